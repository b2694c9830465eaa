"""Warnings of sizes far outside of practice and of uneven firing, none of which is refused."""

import itertools
import math
import re

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import input_warnings, load_any
from crankfem.analyses.file_check import check_file
from crankfem.files.engine import usual_parts, usual_sizes
from crankfem.files.engine.mechanism_cylinders import (
    FiringEvenness,
    firing_evenness,
    firing_sentence,
)
from crankfem.files.engine.throw_file import ThrowFile
from crankfem.files.engine.usual_parts import EngineScale, pressure_warnings
from crankfem.files.engine.usual_sizes import UsualRange, throw_warnings
from crankfem.files.reading.data_files import data_folder, input_path, shipped_names
from crankfem.files.sections.engine_sections import Engine
from dynamics.gas.pressure import gas_pressure
from dynamics.harmonics import read_torque_table


def sentences(warnings):
    return [warning.sentence for warning in warnings]


@pytest.fixture(scope="module")
def shipped():
    """All shipped engine files with a mechanism, read."""
    files = [load_any(name) for name in shipped_names("engine")]
    return [file for file in files if not isinstance(file, ThrowFile)]


def test_no_shipped_engine_is_warned_of(shipped):
    for file in shipped:
        assert input_warnings(file) == (), file.path
    for name in shipped_names("engine"):
        if isinstance(file := load_any(name), ThrowFile):
            assert not list(throw_warnings(file.throws)), name


def outwards(low, high):
    """Two digits, rounded away from the middle."""
    size = [10.0 ** (math.floor(math.log10(one)) - 1) for one in (low, high)]
    return math.floor(low / size[0]) * size[0], math.ceil(high / size[1]) * size[1]


def throws_in(name):
    """The different throws of a shipped engine."""
    file = load_any(name)
    return {
        throw.model_dump_json(): throw for throw in getattr(file, "crank_throws", (file.throw,))
    }.values()


def test_usual_ranges_are_those_of_the_shipped_engines(shipped):
    values = {}

    def add(name, value):
        values.setdefault(name, []).append(value)

    for file in shipped:
        cylinder, throw = file.layout.cylinders[0], file.throw
        bore, stroke = cylinder.bore, 2.0 * throw.crank_radius
        swept = 1e3 * 0.25 * math.pi * bore**2 * stroke
        add("STROKE", stroke / bore)
        add("JOURNAL", throw.main_journal_diameter / bore)
        add("PITCH", throw.length / bore)
        add("ROD_LENGTH", cylinder.rod.length / throw.crank_radius)
        add("PISTON_MASS", cylinder.piston_mass / swept)
        add("ROD_MASS", cylinder.rod.mass / swept)
        add("PISTON_SPEED", 2.0 * stroke * file.engine.rated_speed / (2.0 * math.pi))
        if file.power is not None:
            add("INDICATED", file.power.mean_indicated_pressure / 1e6)
        if file.whole:
            add("HIGHEST_PISTON_SPEED", 2.0 * stroke * file.engine.highest_speed / (2.0 * math.pi))
            add("FLYWHEEL", math.sqrt(file.flywheel.inertia / file.flywheel.mass) / bore)
            stiffness = file.thrust_bearing.stiffness / throw.main_journal_diameter
            add("THRUST", stiffness / 1e9)
            if (end := file.free_end) is not None:
                diameter = throw.main_journal_diameter
                disk = 7850.0 * math.pi / 32.0 * (2.0 * diameter) ** 4 * 0.5 * diameter
                add("FREE_END", end.inertia / disk)
    for throw in (throw for name in shipped_names("engine") for throw in throws_in(name)):
        for radius in (
            throw.pin_fillet_radius,
            throw.main_journal_fillet_radius,
            throw.fillet_radius,
        ):
            if radius:
                add("FILLET", radius / throw.main_journal_diameter)
        for web in (throw, throw.left_web, throw.right_web):
            if (weight := getattr(web, "counterweight", None)) is not None:
                add("WEIGHT_ANGLE", math.degrees(weight.angle))
    ranges = {n: one for n, one in vars(usual_sizes).items() if isinstance(one, UsualRange)}
    ranges = {n: one for n, one in ranges.items() if one.basis == usual_sizes.SHIPPED}
    assert ranges.keys() == values.keys()
    for name, found in values.items():
        usual = ranges[name]
        assert (usual.low, usual.high) == close(outwards(min(found), max(found))), name


