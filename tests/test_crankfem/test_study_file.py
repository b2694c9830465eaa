"""Study files: what they say becomes the plan, what they cannot say is refused in one sentence."""

import json
import re
import tomllib
from pathlib import Path
from typing import get_args

import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankbase.input_file import InputFile
from crankfem.analyses.study.planned_designs import PlannedDesigns
from crankfem.analyses.study.studies import run_study, study_key
from crankfem.cli import console
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.throw_file import load_study
from crankfem.files.reading.data_files import input_path
from crankfem.files.reading.toml_file import read_toml
from crankfem.files.study_file import StudySection, read_design, study_plan
from fem.material import STEEL
from geometry.throw import CrankThrow
from plans import FILLETED
from regression.plans.designs import DesignChoice, DesignKind
from regression.plans.factors import Factor
from regression.plans.plan import plan_designs
from regression.records import StudyStoppedError

ROOT = Path(__file__).resolve().parents[2]
THROW = FILLETED
HEAVY = CrankThrow(
    **THROW.model_dump(mode="json") | {"counterweight": {"outer_radius": 0.25, "angle": 2.0}}
)
WIDTH = 'web_width = ["270 mm", "300 mm", "330 mm"]'
RANGE = 'web_thickness = { from = "38 mm", to = "98 mm" }'


@pytest.fixture
def read(tmp_path):
    def reader(text, throw=THROW):
        file = tmp_path / "study.toml"
        file.write_text(text, encoding="utf-8")
        return study_plan(read_toml(file), {"throw": throw}, "throw", STEEL)

    return reader


def study(head="", factors=WIDTH, tail=""):
    return f"[study]\n{head}\n[study.factors]\n{factors}\n{tail}\n"


def test_a_file_without_a_study(read):
    assert read("[throw]\n") is None


def test_the_key_of_a_files_study(read, tmp_path):
    lengths = {
        name: f"{name} = '{1000.0 * value} mm'\n"
        for name, value in THROW.model_dump(exclude_defaults=True).items()
    }
    plan = read(f"[throw]\n{''.join(lengths.values())}{study()}")
    assert study_key(str(tmp_path / "study.toml")) == plan.key


def test_what_is_not_said(read):
    plan = read(study())
    assert (plan.held_out, plan.seed, plan.accuracy, plan.stresses) == (10, 1, 0.01, False)
    assert plan.design == DesignChoice()


@pytest.mark.parametrize(
    ("line", "factor"),
    [
        (RANGE, Factor("web_thickness", "m", 0.038, 0.098)),
        (
            'web_thickness = { from = "38 mm", to = "98 mm", levels = 4 }',
            Factor("web_thickness", "m", 0.038, 0.098, (0.038, 0.058, 0.078, 0.098)),
        ),
        (
            'web_thickness = { from = "38 mm", to = "98 mm", levels = 4, spacing = "chebyshev" }',
            Factor("web_thickness", "m", 0.038, 0.098, (0.038, 0.053, 0.083, 0.098)),
        ),
        (
            '"counterweight.angle" = { from = "60 deg", to = "120 deg" }',
            Factor("counterweight.angle", "rad", 1.0471975511965976, 2.0943951023931953),
        ),
        (
            'counterweight.offset = ["1 mm", "2 mm"]',
            Factor.of_levels("counterweight.offset", "m", (0.001, 0.002)),
        ),
    ],
)
def test_factors(read, line, factor):
    (_, found) = read(study(factors=f"{WIDTH}\n{line}"), HEAVY).factors
    assert found.levels == factor.levels
    assert (found.lowest, found.highest) == close((factor.lowest, factor.highest), rel=1e-15)
    assert (found.name, found.unit) == (factor.name, factor.unit)


def test_factors_keep_their_order(read):
    plan = read(study(factors=f'web_outline = ["rectangle", "obround"]\n{RANGE}\n{WIDTH}'))
    assert plan.names == ("web_outline", "web_thickness", "web_width")
    assert plan.factors[0].labels == ("rectangle", "obround")


def test_tables_of_parts(read):
    text = """
[study]
constraints = ["counterweight.thickness <= web_thickness"]
[study.factors.counterweight]
angle = ["80 deg", "120 deg"]
[study.relations.counterweight]
thickness = "0.9 * web_thickness"
[study.relations]
pin_fillet_radius = "0.07 * pin_diameter"
"""
    plan = read(text, HEAVY)
    assert plan.names == ("counterweight.angle",)
    assert plan.relations == {
        "counterweight.thickness": "0.9 * web_thickness",
        "pin_fillet_radius": "0.07 * pin_diameter",
    }
    throw = plan_designs(plan).designs[0].inputs["throw"]
    assert throw["counterweight"]["thickness"] == 0.0612
    assert throw["pin_fillet_radius"] == 0.0126


LENGTHS = ("web_width", "pin_length", "main_journal_length")


