"""Throws by name, and shipped files."""

import json
import re
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.engine_mechanism import with_throws
from crankfem.analyses.file_check import check_file
from crankfem.analyses.mechanism.mechanism_results import mechanism_results
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.throw_analyses import crank_analyses
from crankfem.analyses.vibration.modes import axial_vibration
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine, load_mechanism
from crankfem.files.engine.throw_file import (
    load_crankshaft,
    load_study,
    load_throw,
    names_of_throws,
)
from crankfem.files.reading.data_files import input_path, shipped_names
from crankfem.files.reading.toml_file import read_toml
from crankfem.report.writing import render_report
from crankfem.satellites.optimum.frequencies import engine_frequencies
from fem.analysis import analyze_throw
from stand_ins import stored_results, typed

UNEQUAL = Path(__file__).parents[1] / "data" / "unequal-three.toml"
SHAFT = 'throws = ["heavy", "plain", "plain"]'
ROUND_OFF = 1e-12
STUDY = """
[study]
throw = "plain"
accuracy = 0.1

[study.factors]
web_thickness = ["24 mm", "25 mm", "26 mm"]
"""


@cache
def unequal_text():
    return UNEQUAL.read_text(encoding="utf-8")


@pytest.fixture
def write(tmp_path):
    """Write the file of two throws with some of its text changed."""

    def written(*changes, added=""):
        text = unequal_text()
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / "changed.toml"
        path.write_text(text + added, encoding="utf-8")
        return path

    return written


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """A shipped engine as it is, with the analysis of its throw, and with the same throw by name."""
    folder = tmp_path_factory.mktemp("named")
    plain = input_path("yamz-5340").read_text(encoding="utf-8")
    plain = plain[: plain.index("[torque]")]
    named = plain.replace("[throw]", "[throws.a]")
    (folder / "plain.toml").write_text(plain, encoding="utf-8")
    shaft = '[shaft]\nthrows = ["a", "a", "a", "a"]\n'
    (folder / "named.toml").write_text(named + shaft, encoding="utf-8")
    one, other = load_engine(folder / "plain.toml"), load_engine(folder / "named.toml")
    return one, other, analyze_throw(one.throw, one.material, 0.1)


def test_each_crank_has_its_throw():
    engine = load_engine(UNEQUAL)
    plain, heavy = engine.named_throws["plain"], engine.named_throws["heavy"]
    assert engine.crank_throws == (heavy, plain, plain)
    assert engine.throw == heavy
    assert heavy == plain.changed(
        pin_length=0.038, main_journal_length=0.036, counterweight=heavy.counterweight
    )
    assert load_mechanism(UNEQUAL).crank_throws == engine.crank_throws
    assert tuple(load_crankshaft(UNEQUAL).throws) == engine.crank_throws
    assert load_throw(UNEQUAL)[0] == heavy
    assert load_throw(UNEQUAL, "plain")[0] == plain
    assert names_of_throws(UNEQUAL) == ("heavy", "plain")


def test_what_a_throw_takes_from_another_keeps_its_source():
    records = {record.field: record for record in load_engine(UNEQUAL).records}
    taken, own = records["throws.heavy.crank_radius"], records["throws.heavy.pin_length"]
    assert (taken.source, taken.assumed) == ("drawing", False)
    assert records["throws.heavy.web_thickness"].assumed
    assert (own.given, own.source) == ("38 mm", "unequal-three.toml")
    assert records["throws.heavy.like"].given == "plain"


def test_a_part_takes_what_it_lacks_from_the_same_part_of_the_other(write):
    given = (
        '[throws.third]\nlike = "heavy"\n[throws.third.counterweight]\nangle = "90 deg"\n[shaft]'
    )
    full = unequal_text()[unequal_text().index("[throws.plain]") :].partition("[throws.heavy]")[0]
    full = full.replace("[throws.plain]\n", "").strip()
    path = write(
        ('like = "plain"\npin_length = "38 mm"\nmain_journal_length = "36 mm"', full),
        ("[shaft]", given),
        (SHAFT, 'throws = ["heavy", "plain", "third"]'),
    )
    heavy, third = (load_engine(path).named_throws[name] for name in ("heavy", "third"))
    assert third.counterweight.outer_radius == heavy.counterweight.outer_radius
    assert np.degrees(third.counterweight.angle) == close(90.0)


