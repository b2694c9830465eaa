"""Meshes that are fine at a throw's fillets, or where their stresses are high."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from geometry.mesh import ThrowMesh
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
