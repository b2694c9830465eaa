import itertools
import math
import re

import numpy as np
import pytest

from comparing import close
from regression.fits.equation_text import equation_text, term_symbols
from regression.fits.fits import fit_form
from regression.fits.forms import FORMS, FittedForm
from regression.throw_values import FactorLabel, factor_label

FACTORS = ("web_width", "web_thickness", "pin_length")
BOX = ((0.270, 0.330), (0.038, 0.098), (0.120, 0.158))
POINTS = np.array(list(itertools.product(*(np.linspace(*box, 4) for box in BOX))))


def compliance(x):
    B, h, L = np.moveaxis(np.asarray(x), -1, 0)
    return 1e-9 * (L / 0.139) ** 0.2 * 0.3 / B * (0.3 + (0.05 / h) ** 3 + 2 * L * h)


def form(*arguments, logged=None):
    """Make a fitted form of name, factors, logarithmic, center, half range, terms, coefficients."""
    name, factors, logarithmic, center, half_range, terms, coefficients = arguments
    logs = (logarithmic,) * len(factors) if logged is None else logged
    return FittedForm(name, factors, logarithmic, logs, center, half_range, terms, coefficients)


def evaluate_text(text, values):
    """Evaluate a printed equation as a reader would; values by symbol, in the printed units."""
    left, right = text.split(" = ", 1)
    right = re.sub(r"\[(\w+) = (\w+)\]", r"\1_\2", right)
    scale = 1.0
    if left.startswith("ln(") and " / (" in left:
        scale = float(re.search(r"/ \((1e-?\d+) m/N\)", left).group(1))
    bracket = r"(1e-?\d+) \* \((.*)\) m/N, lengths in mm"
    power_law = r"(\S+) m/N \* (.*)"
    if match := re.fullmatch(bracket, right) or re.fullmatch(power_law, right):
        scale, right = float(match.group(1)), match.group(2)
    right = right.replace("/mm)", ")").replace("^", "**")
    # "0.01 B h" is a product: a blank between two names or numbers, where no sign stands.
    right = re.sub(r"(?<=[\w)]) (?=[A-Za-z(])", " * ", right)
    total = eval(right, {"__builtins__": {}, "ln": math.log}, values)
    return scale * math.exp(total) if left.startswith("ln(") else scale * total


@pytest.mark.parametrize("name", [name for name in FORMS if FORMS[name].basis == "factors"])
def test_printed_equation_reproduces_the_prediction(name):
    found = fit_form(name, FACTORS, POINTS, compliance(POINTS), drop_terms=True).fitted
    text = equation_text(found, symbol="e_n", unit="m/N")
    for point in POINTS:
        values = dict(zip(("B", "h", "L_shm"), point * 1e3, strict=True))
        assert evaluate_text(text, values) == close(float(found.predict(point)), rel=1e-4)


def test_printed_equation_of_a_narrow_box_takes_the_digits_it_needs():
    narrow = ((0.2999, 0.3001), (0.0679, 0.0681))
    x = np.array(list(itertools.product(*(np.linspace(*box, 4) for box in narrow))))
    y = 1.3e-9 * (1 + 5e3 * (x[:, 0] - 0.3)) * (1 - 6e3 * (x[:, 1] - 0.068)) ** 2
    found = fit_form("quadratic", FACTORS[:2], x, y)
    text = equation_text(found.fitted, symbol="e_n", unit="m/N")
    for point in x:
        values = {"B": point[0] * 1e3, "h": point[1] * 1e3}
        assert evaluate_text(text, values) == close(float(found.predict(point)), rel=1e-4)


def test_equation_style():
    terms = ((), (0,), (1,), (2,))
    linear = form(
        "linear", FACTORS, False, (0.3, 0.07, 0.14), (0.02,) * 3, terms, (9e-9, 1e-9, 1e-9, -1e-9)
    )
    assert equation_text(linear, symbol="e_n", unit="m/N") == (
        "e_n = 1e-9 * (-2.5 + 0.05 B + 0.05 h - 0.05 L_shm) m/N, lengths in mm"
    )
    log = form(
        "log-quadratic",
        FACTORS[:1],
        True,
        (math.log(0.3),),
        (0.5,),
        ((), (0,), (0, 0)),
        (math.log(2e-9), -1.0, 0.25),
    )
    # With c = ln 300 the polynomial is ln 2 - 2 (u - c) + (u - c)^2.
    assert equation_text(log, symbol="e_n", unit="m/N") == (
        "ln(e_n / (1e-9 m/N)) = 44.633847 - 13.407565 ln(B/mm) + 1 (ln(B/mm))^2"
    )