# What a value is taken for; fields, unit behind the number, and factor or summand [Pa]. All of these are
# sizes of the shipped engines, each of which has such a field.
MISREADINGS = {
    "GD2 for the inertia": (r"\w*inertia", "kg m.2", 4.0, 0.0),
    "inertia for GD2": (r"\w*inertia", "kg m.2", 0.25, 0.0),
    "per degree for per radian": ("coupling_stiffness", "k?N m/rad", math.radians(1.0), 0.0),
    "per radian for per degree": ("coupling_stiffness", "k?N m/rad", math.degrees(1.0), 0.0),
    "half the angle of a counterweight": ("angle", "deg", 0.5, 0.0),
    "fillet's diameter for radius": (r"\w*fillet_radius", "mm", 2.0, 0.0),
    "fillet's radius for diameter": (r"\w*fillet_radius", "mm", 0.5, 0.0),
    "pressure above ambient": (r"(?:intake|exhaust)_pressure", "bar", 1.0, -1.01325),
}
COUNTS = dict(zip(MISREADINGS, (32, 32, 2, 2, 10, 18, 18, 2), strict=True))


def misread(text, fields, unit, factor, summand):
    """Yield a file's text with one value misread, and the value's field."""
    value = re.compile(rf'^({fields}) = (?:\{{ value = )?"([\d.e+-]+) (?:{unit})"', re.MULTILINE)
    for match in value.finditer(text.partition("\n[sources]")[0]):
        start, end = match.span(2)
        changed = factor * float(match[2]) + summand
        if match[1] == "angle" and "counterweight]" not in text[text.rfind("\n[", 0, start) :][:40]:
            continue
        if float(match[2]):
            yield match[1], f"{text[:start]}{changed:.12g}{text[end:]}"


@pytest.mark.further
@pytest.mark.parametrize("kind", MISREADINGS)
def test_every_misreading_of_the_shipped_engines_is_named(tmp_path, kind):
    for folder in ("tables", "chains"):
        for path in (data_folder() / folder).iterdir():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    silent, count = [], 0
    for name in shipped_names("engine"):
        for field, text in misread(input_path(name).read_text("utf-8"), *MISREADINGS[kind]):
            (tmp_path / "mine.toml").write_text(text, "utf-8")
            count += 1
            try:
                warnings = check_file(str(tmp_path / "mine.toml")).warnings
            except InputError:
                continue
            if not any(f".{field}: " in warning and "perhaps" in warning for warning in warnings):
                silent.append((name, field))
    assert not silent
    assert count == COUNTS[kind]


GD2_FIELDS = {
    "flywheel.inertia": "flywheel.flywheel_effect",
    "driven.inertia": "driven.flywheel_effect",
    "torsional_damper.ring_inertia": "torsional_damper.ring_flywheel_effect",
    "free_end.inertia": "free_end.flywheel_effect",
}


@pytest.mark.parametrize("unit", ["kg m^2", "kgf m2", "kp m^2"])
@pytest.mark.parametrize("field", GD2_FIELDS)
def test_gd2_takes_the_place_of_any_inertia(tmp_path, edit, field, unit):
    """GD2 is four times the inertia; as a weight in kgf it has the number that it has as a mass in kg."""
    text = input_path("6chn18-22-set").read_text("utf-8")
    section, name = field.split(".")
    inertia = getattr(getattr(load_any("6chn18-22-set"), section), name)
    given = f'{{ value = "{4.0 * inertia:g} {unit}", source = "data sheet 7" }}'
    changed = edit(text, {field: None, GD2_FIELDS[field]: given})
    (tmp_path / "mine.toml").write_text(changed, "utf-8")
    read = load_any(tmp_path / "mine.toml")
    assert getattr(getattr(read, section), name) == close(inertia, rel=1e-15)
    (record,) = (record for record in read.records if record.field == field)
    assert record.source == "data sheet 7"
    assert record.given.startswith(f"{4.0 * inertia:g} {unit}")
    assert input_warnings(read) == ()


@pytest.mark.parametrize(
    ("name", "pressure"),
    # What the cycle of each assumes, less an atmosphere.
    [("vw-tdi", 0.1506), ("8chn13-14", 0.0913), ("8chn26-26", 0.1622), ("cat-3116", 0.1317)],
)
def test_an_intake_pressure_above_ambient_is_named(tmp_path, edit, name, pressure):
    text = input_path(name).read_text("utf-8")
    for shift, said in ((0.0, True), (0.101325, False)):
        given = f'"{pressure + shift:.6f} MPa"'
        (tmp_path / "mine.toml").write_text(edit(text, {"gas.intake_pressure": given}), "utf-8")
        warnings = check_file(str(tmp_path / "mine.toml")).warnings
        assert any(one.startswith("gas.intake_pressure: ") for one in warnings) == said


