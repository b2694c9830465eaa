"""The global stiffness matrix, upper triangle only."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.elements import element_stiffnesses
from fem.material import Material


def assemble_stiffness(
    points: NDArray[np.float64], elements: NDArray[np.int64], material: Material
) -> sparse.csr_array:
    """Assemble the upper triangle of the stiffness matrix.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers of 10-node tetrahedra.
    material : Material
        Elastic constants.

    Returns
    -------
    (3 n, 3 n) sparse array
        Unknown 3 a + i is the displacement of node a along axis i; entries below the diagonal are
        left out because the matrix is symmetric [N/m].
    """
    unknowns = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), 30).astype(np.int32)
    first, second = np.triu_indices(30)
    rows = np.empty((len(elements), len(first)), dtype=np.int32)
    columns = np.empty_like(rows)
    values = np.empty(rows.shape)
    for batch, stiffness in element_stiffnesses(points, elements, material):
        values[batch] = stiffness[:, first, second]
    np.minimum(unknowns[:, first], unknowns[:, second], out=rows)
    np.maximum(unknowns[:, first], unknowns[:, second], out=columns)
    size = 3 * len(points)
    matrix = sparse.coo_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))
    return matrix.tocsr()


def symmetric_product(upper: sparse.csr_array, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Multiply a symmetric matrix, given by its upper triangle, with vectors (n,) or (n, k)."""
    diagonal = upper.diagonal()
    scaled = diagonal * vectors if vectors.ndim == 1 else diagonal[:, None] * vectors
    return np.asarray(upper @ vectors + upper.T @ vectors - scaled)