def test_runs_with_slopes(read):
    factorial = read(study('runs = "with slopes"'))
    assert factorial.slopes
    assert factorial.design.runs is None
    assert not read(study("")).slopes
    ranges = "\n".join(f"{name} = {{ from = '120 mm', to = '158 mm' }}" for name in LENGTHS)
    numbers = {
        text: read(study(text, ranges)).design.runs
        for text in (
            'design = "latin hypercube"\nruns = "with slopes"',
            'design = "sobol"\nslopes = true',
            'design = "sobol"\nslopes = true\nruns = 12',
        )
    }
    assert list(numbers.values()) == [8, 8, 12]


def test_a_wrong_word_for_runs_is_told_once(tmp_path):
    file = tmp_path / "engine.toml"
    engine = input_path("6chn25-34").read_text(encoding="utf-8").partition("\n[study")[0]
    for word, wrong in (("many", True), ("with slopes", False)):
        file.write_text(
            engine.replace("[rod]", "[rod]\nwidth = 1")
            + "\n"
            + study(f'design = "latin hypercube"\nruns = "{word}"'),
            encoding="utf-8",
        )
        with pytest.raises(InputError) as error:
            load_engine(file)
        told = [line for line in error.value.sentences if line.startswith("study.runs")]
        assert len(told) == wrong
        assert len(error.value.sentences) == 1 + wrong


def test_stresses_and_constraints(read):
    plan = read(study('stresses = true\nconstraints = ["web_width > 280 mm"]'))
    assert plan.stresses is True
    assert plan.constraints == ("web_width > 280 mm",)
    assert plan.form is None
    assert read(study('form = "Gaussian process"')).form == "Gaussian process"


# --------------------------------------------------------------------------------------- own designs


@pytest.fixture
def read_rows(read, tmp_path):
    def reader(rows, factors="", throw=THROW):
        (tmp_path / "runs.csv").write_text(rows, encoding="utf-8-sig")
        head = '[study]\ndesign = "file"\nfile = "runs.csv"\n'
        return read(head + (f"[study.factors]\n{factors}\n" if factors else ""), throw)

    return reader


EXPECTED = ((0.27, 0.0), (0.30, 1.0), (0.33, 0.0))


@pytest.mark.parametrize(
    "rows",
    [
        "web_width [mm],web_outline\n270,obround\n300,rectangle\n330,obround\n",
        "web_width,web_outline\n270 mm,obround\n\n30 cm , rectangle\n0.33 m,obround\n",
        "web_width [m]; web_outline\n0.27;obround\n0.30;rectangle\n0.33;obround",
        "web_width [m]\tweb_outline\n0,27\tobround\n0,30\trectangle\n0,33\tobround",
    ],
)
def test_runs_from_a_file(read_rows, rows):
    plan = read_rows(rows)
    assert plan.design.rows == EXPECTED
    assert plan.factors == (
        Factor("web_width", "m", 0.27, 0.33),
        Factor.of_labels("web_outline", ("obround", "rectangle")),
    )
    assert [design.values for design in plan_designs(plan).designs[:3]] == list(EXPECTED)


def test_factors_of_the_study_give_order_and_ranges(read_rows):
    plan = read_rows("web_width [mm],web_thickness [mm]\n270,50\n330,60\n", f"{RANGE}\n{WIDTH}")
    assert plan.names == ("web_thickness", "web_width")
    assert plan.design.rows == ((0.05, 0.27), (0.06, 0.33))
    assert plan.factors[0].highest == 0.098


@pytest.mark.parametrize(
    ("rows", "factors", "message"),
    [
        ("web_width [mm]\n", "", "study.file: given 'runs.csv' without any run"),
        ("web_width\n270\n300\n", "", "study.file: web_width in line 2 of runs.csv: given '270'"),
        ("web_width [mm]\n270,3\n", "", "study.file: given 2 cells in line 2 of runs.csv"),
        ("web_width [mm],web_width [mm]\n270,3\n", "", "study.file: web_width is twice in"),
        ("web_width [mm]\n270\n300\n", RANGE, "study.file: given the columns web_width in"),
        ("web_thickness [mm]\n270\n", RANGE, "study.file: given web_thickness = 270 mm in row 1"),
        (
            "web_width [mm],web_outline\n270,obround\n300,round\n",
            f'{WIDTH}\nweb_outline = ["obround", "rectangle"]',
            "study.file: given web_outline = 'round' in line 3 of runs.csv; allowed are obround",
        ),
        ("ratio\n1.5\nmuch\n", "", "study.file: ratio in line 3 of runs.csv: given 'much'; write"),
        ("web_with [mm]\n270\n300\n", "", "study.file: web_with in runs.csv is an unknown throw"),
    ],
)
def test_rows_that_cannot_be(read_rows, rows, factors, message):
    with pytest.raises(InputError) as caught:
        _ = read_rows(rows, factors).planned
    assert str(caught.value).startswith(message)
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize("name", ['"missing.csv"', "3"])
def test_files_that_are_none(read, name):
    with pytest.raises(InputError, match=r"^study\.file: given [^\[]*$") as caught:
        read(f'[study]\ndesign = "file"\nfile = {name}\n')
    assert str(caught.value).count("missing.csv") == ("missing" in name)


