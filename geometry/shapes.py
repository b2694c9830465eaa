"""The 10-node tetrahedron: shape functions, tabulated once for all who integrate over elements, and facets.

The functions and the rules of quadrature of an analysis are scikit-fem's, written out, because it takes as
long to load as a mesh to make; further rules are its own.
"""

import math
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, Integers
from crankbase.errors import MeshError

# The two end nodes of each edge node 4..9, in scikit-fem's order, and of a triangle's 3..5.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
TRIANGLE_EDGES = ((0, 1), (1, 2), (0, 2))
_FIVE, _FIFTEEN, _SHARE = math.sqrt(5), math.sqrt(15), math.sqrt(5 / 14)
# Rules of quadrature by dimension and order: weights, relative to the whole, and barycentric coordinates of
# points, which stand for all their permutations (tetrahedron: P. Keast, Moderate-degree tetrahedral
# quadrature formulas, Comput. Methods Appl. Mech. Eng. 55, 1986; triangle, order 5: J. Radon, Zur
# mechanischen Kubatur, Monatsh. Math. 52, 1948).
RULES: dict[tuple[int, int], list[tuple[float, tuple[float, ...]]]] = {
    (2, 2): [(1 / 3, (2 / 3, 1 / 6, 1 / 6))],
    (2, 5): [
        (9 / 40, (1 / 3, 1 / 3, 1 / 3)),
        *(
            ((155 + root) / 1200, ((9 - 2 * root) / 21, (6 + root) / 21, (6 + root) / 21))
            for root in (_FIFTEEN, -_FIFTEEN)
        ),
    ],
    (3, 2): [(1 / 4, ((5 + 3 * _FIVE) / 20, *[(5 - _FIVE) / 20] * 3))],
    (3, 3): [(-4 / 5, (1 / 4,) * 4), (9 / 20, (1 / 2, 1 / 6, 1 / 6, 1 / 6))],
    (3, 4): [
        (-148 / 1875, (1 / 4,) * 4),
        (343 / 7500, (11 / 14, 1 / 14, 1 / 14, 1 / 14)),
        (56 / 375, (*[(1 + _SHARE) / 4] * 2, *[(1 - _SHARE) / 4] * 2)),
    ],
}
# Corners of each facet, counterclockwise from outside.
FACETS = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
MOST_NODES = 2_000_000  # more than any mesh within the budget has; the cube of it fits into 64 bits


def shapes_at(where: Array) -> tuple[Array, Array]:
    """Values (q, 10) and reference gradients (q, 10, 3) of the shape functions at points (3, q)."""
    return _quadratic_shapes(where, EDGES)


def shapes_at_nodes() -> tuple[Array, Array]:
    """Values (10, 10) and reference gradients (10, 10, 3) at the corners and edge middles."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    return shapes_at(np.vstack([corners, [0.5 * (corners[a] + corners[b]) for a, b in EDGES]]).T)


def _quadratic_shapes(where: Array, edges: tuple[tuple[int, int], ...]) -> tuple[Array, Array]:
    """Values (q, n) and reference gradients (q, n, d) of a quadratic simplex at points (d, q)."""
    shares = np.vstack([1.0 - where.sum(axis=0), where])  # barycentric coordinates
    slopes = np.vstack([np.full(len(where), -1.0), np.eye(len(where))])
    first, second = np.array(edges).T
    values = np.vstack([shares * (2.0 * shares - 1.0), 4.0 * shares[first] * shares[second]])
    gradients = np.concatenate(
        [
            (4.0 * shares - 1.0)[:, :, None] * slopes[:, None],
            4.0 * shares[first][:, :, None] * slopes[second][:, None]
            + 4.0 * shares[second][:, :, None] * slopes[first][:, None],
        ]
    )
    return values.T, np.asarray(gradients.transpose(1, 0, 2))


def shapes_for_quadrature(order: int) -> tuple[Array, Array, Array]:
    """Values (q, 10), reference gradients (q, 10, 3) and weights (q,) of a quadrature rule."""
    where, weights = quadrature(3, order)
    return *shapes_at(where), weights


def quadrature(dimension: int, order: int) -> tuple[Array, Array]:
    """Points (d, q) and weights (q,) of scikit-fem's rule of an order, on the triangle or tetrahedron."""
    if (dimension, order) not in RULES:
        from skfem import MeshTet1, MeshTri1
        from skfem.quadrature import get_quadrature

        where, weights = get_quadrature({2: MeshTri1, 3: MeshTet1}[dimension].elem.refdom, order)
        return np.asarray(where), np.asarray(weights)
    points = [
        (weight / math.factorial(dimension), *place[1:])
        for weight, places in RULES[dimension, order]
        for place in sorted(set(permutations(places)))
    ]
    weights, *where = np.array(points).T
    return np.array(where), weights


