"""Values and slopes fitted together, and slopes that contradict the rest."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.study.fit_records import fitted_study
from crankfem.analyses.study.response_fits import fit_study
from crankfem.analyses.study.studies import worst_designs
from plans import SHARP
from regression.fits.fits import fit_form
from regression.fits.forms import design_matrix
from regression.fits.run_slopes import RunSlopes, derivatives
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.records import RUN
from sloped_studies import (
    FACTORS,
    HALF,
    HIGH,
    LOW,
    NAME,
    box,
    compliance,
    plan,
    slopes_of,
    table_with_slopes,
)


def function_of(form, seed):
    """A function of a form, made of random coefficients, and the number of these."""
    rng = np.random.default_rng(seed)
    runs = box(60, 1)
    fitted = fit_form(form, FACTORS, runs, np.exp(rng.normal(0.0, 0.1, 60))).fitted
    if not fitted.logarithmic:
        rest = (3.0, *rng.uniform(-0.1, 0.1, len(fitted.terms) - 1))
        fitted = fitted.changed(coefficients=rest)
    return fitted.predict, len(fitted.terms)


@pytest.mark.parametrize("form", ["quadratic", "power law", "log-quadratic", "log-cubic"])
@settings(deadline=None, max_examples=8)
@given(seed=st.integers(0, 99))
def test_a_form_is_found_again_in_fewer_runs_than_coefficients(form, seed):
    function, count = function_of(form, seed)
    x = box(count // 2, seed + 7)
    with pytest.raises(InputError, match="are needed"):
        fit_form(form, FACTORS, x, function(x))
    found = fit_form(form, FACTORS, x, function(x), slopes=slopes_of(function, x))
    at = box(20, 3)
    assert found.predict(at) == close(function(at), rel=1e-6)
    assert found.runs == len(x)
    assert found.r_squared == close(1.0, abs=1e-9)


def test_two_levels_with_slopes_are_enough_for_cubes():
    function, _ = function_of("log-cubic", 5)
    corners = np.array(list(itertools.product(*zip(LOW, HIGH, strict=True))))
    found = fit_form(
        "log-cubic", FACTORS, corners, function(corners), slopes=slopes_of(function, corners)
    )
    assert found.undetermined == ()
    assert found.predict(box(20, 3)) == close(function(box(20, 3)), rel=1e-6)


@pytest.mark.parametrize("drop_terms", [False, True])
def test_q_squared_leaves_out_each_run_with_its_slopes(drop_terms):
    def function(x):
        return 1e-9 * np.exp(np.sin(12.0 * x[:, 1]) + x[:, 0] * x[:, 2])

    x = box(9, 4)
    slopes, y = slopes_of(function, x), function(x)
    left_out = []
    for run in range(9):
        others = np.arange(9) != run
        rest = RunSlopes(slopes.values[others], slopes.weights[others], slopes.turned[others])
        fit = fit_form(
            "log-quadratic", FACTORS, x[others], y[others], slopes=rest, drop_terms=drop_terms
        )
        left_out.append(fit.predict(x[run]))
    expected = 1.0 - np.sum((y - left_out) ** 2) / np.sum((y - y.mean()) ** 2)
    found = fit_form("log-quadratic", FACTORS, x, y, slopes=slopes, drop_terms=drop_terms)
    assert found.q_squared == close(expected, rel=1e-6)


def test_derivatives_of_terms():
    terms = ((), (0,), (1,), (0, 0), (1, 1), (0, 1), (0, 0, 1), (1, 1, 1))
    at, shift = np.array([[0.3, -0.7], [1.1, 0.0]]), 1e-6
    for column in (0, 1):
        step = shift * np.eye(2)[column]
        change = design_matrix(terms, at + step) - design_matrix(terms, at - step)
        assert derivatives(terms, at, column) == close(change / (2.0 * shift), abs=1e-8)


def test_a_weight_of_zero_is_as_good_as_no_slope():
    x, form = box(25, 6), "log-quadratic"
    y = 1.0 / x[:, 1] ** 1.5 + x[:, 0]
    wrong = RunSlopes(
        np.ones((25, 3)), np.zeros((25, 3)), np.broadcast_to(np.diag(HALF), (25, 3, 3))
    )
    plain, weightless = fit_form(form, FACTORS, x, y), fit_form(form, FACTORS, x, y, slopes=wrong)
    assert weightless.predict(x) == close(plain.predict(x), rel=1e-9)


def test_slopes_over_ratios_and_relations_follow_by_the_chain_rule():
    ratio = Factor("width_ratio", "", 1.5, 1.8)
    length = Factor("pin_length", "m", 0.120, 0.158)
    relations = {
        "web_width": "width_ratio * pin_diameter",
        "web_thickness": "0.25 * web_width + 0.1 * pin_length",
    }
    made = StudyPlan(
        SHARP, (ratio, length), DesignChoice("sobol", runs=8), relations, slopes=True, held_out=8
    )
    table = table_with_slopes(made)
    runs = ~table.held_out
    found = table.slopes[NAME][runs]
    steps = np.diag([1e-6, 1e-7])
    for place, step in enumerate(steps):
        ends = [
            np.array(
                [
                    compliance(one.throw)
                    for one in made.variants().at(table.values[runs] + sign * step)
                ]
            )
            for sign in (-1.0, 1.0)
        ]
        assert found[:, place] == close((ends[1] - ends[0]) / (2.0 * step[place]), rel=1e-4)
    assert np.isnan(table.slopes[NAME][~runs]).all()
    assert fit_study(table)["axial_compliance"].slopes == 16


def test_eight_runs_with_slopes_fit_as_well_as_many_without():
    table = table_with_slopes(plan(runs=8, held_out=30))
    found = fit_study(table)["axial_compliance"]
    assert found.left_out_slopes == ()
    assert found.chosen.largest_heldout_error < 0.004
    without = replace(table, slopes={}, slope_errors={})
    assert fit_study(without)["axial_compliance"].chosen.largest_heldout_error > 0.02


def sizes_plan():
    """Throws of different size: the groups differ from the factors, and the response's scale changes."""
    sizes = [("crank_radius", 0.15, 0.19), ("pin_diameter", 0.16, 0.20)]
    ratios = [Factor(name, "m", low, high) for name, low, high in sizes]
    thick = Factor("web_thickness", "m", 0.05, 0.08)
    shares = {
        "main_journal_diameter": 1.2,
        "web_width": 1.6,
        "pin_length": 0.75,
        "fillet_radius": 0.07,
    }
    shares["main_journal_length"] = 0.7
    relations = {name: f"{share} * pin_diameter" for name, share in shares.items()}
    design = DesignChoice("latin hypercube", runs=6)
    return StudyPlan(SHARP, (*ratios, thick), design, relations, slopes=True, held_out=10)


