"""The global stiffness matrix and the consistent mass matrix, upper triangles only.

Inertia acts on each displacement component alone, so the mass matrix is one of nodes times the identity
of three axes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

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


def _cross(left: Array, other: Array, product: Array) -> None:
    """Cross products of vectors along the last axis."""
    for axis in range(3):
        after, last = (axis + 1) % 3, (axis + 2) % 3
        product[..., axis] = (
            left[..., after] * other[..., last] - left[..., last] * other[..., after]
        )


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


AXES = 3


@dataclass(frozen=True, eq=False)
class BlockMatrix:
    """The upper triangle of a symmetric matrix by blocks of 3 x 3, those on the diagonal whole.

    Attributes
    ----------
    shape : tuple of two int
        Rows and columns of blocks.
    indptr, indices : (n + 1,) and (b,) arrays
        Rows and columns of the blocks, as in compressed sparse rows.
    data : (9 b,) array
        Entries block by block, column by column.
    """

    shape: tuple[int, int]
    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    data: NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class NodeBlocks:
    """Where the entries of a pattern stand in its blocks.

    Attributes
    ----------
    indptr, indices : arrays
        As in `BlockMatrix`.
    places : (9 b,) array
        Where each entry of the blocks stands among those of the upper triangle.
    """

    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    places: NDArray[np.int64]

    def of(self, upper: sparse.csr_array) -> BlockMatrix:
        """Return a matrix of the pattern, given by its upper triangle, by blocks."""
        count = len(self.indptr) - 1
        return BlockMatrix((count, count), self.indptr, self.indices, upper.data[self.places])


def node_blocks(upper: sparse.csr_array) -> NodeBlocks | None:
    """Find the blocks of three axes of an upper triangle.

    Parameters
    ----------
    upper : (m, m) sparse array
        Its columns in ascending order in each row.

    Returns
    -------
    NodeBlocks or None
        None if the pattern is not one of full blocks.
    """
    limits, columns = upper.indptr.astype(np.int64), upper.indices
    if upper.shape[0] % AXES or not columns.size:
        return None
    starts = limits[:-1].reshape(-1, AXES)
    lengths = np.diff(limits).reshape(-1, AXES)
    count = lengths[:, 0] // AXES
    # Below the diagonal, the second row of a node has one entry less than the first, the third two.
    if np.any(lengths != AXES * count[:, None] - np.arange(AXES)) or np.any(count == 0):
        return None
    rows = np.repeat(np.arange(len(count)), count)
    first = np.cumsum(count) - count
    within = AXES * (np.arange(len(rows)) - first[rows])
    # places[b, j, i]: entry of row i and column j, so that columns follow each other.
    row, column = np.arange(AXES), np.arange(AXES)[:, None]
    places = starts[rows][:, None, :] + within[:, None, None] + (column - row)
    below = column < row  # of blocks on the diagonal: the same as above it
    places[first] = np.where(below, places[first].transpose(0, 2, 1), places[first])
    nodes = columns[places[:, 0, 0]] // AXES
    fits = columns[places] == AXES * nodes[:, None, None] + column
    fits[first] |= below
    if not fits.all() or not np.array_equal(nodes[first], np.arange(len(count))):
        return None
    return NodeBlocks(
        np.append(first, len(rows)).astype(np.int32), nodes.astype(np.int32), places.ravel()
    )


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
