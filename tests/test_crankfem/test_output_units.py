"""Units on output and on input: what is printed in other units is the SI record, converted.

Expected sizes are the definitions: an inch is 25.4 mm, a pound 0.45359237 kg, the standard gravity
9.80665 m/s^2. Printed numbers have four digits or more, hence relative tolerances of 1e-3.
"""

import math
import re

import pytest

from comparing import close
from crankbase.errors import InputError
from crankbase.tables.output_units import SI, UNITS, parse_output_units
from crankbase.units.quantity import parse_quantity, unit_registry

INCH, POUND = 0.0254, 0.45359237
FORCE = POUND * 9.80665
KSI = 1e3 * FORCE / INCH**2


@pytest.mark.parametrize(
    ("printed", "name", "size"),
    [
        ("mm", "in", INCH),
        ("um", "in", INCH),
        ("kN", "lbf", FORCE),
        ("kN m", "lbf in", FORCE * INCH),
        ("MPa", "ksi", KSI),
        ("kg", "lb", POUND),
        ("kg m^2", "lb in^2", POUND * INCH**2),
        ("dm^3", "in^3", INCH**3),
        ("1e-9 m/N", "1e-9 in/lbf", 1e-9 * INCH / FORCE),
        ("1e-9 rad/(N m)", "1e-9 rad/(lbf in)", 1e-9 / (FORCE * INCH)),
        ("N s/m", "lbf s/in", FORCE / INCH),
        ("1/min", "1/min", 2.0 * math.pi / 60.0),
        ("Hz", "Hz", 1.0),
    ],
)
def test_imperial_units(printed, name, size):
    unit = parse_output_units("imperial").of(printed)
    assert unit.name == name
    assert unit.size == close(size, rel=1e-12)


@pytest.mark.parametrize("name", UNITS)
def test_sizes_of_printed_units_are_those_of_pint(name):
    unit, size = UNITS[name]
    # Turns per minute: engineers do not write the turn.
    registry, said = unit_registry(), name.replace("1/min", "turn/min")
    one = registry.Quantity(1.0, registry.parse_units(said)).to(registry.parse_units(unit))
    assert size == close(one.magnitude, rel=1e-12)  # both are factors, but for round-off


def test_without_a_wish_everything_stays_in_si():
    for text in (None, "SI", "si", ""):
        units = parse_output_units(text)
        assert units == SI
        assert all(units.of(name).name == name and not units.of(name).wished for name in UNITS)
    assert SI.quantity(1.27e-9, "m/N", 4) == "1.27e-9 m/N"
    assert SI.of("um").number(None) == "unbounded"
    assert SI.text("280 mm") == "280 mm"


def test_what_a_wish_does_not_fit_stays():
    units = parse_output_units("rpm, deg, J")
    assert units.of("1/min").name == "rpm"
    assert units.of("mrad").name == "deg"
    # A speed is no angle, torque no energy, a frequency no speed.
    assert [units.of(name).name for name in ("kN m", "Hz", "mm")] == ["kN m", "Hz", "mm"]
    assert parse_output_units("deg").of("1/min").name == "1/min"
    assert parse_output_units("lbf ft").of("kN m").name == "lbf ft"
    assert parse_output_units("lbf ft").of("mm").name == "mm"


def test_large_numbers_have_no_exponent():
    unit = parse_output_units("in, lbf").of("kN m")
    assert unit.number(30730.0) == "272000"


def test_decimals_are_as_fine_as_in_si_at_least():
    units = parse_output_units("in, lbf, rpm")
    # A tenth of a kN m is 885 lbf in, a newton 0.2 lbf; what is round-off stays zero.
    assert units.of("kN m").fixed(30730.0, 1) == "271983"
    assert units.of("kN").fixed(50e3, 3) == "11240.4"
    assert units.of("kN m").fixed(-6e-12, 3) == "0"
    assert units.of("1/min").fixed(10.0 * math.pi, 1) == "300.0"


def test_quantities_in_sentences():
    units = parse_output_units("imperial")
    said = "web_width: given 340 mm; the range is 270 to 330 mm, at 515 1/min and 12 kN m, 1.27e-9 m/N."
    assert units.text(said) == (
        "web_width: given 13.4 in; the range is 10.6 to 13 in, at 515 1/min and 106000 lbf in, "
        "2.22e-07 in/lbf."
    )
    # One unit behind a list is that of all its numbers.
    units = parse_output_units("in, rad")
    for said, converted in (
        ("uneven intervals of 60, 90, 120 deg.", "uneven intervals of 1.05, 1.57, 2.09 rad."),
        ("between 5 and 10 mm", "between 0.197 and 0.394 in"),
        ("10, 20, or 30.00 mm", "0.394, 0.787, or 1.181 in"),
        ("254 x 508 x 1016 mm", "10 x 20 x 40 in"),
        ("-5 to 5 mm", "-0.197 to 0.197 in"),
        ("a 10 mm web, 20 mm pin", "a 0.394 in web, 0.787 in pin"),
        ("2 or more, 10 mm", "2 or more, 0.394 in"),
    ):
        assert units.text(said) == converted
    # Names and pure numbers are no quantities.
    for text in ("6ChN 25/34", "mode 2 makes 3", "8 minutes", "2 mmm"):
        assert units.text(text) == text


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("parsek", "given 'parsek', which is no unit; allowed are units with commas between"),
        ("in, mm", "given 'in' and 'mm', which are units of one kind"),
        ("in,, lbf", "given '', which is no unit"),
        ("ohm", "given 'ohm', of a kind that is never printed"),
        ("degC", "given 'degC', of a kind that is never printed"),
        ("1e3 in", "given '1e3 in', which is no unit"),
    ],
)
def test_refused_units(text, fragment):
    with pytest.raises(InputError, match=re.escape(fragment)):
        parse_output_units(text)


