"""Quantities with units, angles, and numbers with separators."""

import math
import re
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import crankfem as cf
from comparing import close
from crankbase import quantity, written_quantity
from crankbase.array_checks import checked_degrees, refuse_crank_radians
from crankbase.errors import InputError
from crankbase.quantity import format_quantity
from crankbase.table import Column
from crankbase.units import NoUnitError, unit_quantity, unit_registry
from crankbase.written_quantity import PLAIN_SIZES, TURNING, parse_quantity, readings
from refusals import refused


@pytest.mark.parametrize("text", [f"{'m ' * 200}", "nm^40"])
def test_units_too_long_or_of_no_size_are_none(text):
    with pytest.raises(NoUnitError, match=r"too (long|small or large)"):
        unit_quantity(text)


def test_the_same_length_in_any_unit_is_the_same_number():
    assert {parse_quantity(text, "m", "field") for text in ("254 mm", "0.254 m", "10 in")} == {
        0.254
    }


@given(st.integers(1, 5000))
def test_millimetres_are_the_number_that_python_writes(number):
    # The same design from a file and from a program must be one design of a study.
    assert parse_quantity(f"{number} mm", "m", "field") == number / 1000


@pytest.mark.parametrize(
    ("text", "per_second"),
    [
        *((text, 500.0 / 60.0) for text in ("500 1/min", "500 rpm", "500 rev/min")),
        *((text, 8.0) for text in ("8 Hz", "8 1/s", "8 cycle/s")),
        ("30 deg/s", 30.0 / 360.0),
        ("100 gon/s", 0.25),
        ("5400 arcmin/s", 0.25),
    ],
)
def test_speed_of_rotation_counts_revolutions_unless_it_names_an_angle(text, per_second):
    assert parse_quantity(text, "rad/s", "speed") == close(2.0 * math.pi * per_second, rel=1e-14)


@pytest.mark.parametrize("text", ["52 rad/s", "52 radian/second"])
def test_angular_velocity_stays_itself(text):
    assert parse_quantity(text, "rad/s", "speed") == 52.0


@pytest.mark.parametrize("number", [170, 1.5, -3])
def test_bare_number_is_refused_with_what_to_write(number):
    with refused("throw.crank_radius") as caught:
        parse_quantity(number, "m", "throw.crank_radius")
    assert f'"{number} mm"' in str(caught.value)


def test_bare_number_as_text_is_refused_with_what_to_write():
    with pytest.raises(InputError, match=r"^field: given '170', .* like \"170 mm\"\.$"):
        parse_quantity("170", "m", "field")


@pytest.mark.parametrize(
    "text",
    [
        *("", "m", "mm", "170 xyz", "1 500 mm", "1,500 mm", "170,5 mm", "1_70 mm", "2*3 mm"),
        *("1/2 m", "170 mm + 3 mm", "nan m", "inf m", "1e400 m", "abs(3) mm"),
    ],
)
def test_text_that_could_be_read_two_ways_is_refused(text):
    with pytest.raises(InputError, match=r"^field: given "):
        parse_quantity(text, "m", "field")


@pytest.mark.parametrize("value", [True, None, ["170 mm"], {"a": 1}])
def test_other_types_are_refused(value):
    with refused("field"):
        parse_quantity(value, "m", "field")


def test_pure_numbers_take_no_unit():
    assert parse_quantity(0.3, "", "field") == 0.3
    assert parse_quantity(2, "", "field") == 2.0
    for wrong in ("0.3", True, None, math.nan, math.inf):
        with pytest.raises(InputError, match=r"^field: given "):
            parse_quantity(wrong, "", "field")


