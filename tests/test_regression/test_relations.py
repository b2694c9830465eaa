"""Expressions over the dimensions of a study: units, grammar, comparisons.

Results are compared with Python's own arithmetic; 1e-12 is its rounding.
"""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from geometry.throw import CrankThrow
from regression.plans.factors import throw_fields
from regression.plans.relations import (
    constraint_violations,
    evaluate_expression,
    evaluation_order,
    is_unit,
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


def test_the_names_that_an_expression_uses():
    read = read_expression("counterweight.angle + 2 * counterweight.angle * ratio", "x", UNITS)
    assert read.names == ("counterweight.angle", "ratio")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "pin_diameter web_thickness",
            "is no expression \\('web_thickness' after 'pin_diameter'\\)",
        ),
        ("2 pin_diameter", "pin_diameter"),
        ("1,6 * pin_diameter", "with ',' in it; allowed are numbers with a decimal point"),
        ("pin_diameter; ratio", "with ';' in it"),
        ("pin_diameter[0]", "with '\\[' in it"),
        ("pin_diameter // ratio", "'/' after '/'"),
        ("pin_diameter * (ratio", "the end after 'ratio'"),
        ("pin_diameter)", "'\\)' after 'pin_diameter'"),
        ("pin_diameter *", "the end after '\\*'"),
        ("* pin_diameter", "'\\*' at its start"),
        ("()", "'\\)' after '\\('"),
        ("", "allowed is an expression in quotes"),
        (True, "allowed is an expression in quotes"),
        ("pin_diametre * 2", "pin_diametre is no known quantity; did you mean pin_diameter"),
        ("mm * ratio", "mm is no known quantity; a unit follows a number"),
        ("3 furlongz", "furlongz is no known quantity"),
        ("__import__('os')", 'with "\'" in it'),
        ("max(pin_diameter)", "max is no known quantity"),
        ("pin_diameter + ratio", "which cannot be calculated \\(Cannot convert from"),
    ],
)
def test_expressions_that_cannot_be(text, message):
    with pytest.raises(InputError, match=rf"^study\.relations\.x: given .*{message}") as caught:
        value_of(text)
    assert str(caught.value).endswith(".")
    assert "\n" not in str(caught.value)


def test_a_division_by_zero_has_no_value():
    assert not np.isfinite(value_of("pin_diameter / (ratio - ratio)")).any()
    with pytest.raises(InputError, match=r"which cannot be calculated \(it divides by zero\)"):
        value_of("pin_diameter / ratio * (1 / 0)")


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("pin_diameter ** 2", "m", "which is an area; allowed is a length"),
        ("ratio", "m", "which is a pure number; allowed is a length"),
        ("0.3", "m", "which is a pure number; allowed is a length"),
        ("3 kg", "m", "which is in kg; allowed is a length"),
        ("ratio", "rad", "which is a pure number; allowed is an angle"),
        ("120 deg", "", "which is an angle; allowed is a pure number"),
        ("pin_diameter", "rad", "which is a length; allowed is an angle"),
    ],
)
def test_results_of_another_kind(text, unit, message):
    with pytest.raises(InputError, match=rf"^study\.relations\.x: given .*, {message}\."):
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


def test_the_reason_shows_both_sides():
    constraint = read_constraint("web_thickness >= 0.3 * pin_diameter", "c", UNITS)
    assert constraint_violations(constraint, VALUES, UNITS, 2)[0] == (
        "the constraint 'web_thickness >= 0.3 * pin_diameter' is broken: 50 mm is not >= 54 mm"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("web_thickness", "allowed is a comparison by <, <=, > or >="),
        ("web_thickness == 5 mm", "allowed is a comparison by"),
        ("web_thickness != 5 mm", "allowed is a comparison by"),
        ("web_thickness = 5 mm", "allowed is a comparison by"),
        (5, "allowed is a comparison by"),
        ("web_thickness >", "allowed is an expression in quotes"),
        ("web_thickness > 0.3", "which compares a length with a pure number"),
        ("ratio < 30 deg", "which compares a pure number with an angle"),
        ("ratio < wrong", "wrong is no known quantity"),
    ],
)
def test_constraints_that_cannot_be(text, message):
    with pytest.raises(InputError, match=rf"^study\.constraints\[0\]: given .*{message}") as caught:
        reasons(text)
    assert str(caught.value).endswith(".")


def test_relations_stand_behind_what_they_use():
    texts = {"a": "b + c", "b": "2 * c", "c": "ratio * pin_diameter", "d": "a"}
    units = UNITS | dict.fromkeys("abcd", "m")
    read = {name: read_expression(text, name, units) for name, text in texts.items()}
    order = evaluation_order(read)
    assert sorted(order) == sorted(texts)
    for name, expression in read.items():
        assert all(
            order.index(used) < order.index(name) for used in expression.names if used in texts
        )


@pytest.mark.parametrize("texts", [{"a": "b", "b": "2 * c", "c": "a"}, {"a": "2 * a"}])
def test_relations_that_go_round(texts):
    units = dict.fromkeys("abc", "m")
    read = {name: read_expression(text, name, units) for name, text in texts.items()}
    with pytest.raises(InputError, match=r"^study\.relations: given a circle \(.* -> .*\)"):
        evaluation_order(read)


def test_no_field_of_a_throw_is_a_unit():
    throw = CrankThrow(
        crank_radius=0.170,
        main_journal_diameter=0.220,
        pin_diameter=0.180,
        main_journal_length=0.120,
        pin_length=0.139,
        web_width=0.285,
        web_thickness=0.068,
        counterweight={"outer_radius": 0.25, "angle": 2.0},
        further_pins=({"angle": 2.0},),
    )
    assert not [path for path in throw_fields(throw) if is_unit(path)]
    assert is_unit("mm")
    assert is_unit("h")
    assert not is_unit("width_ratio")


def test_one_design_and_many_give_the_same():
    expression = read_expression("ratio * pin_diameter - 3 mm", "x", UNITS)
    many = evaluate_expression(expression, VALUES, UNITS, "m")
    for place in range(2):
        one = {name: column[place] for name, column in VALUES.items()}
        assert evaluate_expression(expression, one, UNITS, "m") == many[place]
    assert math.isclose(many[0], 0.267, rel_tol=1e-12)


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
    with pytest.raises(InputError, match=r"^study\.relations\.x: given "):
        value_of(text)


def test_whole_numbers_are_calculated_as_others():
    assert value_of("(9**3)**3 * (1/9)**9 * pin_diameter") == close(D, rel=1e-12)
