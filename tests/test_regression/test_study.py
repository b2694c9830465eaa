import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
import uuid
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from crankbase import memory
from crankbase.errors import InputError, NotEnoughMemoryError
from fem.material import STEEL
from fem.responses import evaluate_throw
from geometry.throw import CrankThrow
from plans import FILLETED, plan_of_levels
from puppets import marked, puppet
from refusals import refused
from regression.plans import plan as plan_module
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import ExcludedDesign, StudyPlan, plan_designs
from regression.runs import study as study_module
from regression.runs import workers as workers_module
from regression.runs.exchange import export_table
from regression.runs.store import ResultStore
from regression.runs.study import StoreCheck, StudyCheck, import_results, read_study, run_plan

ROOT = Path(__file__).resolve().parents[2]
THROW = FILLETED
SHARP = THROW.model_copy(update={"fillet_radius": 0.0})
# The factors do not stand in alphabetical order: it must not matter.
THREE = {
    "web_width": (0.270, 0.300, 0.330),
    "web_thickness": (0.038, 0.068, 0.098),
    "pin_length": (0.120, 0.139, 0.158),
}
TWO = {"web_width": (0.280, 0.300), "pin_length": (0.130, 0.150)}
SMALL = plan_of_levels(SHARP, TWO, held_out=1, accuracy=0.1)

# A worker that does no finite elements, or none at all.
QUICK = """
for request in requests():
    responses = {"axial_compliance_pinned": request["inputs"]["throw"]["web_width"]}
    errors = {"axial_compliance_pinned": 0.01}
    found = {"key": request["key"], "responses": responses, "errors": errors, "seconds": 0.5}
    answer(found | {"unknowns": 9})
"""


def puppets(monkeypatch, code):
    def spawn():
        return puppet(code)

    monkeypatch.setattr(workers_module, "spawn_worker", spawn)


@pytest.mark.parametrize("count", [0, -1, 257, 2.5, 2.0, True, "2"])
def test_numbers_of_workers(tmp_path, count):
    with refused("workers"):
        run_plan(SMALL, tmp_path / "runs.sqlite", workers=count)
    assert list(tmp_path.iterdir()) == []


# --------------------------------------------------------------------------------- running, for real


@pytest.fixture(scope="module")
def small_run(tmp_path_factory):
    store = tmp_path_factory.mktemp("study") / "runs.sqlite"
    told = []
    table = run_plan(
        SMALL, store, 2, lambda done, total, newest: told.append((done, total, newest))
    )
    return store, table, told


@pytest.mark.slow
def test_results_are_those_of_the_throw_alone(small_run):
    _, table, _ = small_run
    throw = SHARP.model_copy(update={"web_width": 0.280, "pin_length": 0.150})
    expected = evaluate_throw(throw, accuracy=0.1)
    assert table.values[1].tolist() == [0.280, 0.150]
    assert table.responses.keys() == expected.values.keys()
    # The same code on the same mesh; only the number of threads of the sums differs.
    for name, value in expected.values.items():
        assert table.responses[name][1] == close(value, rel=1e-9)
        assert table.errors[name][1] == close(expected.errors[name], rel=1e-6, abs=1e-12)


SLOPED = StudyPlan(
    SHARP,
    (Factor("web_width", "m", 0.28, 0.30), Factor("ratio", "", 1.0, 1.2)),
    DesignChoice("latin hypercube", runs=3),
    {"pin_length": "ratio * 130 mm", "main_journal_length": "0.40 m - pin_length"},
    held_out=1,
    accuracy=0.1,
    slopes=True,
)


