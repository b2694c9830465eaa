"""Shape functions of the 10-node tetrahedron, tabulated once for all who integrate over elements.

The functions are scikit-fem's; it numbers the edge nodes 01 12 02 03 13 23.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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


def jacobians(gradients: Array, corners: Array) -> Array:
    """Jacobians (m, q, 3, 3) of elements with node coordinates (m, 10, 3): d x_j / d xi_i [m]."""
    return np.asarray(gradients.transpose(0, 2, 1)[None] @ corners[:, None])


def element_volumes(
    points: NDArray[np.float64], elements: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Volumes (m,) of straight or curved 10-node tetrahedra [m^3]."""
    return np.asarray(
        element_quadrature(points, elements)[1].reshape(len(elements), -1).sum(axis=1)
    )


def element_quadrature(
    points: NDArray[np.float64], elements: NDArray[np.int64], order: int = 5
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Quadrature points (p, 3) and their volumes (p,) over all elements."""
    values, gradients, weights = shapes_for_quadrature(order)
    corners = points[elements]
    volumes = np.linalg.det(jacobians(gradients, corners)) * weights
    return (values[None] @ corners).reshape(-1, 3), volumes.ravel()
