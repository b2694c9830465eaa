"""Jobs and their runner: queued, followed, canceled, lost, found again."""

import asyncio
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import psutil
import pytest

from comparing import close
from crankfem.client import Client, RefusedError
from crankfem.files.engine.throw_file import load_crankshaft
from crankfem.satellites.service import job_runner, job_store
from crankfem.satellites.service.asking import ProblemError
from crankfem.satellites.service.guard import Bounds
from crankfem.satellites.service.job_runner import STARTS, JobRunner
from crankfem.satellites.service.job_store import FULL, GONE, Followers, JobStore, StoreError
from geometry.crankshaft import throw_masses
from geometry.solid_files import write_step
from satellites.service.serving import ROOT, STUDY, THROW


def engine_text():
    from crankfem.files.engine.new_file import engine_template

    return engine_template("mine.toml", 3, 4)


@pytest.fixture
def own_service(serve, tmp_path):
    """A service of the test's own."""
    return serve(tmp_path)


@pytest.mark.slow
def test_a_file_is_checked_before_it_is_run(service):
    status, told = service.json("/api/engines", {"text": STUDY, "name": "study.toml"})
    assert status == 422
    assert "allowed is one that serves run" in told["detail"]
    wrong = engine_text().replace("\nbore =", "\nboer =")
    status, told = service.json("/api/engines", {"text": wrong, "name": "mine.toml"})
    assert status == 422
    assert "engine.boer" in [one["field"] for one in told["errors"]]
    status, told = service.json("/api/files/check", {"text": engine_text(), "name": "mine.toml"})
    assert status == 200
    assert told["kind"] == "engine"
    assert "run" in told["commands"]
    thin = STUDY.replace('web_thickness = "68 mm"', 'web_thickness = "20 mm"')
    _, told = service.json("/api/files/check", {"text": thin, "name": "study.toml"})
    assert "throw.web_thickness" in [one.partition(":")[0] for one in told["warnings"]]


