"""The runner of jobs outlives jobs, worker processes, full disks and the folder itself."""

import json
import shutil
import signal
import subprocess
import sys
import time

import psutil
import pytest

from crankfem.service import job_runner
from crankfem.service.asking import ProblemError
from crankfem.service.guard import Bounds
from crankfem.service.job_runner import STARTS, JobRunner
from crankfem.service.job_store import FULL, GONE, JobStore, StoreError
from serving import ROOT, THROW

# A worker process that does with a job what the job says.
WORKER = """
import os, pickle, sys
def send(*content):
    pickle.dump(content, sys.stdout.buffer)
    sys.stdout.buffer.flush()
tried = 0
while True:
    function, arguments, _ = pickle.load(sys.stdin.buffer)
    task = "" if function.endswith(":load") else arguments[1]["task"]
    if task == "die":
        os._exit(1)
    if task == "note":
        send("remark", {"step": "Working"})
        send("remark", {"note": "Noted."})
    tried += task == "full twice"
    if task == "full" or (task == "full twice" and tried < 3):
        send("OSError", "OSError: [Errno 28] No space left on device: '/srv/jobs'")
    else:
        send("result", None)
"""
DIES = "raise SystemExit(7)"


@pytest.fixture
def workers(monkeypatch):
    """The code of worker processes, and how many were started; pauses are short."""
    told = {"code": WORKER, "started": 0}

    def spawn(_):
        told["started"] += 1
        return subprocess.Popen(
            [sys.executable, "-S", "-c", told["code"]],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )

    monkeypatch.setattr(job_runner, "spawn_worker", spawn)
    monkeypatch.setattr(job_runner, "PAUSE", 0.002)
    monkeypatch.setattr(job_runner, "LOOK", 0.01)
    return told


@pytest.fixture
def store(tmp_path):
    made = JobStore(tmp_path / "service")
    yield made
    made.close()


@pytest.fixture
def runner(store, workers):
    made = JobRunner(store, Bounds())
    yield made
    made.stop()


def until(happened, seconds=30.0):
    deadline = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def ended(store, *names):
    """The jobs, when all of them have ended."""
    until(lambda: not store.count("queued") and not store.count("running"))
    return [store.job(name) for name in names]


NO_SPACE, FAULT = StoreError(507, FULL), RuntimeError("a fault")


@pytest.mark.parametrize(
    ("method", "error"),
    [
        (name, NO_SPACE)
        for name in ("check", "queue_again", "start_next", "change", "note", "settle")
    ]
    + [(name, FAULT) for name in ("check", "queue_again", "start_next", "settle")],
)
def test_no_failure_of_the_store_ends_the_runner(store, runner, monkeypatch, method, error):
    works, failures = getattr(store, method), []

    def fails(*arguments, **values):
        if len(failures) < 3:
            failures.append(error)
            raise error
        return works(*arguments, **values)

    monkeypatch.setattr(store, method, fails)
    names = [runner.submit("analysis", "throw", {"task": "note"}) for _ in range(3)]
    runner.start()
    jobs = ended(store, *names)
    assert len(failures) == 3
    assert [job.state for job in jobs] == ["done"] * 3
    assert all("Noted." in job.notes for job in jobs)
    until(lambda: runner.health()["state"] == "ok")


def test_what_is_wrong_is_told_until_it_is_over(store, runner, monkeypatch, capfd):
    full, works = [True], store.start_next

    def fails():
        if full:
            store.trouble = FULL
            raise StoreError(507, FULL)
        return works()

    monkeypatch.setattr(store, "start_next", fails)
    name = runner.submit("analysis", "throw", {"task": ""})
    runner.start()
    until(lambda: runner.health()["state"] == "retrying")
    told = runner.health()
    assert told["problems"] == [FULL]
    assert told["queued"] == 1
    assert abs(told["since"] - time.time()) < 60.0
    full.clear()
    assert ended(store, name)[0].state == "done"
    until(lambda: runner.health() | {"queued": 0} == runner.health())
    until(lambda: runner.health()["problems"] == [])
    lines = [json.loads(line) for line in capfd.readouterr().err.splitlines()]
    assert [(line["jobs"], line.get("problem")) for line in lines] == [
        ("retrying", FULL),
        ("ok", None),
    ]


