"""Engine files whose throws are in STEP files."""

import re
import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cad_files import Posture, write_shaft
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.file_check import check_file
from crankfem.analyses.mechanism.engine_balance import engine_balance
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.shaft.whole_records import shaft_balance
from crankfem.analyses.throw.pictures.solid_picture import FIRST_THROW, shaft_surface
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.throw_file import load_crankshaft, load_throw
from crankfem.files.reading.data_files import input_path
from crankfem.files.reading.toml_text import toml_text
from crankfem.report.interactive.throw_view import shaft_figure
from crankfem.satellites.cad.dimensions import dimensions_text
from crankfem.satellites.cad.new_engine import engine_text
from crankfem.satellites.cad.run import run_cad
from fem.analysis import analyze_throw
from geometry.crankshaft import Crankshaft, throw_masses
from geometry.imported import import_throw
from geometry.solid_files import write_step
from geometry.throw_dimensions import Counterweight

pytestmark = pytest.mark.slow
NAME = "6chn25-34"
TURNED = Posture((0.4, -1.1, 0.7), (0.3, -0.2, 0.1), unit="inch", beside=True)


def without(text, section):
    """Text of an engine file without a section and its tables."""
    return re.sub(rf"(?ms)^\[{section}[\].].*?(?=^\[(?!{section}))", "", text)


@pytest.fixture(scope="module")
def text():
    return without(input_path(NAME).read_text(encoding="utf-8"), "study")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cad-engine")
    write_step(load_throw(NAME)[0], folder / "throw.step")
    return folder


@pytest.fixture(scope="module")
def file(folder, text):
    path = folder / "engine.toml"
    written = without(text, "throw") + '\n[throw]\nfile = "throw.step"\n'
    path.write_text(written, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def engine(file):
    return load_engine(file)


@pytest.fixture(scope="module")
def shipped():
    return load_engine(NAME)


def test_a_part_answers_as_dimensions_do(engine, shipped):
    part, throw = engine.throw, shipped.throw
    for name in (
        *("crank_radius", "pin_diameter", "pin_bore", "main_journal_diameter", "volume", "length"),
        *("main_journal_bore", "overlap"),
    ):
        assert getattr(part, name) == close(getattr(throw, name), rel=1e-6, abs=1e-9)
    mass, wanted = (throw_masses(each, 7850.0) for each in (part, throw))
    assert mass.mass == close(wanted.mass, rel=1e-6)
    assert mass.center == close(wanted.center, rel=1e-6, abs=1e-9)
    assert mass.inertia == close(wanted.inertia, rel=1e-6, abs=1e-6)


def test_balance_is_that_of_the_dimensions(engine, shipped):
    balances = [engine_balance(run_mechanism(file)) for file in (engine, shipped)]
    for cad, dimensioned in zip(*(balance.throws for balance in balances), strict=True):
        assert cad.solid == close(dimensioned.solid, rel=1e-6, abs=1e-6)
    forces, moments = (
        [getattr(balance.balance.of(1), name).major for balance in balances]
        for name in ("force", "moment")
    )
    assert forces[0] == close(forces[1], rel=1e-6, abs=1e-3)
    assert moments[0] == close(moments[1], rel=1e-6, abs=1e-3)
    cad, dimensioned = shaft_balance(engine), shaft_balance(shipped)
    assert cad.inertia_about_shaft == close(dimensioned.inertia_about_shaft, rel=1e-6)


def test_vibration_is_that_of_the_dimensions_within_the_error_bars(engine, shipped):
    files, answers = (engine, shipped), []
    for file in files:
        analysis = analyze_throw(file.throw, file.material, accuracy=0.05)
        answers.append(engine_vibration(file, analysis=analysis))
    error = sum(answer.analysis.error_estimate for answer in answers)
    for kind in ("axial", "torsional"):
        cad, dimensioned = (answer.modes(kind).chosen.elastic_frequencies[:3] for answer in answers)
        assert cad == close(dimensioned, rel=error)
        cad, dimensioned = (answer.forced_of(kind).peaks for answer in answers)
        assert [peak.order for peak in cad] == [peak.order for peak in dimensioned]
    assert {row.source for row in answers[0].axial.sources} == {"fe", "fe pinned"}


def test_check_names_what_is_known(file, folder):
    checked = check_file(str(file))
    assert checked.throw.path == str((folder / "throw.step").resolve())
    assert "vibration" in checked.commands
    assert "lookup" not in checked.commands


def test_changes_are_saved(engine, folder):
    inside = folder / "inside"
    inside.mkdir()
    again = load_engine(engine.changed(rod={"length": 0.75}).save(inside / "changed.toml"))
    assert again.rod.length == 0.75
    assert again.throw.digest == engine.throw.digest
    whole = engine.changed(throw=load_throw(NAME)[0])
    assert load_engine(whole.save(inside / "whole.toml")).throw == whole.throw
    with pytest.raises(InputError, match=r"throw: given fields of a throw from a STEP file"):
        engine.changed(throw={"web_width": 0.3})


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('"throw.step"', '"nowhere.step"', "throw.file: given 'nowhere.step', which is not in the"),
        ('"throw.step"', '"throw.step"\nweb_width = "1 m"', "throw.web_width: unknown field"),
        (
            'axial_source = "fe"',
            'axial_source = "law"',
            "vibration.axial_source: given law for throw",
        ),
        ('stroke = { value = "340 mm"', 'stroke = { value = "350 mm"', "throw.crank_radius: given"),
    ],
)
def test_what_a_part_cannot_be_used_for_is_refused(file, old, new, reason):
    written = file.read_text(encoding="utf-8")
    assert old in written
    path = Path(file).with_name("refused.toml")
    path.write_text(written.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_engine(path)
    assert str(error.value).startswith(reason)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (
            ("draw",),
            "draw: given a throw from a STEP file, without dimensions for a drawing; give --picture",
        ),
        (
            ("export", "new.step"),
            "new.step: given a throw that is in throw.step already; allowed is --shaft",
        ),
    ],
)
def test_drawings_and_copies_of_a_part_are_refused(call, file, line, reason):
    command, *rest = line
    answer = call(command, str(file), *rest)
    assert answer.code == 2
    assert reason in answer.err