@pytest.mark.slow
def test_a_step_file_is_checked(service, tmp_path):
    shaft = load_crankshaft("yamz-5340")
    text = write_step(shaft, tmp_path / "crank.step").read_text(encoding="utf-8")
    status, told = service.json("/api/files/check", {"text": text, "name": "crank.step"})
    assert (status, told["kind"], told["commands"]) == (200, "crankshaft", ["cad"])
    throws = told["record"]["throws"]
    assert [throw["angle_deg"] for throw in throws] == close(shaft.crank_angles_deg, abs=1e-6)
    assert throws[3]["mass"] == close(throw_masses(shaft.throws[3], 7850.0).mass, rel=1e-5)
    assert {throw["like"] for throw in throws} == {1}
    many = text.replace("ENDSEC;", "/* " + "ADVANCED_FACE( " * 3000 + "*/ENDSEC;", 1)
    for sent, name, reason in (
        (text[: len(text) // 2], "crank.step", "crank.step: "),
        (many, "crank.step", "allowed are 3000 at most"),
        (text, "../crank.step", "allowed is the plain name"),
    ):
        status, told = service.json("/api/files/check", {"text": sent, "name": name})
        assert status == 422
        assert reason in told["detail"]
        assert "/tmp" not in told["detail"]
    status, told = service.json("/api/engines", {"text": text, "name": "crank.step"})
    assert (status, "allowed is one that serves run" in told["detail"]) == (422, True)
    # The process that checks serves the next file as before.
    status, _ = service.json("/api/files/check", {"text": engine_text(), "name": "mine.toml"})
    assert status == 200


@pytest.mark.further
def test_the_queue_is_bounded_and_loses_nothing(own_service, throw):
    accepted, refused = [], []
    for _ in range(24):
        status, headers, _ = own_service.ask(
            "/api/throws/analysis", {"throw": throw, "accuracy": 0.1}
        )
        (accepted if status == 202 else refused).append((status, headers))
    assert {status for status, _ in refused} == {429}
    assert all(int(headers["Retry-After"]) > 0 for _, headers in refused)
    assert 20 <= len(accepted) <= 23
    client = Client(own_service.address)
    jobs = client.jobs()
    assert len(jobs) == len(accepted)
    for job in jobs[:-3]:
        if job.state == "queued":
            client.cancel(job)
    ended = [own_service.wait(job.id, "done", "canceled") for job in jobs]
    assert [job["state"] for job in ended].count("done") >= 2
    first = next(job for job in client.jobs() if job.state == "done")
    with pytest.raises(RefusedError, match="has ended already"):
        client.cancel(first)
    own_service.ask(f"/api/jobs/{first.id}", method="DELETE")
    assert own_service.ask(f"/api/jobs/{first.id}")[0] == 404
    assert not (own_service.folder / "service" / "jobs" / first.id).exists()


def test_files_are_listed_while_their_folder_goes(tmp_path, monkeypatch):
    store = JobStore(tmp_path)
    name = store.add("engine", "mine", {}, 1)
    for folder in ("first", "second"):
        (store.place(name) / folder).mkdir()
        (store.place(name) / folder / "told.json").write_text("{}")
    scan = os.scandir

    def goes(path):
        if str(path).endswith("first"):
            shutil.rmtree(path, ignore_errors=True)
        return scan(path)

    monkeypatch.setattr(os, "scandir", goes)
    assert store.files(name) == ["second/told.json"]
    store.close()


@pytest.mark.further
def test_a_job_that_runs_is_canceled_and_the_next_one_runs(own_service, throw):
    client = Client(own_service.address)
    job = client.analyze_throw(throw, accuracy=0.002)
    own_service.wait(job.id, "running")
    client.cancel(job)
    assert own_service.wait(job.id, "canceled", "done")["state"] == "canceled"
    after = client.analyze_throw(throw, accuracy=0.1)
    assert own_service.wait(after.id, "done", "failed")["state"] == "done"


def worker_of(service):
    """The process of the job: a child of the service that is no guard of a folder."""
    children = psutil.Process(service.process.pid).children()
    return [child for child in children if "crankbase.calls" in child.cmdline()]


@pytest.mark.further
def test_a_crash_of_a_worker_is_survived_and_the_job_tried_again(own_service, throw):
    client = Client(own_service.address)
    job = client.analyze_throw(throw, accuracy=0.002)
    own_service.wait(job.id, "running")
    for child in worker_of(own_service):
        child.kill()
    noted = own_service.wait(job.id, "queued", "running", "done")
    assert client.models() == []
    deadline = time.monotonic() + 60.0
    while not noted["notes"] and time.monotonic() < deadline:
        noted = own_service.json(f"/api/jobs/{job.id}")[1]
    assert "Tried again, because the worker process was ended by SIGKILL" in noted["notes"][0]
    client.cancel(job)


def finished(service, name, least):
    """Wait until so many designs of a study are finished."""
    deadline = time.monotonic() + 180.0
    while time.monotonic() < deadline:
        job = service.json(f"/api/jobs/{name}")[1]
        if job["finished"] >= least:
            return job
        assert job["state"] in ("queued", "running"), job
        time.sleep(0.02)
    raise AssertionError(job)


@pytest.mark.further
def test_the_memory_of_a_job_is_that_of_all_its_processes(serve, tmp_path):
    # Neither the process of the job nor one of its two workers alone takes as much.
    service = serve(tmp_path, job_memory=0.5e9, workers=2)
    _, told = service.json("/api/studies", {"text": STUDY, "name": "study.toml"})
    ended = service.wait(told["id"], "done", "failed")
    assert ended["state"] == "failed"
    assert "GB of memory, more than the limit of 0.5 GB" in ended["problem"]["detail"]
    assert "GB of memory" in ended["notes"][0]
    assert service.end() == 0


@pytest.mark.further
def test_a_study_goes_on_after_server_and_worker_were_killed(serve, tmp_path):
    first = serve(tmp_path)
    status, told = first.json("/api/studies", {"text": STUDY, "name": "study.toml"})
    assert status == 202, told
    before = finished(first, told["id"], 2)
    children = psutil.Process(first.process.pid).children(recursive=True)
    first.process.kill()
    for child in children:
        if child.is_running():
            child.kill()
    first.process.wait()
    second = serve(tmp_path)
    found = Client(second.address).job(told["id"])
    assert found.state in ("queued", "running")
    ended = second.wait(told["id"], "done", "failed")
    assert ended["state"] == "done", ended
    assert ended["attempts"] == 2
    result = Client(second.address).result(found)
    assert result["runs"] + result["held_out"] == ended["total"]
    # Those that were finished were not computed again.
    assert result["computed_now"] <= ended["total"] - before["finished"]
    model = f"job-{told['id']}"
    assert Client(second.address).models() == [model]
    looked = Client(second.address).lookup(model, {"web_width": "0.3 m", "web_thickness": 0.07})
    assert 1e-9 < looked.responses["axial_compliance"].value < 2e-9
    assert second.end() == 0


@pytest.mark.further
def test_a_graceful_stop_leaves_jobs_for_the_next_start(serve, tmp_path, throw):
    first = serve(tmp_path)
    job = Client(first.address).analyze_throw(throw, accuracy=0.002)
    first.wait(job.id, "running")
    children = psutil.Process(first.process.pid).children(recursive=True)
    assert first.end(signal.SIGTERM) == 0
    time.sleep(1.0)
    assert not [child for child in children if child.is_running() and child.status() != "zombie"]
    second = serve(tmp_path)
    assert second.wait(job.id, "running", "queued")["attempts"] <= 1
    Client(second.address).cancel(job)
    assert "Traceback" not in first.log.read_text()


@pytest.mark.further
def test_an_engine_is_run_and_reported(service, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(engine_text())
    client = Client(service.address)
    job = client.run_engine(file)
    found = client.result(job)
    assert found["vibration"]
    status, headers, report = service.ask(f"/api/jobs/{job.id}/report")
    assert status == 200
    assert headers["Content-Security-Policy"].startswith("sandbox")
    assert b"crankshaft vibration" in report
    _, screen = service.json(f"/api/jobs/{job.id}/files/first_screen.json")
    assert 0 < len(screen["findings"]) <= 3
    assert all(about and line for about, line in screen["findings"])
    assert f"job-{job.id}" in client.models() or found["study"] is None


@pytest.fixture
def store(tmp_path):
    made = JobStore(tmp_path)
    yield made
    made.close()


def followed(store, name, change, count=1, stopping=lambda: False):
    """Follow a job by so many streams until all have ended; return the states that each was told."""

    async def stream(source):
        return [json.loads(text)["state"] async for text in source.follow(name)]

    async def run():
        source = Followers(store, stopping)
        changes = asyncio.create_task(change())
        async with asyncio.timeout(30.0):
            told = await asyncio.gather(*[stream(source) for _ in range(count)])
        await changes
        return told

    return asyncio.run(run())


@pytest.mark.slow
def test_every_follower_gets_every_change_and_the_end(store, monkeypatch):
    looks, looked = [], store.job
    monkeypatch.setattr(store, "job", lambda name: looks.append(name) or looked(name))
    name = store.add("study", "mine", {}, 20)

    async def change():
        await asyncio.sleep(0.4)
        store.change(name, state="running")
        await asyncio.sleep(0.4)
        store.settle(name, "done")

    began = time.monotonic()
    assert followed(store, name, change, 100) == [["queued", "running", "done"]] * 100
    assert len(looks) <= 2 + (time.monotonic() - began) / job_store.LOOK  # one for all of them


@pytest.mark.slow
def test_a_store_that_cannot_be_read_for_a_while_ends_no_stream(store, monkeypatch):
    name, looked, full = store.add("study", "mine", {}, 20), store.job, [True]

    def fails(name):
        if full:
            raise StoreError(507, FULL)
        return looked(name)

    monkeypatch.setattr(store, "job", fails)

    async def change():
        await asyncio.sleep(0.3)
        full.clear()
        store.settle(name, "failed")

    assert followed(store, name, change) == [["failed"]]


@pytest.mark.slow
def test_streams_end_with_the_job_s_record_and_with_the_service(store):
    name, ended = store.add("study", "mine", {}, 20), []

    async def remove():
        await asyncio.sleep(0.3)
        store.remove(name)

    assert followed(store, name, remove) == [["queued"]]
    name = store.add("study", "mine", {}, 20)

    async def end():
        await asyncio.sleep(0.3)
        ended.append(True)

    assert followed(store, name, end, stopping=lambda: bool(ended)) == [["queued"]]


@pytest.mark.slow
def test_a_follower_hears_from_time_to_time_that_nothing_changes(store, monkeypatch):
    monkeypatch.setattr(job_store, "PING", 0.2)
    name = store.add("study", "mine", {}, 20)

    async def change():
        await asyncio.sleep(1.0)
        store.settle(name, "canceled")

    (told,) = followed(store, name, change)
    assert set(told[:-1]) == {"queued"}
    assert 3 <= len(told[:-1]) <= 7


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
def runner_store(tmp_path):
    made = JobStore(tmp_path / "service")
    yield made
    made.close()


@pytest.fixture
def runner(runner_store, workers):
    made = JobRunner(runner_store, Bounds())
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
def test_no_failure_of_the_store_ends_the_runner(runner_store, runner, monkeypatch, method, error):
    works, failures = getattr(runner_store, method), []

    def fails(*arguments, **values):
        if len(failures) < 3:
            failures.append(error)
            raise error
        return works(*arguments, **values)

    monkeypatch.setattr(runner_store, method, fails)
    names = [runner.submit("analysis", "throw", {"task": "note"}) for _ in range(3)]
    runner.start()
    jobs = ended(runner_store, *names)
    assert len(failures) == 3
    assert [job.state for job in jobs] == ["done"] * 3
    assert all("Noted." in job.notes for job in jobs)
    until(lambda: runner.health()["state"] == "ok")


def test_what_is_wrong_is_told_until_it_is_over(runner_store, runner, monkeypatch, capfd):
    full, works = [True], runner_store.start_next

    def fails():
        if full:
            runner_store.trouble = FULL
            raise StoreError(507, FULL)
        return works()

    monkeypatch.setattr(runner_store, "start_next", fails)
    name = runner.submit("analysis", "throw", {"task": ""})
    runner.start()
    until(lambda: runner.health()["state"] == "retrying")
    told = runner.health()
    assert told["problems"] == [FULL]
    assert told["queued"] == 1
    assert abs(told["since"] - time.time()) < 60.0
    full.clear()
    assert ended(runner_store, name)[0].state == "done"
    until(lambda: runner.health() | {"queued": 0} == runner.health())
    until(lambda: runner.health()["problems"] == [])
    lines = [json.loads(line) for line in capfd.readouterr().err.splitlines()]
    assert [(line["jobs"], line.get("problem")) for line in lines] == [
        ("retrying", FULL),
        ("ok", None),
    ]


@pytest.mark.slow
def test_a_job_that_finds_the_disk_full_waits_for_space(runner_store, runner, workers, monkeypatch):
    monkeypatch.setattr(job_runner, "LONGEST_PAUSE", 0.05)
    tasks = ("full twice", "full", "die", "")
    names = [runner.submit("analysis", "throw", {"task": task}) for task in tasks]
    runner.start()
    twice, ever, died, sound = ended(runner_store, *names)
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


@pytest.mark.slow
def test_a_worker_that_always_dies_is_given_up_until_a_job_is_submitted(
    runner_store, runner, workers
):
    workers["code"] = DIES
    runner.start()
    until(lambda: runner.health()["state"] == "stopped")
    assert "exit code 7" in runner.health()["problems"][0]
    time.sleep(0.1)
    assert workers["started"] == STARTS
    with pytest.raises(ProblemError, match=r"exit code 7.*tried again now") as refused:
        runner.submit("analysis", "throw", {"task": ""})
    assert refused.value.status == 503
    assert runner_store.count("queued") == 0
    until(lambda: workers["started"] == STARTS + 1)
    workers["code"] = WORKER
    time.sleep(0.1)  # the last one may be under way
    with pytest.raises(ProblemError):
        runner.submit("analysis", "throw", {"task": ""})
    until(lambda: runner.health()["state"] == "ok")
    assert ended(runner_store, runner.submit("analysis", "throw", {"task": ""}))[0].state == "done"


def test_a_full_disk_leaves_nothing_of_a_job_behind(runner_store, runner):
    runner.start()
    (pages,) = runner_store._base.execute("PRAGMA page_count").fetchone()
    runner_store._base.execute(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(StoreError, match=FULL) as refused:
        runner.submit("engine", "mine", {"text": "x" * 100_000})
    assert refused.value.status == 507
    assert runner_store.jobs(10) == []
    assert list((runner_store.folder / "jobs").iterdir()) == []
    until(lambda: runner.health()["state"] == "ok")  # less finds room


@pytest.mark.parametrize("replaced", [False, True])
def test_a_folder_that_vanishes_is_told_and_starts_nothing(runner_store, runner, workers, replaced):
    shutil.rmtree(runner_store.folder)
    if replaced:
        runner_store.folder.mkdir()
        (runner_store.folder / "jobs.sqlite").write_bytes(b"another")
    runner.start()
    until(lambda: runner.health()["problems"] == [GONE])
    with pytest.raises(StoreError, match=GONE) as refused:
        runner.submit("analysis", "throw", {"task": ""})
    assert refused.value.status == 503
    time.sleep(0.05)
    assert workers["started"] == 0


@pytest.mark.further
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
        "from satellites.service.serving import Served; service = Served(Path()); "
        "Path('ready').touch(); time.sleep(100)"
    )
    program.wait_for((program.scratch.parent / "ready").exists)
    assert [one for one in program.children() if "serve" in one.cmdline()]
    assert program.end(signal.SIGTERM) == ([], [])
