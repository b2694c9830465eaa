"""The loop over a cluster, by a cluster that plays every trick; then Dask itself, by puppets.

Nothing here computes finite elements; that a cluster gives the numbers of a local run is shown by
tests/campaigns/faults.py.
"""

import gc
import math
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import closing

import numpy as np
import pytest

from crankbase.calls import Limits
from crankbase.errors import InputError, MissingLibraryError
from plans import SHARP, plan_of_levels
from puppets import spawned
from refusals import refused
from regression.records import StudyStoppedError
from regression.runs import cluster as cluster_module
from regression.runs.cluster import (
    DaskCluster,
    ProcessPool,
    TaskLostError,
    compute_design,
    identity,
    run_on_cluster,
    shared_process_pool,
)
from regression.runs.study import run_plan

THROW = SHARP
PUPPET = """
for request in requests():
    key = request["key"]
    if key.startswith("die"):
        os._exit(7)
    if key.startswith("hang"):
        time.sleep(600)
    time.sleep(0.05)
    found = {"key": key, "responses": {"mass": 1.0 / 3.0}, "seconds": 0.05}
    answer(found)
"""


@pytest.fixture
def puppets(monkeypatch):
    shared_process_pool().close()  # workers of studies before these tests would compute, too
    started = spawned(monkeypatch, PUPPET)
    yield started
    for process in started:
        process.kill()
        process.wait()


class FakeTask:
    """Done at once; its behaviour is a function that answers or raises."""

    def __init__(self, behave, done=True):
        self.behave, self.is_done = behave, done
        self.fetched = self.released = False

    def done(self):
        return self.is_done

    def result(self):
        assert not self.released
        self.fetched = True
        return self.behave()

    def release(self):
        self.released = True


class FakeCluster:
    """Places that come and go; `answer(place, key)` says what becomes of a design there."""

    def __init__(self, answer, places=("one", "two")):
        self.answer, self.there = answer, dict.fromkeys(places, True)
        self.given, self.tasks = [], []

    def places(self):
        return dict(self.there)

    def submit(self, place, request, _limits):
        busy = [t for p, t in self.tasks if p == place and not (t.fetched or t.released)]
        assert place not in self.there or not busy, "one design at a time for each worker"
        key = request["key"]
        self.given.append((place, key))
        task = self.answer(self, place, key)
        self.tasks.append((place, task))
        return task

    def wait(self, _seconds):
        time.sleep(0.001)


def answer_of(key, **other):
    return {
        "identity": identity(),
        "worker": "host:1",
        "answer": {"key": key, "responses": {"mass": 1.0}, "seconds": 0.0},
    } | other


def good(cluster, place, key):
    return FakeTask(lambda: answer_of(key))


def collect(cluster, keys, limits=None):
    found, notes = {}, []

    def keep(outcome):
        assert outcome.key not in found, "a design has one outcome"
        found[outcome.key] = outcome

    limits = limits or Limits(60.0)
    run_on_cluster([(key, {"n": key}) for key in keys], keep, cluster, limits, notes.append)
    assert all(task.released for _, task in cluster.tasks)
    return found, notes


@pytest.fixture(autouse=True)
def quick_looks(monkeypatch):
    monkeypatch.setattr(cluster_module, "LOOK", 0.0)


def test_every_design_has_one_outcome_and_all_workers_work():
    cluster = FakeCluster(good, ("one", "two", "three"))
    found, notes = collect(cluster, [f"k{n}" for n in range(30)])
    assert len(found) == 30
    assert all(o.responses == {"mass": 1.0} and o.attempts == 1 for o in found.values())
    assert all(found[key].inputs == {"n": key} for key in found)
    assert {place for place, _ in cluster.given} == {"one", "two", "three"}
    assert notes == []


