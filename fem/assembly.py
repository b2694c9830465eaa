"""The global stiffness matrix and the consistent mass matrix, upper triangles only.

Inertia acts on each displacement component alone, so the mass matrix is one of nodes times the identity
of three axes.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.elements import PAIRS, element_masses, element_stiffnesses
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
    count = len(points)
    # Blocks of 3 x 3 for pairs of nodes: nine times fewer than entries to be sorted.
    blocks = np.empty((len(elements), PAIRS.shape[1], 3, 3))
    for batch, stiffness in element_stiffnesses(points, elements, material):
        blocks[batch] = stiffness
    rows, columns = np.sort(elements, axis=1)[:, PAIRS].transpose(1, 0, 2)
    keys = (rows * count + columns).ravel()
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    limits = np.append(starts, len(keys))
    gather = sparse.csr_array((np.ones(len(keys)), order, limits), shape=(len(starts), len(keys)))
    sums = gather @ blocks.reshape(-1, 9)
    rows, columns = np.divmod(keys[starts], count)
    limits = np.searchsorted(rows, np.arange(count + 1))
    whole = sparse.bsr_array(
        (sums.reshape(-1, 3, 3), columns.astype(np.int32), limits.astype(np.int32)),
        shape=(3 * count, 3 * count),
    ).tocsr()
    return _upper(whole)


def assemble_mass(
    points: NDArray[np.float64], elements: NDArray[np.int64], density: float
) -> sparse.csr_array:
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
        `assemble_stiffness` [kg].
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


def _upper(matrix: sparse.csr_array) -> sparse.csr_array:
    """Remove the part below the diagonal in the diagonal blocks."""
    lengths = np.diff(matrix.indptr)
    kept = matrix.indices >= np.repeat(np.arange(matrix.shape[0]), lengths)
    limits = np.concatenate([[0], np.cumsum(kept)])[matrix.indptr]
    return sparse.csr_array(
        (matrix.data[kept], matrix.indices[kept], limits.astype(np.int32)), matrix.shape
    )


def symmetric_product(upper: sparse.csr_array, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Multiply a symmetric matrix, given by its upper triangle, with vectors (n,) or (n, k)."""
    diagonal = _diagonal(upper)
    scaled = diagonal * vectors if vectors.ndim == 1 else diagonal[:, None] * vectors
    return np.asarray(upper @ vectors + upper.T @ vectors - scaled)


def _diagonal(upper: sparse.csr_array) -> NDArray[np.float64]:
    """Diagonal of an upper triangle; mostly each row begins with its entry."""
    count, starts = upper.shape[0], upper.indptr[:-1]
    if np.diff(upper.indptr).all() and np.array_equal(upper.indices[starts], np.arange(count)):
        return np.asarray(upper.data[starts])
    return np.asarray(upper.diagonal())
