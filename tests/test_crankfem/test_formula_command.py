"""The command `formulas`, its tables, and the pictures of the angle."""

import functools
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from comparing import close
from crankbase.diagrams import draw_diagram, figure
from crankfem.analyses.throw import formula_records
from crankfem.analyses.throw.formula_records import (
    ElementValues,
    EngineSpread,
    Ratio,
    fe_axial,
    formula_spreads,
    formulas_over_angle,
)
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading import data_files
from fem.analysis import analyze_throw
from fem.supports import Neighbors
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Web
from regression.formulas.axial_formulas import AXIAL_FORMULA_NAMES, axial_formulas
from regression.formulas.torsional_formulas import TORSIONAL_FORMULA_NAMES

# An engine of nobody's.
MINE = {
    "crank_radius": 95,
    "main_journal_diameter": 150,
    "pin_diameter": 130,
    "web_width": 210,
    "web_thickness": 42,
    "pin_length": 95,
    "main_journal_length": 90,
    "fillet_radius": 8,
}

coarse = functools.partial(analyze_throw, accuracy=0.1)


@pytest.fixture(scope="module")
def analysis():
    return coarse(*load_throw("6chn25-34"))


def test_printed_says_what_is_left_out(call):
    content = call("formulas", "6chn25-34", "--no-fe", "--variant", "printed", "--json").json()
    assert [record["name"] for record in content["left_out"]] == [
        "Draminsky (2)",
        "Anderson",
        "Gorbunov",
    ]
    assert len(content["axial"]) == 6


def test_other_readings(call):
    for variant, name in (("plain", "TsNIIMF"), ("k/4", "Draminsky (2)")):
        content = call("formulas", "6chn25-34", "--no-fe", "--variant", variant, "--json").json()
        assert [record["name"] for record in content["axial"]] == [name]
        assert content["left_out"] == []


def test_all_engines_in_one_table(call, monkeypatch, analysis):
    monkeypatch.setattr(data_files, "shipped_names", lambda _: ("6chn25-34", "6chn25-34"))
    monkeypatch.setattr(formula_records, "analyze_throw", lambda *_, **__: analysis)
    answer = call("formulas", "--all", "--gamma", "120 deg", "--constant", "k_3=1")
    assert answer.code == 0
    title = (
        "Axial compliance: formula / finite elements, gamma = 120 deg, corrected formulas, k_3 = 1"
    )
    assert title in " ".join(answer.out.split())
    assert answer.err.splitlines() == [
        "finite elements: 6chn25-34 (1 of 2)",
        "finite elements: 6chn25-34 (2 of 2)",
    ]
    lines = answer.out[answer.out.index("engine ") :].splitlines()
    assert max(map(len, lines)) <= 80
    rows = [line.split() for line in answer.out.splitlines() if line.startswith("6chn25-34")]
    counts = len(AXIAL_FORMULA_NAMES), len(TORSIONAL_FORMULA_NAMES)
    assert [len(row) - 3 for row in rows] == [counts[0], counts[0], counts[1], counts[1]]
    throw, _ = load_throw("6chn25-34")
    expected = axial_formulas(throw, 120.0)
    fe = fe_axial(analysis, 120.0)
    assert float(rows[0][2]) == close(fe * 1e9, abs=0.0005)
    for name, cell in zip(AXIAL_FORMULA_NAMES, rows[0][3:], strict=True):
        assert cell.endswith("*") == (not expected[name].valid), name
        assert float(cell.rstrip("*")) == close(expected[name].value / fe, abs=0.0051), name
    assert [line.startswith("greatest") for line in answer.out.splitlines()].count(True) == 2


