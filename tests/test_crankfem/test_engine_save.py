"""Engines that are changed in Python and written back to files."""

import dataclasses
import math
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

import crankfem as cf
from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra, part_kind
from crankbase.written_quantity import parse_quantity
from crankfem.files.engine.changed_content import lost_changes
from crankfem.files.engine.file_kinds import SECTIONS, engine_sections, file_kind
from crankfem.files.reading.data_files import input_path, shipped_names
from crankfem.files.reading.toml_text import quantity_text, toml_text

ENGINES = [name for name in shipped_names("engine") if file_kind(engine_sections(name)) == "engine"]


def numbers_in(section):
    """Every number and every tuple of numbers of a record's fields, slightly changed."""
    for name in type(section).model_fields:
        value = getattr(section, name)
        if isinstance(value, float) and value:
            yield name, value * 1.0137
        elif isinstance(value, tuple) and value and all(isinstance(item, float) for item in value):
            yield name, tuple(item + 1e-3 for item in value)


def changed_everywhere(engine):
    """The engine with as many numbers changed as its checks allow, and the names of these fields."""
    names = []
    for part in dataclasses.fields(engine):
        section = getattr(engine, part.name)
        if not isinstance(section, InputModel):
            continue
        for name, value in numbers_in(section):
            try:
                engine = engine.changed(**{part.name: {name: value}})
            except InputError:
                continue
            names.append(f"{section.section}.{name}")
    return engine, names


@pytest.mark.slow
@pytest.mark.parametrize("name", ENGINES)
def test_every_shipped_engine_is_read_as_it_was_written(name, tmp_path):
    engine = cf.load_engine(name)
    read = cf.load_engine(engine.save(tmp_path / f"{name}.toml"))
    assert lost_changes(read, engine) == []
    assert (read.records, read.provenance, read.sources) == (
        engine.records,
        engine.provenance,
        engine.sources,
    )
    changed, names = changed_everywhere(engine)
    again = cf.load_engine(changed.save(tmp_path / f"{name}.toml"))
    assert len(names) > 15
    assert lost_changes(again, changed) == []
    assert lost_changes(again, engine) != []
    assert again.provenance == engine.provenance | dict.fromkeys(
        names, ("changed in Python", False)
    )


def test_sources_and_marks_stay_and_sections_come_and_go(tmp_path):
    engine = cf.load_engine("8chn13-14")
    changed = engine.changed(
        throw={
            "fillet_radius": 0.009,
            "oil_holes": (cf.throws.OilHole(part="pin", diameter=0.008),),
        },
        free_end=None,
        damping={"loss_factor": 0.02},
    )
    before = tomllib.loads(input_path("8chn13-14").read_text(encoding="utf-8"))
    after = tomllib.loads(changed.save(tmp_path / "mine.toml").read_text(encoding="utf-8"))
    throw = before["throw"] | {
        "fillet_radius": {"value": "9 mm", "source": "changed in Python"},
        "oil_holes": [{"part": "pin", "diameter": "8 mm"}],
    }
    assert after.pop("throw") == throw
    assert after.pop("damping") == {"loss_factor": {"value": 0.02, "source": "changed in Python"}}
    del before["throw"], before["free_end"]
    assert after == before


NAMED = """
[throws.a]
{throw}
[throws.b]
like = "a"
web_thickness = {{ value = "70 mm", source = "drawing 7" }}

[throws.c]
like = "b2"
reversed = true

[throws.b2]
{throw}

[shaft]
throws = ["a", "b", "b2", "c", "b", "a"]
"""


@pytest.fixture
def named(tmp_path):
    """A file whose throws have names, two like others, with a table of pressures in its folder."""
    text = input_path("6chn25-34").read_text(encoding="utf-8")
    before, _, rest = text.partition("[throw]")
    throw, _, rest = rest.partition("[material]")
    gas, _, rest = rest.partition("[gas]")
    rest = rest.partition("[vibration]")[2].partition("[study]")[0]
    table = 'pressure_table = "diagram.csv"\n'
    path = tmp_path / "named.toml"
    path.write_text(
        f"{before}{NAMED.format(throw=throw)}[material]{gas}[gas]\n{table}[vibration]{rest}",
        encoding="utf-8",
    )
    angles = range(0, 721, 2)
    rows = [f"{angle},{1.0 + 60.0 * math.exp(-(((angle - 365) / 30.0) ** 2))}" for angle in angles]
    (tmp_path / "diagram.csv").write_text(
        "\n".join(["crank angle [deg],pressure [bar]", *rows]), encoding="utf-8"
    )
    return path


