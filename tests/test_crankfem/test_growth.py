"""Studies that grow, with functions in place of finite elements.

The function is shaped like a throw: a pin in bending and in compression, and webs whose softness goes with
about the third power of their thickness. None of the forms has it, so all of them err between the runs.
"""

import math

import numpy as np
import pytest

from crankbase.errors import InputError
from crankfem.analyses.study import studies
from crankfem.analyses.study.response_fits import fit_study, surface
from crankfem.analyses.study.studies import run_grown, worst_designs
from plans import FILLETED, plan_of_levels, table_of_function
from puppets import puppet
from regression.plans.designs import DesignChoice, values_at
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.runs import workers
from regression.runs.store import ResultStore
from regression.runs.study import read_study

THROW = FILLETED
BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.040, 0.100), "pin_length": (0.120, 0.158)}
DESIGNS = {
    "full factorial": {"levels": 3},
    "fractional factorial": {"resolution": 3},
    "central composite": {},
    "box-behnken": {},
    "latin hypercube": {"runs": 24},
    "sobol": {"runs": 32},
}


def compliance(x):
    width, thickness, length = x[:, 0], x[:, 1], x[:, 2]
    pin = 0.17**2 * (length + 0.33 * thickness) / (2.1e11 * math.pi * 0.18**4 / 64)
    web = 8 * 0.17**3 / (2.1e11 * width * (thickness**2 + 0.03**2) ** 1.5)
    return 0.6 * pin + 0.5 * web


def plan_of(kind, seed=1, **others):
    given = dict(DESIGNS[kind])
    levels = given.pop("levels", None)
    factors = tuple(
        Factor(name, "m", *ends)
        if levels is None
        else Factor.spread(name, "m", *ends, levels, "even")
        for name, ends in BOX.items()
    )
    return StudyPlan(THROW, factors, DesignChoice(kind, **given), seed=seed, **others)


def largest_error(table):
    """Of the chosen equation, at 2000 points that no study has."""
    x = values_at(table.plan.factors, np.random.default_rng(99).random((2000, 3)))
    found = fit_study(table)["axial_compliance"]
    return np.max(np.abs(surface(table.plan, found, found.chosen)(x) / compliance(x) - 1.0))


@pytest.mark.slow
@pytest.mark.parametrize("kind", DESIGNS)
def test_runs_where_the_equation_is_worst_help_more_than_as_many_random_ones(monkeypatch, kind):
    monkeypatch.setattr(studies, "PLACES", 300)
    before, grown, by_chance = [], [], []
    for seed in range(1, 4):
        plan = plan_of(kind, seed)
        table = table_of_function(plan, compliance)
        before.append(largest_error(table))
        grown.append(
            largest_error(
                table_of_function(plan, compliance, worst_designs(table, fit_study(table), 10))
            )
        )
        random = values_at(plan.factors, np.random.default_rng(seed).random((10, 3)))
        by_chance.append(largest_error(table_of_function(plan, compliance, random)))
    assert np.median(grown) < 0.9 * np.median(by_chance)
    assert np.median(grown) < 0.9 * np.median(before)


def test_added_runs_keep_constraints_and_relations_and_are_new(monkeypatch):
    monkeypatch.setattr(studies, "PLACES", 100)
    factors = (
        Factor("web_width", "m", 0.270, 0.330),
        Factor("web_thickness", "m", 0.040, 0.100),
        Factor("pin_length", "m", 0.120, 0.158),
        Factor.of_labels("web_outline", ("obround", "rectangle")),
    )
    plan = StudyPlan(
        THROW,
        factors,
        DesignChoice("latin hypercube", runs=24),
        relations={"main_journal_length": "400 mm - pin_length - 2 * web_thickness"},
        constraints=("web_width > 240 mm + web_thickness",),
    )
    table = table_of_function(plan, compliance)
    found = worst_designs(table, fit_study(table), 12)
    assert all(variant.throw is not None for variant in plan.variants().at(found))
    assert np.all(found[:, 0] > 0.240 + found[:, 1] - 1e-9)
    assert set(found[:, 3]) <= {0.0, 1.0}
    present = {row.values for row in table.rows}
    assert len({tuple(row) for row in found.tolist()} - present) == 12


WORKER = """
for request in requests():
    throw = request["inputs"]["throw"]
    value = 1e-9 * (throw["web_width"] / 0.3) ** -2.2 * (0.5 + throw["pin_length"] / 0.139)
    responses = {"axial_compliance_pinned": value}
    found = {"key": request["key"], "responses": responses, "errors": {}, "seconds": 0.5}
    answer(found | {"unknowns": 9})
"""
TWO = {"web_width": (0.280, 0.300, 0.330), "pin_length": (0.130, 0.150, 0.170)}


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(workers, "spawn_worker", lambda: puppet(WORKER))
    monkeypatch.setattr(studies, "PLACES", 60)


def test_the_store_remembers_what_was_added(quick, tmp_path):
    plan = plan_of_levels(THROW, TWO, held_out=3)
    store = tmp_path / "runs.sqlite"
    first = run_grown(plan, store, more=4)
    assert (first.added, first.computed, len(first.values)) == (4, 9 + 3 + 4, 16)
    again = run_grown(plan, store, more=4)
    assert (again.added, again.computed) == (4, 0)
    assert run_grown(plan, store).added == 4  # without being asked for
    assert [row.values for row in again.rows] == [row.values for row in first.rows]
    larger = run_grown(plan, store, more=6)
    assert (larger.added, larger.computed) == (6, 2)
    assert [row.values for row in larger.rows[:16]] == [row.values for row in first.rows]
    read = read_study(store)
    assert read.plan.key == plan.key
    assert (read.added, len(read.values), int(read.held_out.sum())) == (6, 18, 3)


def test_an_interrupted_growth_goes_on_with_the_same_runs(quick, tmp_path):
    plan = plan_of_levels(THROW, TWO, held_out=3)
    store = tmp_path / "runs.sqlite"

    def interrupt(finished, *_):
        if finished == 14:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_grown(plan, store, progress=interrupt, more=4)
    chosen = [design[2] for design in read_designs(store, plan)]
    table = run_grown(plan, store, more=4)
    assert (table.added, len(table.values)) == (4, 16)
    assert table.computed <= 2
    assert [design[2] for design in read_designs(store, plan)] == chosen


def read_designs(store, plan):
    with ResultStore(store, readonly=True) as results:
        return results.study_designs(plan.key)


@pytest.mark.parametrize("more", [-1, 1001, 2.5, True])
def test_numbers_that_no_study_grows_by(tmp_path, more):
    plan = plan_of_levels(THROW, TWO, held_out=3)
    with pytest.raises(InputError, match=r"^more: given .*; allowed is 0 to 1000 further designs"):
        run_grown(plan, tmp_path / "runs.sqlite", more=more)
    assert not (tmp_path / "runs.sqlite").exists()


def test_too_few_throws_to_grow_by(monkeypatch):
    plan = plan_of("latin hypercube")
    table = table_of_function(plan, compliance)
    monkeypatch.setattr(studies, "draw_feasible_points", lambda *_, **__: None)
    with pytest.raises(InputError, match=r"^more: given 10 further designs; allowed are as many"):
        worst_designs(table, fit_study(table), 10)