@pytest.mark.slow
def test_a_study_with_slopes_continues_and_shows_them(tmp_path):
    store, name = tmp_path / "runs.sqlite", "axial_compliance_in_line"

    def interrupt(done, *_):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_plan(SLOPED, store, 1, interrupt)
    table = run_plan(SLOPED, store, 1)
    assert table.computed == 2
    read = read_study(store)
    assert np.array_equal(read.slopes[name], table.slopes[name], equal_nan=True)
    # All responses have slopes over both factors at the runs.
    assert table.slopes.keys() == table.responses.keys()
    assert np.isfinite(table.slopes[name][:3]).all()
    assert np.isnan(table.slopes[name][3]).all()
    # By the chain rule from those of the throw alone, over its three dimensions.
    moved = ("web_width", "pin_length", "main_journal_length")
    throw = CrankThrow(**SLOPED.planned.designs[0].inputs["throw"])
    shares = evaluate_throw(throw, accuracy=0.1, slopes=moved).slopes[name]
    terms = (
        shares["pin_length"] / throw.pin_length
        - shares["main_journal_length"] / throw.main_journal_length
    )
    over_ratio = table.responses[name][0] * 0.130 * terms
    assert table.slopes[name][0, 1] == close(over_ratio, rel=1e-5)
    frame = table.to_pandas()
    assert frame.attrs["units"][f"{name} per web_width"] == "m/N per m"
    assert frame[f"{name} per ratio"].iloc[0] == table.slopes[name][0, 1]
    exported = tmp_path / "runs.csv"
    export_table(table, exported)
    header = exported.read_text(encoding="utf-8").splitlines()[0]
    assert f"{name} per web_width [m/N per m]" in header
    assert import_results(SLOPED, tmp_path / "other.sqlite", exported, alone=True).rows == 4
    assert import_results(SLOPED, tmp_path / "third.sqlite", store).designs == 4
    third = run_plan(SLOPED, tmp_path / "third.sqlite", 1)
    assert third.computed == 0
    assert np.array_equal(third.slopes[name], table.slopes[name], equal_nan=True)


@pytest.mark.slow
def test_a_finer_study_takes_over_what_is_known(small_run, tmp_path):
    store, _, _ = small_run
    copy = tmp_path / "runs.sqlite"
    with sqlite3.connect(store) as source, sqlite3.connect(copy) as target:
        source.backup(target)
    source.close()
    target.close()
    finer = plan_of_levels(
        SHARP, TWO | {"web_width": (0.280, 0.290, 0.300)}, held_out=1, accuracy=0.1
    )
    assert run_plan(finer, copy, 1).computed == 2
    with pytest.raises(InputError, match=r"^study: none named; .* holds 2 studies: .*; name one"):
        read_study(copy)
    assert read_study(copy, finer.key).plan == finer
    assert read_study(copy, SMALL.key).plan == SMALL
    with pytest.raises(InputError, match=r"^study: given 'zz'; .* holds 2 studies: "):
        read_study(copy, "zz")


# ------------------------------------------------------------------------------- running, by puppets


def test_failed_designs_are_told_and_not_repeated(tmp_path, monkeypatch):
    code = QUICK.replace(
        "    responses =",
        "    if request['inputs']['throw']['web_width'] == 0.28:\n"
        "        failed = {'key': request['key'], 'reason': 'MeshError: no', 'seconds': 0.0}\n"
        "        answer(failed)\n"
        "        continue\n"
        "    responses =",
    )
    puppets(monkeypatch, code)
    table = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert len(table.values) == 3
    assert table.failures == (
        ExcludedDesign((0.280, 0.130), "MeshError: no"),
        ExcludedDesign((0.280, 0.150), "MeshError: no"),
    )
    again = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert again.computed == 0
    assert again.failures == table.failures


def test_workers_that_do_not_fit_into_the_memory_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "free_memory", lambda: 0.6e9)
    monkeypatch.setattr(study_module, "free_memory", lambda: 0.6e9)
    refused = (
        r"^workers: given 4, of which 3 take about 0\.2\d GB each, together about 0\.\d+ GB of memory; "
        r"allowed is what fits into the 0\.6 GB that are free, so ask for at most 2\.$"
    )
    plan = plan_of_levels(SHARP, {"web_width": (0.280, 0.300)}, held_out=1, accuracy=0.1)
    with pytest.raises(NotEnoughMemoryError, match=refused):
        run_plan(plan, tmp_path / "runs.sqlite", workers=4)