def test_a_throw_is_turned_end_for_end(write):
    turned = '[throws.turned]\nlike = "heavy"\nreversed = true\n\n[shaft]'
    path = write(
        ('like = "plain"\npin_length = "38 mm"\nmain_journal_length = "36 mm"', FULL),
        ("[throws.heavy.counterweight]", "[throws.heavy.right_web.counterweight]"),
        ("[shaft]", turned),
        (SHAFT, 'throws = ["heavy", "plain", "turned"]'),
    )
    engine = load_engine(path)
    assert engine.named_throws["turned"] == engine.named_throws["heavy"].reversed()
    assert engine.named_throws["turned"] != engine.named_throws["heavy"]


FULL = """crank_radius = "64 mm"
main_journal_diameter = "78 mm"
pin_diameter = "70 mm"
web_width = "100 mm"
web_thickness = "25 mm"
pin_length = "38 mm"
main_journal_length = "36 mm"
fillet_radius = "4 mm"
"""

# What is changed in the file of two throws, and what the refusal must say.
REFUSED = {
    "both": ([("[rod]", f"[throw]\n{FULL}\n[rod]")], r"throws: given together with the section \[throw\]"),
    "unknown": ([(SHAFT, 'throws = ["heavy", "plane", "plain"]')], r"shaft\.throws: given 'plane'; all"),
    "unused": ([(SHAFT, 'throws = ["plain", "plain", "plain"]')], r"throws\.heavy: given, but no crank"),
    "few": ([(SHAFT, 'throws = ["heavy", "plain"]')], r"shaft\.throws: given 2 names; allowed is 3"),
    "not named": ([(SHAFT, ""), ("[shaft]\n", "")], r"shaft\.throws: missing"),
    "empty": ([(SHAFT, "")], r"shaft\.throw_angles: missing; allowed are throw_angles, throws or both"),
    "plain": (
        [("[throws.plain]", "[throw]"), ('like = "plain"\n', "")],
        r"throws: given together with the section \[throw\]",
    ),
    "radius": (
        [('pin_length = "38 mm"\n', 'pin_length = "38 mm"\ncrank_radius = "64.01 mm"\n')],
        r"throws\.heavy\.crank_radius: given 64\.01 mm; allowed is 64 mm as in throws\.plain",
    ),
    "stroke": (
        [('crank_radius = { value = "64 mm", source = "drawing" }', 'crank_radius = "60 mm"')],
        r"throws\.plain\.crank_radius: given 60 mm; allowed is half of engine\.stroke, 64 mm",
    ),
    "pins": (
        [
            (
                "[throws.heavy.counterweight]",
                '[[throws.heavy.further_pins]]\nangle = "30 deg"\nweb_thickness = "0 mm"\n'
                "[throws.heavy.counterweight]",
            )
        ],
        r"throws\.heavy\.further_pins: given 2 pins in all; allowed is 1 as in throws\.plain",
    ),
    "journals": (
        [('pin_length = "38 mm"\n', 'pin_length = "38 mm"\nmain_journal_diameter = "80 mm"\n')],
        r"throws: given main_journal_diameter 80 mm in throw 1 and 78 mm in throw 2; allowed is one",
    ),
    "like nothing": ([('like = "plain"', 'like = "plane"')], r"throws\.heavy\.like: given 'plane'; all"),
    "like itself": ([('like = "plain"', 'like = "heavy"')], r"throws\.heavy\.like: given 'heavy'; allowed"),
    "like a number": ([('like = "plain"', "like = 3")], r"throws\.heavy\.like: given 3; allowed is text"),
    "turned alone": (
        [("[throws.plain]\n", "[throws.plain]\nreversed = true\n")],
        r"throws\.plain\.reversed: given without like",
    ),
    "no table": ([("[throws.plain]\n", "[throws]\nx = 3\n[throws.plain]\n")], r"throws\.x: given 3; all"),
    "field": ([("web_width", "web_with")], r"throws\.plain\.web_with: unknown field; did you mean web_wi"),
    "name": (
        [("[throws.heavy]", '[throws."a b"]'), ("throws.heavy.c", 'throws."a b".c')],
        r"throws: given a throw of the name 'a b'; allowed are letters",
    ),
    "called throw": (
        [("throws.heavy", "throws.throw"), ('"heavy"', '"throw"')],
        r"throws: given a throw of the name 'throw'; allowed are letters",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), REFUSED.values(), ids=REFUSED)