def test_a_result_is_stored_before_it_is_released():
    """A result that is released before it is stored could be lost; one that is held too long could be
    computed again when its worker is lost."""
    cluster = FakeCluster(good, ("one",))
    stored = []

    def keep(outcome):
        (task,) = [
            t
            for (_, t), (_, k) in zip(cluster.tasks, cluster.given, strict=True)
            if k == outcome.key
        ]
        assert not task.released
        stored.append(outcome.key)

    run_on_cluster([(k, {}) for k in "abc"], keep, cluster, Limits(60.0), str)
    assert stored == ["a", "b", "c"]
    assert all(task.released for _, task in cluster.tasks)


def test_a_design_whose_worker_leaves_is_tried_elsewhere():
    def answer(cluster, place, key):
        if place == "one":
            del cluster.there["one"]
            return FakeTask(None, done=False)
        return good(cluster, place, key)

    cluster = FakeCluster(answer)
    found, _ = collect(cluster, "abcd")
    assert all(outcome.responses for outcome in found.values())
    assert sorted(outcome.attempts for outcome in found.values()) == [1, 1, 1, 2]


def test_a_design_that_takes_two_workers_with_it_is_set_aside():
    def answer(cluster, place, key):
        if key != "bad":
            return good(cluster, place, key)
        del cluster.there[place]
        cluster.there[place + "'"] = True  # its nanny starts a new one
        return FakeTask(None, done=False)

    cluster = FakeCluster(answer)
    found, _ = collect(cluster, ["a", "bad", "b", "c"])
    assert [key for key, outcome in found.items() if outcome.responses is None] == ["bad"]
    assert (found["bad"].lost, found["bad"].attempts) == (True, 2)
    assert found["bad"].reason == "the cluster lost the worker"
    assert sum(key == "bad" for _, key in cluster.given) == 2


def test_a_result_that_is_lost_is_computed_again():
    lost = []

    def answer(cluster, place, key):
        def behave():
            if key == "b" and not lost:
                lost.append(key)
                raise TaskLostError("the result was lost with its worker")
            return answer_of(key)

        return FakeTask(behave)

    found, _ = collect(FakeCluster(answer), "abc")
    assert {key: outcome.attempts for key, outcome in found.items()} == {"a": 1, "b": 2, "c": 1}
    assert all(outcome.responses for outcome in found.values())


def test_what_the_worker_says_of_a_lost_design_is_recorded():
    told = {"lost": "took too long", "seconds": 5.0, "worker": "far:7"}
    lost = FakeCluster(lambda *_: FakeTask(lambda: {"identity": identity(), **told}))
    found, _ = collect(lost, ["k"])
    outcome = found["k"]
    assert (outcome.reason, outcome.seconds, outcome.worker) == (told["lost"], 5.0, "far:7")
    assert (outcome.attempts, outcome.lost) == (2, True)


def test_a_worker_that_is_silent_beyond_the_limit_is_given_up(monkeypatch):
    monkeypatch.setattr(cluster_module, "GRACE", 0.0)

    def answer(cluster, place, key):
        return FakeTask(None, done=False) if place == "one" else good(cluster, place, key)

    cluster = FakeCluster(answer)
    found, notes = collect(cluster, [f"k{n}" for n in range(6)], Limits(0.05))
    assert all(outcome.responses for outcome in found.values())
    assert any("worker one" in note for note in notes)
    assert cluster.given.count(("one", "k0")) == 1


def test_a_worker_that_pauses_keeps_its_design_and_gets_no_other():
    def answer(cluster, place, key):
        if place == "one":
            cluster.there["one"] = False  # short of memory, but at work
        return good(cluster, place, key)

    cluster = FakeCluster(answer)
    found, _ = collect(cluster, [f"k{n}" for n in range(6)])
    assert all(outcome.attempts == 1 for outcome in found.values())
    assert [place for place, _ in cluster.given].count("one") == 1


