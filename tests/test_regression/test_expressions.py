"""Expressions over dimensions: units, grammar, comparisons, and equations as text."""

import itertools
import math
import re

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankbase.units import is_unit
from geometry.throw import CrankThrow
from plans import SHARP
from refusals import refusals, refused
from regression.fits.equation_text import equation_text, term_symbols
from regression.fits.fits import fit_form
from regression.fits.forms import FittedForm
from regression.plans.factors import throw_fields
from regression.plans.relations import (
    compile_constraint,
    compile_expression,
    constraint_violations,
    evaluate_expression,
    evaluation_order,
    read_constraint,
    read_expression,
)

UNITS = {"pin_diameter": "m", "web_thickness": "m", "ratio": "", "counterweight.angle": "rad"}
VALUES = {
    "pin_diameter": np.array([0.18, 0.20]),
    "web_thickness": np.array([0.05, 0.07]),
    "ratio": np.array([1.5, 2.0]),
    "counterweight.angle": np.array([1.0, 2.0]),
}
D, H, Q = VALUES["pin_diameter"], VALUES["web_thickness"], VALUES["ratio"]


def value_of(text, unit="m"):
    return evaluate_expression(
        read_expression(text, "study.relations.x", UNITS), VALUES, UNITS, unit
    )


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("1.6 * pin_diameter", "m", 1.6 * D),
        ("ratio * pin_diameter", "m", Q * D),
        ("410 mm - pin_diameter - 2 * web_thickness", "m", 0.41 - D - 2 * H),
        ("41 cm - pin_diameter", "m", 0.41 - D),
        ("10 in", "m", 0.254),
        ("-web_thickness + 2 * -3 mm", "m", -H - 0.006),
        ("410 mm / 2 mm", "", 205.0),
        ("4 mm ^ 2 / 2 mm", "m", 2e-3),
        ("(pin_diameter^2 - web_thickness**2) ** 0.5", "m", np.sqrt(D**2 - H**2)),
        ("2 ** -1 * pin_diameter", "m", 0.5 * D),
        ("-ratio ** 2", "", -(Q**2)),
        ("pin_diameter / web_thickness / ratio", "", D / H / Q),
        ("1e-1 * ratio + .5", "", 0.1 * Q + 0.5),
        (
            "counterweight.angle / 2 + 10 deg",
            "rad",
            VALUES["counterweight.angle"] / 2 + 0.1745329252,
        ),
        ("pin_diameter * counterweight.angle", "m", D * VALUES["counterweight.angle"]),
        ("0.3", "", 0.3),
        (0.3, "", 0.3),
    ],
)
def test_expressions(text, unit, expected):
    # Ten degrees stand above with ten digits.
    rel = 1e-9 if "deg" in str(text) else 1e-12
    assert np.broadcast_to(value_of(text, unit), (2,)) == close(
        np.broadcast_to(expected, (2,)), rel=rel
    )


@pytest.mark.parametrize(
    "text",
    [
        *("pin_diameter web_thickness", "2 pin_diameter", "1,6 * pin_diameter"),
        *("pin_diameter; ratio", "pin_diameter[0]", "pin_diameter // ratio", "3 furlongz"),
        *("pin_diameter * (ratio", "pin_diameter)", "pin_diameter *", "* pin_diameter", "()", ""),
        *(True, "mm * ratio", "__import__('os')", "max(pin_diameter)", "pin_diameter + ratio"),
    ],
)
def test_expressions_that_cannot_be(text):
    with refused("study.relations.x"):
        value_of(text)


def test_a_quantity_that_is_not_known_is_named_with_one_like_it():
    with pytest.raises(InputError, match=r"pin_diametre .* did you mean pin_diameter"):
        value_of("pin_diametre * 2")


