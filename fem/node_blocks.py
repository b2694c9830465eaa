"""Symmetric matrices stored by nodes: blocks of three axes, as every element couples them.

With this information a solver orders the elimination by nodes, with nine times fewer couplings than
entries.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

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
