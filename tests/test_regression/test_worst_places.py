"""Expected errors of equations, against the conditional normal distribution that they are derived from."""

import numpy as np
import pytest

from comparing import close
from regression.fits import fits as module
from regression.fits.fits import (
    JudgedEquation,
    expected_errors,
    fit_form,
    lacking_terms,
    worst_places,
)

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


def test_expected_errors_are_those_of_a_normal_distribution(monkeypatch):
    monkeypatch.setattr(module, "_likeliest", lambda *_: (0.01, 0.3))
    equation = judged()
    found = expected_errors(equation)
    # Relative errors are errors by the size of 2; the prior of a hundred million is not endless.
    expected = posterior(equation, 0.01, 0.3, RUNS) / 4.0
    assert found.left @ found.right.T == close(expected, rel=1e-4, abs=1e-5)
    assert found.squares == close(np.diag(expected), rel=1e-4)


def test_a_run_changes_them_by_what_it_tells(monkeypatch):
    monkeypatch.setattr(module, "_likeliest", lambda *_: (0.01, 0.3))
    equation = judged()
    found = expected_errors(equation).after_run(4)
    expected = posterior(equation, 0.01, 0.3, np.vstack([RUNS, PLACES[4:5]])) / 4.0
    assert found.squares == close(np.diag(expected), rel=1e-4)


def test_the_ratio_is_where_the_restricted_likelihood_is_largest():
    """Data drawn with a ratio of 0.1 and a variance of 4, over 400 runs: both are found within a factor."""
    rng = np.random.default_rng(5)
    x = rng.uniform(-1.0, 1.0, 400)
    own = np.column_stack([np.ones(400), x])
    further = rng.standard_normal((400, 60))
    target = own @ [3.0, -2.0] + 2.0 * further @ rng.standard_normal(60)
    target += np.sqrt(0.4) * rng.standard_normal(400)
    ratio, variance = module._likeliest(own, further, target)
    assert 0.03 < ratio < 0.33
    assert 2.0 < variance < 8.0


@pytest.mark.parametrize("form", ["linear", "quadratic"])
def test_the_worst_places_lie_outside_the_runs_and_apart(form):
    grid = np.array([[a, b] for a in np.linspace(0.8, 2.2, 8) for b in np.linspace(0.8, 2.2, 8)])
    chosen = grid[worst_places([judged(form, places=grid)], 4)]
    assert chosen[0].tolist() in [[a, b] for a in (0.8, 2.2) for b in (0.8, 2.2)]
    on_edge = np.any((chosen == 0.8) | (chosen == 2.2), axis=1)
    assert on_edge.all()
    distances = np.linalg.norm(chosen[:, None] - chosen, axis=2)
    assert distances[~np.eye(4, dtype=bool)].min() > 0.5


def test_an_exact_equation_is_worst_nowhere():
    runs = RUNS
    fit = fit_form("linear", ("a", "b"), runs, np.ones(len(runs)))
    equation = JudgedEquation(fit, runs, np.ones(len(runs)), PLACES, np.ones(len(PLACES)))
    assert expected_errors(equation).squares == close(np.zeros(6), abs=1e-12)
    assert len(set(worst_places([equation], 3))) == 3


def test_as_many_runs_as_coefficients_tell_nothing_of_the_error():
    runs = np.array([[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]])
    found = expected_errors(judged("linear", runs=runs))
    assert np.all(np.isfinite(found.squares))
    assert np.all(found.squares > 0.0)