@given(st.floats(1e-3, 10.0))
def test_shown_lengths_read_back(length):
    assert parse_quantity(format_quantity(length, "m", 17), "m", "f") == close(length, rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        *("320 mm*10**99999999", "1 m**9**9**9", "1 h^99999999", "1 h⁹⁹⁹⁹⁹⁹⁹⁹"),
        *("1 (((((h^9)^9)^9)^9)^9)^9", "1 h squared squared squared squared squared squared"),
        *("5 mm^60/km^60/s", "5 km^80/nm^80/s", "1 " + "(" * 100 + "m"),
        "1 m" + " " * 100_000 + "x",
        "1" * 5000 + " mm",
        10**400,
        pytest.param(10**5000, id="thousands of digits"),
    ],
)
@pytest.mark.parametrize("unit", ["m", "rad/s"])
def test_no_text_takes_long_or_ends_unexpectedly(text, unit):
    with pytest.raises(InputError, match=r"^field: given ") as caught:
        parse_quantity(text, unit, "field")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("5 m²", "m^2", 5.0),
        ("5 kg·m²", "kg m^2", 5.0),
        ("5 kg m**2/(s^2 m)", "N", 5.0),
        ("5 (mm^2)^0.5", "m", 0.005),
        ("5 N/(mm)", "N/m", 5000.0),
        ("180 °", "rad", math.pi),
        ("5 m per s", "m/s", 5.0),
    ],
)
def test_ways_to_write_powers(text, unit, expected):
    assert parse_quantity(text, unit, "field") == close(expected, rel=1e-14)


def test_a_failure_of_the_library_is_not_told_as_the_users(monkeypatch):
    def fails(text):
        raise TypeError("of the library")

    monkeypatch.setattr(unit_registry(), "parse_units", fails)
    with pytest.raises(TypeError, match="of the library"):
        parse_quantity("7 ft2/in", "m", "field")


@pytest.mark.parametrize(("name", "unit"), [*PLAIN_SIZES, TURNING])
def test_what_is_known_without_pint_is_what_pint_says(monkeypatch, name, unit):
    known = parse_quantity(f"3.7 {name}", unit, "field")
    monkeypatch.setattr(written_quantity, "PLAIN_SIZES", {})
    monkeypatch.setattr(written_quantity, "TURNING", None)
    assert known == close(parse_quantity(f"3.7 {name}", unit, "field"), rel=1e-15)


TURN = 2.0 * np.pi


@pytest.mark.parametrize(
    "cranks",
    [
        *([0.0, 2.09, 4.19], [0, 3.14159, 3.14159, 0], [0, 2.094, 4.189, 4.189, 2.094, 0]),
        *([0.0, 1.57, 4.71, 3.14], [0.0, -2.09, 2.09]),
        *(np.radians(cranks) for cranks in ([0, 180], [0, 72, 144, 216, 288])),
        *(
            np.radians(cranks)
            for cranks in ([0, 240, 480, 120, 360, 600], [0, 30, 120, 150, 240, 270])
        ),
    ],
)
def test_cranks_in_radians_are_refused(cranks):
    with refused("crank_angles_deg"):
        refuse_crank_radians("crank_angles_deg", cranks)


@pytest.mark.parametrize(
    "cranks",
    [
        *([0.0], [0, 0, 0, 0], [0, 180, 180, 0], [0.0, 120.0, 240.0]),
        *([0.0, 10.0], [0.0, 12.5, 0.0, 12.5]),  # split pins
        *([1.0, 2.0, 3.0], [0.0, 0.3, 0.5], [0, 51.43, 102.86, 154.29, 205.71, 257.14, 308.57]),
    ],
)
def test_cranks_in_degrees_are_not_taken_for_radians(cranks):
    refuse_crank_radians("crank_angles_deg", cranks)


def test_layouts_in_radians_are_refused():
    rod = cf.ConnectingRod(0.265, 5.0, 0.097, 0.069)
    cylinders = [
        cf.EngineCylinder(0.13, 3.0, rod, crank_angle_deg=angle, position=0.1 * place)
        for place, angle in enumerate((0.0, 2.09, 4.19))
    ]
    with refused("crank_angle_deg"):
        cf.EngineLayout(0.07, cylinders, [1, 3, 2])


@pytest.mark.parametrize("length", [TURN, 2.0 * TURN])
@pytest.mark.parametrize("count", [8, 361, 720])
@pytest.mark.parametrize("closed", [False, True])
def test_even_radians_over_a_turn_are_refused(length, count, closed):
    for begin in (0.0, -0.5 * length):
        angles = begin + np.linspace(0.0, length, count, endpoint=closed)
        with refused("angles_deg"):
            checked_degrees("angles_deg", angles)


