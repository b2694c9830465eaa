"""Sensitivities and expected errors of equations, against functions known in closed form."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from regression.fits import fits as module
from regression.fits.fits import (
    JudgedEquation,
    expected_errors,
    fit_form,
    lacking_terms,
    worst_places,
)
from regression.fits.forms import FittedForm
from regression.fits.sensitivity import (
    constrained_indices,
    elasticities,
    region_sample,
    sobol_indices,
)
from regression.plans.factors import Factor

A, B = Factor("a", "m", 1.0, 2.0), Factor("b", "m", 1.0, 3.0)
KIND = Factor.of_labels("kind", ("x", "y", "z"))


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


def test_one_factor_has_all_of_the_variance():
    found = sobol_indices(lambda x: x[:, 0] ** 2, [Factor("a", "m", 1.0, 2.0)])
    assert (found.first, found.total) == ((1.0,), (1.0,))
    assert sobol_indices(lambda x: 0.0 * x[:, 0] + 3.0, [Factor("a", "m", 1.0, 2.0)]) is None


UNIT = [Factor(name, "m", 0.0, 1.0) for name in "abc"]


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


RNG = np.random.default_rng(3)
PLACES = RNG.uniform(0.5, 3.0, (6, 2))
RUNS = RNG.uniform(1.0, 2.0, (15, 2))


def response(x):
    return 2.0 + np.sin(2.0 * x[:, 0]) + x[:, 0] * x[:, 1]


def judged(form="quadratic", runs=RUNS, places=PLACES):
    fit = fit_form(form, ("a", "b"), runs, response(runs))
    target = response(runs)
    return JudgedEquation(fit, runs, target, places, np.full(len(places), 2.0))


def test_terms_of_one_degree_more_are_lacking():
    fit = fit_form("linear", ("a", "b=x"), np.array([[1, 0], [2, 1], [3, 0]]), [1, 2, 3])
    assert set(fit.fitted.terms) == {(), (0,), (1,)}
    assert lacking_terms(fit) == ((0, 0), (0, 1))  # a column of 0 and 1 has no square


def columns(equation, x):
    form = equation.fit.fitted
    z = (x - np.array(form.center)) / np.array(form.half_range)

    def powers(terms):
        return np.column_stack([np.prod(z[:, list(term)], axis=1) for term in terms])

    return powers(form.terms), powers(lacking_terms(equation.fit))


def posterior(equation, ratio, variance, runs):
    """Covariance of the response at places, given runs, by a wide prior of the equation's own terms."""
    own, further = columns(equation, np.vstack([equation.places, runs]))
    wide = 1e7 * variance
    covariance = variance * further @ further.T + wide * own @ own.T
    count = len(equation.places)
    at_runs = covariance[count:, count:] + ratio * variance * np.eye(len(runs))
    cross = covariance[:count, count:]
    return covariance[:count, :count] - cross @ np.linalg.solve(at_runs, cross.T)


def test_a_run_changes_them_by_what_it_tells(monkeypatch):
    monkeypatch.setattr(module, "_likeliest", lambda *_: (0.01, 0.3))
    equation = judged()
    found = expected_errors(equation).after_run(4)
    expected = posterior(equation, 0.01, 0.3, np.vstack([RUNS, PLACES[4:5]])) / 4.0
    assert found.squares == close(np.diag(expected), rel=1e-4)


@pytest.mark.parametrize("form", ["linear", "quadratic"])
def test_the_worst_places_lie_outside_the_runs_and_apart(form):
    grid = np.array([[a, b] for a in np.linspace(0.8, 2.2, 8) for b in np.linspace(0.8, 2.2, 8)])
    chosen = grid[worst_places([judged(form, places=grid)], 4)]
    assert chosen[0].tolist() in [[a, b] for a in (0.8, 2.2) for b in (0.8, 2.2)]
    on_edge = np.any((chosen == 0.8) | (chosen == 2.2), axis=1)
    assert on_edge.all()
    distances = np.linalg.norm(chosen[:, None] - chosen, axis=2)
    assert distances[~np.eye(4, dtype=bool)].min() > 0.5


def test_as_many_runs_as_coefficients_tell_nothing_of_the_error():
    runs = np.array([[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]])
    found = expected_errors(judged("linear", runs=runs))
    assert np.all(np.isfinite(found.squares))
    assert np.all(found.squares > 0.0)
