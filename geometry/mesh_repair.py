"""Find inverted curved tetrahedra and straighten them."""

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import MeshError
from geometry.shapes import EDGES as EDGES
from geometry.shapes import determinants, shapes_at_nodes

MOST_HALVINGS = 40


def smallest_jacobians(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Smallest ratio (m,) of the Jacobian at any node to the straight element's mean one."""
    _, gradients = shapes_at_nodes()
    determinant = determinants(gradients, points[elements])
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
    """Straighten edges of inverted elements: half of the largest curvature at a time.

    Straightening one element changes its neighbors, so the check is repeated; no edge is straightened
    more than necessary, since it leaves the solid's surface.

    Parameters
    ----------
    points : (n, 3) array
    elements : (m, 10) array

    Returns
    -------
    points : (n, 3) array
    mended : int
        Number of elements straightened.

    Raises
    ------
    MeshError
        If elements stay inverted.
    """
    mended: set[int] = set()
    points = points.copy()
    first, second = np.array(EDGES).T
    for _ in range(MOST_HALVINGS):
        bad = np.flatnonzero(smallest_jacobians(points, elements) < 0.05)
        if len(bad) == 0:
            return points, len(mended)
        mended.update(bad.tolist())
        start, end = points[elements[bad][:, first]], points[elements[bad][:, second]]
        bow = points[elements[bad, 4:]] - 0.5 * (start + end)
        shares = np.linalg.norm(bow, axis=2) / np.linalg.norm(end - start, axis=2)
        worst = np.arange(len(bad)), shares.argmax(axis=1)
        points[elements[bad, 4 + worst[1]]] -= 0.5 * bow[worst]
    raise MeshError(
        f"{len(bad)} elements of the throw's mesh stay inside out after straightening their edges."
    )
