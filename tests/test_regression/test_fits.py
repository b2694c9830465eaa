import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import qmc

from comparing import close
from crankbase.errors import InputError
from regression.fits.fits import fit_form
from regression.fits.forms import FORMS

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


def test_a_fit_is_shown_in_a_line():
    found = fit("linear")
    assert repr(found).startswith(
        f"Fit(linear of {', '.join(found.factors)}: 4 coefficients, largest error "
    )
    assert repr(found).endswith(f" % at {len(HELDOUT)} held out)")


def test_coefficients_are_named_by_their_terms():
    assert list(fit("linear").coefficients) == ["1", *FACTORS]
    assert list(fit("quadratic").coefficients)[4:] == [
        "web_width^2",
        "web_thickness^2",
        "pin_length^2",
        "web_width * web_thickness",
        "web_width * pin_length",
        "web_thickness * pin_length",
    ]
    assert "ln(web_width) * ln(pin_length)" in fit("log-quadratic").coefficients


@pytest.mark.parametrize("form", KINDS)
def test_natural_coefficients_give_the_prediction(form):
    found = fit(form)
    u = np.log(HELDOUT) if found.fitted.logarithmic else HELDOUT
    natural = found.fitted.natural_coefficients()
    total = sum(
        c * np.prod([u[:, i] for i in term] or [np.ones(len(u))], axis=0)
        for term, c in natural.items()
    )
    expected = np.exp(total) if found.fitted.logarithmic else total
    assert found.predict(HELDOUT) == close(expected, rel=1e-9)


@pytest.mark.parametrize("form", KINDS)
def test_q_squared_equals_refitting_without_each_run(form):
    found = fit(form)
    left_out = np.array(
        [
            fit_form(form, FACTORS, np.delete(RUNS, i, 0), np.delete(Y, i)).predict(RUNS[i])
            for i in range(len(Y))
        ]
    )
    expected = 1.0 - np.sum((Y - left_out) ** 2) / np.sum((Y - Y.mean()) ** 2)
    assert found.q_squared == close(expected, rel=1e-9)


@pytest.mark.parametrize("form", KINDS)
def test_errors_are_of_the_response_itself(form):
    found = fit(form)
    predicted = found.predict(RUNS)
    r_squared = 1.0 - np.sum((Y - predicted) ** 2) / np.sum((Y - Y.mean()) ** 2)
    assert found.r_squared == close(r_squared, rel=1e-12)
    errors = np.abs(predicted / Y - 1.0)
    heldout = np.abs(found.predict(HELDOUT) / HELDOUT_Y - 1.0)
    assert found.largest_error == close(errors.max())
    assert found.mean_error == close(errors.mean())
    assert found.largest_heldout_error == close(heldout.max())
    assert found.mean_heldout_error == close(heldout.mean())
    assert (found.runs, found.heldout_runs) == (27, 12)


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


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"form": "cubic"}, "form: given 'cubic'; allowed are linear, interactions, quadratic"),
        ({"x": RUNS[NINE], "y": Y[NINE]}, "runs: given 9; at least 10 are needed"),
        ({"x": RUNS[:, :2]}, r"x: given an array of shape \(27, 2\)"),
        ({"y": Y[:5]}, r"y: given an array of shape \(5,\)"),
        ({"y": [*Y[:26], np.nan]}, "y: given a number that is not finite"),
        ({"y": [*Y[:26], 0.0]}, "y: given a response of 0"),
        ({"factors": ("a", "a", "b")}, "factors: given"),
        ({"heldout_y": None}, "heldout_x, heldout_y: given only one"),
        ({"x": RUNS * [1.0, 1.0, 0.0] + [0, 0, 0.139]}, "pin_length: given the same value 0.139"),
    ],
)
def test_unusable_runs(change, match):
    given_input = {
        "form": "quadratic",
        "factors": FACTORS,
        "x": RUNS,
        "y": Y,
        "heldout_x": HELDOUT,
        "heldout_y": HELDOUT_Y,
    }
    with pytest.raises(InputError, match=match):
        fit_form(**(given_input | change))


def test_log_form_needs_a_positive_response():
    with pytest.raises(InputError, match=r"y: given -.*not positive"):
        fit("log-quadratic", y=-Y, heldout_y=-HELDOUT_Y)
    with pytest.raises(InputError, match="x: given -1"):
        fit("log-quadratic").predict([-1.0, 0.07, 0.14])


def test_a_column_that_reaches_zero_stays_out_of_logarithms():
    x = RUNS - [0.0, 0.038, 0.0]  # the second column from 0
    found = fit_form("log-quadratic", FACTORS, x, Y)
    assert found.fitted.log_factors == (True, False, True)
    assert "ln(web_width) * web_thickness" in found.coefficients
    # The range may reach 0 though no run does.
    asked = fit_form("log-quadratic", FACTORS, RUNS, Y, logged=(True, False, True))
    assert asked.fitted.log_factors == (True, False, True)


def test_two_levels_do_not_determine_a_square():
    x = np.array(list(itertools.product(*BOX.values())) * 2)
    found = fit_form("quadratic", FACTORS, x, compliance(x))
    assert found.undetermined == ("web_width^2", "web_thickness^2", "pin_length^2")
    assert len(found.coefficients) == 7


