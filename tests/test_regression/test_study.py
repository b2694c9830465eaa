import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
import uuid
from pathlib import Path

import numpy as np
import pytest

from fem.analysis import throw_responses
from geometry.errors import InputError
from geometry.throw import CrankThrow
from regression import workers
from regression.store import ResultStore
from regression.study import HELD_OUT, RUN, StudyPlan, plan_designs, read_study, run_plan

ROOT = Path(__file__).resolve().parents[2]
THROW = CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.285,
    web_thickness=0.068,
    fillet_radius=0.012,
)
SHARP = THROW.model_copy(update={"fillet_radius": 0.0})
# The factors do not stand in alphabetical order: it must not matter.
THREE = {
    "web_width": (0.270, 0.300, 0.330),
    "web_thickness": (0.038, 0.068, 0.098),
    "pin_length": (0.120, 0.139, 0.158),
}
TWO = {"web_width": (0.280, 0.300), "pin_length": (0.130, 0.150)}
SMALL = StudyPlan(SHARP, TWO, held_out=1, accuracy=0.1)

# A worker that does no finite elements, or none at all.
QUICK = """
import json, sys
for line in sys.stdin:
    request = json.loads(line)
    responses = {"axial_compliance_pinned": request["inputs"]["throw"]["web_width"]}
    print(json.dumps({"key": request["key"], "responses": responses, "seconds": 0.0}), flush=True)
"""


