"""Engine files whose throws are in STEP files."""

import re
from pathlib import Path

import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.file_check import check_file
from crankfem.analyses.mechanism.engine_balance import engine_balance
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.shaft.whole_records import shaft_balance
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import input_path
from fem.analysis import analyze_throw
from geometry.crankshaft import throw_masses
from geometry.solid_files import write_step

pytestmark = pytest.mark.slow
NAME = "6chn25-34"


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
