"""Fits: forms, least squares, and the choice between equations."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import qmc

from comparing import close
from crankbase.errors import InputError
from refusals import refusals, refusals_of, refused
from regression.fits.fits import fit_form
from regression.fits.forms import FORMS, FittedForm, design_matrix, form_named, polynomial_terms
from regression.fits.selection import (
    adjusted,
    backward,
    choose,
    coefficient_of_determination,
    least_squares,
    left_out_predictions,
)

FACTORS = ("web_width", "web_thickness", "pin_length")
BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098), "pin_length": (0.120, 0.158)}
LOW, HIGH = np.array(list(BOX.values())).T
RUNS = np.array(list(itertools.product(*(np.linspace(*box, 3) for box in BOX.values()))))
HELDOUT = qmc.scale(qmc.LatinHypercube(3, rng=5).random(12), LOW, HIGH)
# Nine runs that have all levels of every factor.
NINE = [0, 4, 8, 10, 14, 15, 20, 21, 25]
# A fit of each kind; the others differ from these by their terms alone.
KINDS = ("linear", "quadratic", "log-quadratic", "log-cubic")


def compliance(x):
    """Something shaped like a throw: a pin in bending, and webs that soften each other's ends."""
    B, h, L = np.moveaxis(np.asarray(x), -1, 0)
    pin = 0.17**2 * (L + 0.33 * h) / (2.1e11 * math.pi * 0.18**4 / 64)
    web = 8 * 0.17**3 / (2.1e11 * B * (h**2 + 0.03**2) ** 1.5)
    return 0.6 * pin + 0.5 * web


Y, HELDOUT_Y = compliance(RUNS), compliance(HELDOUT)


def fit(form, x=RUNS, y=Y, heldout_x=HELDOUT, heldout_y=HELDOUT_Y):
    return fit_form(form, FACTORS, x, y, heldout_x, heldout_y)


@pytest.mark.parametrize("form", KINDS)
def test_recovers_its_own_form(form):
    rng = np.random.default_rng(2)
    terms = fit(form).fitted.terms
    truth = rng.uniform(0.5, 1.5, len(terms))
    u = np.log(RUNS) if FORMS[form].logarithmic else RUNS
    total = sum(
        c * np.prod([u[:, i] for i in term] or [np.ones(len(u))], axis=0)
        for c, term in zip(truth, terms, strict=True)
    )
    y = np.exp(total) if FORMS[form].logarithmic else total
    found = fit_form(form, FACTORS, RUNS, y, RUNS[:4], y[:4])
    assert list(found.coefficients.values()) == close(truth, rel=1e-7)
    assert found.r_squared == close(1.0, abs=1e-12)
    assert found.q_squared == close(1.0, abs=1e-10)
    assert found.largest_error < 1e-12
    assert found.largest_heldout_error < 1e-12


@pytest.mark.parametrize(
    ("form", "drop_terms"), [*((form, False) for form in KINDS), ("log-quadratic", True)]
)
def test_q_squared_equals_refitting_without_each_run(form, drop_terms):
    """Also the terms are selected without the run, where some are dropped."""
    found = fit_form(form, FACTORS, RUNS, Y, drop_terms=drop_terms)
    assert bool(found.dropped) == drop_terms
    others = [
        fit_form(form, FACTORS, np.delete(RUNS, i, 0), np.delete(Y, i), drop_terms=drop_terms)
        for i in range(len(Y))
    ]
    left_out = np.array([fit.predict(run) for fit, run in zip(others, RUNS, strict=True)])
    expected = 1.0 - np.sum((Y - left_out) ** 2) / np.sum((Y - Y.mean()) ** 2)
    assert found.q_squared == close(expected, rel=1e-9)


def test_a_fit_is_shown_in_a_line():
    assert f"at {len(HELDOUT)} held out" in repr(fit("linear"))


def test_as_many_runs_as_coefficients_has_no_q_squared():
    x = np.array([[0.27], [0.30], [0.33]])
    found = fit_form("quadratic", ("web_width",), x, [3.0, 2.0, 1.5])
    assert found.r_squared == close(1.0)
    assert found.q_squared is None
    assert found.largest_heldout_error is None


def test_constant_response():
    found = fit_form("linear", FACTORS, RUNS, np.full(27, 2e-9))
    assert found.r_squared == 1.0
    assert found.predict(HELDOUT) == close(np.full(12, 2e-9))


@pytest.mark.slow
@settings(deadline=None, max_examples=30)
@given(size=st.floats(1e-4, 1e4), response_size=st.floats(1e-12, 1e12), form=st.sampled_from(KINDS))
def test_unit_invariance(size, response_size, form):
    """Fitted in mm and nm/N instead of m and m/N, the same throws get the same compliance."""
    plain = fit(form)
    scaled = fit_form(
        form, FACTORS, RUNS / size, Y / response_size, HELDOUT / size, HELDOUT_Y / response_size
    )
    assert scaled.predict(HELDOUT / size) * response_size == close(plain.predict(HELDOUT), rel=1e-9)
    assert scaled.q_squared == close(plain.q_squared, rel=1e-7)
    assert scaled.largest_heldout_error == close(plain.largest_heldout_error, rel=1e-6)