def test_a_division_by_zero_has_no_value():
    assert not np.isfinite(value_of("pin_diameter / (ratio - ratio)")).any()


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        *(("pin_diameter ** 2", "m"), ("ratio", "m"), ("0.3", "m"), ("3 kg", "m")),
        *(("ratio", "rad"), ("120 deg", ""), ("pin_diameter", "rad")),
    ],
)
def test_results_of_another_kind(text, unit):
    with refused("study.relations.x"):
        value_of(text, unit)


def reasons(text):
    constraint = read_constraint(text, "study.constraints[0]", UNITS)
    return [reason is not None for reason in constraint_violations(constraint, VALUES, UNITS, 2)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("web_thickness >= 0.3 * pin_diameter", [True, False]),
        ("web_thickness < 60 mm", [False, True]),
        ("web_thickness <= 50 mm", [False, True]),
        ("web_thickness > 50 mm", [True, False]),
        ("1.2 < ratio < 1.8", [False, True]),
        ("0.3 <= web_thickness / pin_diameter <= 0.4", [True, False]),
        ("2 > 1", [False, False]),
        ("counterweight.angle <= 90 deg", [False, True]),
        ("pin_diameter * web_thickness > 100 cm^2", [True, False]),
    ],
)
def test_constraints(text, expected):
    assert reasons(text) == expected


def test_rounding_breaks_no_constraint():
    assert 3 * 0.1 != 0.3
    units = {"a": "m"}
    for text, holds in (("a <= 0.3 m", True), ("a >= 0.3 m", True), ("a < 0.3 m", False)):
        constraint = read_constraint(text, "c", units)
        assert (
            constraint_violations(constraint, {"a": np.array([3 * 0.1])}, units, 1) == [None]
        ) is holds


def test_what_has_no_value_holds_nothing():
    constraint = read_constraint("1 mm / (ratio - 2) < 5 m", "c", UNITS)
    assert constraint_violations(constraint, VALUES, UNITS, 2)[1] is not None


@pytest.mark.parametrize(
    "text",
    [
        *("web_thickness", *(f"web_thickness {sign} 5 mm" for sign in ("==", "!=", "=")), 5),
        *("web_thickness >", "web_thickness > 0.3", "ratio < 30 deg", "ratio < wrong"),
    ],
)
def test_constraints_that_cannot_be(text):
    with refused("study.constraints[0]"):
        reasons(text)


@pytest.mark.parametrize("texts", [{"a": "b", "b": "2 * c", "c": "a"}, {"a": "2 * a"}])
def test_relations_that_go_round(texts):
    units = dict.fromkeys("abc", "m")
    read = {name: read_expression(text, name, units) for name, text in texts.items()}
    with refused("study.relations"):
        evaluation_order(read)


def test_no_field_of_a_throw_is_a_unit():
    weight, pins = {"outer_radius": 0.25, "angle": 2.0}, ({"angle": 2.0},)
    throw = CrankThrow(**SHARP.model_dump() | {"counterweight": weight, "further_pins": pins})
    assert not [path for path in throw_fields(throw) if is_unit(path)]
    assert is_unit("mm")
    assert is_unit("h")
    assert not is_unit("width_ratio")


@pytest.mark.parametrize(
    "text",
    [
        "9**9**9**9",
        "(9**9)**9**9",
        "((9**9)**9)**9 * 9**(9**9)**(9**9)",
        "((pin_diameter**99)**99)**99",
        "2 ** (9 ** 9) * pin_diameter",
        "4 mm ** (1/2)",
        "(-8) ** 0.5 * pin_diameter",
        "pin_diameter" + " + pin_diameter" * 1000,
        pytest.param(10**5000, id="thousands of digits"),
    ],
)
def test_no_expression_takes_long_or_ends_unexpectedly(text):
    with refused("study.relations.x"):
        value_of(text)


def test_whole_numbers_are_calculated_as_others():
    assert value_of("(9**3)**3 * (1/9)**9 * pin_diameter") == close(D, rel=1e-12)


