"""Positions of the fillets of a throw, and of corners without any."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from geometry.mesh import ThrowMesh
from geometry.parts import Cylinder, ThrowParts, WebPlate
from geometry.sizes import SizeMap, element_sizes, sizes_at_corners

Array = NDArray[np.float64]

# Elements grow by this much per unit of distance from where they are small.
GROWTH = 0.5


def fillet_element(radius: float, fineness: float) -> float:
    """Element size for a number of elements across the quarter circle of a fillet of a radius [m]."""
    return 0.5 * math.pi * radius / fineness


def measured_sizes(mesh: ThrowMesh) -> SizeMap:
    """Sizes of a mesh's elements: at each corner node the mean of the adjacent ones."""
    corners = mesh.elements[:, :4]
    return sizes_at_corners(mesh.points, corners, element_sizes(mesh.points, corners))


def refine_at(sizes: SizeMap, places: Sequence[tuple[Array, float]]) -> SizeMap:
    """Refine sizes at some points and let them grow from there.

    Parameters
    ----------
    sizes : SizeMap
    places : sequence of ((p, 3) array, float)
        Points [m], and the size of elements there [m].
    """
    wished = sizes.sizes
    for points, size in places:
        if len(points):
            distance, _ = KDTree(points).query(sizes.points)
            wished = np.minimum(wished, size + GROWTH * distance)
    return SizeMap(sizes.points, sizes.tetrahedra, wished)


# Nodes lie on a fillet's torus to this share of the journal's radius.
PLACE_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Fillet:
    """A fillet between a main journal or pin and a web.

    Attributes
    ----------
    name : str
        For example "left main journal", "pin, left web".
    journal : Cylinder
        The main journal or pin.
    web : WebPlate
    radius : float
        [m]
    start, end : float
        Extent along z [m].
    """

    name: str
    journal: Cylinder
    web: WebPlate
    radius: float
    start: float
    end: float

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Which points (n, 3) of the throw's fillets are on this one."""
        tolerance = PLACE_TOLERANCE * self.journal.radius
        reach = np.linalg.norm(points[:, :2] - self.journal.axis, axis=1)
        low, high = self.journal.radius - tolerance, self.journal.radius + self.radius + tolerance
        z = points[:, 2]
        along = (z > self.start - tolerance) & (z < self.end + tolerance)
        return np.asarray((reach > low) & (reach < high) & along)


def throw_fillets(parts: ThrowParts) -> tuple[Fillet, ...]:
    """Fillets of a throw from its left end to its right."""
    found = []
    for journal, web, radius, at_start in _roots(parts):
        if radius > 0.0:
            start = journal.start if at_start else journal.end - radius
            found.append(
                Fillet(_root_name(journal, web), journal, web, radius, start, start + radius)
            )
    return tuple(found)


def sharp_corners(parts: ThrowParts) -> tuple[str, ...]:
    """Names of the re-entrant corners at main journals and pins that have no fillet."""
    found = []
    for number, web in enumerate(parts.webs):
        before, after = parts.cylinders[number : number + 2]
        if web.end == web.start:
            found.append(f"{before.name} and {after.name} where they meet")
    for journal, web, radius, _ in _roots(parts):
        if radius == 0.0 and web.end > web.start:
            found.append(_root_name(journal, web))
    return tuple(found)


def _root_name(journal: Cylinder, web: WebPlate) -> str:
    return f"{journal.name}, {web.name}" if journal.is_pin else journal.name


def _roots(parts: ThrowParts) -> list[tuple[Cylinder, WebPlate, float, bool]]:
    """Journal, web, fillet radius and whether it is the journal's start, of each journal's root."""
    found = []
    for number, web in enumerate(parts.webs):
        before, after = parts.cylinders[number : number + 2]
        found.append((before, web, before.end_fillet, False))
        found.append((after, web, after.start_fillet, True))
    return found