def test_predict_takes_any_leading_shape():
    found = fit("quadratic")
    grid = RUNS.reshape(3, 9, 3)
    assert found.predict(grid).shape == (3, 9)
    assert found.predict(RUNS[4]).shape == ()
    assert np.array_equal(found.predict(grid).ravel(), found.predict(RUNS))


test_unusable_runs = refusals_of(
    lambda change: fit(**{"form": "quadratic"} | change),
    ({"form": "cubic"}, "form"),
    ({"x": RUNS[NINE], "y": Y[NINE]}, "runs"),
    ({"y": [*Y[:26], 0.0]}, "y"),
    ({"x": RUNS * [1.0, 1.0, 0.0] + [0, 0, 0.139]}, "pin_length"),
)


def test_two_levels_do_not_determine_a_square():
    x = np.array(list(itertools.product(*BOX.values())) * 2)
    found = fit_form("quadratic", FACTORS, x, compliance(x))
    assert found.undetermined == ("web_width^2", "web_thickness^2", "pin_length^2")
    assert len(found.coefficients) == 7


def test_aliased_interactions_are_no_interactions():
    # A half fraction with c = a b: the product of the first two is the third.
    corners = np.array([[a, b, a * b] for a in (-1.0, 1.0) for b in (-1.0, 1.0)] * 3)
    with pytest.raises(InputError, match=r"do not determine the coefficient of a \* b"):
        fit_form("interactions", ("a", "b", "c"), corners, np.arange(1.0, 13.0))


def test_labels_of_one_category_are_never_multiplied():
    x = np.array([[b, float(i == 1), float(i == 2)] for b in (1.0, 2.0, 3.0) for i in range(3)])
    found = fit_form("interactions", ("b", "kind=b", "kind=c"), x, 1 + x @ [1.0, 2.0, 3.0])
    assert "kind=b * kind=c" not in found.coefficients
    assert "b * kind=c" in found.coefficients


def test_scaled_response_is_the_same_fit():
    """Fitted as y = scale * equation, errors are those of y; R2 is that of y, too."""
    scale, heldout_scale = RUNS[:, 0] * 3.0, HELDOUT[:, 0] * 3.0
    judged = (HELDOUT, HELDOUT_Y)
    scales = {"scale": scale, "heldout_scale": heldout_scale}
    found = fit_form("log-quadratic", FACTORS, RUNS, Y, *judged, **scales)
    plain = fit("log-quadratic")
    # ln(scale) is a term of the form: nothing but one coefficient changes.
    assert found.largest_heldout_error == close(plain.largest_heldout_error, rel=1e-7)
    assert found.r_squared == close(plain.r_squared, rel=1e-9)
    assert found.q_squared == close(plain.q_squared, rel=1e-9)
    power = found.fitted.natural_coefficients()
    assert power[(0,)] == close(plain.fitted.natural_coefficients()[(0,)] - 1.0, rel=1e-7)


def equation(**changes):
    given = {
        "form": "log-cubic",
        "factors": ("a", "b"),
        "logarithmic": True,
        "log_factors": (True, False),
        "center": (0.5, 2.0),
        "half_range": (0.25, 4.0),
        "terms": ((), (0,), (1,), (0, 0, 1)),
        "coefficients": (1.0, 0.5, -0.25, 0.125),
    }
    return FittedForm(**(given | changes))


def test_natural_coefficients_in_other_units():
    found = equation()
    natural = found.natural_coefficients((1e-3, 10.0), 1e-9)
    u = (math.log(3.0 / 1e-3), 5.0 / 10.0)
    total = sum(c * math.prod(u[i] for i in term) for term, c in natural.items())
    assert float(found.predict([3.0, 5.0])) == close(1e-9 * math.exp(total), rel=1e-10)


def test_natural_transformation():
    found = equation()
    terms, matrix = found.natural_transformation()
    natural = found.natural_coefficients()
    assert terms == tuple(natural)
    assert matrix @ found.coefficients == close(list(natural.values()), rel=1e-12)


test_contradictory_equations = refusals_of(
    lambda changes: equation(**changes),
    ({"center": (0.5,)}, "center"),
    ({"coefficients": (1.0, 2.0)}, "coefficients"),
    ({"log_factors": (True,)}, "log_factors"),
    ({"half_range": (0.25, 0.0)}, "half_range"),
    ({"center": (0.5, np.nan)}, "center[1]"),
    ({"terms": ((), (0,), (1,), (1, 0))}, "terms"),
    ({"terms": ((), (0,), (1,), (2,))}, "terms"),
    ({"terms": ((), (0,), (1,), (1,))}, "terms"),
)


def test_points_that_cannot_be_evaluated():
    with refused("x"):
        equation().predict([1.0, 2.0, 3.0])
    # Columns that are not logged may be negative.
    assert np.isfinite(equation().predict([3.0, -2.0]))


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
    left_out = least_squares(matrix, y, names(matrix)).leave_one_out
    return None if left_out is None else np.sum((y - left_out) ** 2)


