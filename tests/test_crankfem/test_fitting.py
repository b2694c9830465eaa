"""Fits of a whole study, their records, tables and diagrams, on a puppet instead of finite elements."""

import json
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.study.fit_plots import plot_fits
from crankfem.analyses.study.fit_records import comparisons, compliance_model, fitted_study
from crankfem.analyses.study.nominal_throw import nominal_points, sensitivities
from crankfem.analyses.study.response_fits import (
    dimensions_at,
    fit_study,
    predicted,
    response_name,
    surface,
)
from crankfem.analyses.study.study_results import FittedStudy, comparison_parts
from crankfem.cli.console import print_parts
from geometry.throw import CrankThrow
from json_units import numbers_with_units
from parts_in_a_line import crank_throw
from plans import plan_of_levels, table_of_function
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan, plan_designs
from regression.records import ExtraRow, Outcome
from regression.runs.exchange import read_rows
from regression.runs.study_table import study_table

THROW = crank_throw(0.170, 0.220, 0.180, 0.135, 0.139, 0.285, 0.068, fillet_radius=0.012)
LEVELS = {
    "web_width": (0.27, 0.30, 0.33),
    "web_thickness": (0.038, 0.048, 0.077, 0.098),
    "pin_length": (0.120, 0.158),
}
RATIOS = (
    Factor("crank_radius", "m", 0.065, 0.175),
    Factor("overlap_ratio", "", 0.05, 0.4),
    Factor("slimness", "", 1.9, 3.3),
    Factor("width_ratio", "", 1.5, 1.8),
)
RELATIONS = {
    "pin_diameter": "0.9 * crank_radius * (1 + overlap_ratio)",
    "main_journal_diameter": "1.1 * crank_radius * (1 + overlap_ratio)",
    "main_journal_length": "0.7 * pin_diameter",
    "pin_length": "0.75 * pin_diameter",
    "web_width": "width_ratio * pin_diameter",
    "web_thickness": "crank_radius / slimness",
    "fillet_radius": "0.06 * pin_diameter",
}


def puppet(throw):
    """Responses shaped like a throw's: a pin and webs in bending, stiffened by the overlap."""
    R, B, h, L, D = (
        throw[name]
        for name in ("crank_radius", "web_width", "web_thickness", "pin_length", "pin_diameter")
    )
    s = 0.5 * (D + throw["main_journal_diameter"]) - R
    pin = R**2 * (L + 0.33 * h) / (2.1e11 * math.pi * D**4 / 64)
    web = 8 * R**3 / (2.1e11 * B * (h**2 + 0.3 * s**2) ** 1.5)
    e = 0.6 * pin + 0.5 * web * (1.0 if throw["web_outline"] == "obround" else 0.9)
    return {
        "axial_compliance_pinned": e,
        "axial_compliance_in_line": 0.3 * e + 0.1 * pin,
        "torsional_compliance_pinned": e * (1.0 + B) / D**2,
        "axial_reaction_pinned": 0.0,  # nothing that relative errors could be taken of
        "mass": 7850 * (2 * B * h * 2 * R + D**2 * L),
        "unknown_to_all": 1.0,
    }


def puppet_table(plan, extra=()):
    planned = plan_designs(plan)
    outcomes = {}
    for place, design in enumerate(planned.designs):
        responses = puppet(design.inputs["throw"])
        errors = dict.fromkeys(responses, 0.009 + 1e-4 * (place % 3))
        outcomes[design.key] = Outcome(
            design.key, design.inputs, responses, None, 1.0, errors=errors
        )
    return study_table(plan, planned.designs, outcomes, extra, planned.excluded)


@pytest.fixture(scope="module")
def table():
    return puppet_table(plan_of_levels(THROW, LEVELS, held_out=12))


@pytest.fixture(scope="module")
def fits(table):
    return fit_study(table)


@pytest.fixture(scope="module")
def outlines():
    factors = (
        Factor("web_thickness", "m", 0.04, 0.09),
        Factor("fillet_radius", "m", 0.0, 0.012),
        Factor.of_labels("web_outline", ("obround", "rectangle")),
    )
    return puppet_table(StudyPlan(THROW, factors, DesignChoice("latin hypercube", runs=30)))


@pytest.fixture(scope="module")
def family():
    choice = DesignChoice("latin hypercube", runs=60)
    return puppet_table(StudyPlan(THROW, RATIOS, choice, relations=RELATIONS))


def test_forms_of_the_same_terms_stand_once(fits):
    told = [text for found in fits.values() for text in found.skipped]
    assert any("has the same terms as" in text for text in told)
    for found in fits.values():
        terms = [(f.basis, f.fitted.logarithmic, frozenset(f.fitted.terms)) for f in found.fits]
        assert len(set(terms)) == len(terms)