def triangle_shapes_at(where: Array) -> tuple[Array, Array]:
    """Values (q, 6) and reference gradients (6, 2, q) of a six-node triangle's at points (2, q)."""
    values, gradients = _quadratic_shapes(where, TRIANGLE_EDGES)
    return values, np.asarray(gradients.transpose(1, 2, 0))


def jacobians(gradients: Array, corners: Array) -> Array:
    """Jacobians (m, q, 3, 3) of elements with node coordinates (m, 10, 3): d x_j / d xi_i [m]."""
    return np.asarray(gradients.transpose(0, 2, 1)[None] @ corners[:, None])


def determinants(gradients: Array, corners: Array) -> Array:
    """Determinants (m, q) of the Jacobians of elements with node coordinates (m, 10, 3) [m^3]."""
    across = np.ascontiguousarray(corners.transpose(1, 2, 0))
    # Not by BLAS, whose threads would wait for each other most of the time.
    (a, b, c), (d, e, f), (g, h, i) = np.einsum("qni,njm->ijqm", gradients, across)
    return np.asarray(a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)).T


def element_volumes(points: Array, elements: Integers) -> Array:
    """Volumes (m,) of straight or curved 10-node tetrahedra [m^3]; the determinant is a cubic."""
    _, gradients, weights = shapes_for_quadrature(3)
    return np.asarray(determinants(gradients, points[elements]) @ weights)


def element_quadrature(points: Array, elements: Integers, order: int = 5) -> tuple[Array, Array]:
    """Quadrature points (p, 3) and their volumes (p,) over all elements."""
    values, gradients, weights = shapes_for_quadrature(order)
    corners = points[elements]
    volumes = determinants(gradients, corners) * weights
    return (values[None] @ corners).reshape(-1, 3), volumes.ravel()


def facet_keys(facets: Integers) -> Integers:
    """Numbers (k,) that facets (k, 3) share with those of the same corners alone."""
    low, middle, high = np.sort(facets, axis=1).T
    return np.asarray((low * MOST_NODES + middle) * MOST_NODES + high)


def outer_facets(tetrahedra: Integers) -> tuple[Integers, Integers]:
    """Facets (k, 3) that bound one tetrahedron only, after their keys, which are sorted."""
    facets = tetrahedra[:, FACETS].reshape(-1, 3)
    keys, first, count = np.unique(facet_keys(facets), return_index=True, return_counts=True)
    return keys[count == 1], facets[first[count == 1]]


MOST_HALVINGS = 40


def smallest_jacobians(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Smallest ratio (m,) of the Jacobian at any node to the straight element's mean one."""
    _, gradients = shapes_at_nodes()
    determinant = determinants(gradients, points[elements])
    return np.asarray(determinant.min(axis=1) / np.abs(determinant).mean(axis=1))


def corner_quality(points: NDArray[np.float64], elements: NDArray[np.int64]) -> NDArray[np.float64]:
    """Mean ratio (m,) of the straight tetrahedra: 1 for a regular one, 0 for a flat one, less inside out."""
    corners = points[elements[:, :4]]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    squares = sum(
        ((corners[:, i] - corners[:, j]) ** 2).sum(axis=1) for i in range(4) for j in range(i)
    )
    return np.asarray(12.0 * np.cbrt(3.0 * volumes) * np.cbrt(3.0 * np.abs(volumes)) / squares)


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
