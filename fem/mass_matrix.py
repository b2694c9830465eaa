"""The global mass matrix, consistent with the shape functions; upper triangle only.

Inertia acts on each displacement component alone, so the matrix is one of nodes times the identity of
three axes.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from geometry.shapes import jacobians, shapes_for_quadrature

# Two quadratic shape functions times the cubic Jacobian determinant of a curved element are of seventh
# order, which scikit-fem's rule "8" integrates exactly; its rules 5 to 9 are exact to one order less
# than their names.
QUADRATURE_ORDER = 8
CHUNK = 4096

Array = NDArray[np.float64]


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
    values, gradients, weights = shapes_for_quadrature(QUADRATURE_ORDER)
    products = (values[:, :, None] * values[:, None, :]).reshape(len(weights), 100)
    weighted = density * weights[:, None] * products
    for start in range(0, len(elements), CHUNK):
        batch = slice(start, min(start + CHUNK, len(elements)))
        determinants = np.linalg.det(jacobians(gradients, points[elements[batch]]))
        yield batch, (determinants @ weighted).reshape(-1, 10, 10)


def assemble_mass(points: Array, elements: NDArray[np.int64], density: float) -> sparse.csr_array:
    """Assemble the upper triangle of the consistent mass matrix.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers of 10-node tetrahedra.
    density : float
        [kg/m^3]

    Returns
    -------
    (3 n, 3 n) sparse array
        Unknown 3 a + i is the displacement of node a along axis i, as in
        `fem.assembly.assemble_stiffness` [kg].
    """
    first, second = np.triu_indices(10)
    values = np.empty((len(elements), len(first)))
    for batch, masses in element_masses(points, elements, density):
        values[batch] = masses[:, first, second]
    rows = np.minimum(elements[:, first], elements[:, second]).ravel().astype(np.int32)
    columns = np.maximum(elements[:, first], elements[:, second]).ravel().astype(np.int32)
    size = len(points)
    nodal = sparse.coo_array((values.ravel(), (rows, columns)), shape=(size, size)).tocsr()
    return sparse.csr_array(sparse.kron(nodal, sparse.eye_array(3), format="csr"))
