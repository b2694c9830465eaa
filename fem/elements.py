"""Stiffness and mass of curved 10-node tetrahedra as batched matrix products.

Shape functions and quadrature are scikit-fem's. Its general forms give the same matrices and are
the reference in tests; batched products of the gradients are several times faster.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fem.material import Material
from geometry.shapes import jacobians, shapes_for_quadrature

# Four points integrate the stiffness of a straight element exactly; on curved ones the error is far
# below that of the mesh.
QUADRATURE_ORDER = 2
# Two quadratic shape functions times the cubic Jacobian determinant of a curved element are of seventh
# order, which scikit-fem's rule "8" integrates exactly; its rules 5 to 9 are exact to one order less
# than their names.
MASS_QUADRATURE_ORDER = 8
CHUNK = 4096
# Pairs (2, 55) of an element's nodes, each once, nodes with themselves included.
PAIRS = np.array(np.triu_indices(10))
# Where their 3 x 3 entries, row by row and column by column, stand in a 30 x 30 matrix of all nodes.
_BLOCKS = 90 * PAIRS[0][:, None, None] + 3 * PAIRS[1][:, None, None]
_ENTRIES = (_BLOCKS + np.arange(0, 90, 30)[:, None] + np.arange(3)).ravel()
_TRANSPOSED = (_BLOCKS + np.arange(3)[:, None] + np.arange(0, 90, 30)).ravel()

Array = NDArray[np.float64]


def physical_gradients(corners: Array, gradients: Array, weights: Array) -> tuple[Array, Array]:
    """Gradients in space and integration weights of a batch of elements.

    Parameters
    ----------
    corners : (m, 10, 3) array
        Node coordinates of the elements [m].
    gradients : (q, 10, 3) array
        Reference gradients of the shape functions.
    weights : (q,) array
        Quadrature weights.

    Returns
    -------
    gradients : (m, q, 10, 3) array
        Derivatives of each shape function by x, y, z [1/m].
    volumes : (m, q) array
        Weight times Jacobian determinant [m^3].
    """
    jacobian = jacobians(gradients, corners)
    # The inverse by cofactors: several times faster than a general one for so many small matrices.
    first, second, third = jacobian[:, :, 0], jacobian[:, :, 1], jacobian[:, :, 2]
    adjugate = np.empty_like(jacobian)
    _cross(second, third, adjugate[:, :, 0])
    _cross(third, first, adjugate[:, :, 1])
    _cross(first, second, adjugate[:, :, 2])
    determinant = np.einsum("mqi,mqi->mq", first, adjugate[:, :, 0])
    adjugate /= determinant[:, :, None, None]
    return gradients[None] @ adjugate, determinant * weights


def _cross(one: Array, other: Array, product: Array) -> None:
    """Cross products of vectors along the last axis."""
    for axis in range(3):
        after, last = (axis + 1) % 3, (axis + 2) % 3
        product[..., axis] = one[..., after] * other[..., last] - one[..., last] * other[..., after]


def element_stiffnesses(
    points: Array, elements: NDArray[np.int64], material: Material
) -> Iterator[tuple[slice, Array]]:
    """Yield the stiffness of elements between each two of their nodes, in batches.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers.
    material : Material
        Elastic constants.

    Yields
    ------
    batch : slice
        Which elements.
    stiffness : (b, 55, 3, 3) array
        Forces along three axes (rows) on the first node of each pair of `PAIRS` for displacements
        (columns) of the second. The nodes of an element are taken by ascending numbers [N/m].
    """
    lame, shear = material.lame_constant, material.shear_modulus
    _, gradients, weights = shapes_for_quadrature(QUADRATURE_ORDER)
    order = np.argsort(elements, axis=1)
    for batch in _batches(elements):
        spatial, volumes = physical_gradients(points[elements[batch]], gradients, weights)
        scaled = spatial * np.sqrt(volumes)[:, :, None, None]
        scaled = np.take_along_axis(scaled, order[batch, None, :, None], axis=2)
        scaled = scaled.reshape(*volumes.shape, 30)
        # products[a, i, b, j] = integral of d_i phi_a d_j phi_b
        products = (scaled.transpose(0, 2, 1) @ scaled).reshape(len(volumes), 900)
        stiffness = lame * products.take(_ENTRIES, axis=1)
        stiffness += shear * products.take(_TRANSPOSED, axis=1)
        # What both have on the diagonal is the integral of grad phi_a grad phi_b.
        laplacian = shear * sum(products.take(_ENTRIES[axis::9], axis=1) for axis in (0, 4, 8))
        for axis in (0, 4, 8):
            stiffness[:, axis::9] += laplacian
        yield batch, stiffness.reshape(len(volumes), -1, 3, 3)


def element_masses(
    points: Array, elements: NDArray[np.int64], density: float
) -> Iterator[tuple[slice, Array]]:
    """Yield mass matrices of curved 10-node tetrahedra in batches.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers.
    density : float
        [kg/m^3]

    Yields
    ------
    batch : slice
        Which elements.
    masses : (b, 10, 10) array
        Integral of density times the shape functions of two nodes, the same along each axis [kg].
    """
    values, gradients, weights = shapes_for_quadrature(MASS_QUADRATURE_ORDER)
    products = (values[:, :, None] * values[:, None, :]).reshape(len(weights), 100)
    weighted = density * weights[:, None] * products
    for batch in _batches(elements):
        determinants = np.linalg.det(jacobians(gradients, points[elements[batch]]))
        yield batch, (determinants @ weighted).reshape(-1, 10, 10)


def _batches(elements: NDArray[np.int64]) -> Iterator[slice]:
    for start in range(0, len(elements), CHUNK):
        yield slice(start, min(start + CHUNK, len(elements)))