def test_cubic_terms_where_the_levels_are():
    levels = [np.linspace(*box, n) for box, n in zip(BOX.values(), (3, 4, 2), strict=True)]
    x = np.array(list(itertools.product(*levels)))
    found = fit_form("log-cubic", FACTORS, x, compliance(x))
    assert set(found.undetermined) == {
        "ln(pin_length)^2",
        "ln(web_width)^3",
        "ln(pin_length)^3",
        "ln(web_width) * ln(pin_length)^2",
        "ln(web_thickness) * ln(pin_length)^2",
    }
    # The rest is what a product of full polynomials of these degrees has up to degree 3.
    assert len(found.coefficients) == 20 - 5


def test_cubic_terms_that_follow_from_others_are_left_out():
    # Three levels of b, at which b^3 is a sum of its lower powers, and one run that gives a a fourth.
    square = np.array(list(itertools.product((1.0, 2.0, 3.0), repeat=2)))
    found = fit_form(
        "log-cubic", ("a", "b"), np.vstack([square, [[1.5, 1.0], [1.5, 2.0]]]), np.arange(1.0, 12.0)
    )
    assert "ln(b)^3" in found.undetermined
    assert np.isfinite(list(found.coefficients.values())).all()


def test_aliased_interactions_are_no_interactions():
    # A half fraction with c = a b: the product of the first two is the third.
    corners = np.array([[a, b, a * b] for a in (-1.0, 1.0) for b in (-1.0, 1.0)] * 3)
    with pytest.raises(InputError, match=r"do not determine the coefficient of a \* b"):
        fit_form("interactions", ("a", "b", "c"), corners, np.arange(1.0, 13.0))


def with_outline(x, share=0.9):
    """Add a rectangle for each obround: columns of three labels, of which one never occurs."""
    both = np.vstack(
        [np.column_stack([x, np.zeros(len(x))]), np.column_stack([x, np.ones(len(x))])]
    )
    return both, np.concatenate([compliance(x), share * compliance(x)])


def test_a_category_is_a_column_without_powers_or_logarithm():
    x, y = with_outline(RUNS)
    found = fit_form("power law", (*FACTORS, "web_outline=rectangle"), x, y)
    assert found.fitted.log_factors == (True, True, True, False)
    # ln of a constant share is its coefficient.
    assert found.coefficients["web_outline=rectangle"] == close(math.log(0.9), rel=1e-9)
    full = fit_form("log-quadratic", (*FACTORS, "web_outline=rectangle"), x, y)
    assert "web_outline=rectangle^2" not in full.coefficients
    assert "ln(web_width) * web_outline=rectangle" in full.coefficients


def test_labels_of_one_category_are_never_multiplied():
    x = np.array([[b, float(i == 1), float(i == 2)] for b in (1.0, 2.0, 3.0) for i in range(3)])
    found = fit_form("interactions", ("b", "kind=b", "kind=c"), x, 1 + x @ [1.0, 2.0, 3.0])
    assert "kind=b * kind=c" not in found.coefficients
    assert "b * kind=c" in found.coefficients


def test_scaled_response_is_the_same_fit():
    """Fitted as y = scale * equation, errors are those of y; R2 is that of y, too."""
    scale, heldout_scale = RUNS[:, 0] * 3.0, HELDOUT[:, 0] * 3.0
    found = fit_form(
        "log-quadratic",
        FACTORS,
        RUNS,
        Y,
        HELDOUT,
        HELDOUT_Y,
        scale=scale,
        heldout_scale=heldout_scale,
    )
    plain = fit("log-quadratic")
    # ln(scale) is a term of the form: nothing but one coefficient changes.
    assert found.largest_heldout_error == close(plain.largest_heldout_error, rel=1e-7)
    assert found.r_squared == close(plain.r_squared, rel=1e-9)
    assert found.q_squared == close(plain.q_squared, rel=1e-9)
    power = found.fitted.natural_coefficients()
    assert power[(0,)] == close(plain.fitted.natural_coefficients()[(0,)] - 1.0, rel=1e-7)
    with pytest.raises(InputError, match=r"scale: given an array of shape \(3,\)"):
        fit_form("linear", FACTORS, RUNS, Y, scale=[1.0, 2.0, 3.0])


def test_statistics_of_natural_coefficients():
    """Standard errors in natural variables are those of a fit in natural variables."""
    found = fit("linear")
    plain = np.column_stack([np.ones(27), RUNS])
    covariance = found.statistics.residual_variance * np.linalg.inv(plain.T @ plain)
    assert list(found.natural_standard_errors.values()) == close(
        np.sqrt(np.diag(covariance)), rel=1e-8
    )
    assert (
        fit_form("quadratic", ("web_width",), RUNS[[0, 9, 18], :1], Y[:3]).natural_standard_errors
        is None
    )


def test_ranges_are_those_of_the_runs():
    found = fit("linear")
    assert found.lowest == close(tuple(LOW))
    assert found.highest == close(tuple(HIGH))
    assert found.basis == "factors"
    assert fit_form("group power law", ("R/h",), RUNS[:, 1:2], Y).basis == "groups"