def test_a_throw_alone_and_by_name(call, tmp_path):
    text = input_path("2ch85-110").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace('"24 mm"', '"60 mm"', 1), encoding="utf-8")
    answer = call("check", "mine.toml", "--json")
    assert all(one.startswith("throw.") for one in answer.json()["warnings"])
    throw = load_any("6chn25-34").throw.changed(main_journal_length=0.5)
    (warning,) = sentences(throw_warnings({"a": throw}))
    assert warning.startswith("throws.a.main_journal_length: given 500 mm")


@pytest.mark.parametrize(
    ("command", "computes"),
    [
        ("mechanism", "analyses.mechanism.mechanism_run.run_mechanism"),
        ("vibration", "analyses.vibration.run.engine_vibration"),
        ("run", "jobs.pipeline._compute"),
    ],
)
def test_warnings_come_before_anything_is_computed(
    call, tmp_path, monkeypatch, six_cylinders, edit, command, computes
):
    def stopped(*_, **__):
        raise InputError("Stopped.")

    text = edit(six_cylinders, {"piston.mass": '"300 kg"'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(f"crankfem.{computes}", stopped)
    answer = call(command, "mine.toml", "--quiet")
    assert answer.err.startswith("Warning: piston.mass: given 300 kg")
    assert answer.err.endswith("Error: Stopped.\n")


def three_cylinders(**changes):
    given = {
        "name": "three",
        "cylinders": 3,
        "strokes": 4,
        "bore": 0.08,
        "stroke": 0.1,
        "rated_speed": 300.0,
        "lowest_speed": 100.0,
        "highest_speed": 310.0,
        "crank_angles": tuple(math.radians(angle) for angle in (0.0, 120.0, 240.0)),
        "firing_order": (1, 3, 2),
    }
    return Engine(**(given | changes))


def test_an_order_that_fits_both_senses_turns_so_that_it_fires_evenly():
    engine = three_cylinders()
    assert sorted(np.rad2deg(engine.firing_angles)) == close([0.0, 240.0, 480.0])
    assert firing_evenness(engine) == FiringEvenness()


def test_uneven_firing_is_told():
    angles = tuple(math.radians(angle) for angle in (0.0, 90.0, 240.0))
    (warning,) = sentences(firing_evenness(three_cylinders(crank_angles=angles)).warnings)
    assert "240, 210, 270 deg" in warning


def test_an_even_order_is_proposed():
    """Five cranks 72 deg apart: every second one must follow for 144 deg between firings."""
    angles = tuple(math.radians(angle) for angle in (0.0, 288.0, 216.0, 144.0, 72.0))
    engine = three_cylinders(cylinders=5, crank_angles=angles, firing_order=(1, 2, 3, 4, 5))
    (warning,) = sentences(firing_evenness(engine).warnings)
    assert all(said in warning for said in ("72, 72, 72, 72, 432 deg", "1-3-5-2-4", "144 deg"))
    assert firing_evenness(engine.changed(firing_order=(1, 3, 5, 2, 4))) == FiringEvenness()


@pytest.mark.parametrize(
    ("cranks", "given", "warned"),
    [
        # Three common pins at 90 deg between banks; 120 and 240 deg exchanged is a slip.
        ((0.0, 240.0, 120.0), "90, 150 deg in turn", False),
        ((0.0, 120.0, 240.0), "90, 30, 90, 30, 90, 390 deg", True),
    ],
)
def test_the_least_uneven_order_is_proposed(cranks, given, warned):
    bank = math.radians(45.0)
    engine = three_cylinders(
        cylinders=6,
        crank_angles=tuple(map(math.radians, (*cranks, *cranks))),
        bank_angles=(bank,) * 3 + (-bank,) * 3,
        firing_order=(1, 4, 2, 5, 3, 6),
    )
    found = firing_evenness(engine)
    assert bool(found.warnings) == warned
    (said,) = sentences((*found.warnings, *found.notes))
    assert given in said
    assert given in firing_sentence(engine)
    if not warned:
        return
    order = tuple(
        map(int, re.search(r"such as ([\d-]+) at 90, 150 deg in turn", said)[1].split("-"))
    )
    # The order proposed fires so, and no other one differs less between its intervals.
    spreads = {}
    for other in itertools.permutations(range(2, 7)):
        try:
            steps = engine.changed(firing_order=(1, *other)).firing_intervals_deg
        except ValueError:
            continue
        spreads[1, *other] = max(steps) - min(steps)
    assert sorted(engine.changed(firing_order=order).firing_intervals_deg) == close(
        [90.0] * 3 + [150.0] * 3
    )
    assert min(spreads.values()) == close(60.0)


def test_cylinders_alone_at_the_top_are_named():
    angles = tuple(math.radians(angle) for angle in (0.0, 120.0, 240.0, 240.0, 110.0, 0.0))
    engine = three_cylinders(cylinders=6, crank_angles=angles, firing_order=(1, 5, 3, 6, 2, 4))
    (warning,) = sentences(firing_evenness(engine).warnings)
    assert "cylinders 2, 5" in warning


@pytest.mark.parametrize(
    ("cylinders", "angles", "banks"),
    [(2, (0.0, 180.0), None), (2, (0.0, 0.0), (-22.5, 22.5))],
    ids=["two in line", "V-twin"],
)
def test_engines_built_uneven_get_a_note(cylinders, angles, banks):
    engine = three_cylinders(
        cylinders=cylinders,
        crank_angles=tuple(map(math.radians, angles)),
        bank_angles=banks and tuple(map(math.radians, banks)),
        firing_order=(1, 2),
    )
    found = firing_evenness(engine)
    assert (len(found.warnings), len(found.notes)) == (0, 1)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("throw.web_thickness", '"68 m"'),
        ("material.youngs_modulus", '"210 MPa"'),
        ("engine.bore", '"2500 mm"'),
        ("engine.bore", '"3 m"'),
        ("engine.bore", '"2500 m"'),
        ("engine.bore", '"900 m"'),
        ("engine.bore", '"0.25 mm"'),
        ("throw.web_thickness", '"68,5 mm"'),
        ("engine.stroke", '"430 mm"'),
        ("engine.strokes", '"4"'),
        ("engine.firing_order", "[1, 2, 3, 4, 5, 6]"),
    ],
)
def test_a_sentence_names_cause_and_line(call, tmp_path, six_cylinders, edit, field, value):
    text = edit(six_cylinders, {field: value})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    answer = call("check", "mine.toml")
    assert answer.code == 2
    field = "throw.crank_radius" if field == "engine.stroke" else field
    assert answer.err.startswith(f"Error: {field}: given")
    line = int(answer.err.rpartition("(mine.toml, line ")[2].removesuffix(").\n"))
    assert text.splitlines()[line - 1].startswith(field.partition(".")[2])