@pytest.fixture(
    scope="module", params=["yamz-5340", pytest.param("cat-3116", marks=pytest.mark.further)]
)
def round_trip(request, tmp_path_factory):
    """A shipped engine, and what is written for its crankshaft and filled in with its other sections."""
    folder = tmp_path_factory.mktemp("round-trip")
    shipped = load_engine(request.param)
    file = write_shaft(folder / "crank.step", shipped.crankshaft, TURNED)
    mine = folder / "mine.toml"
    mine.write_text(
        engine_text(run_cad(file, accuracy=None, folder=folder / "throws"), mine), encoding="utf-8"
    )
    written = tomllib.loads(mine.read_text(encoding="utf-8"))
    rest = tomllib.loads(shipped.text)
    rest.pop("study", None)
    for section in ("throw", "shaft_ends"):
        if section in written:
            rest[section] = written[section]
    filled = folder / "filled.toml"
    filled.write_text(toml_text(rest), encoding="utf-8")
    return mine, load_engine(filled), shipped


@pytest.mark.parametrize(
    ("name", "angles", "cylinders"),
    [("buick-3800", None, 6), ("vw-tdi", [0.0, 90.0, 270.0, 180.0], 8)],
    ids=["a rod on each pin", "two rods on each pin"],
)
def test_v_engines_fire_evenly(tmp_path, name, angles, cylinders):
    shaft = load_crankshaft(name)
    if angles is not None:
        shaft = Crankshaft(shaft.throws, crank_angles_deg=angles)
    run = run_cad(
        write_shaft(tmp_path / "crank.step", shaft), accuracy=None, folder=tmp_path / "throws"
    )
    mine = tmp_path / "mine.toml"
    mine.write_text(engine_text(run, mine, v_angle_deg=90.0), encoding="utf-8")
    engine = load_engine(mine).engine
    assert engine.strokes == 4
    assert np.ptp(np.diff(np.sort(engine.firing_angles))) == close(0.0, abs=1e-6)
    assert np.degrees(np.abs(engine.bank_angles)) == close(np.full(cylinders, 45.0), rel=1e-9)


def test_a_written_file_runs_unchanged(round_trip):
    mine, _, shipped = round_trip
    engine = load_engine(mine)
    assert engine.whole
    assert engine.engine.stroke == close(shipped.engine.stroke, rel=1e-9)
    assert engine.throw_angles_deg == close(shipped.throw_angles_deg, abs=1e-6)
    assumed = {record.field for record in engine.records if record.assumed}
    assert {"engine.cylinders", "engine.strokes", "engine.bore", "engine.firing_order"} <= assumed
    assert {"rod.length", "gas.peak_pressure"} <= assumed
    assert not {"engine.stroke", "engine.crank_angles", "throw.file"} & assumed