@pytest.mark.parametrize(
    ("handler", "stops"), [(signal.default_int_handler, " (Ctrl-C stops)"), (signal.SIG_IGN, "")]
)
def test_without_workers_it_says_so_and_waits(monkeypatch, interruptible, handler, stops):
    """What stops it is said only where it does, which is not under nohup."""
    signal.signal(signal.SIGINT, handler)
    monkeypatch.setattr(cluster_module, "QUIET", 0.02)
    cluster = FakeCluster(good, ())
    threading.Timer(0.1, lambda: cluster.there.update(late=True)).start()
    found, notes = collect(cluster, "ab")
    assert all(outcome.responses for outcome in found.values())
    assert notes == [f"the cluster has no workers; waiting for one{stops}"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, StudyStoppedError])
def test_an_error_lets_go_of_everything(error):
    def answer(cluster, place, key):
        return good(cluster, place, key) if key == "a" else FakeTask(None, done=False)

    def fail(_):
        raise error

    cluster = FakeCluster(answer)
    with pytest.raises(error):
        run_on_cluster([(k, {}) for k in "abc"], fail, cluster, Limits(60.0), str)
    running = [
        task for (_, task), (_, key) in zip(cluster.tasks, cluster.given, strict=True) if key != "a"
    ]
    assert running
    assert all(task.released for task in running)


class MortalCluster(FakeCluster):
    """Its scheduler is gone, or the user presses Ctrl-C, when two designs have been given out."""

    error: BaseException

    def places(self):
        if len(self.given) >= 2:
            raise self.error
        return super().places()


@pytest.mark.parametrize("error", [StudyStoppedError("dask: gone"), KeyboardInterrupt()])
def test_results_that_have_arrived_are_stored_when_the_cluster_goes(error):
    cluster, stored = MortalCluster(good), []
    cluster.error = error
    with pytest.raises(type(error)):
        run_on_cluster(
            [(k, {}) for k in "abcd"], lambda o: stored.append(o.key), cluster, Limits(60.0), str
        )
    assert stored == ["a", "b"]
    assert all(task.released for _, task in cluster.tasks)


@pytest.mark.parametrize("how", ["other version", "no crankfem"])
@pytest.mark.parametrize("bad", ["one", "two", "three"])
def test_a_refused_worker_does_not_cost_the_results_of_the_others(how, bad):
    def answer(_cluster, place, key):
        def behave():
            if place != bad:
                return answer_of(key)
            if how == "no crankfem":
                raise InputError("dask: given a cluster whose worker cannot load crankfem.")
            return {"identity": identity() | {"model_version": 1}}

        return FakeTask(behave)

    cluster, stored = FakeCluster(answer, ("one", "two", "three")), []
    with pytest.raises(InputError, match=r"^dask: given"):
        run_on_cluster(
            [(k, {}) for k in "abcdef"], lambda o: stored.append(o.key), cluster, Limits(60.0), str
        )
    assert len(stored) == 2
    assert len(cluster.given) == 3
    assert all(task.released for _, task in cluster.tasks)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_while_results_are_stored_costs_none_of_them():
    stored = []

    def keep(outcome):
        if not stored:
            signal.raise_signal(signal.SIGINT)
        stored.append(outcome.key)

    cluster = FakeCluster(good)
    with pytest.raises(KeyboardInterrupt):
        run_on_cluster([(k, {}) for k in "abcd"], keep, cluster, Limits(60.0), str)
    assert stored == ["a", "b"]
    assert all(task.released for _, task in cluster.tasks)


@pytest.mark.parametrize("name", ["model_version", "crankfem"])
def test_a_worker_of_another_version_is_refused(name):
    other = identity() | {name: "other"}
    assert compute_design("run", {"key": "k"}, Limits(300.0), other) == {"identity": identity()}
    cluster = FakeCluster(lambda *_: FakeTask(lambda: {"identity": other}))
    with refused("dask") as e:
        collect(cluster, "ab")
    assert "other" in str(e.value)


def test_a_worker_with_other_libraries_is_told_once():
    libraries = identity()["libraries"] | {"gmsh": "0.1"}
    other = identity() | {"libraries": libraries}

    def answer(_cluster, _place, key):
        return FakeTask(lambda: answer_of(key, identity=other))

    found, notes = collect(FakeCluster(answer, ("one",)), "abc")
    assert len(found) == 3
    assert len(notes) == 1
    assert "gmsh 0.1" in notes[0]


