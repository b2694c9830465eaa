"""Sobol indices and Shapley effects over a part of the box, against closed forms.

Tolerance 0.015: the uncertainty of 0.01 that the estimates state, which is a standard deviation of about
0.006 for the worst of those here.
"""

import numpy as np
import pytest

from comparing import close
from regression.fits.sensitivity import constrained_indices, region_sample, sobol_indices
from regression.plans.factors import Factor

UNIT = [Factor(name, "m", 0.0, 1.0) for name in "abc"]
KIND = Factor.of_labels("kind", ("x", "y", "z"))


def triangle(x):
    return x[:, 0] + x[:, 1] <= 1.0


@pytest.fixture(scope="module")
def over_triangle():
    """A triangle, where two factors have the variance 1/18 and the covariance -1/36, and a free factor."""
    return region_sample(UNIT, triangle)


@pytest.mark.parametrize("slopes", [(1.0, 1.0, 0.5), (3.0, -1.0, 0.0), (2.0, 1.0, 1.0)])
def test_a_plane_over_a_triangle(over_triangle, slopes):
    """E(b | a) = (1 - a) / 2 and E Var(b | a) = 1/24 give every index."""
    a, b, c = slopes
    found = constrained_indices(lambda x: x @ np.array(slopes), over_triangle)
    variance = (a * a + b * b - a * b) / 18 + c * c / 12
    free = c * c / 12
    first = [(a - b / 2) ** 2 / 18, (b - a / 2) ** 2 / 18, free]
    total = [a * a / 24, b * b / 24, free]
    both = (a * a + b * b - a * b) / 18
    shapley = [(total[0] + both - total[1]) / 2, (total[1] + both - total[0]) / 2, free]
    for given, expected in ((found.first, first), (found.total, total), (found.shapley, shapley)):
        assert given == close([value / variance for value in expected], abs=0.015)
    assert sum(found.shapley) == close(1.0)


def test_a_region_that_is_the_box_has_the_usual_indices():
    factors = [*UNIT[:2], KIND]

    def product(x):
        return (1 + x[:, 0]) * (2 + x[:, 1]) * (1 + x[:, 2])

    usual = sobol_indices(product, factors)
    sample = region_sample(factors, lambda x: np.ones(len(x), dtype=bool))
    found = constrained_indices(product, sample)
    assert found.first == close(usual.first, abs=0.025)
    assert found.total == close(usual.total, abs=0.025)
    for low, share, high in zip(usual.first, found.shapley, usual.total, strict=True):
        assert low - 0.015 < share < high + 0.015


def test_a_thin_region_that_leaves_one_freedom():
    """Where a and b are nearly the same, each tells all alone, nothing is left without it, and they share."""
    sample = region_sample(UNIT[:2], lambda x: np.abs(x[:, 0] - x[:, 1]) < 0.01)
    found = constrained_indices(lambda x: x[:, 0] + x[:, 1], sample)
    assert found.first == close([1.0, 1.0], abs=0.01)
    assert found.total == close([0.0, 0.0], abs=0.01)
    assert found.shapley == close([0.5, 0.5], abs=0.015)


def test_what_does_not_vary_and_what_is_not_found(over_triangle):
    assert constrained_indices(lambda x: np.full(len(x), 3e-9), over_triangle) is None
    assert region_sample(UNIT, lambda x: np.zeros(len(x), dtype=bool), count=64) is None