def test_what_throws_by_name_cannot_say(write, changes, message):
    path = write(*changes)
    for load in (load_engine, load_mechanism):
        with pytest.raises(InputError, match=rf"^(?:changed\.toml: )?{message}"):
            load(path)


def test_names_beside_one_throw_are_refused(tmp_path):
    text = input_path("yamz-5340").read_text(encoding="utf-8")
    path = tmp_path / "one.toml"
    shaft = '[shaft]\nthrows = ["a", "a", "a", "a"]\n'
    path.write_text(text[: text.index("[torque]")] + shaft, encoding="utf-8")
    with pytest.raises(InputError, match=r"^shaft\.throws: "):
        load_engine(path)


def test_a_study_is_of_the_throw_it_names(write):
    plan = load_study(write(added=STUDY))
    engine = load_engine(write(added=STUDY))
    assert plan.throw == engine.study.throw == engine.named_throws["plain"]
    first = write(added=STUDY.replace('throw = "plain"\n', ""))
    assert load_study(first).throw == engine.named_throws["heavy"]
    with pytest.raises(InputError, match=r"^study\.throw: "):
        load_study(write(added=STUDY.replace('"plain"', '"third"')))
    with pytest.raises(InputError, match=r"^study\.throw: "):
        load_study(_plain_with_study_throw(first.parent))


def _plain_with_study_throw(folder):
    text = input_path("yamz-5340").read_text(encoding="utf-8")
    path = folder / "plain.toml"
    path.write_text(text.replace("[study]\n", '[study]\nthrow = "a"\n'), encoding="utf-8")
    return path


def test_one_of_several_throws_is_changed(write):
    engine = load_engine(write(added=STUDY))
    thicker = engine.changed(throws={"plain": {"web_thickness": 0.026}})
    assert thicker.crank_throws[1] == engine.named_throws["plain"].changed(web_thickness=0.026)
    assert thicker.crank_throws[0] == engine.crank_throws[0]
    assert thicker.study.throw == thicker.named_throws["plain"]
    records = {record.field: record.source for record in thicker.records}
    assert records["throws.plain.web_thickness"] == "changed in Python"
    assert records["throws.plain.web_width"] == "changed.toml"
    other = engine.changed(shaft={"throws": ["plain", "heavy", "heavy"]})
    assert other.throw == engine.named_throws["plain"]
    alike = engine.changed(throws={"heavy": None}, shaft={"throws": ["plain"] * 3})
    assert alike.crank_throws == (engine.named_throws["plain"],) * 3
    assert alike.study == engine.study
    for changes, message in (
        ({"throw": engine.throw.changed(web_width=0.105)}, "throw: given for an engine with"),
        ({"throws": {"plain": 3}}, r"throws\.plain: given 3; allowed are fields"),
        ({"throws": {"third": engine.throw}}, r"throws\.third: given, but no crank uses it"),
        ({"throws": 3}, "throws: given 3; allowed are names with changes"),
        ({"shaft": None}, r"shaft\.throws: missing"),
    ):
        with pytest.raises(InputError, match=f"^{message}"):
            engine.changed(**changes)
    with pytest.raises(InputError, match=r"^throws: "):
        load_engine("yamz-5340").changed(throws={"a": {"web_width": 0.1}})


