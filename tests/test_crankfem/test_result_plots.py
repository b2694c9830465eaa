"""Diagrams and tables of the results that the face gives, and that every public result has some.

What draws the curves is tested where it lives; here it is tested that the right numbers get there.
"""

import inspect
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankbase.results import Result
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.study.response_fits import predicted
from crankfem.analyses.study.studies import fitted
from crankfem.analyses.throw.formula_records import (
    plot_formulas,
    plot_formulas_over_angle,
    plot_run_formulas,
)
from crankfem.analyses.titles import short_name
from crankfem.analyses.vibration import run as vibration_run
from crankfem.analyses.vibration.run_up import run_up
from crankfem.files.engine.engine_file import load_mechanism
from crankfem.files.reading.data_files import input_path
from crankfem.report.interactive.vibration import VIBRATION
from geometry.mass import MassProperties
from plans import plan_of_levels
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.case import FormulaValue
from regression.plans.plan import plan_designs
from regression.records import Outcome
from regression.runs.study_table import study_table

# What a plot may take by its place: which of several things is drawn.
PLACES = {"place", "node", "element", "cylinder", "throw", "point"}


METHODS = ("plot", "to_pandas", "to_xarray")


def is_special(kind, method):
    """Tell whether a class has a method that not every result has."""
    return hasattr(kind, method) and getattr(kind, method) is not getattr(Result, method, None)


def said_of_classes(public):
    """Of each class in the table of the page on plots, whether it draws, tabulates, makes a grid."""
    kinds = {name.rpartition(".")[2]: one for name, one in public.items()}
    page = Path(__file__).parents[2] / "docs/plots.md"
    said = {}
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("| `"):
            first, *cells = (cell.strip() for cell in line.strip("|").split("|"))
            for name in re.findall(r"`(\w+)`", first):
                assert name in kinds, name
                assert name not in said, f"{name} has two rows"
                said[name] = tuple(bool(cell) for cell in cells)
    return {name: own for name, own in said.items() if inspect.isclass(kinds[name])}


def test_the_table_of_results_is_true(public, public_classes):
    ways = {
        name: tuple(hasattr(one, own) for own in METHODS) for name, one in public_classes.items()
    }
    special = {
        name: tuple(is_special(one, own) for own in METHODS) for name, one in public_classes.items()
    }
    said = said_of_classes(public)
    assert {name for name, own in special.items() if any(own)} <= set(said)
    for name, own in said.items():  # a row of one result, which all have, may be told or not
        pairs = zip(special[name], own, ways[name], strict=True)
        assert all(least <= told <= most for least, told, most in pairs), name


def test_all_plots_take_axes_first(public_classes):
    for name, one in public_classes.items():
        if hasattr(one, "plot"):
            _, axes, *others = inspect.signature(one.plot).parameters.values()
            assert (axes.name, axes.default) == ("axes", None), name
            named = {one.name for one in others if one.kind is not one.POSITIONAL_OR_KEYWORD}
            assert {one.name for one in others} - named <= PLACES, name


# ----------------------------------------------------------------------------------- studies


def compliance(width, thickness):
    return 1.2e-9 * (width / 0.3) ** -0.8 * (thickness / 0.07) ** -1.2


@pytest.fixture(scope="module")
def study(dimensions):
    """A study with a power law instead of finite elements."""
    levels = {"web_width": (0.27, 0.30, 0.33), "web_thickness": (0.05, 0.07, 0.09)}
    plan = plan_of_levels(cf.CrankThrow(**dimensions), levels, held_out=3)
    planned = plan_designs(plan)
    outcomes = {}
    for design in planned.designs:
        throw = design.inputs["throw"]
        value = {"axial_compliance_pinned": compliance(throw["web_width"], throw["web_thickness"])}
        outcomes[design.key] = Outcome(design.key, design.inputs, value, None, 1.0)
    return fitted(study_table(plan, planned.designs, outcomes))


def test_parity_of_a_study(study):
    axes = study.plot(form="linear")
    found = study.fits["axial_compliance"]
    values = predicted(study.table, found, found.fit_named("linear"))
    _, runs, held = axes.lines
    assert runs.get_ydata() == close(1e9 * values[~study.table.held_out])
    assert held.get_xdata() == close(
        1e9 * study.table.responses["axial_compliance_pinned"][study.table.held_out]
    )
    assert "[$10^{-9}$ m/N]" in axes.get_xlabel()


@pytest.mark.parametrize("show", ["response", "effects", "elasticities", "sobol"])
def test_other_diagrams_of_a_study(study, show):
    given = pyplot.figure().add_subplot()
    along = {"factor": "web_thickness"} if show == "response" else {}
    assert study.plot(given, show=show, **along) is given
    assert given.get_xlabel()
    assert given.lines or given.patches


