"""Curved tetrahedra that turned inside out: find them and straighten them."""

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import MeshError
from geometry.shapes import jacobians, shapes_at_nodes

# The two end nodes of each edge node 4..9, in scikit-fem's order.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
# How far edges go towards their straight line, one after the other: at last all the way.
STEPS = (0.5,) * 8 + (1.0,) * 10
# Smallest ratio of the Jacobian at any node of an element to its mean one.
SMALLEST_JACOBIAN = 0.05


def smallest_jacobians(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Smallest ratio (m,) of the Jacobian at any node to the straight element's mean one."""
    _, gradients = shapes_at_nodes()
    determinant = np.linalg.det(jacobians(gradients, points[elements]))
    return np.asarray(determinant.min(axis=1) / np.abs(determinant).mean(axis=1))


def corner_quality(points: NDArray[np.float64], elements: NDArray[np.int64]) -> NDArray[np.float64]:
    """Mean ratio (m,) of the straight tetrahedra: 1 for a regular one, 0 for a flat one."""
    corners = points[elements[:, :4]]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    squares = sum(
        ((corners[:, i] - corners[:, j]) ** 2).sum(axis=1) for i in range(4) for j in range(i)
    )
    return np.asarray(12.0 * (3.0 * volumes) ** (2.0 / 3.0) / squares)


def straighten_elements(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> tuple[NDArray[np.float64], int]:
    """Straighten the edges of elements that curving turned inside out, no more than they need.

    An edge on a fillet that is straightened adds what the fillet takes away, which stiffens the throw; so
    edges go half of their way again and again. Straightening one element changes its neighbors, which are
    checked as well.

    Parameters
    ----------
    points : (n, 3) array
    elements : (m, 10) array

    Returns
    -------
    points : (n, 3) array
    mended : int
        How many elements were straightened.

    Raises
    ------
    MeshError
        If elements stay inside out.
    """
    points = points.copy()
    mended: set[int] = set()
    for step in STEPS:
        bad = np.flatnonzero(smallest_jacobians(points, elements) < SMALLEST_JACOBIAN)
        if len(bad) == 0:
            return points, len(mended)
        mended.update(bad.tolist())
        # An edge of several bad elements goes its way once.
        middles, place = np.unique(elements[bad, 4:], return_index=True)
        ends = elements[bad][:, EDGES].reshape(-1, 2)[place]
        points[middles] += step * (points[ends].mean(axis=1) - points[middles])
    raise MeshError(
        f"{len(bad)} elements of the throw's mesh stay inside out after straightening their edges."
    )