@pytest.mark.slow
def test_designs_lost_with_their_workers_are_tried_again_by_the_next_run(tmp_path, monkeypatch):
    puppets(monkeypatch, "next(requests()); sys.exit(9)")
    table = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert [failure.reason for failure in table.failures] == [
        "the worker process died (exit code 9)"
    ] * 5
    puppets(monkeypatch, QUICK)
    again = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert again.computed == 5
    assert again.failures == ()


@pytest.mark.slow
def test_an_interrupted_study_keeps_what_arrived(tmp_path, monkeypatch):
    puppets(monkeypatch, QUICK)

    def interrupt(done, *_):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_plan(SMALL, tmp_path / "runs.sqlite", 1, interrupt)
    partial = read_study(tmp_path / "runs.sqlite")
    assert len(partial.values) == 2
    assert {failure.reason for failure in partial.failures} == {"not computed yet"}
    assert run_plan(SMALL, tmp_path / "runs.sqlite").computed == 3


@pytest.mark.slow
def test_an_import_replaces_lost_designs_and_no_others(tmp_path, monkeypatch):
    puppets(monkeypatch, QUICK)
    run_plan(SMALL, tmp_path / "other.sqlite")
    code = QUICK.replace(
        "    responses =",
        "    if request['inputs']['throw']['web_width'] == 0.28:\n"
        "        sys.exit(9)\n"
        "    responses =",
    )
    puppets(monkeypatch, code.replace('"seconds": 0.5', '"seconds": 0.75'))
    assert len(run_plan(SMALL, tmp_path / "runs.sqlite").failures) == 2
    found = import_results(SMALL, tmp_path / "runs.sqlite", tmp_path / "other.sqlite")
    assert (found.designs, found.rows, found.left_out) == (2, 0, 0)
    after = read_study(tmp_path / "runs.sqlite")
    assert after.failures == ()
    assert after.seconds.tolist() == [0.5, 0.5, 0.75, 0.75, 0.75]


@pytest.mark.slow
def test_a_study_is_read_back_with_the_designs_it_was_run_with(tmp_path, monkeypatch):
    """Also where a later release of numpy or scipy draws other points."""
    puppets(monkeypatch, QUICK)
    factors = (
        Factor.of_labels("web_outline", ("obround", "rectangle")),
        Factor("web_width", "m", 0.250, 0.300),
    )
    choice = DesignChoice("latin hypercube", runs=6)
    limit = ("web_width >= 260 mm",)
    plan = StudyPlan(SHARP, factors, choice, constraints=limit, held_out=3, accuracy=0.1)
    table = run_plan(plan, tmp_path / "runs.sqlite")
    assert table.excluded
    assert read_study(tmp_path / "runs.sqlite").excluded == table.excluded
    draw = plan_module.space_filling_points
    monkeypatch.setattr(
        plan_module, "space_filling_points", lambda f, kind, n, seed: draw(f, kind, n, (7, *seed))
    )
    other = plan_designs(plan)
    assert not {design.values for design in other.designs} & {row.values for row in table.rows}
    read = read_study(tmp_path / "runs.sqlite")
    assert read.failures == ()
    assert read.rows == table.rows
    assert read.excluded == ()  # what was drawn beside them is not known
    # Run again, the study has the designs that are drawn now, and shows no others.
    again = run_plan(replace(plan), tmp_path / "runs.sqlite")
    assert again.computed == 9
    assert [row.values for row in again.rows] == [design.values for design in other.designs]
    assert read_study(tmp_path / "runs.sqlite").rows == again.rows
    connection = sqlite3.connect(tmp_path / "runs.sqlite")
    (shown,) = connection.execute("SELECT count(*) FROM results").fetchone()
    connection.close()
    assert shown == 9


