import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import InputError
from regression.designs import full_factorial, latin_hypercube
from regression.fits import choose, fit_form
from regression.forms import FORMS, FactorLabel, FittedForm, equation_text, form_terms

FACTORS = ("web_width", "web_thickness", "pin_length")
BOX = {
    "web_width": (0.270, 0.330),
    "web_thickness": (0.038, 0.098),
    "pin_length": (0.120, 0.158),
}
RUNS = full_factorial({name: np.linspace(*box, 3).tolist() for name, box in BOX.items()}).runs
HELDOUT = latin_hypercube(BOX, 12, 5).runs


def compliance(x):
    """Something shaped like a throw: a pin in bending, and webs that soften each other's ends."""
    B, h, L = np.moveaxis(np.asarray(x), -1, 0)
    pin = 0.17**2 * (L + 0.33 * h) / (2.1e11 * math.pi * 0.18**4 / 64)
    web = 8 * 0.17**3 / (2.1e11 * B * (h**2 + 0.03**2) ** 1.5)
    return 0.6 * pin + 0.5 * web


Y, HELDOUT_Y = compliance(RUNS), compliance(HELDOUT)


def fit(form, x=RUNS, y=Y, heldout_x=HELDOUT, heldout_y=HELDOUT_Y):
    return fit_form(form, FACTORS, x, y, heldout_x, heldout_y)


def evaluate_text(text, values):
    """Evaluate a printed equation as a reader would; values by symbol, in the printed units."""
    left, right = text.split(" = ")
    logarithmic = left.startswith("ln(")
    if logarithmic:
        scale = float(re.fullmatch(r"ln\(\S+ / \((1e-?\d+) m/N\)\)", left).group(1))
        right = re.sub(r"ln\((\w+)/mm\)", lambda m: f"ln_{m.group(1)}", right)
        values = {f"ln_{name}": math.log(value) for name, value in values.items()}
    else:
        match = re.fullmatch(r"(1e-?\d+) \* \((.*)\) m/N, lengths in mm", right)
        scale, right = float(match.group(1)), match.group(2)
    # "0.01 B h" is a product: a blank between two names or numbers, where no sign stands.
    python = right.replace("^", "**")
    python = re.sub(r"(?<=[\w)]) (?=[A-Za-z(])", " * ", python)
    total = eval(python, {"__builtins__": {}}, values)
    return scale * math.exp(total) if logarithmic else scale * total


@pytest.mark.parametrize("form", FORMS)
def test_recovers_its_own_form(form):
    rng = np.random.default_rng(2)
    terms = form_terms(FORMS[form], 3)
    truth = rng.uniform(0.5, 1.5, len(terms))
    u = np.log(RUNS) if FORMS[form].logarithmic else RUNS
    total = sum(
        c * np.prod([u[:, i] for i in term] or [np.ones(len(u))], axis=0)
        for c, term in zip(truth, terms, strict=True)
    )
    y = np.exp(total) if FORMS[form].logarithmic else total
    found = fit_form(form, FACTORS, RUNS, y, RUNS[:4], y[:4])
    assert list(found.coefficients.values()) == pytest.approx(truth, rel=1e-7)
    assert found.r_squared == pytest.approx(1.0, abs=1e-12)
    assert found.q_squared == pytest.approx(1.0, abs=1e-10)
    assert found.largest_error < 1e-12
    assert found.largest_heldout_error < 1e-12


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