def alike(one, other):
    """Compare plain records but for what tells of the file; numbers to round-off of their list."""
    assert type(one) is type(other)
    if isinstance(one, dict):
        assert list(one) == list(other)
        for key in one:
            alike(one[key], other[key])
    elif isinstance(one, list) and one and all(isinstance(item, float) for item in one):
        scale = max(abs(item) for item in one)
        assert np.allclose(one, other, rtol=ROUND_OFF, atol=ROUND_OFF * scale)
    elif isinstance(one, list):
        for left, right in zip(one, other, strict=True):
            alike(left, right)
    elif isinstance(one, float):
        assert other == close(one, rel=ROUND_OFF, abs=0.0)
    else:
        assert one == other


@pytest.mark.further
def test_one_throw_by_name_gives_the_vibration_of_a_plain_file(both, lightly):

    from crankfem.analyses.record import with_units

    plain, named, analysis = both
    ours = engine_vibration(named, analysis={"a": analysis}, coupled=True)
    theirs = engine_vibration(plain, analysis=analysis, coupled=True)
    records = [json.loads(json.dumps(with_units(run))) for run in (theirs, ours)]
    for record in records:
        for one in record["assumed"]:  # the same values, in fields of the throw's own name
            one["field"] = one["field"].replace("throws.a.", "throw.")
    alike(*records)
    assert ours.analysis is theirs.analysis is analysis


@pytest.mark.slow
def test_one_throw_by_name_gives_the_mechanism_of_a_plain_file(both):
    records = []
    for engine in both[:2]:
        record = mechanism_results(run_mechanism(engine)).to_record()
        del record["assumed"]
        records.append(record)
    alike(*records)


def test_a_v_engine_with_split_pins_has_throws_by_name_too(tmp_path):
    text = input_path("buick-3800").read_text(encoding="utf-8")
    path = tmp_path / "vee.toml"
    named = text.replace("[throw]", "[throws.a]").replace("[throw.", "[throws.a.")
    named += '\n[throws.b]\nlike = "a"\n'
    path.write_text(
        named.replace("[shaft]\n", '[shaft]\nthrows = ["a", "b", "a"]\n'), encoding="utf-8"
    )
    plain, found = load_mechanism("buick-3800"), load_mechanism(path)
    assert found.layout == plain.layout
    assert found.rotation_angles_deg == plain.rotation_angles_deg
    assert with_throws(found) == with_throws(plain)
    assert load_crankshaft(path) == load_crankshaft("buick-3800")


@pytest.mark.further
def test_analyses_are_those_of_the_engines_throws(both):
    plain, named, analysis = both
    with pytest.raises(InputError, match=r"^analysis: "):
        engine_vibration(named, analysis={"b": analysis})
    with pytest.raises(InputError, match=r"^analysis: "):
        engine_vibration(UNEQUAL, analysis=analysis)
    other = named.changed(throws={"a": {"web_width": 0.105}})
    with pytest.raises(InputError, match="analyze_throw"):
        engine_vibration(other, analysis={"a": analysis})
    assert engine_vibration(plain, analysis={"throw": analysis}).analysis is analysis


@pytest.mark.slow
def test_masses_are_those_of_each_crank():
    mechanism = load_mechanism(UNEQUAL)
    masses = {throw: cf.throws.throw_masses(throw, 7850.0) for throw in set(mechanism.crank_throws)}
    along = [masses[throw] for throw in mechanism.crank_throws]
    assert with_throws(mechanism) == with_throws(mechanism, along)
    for given, said in ((along[0], "one throw"), (along[:2], "2 throws")):
        with pytest.raises(InputError, match=rf"^masses: given those of {said}; allowed are those"):
            with_throws(mechanism, given)