@pytest.mark.slow
def test_a_power_law_in_groups_is_exact_with_slopes():
    made = sizes_plan()
    table = table_with_slopes(made)

    def law(sizes):
        overlap = (
            0.5 * (sizes["main_journal_diameter"] + sizes["pin_diameter"]) / sizes["crank_radius"]
        )
        thin = sizes["crank_radius"] / sizes["web_thickness"]
        return 1e-11 / sizes["pin_diameter"] * np.exp(-0.6 * overlap + 1.3 * np.log(thin))

    y, runs = law(table.dimensions), ~table.held_out
    slopes = np.full_like(table.values, np.nan)
    for place in range(3):
        variants = made.variants()
        less, more, step = variants.beside(table.values[runs], place)
        low, high = variants.fields_at(less), variants.fields_at(more)
        slopes[runs, place] = (law(high) - law(low)) / (2.0 * step)
    exact = replace(table, responses={NAME: y}, slopes={NAME: slopes})
    found = fit_study(exact)["axial_compliance"]
    group = found.fit_named("group power law")
    assert group.largest_heldout_error < 1e-7
    assert found.left_out_slopes == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "found"),
    [
        (
            lambda run, over: (
                over | {"web_thickness": -over["web_thickness"]} if run == 3 else over
            ),
            1,
        ),
        (lambda run, over: dict.fromkeys(over, 0.0) if run == 5 else over, 3),
        (lambda _, over: over | {"pin_length": -over["pin_length"]}, 10),
    ],
    ids=["one", "those of a run", "all over a factor"],
)
def test_wrong_slopes_are_found_and_left_out(change, found):
    made = plan()
    right = fit_study(table_with_slopes(made))["axial_compliance"]
    table = table_with_slopes(made, change)
    fits = fit_study(table)["axial_compliance"]
    assert (right.slopes, fits.slopes) == (30, 30 - found)
    assert len(fits.left_out_slopes) == (1 if found == 10 else found)
    assert fits.chosen.largest_heldout_error < 3.0 * right.chosen.largest_heldout_error
    if found == 1:
        thickness = made.factors[1].format_value(table.values[~table.held_out][3, 1])
        assert fits.left_out_slopes[0].startswith("over web_thickness at web_width ")
        assert f"web_thickness {thickness}" in fits.left_out_slopes[0]
    if found == 10:
        assert fits.left_out_slopes == ("all over pin_length",)
    shown = [str(part) for part in fitted_study(table, {"axial_compliance": fits}).parts()]
    assert any("; ".join(fits.left_out_slopes) in part for part in shown)
    assert any(f"Fitted to {30 - found} slopes" in part for part in shown)


@pytest.mark.slow
def test_further_runs_are_chosen_with_fewer_runs_than_coefficients():
    table = table_with_slopes(plan(runs=8))
    fits = fit_study(table)
    assert fits["axial_compliance"].chosen.coefficient_count > 8
    added = worst_designs(table, fits, 2)
    assert added.shape == (2, 3)
    assert np.all((added >= LOW) & (added <= HIGH))


def test_plans_without_slopes_keep_their_keys():
    made = plan()
    plain = replace(made, slopes=False)
    assert "slopes" not in plain.as_record()
    assert all("slopes" not in design.inputs for design in plain.planned.designs)
    assert StudyPlan.from_record(made.as_record()) == made
    assert StudyPlan.from_record(plain.as_record()) == plain
    # Held-out designs are the same; they need no slopes.
    held = [{d.key for d in one.planned.designs if d.role != RUN} for one in (made, plain)]
    assert held[0] == held[1]
