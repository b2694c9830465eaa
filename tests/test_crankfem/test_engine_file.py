"""Engine files, and engines changed in Python."""

import math
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.array_checks import finite_array, positive_number
from crankbase.choices import whole_number
from crankbase.errors import InputError
from crankbase.written_quantity import parse_quantity
from crankfem.analyses.assumptions import assumed_values
from crankfem.analyses.file_check import refuse_what_cannot_run
from crankfem.analyses.shaft.chains import engine_throw_inertias
from crankfem.analyses.vibration.engine_limits import rule_of
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine, load_mechanism
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.engine.throw_file import load_crankshaft, load_study, load_throw
from crankfem.files.reading import toml_file
from crankfem.files.reading.data_files import input_path
from dynamics.indices import values_at_nodes
from dynamics.turning.speed_over_angle import checked_inertia
from fem.material import STEEL
from fem.modes import free_modes
from fem.supports import Neighbors
from parts_in_a_line import crank_throw
from regression.formulas.axial_formulas import axial_formula
from regression.law.throw_law import axial_law
from regression.plans.factors import Factor


def test_values_are_read_in_si_units():
    engine = load_engine("6chn25-34")
    assert engine.throw.crank_radius == close(0.170)
    assert engine.engine.stroke == close(0.340)
    assert engine.engine.rated_speed == close(500.0 * math.pi / 30.0)
    assert engine.material.youngs_modulus == close(2.1e11)
    assert math.degrees(engine.engine.crank_angles[1]) == close(120.0)
    firing = [round(math.degrees(angle)) for angle in engine.engine.firing_angles]
    assert firing == [0, 480, 240, 600, 120, 360]


def test_equal_engines_and_studies_have_equal_hashes():
    engine, again = load_engine("6chn25-34"), load_engine("6chn25-34")
    assert (engine, hash(engine)) == (again, hash(again))
    assert len({engine, again, engine.changed(engine={"rated_speed": 50.0})}) == 2
    assert len({engine.study, again.study, replace(engine.study, seed=2)}) == 2


def test_names_of_sources_are_found_as_words_only(tmp_path, six_cylinders, edit):
    text = edit(six_cylinders, {"sources.a": '"one letter"', "piston.mass": '"30 kg"'})
    text = edit(text, {"rod.mass": '{ value = "56 kg", source = "a, table of data" }'})
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    records = {record.field: record for record in load_engine(tmp_path / "a.toml").records}
    assert records["rod.mass"].source == "[a], table of data"
    assert records["throw.crank_radius"].source == "[yamanin2021], figure 3; half the stroke"


def test_what_the_file_leaves_out_takes_defaults(tmp_path, six_cylinders, edit):
    gone = ["material", "free_end", "gas", "vibration", "study]", "study.factors"]
    text = edit(six_cylinders, {f"[{name}".replace("]", "") + "]": None for name in gone})
    (tmp_path / "bare.toml").write_text(text, encoding="utf-8")
    engine = load_engine(tmp_path / "bare.toml")
    assert engine.material == cf.STEEL
    assert engine.free_end is None
    assert engine.gas is None
    assert engine.study is None
    assert engine.vibration.axial_source == "fe"


def test_a_file_with_a_byte_order_mark_is_read(tmp_path, six_cylinders):
    (tmp_path / "mark.toml").write_bytes(b"\xef\xbb\xbf" + six_cylinders.encode())
    assert load_engine(tmp_path / "mark.toml").engine.cylinders == 6


def test_a_throw_and_a_study_can_stand_alone(tmp_path, six_cylinders, edit):
    gone = ("engine", "material", "rod", "piston", "flywheel", "free_end", "thrust_bearing")
    text = edit(six_cylinders, {f"[{name}]": None for name in (*gone, "gas", "vibration")})
    path = tmp_path / "study.toml"
    path.write_text(text, encoding="utf-8")
    throw, material = load_throw(path)
    assert throw == load_engine("6chn25-34").throw
    assert material == cf.STEEL
    plan = load_study(path)
    assert plan.names[0] == "web_width"
    assert (plan.factors[0].lowest, plan.factors[0].highest) == close((0.270, 0.330))
    with pytest.raises(InputError, match="describes a throw"):
        load_engine(path)