def puppets(monkeypatch, code):
    def spawn():
        return subprocess.Popen(
            [sys.executable, "-S", "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    monkeypatch.setattr(workers, "_spawn", spawn)


# -------------------------------------------------------------------------------------------- plans


def test_all_combinations_and_the_held_out_designs():
    designs = plan_designs(StudyPlan(THROW, THREE))
    assert [design.role for design in designs] == [RUN] * 27 + [HELD_OUT] * 8
    assert len({design.key for design in designs}) == 35
    combinations = {
        (b, h, L)
        for b in THREE["web_width"]
        for h in THREE["web_thickness"]
        for L in THREE["pin_length"]
    }
    assert {design.values for design in designs[:27]} == combinations


def test_held_out_designs_lie_inside_the_box_and_between_the_levels():
    plan = StudyPlan(THROW, THREE)
    held = np.array([design.values for design in plan_designs(plan) if design.role == HELD_OUT])
    for column, levels in zip(held.T, THREE.values(), strict=True):
        assert np.all((column > min(levels)) & (column < max(levels)))
        assert len(set(column)) == 8
        # One in each eighth of the range.
        strata = np.floor(8 * (column - min(levels)) / (max(levels) - min(levels)))
        assert sorted(strata) == list(range(8))


def test_inputs_are_the_base_throw_with_the_factors_changed():
    plan = StudyPlan(THROW, TWO, accuracy=0.05)
    for design in plan_designs(plan):
        changes = dict(zip(plan.factors, design.values, strict=True))
        assert design.inputs["throw"] == THROW.model_dump(mode="json") | changes
        assert design.inputs["accuracy"] == 0.05


def test_the_seed_moves_the_held_out_designs_alone():
    first, second = (plan_designs(StudyPlan(THROW, THREE, seed=seed)) for seed in (1, 2))
    assert [d.key for d in first[:27]] == [d.key for d in second[:27]]
    assert not {d.key for d in first[27:]} & {d.key for d in second[27:]}
    assert plan_designs(StudyPlan(THROW, THREE, seed=1)) == first


@pytest.mark.parametrize(
    "other",
    [
        StudyPlan(THROW, THREE, seed=2),
        StudyPlan(THROW, THREE, held_out=9),
        StudyPlan(THROW, THREE, accuracy=0.02),
        StudyPlan(THROW, TWO),
        StudyPlan(SHARP, THREE),
    ],
)
def test_plans_that_differ_have_keys_that_differ(other):
    assert other.key != StudyPlan(THROW, THREE).key


@pytest.mark.parametrize(
    "plan",
    [SMALL, StudyPlan(THROW, THREE), StudyPlan(THROW, dict(reversed(THREE.items())), seed=3)],
)
def test_a_plan_comes_back_from_its_record(plan, tmp_path):
    again = StudyPlan.from_record(json.loads(json.dumps(plan.as_record())))
    assert again == plan
    assert again.factors == plan.factors
    with ResultStore(tmp_path / "runs.sqlite") as store:
        store.register_study(plan.key, plan.as_record(), [])
        stored = StudyPlan.from_record(store.studies()[plan.key])
    assert stored.key == plan.key
    assert plan_designs(stored) == plan_designs(plan)


def test_one_key_stands_for_one_set_of_designs():
    plan, turned = StudyPlan(THROW, THREE), StudyPlan(THROW, dict(reversed(THREE.items())))
    designs = [{design.key for design in plan_designs(found)} for found in (plan, turned)]
    assert plan.key != turned.key or designs[0] == designs[1]


@pytest.mark.parametrize(
    ("levels", "options", "message"),
    [
        ({"web_with": (0.27, 0.30)}, {}, r"^study\.factors\.web_with: unknown throw dimension; "),
        ({"web_width": (0.27,)}, {}, r"^study\.factors\.web_width: given 1 level; allowed are two"),
        ({"web_width": (0.27, 0.27)}, {}, r"^study\.factors\.web_width: given 1 level; "),
        ({}, {}, r"^study\.factors: none given; at least one"),
        (TWO, {"held_out": 0}, r"^study\.held_out: given 0; allowed is 1 or more"),
        (TWO, {"held_out": -3}, r"^study\.held_out: given -3; allowed is 1 or more"),
    ],
)
def test_plans_that_cannot_be(levels, options, message):
    with pytest.raises(InputError, match=message) as caught:
        StudyPlan(THROW, levels, **options)
    assert str(caught.value).endswith(".")
    assert "\n" not in str(caught.value)


def test_a_corner_that_cannot_be_built_is_named():
    plan = StudyPlan(THROW, {"web_width": (0.225, 0.300), "pin_length": (0.120, 0.158)})
    with pytest.raises(InputError) as caught:
        plan_designs(plan)
    message = str(caught.value)
    assert message.startswith("study.factors: one of the designs cannot be built: throw.fillet")
    assert "given 12 mm" in message
    assert "web of 225 mm is too narrow" in message
    assert "\n" not in message


@pytest.mark.parametrize("count", [0, -1, 257])
def test_numbers_of_workers(tmp_path, count):
    with pytest.raises(InputError, match=f"^workers: given {count}; allowed is 1 to 256"):
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


def test_a_small_study(small_run):
    _, table, told = small_run
    assert table.computed == 5
    assert table.failures == ()
    assert table.values.shape == (5, 2)
    assert table.held_out.tolist() == [False] * 4 + [True]
    assert [call[:2] for call in told] == [(done, 5) for done in range(6)]
    assert told[0][2] is None
    assert all(newest.responses for _, _, newest in told[1:])


def test_results_are_those_of_the_throw_alone(small_run):
    _, table, _ = small_run
    throw = SHARP.model_copy(update={"web_width": 0.280, "pin_length": 0.150})
    expected = throw_responses(throw, accuracy=0.1)
    assert table.values[1].tolist() == [0.280, 0.150]
    for name, value in expected.items():
        assert table.responses[name][1] == pytest.approx(value, rel=1e-6)


def test_a_second_run_computes_nothing(small_run):
    store, table, _ = small_run
    told = []
    again = run_plan(SMALL, store, 2, lambda *call: told.append(call))
    assert again.computed == 0
    assert told == [(5, 5, None)]
    assert again.responses.keys() == table.responses.keys()
    for name, column in table.responses.items():
        assert again.responses[name].tolist() == column.tolist()


def test_a_study_is_read_back_without_computing(small_run):
    store, table, _ = small_run
    for named in (None, SMALL.key, SMALL.key[:6]):
        read = read_study(store, named)
        assert read.plan == SMALL
        assert read.computed == 0
        assert read.failures == ()
        assert read.values.tolist() == table.values.tolist()
        assert read.held_out.tolist() == table.held_out.tolist()
        assert read.responses["mass"].tolist() == table.responses["mass"].tolist()


def test_a_finer_study_takes_over_what_is_known(small_run, tmp_path):
    store, _, _ = small_run
    copy = tmp_path / "runs.sqlite"
    with sqlite3.connect(store) as source, sqlite3.connect(copy) as target:
        source.backup(target)
    source.close()
    target.close()
    finer = StudyPlan(SHARP, TWO | {"web_width": (0.280, 0.290, 0.300)}, held_out=1, accuracy=0.1)
    assert run_plan(finer, copy).computed == 2
    with pytest.raises(
        InputError, match=r"^study: none named; .* holds 2 such studies \(.*; name one"
    ):
        read_study(copy)
    assert read_study(copy, finer.key).plan == finer
    assert read_study(copy, SMALL.key).plan == SMALL
    with pytest.raises(InputError, match=r"^study: given 'zz'; .* holds no such study"):
        read_study(copy, "zz")


# ------------------------------------------------------------------------------- running, by puppets


def test_failed_designs_are_told_and_not_repeated(tmp_path, monkeypatch):
    code = QUICK.replace(
        "    responses =",
        "    if request['inputs']['throw']['web_width'] == 0.28:\n"
        "        failed = {'key': request['key'], 'reason': 'MeshError: no', 'seconds': 0.0}\n"
        "        print(json.dumps(failed), flush=True)\n"
        "        continue\n"
        "    responses =",
    )
    puppets(monkeypatch, code)
    table = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert len(table.values) == 3
    assert table.failures == (
        (RUN, (0.280, 0.130), "MeshError: no"),
        (RUN, (0.280, 0.150), "MeshError: no"),
    )
    again = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert again.computed == 0
    assert again.failures == table.failures


def test_designs_lost_with_their_workers_are_tried_again_by_the_next_run(tmp_path, monkeypatch):
    puppets(monkeypatch, "import sys; sys.stdin.readline(); sys.exit(9)")
    table = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert [failure[2] for failure in table.failures] == [
        "the worker process died (exit code 9)"
    ] * 5
    puppets(monkeypatch, QUICK)
    again = run_plan(SMALL, tmp_path / "runs.sqlite")
    assert again.computed == 5
    assert again.failures == ()


def test_an_interrupted_study_keeps_what_arrived(tmp_path, monkeypatch):
    puppets(monkeypatch, QUICK)

    def interrupt(done, *_):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_plan(SMALL, tmp_path / "runs.sqlite", 1, interrupt)
    partial = read_study(tmp_path / "runs.sqlite")
    assert len(partial.values) == 2
    assert {failure[2] for failure in partial.failures} == {"not computed yet"}
    assert run_plan(SMALL, tmp_path / "runs.sqlite").computed == 3


def test_stores_without_a_study(tmp_path):
    with pytest.raises(
        InputError, match=r"^store: given '.*none\.sqlite'; there is no such file\.$"
    ):
        read_study(tmp_path / "none.sqlite")
    with ResultStore(tmp_path / "empty.sqlite"):
        pass
    with pytest.raises(InputError, match=r"^study: none named; .* holds no such study"):
        read_study(tmp_path / "empty.sqlite")


# ------------------------------------------------------------------------------------- sudden death


def marked(mark):
    found = []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit() or int(folder.name) == os.getpid():
            continue
        try:
            environment = (folder / "environ").read_bytes().split(b"\0")
            state = (folder / "stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            continue
        if mark.encode() in environment and state not in "ZX":
            found.append(int(folder.name))
    return found


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
from regression.study import StudyPlan, run_plan
from geometry.throw import CrankThrow
plan = StudyPlan.from_record(__import__("json").loads(sys.argv[1]))
print(run_plan(plan, sys.argv[2], 2).computed)
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs /proc")
def test_a_killed_study_repeats_no_finished_design_and_finishes_the_rest(tmp_path):
    plan = StudyPlan(SHARP, THREE | {"web_width": (0.300, 0.330)}, held_out=2, accuracy=0.1)
    total = len(plan_designs(plan))
    store, mark = tmp_path / "runs.sqlite", f"CRANKFEM_TEST={uuid.uuid4()}"
    name, value = mark.split("=")
    paths = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    environment = os.environ | {"PYTHONPATH": paths, name: value}
    command = [sys.executable, "-P", "-c", COORDINATOR, json.dumps(plan.as_record()), str(store)]

    for wanted in (2, 8):
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
        while marked(mark) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert marked(mark) == []
        if wanted == 2:
            first = finished(store)
    before = finished(store)
    assert 8 <= len(before) < total
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
    assert marked(mark) == []
    table = read_study(store)
    assert table.failures == ()
    assert len(table.values) == total
