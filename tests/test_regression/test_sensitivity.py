"""Sensitivities of functions whose elasticities and Sobol indices are known in closed form.

Tolerances of Sobol indices: 0.01, the uncertainty of the estimates from 4096 points that their
docstring states.
"""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from regression.fits.forms import FittedForm
from regression.fits.sensitivity import elasticities, nominal_values, sobol_indices
from regression.plans.factors import Factor

A, B = Factor("a", "m", 1.0, 2.0), Factor("b", "m", 1.0, 3.0)
KIND = Factor.of_labels("kind", ("x", "y", "z"))


def test_elasticities_of_a_power_law_are_its_exponents():
    def law(x):
        return 1e-9 * x[:, 0] ** -2.5 * x[:, 1] ** 0.75 * (1 + x[:, 2])

    found = elasticities(law, (A, B, KIND), (1.5, 2.0, 1.0))
    # The difference quotient's error is about 1e-4 squared.
    assert found == close([-2.5, 0.75], rel=1e-6)


def test_elasticities_of_a_fitted_form_are_its_derivatives():
    # d ln y / d ln a = (d y / d a) a / y, with y = 1 + 0.5 z^2 + 0.2 z w, z = 2 a - 3, w = b - 2.
    terms, coefficients = ((), (0, 0), (0, 1)), (1.0, 0.5, 0.2)
    form = FittedForm(
        "quadratic", ("a", "b"), False, (False, False), (1.5, 2.0), (0.5, 1.0), terms, coefficients
    )
    a, b = 1.8, 2.4
    z, w = 2 * a - 3, b - 2
    y = 1 + 0.5 * z**2 + 0.2 * z * w
    expected = [(z + 0.2 * w) * 2 * a / y, 0.2 * z * b / y]
    assert elasticities(form.predict, (A, B), (a, b)) == close(expected, rel=1e-6)


def test_elasticities_of_a_negative_response():
    """Differences are of y, not of its logarithm: a reaction may be negative."""
    found = elasticities(lambda x: -1e-9 * x[:, 0] ** 3 / x[:, 1], (A, B), (1.5, 2.0))
    assert found == close([3.0, -1.0], rel=1e-6)


def test_elasticity_at_nothing():
    def through_zero(x):
        return 3.0 + x[:, 0]

    zero = Factor("a", "m", 0.0, 1.0)
    assert elasticities(through_zero, (zero,), (0.0,)) == [0.0]
    with pytest.raises(InputError, match="nominal: given factors at which the response is 0"):
        elasticities(lambda x: x[:, 0], (zero,), (0.0,))


def test_sobol_indices_of_ishigami():
    """Ishigami and Homma 1990, a = 7, b = 0.1: the usual test, with its closed-form variances."""

    def ishigami(x):
        return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    pi = math.pi
    v1 = 0.5 * (1 + 0.1 * pi**4 / 5) ** 2
    v2 = 7**2 / 8
    v13 = 0.1**2 * pi**8 * (1 / 18 - 1 / 50)
    total = v1 + v2 + v13
    found = sobol_indices(ishigami, [Factor(name, "m", -pi, pi) for name in "abc"])
    assert found.names == ("a", "b", "c")
    assert found.first == close([v1 / total, v2 / total, 0.0], abs=0.01)
    assert found.total == close([(v1 + v13) / total, v2 / total, v13 / total], abs=0.01)


def test_sobol_indices_of_a_product_with_a_category():
    """Of a product, first index i is (v_i / m_i^2) / (prod (1 + v / m^2) - 1)."""

    def product(x):
        return 1e-9 * x[:, 0] * x[:, 1] * (1 + x[:, 2])

    # Variance over squared mean: of a uniform a ... b (b - a)^2 / 12, of 1, 2, 3 two thirds.
    ratios = np.array([1 / 12 / 1.5**2, 4 / 12 / 2**2, 2 / 3 / 2**2])
    whole = np.prod(1 + ratios) - 1
    found = sobol_indices(product, (A, B, KIND))
    assert found.first == close(ratios / whole, abs=0.01)
    total = [ratios[i] * np.prod(np.delete(1 + ratios, i)) / whole for i in range(3)]
    assert found.total == close(total, abs=0.01)
    assert sum(found.first) <= 1.0


def test_what_does_not_vary_has_no_indices():
    assert sobol_indices(lambda x: np.full(len(x), 2e-9), (A, B)) is None


def test_nominal_values():
    factors = (A, B, KIND)
    assert nominal_values(factors, (1.2, 5.0, 2.0)) == [1.2, 2.0, 2.0]
    assert nominal_values(factors, (None, 1.0, None)) == [1.5, 1.0, 0.0]


def test_one_factor_has_all_of_the_variance():
    found = sobol_indices(lambda x: x[:, 0] ** 2, [Factor("a", "m", 1.0, 2.0)])
    assert (found.first, found.total) == ((1.0,), (1.0,))
    assert sobol_indices(lambda x: 0.0 * x[:, 0] + 3.0, [Factor("a", "m", 1.0, 2.0)]) is None