def test_stores_without_a_study(tmp_path):
    with pytest.raises(InputError, match=r"^store: given '.*none\.sqlite'; there is no such"):
        read_study(tmp_path / "none.sqlite")
    with ResultStore(tmp_path / "empty.sqlite"):
        pass
    with pytest.raises(InputError, match=r"^study: none named; .* holds no study yet"):
        read_study(tmp_path / "empty.sqlite")


def test_a_check_of_a_store_tells_studies_and_the_first_damaged_rows():
    rows = {str(number): "no number" for number in range(12)}
    told = list(StoreCheck("a.sqlite", damaged_rows=rows).parts())
    assert "12 damaged" in told[0]
    assert "2 more" in told[-2]
    for check, sentence in (
        (StudyCheck("abcdefgh"), "Study abcdef: of another version of the finite element model."),
        (StudyCheck("abcdefgh", "its plan"), "Study abcdef: its plan is damaged; run it from"),
        (StudyCheck("abcdefgh", None, 5, 2), "Study abcdef: 5 designs, 2 without a result."),
    ):
        assert check.sentence.startswith(sentence)
        assert check.sentence in list(StoreCheck("a.sqlite", studies=(check,)).parts())


def test_several_studies_in_one_store_are_told_apart(tmp_path):
    plans = [
        plan_of_levels(THROW, {"web_width": levels}, held_out=1)
        for levels in ((0.27, 0.28), (0.27, 0.28, 0.29))
    ]
    store = tmp_path / "runs.sqlite"
    with ResultStore(store) as results:
        for plan in plans:
            designs = [(d.role, d.key, {}) for d in plan_designs(plan).designs]
            results.register_study(plan.key, plan.as_record(), designs)
    expected = "; ".join(
        f"{plan.key[:6]} (full factorial of {runs} runs: web_width 270 mm to {end} mm)"
        for plan, runs, end in zip(plans, (2, 3), (280, 290), strict=True)
    )
    for given, said in ((None, "none named"), ("x", "given 'x'")):
        with pytest.raises(InputError) as caught:
            read_study(store, given)
        assert all(words in str(caught.value) for words in (f"study: {said}", expected))


# --------------------------------------------------------------------- a study that changes starts anew


def stored_versions(store):
    with ResultStore(store, readonly=True) as results:
        return sorted(version for _, _, version in results.results())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("other", "new"),
    [
        # Two new runs at 0.310, and the held-out design moves with the range.
        (plan_of_levels(SHARP, TWO | {"web_width": (0.280, 0.310)}, held_out=1, accuracy=0.1), 3),
        # Another factor: the four corners at the old web thickness are there, four more are not.
        (
            plan_of_levels(
                SHARP, TWO | {"web_thickness": (0.060, 0.068)}, held_out=1, accuracy=0.1
            ),
            5,
        ),
        (plan_of_levels(SHARP, TWO, held_out=1, accuracy=0.05), 5),
        (plan_of_levels(THROW, TWO, held_out=1, accuracy=0.1), 5),
        (
            plan_of_levels(
                SHARP,
                TWO,
                held_out=1,
                accuracy=0.1,
                material=STEEL.model_copy(update={"youngs_modulus": 2.0e11}),
            ),
            5,
        ),
        (plan_of_levels(SHARP, TWO, held_out=1, accuracy=0.1, stresses=True), 5),
        (plan_of_levels(SHARP, TWO, held_out=1, accuracy=0.1, seed=2), 1),
    ],
    ids=["range", "factor", "accuracy", "throw", "material", "stresses", "seed"],
)
def test_a_changed_study_computes_what_is_new_and_mixes_nothing(tmp_path, monkeypatch, other, new):
    store = tmp_path / "runs.sqlite"
    puppets(monkeypatch, QUICK)
    first = run_plan(SMALL, store)
    changed = run_plan(other, store)
    assert changed.computed == new
    assert len(changed.values) == len(plan_designs(other).designs)
    again = run_plan(SMALL, store)
    assert again.computed == 0
    assert again.values.tolist() == first.values.tolist()
    read = read_study(store, other.key)
    assert read.plan == other
    assert read.values.tolist() == changed.values.tolist()