def test_elasticities_are_the_exponents(study):
    axes = study.plot(show="elasticities")
    # The chosen equation is the power law itself, to the round-off of its fit.
    assert [bar.get_width() for bar in axes.patches] == close([-0.8, -1.2], rel=1e-6)


def test_forms_of_a_response(study):
    found = study.fits["axial_compliance"]
    frame = found.to_pandas()
    assert frame.loc[frame["chosen"], "form"].item() == found.chosen.form
    assert [bar.get_width() for bar in found.plot().patches] == close(
        [100.0 * fit.largest_heldout_error for fit in found.fits]
    )
    assert study.to_pandas()["held_out"].sum() == 3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"show": "all"}, "show: given 'all'; allowed are parity, response, effects, "),
        ({"response": "mass"}, "response: given 'mass'; allowed are axial_compliance, because"),
        ({"show": "response", "factor": "fillet"}, "factor: given 'fillet'; allowed are"),
        ({"factor": "web_width"}, "factor: given 'web_width' with 'parity'; allowed is none, "),
        ({"show": "sobol", "form": "linear"}, "form: given 'linear' with 'sobol'; allowed is none"),
        ({"form": "magic"}, "form: given 'magic'; allowed are"),
    ],
)
def test_a_study_refuses_what_it_has_not(study, options, message):
    with pytest.raises(InputError, match=message):
        study.plot(**options)
    assert not pyplot.get_fignums()


# ---------------------------------------------------------------------------------- formulas


def test_formulas_of_a_throw_in_bars(dimensions):
    found = axial_formulas(cf.CrankThrow(**dimensions), gamma_deg=180)
    axes = plot_formulas(found, finite_elements=1.25e-9)
    values = [1e9 * one.value for one in found.values()]
    assert [bar.get_width() for bar in axes.patches] == close(values)
    assert axes.lines[0].get_xdata()[0] == close(1.25)
    assert axes.get_xlabel() == "axial compliance [$10^{-9}$ m/N]"
    twist = FormulaValue(1e-8, True, (), "", "rad/(N m)", "corrected")
    with pytest.raises(InputError, match=r"found: "):
        plot_formulas({**found, "twist": twist})
    for wrong in ("a", -3):
        with pytest.raises(InputError, match=r"finite_elements: given .*; allowed are"):
            plot_formulas(found, finite_elements=wrong)


def test_formulas_over_the_angle(dimensions):
    throw = cf.CrankThrow(**dimensions)
    axes = plot_formulas_over_angle(throw)
    assert {line.get_label(): line.get_ydata()[12] for line in axes.lines} == {
        name: close(1e9 * one.value if one.value > 0.0 else np.nan, nan_ok=True)
        for name, one in axial_formulas(throw, gamma_deg=60.0).items()
    }


def test_a_runs_formulas():
    path = Path(__file__).with_name("report_results.json")
    stored = json.loads(path.read_text(encoding="utf-8"))["throw"]
    stored["supports"]["guided"]["axial_compliance"] = 3e-10
    results = {
        "angle_law": {
            "gamma_deg": [0.0, 180.0],
            "fe": [3e-10, 1.2e-9],
            "formulas": {"one": [None, 2e-9]},
            "law": None,
        },
        "throw": stored,
    }
    axes = plot_run_formulas(results)
    assert axes.lines[0].get_ydata() == close([np.nan, 2.0], nan_ok=True)
    assert axes.lines[1].get_ydata() == close([0.3, 1.2])
    assert axes.lines[2].get_ydata() == close([0.3, 0.3])
    with pytest.raises(InputError, match=r"results: "):
        plot_run_formulas({})


# --------------------------------------------------------------------------------- mechanism


@pytest.fixture(scope="module")
def mechanism():
    masses = MassProperties(100.0, np.array([0.0, 0.05, 0.2]), np.eye(3))
    return run_mechanism(load_mechanism(input_path("6chn25-34")), masses=masses)


def test_a_mechanism(mechanism):
    axes = mechanism.plot()
    assert axes.lines[0].get_ydata()[:-1] == close(1e-3 * mechanism.torque.total)
    assert "[kN m]" in axes.get_ylabel()
    for show in ("forces", "pressure", "crankpin", "bearing"):
        assert mechanism.plot(show=show, number=1).has_data(), show
    # Of a six nothing is left over.
    balanced = mechanism.plot(show="moment balance")
    assert balanced.get_title(loc="left").startswith("moment of inertia forces")
    assert not balanced.has_data()
    assert mechanism.to_pandas()["work"].tolist() == [one.work for one in mechanism.works]
    for options, message in (
        ({"show": "bearing", "number": 8}, "number: given 8; allowed is 1 to 7 for the bearings, "),
        ({"show": "forces", "number": 99}, "number: given 99; allowed is 1 to 6 for the cylinders"),
        ({"number": 1}, "number: given 1 with 'torque'; allowed is none, because"),
        ({"show": "pressure", "frame": "crank"}, "frame: given 'crank' with 'pressure'; allowed"),
    ):
        with pytest.raises(InputError, match=message):
            mechanism.plot(**options)