def test_the_crankshaft_of_an_engine_and_of_a_throw_file(tmp_path):
    six = load_crankshaft("6chn25-34")
    assert len(six.throws) == 6
    assert six.crank_angles_deg == close([0, 120, 240, 240, 120, 0])
    assert six.length == close(6 * 0.410)
    buick = load_crankshaft("buick-3800")
    assert buick.crank_angles_deg == close([0, 240, 120])
    assert buick.length == close(3 * 0.1077 + 0.070 + 0.014)
    text = input_path("8chn14-14").read_text(encoding="utf-8")
    path = tmp_path / "other.toml"
    path.write_text(text.replace("[shaft]\nthrow_angles", "[nothing]\nx"), encoding="utf-8")
    with pytest.raises(InputError, match=r"\[nothing\]"):
        load_crankshaft(path)
    path.write_text(
        text[: text.index("[shaft]")] + text[text.index("[sources]") :]
        if "[sources]" in text
        else text[: text.index("[shaft]")],
        encoding="utf-8",
    )
    with pytest.raises(InputError, match="throw_angles"):
        load_crankshaft(path)


@pytest.mark.slow
@pytest.mark.parametrize("command", [("check",), ("run",), ("plan",), ("doe",)])
def test_a_study_of_which_nothing_can_be_built(
    tmp_path, monkeypatch, six_cylinders, edit, call, command
):
    """Commands that need the study say so before anything is computed; others need no study."""
    monkeypatch.chdir(tmp_path)
    text = edit(six_cylinders, {"study.factors.web_width": '["215 mm", "225 mm"]'})
    (tmp_path / "wrong.toml").write_text(text, encoding="utf-8")
    assert load_engine("wrong.toml").study is not None
    answer = call(*command, "wrong.toml")
    assert answer.code == 2
    assert answer.out == ""
    sentences = [line for line in answer.err.splitlines() if line.startswith("Error: ")]
    assert len(sentences) == 1
    assert sentences[0].startswith("Error: study.factors: ")
    assert "215 mm" in sentences[0]
    assert [path.name for path in tmp_path.iterdir()] == ["wrong.toml"]