@pytest.mark.slow
def test_a_regression_that_does_not_know_a_throw_is_left_out():
    engine = load_engine(UNEQUAL)
    analyses = {
        name: analyze_throw(throw, engine.material, 0.1)
        for name, throw in engine.named_throws.items()
    }
    shaft = compliances_in_shaft(engine, analyses)

    class Model:
        """Knows 1e-9 m/N of throws without a counterweight, or of all."""

        responses = ("axial_compliance",)

        def __init__(self, family):
            self.family = family
            self.material = {}

        def of_material(self, _):
            return self

        def dimensions_of(self, throw):
            if throw not in self.family:
                raise InputError("counterweight: given one; allowed is none.")
            return {"pin_length": throw.pin_length}

        def lookup(self, _, *, pin_length):
            value = 1e-9 * (1 + pin_length)
            return SimpleNamespace(value=value, inside=True, lower=0.9 * value, upper=1.1 * value)

    known = axial_vibration(engine, analyses, shaft, Model(engine.crank_throws))
    found = next(own for own in known.others if own.source == "regression")
    pinned = [own.axial_compliance("pinned") for own in crank_analyses(engine, analyses)]
    lengths = np.array([throw.pin_length for throw in engine.crank_throws])
    assert found.compliances == close(1e-9 * (1 + lengths) * shaft.axial / pinned)
    unknown = axial_vibration(engine, analyses, shaft, Model([engine.named_throws["plain"]]))
    assert "regression" not in [own.source for own in unknown.others]
    assert unknown.unusable[0].startswith("regression: ")
    assert "throw heavy:" in unknown.unusable[0]
    formulas = next(own for own in unknown.others if own.source == "Dorey").compliances
    assert formulas[0] != close(formulas[1], rel=1e-3)


def test_a_search_for_one_throw_wants_an_engine_of_one():
    with pytest.raises(InputError, match=r"^unequal-three\.toml: "):
        engine_frequencies(load_engine(UNEQUAL))


def test_bearings_are_as_long_as_the_throws_beside_them_make_them():
    results = mechanism_results(run_mechanism(load_engine(UNEQUAL)))
    assert [own.length for own in results.main_bearings] == close([0.036, 0.035, 0.034, 0.034])
    assert [own.length for own in results.crankpins] == close([0.038, 0.036, 0.036])


@pytest.mark.further
def test_check_shows_each_throw(call):
    record = call("check", UNEQUAL, "--json").json()
    assert list(record["throws"]) == ["plain", "heavy"]
    assert record["throws"]["heavy"]["shape"]["length"] == close(0.124)
    text = call("check", UNEQUAL, "--full").out
    assert re.findall(r"Throw (\w+) .*: length (\d+) mm", text) == [
        ("plain", "120"),
        ("heavy", "124"),
    ]
    assert set(check_file(str(UNEQUAL)).commands) >= {"run", "vibration", "throw", "mechanism"}
    assert "throws" not in call("check", "yamz-5340", "--json").json()


@pytest.mark.slow
def test_commands_take_the_throw_they_are_told(call):
    first, told = call("formulas", UNEQUAL, "--no-fe", "--json"), []
    assert "throw heavy " in first.err
    for name in ("heavy", "plain"):
        answer = call("formulas", UNEQUAL, "--throw", name, "--no-fe", "--json")
        assert answer.err == ""
        told.append(answer.json())
    assert first.json() == told[0] != told[1]
    # The heavy one is like the plain one, but for two lengths of its own.
    unused = [[n for n in record["not_used"] if n.startswith("throws.")] for record in told]
    lengths = [f"throws.plain.{name}" for name in ("pin_length", "main_journal_length")]
    assert unused == [lengths, ["throws.heavy"]]
    assert call("draw", UNEQUAL, "--throw", "plain", "--json").json()["files"] == [
        "unequal-three-throw-plain.svg"
    ]
    assert "is used" not in call("formulas", "yamz-5340", "--no-fe").err