def test_the_command_replaces_no_engine_file(call, round_trip, tmp_path):
    mine = tmp_path / "mine.toml"
    line = ("cad", str(round_trip[0].with_name("crank.step")), "--no-fe", "--engine")
    assert call(*line, str(mine)).code == 0
    written = mine.read_text(encoding="utf-8")
    assert load_engine(mine).throw.path == str(tmp_path / "mine-throws" / "throw-1.step")
    for name, reason in (("mine.toml", "exists already"), ("mine.txt", "a name ending in .toml")):
        answer = call(*line, str(tmp_path / name))
        assert (answer.code, answer.out) == (2, "")
        assert reason in answer.err
    assert mine.read_text(encoding="utf-8") == written


def test_a_filled_in_file_vibrates_as_the_engine_does(round_trip):
    _, cad, shipped = round_trip
    answers = []
    for file in (cad, shipped):
        analysis = analyze_throw(file.throw, file.material, accuracy=0.05)
        answers.append(engine_vibration(file, analysis=analysis))
    error = sum(answer.analysis.error_estimate for answer in answers)
    for kind in ("axial", "torsional"):
        modes = [answer.modes(kind).chosen.elastic_frequencies[:3] for answer in answers]
        assert modes[0] == close(modes[1], rel=0.5 * error)
        assert modes[0] != close(modes[1], rel=1e-12)
        cad_peaks, peaks = (
            {(peak.mode, peak.order): peak for peak in answer.forced_of(kind).peaks}
            for answer in answers
        )
        largest = max(peaks.values(), key=lambda peak: peak.severity)
        same = cad_peaks[largest.mode, largest.order]
        assert same.speed == close(largest.speed, rel=0.5 * error)
        assert same.amplitude == close(largest.amplitude, rel=2.0 * error)
    checks = [answer.worst_check for answer in answers]
    assert checks[0].limit.name == checks[1].limit.name
    assert checks[0].worst_value == close(checks[1].worst_value, rel=2.0 * error)
    balances = [shaft_balance(file) for file in (cad, shipped)]
    assert balances[0].mass == close(balances[1].mass, rel=1e-5)
    assert balances[0].inertia_about_shaft == close(balances[1].inertia_about_shaft, rel=1e-5)
    scale = shipped.throw.crank_radius * balances[1].mass
    assert balances[0].unbalance.static == close(balances[1].unbalance.static, abs=1e-5 * scale)


def test_the_report_shows_the_throws_in_colors(engine):
    shaft = engine.crankshaft
    analysis = analyze_throw(engine.throw, engine.material, accuracy=0.05)
    traces, layout = shaft_figure(shaft, [analysis] * len(shaft.throws))
    throws, cuts = traces[:-1], traces[-1]
    assert [trace["name"] for trace in throws] == [f"throw {n}" for n in range(1, 7)]
    assert all(one["color"] != next_["color"] for one, next_ in pairwise(throws))
    for trace, start, end in zip(throws, shaft.starts, shaft.starts[1:], strict=False):
        assert (min(trace["z"]), max(trace["z"])) == close((1e3 * start, 1e3 * end), abs=0.1)
    # Cranks 1 and 6 point up, the others do not.
    up = [max(trace["y"]) for trace in throws]
    assert up[0] == close(up[5], rel=1e-6)
    assert up[0] > 1.2 * max(up[1:5])
    assert sorted({z for z in cuts["z"] if z is not None}) == close(1e3 * shaft.starts, abs=0.1)
    assert layout["scene"]["camera"]["projection"] == {"type": "orthographic"}


def test_a_picture_tells_throws_apart(engine):
    shaft = engine.crankshaft
    plain, colored = (shaft_surface(shaft, 1, colored) for colored in (False, True))
    assert set(colored.kinds.tolist()) == set(range(FIRST_THROW, FIRST_THROW + 6))
    assert max(plain.kinds) < FIRST_THROW


@pytest.mark.parametrize(
    ("changes", "described"),
    [
        ({}, True),
        ({"counterweight": Counterweight(outer_radius=0.1, angle=2.2)}, True),
        ({"web_tip_thickness": 0.012, "web_foot_thickness": 0.02}, False),  # not looked for
    ],
)
def test_dimensions_are_written_where_they_describe_a_throw(changes, described, tmp_path):
    shipped, material = load_throw("yamz-5340")
    throw = shipped.changed(**changes)
    part = import_throw(write_step(throw, tmp_path / "throw.step"))
    text = dimensions_text(analyze_throw(part, material, accuracy=0.02), 0.02)
    assert (text != "") == described
    if described:
        path = tmp_path / "dimensions.toml"
        path.write_text(f"[throw]\n{text}\n", encoding="utf-8")
        again, _ = load_throw(path)
        assert again.web_width == close(throw.web_width, rel=1e-3)
        assert again.volume == close(throw.volume, rel=1e-3)
        if throw.counterweight is not None:
            assert again.counterweight.angle == close(throw.counterweight.angle, rel=0.02)