@pytest.mark.slow
def test_a_new_model_version_uses_nothing_of_the_old_one(tmp_path, monkeypatch):
    store = tmp_path / "runs.sqlite"
    puppets(monkeypatch, QUICK)
    run_plan(SMALL, store)
    now = plan_module.MODEL_VERSION
    for module in (plan_module, study_module):
        monkeypatch.setattr(module, "MODEL_VERSION", now + 1)
    with refused("store"):
        read_study(store)
    puppets(monkeypatch, QUICK.replace('["web_width"]', '["web_width"] * 2'))
    told = []
    table = run_plan(replace(SMALL), store, note=told.append)  # as a later release plans it
    assert table.computed == 5
    assert len(told) == 1
    run_plan(replace(SMALL), store, note=told.append)
    assert len(told) == 1  # nothing is left to compute
    assert table.responses["axial_compliance_pinned"].tolist() == (2 * table.values[:, 0]).tolist()
    assert stored_versions(store) == [now] * 5 + [now + 1] * 5
    # The store holds one study of this version: it needs no naming.
    assert read_study(store).computed == 0


# ------------------------------------------------------------------------------------- sudden death


def finished(store):
    """Return the rows of finished designs, read beside the running coordinator."""
    if not store.is_file():
        return []
    connection = sqlite3.connect(store, timeout=10.0)
    try:
        return connection.execute(
            "SELECT rowid, key, finished_at, seconds, responses FROM designs ORDER BY rowid"
        ).fetchall()
    except sqlite3.OperationalError:  # the tables are not made yet
        return []
    finally:
        connection.close()


COORDINATOR = """
import sys
from regression.plans.plan import StudyPlan
from regression.runs.study import run_plan
from geometry.throw import CrankThrow
plan = StudyPlan.from_record(__import__("json").loads(sys.argv[1]))
print(run_plan(plan, sys.argv[2], 2).computed)
"""


@pytest.mark.further
@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs /proc")
def test_a_killed_study_repeats_no_finished_design_and_finishes_the_rest(tmp_path):
    two_levels = {"web_width": (0.300, 0.330), "pin_length": (0.130, 0.150)}
    plan = plan_of_levels(SHARP, THREE | two_levels, held_out=2, accuracy=0.1)
    total = len(plan_designs(plan).designs)
    store, mark = tmp_path / "runs.sqlite", f"CRANKFEM_TEST={uuid.uuid4()}"
    name, value = mark.split("=")
    paths = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    environment = os.environ | {"PYTHONPATH": paths, name: value}
    command = [sys.executable, "-P", "-c", COORDINATOR, json.dumps(plan.as_record()), str(store)]

    for wanted in (2, 6):
        killed = subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE)
        try:
            deadline = time.monotonic() + 60.0
            while len(finished(store)) < wanted and time.monotonic() < deadline:
                assert killed.poll() is None, "the study ended before it could be killed"
                time.sleep(0.02)
        finally:
            killed.send_signal(signal.SIGKILL)
            killed.communicate()
        # Workers end by themselves as soon as they have no coordinator.
        deadline = time.monotonic() + 30.0
        while marked(mark.encode()) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert marked(mark.encode()) == []
        if wanted == 2:
            first = finished(store)
    before = finished(store)
    assert 6 <= len(before) < total
    assert before[: len(first)] == first

    done = subprocess.run(
        command,
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    after = finished(store)
    assert len(after) == total
    assert after[: len(before)] == before
    assert int(done.stdout) == total - len(before)
    assert marked(mark.encode()) == []
    table = read_study(store)
    assert table.failures == ()
    assert len(table.values) == total
