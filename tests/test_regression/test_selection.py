import itertools
from dataclasses import dataclass

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from regression.fits.fits import fit_form
from regression.fits.selection import backward, choose, least_squares, left_out_predictions
from regression.fits.terms import design_matrix, divisors, polynomial_terms

TERMS = polynomial_terms(3, 2)


@dataclass(frozen=True)
class Judged:
    form: str
    coefficient_count: int
    largest_heldout_error: float | None


def noisy(seed=1):
    rng = np.random.default_rng(seed)
    z = rng.uniform(-1, 1, (40, 3))
    y = 1 + z[:, 0] - 2 * z[:, 1] + 0.8 * z[:, 0] * z[:, 1] + 0.1 * rng.normal(size=40)
    return design_matrix(TERMS, z), y


def press(matrix, y):
    return least_squares(matrix, y, [str(i) for i in range(matrix.shape[1])]).press


def test_terms_of_nothing_go_and_the_others_stay():
    kept, dropped = backward(*noisy(), TERMS)
    assert (0, 1) in [TERMS[i] for i in kept]
    assert len(dropped) >= 3
    assert sorted(kept + dropped) == list(range(len(TERMS)))
    # The constant and the factors stay, though the third does nothing.
    assert kept[:4] == [0, 1, 2, 3]


def test_press_never_grows_and_no_single_loss_would_lower_it():
    matrix, y = noisy(3)
    kept, dropped = backward(matrix, y, TERMS)
    history = [
        press(np.delete(matrix, dropped[:count], axis=1), y) for count in range(len(dropped) + 1)
    ]
    assert all(later <= earlier for earlier, later in itertools.pairwise(history))
    for place in kept[4:]:
        rest = [other for other in kept if other != place]
        assert press(matrix[:, rest], y) > history[-1]


def test_hierarchy_is_kept():
    terms = polynomial_terms(2, 3)
    z = np.random.default_rng(5).uniform(-1, 1, (30, 2))
    kept, _ = backward(design_matrix(terms, z), 1 + z[:, 0] ** 2 * z[:, 1], terms)
    left = [terms[place] for place in kept]
    assert (0, 0, 1) in left
    assert divisors((0, 0, 1)) <= set(left)


def test_a_form_with_as_many_terms_as_runs_loses_some_until_it_can_be_judged():
    z = np.random.default_rng(2).uniform(-1, 1, (len(TERMS), 3))
    matrix, y = design_matrix(TERMS, z), np.arange(1.0, 11.0)
    assert press(matrix, y) is None
    kept, dropped = backward(matrix, y, TERMS)
    assert dropped
    assert press(matrix[:, kept], y) is not None


def test_nothing_goes_where_no_shorter_form_can_be_judged():
    # Two runs at each of which one column alone is not 0 cannot be missed, whatever goes.
    matrix = np.zeros((4, 4))
    matrix[:, 0] = 1.0
    matrix[0, 1] = matrix[1, 2] = matrix[2, 3] = 1.0
    assert backward(matrix, np.arange(4.0), ((), (0,), (1,), (0, 1))) == ([0, 1, 2, 3], [])


def selected(matrix, y):
    """The selection by its definition: the worst term of those that may go, by refits."""
    kept = list(range(len(TERMS)))
    while True:
        needed = set().union(*(divisors(TERMS[i]) for i in kept))
        may_go = [i for i in kept if len(TERMS[i]) > 1 and TERMS[i] not in needed]
        errors = {i: press(matrix[:, [j for j in kept if j != i]], y) for i in may_go}
        best = min(errors, key=errors.get, default=None)
        if best is None or errors[best] > press(matrix[:, kept], y):
            return kept
        kept.remove(best)


def test_left_out_runs_are_left_out_of_the_selection_too():
    matrix, y = noisy(2)
    found = left_out_predictions(matrix, y, TERMS)
    sizes = set()
    for run in range(len(y)):
        others = np.arange(len(y)) != run
        kept = selected(matrix[others], y[others])
        sizes.add(tuple(kept))
        fit = least_squares(matrix[others][:, kept], y[others], [str(i) for i in kept])
        assert found[run] == close(matrix[run, kept] @ fit.coefficients, rel=1e-9)
    assert len(sizes) > 1  # the runs do not all keep the same terms
    assert selected(matrix, y) == backward(matrix, y, TERMS)[0]