# -------------------------------------------------------------------------------------------- showing


def test_a_plan_is_shown(read, capsys, monkeypatch):
    monkeypatch.setattr(console.output, "_width", 200)
    text = study(
        'constraints = ["web_thickness > 40 mm"]',
        f'{WIDTH}\n{RANGE}\nweb_outline = ["obround", "rectangle"]',
        '[study.relations]\npin_fillet_radius = "0.07 * pin_diameter"',
    )
    listed = PlannedDesigns.of(plan_designs(read(text)))
    console.print_parts(listed.parts())
    shown = capsys.readouterr().out
    assert "3 x 2 x 2 = 12 runs" in shown
    assert "web_width [mm]" in shown
    assert "rectangle" in shown
    assert "pin_fillet_radius = 0.07 * pin_diameter" in shown
    assert "6 runs, 1 " in shown
    record = json.loads(listed.to_json())
    assert len(record["designs"]) == 16
    assert record["designs"][0]["values"] == {
        "web_width": 0.27,
        "web_thickness": 0.098,
        "web_outline": "obround",
    }
    assert {design["role"] for design in record["excluded"]} == {"run", "held out"}


# ----------------------------------------------------------------------------------------------- docs

PAGE = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)


@pytest.mark.slow
@pytest.mark.parametrize("block", BLOCKS)
def test_examples_of_the_page_can_be_run(read, tmp_path, block):
    (tmp_path / "runs.csv").write_text(
        re.search(r"```csv\n(.*?)```", PAGE, flags=re.DOTALL)[1], encoding="utf-8"
    )
    assert set(tomllib.loads(block)) == {"study"}
    planned = plan_designs(read(block, HEAVY))
    for comment in re.findall(r"# (\d+) runs", block):
        assert sum(design.role == "run" for design in planned.designs) == int(comment)


def test_the_page_names_every_field_and_design():
    assert {tomllib.loads(block)["study"].get("design", "full factorial") for block in BLOCKS} >= {
        "latin hypercube",
        "file",
        "full factorial",
    }
    for name in (*StudySection.model_fields, *get_args(DesignKind)):
        assert re.search(rf"`[^`]*\b{name}\b[^`]*`", PAGE)


def test_notes_of_a_study_go_to_standard_error_or_where_they_are_wanted(monkeypatch, capsys):
    def run_plan(*_, note, **__):
        note("the cluster has no workers; waiting for one")
        raise StudyStoppedError("dask: gone.")

    monkeypatch.setattr("crankfem.analyses.study.studies.run_plan", run_plan)
    told = []
    for options in ({}, {"note": told.append}):
        with pytest.raises(StudyStoppedError):
            run_study("6chn25-34", dask="tcp://h:1", **options)
    assert told == ["the cluster has no workers; waiting for one"]
    assert capsys.readouterr() == ("", f"{told[0]}\n")


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("web_width [mm]\n" + "9" * 200_000 + "\n", "which is no table"),
        ("web_width [mm]\n" + "270\n" * 15_000_000, "given a file of 60 MB"),
    ],
    ids=["long cell", "large file"],
)
def test_tables_that_are_too_large(tmp_path, table, message):
    path = tmp_path / "designs.csv"
    path.write_text(table, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_design(InputFile(path), (), THROW)


def test_a_study_in_a_dict_is_that_of_a_file(tmp_path):
    text = """
    [throw]
    crank_radius = "170 mm"
    main_journal_diameter = { value = "220 mm", source = "drawing" }
    pin_diameter = "180 mm"
    main_journal_length = "120 mm"
    pin_length = "139 mm"
    web_width = "285 mm"
    web_thickness = "68 mm"
    [study]
    held_out = 3
    [study.factors]
    web_width = ["270 mm", "300 mm", "330 mm"]
    """
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    given = tomllib.loads(text)
    assert load_study(given).key == load_study(tmp_path / "study.toml").key
    assert given == tomllib.loads(text)
    given["study"]["factors"] = {"web_widht": ["270 mm", "300 mm"]}
    with pytest.raises(InputError, match=r"web_widht: "):
        load_study(given)


@pytest.mark.further
def test_a_plan_is_run(tmp_path):
    plan = cf.studies.StudyPlan(
        cf.load_throw("6chn25-34")[0],
        (cf.studies.Factor("web_width", "m", 0.27, 0.33),),
        cf.studies.DesignChoice("latin hypercube", runs=3),
        held_out=2,
        accuracy=0.1,
    )
    study = cf.run_study(plan, tmp_path / "runs.sqlite", workers=1)
    assert study.table.plan is plan
    assert len(study.table.values) == 5
    assert len(str(study.table).splitlines()) <= 3
