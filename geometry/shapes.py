"""The 10-node tetrahedron: shape functions, tabulated once for all who integrate over elements, and facets.

The functions are scikit-fem's; it numbers the edge nodes 01 12 02 03 13 23.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Corners of each facet, counterclockwise from outside.
FACETS = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
MOST_NODES = 2_000_000  # more than any mesh within the budget has; the cube of it fits into 64 bits


def shapes_at(where: Array) -> tuple[Array, Array]:
    """Values (q, 10) and reference gradients (q, 10, 3) of the shape functions at points (3, q)."""
    from skfem import ElementTetP2

    element = ElementTetP2()
    shapes = [element.lbasis(where, node) for node in range(10)]
    values = [value + np.zeros(where.shape[1]) for value, _ in shapes]
    gradients = [slope + np.zeros_like(where) for _, slope in shapes]
    return np.asarray(values).T, np.asarray(gradients).transpose(2, 0, 1)


def shapes_at_nodes() -> tuple[Array, Array]:
    """Values (10, 10) and reference gradients (10, 10, 3) at the corners and edge middles."""
    from skfem import ElementTetP2

    return shapes_at(ElementTetP2.doflocs.T)


def shapes_for_quadrature(order: int) -> tuple[Array, Array, Array]:
    """Values (q, 10), reference gradients (q, 10, 3) and weights (q,) of a quadrature rule."""
    from skfem import MeshTet1
    from skfem.quadrature import get_quadrature

    where, weights = get_quadrature(MeshTet1.elem.refdom, order)
    return *shapes_at(where), np.asarray(weights)


def triangle_shapes_at(where: Array) -> tuple[Array, Array]:
    """Values (q, 6) and reference gradients (6, 2, q) of a six-node triangle's at points (2, q)."""
    from skfem import ElementTriP2

    element = ElementTriP2()
    shapes = [element.lbasis(where, node) for node in range(6)]
    values = np.array([value + np.zeros(where.shape[1]) for value, _ in shapes])
    return values.T, np.array([slope + np.zeros_like(where) for _, slope in shapes])


def jacobians(gradients: Array, corners: Array) -> Array:
    """Jacobians (m, q, 3, 3) of elements with node coordinates (m, 10, 3): d x_j / d xi_i [m]."""
    return np.asarray(gradients.transpose(0, 2, 1)[None] @ corners[:, None])


def element_volumes(points: Array, elements: Integers) -> Array:
    """Volumes (m,) of straight or curved 10-node tetrahedra [m^3]."""
    return np.asarray(
        element_quadrature(points, elements)[1].reshape(len(elements), -1).sum(axis=1)
    )


def element_quadrature(points: Array, elements: Integers, order: int = 5) -> tuple[Array, Array]:
    """Quadrature points (p, 3) and their volumes (p,) over all elements."""
    values, gradients, weights = shapes_for_quadrature(order)
    corners = points[elements]
    volumes = np.linalg.det(jacobians(gradients, corners)) * weights
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
