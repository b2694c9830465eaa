"""Studies on moved meshes: classes and anchors by the plan alone, answers scaled, runs that continue."""

import sqlite3
from contextlib import closing
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from plans import FILLETED, SHARP, plan_of_levels
from puppets import puppet
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.moved_meshes import anchor_count, mesh_classes
from regression.plans.plan import StudyPlan
from regression.records import MOVED, RUN, Outcome
from regression.runs import study as study_module
from regression.runs import workers as workers_module
from regression.runs.cluster import compute_design, identity
from regression.runs.exchange import columns
from regression.runs.moved_answers import ratio_fit, scaled_answers
from regression.runs.reference_meshes import ReferenceMeshes
from regression.runs.study import add_runs, import_results, read_study, run_plan
from regression.runs.study_table import study_table
from regression.runs.workers import design_limits

NAME = "axial_compliance_pinned"
RANGES = {"web_width": (0.28, 0.29), "pin_length": (0.13, 0.145), "web_thickness": (0.065, 0.07)}
FACTORS = tuple(Factor(name, "m", *ends) for name, ends in RANGES.items())
LARGE = DesignChoice("latin hypercube", runs=80)


def plan(runs=20, accuracy=0.02, **others):
    design = DesignChoice("latin hypercube", runs=runs)
    return StudyPlan(FILLETED, FACTORS, design, accuracy=accuracy, mesh="moved", **others)


def outcome(key, inputs, value, tier=None):
    mesh = {} if tier is None else {"tier": tier, "quality": 0.3, "reference": "abc"}
    return Outcome(key, inputs, {NAME: value}, None, 0.1, errors={NAME: 0.02}, mesh=mesh)


def shape(values):
    """True answer, and that of the moved mesh, of which it is a share that is linear in logarithms."""
    coded = (np.array(values) - 0.1) / 0.05
    truth = 1e-9 * (1.0 + 0.3 * coded[0] - 0.2 * coded[1] ** 2)
    logs = np.log(values)
    return truth, truth / (1.05 + 0.02 * logs[0] - 0.01 * logs[2])


def outcomes_of(planned):
    outcomes = {}
    for design in planned.designs:
        truth, coarse = shape(design.values)
        outcomes[design.key] = outcome(design.key, design.inputs, coarse, "velocities")
        if design.ordinary:
            outcomes[design.ordinary[0]] = outcome(*design.ordinary, truth)
    return outcomes


def test_numbers_of_anchors():
    assert anchor_count(11, 3, 0.01) == 0
    assert anchor_count(33, 3, 0.02) == 1
    assert anchor_count(33, 3, 0.01) == anchor_count(400, 3, 0.02) == 6
    assert anchor_count(60, 5, 0.01) == 9
    assert anchor_count(19, 5, 0.01) == 0


def test_classes_follow_from_topology_and_the_middle_throw_lends_its_mesh():
    throws = [
        FILLETED.changed(web_width=width, fillet_radius=fillet).model_dump(mode="json")
        for fillet in (0.012, 0.0)
        for width in (0.28, 0.285, 0.29, 0.295)
    ]
    widths = np.array([[throw["web_width"]] for throw in throws])
    first, second = mesh_classes(throws, widths, 0.02)
    assert (first.members, second.members) == ((0, 1, 2, 3), (4, 5, 6, 7))
    assert first.throw is throws[first.anchors[0]]
    assert first.anchors in ((1,), (2,))
    # Too few of the second kind; further throws decide nothing.
    (only,) = mesh_classes(throws[:7], widths[:7], 0.02)
    assert only.members == first.members
    (same,) = mesh_classes(throws, widths[:4], 0.02)
    assert (same.anchors, same.throw) == (first.anchors, first.throw)


def test_a_plan_of_moved_meshes_has_keys_of_its_own():
    moved = plan()
    new = replace(moved, mesh="new")
    assert moved.key != new.key
    assert new.key == replace(moved, mesh="new").key
    assert "mesh" not in new.as_record()
    assert StudyPlan.from_record(moved.as_record()).mesh == "moved"
    designs = moved.planned.designs
    assert {design.mesh_class for design in designs} == {1}
    (anchor,) = (design for design in designs if design.ordinary)
    assert anchor.inputs[MOVED]["throw"] == anchor.inputs["throw"]
    # An anchor's own mesh is that of a study of new ones to 1 %: what is computed of it is shared.
    fine = replace(new, accuracy=0.01).planned
    assert anchor.ordinary[0] in {design.key for design in fine.designs}
    finer = plan(accuracy=0.005)
    (first, *_) = (design for design in finer.planned.designs if design.ordinary)
    assert first.ordinary[1]["accuracy"] == 0.005
    assert not {design.key for design in designs} & {d.key for d in new.planned.designs}
    assert len(moved.planned.tasks) == len(designs) + 1
    assert moved.planned.remarks[-1] == (
        "30 of 30 designs have moved meshes, those of 1 topology; anchors, with meshes of their own too: 1."
    )
    few = plan(runs=5, held_out=2).planned
    assert few.remarks[-1].startswith("No mesh is moved, because")
    assert {design.mesh_class for design in few.designs} == {None}