@pytest.mark.further
@pytest.mark.parametrize(
    "command",
    [
        ("check",),
        ("mechanism",),
        pytest.param(("vibration",), marks=pytest.mark.slow),
        ("draw", "--output", "a.svg"),
        ("export", "a.step", "--shaft"),
    ],
)
def test_a_file_is_read_once(tmp_path, monkeypatch, six_cylinders, call, command):
    """Everything that a command takes from a file is of one state of it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "six.toml").write_text(six_cylinders, encoding="utf-8")
    read, paths = toml_file.tomllib.loads, []
    monkeypatch.setattr(toml_file.tomllib, "loads", lambda text: paths.append(text) or read(text))
    assert call(command[0], "six.toml", *command[1:]).code == 0
    assert paths.count(six_cylinders) == 1


def test_a_name_that_no_file_can_have():
    with pytest.raises(InputError) as told:
        load_engine("x" * 100_000)
    assert len(str(told.value)) < 1000


@pytest.mark.parametrize("command", ["run", "throw", "formulas", "doe", "vibration", "check"])
def test_every_command_refuses_a_bare_number(command, tmp_path, six_cylinders, edit, call):
    path = tmp_path / "wrong.toml"
    path.write_text(edit(six_cylinders, {"throw.pin_length": "139"}), encoding="utf-8")
    answer = call(command, path)
    assert answer.code == 2
    assert "Error: throw.pin_length: given 139, " in answer.err
    assert "Traceback" not in answer.err
    assert sorted(tmp_path.iterdir()) == [path]


@pytest.mark.further
def test_a_refusal_in_a_process_of_its_own(tmp_path, six_cylinders, edit, spawn):
    path = tmp_path / "wrong.toml"
    path.write_text(edit(six_cylinders, {"throw.pin_length": "139"}), encoding="utf-8")
    answer = spawn("run", path)
    assert answer.code == 2
    assert answer.out == ""
    assert "Traceback" not in answer.err
    assert answer.err.rstrip().splitlines()[-1].startswith("Error: throw.pin_length: given 139, ")


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"material.youngs_modulus": "210"}, "material.youngs_modulus"),
        ({"material.youngs_modulus": "2.1e11"}, "material.youngs_modulus"),
        ({"gas.peak_pressure": "8.5"}, "gas.peak_pressure"),
        ({"rod.length": "0.72"}, "rod.length"),
        ({"rod.length": '"7,2 m"'}, "rod.length"),
        ({"engine.rated_speed": '"fast"'}, "engine.rated_speed"),
        ({"flywheel.inertia": "[]"}, "flywheel.inertia"),
    ],
)
def test_what_a_message_suggests_is_allowed(tmp_path, six_cylinders, edit, changes, field):
    path = tmp_path / "mine.toml"
    path.write_text(edit(six_cylinders, changes), encoding="utf-8")
    with pytest.raises(InputError, match=f"^{field}: ") as raised:
        load_engine(path)
    suggested = re.search(r'(?:like|example) ("[^"]+")', str(raised.value))[1]
    section, name = field.split(".")
    try:  # without the section's other fields
        SECTIONS[section].model.from_text({name: suggested.strip('"')}, section)
    except InputError as error:
        assert not any(line.startswith(f"{field}: ") for line in error.sentences)  # noqa: PT017


@pytest.mark.parametrize("text", ["1-5-3-6-2-4", "1 - 5 - 3 - 6 - 2 - 4", "1, 5, 3, 6, 2, 4"])
def test_a_firing_order_may_be_text(tmp_path, six_cylinders, edit, text):
    path = tmp_path / "mine.toml"
    path.write_text(edit(six_cylinders, {"engine.firing_order": f'"{text}"'}), encoding="utf-8")
    engine = load_engine(path)
    assert engine.engine.firing_order == (1, 5, 3, 6, 2, 4)
    changed = engine.changed(engine={"firing_order": "1-4-2-6-3-5"})
    assert changed.engine.firing_order == (1, 4, 2, 6, 3, 5)


@pytest.mark.slow
def test_a_modulus_that_no_steel_has_is_remarked(call, tmp_path, six_cylinders, edit):
    for modulus, remarked in (("21 GPa", True), ("999 GPa", True), ("206 GPa", False)):
        text = edit(six_cylinders, {"material.youngs_modulus": f'"{modulus}"'})
        (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
        words = call("check", "mine.toml", "--full").out
        assert ("Warning: material.youngs_modulus: " in words) is remarked


def test_a_choice_that_is_not_made_is_shown_as_not_given():
    shown = {one.field: one.given for one in load_engine("8chn13-14").records}
    assert shown["engine.drives"] == "not given"
    assert all(shown.values())


@pytest.fixture(scope="module")
def engine():
    return load_engine("6chn25-34")


@pytest.mark.parametrize(
    "way", [lambda e, rod: e.changed(rod=rod), lambda e, rod: replace(e, rod=rod)]
)
def test_a_changed_rod_changes_mechanism_and_inertias(engine, way):
    """Half a rod's rotating mass more at the crank radius, exactly: that is how rods count there."""
    rod = engine.rod.changed(
        rotating_mass=engine.rod.rotating_mass + 2.0, mass=engine.rod.mass + 2.0
    )
    heavier = way(engine, rod)
    own, other = (engine_throw_inertias(one, 1.0) for one in (engine, heavier))
    assert other - own == close(2.0 * engine.throw.crank_radius**2, rel=1e-9)
    assert heavier.layout.cylinders[0].rod.mass == rod.mass


def test_fields_make_sections(engine):
    damper = {"kind": "viscous", "ring_inertia": 5.0, "damping": 2000.0}
    changed = engine.changed(
        throw={"web_thickness": 0.070}, torsional_damper=damper, two_mass=None, gas=None
    )
    assert changed.throw.web_thickness == 0.070
    assert changed.throw.crank_radius == engine.throw.crank_radius
    assert changed.torsional_damper.ring_inertia == 5.0
    assert changed.gas is None
    assert changed.study.throw == changed.throw
    assert changed.path == engine.path


def test_changed_values_lose_their_sources(engine):
    changed = engine.changed(throw={"crank_radius": 0.1701}, free_end=None)
    before, after = ({r.field: r for r in one.records} for one in (engine, changed))
    radius = after["throw.crank_radius"]
    assert (radius.given, radius.source, radius.assumed) == ("170.1 mm", "changed in Python", False)
    assert changed.provenance["throw.crank_radius"] == ("changed in Python", False)
    assert after.keys() == before.keys() - {"free_end.inertia", "free_end.mass"}
    assert after["throw.web_width"] == before["throw.web_width"]
    assert list(after)[:8] == list(before)[:8]


