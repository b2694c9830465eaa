"""Jobs: queued, followed, canceled, lost, found again."""

import signal
import time

import psutil
import pytest

from crankfem.client import Client, RefusedError
from serving import STUDY


def engine_text():
    from crankfem.files.engine.file_kinds import engine_template

    return engine_template("mine.toml", 3, 4)


@pytest.fixture
def own_service(serve, tmp_path):
    """A service of the test's own."""
    return serve(tmp_path)


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


@pytest.mark.slow
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


@pytest.mark.slow
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
    service = serve(tmp_path, job_memory=0.6e9, workers=2)
    _, told = service.json("/api/studies", {"text": STUDY, "name": "study.toml"})
    ended = service.wait(told["id"], "done", "failed")
    assert ended["state"] == "failed"
    assert "GB of memory, more than the limit of 0.6 GB" in ended["problem"]["detail"]
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
    assert f"job-{job.id}" in client.models() or found["study"] is None