# How a number is written: separator of thousands and decimal mark.
WRITTEN = st.sampled_from(
    [(",", "."), (".", ","), (" ", ","), ("'", "."), ("\u202f", ","), ("", ",")]
)


@given(st.integers(0, 10**9), st.integers(0, 999), st.integers(0, 3), WRITTEN)
def test_what_is_meant_is_among_the_readings_and_no_digit_is_lost(whole, part, places, marks):
    thousands, point = marks
    fraction = f"{part:03d}"[:places]
    text = f"{whole:,}".replace(",", thousands) + (point + fraction if fraction else "")
    if text.isdigit() or text.replace(".", "", 1).isdigit():
        assert readings(f"{text} mm") == ()
        return
    meant = Decimal(f"{whole}.{fraction or 0}")
    found = [Decimal(one.removesuffix(" mm")) for one in readings(f"{text} mm")]
    assert meant in found
    # Every reading has the digits that were written, but zeros at the end of a fraction.
    digits = "".join(filter(str.isdigit, text)).strip("0")
    assert all("".join(filter(str.isdigit, str(one))).strip("0") == digits for one in found)
    assert (len(found) > 1) == (
        (text.count(",") + text.count(".") == 1) and len(text.replace(".", ",").split(",")[1]) == 3
        and len(text.replace(".", ",").split(",")[0]) <= 3 and not text.startswith("0")
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "suggested"),
    [
        ("82,5 mm", 'like "82.5 mm"'),
        ("1.200,5 mm", 'like "1200.5 mm"'),
        ("1,200 mm", 'like "1.2 mm" or "1200 mm"'),
        ("1 200 mm", 'like "1200 mm"'),
        ("1'200 mm", 'like "1200 mm"'),
        ("82,5", 'like "82.5 mm"'),
        ("17 0 mm", "one number"),
        ("Ø180 mm", 'write for example "180 mm"'),
        # Another sign than minus is not left out.
        ("\u20135 mm", 'write for example "(?!5 mm)'),
        ("1.4 mmm", "unit mmm; write it in mm"),
        ("66 %", "unit %; write it in mm"),
    ],
)
def test_suggestion_keeps_the_digits(text, suggested):
    with pytest.raises(InputError, match=suggested):
        parse_quantity(text, "m", "throw.crank_radius")


def test_zero_has_no_sign_and_round_off_is_zero():
    column = Column("amplitude", "um", 3)
    assert {column.text(amplitude) for amplitude in (0.0, -0.0, 7.9e-16, -7.9e-16)} == {"0"}
    assert column.text(7.9e-9) == "0.0079"
    for write in (
        lambda value: quantity.format_number(value, 3),
        quantity.compact,
        quantity.significant,
        lambda value: format_quantity(value, "N m"),
        lambda value: Column("share", "%").text(value),
    ):
        assert write(-0.0) == write(0.0)


@pytest.mark.parametrize(
    ("share", "written"),
    [(39.4, "3940"), (0.0, "0"), (0.5, "50"), (-0.0123, "-1.23"), (2e-12, "below 0.001")],
)
def test_a_share_has_no_exponent(share, written):
    assert quantity.percent(share, 3) == written
    assert Column("share", "%", 3).text(share) == written


@pytest.mark.parametrize(
    ("text", "limits", "suggested"),
    [
        ("1,200 mm", (0.01, 2.0), ["1200 mm"]),
        ("1,200 mm", (0.0001, 0.01), ["1.2 mm"]),
        ("1,200 mm", (0.0001, 2.0), ["1.2 mm", "1200 mm"]),
        ("165 Mm", (0.01, 2.0), ["165 mm"]),
        ("165 Mm", (0.01, 0.1), []),
        ("165 MM", (0.01, 2.0), ["165 mm"]),
    ],
)
def test_what_is_suggested_lies_in_the_range(text, limits, suggested):
    with pytest.raises(InputError) as caught:
        parse_quantity(text, "m", "f", limits=limits)
    assert re.findall(r'"([^"]+)"', str(caught.value)) == suggested


@pytest.mark.parametrize("given", ["+5,N'%4", "847,e+8Å4*"])
def test_what_is_no_number_behind_a_comma_is_refused(given):
    with refused("f"):
        parse_quantity(given, "m", "f")