def test_power_law_is_written_with_powers():
    # ln e = ln(2e-9) - 1.5 (ln B - ln 0.3) / 0.5 at half range 0.5: e = 2e-9 (B / 300 mm)^-3.
    law = form(
        "power law", FACTORS[:1], True, (math.log(0.3),), (0.5,), ((), (0,)), (math.log(2e-9), -1.5)
    )
    assert equation_text(law, symbol="e_n", unit="m/N") == "e_n = 0.054 m/N * (B/mm)^-3"


def test_cubic_terms_and_their_order():
    cubic = form(
        "cubic",
        ("a", "b"),
        False,
        (0.0, 0.0),
        (1.0, 1.0),
        ((), (0, 0, 1), (1, 1, 1)),
        (1.0, 2.0, 3.0),
    )
    assert equation_text(cubic, symbol="y", unit="") == "y = (1 + 2 a^2 b + 3 b^3)"
    assert term_symbols(cubic) == ("1", "a^2 b", "b^3")


def test_category_and_unlogged_column_in_a_logarithmic_form():
    mixed = form(
        "power law",
        ("web_thickness", "fillet_radius", "web_outline=rectangle"),
        True,
        (math.log(0.068), 0.005, 0.5),
        (1.0, 0.005, 0.5),
        ((), (0,), (1,), (2,)),
        (math.log(1e-9), -2.0, 0.1, 0.05),
        logged=(True, False, False),
    )
    text = equation_text(mixed, symbol="e_n", unit="m/N")
    assert text.endswith("- 2 ln(h/mm) + 0.02 (r/mm) + 0.1 [web_outline = rectangle]")
    point = [0.05, 0.008, 1.0]
    values = {"h": 50.0, "r": 8.0, "web_outline_rectangle": 1.0}
    assert evaluate_text(text, values) == close(float(mixed.predict(point)), rel=1e-4)


def test_equation_on_groups_is_dimensionless():
    groups = form(
        "group quadratic",
        ("s/R", "R/h"),
        True,
        (0.0, 0.0),
        (1.0, 1.0),
        ((), (0,), (1,), (0, 1)),
        (3.0, -0.5, 1.25, 0.1),
        logged=(False, True),
    )
    expected = " = 3 - 0.5 (s/R) + 1.25 ln(R/h) + 0.1 (s/R) ln(R/h)"
    for unit, left in (
        ("m/N", "ln(y E D_shm)"),
        ("rad/(N m)", "ln(y E D_shm^3)"),
        ("kg", "ln(y / (rho D_shm^3))"),
        ("", "ln(y)"),
    ):
        assert equation_text(groups, symbol="y", unit=unit, basis="groups") == left + expected


def test_equation_of_other_responses_and_units():
    labels = {"load": FactorLabel("P", "kN", 1e3), "ratio": FactorLabel("k", "", 1.0)}
    terms = ((), (0,), (1,))
    plane = form(
        "linear", ("load", "ratio"), False, (0.0, 0.0), (1e3, 1.0), terms, (5.0, 2.0, -1.0)
    )
    assert equation_text(plane, symbol="m", unit="kg", labels=labels) == (
        "m = (5 + 2 P - 1 k) kg, P in kN"
    )
    torsional = form("linear", FACTORS[:1], False, (0.3,), (0.03,), ((), (0,)), (4e-8, 1e-9))
    text = equation_text(torsional, symbol="e_t", unit="rad/(N m)")
    assert text == "e_t = 1e-9 * (30 + 0.0333333 B) rad/(N m), lengths in mm"


def test_labels_of_factors():
    assert factor_label("temperature") == FactorLabel("temperature", "", 1.0)
    assert factor_label("counterweight.thickness").unit == "mm"
    assert factor_label("further_pins.0.length").unit == "mm"
    assert factor_label("counterweight.nothing") == FactorLabel("counterweight.nothing", "", 1.0)
