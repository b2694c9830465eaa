"""Points of designs, held against those of scipy."""

import copy

import numpy as np
import pytest
from scipy.stats import qmc

from crankbase.even_points import centered_discrepancy, latin_hypercube, sobol_sequence


@pytest.mark.parametrize("columns", [1, 2, 3, 8, 30])
@pytest.mark.parametrize("count", [1, 2, 3, 33, 64, 501])
def test_points_are_those_of_scipy_to_the_last_bit(count, columns):
    for seed in ([1], [7, 2], [2024, 0, 5]):
        sampler = qmc.LatinHypercube(columns, rng=np.random.default_rng(seed))
        random = np.random.default_rng(seed).spawn(1)[0]
        for _ in range(3):  # one after the other from the same generator
            drawn, theirs = latin_hypercube(count, columns, random), sampler.random(count)
            assert np.array_equal(drawn, theirs)
            assert drawn.flags.c_contiguous == theirs.flags.c_contiguous


def test_a_large_design_is_that_of_scipy_too():
    theirs = qmc.LatinHypercube(4, rng=np.random.default_rng(3)).random(100_000)
    drawn = latin_hypercube(100_000, 4, np.random.default_rng(3).spawn(1)[0])
    assert np.array_equal(drawn, theirs)


@pytest.mark.parametrize("columns", [1, 2, 3, 8, 30])
@pytest.mark.parametrize("count", [1, 2, 33, 64, 1501])
def test_discrepancy_is_that_of_scipy_to_the_last_bit(count, columns):
    points = np.random.default_rng(1).random((count, columns))
    assert centered_discrepancy(points) == qmc.discrepancy(points)


def test_no_columns_have_no_discrepancy():
    assert abs(centered_discrepancy(np.empty((7, 0)))) < 1e-15


@pytest.mark.parametrize("start", [1, np.random.default_rng([5, 7])], ids=["number", "generator"])
@pytest.mark.parametrize("bits", [30, 64])
@pytest.mark.parametrize("columns", [1, 2, 7, 40, 41])
def test_a_sobol_sequence_is_that_of_scipy_to_the_last_bit(columns, bits, start):
    theirs = qmc.Sobol(columns, rng=copy.deepcopy(start), bits=bits).random(256)
    for count in (1, 2, 3, 100, 256):
        drawn = sobol_sequence(count, columns, copy.deepcopy(start), bits)
        assert np.array_equal(drawn, theirs[:count])