def test_a_job_that_finds_the_disk_full_waits_for_space(store, runner, workers, monkeypatch):
    monkeypatch.setattr(job_runner, "LONGEST_PAUSE", 0.05)
    tasks = ("full twice", "full", "die", "")
    names = [runner.submit("analysis", "throw", {"task": task}) for task in tasks]
    runner.start()
    twice, ever, died, sound = ended(store, *names)
    assert twice.state == "done"
    assert twice.notes == ["Tried again, because the disk of the service was full."]
    assert twice.attempts == 1  # it was no fault of the job's
    assert (ever.state, ever.problem.status, ever.problem.detail) == ("failed", 507, FULL)
    assert (died.state, died.attempts) == ("failed", 2)
    assert sound.state == "done"


def test_the_longest_trouble_ends_no_thread(runner):
    runner._ending.set()
    runner._wait(0, StoreError(507, FULL), 5000)
    runner.start()


def test_a_worker_that_always_dies_is_given_up_until_a_job_is_submitted(store, runner, workers):
    workers["code"] = DIES
    runner.start()
    until(lambda: runner.health()["state"] == "stopped")
    assert runner.health()["problems"] == [
        "Jobs do not run: the worker process died (exit code 7)."
    ]
    time.sleep(0.1)
    assert workers["started"] == STARTS
    with pytest.raises(ProblemError, match=r"exit code 7.*tried again now") as refused:
        runner.submit("analysis", "throw", {"task": ""})
    assert refused.value.status == 503
    assert store.count("queued") == 0
    until(lambda: workers["started"] == STARTS + 1)
    workers["code"] = WORKER
    time.sleep(0.1)  # the last one may be under way
    with pytest.raises(ProblemError):
        runner.submit("analysis", "throw", {"task": ""})
    until(lambda: runner.health()["state"] == "ok")
    assert ended(store, runner.submit("analysis", "throw", {"task": ""}))[0].state == "done"


def test_a_full_disk_leaves_nothing_of_a_job_behind(store, runner):
    runner.start()
    (pages,) = store._base.execute("PRAGMA page_count").fetchone()
    store._base.execute(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(StoreError, match=FULL) as refused:
        runner.submit("engine", "mine", {"text": "x" * 100_000})
    assert refused.value.status == 507
    assert store.jobs(10) == []
    assert list((store.folder / "jobs").iterdir()) == []
    until(lambda: runner.health()["state"] == "ok")  # less finds room


@pytest.mark.parametrize("replaced", [False, True])
def test_a_folder_that_vanishes_is_told_and_starts_nothing(store, runner, workers, replaced):
    shutil.rmtree(store.folder)
    if replaced:
        store.folder.mkdir()
        (store.folder / "jobs.sqlite").write_bytes(b"another")
    runner.start()
    until(lambda: runner.health()["problems"] == [GONE])
    with pytest.raises(StoreError, match=GONE) as refused:
        runner.submit("analysis", "throw", {"task": ""})
    assert refused.value.status == 503
    time.sleep(0.05)
    assert workers["started"] == 0


@pytest.mark.slow
def test_a_service_says_that_its_folder_is_gone_and_restarts_no_worker(serve, tmp_path):
    """Its log names each reason once; the worker that is lost afterwards stays away."""
    service = serve(tmp_path)
    log = service.log.open("rb")
    shutil.rmtree(tmp_path)
    for child in (process := psutil.Process(service.process.pid)).children():
        child.kill()
    until(lambda: service.json("/api/health")[1]["problems"] == [GONE])
    status, told = service.json("/api/throws/analysis", {"throw": THROW})
    assert (status, told["detail"]) == (503, GONE)
    assert service.json("/api/throws/law", {"throw": THROW})[0] == 200
    time.sleep(1.5)
    assert not [one for one in process.children() if one.status() != psutil.STATUS_ZOMBIE]
    lines = [json.loads(line) for line in log.read().decode().splitlines() if line[0] == "{"]
    log.close()
    told = [line["problem"] for line in lines if "problem" in line]
    assert told[-1] == GONE
    assert len(told) == len(set(told)) <= 2  # before, that the worker is lost


@pytest.mark.slow
def test_a_service_of_a_test_ends_with_the_program_that_started_it(own):
    program = own(
        f"import sys, time; sys.path.append({str(ROOT / 'tests')!r}); from pathlib import Path; "
        "from serving import Served; service = Served(Path()); Path('ready').touch(); time.sleep(100)"
    )
    program.wait_for((program.scratch.parent / "ready").exists)
    assert [one for one in program.children() if "serve" in one.cmdline()]
    assert program.end(signal.SIGTERM) == ([], [])