@pytest.mark.parametrize("form", FORMS)
def test_natural_coefficients_give_the_prediction(form):
    found = fit(form)
    u = np.log(HELDOUT) if found.fitted.logarithmic else HELDOUT
    natural = found.fitted.natural_coefficients()
    total = sum(
        c * np.prod([u[:, i] for i in term] or [np.ones(len(u))], axis=0)
        for term, c in natural.items()
    )
    expected = np.exp(total) if found.fitted.logarithmic else total
    assert found.predict(HELDOUT) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_q_squared_equals_refitting_without_each_run(form):
    found = fit(form)
    left_out = np.array(
        [
            fit_form(form, FACTORS, np.delete(RUNS, i, 0), np.delete(Y, i)).predict(RUNS[i])
            for i in range(len(Y))
        ]
    )
    expected = 1.0 - np.sum((Y - left_out) ** 2) / np.sum((Y - Y.mean()) ** 2)
    assert found.q_squared == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_errors_are_of_the_response_itself(form):
    found = fit(form)
    predicted = found.predict(RUNS)
    r_squared = 1.0 - np.sum((Y - predicted) ** 2) / np.sum((Y - Y.mean()) ** 2)
    assert found.r_squared == pytest.approx(r_squared, rel=1e-12)
    errors = np.abs(predicted / Y - 1.0)
    heldout = np.abs(found.predict(HELDOUT) / HELDOUT_Y - 1.0)
    assert found.largest_error == pytest.approx(errors.max())
    assert found.mean_error == pytest.approx(errors.mean())
    assert found.largest_heldout_error == pytest.approx(heldout.max())
    assert found.mean_heldout_error == pytest.approx(heldout.mean())
    assert (found.runs, found.heldout_runs) == (27, 12)


def test_log_quadratic_is_chosen_by_heldout_designs():
    fits = [fit(form) for form in FORMS]
    assert choose(fits).form == "log-quadratic"
    assert choose(fits[:2]).form == "quadratic"
    best = choose(fits)
    assert best.largest_heldout_error == min(f.largest_heldout_error for f in fits)


def test_choose_needs_heldout_designs():
    with pytest.raises(InputError, match="linear fit without held-out designs"):
        choose([fit_form("linear", FACTORS, RUNS, Y)])
    with pytest.raises(InputError, match="fits: given none"):
        choose([])


def test_as_many_runs_as_coefficients_has_no_q_squared():
    x = np.array([[0.27], [0.30], [0.33]])
    found = fit_form("quadratic", ("web_width",), x, [3.0, 2.0, 1.5])
    assert found.r_squared == pytest.approx(1.0)
    assert found.q_squared is None
    assert found.largest_heldout_error is None


def test_constant_response():
    found = fit_form("linear", FACTORS, RUNS, np.full(27, 2e-9))
    assert found.r_squared == 1.0
    assert found.predict(HELDOUT) == pytest.approx(np.full(12, 2e-9))


