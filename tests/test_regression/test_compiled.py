"""Compiled expressions beside pint's own calculation, which they replace (1e-12, rounding)."""

import numpy as np
import pytest

from comparing import close
from regression.plans.relations import (
    compile_constraint,
    compile_expression,
    constraint_violations,
    evaluate_expression,
    read_constraint,
    read_expression,
)

UNITS = {"a": "m", "b": "m", "x": "", "angle": "rad"}
VALUES = {
    name: np.random.default_rng(place).uniform(0.2, 2.0, 5) for place, name in enumerate(UNITS)
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
    read = read_expression(text, "f", UNITS)
    expected = evaluate_expression(read, VALUES, UNITS, unit)
    value = compile_expression(read)
    assert value(VALUES) == close(expected, rel=1e-12)
    for place in range(5):
        one = {name: float(column[place]) for name, column in VALUES.items()}
        assert value(one) == close(expected[place], rel=1e-12)


@pytest.mark.parametrize("text", ["1 / (a - a) * b", "(x - 3) ** 0.5", "x ** (x * 1e6)"])
def test_what_has_no_value_is_not_finite(text):
    value = compile_expression(read_expression(text, "f", UNITS))
    one = dict.fromkeys(UNITS, 1.5)
    assert not np.isfinite(value(one))
    with np.errstate(all="ignore"):
        assert not np.isfinite(value({name: np.array([1.5]) for name in UNITS})).any()


@pytest.mark.parametrize("text", ["a >= 0.7 * b", "0.5 < x <= a / b", "a > a", "a >= a * 1.0"])
def test_constraints_hold_where_designs_keep_them(text):
    read = read_constraint(text, "f", UNITS)
    kept = [reason is None for reason in constraint_violations(read, VALUES, UNITS, 5)]
    holds = compile_constraint(read)
    assert np.broadcast_to(holds(VALUES), 5).tolist() == kept
    ones = [{name: float(column[place]) for name, column in VALUES.items()} for place in range(5)]
    assert [bool(holds(one)) for one in ones] == kept
