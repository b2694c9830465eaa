"""Every shipped engine file: it loads, each value says where it comes from, and it is in proportion."""

import math
import re

import pytest

from comparing import close
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.mechanism_file import load_mechanism
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import input_path, shipped_names
from crankfem.files.reading.toml_file import read_toml
from geometry.crankshaft import ShaftEnds

# The types whose compliance the paper of 2021 lists, in its order.
TYPES_OF_THE_PAPER = (
    "8chn26-26",
    "6chn25-34",
    "6chn18-22",
    "12chn18-20",
    "cat-3116",
    "12dn23-30",
    "6chn105-130",
    "6chn15-18",
    "8chn14-14",
    "8chn13-14",
)
OLDER = ("6chn25-34", "yamz-5340")
SECTIONS = {n: read_toml(input_path(n)).sections for n in shipped_names("engine")}
FULL = tuple(n for n, sections in SECTIONS.items() if "flywheel" in sections)
MECHANISMS = tuple(n for n, sections in SECTIONS.items() if "engine" in sections)
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


def test_there_are_at_least_twelve():
    shipped = shipped_names("engine")
    assert len(shipped) >= 12
    assert set(TYPES_OF_THE_PAPER) <= set(shipped)
    assert {"vw-tdi", "6s50mc-c"} <= set(shipped)


@pytest.mark.parametrize("name", shipped_names("engine"))
def test_it_opens_with_what_engine_it_is(name):
    lines = input_path(name).read_text(encoding="utf-8").splitlines()
    opening = lines[: next(place for place, line in enumerate(lines) if not line.startswith("#"))]
    assert 1 <= len(opening) <= 3 or name in OLDER


@pytest.mark.parametrize("name", shipped_names("engine"))
def test_every_value_says_where_it_comes_from(name):
    content = read_toml(input_path(name))
    sections = ["throw"] if name in OLDER else list(content.sections)
    fields = [f for section in sections for f in values(section, content.sections[section])]
    # What needs no source: names and counts of the engine.
    plain = {"engine.name", "engine.cylinders", "engine.strokes"}
    without = [f for f in fields if f not in plain and not content.provenance.get(f, ("",))[0]]
    assert not without


@pytest.mark.parametrize("name", shipped_names("engine"))
def test_citations_and_short_names_belong_together(name):
    text = input_path(name).read_text(encoding="utf-8")
    body, _, _ = text.partition("[sources]")
    short = set(read_toml(input_path(name)).sources)
    assert all(re.search(rf"\b{source}\b", body) for source in short)
    assert set(re.findall(r"\b(?:yamanin|makushev|mikhina|cat)\d{4}\b", body)) <= short


@pytest.mark.parametrize("name", FULL)
def test_full_engine_files_are_valid(name):
    engine = load_engine(name)
    assert engine.throw.crank_radius == close(engine.engine.stroke / 2.0)
    assert engine.throw.further_pins == ()


@pytest.mark.parametrize("name", MECHANISMS)
def test_mechanisms_are_those_of_engines_that_exist(name):
    mechanism = load_mechanism(name)
    layout = mechanism.layout
    assert layout.crank_radius == close(mechanism.throw.crank_radius)
    assert 4.0 < 2.0 * layout.crank_radius * mechanism.rated_speed / math.pi < 15.0  # piston speed
    assert all(0.19 < layout.crank_radius / c.rod.length <= 0.5 for c in layout.cylinders)
    assert 5e6 < mechanism.pressure[0].peak_pressure < 16e6


@pytest.mark.parametrize("name", sorted(set(shipped_names("engine")) - set(OLDER)))
def test_new_files_give_both_shaft_ends_and_no_study(name):
    content = read_toml(input_path(name))
    ends = content.model("shaft_ends", ShaftEnds)
    throw, _ = load_throw(name)
    assert ends.free_end_diameter < throw.main_journal_diameter < ends.flange_diameter
    assert ends.free_end_length > 0.0
    assert ends.flange_thickness < throw.main_journal_diameter
    assert "study" not in content.sections


@pytest.mark.parametrize("name", shipped_names("engine"))
def test_the_throw_is_in_proportion(name):
    throw, _ = load_throw(name)
    journal, pin, radius = throw.main_journal_diameter, throw.pin_diameter, throw.crank_radius
    assert 0.75 < pin / journal <= 1.0
    assert 1.1 < throw.web_width / journal < 2.2
    assert 0.15 < throw.web_thickness / journal < 0.5
    assert 0.2 < throw.pin_length / pin < 1.2
    assert 0.2 < throw.main_journal_length / journal < 1.0
    assert -0.7 * pin < throw.overlap < 0.5 * pin
    assert 0.5 < radius / journal < 1.8
    for item in throw.parts.cylinders:
        for fillet in (item.start_fillet, item.end_fillet):
            assert fillet == 0.0 or 0.04 < fillet / (2.0 * item.radius) < 0.08
        assert item.bore_radius <= 0.7 * item.radius
    for web in throw.parts.webs:
        if web.sector is not None:
            assert web.sector.outer_radius < 2.0 * radius


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


def test_the_features_are_where_the_engines_have_them():
    throws = {name: load_throw(name)[0] for name in shipped_names("engine")}
    hollow = {n for n, t in throws.items() if t.main_journal_bore}
    assert hollow == {"8chn26-26", "12chn18-20", "12dn23-30", "6chn15-18"}
    eccentric = {n for n, t in throws.items() if t.pin_bore_offset}
    assert eccentric == {"8chn26-26", "8chn14-14", "8chn13-14"}
    flat = {n for n, t in throws.items() if t.web_outline == "rectangle"}
    assert flat == {"6chn18-22", "6chn18-22-set", "12dn23-30"}
    assert throws["6chn18-22"].web_corner_chamfer > 0.0
    assert throws["12dn23-30"].web_corner_radius > 0.0
    weighted = {n for n, t in throws.items() if any(w.sector for w in t.parts.webs)}
    assert {"8chn26-26", "8chn14-14", "8chn13-14", "cat-3116", "vw-tdi"} <= weighted
    assert {n for n, t in throws.items() if t.further_pins} == {"2ch85-110", "buick-3800"}
    split = throws["buick-3800"].parts.webs[1]
    assert split.start == split.end
    unequal = {n for n, t in throws.items() if not t.parts.mirrored}
    assert unequal == {"8chn13-14", "2ch85-110", "buick-3800"}