def test_named_throws_and_files_in_another_folder(named, tmp_path):
    engine = cf.load_engine(named)
    (tmp_path / "other").mkdir()
    path = engine.save(tmp_path / "other" / "mine.toml")
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    assert content["gas"]["pressure_table"] == "../diagram.csv"
    assert content["throws"]["b"]["like"] == "a"
    # What is like another throw would follow it, and so each stands alone once one changes.
    changed = engine.changed(throws={"a": {"web_width": 0.300}})
    content = tomllib.loads(changed.save(path).read_text(encoding="utf-8"))
    assert not any("like" in throw for throw in content["throws"].values())
    assert content["throws"]["b"]["web_thickness"] == {"value": "70 mm", "source": "drawing 7"}
    read = cf.load_engine(path)
    assert read.throws_by_name == changed.throws_by_name
    assert read.throws_by_name["b"].web_width == engine.throws_by_name["b"].web_width


def test_files_of_others_are_not_replaced(tmp_path):
    engine, path = cf.load_engine("6chn25-34"), tmp_path / "mine.toml"
    path.write_text("precious", encoding="utf-8")
    with pytest.raises(InputError, match=r"mine\.toml: "):
        engine.save(path)
    assert path.read_text(encoding="utf-8") == "precious"
    path.unlink()
    engine.save(path)
    engine.changed(rod={"length": 0.7}).save(path)
    path.write_text(path.read_text(encoding="utf-8") + "# mine now\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"mine\.toml: "):
        engine.save(path)
    with pytest.raises(InputError, match=r"\.json"):
        engine.save(tmp_path / "mine.json")
    with pytest.raises(InputError, match="nowhere"):
        engine.save(tmp_path / "nowhere" / "mine.toml")
    with pytest.raises(InputError, match="path: given 3"):
        engine.save(3)


def test_what_a_file_cannot_hold_is_refused(tmp_path):
    engine, path = cf.load_engine("5rt-flex50d"), tmp_path / "mine.toml"
    lines = {"torsional": cf.Chain([1.0, 2.0], [3e6])}
    with pytest.raises(InputError, match=r"shaft_lines: "):
        dataclasses.replace(engine, shaft_lines=lines).save(path)
    six = cf.load_engine("6chn25-34")
    study = dataclasses.replace(six.study, held_out=3)
    with pytest.raises(InputError, match=r"study: "):
        dataclasses.replace(six, study=study).save(path)
    assert not path.exists()
    assert "study" not in tomllib.loads(
        dataclasses.replace(six, study=None).save(path).read_text(encoding="utf-8")
    )


def units_of(model):
    for info in model.model_fields.values():
        if part := part_kind(info):
            yield from units_of(part)
        elif unit := field_extra(info, "unit"):
            yield unit


# Of all fields of engine files.
UNITS = sorted({unit for section in SECTIONS.values() for unit in units_of(section.model)})


@given(value=st.floats(-1e12, 1e12, allow_subnormal=False), unit=st.sampled_from(UNITS))
def test_a_quantity_is_read_as_the_number_that_was_written(value, unit):
    possible = abs(value) if unit == "K" else value
    assert parse_quantity(quantity_text(possible, unit), unit, "field") == possible


TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=5)
SCALARS = TEXTS | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False)
VALUES = (
    SCALARS
    | st.lists(SCALARS, max_size=3)
    | st.fixed_dictionaries({"value": SCALARS, "source": TEXTS})
)
TABLES = st.dictionaries(TEXTS, VALUES, max_size=3)
DEEPER = st.dictionaries(TEXTS, VALUES | TABLES | st.lists(TABLES, min_size=1), max_size=3)


@given(content=st.dictionaries(TEXTS, DEEPER, max_size=3))
def test_any_content_is_parsed_as_it_was_written(content):
    assert tomllib.loads(toml_text(content)) == content