# --------------------------------------------------------------------------------- vibration


def test_nodes_have_short_names():
    assert short_name("cylinder 6, flywheel") == "cyl. 6\nflywheel"


@pytest.fixture(scope="module")
def vibration(coupled_vibration):
    return coupled_vibration("6chn25-34")


@pytest.mark.slow
def test_what_an_engines_vibration_is_made_of(vibration):
    free, forced = vibration.torsional, vibration.forced_torsional
    axes = free.plot()
    assert axes.lines[-2].get_ydata() is not None
    assert "twist" in axes.get_ylabel()
    assert free.to_pandas()["speed"].tolist() == [one.speed for one in free.criticals]
    frame = forced.to_pandas()
    assert len(frame) == len(forced.resonances)
    assert frame.attrs["units"]["amplitude"] == "rad"
    # Both tables of a chain count its elastic modes from 1.
    numbers = {one.frequency: one.mode for one in free.criticals}
    assert all(
        numbers.get(one.frequency, mode) == mode
        for one, mode in zip(forced.resonances, frame["mode"], strict=True)
    )
    for wrong in ({"count": "a"}, {"count": 0}, {"count": -2}):
        with pytest.raises(InputError, match="count: given"):
            free.plot(**wrong)
    with pytest.raises(InputError, match=r"barred: "):
        forced.plot(show="power", barred=[(80.0, 90.0)])
    assert forced.to_xarray().sizes["speed"] == len(forced.response.speeds)
    assert vibration.forced_axial.plot(show="axial forces").has_data()
    assert vibration.forced is vibration.forced_torsional

    bounds = vibration.assessment.torsional
    assert bounds.to_pandas()["highest"].to_numpy() == close(
        [mode.highest for mode in bounds.frequencies]
    )
    assert len(vibration.assessment.to_pandas()) == len(vibration.assessment.verdict.checks)

    shaft = vibration.whole
    assert len(shaft.to_pandas()) == len(shaft.modes.frequencies)
    assert shaft.plot(mode=3, radius=0.17).has_data()
    axes = vibration.comparison.plot(show="axial")
    assert axes.lines[0].get_ydata() == close(1e6 * vibration.comparison.axial.response.shaft)
    assert vibration.comparison.plot().has_data()
    looked_at = sum(len(one.modes) for one in vibration.comparison.verdicts)
    assert len(vibration.comparison.to_pandas()) == looked_at


def test_a_backend_that_turns_on_interactive_drawing_keeps_it(monkeypatch):
    made = pyplot.figure

    def selecting(*arguments, **options):
        # As the inline backend of notebooks, selected by the first figure.
        pyplot.ion()
        return made(*arguments, **options)

    with pyplot.ioff(), monkeypatch.context() as patch:
        patch.setattr(pyplot, "figure", selecting)
        pyplot.close(cf.Chain([0.1, 0.78], [9e5]).modes().plot().figure)
        assert pyplot.isinteractive()


@pytest.mark.slow
def test_campbell_diagrams_without_gas_have_dots_in_files_too(vibration, tmp_path, monkeypatch):
    drawn = {}
    monkeypatch.setattr(
        vibration_run,
        "draw_campbell",
        lambda _, frequencies, *given: drawn.update({tuple(frequencies): given[2]}),
    )
    free = replace(vibration, forced_axial=None, forced_torsional=None, assessment=None)
    for one in VIBRATION.of(free):
        if one.name.endswith("campbell"):
            one.draw(tmp_path, free)
    own = {
        tuple(one.chosen.elastic_frequencies): one.criticals for one in (free.axial, free.torsional)
    }
    assert {name: [dot.frequency for dot in found] for name, found in drawn.items()} == {
        name: [one.frequency for one in found] for name, found in own.items()
    }
    assert all(drawn.values())


@pytest.mark.slow
def test_a_run_up(vibration):
    found = run_up(vibration, 0.5)
    assert found.largest[found.worst] == max(found.largest)
    assert found.plot().has_data()
    frame = found.to_pandas()
    assert frame["largest"].to_numpy() == close(found.largest)
    name = frame["element"][found.worst]
    assert found.plot(element=name).get_title(loc="left") == name