def test_q_squared_is_that_of_runs_left_out_of_the_selection():
    x = np.random.default_rng(8).uniform(1.0, 2.0, (40, 3))
    y = x @ [1.0, -2.0, 0.5] + 0.3 * np.random.default_rng(9).normal(size=40) + 9.0
    found = fit_form("quadratic", ("a", "b", "c"), x, y, drop_terms=True)
    # Judged by the terms that all runs together chose, it looks better than it is.
    assert found.q_squared < found.statistics.q_squared
    assert found.band_designs == 40
    assert np.sum(np.abs(found.predict(x) / y - 1.0) <= found.band_error) >= 0.95 * 40


def test_a_large_study_keeps_the_selection_of_all_runs(monkeypatch):
    x = np.random.default_rng(8).uniform(1.0, 2.0, (40, 3))
    y = x @ [1.0, -2.0, 0.5] + 0.3 * np.random.default_rng(9).normal(size=40) + 9.0
    monkeypatch.setattr("regression.fits.fits.LARGEST_SELECTION", 40**2 * 10 - 1)
    found = fit_form("quadratic", ("a", "b", "c"), x, y, drop_terms=True)
    assert found.q_squared == close(found.statistics.q_squared, rel=1e-12)


def test_a_run_that_cannot_be_missed_has_no_prediction():
    z = np.random.default_rng(2).uniform(-1, 1, (len(TERMS), 3))
    assert left_out_predictions(design_matrix(TERMS, z), np.arange(1.0, 11.0), TERMS) is None


def test_a_fit_says_what_went():
    rng = np.random.default_rng(4)
    x = rng.uniform(1, 2, (40, 2))
    y = x[:, 0] ** 2 * x[:, 1] ** -1.5 * np.exp(0.001 * rng.normal(size=40))
    found = fit_form("log-quadratic", ("a", "b"), x, y, drop_terms=True)
    full = fit_form("log-quadratic", ("a", "b"), x, y)
    assert full.dropped == ()
    assert len(found.dropped) >= 1
    assert set(found.dropped) | set(found.coefficients) == set(full.coefficients)
    assert found.statistics.press <= full.statistics.press


def test_the_smallest_error_is_chosen():
    fits = [Judged("a", 4, 0.05), Judged("b", 10, 0.02), Judged("c", 20, 0.03)]
    choice = choose(fits)
    assert choice.place == 1
    assert choice.reason.startswith("b has the smallest largest error at the held-out designs, 2 %")


def test_of_nearly_equal_errors_the_shorter_form_is_chosen():
    fits = [Judged("a", 4, 0.05), Judged("b", 10, 0.0219), Judged("c", 20, 0.02)]
    choice = choose(fits)
    assert choice.place == 1
    assert "fewest coefficients, 10, of the 2 forms" in choice.reason
    assert "the smallest is 2 % of c with 20 coefficients" in choice.reason
    # A little over a tenth more, and it is not.
    assert choose([*fits[:1], Judged("b", 10, 0.0221), fits[2]]).place == 2


def test_errors_within_the_scatter_of_the_finite_elements_are_equal():
    fits = [Judged("a", 10, 0.0015), Judged("b", 20, 0.001)]
    assert choose(fits).place == 1
    assert choose(fits, scatter=0.0006).place == 0
    assert "scatter of 0.06 %" in choose(fits, scatter=0.0006).reason


def test_of_equal_forms_the_first_is_chosen():
    assert choose([Judged("a", 4, 0.02), Judged("b", 4, 0.02)]).place == 0


def test_forms_must_be_judged():
    with pytest.raises(InputError, match="linear fit without held-out designs"):
        choose([Judged("linear", 4, None)])
    with pytest.raises(InputError, match="fits: given none"):
        choose([])