def test_a_form_is_found_by_the_name_of_its_twin(table, fits, capsys):
    """Interactions lose all products in the compliances, but not in the mass."""
    axial = fits["axial_compliance"]
    assert axial.twins == {"interactions": "linear"}
    assert axial.fit_named("interactions") is axial.fit_named("linear")
    assert "interactions" not in fits["mass"].twins
    model = compliance_model(table, fits, "interactions")
    assert {name: response.form for name, response in model.responses.items()} == {
        "axial_compliance": "linear",
        "axial_compliance_in_line": "linear",
        "torsional_compliance": "linear",
        "mass": "interactions",
    }
    print_parts(fitted_study(table, fits).answer("axial_compliance", "interactions"))
    assert "linear: e_n = " in " ".join(capsys.readouterr().out.split())


def test_a_response_without_equation_is_told(fits):
    for found in fits.values():
        assert list(found.unfitted) == ["axial_reaction_pinned"]
        assert "given a response of 0" in found.unfitted["axial_reaction_pinned"]


def test_the_record_of_a_study_fits_nothing_anew(table, fits, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError

    monkeypatch.setattr("crankfem.analyses.study.response_fits.fit_form", refuse)
    assert fitted_study(table, fits).unfitted == fits["mass"].unfitted


def test_imported_rows_without_errors_leave_the_others_known(table, fits):
    throw = THROW.model_dump(mode="json")
    values = tuple(throw[name] for name in LEVELS)
    bare = ExtraRow(
        "run",
        {n: v for n, v in throw.items() if isinstance(v, float)},
        {"web_outline": "obround"},
        values,
        puppet(throw),
        {},
        "earlier",
    )
    # A measured value has no error of finite elements, whatever its column says.
    measured = ExtraRow(
        "measured", bare.dimensions, bare.outlines, values, {"mass": 95.0}, {"mass": 0.5}, "scales"
    )
    more = fit_study(puppet_table(table.plan, (bare, measured)))
    for name in ("axial_compliance", "mass"):
        assert more[name].fits[0].runs == fits[name].fits[0].runs + 1
        assert more[name].fe_error == fits[name].fe_error == close(0.0092)
        assert more[name].fe_scatter == fits[name].fe_scatter


def test_response_names():
    assert response_name("influence_coefficient_pinned") == ("influence_coefficient", "pinned")
    assert response_name("axial_compliance_guided") == ("axial_compliance_guided", "guided")
    assert response_name("fillet_stress_factor") == ("fillet_stress_factor", "")


def test_groups_and_logarithms_of_lengths_are_the_same_in_one_size(fits):
    found = fits["axial_compliance"]
    one, other = found.fit_named("log-cubic"), found.fit_named("group cubic")
    assert one.largest_heldout_error == close(other.largest_heldout_error, rel=1e-6)
    assert found.chosen is one


@pytest.mark.slow
def test_family_carries_over_to_another_size(family):
    found = fit_study(family)["axial_compliance"]
    fit = found.fit_named("group quadratic")
    assert fit.factors == ("s/R", "R/h", "B/D_shm")
    # The same throws, half as large: twice the compliance.
    values = surface(family.plan, found, fit)
    half = family.values * [0.5, 1.0, 1.0, 1.0]
    assert values(half) == close(2.0 * values(family.values), rel=1e-12)
    # Nothing else differs between sizes: all errors come from the form, and fall with its degree.
    cubic = found.fit_named("group cubic")
    assert cubic.largest_heldout_error < 0.3 * fit.largest_heldout_error < 0.02


def test_dimensions_follow_from_relations(family):
    found = dimensions_at(family.plan, family.values, list(RELATIONS))
    for name in RELATIONS:
        assert found[name] == close(family.dimensions[name], rel=1e-10)


def test_groups_are_not_offered_where_a_part_keeps_its_size():
    throw = THROW.model_copy(update={"left_web": None})
    heavy = CrankThrow(**throw.model_dump() | {"left_web": {"thickness": 0.05}})
    plan = plan_of_levels(heavy, {"pin_diameter": (0.17, 0.18, 0.19)}, held_out=3)
    found = fit_study(puppet_table(plan))["axial_compliance"]
    assert all(fit.basis == "factors" for fit in found.fits)
    assert found.skipped


@pytest.mark.further
def test_sensitivities_under_a_constraint(capsys):
    """A plane over half of a rectangle, cut by a dimension that follows from one of the factors.

    With places a, b from 0 to 1 the constraint is a + b <= 1, whose indices of a + b are 1/4 (first), 3/4
    (total) and, as both are alike, 1/2 (Shapley).
    """
    plan = StudyPlan(
        THROW,
        (Factor("web_thickness", "m", 0.060, 0.080), Factor("pin_length", "m", 0.120, 0.160)),
        DesignChoice("latin hypercube", runs=12),
        relations={"main_journal_length": "400 mm - 2 * web_thickness"},
        constraints=("pin_length - main_journal_length <= -120 mm",),
    )
    table = table_of_function(plan, lambda x: 1e-9 * (1.0 + 100.0 * x[:, 0] + 50.0 * x[:, 1]))
    fits = fit_study(table)
    known = sensitivities(table, fits["axial_compliance"])
    for shares, each in zip(
        (known.sobol.first, known.sobol.total, known.sobol.shapley), (0.25, 0.75, 0.5), strict=True
    ):
        assert list(shares) == ["web_thickness", "pin_length"]
        assert [*shares.values()] == close([each, each], abs=0.015)
    print_parts(fitted_study(table, fits).parts())
    assert "Shapley" in capsys.readouterr().out


def test_nominal_of_free_names_is_the_middle(family, outlines):
    assert nominal_points(family.plan) == close([0.170, 0.225, 2.6, 1.65])
    assert nominal_points(outlines.plan) == close([0.068, 0.012, 0.0])


def test_model_gives_what_the_chosen_equation_gives(table, fits):
    model = compliance_model(table, fits)
    point = {"web_width": 0.311, "web_thickness": 0.055, "pin_length": 0.133}
    values = surface(table.plan, fits["axial_compliance"], fits["axial_compliance"].chosen)
    expected = float(values(np.array([list(point.values())]))[0])
    assert model.axial_compliance(**point) == close(expected, rel=1e-12)
    assert compliance_model(table, fits, "linear").responses["mass"].form == "linear"


# What a dimension may be spelled out as although it is so anyway, and its base with a range.
SPELLED_OUT = [
    ("pin_fillet_radius", 0.012, "fillet_radius", (0.008, 0.022)),
    ("main_journal_fillet_radius", 0.012, "fillet_radius", (0.008, 0.022)),
    ("web_journal_end", 0.1425, "web_width", (0.27, 0.30)),
    ("web_pin_end", 0.1425, "web_width", (0.27, 0.30)),
    ("web_tip_thickness", 0.068, "web_thickness", (0.060, 0.090)),
    ("web_foot_thickness", 0.068, "web_thickness", (0.060, 0.090)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "value", "base", "ends"), SPELLED_OUT)
def test_a_fixed_dimension_does_not_follow_its_base(name, value, base, ends):
    throw = CrankThrow(**THROW.model_dump() | {name: value})
    factors = (Factor(base, "m", *ends), Factor("pin_length", "m", 0.120, 0.158))
    table = puppet_table(StudyPlan(throw, factors, DesignChoice("latin hypercube", runs=12)))
    model = compliance_model(table, fit_study(table), "power law")
    assert model.fixed[name] == value
    # A throw of the study itself is answered; one in which the dimension follows is another one.
    other = {base: ends[1]}
    assert model.of_throw(CrankThrow(**throw.model_dump() | other)).keys() == model.responses.keys()
    with pytest.raises(InputError, match=f"^{name}: given"):
        model.of_throw(CrankThrow(**THROW.model_dump() | other))


@pytest.mark.slow
def test_models_of_ratios_and_categories(family, outlines):
    found = fit_study(family)
    model = compliance_model(family, found, "group quadratic")
    point = dict(zip(family.plan.names, family.values[0].tolist(), strict=True))
    fit = found["axial_compliance"].fit_named("group quadratic")
    expected = predicted(family, found["axial_compliance"], fit)[0]
    assert model.axial_compliance(**point) == close(expected, rel=1e-9)
    found = fit_study(outlines)
    model = compliance_model(outlines, found)
    place = int(np.flatnonzero(outlines.values[:, 2] == 1.0)[0])
    value = model.axial_compliance(
        web_thickness=outlines.values[place, 0],
        fillet_radius=outlines.values[place, 1],
        web_outline="rectangle",
    )
    chosen = found["axial_compliance"]
    assert value == close(predicted(outlines, chosen, chosen.chosen)[place], rel=1e-9)


@pytest.mark.slow
def test_record_is_plain_json_with_everything(table, fits):
    text = fitted_study(table, fits).to_json()
    record = json.loads(text)
    assert FittedStudy.from_json(text).to_json() == text
    assert numbers_with_units(record)
    assert (record["runs"], record["held_out"]) == (24, 12)
    assert record["factors"]["web_width"]["levels"] == [0.27, 0.30, 0.33]
    assert record["largest_fe_error_estimate"] == close(0.0092)
    axial = record["fits"]["axial_compliance"]
    assert axial["chosen"] == "log-cubic"
    chosen = next(form for form in axial["forms"] if form["form"] == "log-cubic")
    fit = fits["axial_compliance"].chosen
    assert chosen["coefficients"] == close(fit.coefficients)
    assert [row["term"] for row in chosen["coded"]] == list(fit.term_names)
    assert chosen["adjusted_r_squared"] < chosen["r_squared"]
    assert chosen["undetermined"]
    assert set(axial["sensitivities"]["elasticity"]) == set(LEVELS)
    assert record["unfitted"].keys() == {"axial_reaction_pinned"}


def test_warnings(fits):
    by_form = {fit.form: fit for fit in fits["axial_compliance"].fits}
    assert by_form["linear"].warnings == ()
    told = by_form["log-cubic"].warnings
    assert any("above 10 of ln(web_thickness)" in text for text in told)


@pytest.mark.slow
def test_measured_values_are_compared(tmp_path, capsys):
    plan = plan_of_levels(THROW, LEVELS, held_out=5)
    path = tmp_path / "measured.csv"
    path.write_text(
        "source,web_width [mm],crank_radius [mm],mass [kg],tilt_stiffness_ratio\n"
        "A,300,,95,2.0\n"
        "B,,175,95,\n"
    )
    table = puppet_table(plan, read_rows(path, plan))
    found = comparisons(table, compliance_model(table, fit_study(table)))
    mass = puppet(THROW.model_dump(mode="json") | {"web_width": 0.3})["mass"]
    assert found[0].ratio == close(mass / 95.0, rel=1e-6)
    assert "crank_radius: given 175 mm" in found[2].reason
    print_parts(comparison_parts(found))
    text = capsys.readouterr().out
    assert "Not compared: B" in text
    assert list(comparison_parts(())) == []


def test_measured_throws_have_the_part_of_their_line(tmp_path):
    """A counterweight's thickness is a factor, but no field of the throw itself."""
    throw = CrankThrow(
        **THROW.model_dump()
        | {"counterweight": {"thickness": 0.05, "outer_radius": 0.25, "angle": 1.5}}
    )
    factors = (
        Factor("counterweight.thickness", "m", 0.04, 0.06),
        Factor("web_width", "m", 0.27, 0.33),
    )
    plan = StudyPlan(throw, factors, DesignChoice("latin hypercube", runs=12))
    path = tmp_path / "measured.csv"
    # The second line lacks a factor, which then is the study's; the third is far outside the range.
    path.write_text(
        "counterweight.thickness [mm],web_width [mm],mass [kg]\n45,300,95\n45,,90\n45,360,99\n"
    )
    rows = read_rows(path, plan)
    planned = plan_designs(plan)

    def weight(given):
        return {"mass": 1e3 * given["web_width"] * given["counterweight"]["thickness"]}

    outcomes = {
        design.key: Outcome(design.key, design.inputs, weight(design.inputs["throw"]), None, 1.0)
        for design in planned.designs
    }
    table = study_table(plan, planned.designs, outcomes, rows)
    found = comparisons(table, compliance_model(table, fit_study(table), "power law"))
    for one, width in zip(found, (0.3, throw.web_width, 0.36), strict=True):
        assert one.calculated == close(1e3 * width * 0.045, rel=1e-9)
    assert [len(one.remarks) for one in found] == [0, 0, 1]
    assert "360 mm" in found[2].remarks[0]


@pytest.mark.further
@pytest.mark.parametrize("study", ["outlines", "table", "family"])
def test_diagrams(study, request, tmp_path):
    some = request.getfixturevalue(study)
    paths = plot_fits(tmp_path / "plots", some, fit_study(some)["axial_compliance"])
    assert [path.name for path in paths] == [
        f"axial_compliance_{name}.svg"
        for name in ("response", "parity", "effects", "sensitivities")
    ]
    for path in paths:
        # Well-formed, and more than empty axes.
        drawing = ElementTree.parse(path).getroot()
        assert len(list(drawing.iter("{http://www.w3.org/2000/svg}use"))) > 10


def test_diagrams_need_a_folder(table, fits, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match=r"folder: "):
        plot_fits(tmp_path / "taken", table, fits["mass"])


def test_no_held_out_design_with_a_result(table):
    plan = table.plan
    planned = plan_designs(plan)
    outcomes = {
        design.key: Outcome(design.key, design.inputs, puppet(design.inputs["throw"]), None, 1.0)
        for design in planned.designs
        if design.role == "run"
    }
    with pytest.raises(InputError, match="held-out design"):
        fit_study(study_table(plan, planned.designs, outcomes))