def test_stresses_need_new_meshes():
    with pytest.raises(InputError, match=r"study\.mesh: given \"moved\" with study\.stresses"):
        plan(stresses=True)
    with pytest.raises(InputError, match=r"study\.mesh: given 'old'"):
        replace(plan(), mesh="old")


def test_a_linear_ratio_is_found_and_its_scatter_told():
    draw = np.random.default_rng(1)
    values = draw.uniform(0.1, 0.2, (8, 3))
    # Positive factors by their logarithms, others as they are.
    values[:, 2] -= 0.15
    coded = np.column_stack([np.log(values[:, :2]), values[:, 2]])
    ratios = 1.05 - 0.02 * coded[:, 0] + 0.3 * coded[:, 2]
    fit = ratio_fit(values, ratios, 0.002)
    here = np.array([0.12, 0.19, -0.01])
    ratio = 1.05 - 0.02 * np.log(0.12) - 0.3 * 0.01
    assert fit.at(here) == close(ratio, rel=1e-12)
    assert fit.trend(here) * ratio == close([-0.02 / 0.12, 0.0, 0.3], abs=1e-9)
    assert fit.scatter < 1e-12
    noise = 1e-3 * draw.standard_normal(8)
    noisy = ratio_fit(values, ratios + noise, 0.002)
    # By leaving out each anchor in turn.
    left = []
    for place in range(8):
        kept = np.delete(np.arange(8), place)
        columns = np.column_stack([np.ones(7), coded[kept]])
        found = np.linalg.lstsq(columns, (ratios + noise)[kept], rcond=None)[0]
        left.append(ratios[place] + noise[place] - found @ [1.0, *coded[place]])
    assert noisy.scatter == close(np.sqrt(np.mean(np.square(left))), rel=1e-6)


def test_answers_are_scaled_to_their_anchors():
    planned = plan(accuracy=0.005).planned
    outcomes = outcomes_of(planned)
    scaled = scaled_answers(planned.designs, outcomes)
    assert sum(design.ordinary is not None for design in planned.designs) == 6
    for design in planned.designs:
        found = scaled.outcomes[design.key]
        assert found.responses[NAME] == close(shape(design.values)[0], rel=1e-9)
        assert found.errors[NAME] == close(0.02, rel=1e-9)
    # In whatever order, and with an anchor missing.
    (first, *_) = (design.ordinary[0] for design in planned.designs if design.ordinary)
    fewer = {key: one for key, one in outcomes.items() if key != first}
    mean = scaled_answers(planned.designs, fewer).fits[1][NAME]
    assert len(mean.coefficients) == 1
    assert mean.scatter > 1e-4
    backwards = dict(reversed(outcomes.items()))
    assert scaled_answers(planned.designs, backwards).outcomes == scaled.outcomes


def test_one_anchor_leaves_a_share_of_the_meshs_own_error():
    planned = plan().planned
    scaled = scaled_answers(planned.designs, outcomes_of(planned))
    for design in planned.designs:
        found, truth = scaled.outcomes[design.key], shape(design.values)[0]
        assert abs(found.responses[NAME] / truth - 1.0) < found.errors[NAME]
        expected = 0.02 if design.ordinary else np.hypot(0.02, 0.4 * 0.02)
        assert found.errors[NAME] == close(expected, rel=1e-9)


def test_without_anchors_answers_and_bars_are_those_of_the_mesh():
    planned = plan().planned
    outcomes = {d.key: outcomes_of(planned)[d.key] for d in planned.designs}
    assert scaled_answers(planned.designs, outcomes).outcomes == outcomes


def test_designs_that_were_meshed_are_not_scaled():
    planned = plan().planned
    outcomes = outcomes_of(planned)
    place = next(p for p, design in enumerate(planned.designs) if not design.ordinary)
    key = planned.designs[place].key
    outcomes[key] = replace(outcomes[key], mesh={"tier": "new"})
    table = study_table(planned.plan, planned.designs, outcomes)
    assert table.responses[NAME][place] == outcomes[key].responses[NAME]
    assert table.rows[place].mesh == "new"
    kinds = [row.mesh for row in table.rows]
    assert kinds.count("anchor") == 1
    assert set(kinds) == {"anchor", "new", "velocities"}
    cells = {column.name: column.cells for column in columns(table)}
    assert cells["mesh"] == kinds
    assert cells["mesh_class"] == [1] * len(kinds)
    frame = table.to_pandas()
    assert list(frame["mesh"]) == kinds