def test_a_file_without_the_usual_ending_is_read(call, tmp_path, six_cylinders):
    (tmp_path / "двигатель").write_text(six_cylinders.replace("\n", "\r\n"), encoding="utf-8-sig")
    assert call("check", "двигатель").code == 0


def test_a_rated_power_that_does_not_fit_is_a_warning(call, tmp_path, six_cylinders, edit):
    text = edit(six_cylinders, {"engine.rated_power": '"6 MW"'})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    record = call("check", "mine.toml", "--json").json()
    (warning,) = record["warnings"]
    assert warning.startswith("engine.rated_power: ")


def test_speeds_in_radians_with_the_unit_of_turns_are_told(tmp_path, six_cylinders, edit):
    speeds = {"lowest_speed": 20.94, "rated_speed": 52.36, "highest_speed": 53.93}
    text = edit(six_cylinders, {f"engine.{name}": f'"{n} 1/min"' for name, n in speeds.items()})
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    warnings = input_warnings(load_any(tmp_path / "mine.toml"))
    assert any(one.startswith("engine.rated_speed: ") for one in warnings), warnings


# Fields and values that cannot be meant, on the generating set of 6ChN 18/22.
PARTS = [
    ("limits.crankshaft_stress", '"300 MPa"'),
    ("torsional_damper.ring_inertia", '"12000 kg m^2"'),
    ("torsional_damper.damping", '"4.36 N m s/rad"'),
    ("driven.coupling_stiffness", '"2 N m/rad"'),
    ("driven.coupling_loss_factor", "16.0e-5"),
    ("free_end.inertia", '"2000 kg m^2"'),
    ("damping.torsional_magnifier", "4.0"),
    ("bearings.stiffness", '"2e12 N/m"'),
    ("bearings.stiffness", '"2e6 N/m"'),
    ("rod.rotating_mass", '"1 kg"'),
    ("material.poisson_ratio", "0.03"),
    ("limits.generator_angle", '"0.0035 deg"'),
    ("shaft_ends.flange_thickness", '"0.35 mm"'),
]


