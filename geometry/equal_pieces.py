"""Equal throws of a crankshaft, and the symmetry of one, told by its faces under turns and mirrors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

Array = NDArray[np.float64]
# Faces, and volumes, are the same to this share of the throw's length, of its square, and of the volume.
SAME = 1e-5
# How a throw becomes another one: the signs of x and z in its frame. Turning end for end changes both.
EQUAL, MIRRORED, REVERSED, BOTH = "equal", "mirrored", "reversed", "mirrored and reversed"
CHANGES = {EQUAL: (1.0, 1.0), REVERSED: (-1.0, -1.0), MIRRORED: (-1.0, 1.0), BOTH: (1.0, -1.0)}


@dataclass(frozen=True)
class Signature:
    """A throw's faces without those of its end sections.

    Attributes
    ----------
    volume, low, high : float
        Of the throw, and its reach along z.
    areas, centers : arrays (n,), (n, 3)
        Of its faces.
    angles : tuple of float
        Of its pins, about +z from +y [rad].
    """

    volume: float
    low: float
    high: float
    areas: Array
    centers: Array
    angles: tuple[float, ...]

    def change_to(self, other: "Signature", ways: Sequence[str] = tuple(CHANGES)) -> str | None:
        """Return the first of the ways in which it becomes another throw, or None."""
        length = self.high - self.low
        alike = (
            abs(self.volume / other.volume - 1.0) < SAME
            and abs((other.high - other.low) / length - 1.0) < SAME
            and len(self.areas) == len(other.areas)
        )
        if not alike:
            return None
        there = KDTree(np.column_stack([other.local / length, other.areas / length**2]))
        for way in ways:
            across, along = CHANGES[way]
            back = _turned(-self.angles[0 if along > 0.0 else -1])
            change = _turned(other.angles[0]) @ np.diag([across, 1.0, along]) @ back
            here = np.column_stack([self.local @ change.T / length, self.areas / length**2])
            apart, places = there.query(here)
            if len(set(places.tolist())) == len(here) and apart.max() < SAME:
                return way
        return None

    @property
    def local(self) -> Array:
        """Centers of the faces, z from the throw's middle."""
        return self.centers - np.array([0.0, 0.0, 0.5 * (self.low + self.high)])

    @property
    def symmetry(self) -> str:
        """The part of the throw that is enough: quarter, half or full."""
        if self.change_to(self, (MIRRORED,)) is None:
            return "full"
        return "half" if self.change_to(self, (BOTH,)) is None else "quarter"


def _turned(angle: float) -> Array:
    """The rotation by an angle about z."""
    sine, cosine = np.sin(angle), np.cos(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def signature(gmsh: Any, solid: int, low: float, high: float, angles: Sequence[float]) -> Signature:
    """Measure a solid between two end planes; parameters as the attributes of `Signature`."""
    occ = gmsh.model.occ
    areas, centers = [], []
    for _, tag in gmsh.model.getBoundary([(3, solid)], combined=False, oriented=False):
        center = occ.getCenterOfMass(2, tag)
        end = min(abs(center[2] - low), abs(center[2] - high)) < SAME * (high - low)
        if not (end and gmsh.model.getType(2, tag) == "Plane"):
            areas.append(occ.getMass(2, tag))
            centers.append(center)
    volume = float(occ.getMass(3, solid))
    return Signature(volume, low, high, np.array(areas), np.array(centers), tuple(angles))