def discrete(values):
    """The moved mesh's own answer, which its correction takes to that of `shape`."""
    logs = np.log(np.array(values) / [0.285, 0.137, 0.067])
    return shape(values)[1] / (1.06 + 0.1 * logs[0] - 0.3 * logs[0] * logs[2] + 0.2 * logs[1] ** 2)


def test_answers_and_slopes_are_of_one_function():
    made = plan(accuracy=0.005, slopes=True)
    designs, outcomes = made.planned.designs, outcomes_of(made.planned)
    for design in designs:
        one = outcomes[design.key]
        noisy = one.responses[NAME] * (1.0 + 1e-5 * np.sin(1e9 * design.values[0]))
        mesh = {**one.mesh, "discrete": {NAME: discrete(design.values)}}
        one = replace(one, responses={NAME: noisy}, mesh=mesh)
        if "slopes" in one.inputs:
            shares = {}
            for place, factor in enumerate(FACTORS):
                low, high = (np.array(design.values) for _ in range(2))
                low[place], high[place] = 0.9999 * low[place], 1.0001 * high[place]
                shares[factor.name] = np.log(discrete(high) / discrete(low)) / np.log(
                    1.0001 / 0.9999
                )
            one = replace(one, slopes={NAME: shares}, slope_errors={NAME: 0.1})
        outcomes[design.key] = one
    table = study_table(made, designs, outcomes)
    assert np.all(table.slope_errors[NAME][~table.held_out] < 0.1)
    assert scaled_answers(designs, outcomes).fits[1][NAME].scatter < 2e-5

    def multiplier(design, place, change):
        """By what an answer of the mesh is multiplied, as an added design with an answer of 1 tells."""
        values = np.array(design.values)
        values[place] *= 1.0 + change
        known = outcomes[design.key]
        unit = replace(known, mesh={**known.mesh, "discrete": {NAME: 1.0}})
        added = replace(design, values=tuple(values), added=True, key="added", ordinary=None)
        scaled = scaled_answers([*designs, added], {**outcomes, "added": unit})
        return scaled.outcomes["added"].responses[NAME]

    for number, design in enumerate(designs):
        answer = table.responses[NAME][number]
        assert answer == close(shape(design.values)[0], rel=1e-4)
        if design.role != RUN or design.ordinary:
            continue
        assert answer == close(multiplier(design, 0, 0.0) * discrete(design.values), rel=1e-12)
        for place, factor in enumerate(FACTORS):
            low, high = (multiplier(design, place, change) for change in (-1e-5, 1e-5))
            own = outcomes[design.key].slopes[NAME][factor.name]
            share = own + np.log(high / low) / 2e-5
            found = table.slopes[NAME][number, place] * design.values[place] / answer
            assert found == close(share, abs=1e-8)


QUICK = """
for request in requests():
    inputs, tier = request["inputs"], "velocities" if request["reference"] else "new"
    found = {"key": request["key"], "responses": {"axial_compliance_pinned": inputs["throw"]["web_width"]}}
    found |= {"errors": {"axial_compliance_pinned": 0.01}, "seconds": 0.5, "unknowns": 9}
    if "moved" in inputs:
        found["mesh"] = {"tier": tier, "quality": 0.3, "reference": request["reference"].decode()}
    answer(found)
"""


@pytest.fixture
def puppets(monkeypatch):
    """Quick workers, and references that are words."""
    made = []

    def prepare(self, inputs):
        made.append(inputs[MOVED]["throw"]) if MOVED in inputs else None
        return (b"abc", "abc") if MOVED in inputs else (b"", "")

    monkeypatch.setattr(workers_module, "spawn_worker", lambda: puppet(QUICK))
    monkeypatch.setattr(ReferenceMeshes, "_of", prepare)
    return made


def shown(store):
    """Answers of designs in the order of their study, as the store shows them to other programs."""
    with closing(sqlite3.connect(store)) as connection:
        return [value for (value,) in connection.execute(f"SELECT {NAME} FROM results")]


def test_an_interrupted_study_continues_and_ends_the_same(puppets, tmp_path):
    made = plan()

    def interrupt(done, *_):
        if done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_plan(made, tmp_path / "stopped.sqlite", 1, interrupt)
    assert set(shown(tmp_path / "stopped.sqlite")) == {None}
    continued = run_plan(made, tmp_path / "stopped.sqlite", 2)
    at_once = run_plan(made, tmp_path / "whole.sqlite", 1)
    assert 0 < continued.computed < at_once.computed == len(made.planned.tasks)
    for table in (continued, read_study(tmp_path / "stopped.sqlite")):
        assert np.array_equal(table.responses[NAME], at_once.responses[NAME])
        assert [row.mesh for row in table.rows] == [row.mesh for row in at_once.rows]
    assert shown(tmp_path / "stopped.sqlite") == list(at_once.responses[NAME])
    assert {throw["web_width"] for throw in puppets} == {
        made.planned.designs[0].inputs[MOVED]["throw"]["web_width"]
    }