# --------------------------------------------------------------------------- on the worker's machine


def test_a_process_is_kept_between_designs_and_replaced_when_it_dies(puppets):
    shelf, limits = ProcessPool(), Limits(20.0)
    answers = [shelf.compute("run", {"key": key}, limits) for key in ("a", "b", "die", "c")]
    shelf.close()
    assert [answer["answer"]["key"] for answer in answers if "answer" in answer] == ["a", "b", "c"]
    assert answers[2]["lost"].endswith("(exit code 7)")
    assert answers[0]["worker"] == answers[1]["worker"] == answers[2]["worker"]
    assert answers[3]["worker"] != answers[0]["worker"]
    assert len(puppets) == 2
    assert all(process.poll() is not None for process in puppets)


@pytest.mark.slow
def test_limits_are_kept_on_the_workers_machine(puppets):
    answer = ProcessPool().compute("run", {"key": "hang"}, Limits(0.3))
    assert answer["lost"].endswith("0.3 s")
    assert puppets[0].poll() is not None


def test_a_run_that_stops_ends_its_own_designs_alone(puppets):
    shelf, answers = ProcessPool(), {}

    def compute(run):
        answers[run] = shelf.compute(run, {"key": f"hang {run}"}, Limits(3.0))

    threads = [threading.Thread(target=compute, args=(run,)) for run in ("mine", "yours")]
    for thread in threads:
        thread.start()
    while len(puppets) < 2:
        time.sleep(0.01)
    time.sleep(0.1)
    shelf.end_run("mine")
    threads[0].join(timeout=2.0)
    assert "SIGKILL" in answers["mine"]["lost"]
    assert "yours" not in answers
    # What was on its way when the run was stopped is not begun.
    assert shelf.compute("mine", {"key": "hang"}, Limits(3.0))["lost"] == "the run was stopped"
    assert len(puppets) == 2
    shelf.end_run("yours")
    threads[1].join()


# ---------------------------------------------------------------------------------------------- Dask


def test_dask_that_is_not_installed_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'crankfem\[cluster\]'$"):
        DaskCluster("tcp://127.0.0.1:1")


@pytest.fixture
def local_cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=2,
        processes=False,
        protocol="tcp://",
        host="127.0.0.1",
        dashboard_address=None,
    ) as cluster:
        yield cluster


STUDY = plan_of_levels(
    THROW,
    {"web_width": (0.27, 0.28, 0.29, 0.30), "pin_length": (0.12, 0.13, 0.14, 0.15)},
    held_out=4,
)


NO_ADDRESSES = ["nonsense://x", "tcp://x", "10.0.0.1", "tcp://a b:1", "tcp://x:99999", "tcp://:1"]


@pytest.mark.parametrize("address", [*NO_ADDRESSES, "", 5])
def test_what_is_no_address_is_refused_before_anything_is_done(address, tmp_path):
    with refused("dask"):
        run_plan(STUDY, tmp_path / "runs.sqlite", dask=address)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_dask_gives_the_table_of_a_local_run(puppets, local_cluster, tmp_path):
    local = run_plan(STUDY, tmp_path / "local.sqlite", 2)
    before = len(puppets)
    table = run_plan(STUDY, tmp_path / "dask.sqlite", dask=local_cluster.scheduler_address)
    assert table.computed == local.computed == 20
    assert table.failures == ()
    np.testing.assert_array_equal(table.values, local.values)
    np.testing.assert_array_equal(table.responses["mass"], local.responses["mass"])
    # One process for each of the two workers, whatever the number of their threads.
    assert len(puppets) - before <= 2
    again = run_plan(STUDY, tmp_path / "dask.sqlite", dask="tcp://127.0.0.1:1")
    assert again.computed == 0  # nothing left: no cluster is needed