def test_terms_of_nothing_go_and_the_others_stay():
    kept, dropped = backward(*noisy(), TERMS)
    assert (0, 1) in [TERMS[i] for i in kept]
    assert len(dropped) >= 3
    assert sorted(kept + dropped) == list(range(len(TERMS)))
    # The constant and the factors stay, though the third does nothing.
    assert kept[:4] == [0, 1, 2, 3]


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


def test_a_large_study_keeps_the_selection_of_all_runs(monkeypatch):
    x = np.random.default_rng(8).uniform(1.0, 2.0, (40, 3))
    y = x @ [1.0, -2.0, 0.5] + 0.3 * np.random.default_rng(9).normal(size=40) + 9.0
    monkeypatch.setattr("regression.fits.fits.LARGEST_SELECTION", 40**2 * 10 - 1)
    found = fit_form("quadratic", ("a", "b", "c"), x, y, drop_terms=True)
    left_out = found.statistics.leave_one_out
    assert found.q_squared == close(coefficient_of_determination(y, left_out), rel=1e-12)


def test_a_run_that_cannot_be_missed_has_no_prediction():
    z = np.random.default_rng(2).uniform(-1, 1, (len(TERMS), 3))
    assert left_out_predictions(design_matrix(TERMS, z), np.arange(1.0, 11.0), TERMS) is None


def test_the_smallest_error_is_chosen():
    choice = choose([Judged("a", 4, 0.05), Judged("b", 10, 0.02), Judged("c", 20, 0.03)])
    assert choice.place == 1


def test_errors_within_the_scatter_of_the_finite_elements_are_equal():
    fits = [Judged("a", 10, 0.0015), Judged("b", 20, 0.001)]
    assert choose(fits).place == 1
    assert choose(fits, scatter=0.0006).place == 0


def test_of_equal_forms_the_first_is_chosen():
    assert choose([Judged("a", 4, 0.02), Judged("b", 4, 0.02)]).place == 0


def test_forms_must_be_judged():
    with pytest.raises(InputError, match="linear fit without held-out designs"):
        choose([Judged("linear", 4, None)])
    with pytest.raises(InputError, match="fits: given none"):
        choose([])


def random_system(seed=0, rows=30, columns=6):
    rng = np.random.default_rng(seed)
    matrix = np.column_stack([np.ones(rows), rng.uniform(-1, 1, (rows, columns - 1))])
    return matrix, matrix @ rng.normal(size=columns) + 0.3 * rng.normal(size=rows)


def names(matrix):
    return [f"c{i}" for i in range(matrix.shape[1])]


def test_a_line_through_three_points():
    # y = 0, 1, 1 over x = -1, 0, 1: slope 1/2, mean 2/3, residuals -1/6, 1/3, -1/6.
    matrix = np.array([[1.0, -1.0], [1.0, 0.0], [1.0, 1.0]])
    found = least_squares(matrix, np.array([0.0, 1.0, 1.0]), names(matrix))
    assert found.coefficients == close([2 / 3, 1 / 2])
    assert found.residuals == close([-1 / 6, 1 / 3, -1 / 6])
    assert found.residual_variance == close(1 / 6)
    assert found.standard_errors == close([np.sqrt(1 / 18), np.sqrt(1 / 12)])
    assert found.residual_squares / found.total_squares == close(1 / 4)
    assert found.f_value == close(3.0)
    assert found.leverage == close([5 / 6, 1 / 3, 5 / 6])
    # Left out one by one: -1 at the first, 1/2 at the second, 2 at the third.
    assert found.leave_one_out == close([1.0, 0.5, 2.0])
    assert found.variance_inflation == close([1.0])
    assert found.condition_number == close(np.sqrt(3 / 2))


def test_variance_inflation_of_a_column_that_nearly_repeats_another():
    matrix, y = random_system()
    # x5 + a small part of its own: R2 of the new column by the others is 1 - (own part's share).
    noise = 0.01 * np.random.default_rng(3).normal(size=30)
    matrix = np.column_stack([matrix, matrix[:, 5] + noise])
    found = least_squares(matrix, y, names(matrix))
    others = least_squares(matrix[:, :-1], matrix[:, -1], names(matrix))
    assert found.variance_inflation[-1] == close(
        others.total_squares / others.residual_squares, rel=1e-9
    )
    assert found.variance_inflation[-1] > 1000


def test_what_cannot_be_solved():
    matrix, y = random_system(rows=8)
    double = np.column_stack([matrix, matrix[:, 2] - matrix[:, 1]])
    with pytest.raises(InputError, match="do not determine the coefficient of c6"):
        least_squares(double, y, names(double))


def test_adjusted():
    assert adjusted(0.9, 11, 3) == close(0.875)
    assert adjusted(0.9, 3, 3) is None


test_refused = refusals(
    ("y", lambda: fit("log-quadratic", y=-Y, heldout_y=-HELDOUT_Y)),
    ("x", lambda: fit("log-quadratic").predict([-1.0, 0.07, 0.14])),
    ("form", lambda: form_named("cubic")),
    ("x", lambda: equation().predict([-3.0, -2.0])),
)