def test_vibration_of_a_mechanism_alone_is_refused():
    mechanism = load_mechanism("6chn25-34")
    assert not mechanism.whole
    with pytest.raises(InputError, match=r"\[thrust_bearing\]"):
        engine_vibration(mechanism)
    whole = mechanism.changed(thrust_bearing=load_engine("6chn25-34").thrust_bearing)
    assert whole.whole


def test_what_follows_from_sections_is_calculated_once_and_is_read_only(engine):
    assert engine.layout is engine.layout
    assert engine.pressure is engine.pressure
    with pytest.raises(TypeError):
        engine.named_throws["throw"] = engine.throw
    longer = engine.changed(rod={"length": engine.rod.length + 0.01})
    assert longer.layout != engine.layout
    sent = pickle.loads(pickle.dumps(longer))
    assert sent.layout == longer.layout
    assert dict(sent.named_throws) == dict(longer.named_throws)


@pytest.mark.parametrize("rule", [{}, {"crankshaft_rule": "KR main engine"}])
def test_a_strength_beyond_the_rule_stays_as_given_and_is_told(engine, rule):
    given = {"yield_strength": 550e6, "tensile_strength": 850e6, "alloy": True}
    strong = engine.changed(limits=given | rule)
    refuse_what_cannot_run(strong)
    assert strong.limits.tensile_strength == 850e6


@pytest.mark.parametrize(
    ("driven", "rule"), [("generator", "KR generator set"), ("propeller", "KR main engine")]
)
def test_the_rule_that_is_listed_as_assumed_is_the_one_that_is_taken(driven, rule):
    engine = load_engine("6chn25-34").changed(engine={"drives": driven})
    (listed,) = (one for one in assumed_values(engine) if one.field == "limits.crankshaft_rule")
    assert listed.given == rule == rule_of(engine.engine)


def test_the_compression_of_a_misfiring_cylinder_is_listed_beside_a_measured_pressure(tmp_path):
    angles = np.arange(-360.0, 360.0, 2.0)
    pressure = 2.0 + 100.0 * np.exp(-(((angles - 10.0) / 20.0) ** 2))
    rows = [f"{a:g},{p:.6f}" for a, p in zip(angles, pressure, strict=True)]
    table = "\n".join(["crank_angle_deg,absolute_pressure_bar", *rows])
    (tmp_path / "pressure.csv").write_text(table, encoding="utf-8")
    text = input_path("6chn25-34").read_text("utf-8")
    text = re.sub(r"peak_pressure = .*", 'pressure_table = "pressure.csv"', text)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    listed = {one.field: one.given for one in assumed_values(load_engine(tmp_path / "mine.toml"))}
    assert listed["gas.compression_ratio"] == "14.0"


THROW = crank_throw(0.170, 0.220, 0.180, 0.135, 0.139, 0.285, 0.068)


@pytest.mark.parametrize("number", [10**400, -(10**400), 10**5000], ids=["large", "low", "endless"])
def test_numbers_too_large_for_a_float_are_refused_everywhere(number):
    for call in (
        lambda: Neighbors(number, 0.0),
        lambda: free_modes(None, STEEL, highest_frequency=number),
        lambda: axial_law(THROW, youngs_modulus=number),
        lambda: axial_formula("Anderson", THROW, gamma_deg=number),
        lambda: THROW.changed(crank_radius=number),
        lambda: parse_quantity(number, "", "field"),
        lambda: positive_number("field", number, "s", "time runs"),
        lambda: whole_number("field", number, 1, "they are counted"),
        lambda: values_at_nodes("field", {0: number}, 3, "kg", "it is a mass"),
        lambda: finite_array("field", [1.0, number]),
        lambda: checked_inertia(number, 0.0),
        lambda: Factor("web_width", "m", 0.1, number),
    ):
        with pytest.raises(InputError):
            call()


@pytest.mark.slow
def test_an_engine_draws_its_crankshaft():
    engine = load_engine("6chn25-34")
    assert engine.crankshaft.end_cylinders == load_crankshaft("6chn25-34").end_cylinders
    numbers = {text.get_text() for text in engine.plot().texts}
    assert numbers >= {"1", "6"}