@pytest.mark.slow
def test_a_dask_worker_that_leaves_in_the_middle_costs_nothing(puppets, local_cluster, tmp_path):
    told = []

    def progress(finished, total, newest):
        if finished == 4 and not told:
            told.append(finished)
            victim = next(iter(local_cluster.workers.values()))
            local_cluster.sync(victim.close, nanny=False, reason="test")

    table = run_plan(
        STUDY, tmp_path / "dask.sqlite", progress=progress, dask=local_cluster.scheduler_address
    )
    assert told == [4]
    assert table.failures == ()
    assert len(table.values) == 20
    assert np.all(table.responses["mass"] == 1.0 / 3.0)


@pytest.mark.slow
def test_an_interrupt_leaves_the_cluster_and_keeps_what_arrived(puppets, local_cluster, tmp_path):
    def interrupt(finished, *_):
        if finished == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_plan(
            STUDY, tmp_path / "d.sqlite", progress=interrupt, dask=local_cluster.scheduler_address
        )
    table = run_plan(STUDY, tmp_path / "d.sqlite", dask=local_cluster.scheduler_address)
    assert 20 - 3 - 2 <= table.computed <= 20 - 3
    assert table.failures == ()
    assert math.isclose(table.responses["mass"][0], 1.0 / 3.0)


@pytest.mark.slow
def test_leaving_the_cluster_ends_what_is_under_way_there(puppets, local_cluster):
    def interrupt(_):
        raise KeyboardInterrupt

    designs = [(key, {}) for key in ("a", "hang 1", "hang 2")]
    with closing(DaskCluster(local_cluster.scheduler_address)) as cluster:
        with pytest.raises(KeyboardInterrupt):
            run_on_cluster(designs, interrupt, cluster, Limits(300.0), str)
        # Those that hang are the ones that do not wait on the shelf for a next design.
        assert len(puppets) == 2
    deadline = time.monotonic() + 5.0
    while all(process.poll() is None for process in puppets) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert any(process.poll() is not None for process in puppets)


@pytest.fixture
def tls_names(tmp_path):
    """Dask's names of one certificate for all, as docs/studies-running.md has it made."""
    if shutil.which("openssl") is None:
        pytest.skip("no openssl")
    command = "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=crankfem"
    subprocess.run(
        [*command.split(), "-keyout", "key.pem", "-out", "cert.pem"],
        cwd=tmp_path,
        check=True,
        capture_output=True,
    )
    names = {"ca-file": "cert.pem", "scheduler.cert": "cert.pem", "scheduler.key": "key.pem"}
    for role in ("worker", "client"):
        names |= {f"{role}.cert": "cert.pem", f"{role}.key": "key.pem"}
    return {f"distributed.comm.tls.{name}": str(tmp_path / file) for name, file in names.items()}


@pytest.mark.further
def test_a_cluster_behind_tls(puppets, tls_names, tmp_path):
    distributed = pytest.importorskip("distributed")
    import dask

    where = {"host": "127.0.0.1", "dashboard_address": None, "processes": False}
    with dask.config.set({"distributed.comm.require-encryption": True, **tls_names}):
        security = distributed.Security()
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, protocol="tls://", security=security, **where
        ) as cluster:
            address = cluster.scheduler_address
            assert address.startswith("tls://")
            table = run_plan(STUDY, tmp_path / "tls.sqlite", dask=address)
            assert (table.computed, table.failures) == (20, ())
            with (
                dask.config.set(dict.fromkeys(tls_names)),
                pytest.raises(InputError, match="not to the certificate that Dask's configuration"),
            ):
                run_plan(STUDY, tmp_path / "other.sqlite", dask=address)


@pytest.mark.slow
@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_an_address_without_a_scheduler(monkeypatch):
    # The last of all: a client that fails leaves an event loop behind that ends while others start.
    pytest.importorskip("distributed")
    monkeypatch.setattr("regression.runs.cluster.CONNECT", 0.5)
    with refused("dask"):
        DaskCluster("tcp://127.0.0.1:1")
    gc.collect()  # a client that is not closed complains here