@pytest.mark.parametrize(("field", "value"), PARTS)
def test_a_part_that_cannot_be_meant_is_warned_of(tmp_path, edit, field, value):
    text = edit(input_path("6chn18-22-set").read_text("utf-8"), {"limits.crankshaft_rule": None})
    section, _, name = field.rpartition(".")
    if f"[{section}]" in text:
        text = edit(text, {field: value})
    else:
        text += f"\n[{section}]\n{name} = {value}\n"
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    warnings = input_warnings(load_any(tmp_path / "mine.toml"))
    assert any(one.startswith(f"{field}: given") for one in warnings), warnings


def test_parts_of_the_shipped_engines_are_within_their_usual_ranges(shipped):
    """Ranges called those of the shipped engines are theirs; none of theirs is outside of any."""
    scales = [EngineScale(file) for file in shipped if file.whole]
    for field, (compared, usual) in usual_parts.PARTS.items():
        section, name = field.split(".")
        ratios = [
            value / scale.value(compared)
            for scale in scales
            if (value := getattr(scale.part(section), name, None))
        ]
        if usual.basis == usual_sizes.SHIPPED:
            assert (usual.low, usual.high) == close(outwards(min(ratios), max(ratios))), field
        elif ratios:
            assert usual.low / usual.margin < min(ratios), field
            assert max(ratios) < usual.high * usual.margin, field


@pytest.mark.slow
def test_counterweights_pass_under_piston_and_beside_rod(tmp_path, edit):
    text = input_path("vw-tdi").read_text("utf-8")
    (tmp_path / "mine.toml").write_text(edit(text, {"piston.skirt_length": '"60 mm"'}), "utf-8")
    warnings = input_warnings(load_any(tmp_path / "mine.toml"))
    assert len(warnings) == 2
    file = load_any("vw-tdi")
    weight = file.throw.counterweight.changed(
        thickness=file.throw.web_thickness, offset=0.1 * file.throw.pin_length
    )
    throw = {"counterweight": weight}
    warnings = input_warnings(file.changed(throw=throw))
    assert len(warnings) == 2


@pytest.mark.slow
def test_levels_of_a_study_far_from_its_throw(call, tmp_path, edit):
    text = edit(
        input_path("yamz-5340").read_text("utf-8"),
        {"study.factors.web_width": '["90 m", "100 mm", "110 mm"]'},
    )
    (tmp_path / "mine.toml").write_text(text, "utf-8")
    (warning,) = call("check", "mine.toml", "--json").json()["warnings"]
    assert warning.startswith("study.factors.web_width: given 90000 mm")


@pytest.fixture(scope="module")
def measured():
    """Angles and absolute pressure of the model's cycle, for a table."""
    pressure = load_any("6chn25-34").pressure[0]
    return pressure.angles_deg, pressure.pressure


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda p: p, None),
        (lambda p: np.roll(p, round(25.0 * p.size / 720.0)), "exponent"),
        (lambda p: np.maximum(p - 101325.0, 1e3), "lowest pressure"),
        (lambda p: np.where(np.arange(p.size) == p.size - 10, 0.5 * p, p), "perhaps a dropout"),
        (lambda p: np.where(np.arange(p.size) == p.size // 12, 0.5 * p, p), "perhaps a dropout"),
    ],
)
def test_a_pressure_table_that_looks_like_a_slip(measured, change, said):
    angles, pressure = measured
    mechanism = load_any("6chn25-34")
    table = gas_pressure(change(pressure), 4, angles_deg=angles)
    warnings = sentences(
        pressure_warnings(table, mechanism.layout, mechanism.gas.compression_ratio)
    )
    assert any(said in one for one in warnings) if said else not warnings


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda torque: -torque, "perhaps sign"),
        (lambda torque: torque / 1e3, "perhaps a unit's prefix"),
        (lambda torque: torque[::-1], "perhaps the angles are in reverse order"),
    ],
)
def test_a_torque_table_that_looks_like_a_slip(tmp_path, change, said):
    shipped_table = data_folder() / "tables" / "yamz5340_torque_one_throw.csv"
    table = read_torque_table(shipped_table)
    torque = change(table.torque)
    lines = [
        f"{angle:g},{one:.6g}" for angle, one in zip(table.crank_angle_deg, torque, strict=True)
    ]
    (tmp_path / shipped_table.name).write_text("crank_angle_deg,torque_Nm\n" + "\n".join(lines))
    (tmp_path / "mine.toml").write_text(input_path("yamz-5340").read_text("utf-8"), "utf-8")
    warnings = input_warnings(load_any(tmp_path / "mine.toml"))
    assert any(one.startswith("torque.table: ") and said in one for one in warnings), warnings