def test_several_engines_side_by_side(call, monkeypatch, analysis, tmp_path):
    """Each row has what its engine gives alone, at the same angle; finite elements in front."""
    monkeypatch.setattr("fem.analysis.analyze_throw", lambda *_: analysis)
    (tmp_path / "mine.toml").write_text(
        "[throw]\n" + "".join(f'{name} = "{size} mm"\n' for name, size in MINE.items()), "utf-8"
    )
    both = ("formulas", "mine.toml", "6chn25-34", "--gamma", "120 deg")
    engines = call(*both, "--json").json()["engines"]
    assert [each.pop("engine") for each in engines] == ["mine", "6chn25-34"]
    for each, file in zip(engines, both[1:3], strict=True):
        alone = call("formulas", file, "--gamma", "120 deg", "--json").json()
        assert each == {name: alone[name] for name in each}
        assert set(alone) - set(each) == {"gamma_deg", "constants", "units", "not_used"}
    printed = [line.split() for line in call(*both).out.splitlines()]
    row = next(cells for cells in printed if cells[:1] == ["mine"])
    values = [engines[0]["fe"]["axial"], *(each["value"] for each in engines[0]["axial"])]
    assert [float(cell.rstrip("*")) for cell in row[1:]] == close(1e9 * np.array(values), rel=6e-3)
    stars = [cell.endswith("*") for cell in row[2:]]
    assert stars == [not each["valid"] for each in engines[0]["axial"]]
    assert " FE " not in call(*both, "--no-fe").out


def test_summary_over_engines():
    def engine(name, ratio, valid):
        return EngineSpread(
            name, 0.1, ElementValues(1.0, 1.0, 0.0), {"axial": {"Dorey": Ratio(ratio, valid)}}
        )

    spreads = [engine("a", 0.5, True), engine("b", 2.0, True), engine("c", 27.0, False)]
    found = formula_spreads(spreads, "axial")["Dorey"]
    assert (found.least, found.mean, found.greatest) == close((0.5, 3.0, 27.0))
    # A ratio that is not positive has no logarithm; nothing is left of a formula without others.
    assert formula_spreads([engine("d", -0.2, False)], "axial") == {}


def test_one_throw_beside_finite_elements(call, monkeypatch, analysis):
    monkeypatch.setattr("fem.analysis.analyze_throw", lambda *_: analysis)
    content = call("formulas", "6chn25-34", "--gamma", "120", "--json").json()
    law = content["fe"]["angle_law"]
    assert law["e_180"] == close(analysis.axial_compliance(Neighbors(180.0, 180.0)), rel=1e-9)
    cotangent = 1.0 / math.tan(math.radians(60.0))
    expected = law["e_0"] + (law["e_180"] - law["e_0"]) / (1.0 + law["rho"] * cotangent**2)
    assert content["fe"]["axial"] == close(expected, rel=1e-12)


def test_finite_elements_over_the_angle_are_the_chain(analysis):
    # Exact for equal webs; the chain of neighbors itself ends where it changes by 1e-3 no more.
    for gamma in (30.0, 90.0, 120.0, 240.0):
        chain = analysis.axial_compliance(Neighbors(gamma, gamma))
        assert fe_axial(analysis, gamma) == close(chain, rel=1e-3)


@pytest.mark.slow
def test_finite_elements_of_unequal_webs_are_the_chain(dimensions):
    unequal = coarse(CrankThrow(**dimensions, right_web=Web(thickness=0.09)))
    assert fe_axial(unequal, 120.0) == unequal.axial_compliance(Neighbors(120.0, 120.0))


def texts(path):
    """Labels of an SVG file, which matplotlib writes as comments beside their outlines."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    tree = ElementTree.parse(path, parser=parser)
    return [node.text.strip() for node in tree.iter(ElementTree.Comment)]


@pytest.mark.slow
def test_pictures_of_the_angle(tmp_path):
    gammas = np.linspace(0.0, 180.0, 37)
    share = np.sin(np.deg2rad(gammas) / 2) ** 2
    law = 0.2 + 0.8 * share / (share + 2.65 * (1 - share))
    throw, _ = load_throw("6chn25-34")
    tables = [axial_formulas(throw, gamma) for gamma in gammas]
    values = {name: np.array([t[name].value for t in tables]) for name in AXIAL_FORMULA_NAMES}
    curves = formulas_over_angle(gammas, values, law * 1e-9, {"guided": 0.2e-9, "pinned": 1e-9})
    with figure(tmp_path / "formulas.svg") as axes:
        draw_diagram(axes, curves)
        axes.legend()
    shown = texts(tmp_path / "formulas.svg")
    assert {*AXIAL_FORMULA_NAMES, "finite elements", "FE guided: 0.2", "FE pinned: 1"} <= set(shown)
