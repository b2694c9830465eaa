"""Matrices by blocks of nodes."""

import numpy as np
import pytest
from scipy import sparse

from fem.assembly import node_blocks


def test_blocks_hold_the_whole_matrix(stiffness):
    blocks = node_blocks(stiffness)
    assert blocks is not None
    found = blocks.of(stiffness)
    by_columns = found.data.reshape(-1, 3, 3).transpose(0, 2, 1)
    whole = sparse.bsr_array(
        (by_columns, found.indices, found.indptr), shape=stiffness.shape
    ).tocsr()
    assert (sparse.triu(whole) != stiffness).nnz == 0
    diagonal = by_columns[found.indptr[:-1]]
    assert np.array_equal(diagonal, diagonal.transpose(0, 2, 1))


def holed() -> np.ndarray:
    upper = np.triu(np.ones((6, 6)))
    upper[0, 4] = 0.0
    return upper


@pytest.mark.parametrize(
    "upper",
    [
        pytest.param(np.triu(np.ones((5, 5))), id="no whole nodes"),
        pytest.param(holed(), id="a block with a hole"),
        pytest.param(np.eye(6), id="no blocks"),
        pytest.param(np.roll(np.triu(np.ones((6, 6))), 3, axis=1), id="no diagonal"),
        pytest.param(np.zeros((3, 3)), id="empty"),
    ],
)
def test_other_patterns_have_none(upper):
    assert node_blocks(sparse.csr_array(upper)) is None