@pytest.mark.parametrize("option", [(), ("--json",)])
def test_a_wrong_unit_is_told_before_anything_is_computed(call, option):
    for command in ("throw", "stress", "mechanism", "harmonics", "vibration", "run", "check"):
        answer = call(command, "6chn25-34", "--units", "in, thou", *option)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith("Error: --units: given 'in' and 'thou'")


def test_a_command_prints_its_record_in_other_units(call):
    arguments = ("mechanism", "6chn25-34")
    record = call(*arguments, "--json").json()
    assert call(*arguments, "--json", "--units", "imperial").json() == record
    out = call(*arguments, "--units", "in, lbf, ksi").out
    torque = float(re.search(r"torque (\d+) lbf in", out)[1])
    assert torque * FORCE * INCH == close(record["torque"]["mean"], rel=1e-3)
    row = next(line for line in out.splitlines() if line.startswith("│ 1 to 6")).split("│")
    assert float(row[2]) * KSI == close(record["cylinders"][0]["peak_pressure"], rel=1e-3)
    assert float(row[5]) * FORCE == close(record["cylinders"][0]["largest_side_force"], rel=1e-3)
    assert not re.search(r"\b(kN|MPa|mm)\b", out)


@pytest.mark.parametrize(
    "arguments",
    [
        ("harmonics", "8chn26-26", "--cylinder", "1"),
        pytest.param(("hinge",), marks=pytest.mark.slow),
        ("check", "6chn25-34"),
        ("formulas", "6chn25-34", "--no-fe"),
    ],
)
def test_no_si_unit_of_length_force_or_stress_is_left(call, arguments):
    answer = call(*arguments, "--units", "imperial")
    assert answer.code == 0
    out = answer.out.partition("Inputs")[0]  # inputs stand as they were given
    found = re.findall(r"\d (?:mm|kN|kN m|N m|MPa|m/N)\b|\[(?:mm|kN|kN m|N m|MPa|1e-9 m/N)\]", out)
    assert found == []
    assert re.search(r"\b(in|lbf|ksi)\b", out)


def test_lookup_in_other_units(call, model_file):
    pairs = ("web_width=11.8in", "web_thickness=2677.165 thou")
    value = call("lookup", model_file, *pairs, "--json").json()["axial_compliance"]["value"]
    out = call("lookup", model_file, *pairs, "--units", "in, lbf").out
    shown = float(re.search(r"axial compliance: ([\d.]+)e-9 in/lbf", out)[1])
    assert shown * 1e-9 * INCH / FORCE == close(value, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 inch", "m", 10.0 * INCH),
        ("10 in", "m", 10.0 * INCH),
        ("500 thou", "m", 0.5 * INCH),
        ("1000 psi", "Pa", KSI),
        ("12 lbf", "N", 12.0 * FORCE),
        ("12 lbf in", "N m", 12.0 * FORCE * INCH),
        ("30 deg", "rad", math.pi / 6.0),
        ("60 turn/min", "rad/s", 2.0 * math.pi),
        ("60 rpm", "rad/s", 2.0 * math.pi),
        ("2 lb", "kg", 2.0 * POUND),
        ("3 furlong", "m", 3.0 * 7920.0 * INCH),
    ],
)
def test_units_on_input(text, unit, value):
    # The furlong is that of the survey foot in some tables, two parts in a million longer.
    assert parse_quantity(text, unit, "field") == close(value, rel=3e-6)


def test_units_in_a_file(call, tmp_path, six_cylinders):
    text = six_cylinders.replace('"170 mm"', '"6.692913386 inch"').replace(
        '"8.5 MPa"', '"1232.8 psi"'
    )
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    checked = call("check", "mine.toml", "--json").json()
    found = {one["name"]: one["value"] for one in checked["dimensions"]}
    assert found["crank_radius"] == close(0.170, rel=1e-9)
    (tmp_path / "mine.toml").write_text(text.replace(" inch", " psi"), encoding="utf-8")
    answer = call("check", "mine.toml")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(
        "Error: throw.crank_radius: given '6.692913386 psi', which is no length"
    )
    assert answer.err.count("\n") == 1
