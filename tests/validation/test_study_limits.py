"""Range of a model: constraints and ranges of its study.

Source: comparisons of dimensions by hand for 2,000 random throws; a study of three dimensions, two
constraints and a relation, its responses closed forms of a frame.

Tolerance: none, counts are equal.

The model must agree for each throw, for every form of its equation, as a number, in an array and on the
command line.
"""

import json
from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from crankbase.errors import InputError
from crankfem.analyses.study.fit_records import compliance_model
from crankfem.analyses.study.response_fits import fit_study
from crankfem.cli.app import app
from parts_in_a_line import crank_throw
from regression.models.response_query import OutsideRangeWarning
from regression.optimum import Limit, find_optimum
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan, plan_designs
from regression.records import Outcome
from regression.runs.study_table import study_table

R, PIN, JOURNAL = 0.170, 0.180, 0.220
THROW = crank_throw(R, JOURNAL, PIN, 0.135, 0.139, 0.285, 0.068, fillet_radius=0.012)
RANGES = {
    "web_width": (0.270, 0.330),
    "web_thickness": (0.040, 0.098),
    "pin_length": (0.120, 0.158),
}
CONSTRAINTS = ("web_thickness >= 0.28 * pin_diameter", "pin_length + 2 * web_thickness <= 320 mm")
RELATIONS = {"main_journal_length": "0.75 * pin_diameter"}
FORMS = ("quadratic", "log-quadratic", "group quadratic")


def responses(throw):
    """Pin and webs of a plane frame, and their mass."""
    width, thickness, length = (throw[name] for name in RANGES)
    bending = length * 64.0 / np.pi / PIN**4 + 8.0 * R / (width * thickness**3)
    return {
        "axial_compliance_pinned": R**2 * bending / 2.1e11,
        "mass": 7850.0 * (2.0 * width * thickness * (R + PIN) + length * PIN**2),
    }


def study(constraints=CONSTRAINTS):
    factors = tuple(Factor(name, "m", *ends) for name, ends in RANGES.items())
    choice = DesignChoice("latin hypercube", runs=50)
    plan = StudyPlan(THROW, factors, choice, RELATIONS, constraints, held_out=10)
    planned = plan_designs(plan)
    outcomes = {
        one.key: Outcome(one.key, one.inputs, responses(one.inputs["throw"]), None, 1.0)
        for one in planned.designs
    }
    return study_table(plan, planned.designs, outcomes, (), planned.excluded)


def belongs(throws):
    """Whether throws belong to the study, by its numbers."""
    width, thickness, length = (throws[name] for name in RANGES)
    inside = (width >= 0.270) & (width <= 0.330) & (thickness >= 0.040) & (thickness <= 0.098)
    inside &= (length >= 0.120) & (length <= 0.158)
    return inside & (thickness >= 0.28 * 0.180) & (length + 2.0 * thickness <= 0.320)


@pytest.fixture(scope="module")
def models():
    table = study()
    fits = fit_study(table)
    return {form: compliance_model(table, fits, form) for form in FORMS}


@pytest.fixture(scope="module")
def throws():
    """2,000 throws in the ranges and up to a tenth of their width beyond."""
    draw = np.random.default_rng(5)
    ends = [(low - (high - low) / 10, high + (high - low) / 10) for low, high in RANGES.values()]
    return {name: draw.uniform(*pair, 2000) for name, pair in zip(RANGES, ends, strict=True)}


@pytest.mark.parametrize("form", FORMS)
def test_throws_inside_are_those_of_the_study(models, throws, form, figure):
    expected = belongs(throws)
    found = models[form].lookups("axial_compliance", **throws)
    figure(
        f"throws inside, {form}",
        int(np.sum(found.inside)),
        int(np.sum(expected)),
        0.5,
        "",
        "absolute",
    )
    assert found.inside.tolist() == expected.tolist()
    assert np.array_equal(np.isfinite(found.lower), expected)
    for place in range(0, 2000, 40):
        one = {name: float(column[place]) for name, column in throws.items()}
        assert models[form].lookup("axial_compliance", **one).inside == expected[place]


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_all_throws_in_the_box_of_a_study_without_constraints_are_inside(throws, form, figure):
    table = study(constraints=())
    model = compliance_model(table, fit_study(table), form)
    inside = {name: np.clip(throws[name], *ends) for name, ends in RANGES.items()}
    found = model.lookups("axial_compliance", strict=True, **inside)
    figure(
        f"throws of the box inside, {form}", int(np.sum(found.inside)), 2000, 0.5, "", "absolute"
    )
    assert found.remarks == ()


@pytest.mark.parametrize("form", FORMS)
def test_a_design_that_the_study_excluded_has_no_band(models, form):
    excluded = {"web_width": 0.300, "web_thickness": 0.045, "pin_length": 0.139}
    model = models[form]
    said = r"'web_thickness >= 0.28 \* pin_diameter' is broken: 45 mm is not >= 50.4 mm"
    found = model.lookup("axial_compliance", **excluded)
    assert not found.inside
    assert (found.lower, found.upper) == (None, None)
    with pytest.warns(OutsideRangeWarning, match=said):
        assert model.axial_compliance(**excluded) == found.value
    for asked in (excluded, excluded | {"web_thickness": np.array([0.07, 0.045])}):
        for ask in (model.axial_compliance, partial(model.lookups, "mass")):
            with pytest.raises(InputError, match=said):
                ask(strict=True, **asked)


def test_a_scaled_throw_keeps_the_constraints_at_its_size(models):
    """Twice as large in all, one throw of the study and one that it excluded."""
    fixed = {"crank_radius": R, "pin_diameter": PIN, "main_journal_diameter": JOURNAL}
    fixed["fillet_radius"] = 0.012
    for thickness, inside in ((0.06, True), (0.045, False)):
        own = {"web_width": 0.300, "web_thickness": thickness, "pin_length": 0.139}
        own["main_journal_length"] = 0.75 * PIN
        double = {name: 2.0 * value for name, value in (fixed | own).items()}
        assert models["group quadratic"].lookup("axial_compliance", **double).inside == inside


def test_a_dimension_that_breaks_its_relation_is_refused(models):
    asked = {"web_width": 0.300, "web_thickness": 0.068, "pin_length": 0.139}
    for model in models.values():
        for length in (0.140, np.array([0.135, 0.140])):
            with pytest.raises(
                InputError, match="main_journal_length: given 140 mm; allowed is 135 mm"
            ):
                model.lookups("mass", main_journal_length=length, **asked)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_the_thinnest_web_keeps_the_constraints(models, form, figure):
    limit = Limit(("axial_compliance",), at_most=1.0, unit="m/N")
    found = find_optimum(models[form], "web_thickness", [limit])
    figure(f"thinnest web, {form}", found.value, 0.28 * PIN, 1e-6, "mm")
    assert found.lookups["axial_compliance"].inside


def test_on_the_command_line_and_from_files(models, tmp_path):
    path = tmp_path / "model.json"
    models["log-quadratic"].save(path)
    pairs = ["web_width=300mm", "web_thickness=45mm", "pin_length=139mm"]
    told = CliRunner().invoke(app, ["lookup", str(path), *pairs])
    assert "OUTSIDE" in told.output
    assert "is broken: 45 mm is not >= 50.4 mm" in " ".join(told.output.split())
    refused = CliRunner().invoke(app, ["lookup", str(path), *pairs, "--strict"])
    assert "allowed are those that keep it" in str(refused.exception)
    record = json.loads(path.read_text())
    assert record["constraints"] == list(CONSTRAINTS)
    assert record["relations"] == RELATIONS
