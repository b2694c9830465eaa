"""Factors: levels over ranges, choices, and the fields of a throw by their paths.

Chebyshev levels are compared with the extremes of the polynomial itself: cos(i pi / (n - 1)).
"""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from geometry.throw import CrankThrow
from regression.plans.factors import (
    Factor,
    changed_record,
    field_value,
    rounded,
    throw_fields,
    unknown_field,
)

PLAIN = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "pin_length": 0.139,
    "web_width": 0.285,
    "web_thickness": 0.068,
}
THROW = CrankThrow(**PLAIN)
RICH = CrankThrow(
    **PLAIN,
    counterweight={"outer_radius": 0.25, "angle": 2.0},
    further_pins=({"angle": 2.0, "web_thickness": 0.06},),
)


@pytest.mark.parametrize(
    ("spacing", "levels"),
    [
        ("even", (0.038, 0.058, 0.078, 0.098)),
        ("chebyshev", (0.038, 0.053, 0.083, 0.098)),
        ("log", tuple(0.038 * (0.098 / 0.038) ** (i / 3) for i in range(4))),
        (
            "log chebyshev",
            tuple(
                math.sqrt(0.038 * 0.098) * (0.098 / 0.038) ** (-0.5 * math.cos(math.pi * i / 3))
                for i in range(4)
            ),
        ),
    ],
)
def test_levels_spread_over_a_range(spacing, levels):
    factor = Factor.spread("web_thickness", "m", 0.038, 0.098, 4, spacing)
    assert factor.levels == close(levels, rel=1e-11)  # rounded to 12 digits
    assert factor.levels[0] == 0.038
    assert factor.levels[-1] == 0.098


def test_the_middle_of_a_range_is_what_one_would_write():
    assert Factor.spread("pin_length", "m", 0.120, 0.158, 3, "even").levels[1] == 0.139
    assert rounded(3 * 0.1) == 0.3
    assert 3 * 0.1 != 0.3
    assert rounded(0.0) == 0.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Factor("a", "m", 0.2, 0.1), "given the range 200 mm to 100 mm; the lowest"),
        (lambda: Factor("a", "m", 0.1, math.inf), r"given \(0\.1, inf\); allowed are finite"),
        (lambda: Factor.of_levels("a", "m", ()), "given no level; allowed are two or more"),
        (lambda: Factor.of_levels("a", "m", (0.1,)), "given 1 level; allowed are two"),
        (lambda: Factor.of_levels("a", "m", (0.1, 0.1)), "given 1 level; allowed are two"),
        (lambda: Factor.of_levels("a", "m", (0.1, 0.2, 0.1)), "given 100 mm, 200 mm, 100 mm; each"),
        (
            lambda: Factor("a", "m", 0.1, 0.2, (0.1, 0.3)),
            "given levels 100 mm, 300 mm; allowed are",
        ),
        (lambda: Factor.of_labels("a", ("x",)), "given x; allowed are two or more different"),
        (lambda: Factor.of_labels("a", ("x", "y", "x")), "given x, y, x; allowed is each choice"),
        (
            lambda: Factor.spread("a", "m", 0.1, 0.2, 1, "even"),
            "given 1; allowed is a whole number",
        ),
        (lambda: Factor.spread("a", "m", 0.1, 0.2, 3, "odd"), "given 'odd'; allowed are even, log"),
        (lambda: Factor.spread("a", "m", 0.0, 0.2, 3, "log"), "given 0 mm; allowed is more than 0"),
        (lambda: Factor.spread("a", "m", 0.2, 0.2, 3, "log"), "given the range 200 mm to 200 mm"),
    ],
)
def test_factors_that_cannot_be(make, message):
    with pytest.raises(InputError, match=rf"^study\.factors\.a[a-z.]*: {message}") as caught:
        make()
    assert str(caught.value).endswith(".")


def test_choices_are_counted():
    factor = Factor.of_labels("web_outline", ("obround", "rectangle"))
    assert factor.categorical
    assert (factor.lowest, factor.highest, factor.levels) == (0.0, 1.0, (0.0, 1.0))
    assert factor.format_value(1.0) == "rectangle"
    assert not Factor("web_width", "m", 0.1, 0.2).categorical


def test_fields_of_a_throw():
    fields = throw_fields(RICH)
    assert fields["web_width"].unit == "m"
    assert fields["web_outline"].choices == ("obround", "rectangle")
    assert fields["counterweight.angle"].unit == "rad"
    assert fields["further_pins.0.length"].unit == "m"
    assert fields["left_web.outline"].choices == ("obround", "rectangle")
    assert "left_web.counterweight.angle" not in fields
    assert "further_pins.1.length" not in fields
    plain = throw_fields(THROW)
    assert "counterweight.angle" not in plain
    assert "left_web.width" in plain
    assert all(field.unit in ("m", "rad") or field.choices for field in fields.values())


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("web_with", "did you mean web_width? "),
        ("counterweight.angle", "the throw has no counterweight to vary; give it in [throw]"),
        ("left_web.counterweight.angle", "the throw has no left_web.counterweight to vary"),
        ("further_pins.0.length", "the throw has no further_pins to vary"),
        ("nonsense.angle", "allowed are crank_radius, "),
    ],
)
def test_unknown_fields(path, message):
    assert unknown_field(path, throw_fields(THROW), THROW).startswith(message)


def test_values_at_paths():
    record = RICH.model_dump(mode="json")
    before = RICH.model_dump(mode="json")
    changed = changed_record(
        record,
        {
            "web_width": 0.3,
            "counterweight.angle": 1.5,
            "further_pins.0.web_thickness": 0.05,
            "left_web.width": 0.31,
        },
    )
    assert record == before
    throw = CrankThrow(**changed)
    assert throw.web_width == 0.3
    assert throw.counterweight.angle == 1.5
    assert throw.further_pins[0].web_thickness == 0.05
    assert throw.left_web.width == 0.31
    assert throw.right_web is None
    assert field_value(changed, "further_pins.0.web_thickness") == 0.05
    assert field_value(changed, "right_web.width") is None
    assert field_value(changed, "web_outline") == "obround"
    for path in throw_fields(throw):
        assert np.isscalar(field_value(changed, path)) or field_value(changed, path) is None