COMPILED_UNITS = {"a": "m", "b": "m", "x": "", "angle": "rad"}
COMPILED_VALUES = {
    name: np.random.default_rng(place).uniform(0.2, 2.0, 5)
    for place, name in enumerate(COMPILED_UNITS)
}


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("410 mm - 2 * b", "m"),
        ("-a + 2 * -b", "m"),
        ("a^2 / 2 mm", "m"),
        ("(a - b) / (2 mm^2) * b", ""),
        ("a / 2 / b * 3", ""),
        ("2 ** x * a / b", ""),
        ("-x ** 2 + x**-1", ""),
        ("30 deg + angle", "rad"),
        ("a ** 3 * (1.5e-3 + x) / b ** 2", "m"),
    ],
)
def test_expressions_are_what_pint_calculates(text, unit):
    read = read_expression(text, "f", COMPILED_UNITS)
    expected = evaluate_expression(read, COMPILED_VALUES, COMPILED_UNITS, unit)
    value = compile_expression(read)
    assert value(COMPILED_VALUES) == close(expected, rel=1e-12)
    for place in range(5):
        one = {name: float(column[place]) for name, column in COMPILED_VALUES.items()}
        assert value(one) == close(expected[place], rel=1e-12)


@pytest.mark.parametrize("text", ["1 / (a - a) * b", "(x - 3) ** 0.5", "x ** (x * 1e6)"])
def test_what_has_no_value_is_not_finite(text):
    value = compile_expression(read_expression(text, "f", COMPILED_UNITS))
    assert not np.isfinite(value(dict.fromkeys(COMPILED_UNITS, 1.5)))
    with np.errstate(all="ignore"):
        assert not np.isfinite(value({name: np.array([1.5]) for name in COMPILED_UNITS})).any()


@pytest.mark.parametrize("text", ["a >= 0.7 * b", "0.5 < x <= a / b", "a > a", "a >= a * 1.0"])
def test_constraints_hold_where_designs_keep_them(text):
    read = read_constraint(text, "f", COMPILED_UNITS)
    kept = [
        reason is None for reason in constraint_violations(read, COMPILED_VALUES, COMPILED_UNITS, 5)
    ]
    holds = compile_constraint(read)
    assert np.broadcast_to(holds(COMPILED_VALUES), 5).tolist() == kept
    ones = [
        {name: float(column[place]) for name, column in COMPILED_VALUES.items()}
        for place in range(5)
    ]
    assert [bool(holds(one)) for one in ones] == kept


FACTORS = ("web_width", "web_thickness", "pin_length")


def form(*arguments, logged=None):
    """Make a fitted form of name, factors, logarithmic, center, half range, terms, coefficients."""
    name, factors, logarithmic, center, half_range, terms, coefficients = arguments
    logs = (logarithmic,) * len(factors) if logged is None else logged
    return FittedForm(
        form=name,
        factors=factors,
        logarithmic=logarithmic,
        log_factors=logs,
        center=center,
        half_range=half_range,
        terms=terms,
        coefficients=coefficients,
    )


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


def test_printed_equation_of_a_narrow_box_takes_the_digits_it_needs():
    narrow = ((0.2999, 0.3001), (0.0679, 0.0681))
    x = np.array(list(itertools.product(*(np.linspace(*box, 4) for box in narrow))))
    y = 1.3e-9 * (1 + 5e3 * (x[:, 0] - 0.3)) * (1 - 6e3 * (x[:, 1] - 0.068)) ** 2
    found = fit_form("quadratic", FACTORS[:2], x, y)
    text = equation_text(found.fitted, symbol="e_n", unit="m/N")
    for point in x:
        values = {"B": point[0] * 1e3, "h": point[1] * 1e3}
        assert evaluate_text(text, values) == close(float(found.predict(point)), rel=1e-4)


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


test_refused_calls = refusals(
    ("study.relations.x", lambda: value_of("pin_diameter / ratio * (1 / 0)")),
)