@settings(deadline=None, max_examples=30)
@given(
    size=st.floats(1e-4, 1e4),
    response_size=st.floats(1e-12, 1e12),
    form=st.sampled_from(sorted(FORMS)),
)
def test_unit_invariance(size, response_size, form):
    """Fitted in mm and nm/N instead of m and m/N, the same throws get the same compliance."""
    plain = fit(form)
    scaled = fit_form(
        form, FACTORS, RUNS / size, Y / response_size, HELDOUT / size, HELDOUT_Y / response_size
    )
    assert scaled.predict(HELDOUT / size) * response_size == pytest.approx(
        plain.predict(HELDOUT), rel=1e-9
    )
    assert scaled.q_squared == pytest.approx(plain.q_squared, rel=1e-7)
    assert scaled.largest_heldout_error == pytest.approx(plain.largest_heldout_error, rel=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_printed_equation_reproduces_the_prediction(form):
    found = fit(form)
    text = equation_text(found.fitted, symbol="e_n", unit="m/N")
    corners = np.array(list(itertools.product(*BOX.values())))
    for point in np.vstack([RUNS, HELDOUT, corners]):
        values = dict(zip(("B", "h", "L_shm"), point * 1e3, strict=True))
        assert evaluate_text(text, values) == pytest.approx(float(found.predict(point)), rel=1e-4)


def test_printed_equation_of_a_narrow_box_takes_the_digits_it_needs():
    narrow = {"web_width": (0.2999, 0.3001), "web_thickness": (0.0679, 0.0681)}
    x = full_factorial({name: np.linspace(*box, 4).tolist() for name, box in narrow.items()}).runs
    y = 1.3e-9 * (1 + 5e3 * (x[:, 0] - 0.3)) * (1 - 6e3 * (x[:, 1] - 0.068)) ** 2
    found = fit_form("quadratic", tuple(narrow), x, y)
    text = equation_text(found.fitted, symbol="e_n", unit="m/N")
    for point in x:
        values = {"B": point[0] * 1e3, "h": point[1] * 1e3}
        assert evaluate_text(text, values) == pytest.approx(float(found.predict(point)), rel=1e-4)


def test_equation_style():
    linear = FittedForm(
        "linear", FACTORS, (0.3, 0.07, 0.14), (0.02, 0.02, 0.02), (9e-9, 1e-9, 1e-9, -1e-9)
    )
    assert equation_text(linear, symbol="e_n", unit="m/N") == (
        "e_n = 1e-9 * (-2.5 + 0.05 B + 0.05 h - 0.05 L_shm) m/N, lengths in mm"
    )
    log = FittedForm(
        "log-quadratic", ("web_width",), (math.log(0.3),), (0.5,), (math.log(2e-9), -1.0, 0.25)
    )
    text = equation_text(log, symbol="e_n", unit="m/N")
    # With c = ln 300 the polynomial is ln 2 - 2 (u - c) + (u - c)^2.
    assert text == "ln(e_n / (1e-9 m/N)) = 44.633847 - 13.407565 ln(B/mm) + 1 (ln(B/mm))^2"


def test_equation_of_other_responses_and_units():
    labels = {"load": FactorLabel("P", "kN", 1e3), "ratio": FactorLabel("k", "", 1.0)}
    plane = FittedForm("linear", ("load", "ratio"), (0.0, 0.0), (1e3, 1.0), (5.0, 2.0, -1.0))
    assert equation_text(plane, symbol="m", unit="kg", labels=labels) == (
        "m = (5 + 2 P - 1 k) kg, P in kN"
    )
    torsional = FittedForm("linear", ("web_width",), (0.3,), (0.03,), (4e-8, 1e-9))
    text = equation_text(torsional, symbol="e_t", unit="rad/(N m)")
    assert text == "e_t = 1e-9 * (30 + 0.0333333 B) rad/(N m), lengths in mm"


def test_factor_unknown_to_the_throw_stands_by_its_name():
    plane = FittedForm("linear", ("temperature",), (300.0,), (10.0,), (5.0, 1.0))
    assert equation_text(plane, symbol="y", unit="") == "y = (-25 + 0.1 temperature)"


def test_predict_takes_any_leading_shape():
    found = fit("quadratic")
    grid = RUNS.reshape(3, 9, 3)
    assert found.predict(grid).shape == (3, 9)
    assert found.predict(RUNS[4]).shape == ()
    assert np.array_equal(found.predict(grid).ravel(), found.predict(RUNS))


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"form": "cubic"}, "form: given 'cubic'; allowed are linear, quadratic, log-quadratic"),
        ({"x": RUNS[:9], "y": Y[:9]}, "runs: given 9; at least 10 are needed"),
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


def test_log_form_needs_positive_values():
    with pytest.raises(InputError, match="not positive"):
        fit("log-quadratic", y=-Y, heldout_y=-HELDOUT_Y)
    with pytest.raises(InputError, match="x: given -1"):
        fit("log-quadratic").predict([-1.0, 0.07, 0.14])


def test_two_levels_do_not_determine_a_square():
    levels = {name: np.linspace(*box, 2).tolist() for name, box in BOX.items()}
    x = np.vstack([full_factorial(levels).runs] * 2)
    with pytest.raises(InputError, match=r"do not determine the coefficient of web_width\^2"):
        fit_form("quadratic", FACTORS, x, compliance(x))