def test_designs_of_another_mesher_are_computed_again_with_the_rest(puppets, tmp_path, monkeypatch):
    made, store = plan(), tmp_path / "runs.sqlite"

    def interrupt(done, *_):
        if done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_plan(made, store, 1, interrupt)
    monkeypatch.setattr(
        ReferenceMeshes, "_of", lambda _, inputs: (b"xyz", "xyz") if MOVED in inputs else (b"", "")
    )
    table = run_plan(made, store, 1)
    with study_module.ResultStore(store, readonly=True) as results:
        kept = results.outcomes([design.key for design in made.planned.designs])
    assert {one.mesh["reference"] for one in kept.values()} == {"xyz"}
    # Whole, it stays as it is.
    monkeypatch.undo()
    assert run_plan(made, store, 1).computed == 0
    assert table.computed >= len(made.planned.designs)


def test_added_runs_join_the_classes_of_the_plan(puppets, tmp_path):
    made, store = plan(), tmp_path / "runs.sqlite"
    before = run_plan(made, store, 1)
    add_runs(made, store, np.array([[0.2845, 0.1345, 0.0677], [0.2825, 0.1325, 0.0655]]))
    table = run_plan(made, store, 1)
    assert (before.computed, table.computed) == (len(made.planned.tasks), 2)
    assert [row.mesh for row in table.rows].count("anchor") == 1
    assert [row.mesh_class for row in table.rows] == [1] * (len(before.rows) + 2)
    assert run_plan(made, store, 1).computed == 0


def test_answers_that_are_not_scaled_yet_are_no_results_elsewhere(puppets, tmp_path):
    made, store = plan(), tmp_path / "runs.sqlite"
    run_plan(made, store, 1)
    with pytest.raises(InputError, match="are of another throw"):
        import_results(replace(made, mesh="new", held_out=3), tmp_path / "new.sqlite", store)
    assert import_results(made, tmp_path / "same.sqlite", store).designs == len(
        made.planned.designs
    )


@pytest.mark.slow
def test_a_study_on_a_moved_mesh_by_workers_here_and_on_a_cluster(tmp_path):
    made = plan(accuracy=0.05, runs=12, held_out=2)
    table = run_plan(made, tmp_path / "runs.sqlite", 2)
    kinds = [row.mesh for row in table.rows]
    assert kinds.count("anchor") == 1
    assert kinds.count("velocities") == len(kinds) - 1
    new = run_plan(replace(made, mesh="new"), tmp_path / "runs.sqlite", 2)
    bars = np.hypot(table.errors[NAME], new.errors[NAME])
    assert np.all(np.abs(table.responses[NAME] / new.responses[NAME] - 1.0) < bars)
    # A cluster's worker takes the mesh with the request.
    design = next(design for design in made.planned.designs if not design.ordinary)
    request = {"key": design.key, "inputs": design.inputs}
    request["reference"] = ReferenceMeshes().of(design.inputs)
    answer = compute_design("run", request, design_limits(0.05), identity())["answer"]
    with study_module.ResultStore(tmp_path / "runs.sqlite", readonly=True) as results:
        kept = results.outcomes([design.key])[design.key]
    assert answer["responses"] == kept.responses
    assert answer["mesh"] == kept.mesh


@pytest.mark.further
def test_a_dask_cluster_gives_the_study_of_this_machine(tmp_path):
    distributed = pytest.importorskip("distributed")
    made = plan(accuracy=0.1, runs=12, held_out=1)
    local = run_plan(made, tmp_path / "local.sqlite", 1)
    alone = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "protocol": "tcp://"}
    with distributed.LocalCluster(host="127.0.0.1", dashboard_address=None, **alone) as cluster:
        table = run_plan(made, tmp_path / "dask.sqlite", dask=cluster.scheduler_address)
    assert [row.mesh for row in table.rows] == [row.mesh for row in local.rows]
    assert {row.mesh for row in table.rows} == {"anchor", "velocities"}
    assert np.array_equal(table.responses[NAME], local.responses[NAME])
    assert shown(tmp_path / "dask.sqlite") == list(local.responses[NAME])


def test_sharp_throws_and_choices_fall_into_classes():
    levels = {"web_width": (0.28, 0.285, 0.29), "pin_length": (0.13, 0.135, 0.14)}
    made = plan_of_levels(SHARP, levels, held_out=2, mesh="moved")
    assert {design.mesh_class for design in made.planned.designs} == {1}
    orders = permutations(range(3))
    assert len({made.planned.designs[place].key for order in orders for place in order}) == 3