@pytest.mark.slow
def test_a_report_shows_each_throw(tmp_path):
    results = stored_results()
    plain, _ = render_report(typed(results), tmp_path)
    own = {name: results[name] for name in ("throw", "formulas", "fillets", "fillet_note")}
    lighter = own | {"throw": own["throw"] | {"mass": 123.456}, "fillets": None}
    count = len(results["shaft"]["axial"])
    throws = {
        "heavy": {"cranks": [1]} | own,
        "plain": {"cranks": list(range(2, count + 1))} | lighter | {"fillet_note": "it is sharp."},
    }
    named, _ = render_report(typed(results | {"throws": throws}), tmp_path)
    for text in ("Throw plain, cranks 2, 3", "123 kg", "show throw heavy first"):
        assert text in named
        assert text not in plain


@pytest.mark.further
def test_an_engine_of_two_throws_runs_to_a_report(coarsely, call, tmp_path):
    answer = call("run", UNEQUAL, "--output", tmp_path / "out", "--json")
    assert answer.code == 0, answer.err
    results = answer.json()
    assert {name: own["cranks"] for name, own in results["throws"].items()} == {
        "heavy": [1],
        "plain": [2, 3],
    }
    masses = [own["throw"]["mass"] for own in results["throws"].values()]
    assert results["balance"]["mass"] == close(masses[0] + 2.0 * masses[1])
    assert results["throw"] == results["throws"]["heavy"]["throw"]
    assert {"drawing", "drawing-plain"} <= set(results["pictures"])
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "cranks 2, 3" in report


def test_help_says_which_sections_throws_are(call):
    """Square brackets would be read as markup, and vanish."""
    answer = call("throw", "--help")
    assert "(sections throws.NAME);" in " ".join(answer.out.replace("│", " ").split())


OLDER = ("6chn25-34", "yamz-5340")
CYLINDER_PITCH = re.compile(r"cylinder pitch of ([\d.]+) mm")


def values(prefix, table):
    """Names of all values of a section, those of its tables included, as provenance has them."""
    for name, value in table.items():
        field = f"{prefix}.{name}"
        if isinstance(value, dict):
            yield from values(field, value)
        elif isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
            for place, item in enumerate(value):
                yield from values(f"{field}[{place}]", item)
        else:
            yield field


@pytest.mark.parametrize("name", shipped_names("engine"))
def test_every_value_says_where_it_comes_from(name):
    content = read_toml(input_path(name))
    sections = ["throw"] if name in OLDER else list(content.sections)
    fields = [f for section in sections for f in values(section, content.sections[section])]
    # What needs no source: names and counts of the engine.
    plain = {"engine.name", "engine.cylinders", "engine.strokes"}
    assert not [f for f in fields if f not in plain and not content.provenance.get(f, ("",))[0]]


@pytest.mark.parametrize("name", shipped_names("engine"))
def test_a_throw_is_as_long_as_the_cylinder_pitch_it_states(name):
    content = read_toml(input_path(name))
    throw, _ = load_throw(name)
    stated = [
        float(found[1]) / 1e3
        for text, _ in content.provenance.values()
        if (found := CYLINDER_PITCH.search(text))
    ]
    if not stated:
        assert name == "2ch85-110"  # two cylinders between two bearings
        first, second = ((pin.start + pin.end) / 2.0 for pin in throw.parts.pins)
        assert second - first == close(0.104)
        return
    assert stated == [close(throw.length, abs=1e-6)]


@pytest.mark.slow
def test_the_whole_crankshaft_has_all_throws(call, write):
    """Of the throws that one alone is not made of, none is named as not used."""
    file = write((SHAFT, 'throws = ["plain", "heavy", "plain"]'))
    for shaft, named in (([], ["throws.heavy"]), (["--shaft", "shaft.png"], [])):
        record = call("draw", file, "--output", "throw.svg", *shaft, "--force", "--json").json()
        assert [name for name in record["not_used"] if name.startswith("throws")] == named
