"""Jobs: submitted, followed, canceled, their results and files; and files checked before."""

import asyncio
import json
import re
from collections.abc import AsyncIterator, Mapping
from pathlib import Path
from typing import Any

import anyio.to_thread
from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import FileResponse, Response, StreamingResponse

from crankbase.calls import ProcessLostError
from crankbase.errors import InputError
from crankbase.model import InputModel
from crankfem.satellites.service.answers import ENDED, CheckedText, Health, Job, Jobs
from crankfem.satellites.service.asking import (
    AnalysisQuestion,
    FileQuestion,
    ProblemError,
    StressQuestion,
    read_body,
    read_question,
)
from crankfem.satellites.service.guard import Bounds
from crankfem.satellites.service.job_runner import LOADING, JobRunner
from crankfem.satellites.service.job_store import Followers, JobStore
from crankfem.satellites.service.responses import JSON, answer, described
from crankfem.satellites.service.tasks import REPORT, RESULT
from geometry.gmsh_session import IsolatedProcess

MOST_LISTED = 100
RETRY_SECONDS = "5"
EVENTS = "text/event-stream"
# Pages that jobs have made run apart from the service's: their scripts reach nothing of it.
SANDBOX = (
    "sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
)
BOXED = {"Content-Security-Policy": SANDBOX}
MEDIA = {
    ".json": JSON,
    ".html": "text/html; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".toml": "text/plain; charset=utf-8",
    ".csv": "text/csv; charset=utf-8",
    ".step": "model/step",
}
OTHER = "application/octet-stream"
CHECKED = re.compile(r"[0-9a-f]{16}")


def throw_report(folder: Path) -> str:
    """Make the report of a throw from the files of its job."""
    from crankfem.report.writing import render_throw_report

    return render_throw_report(json.loads((folder / RESULT).read_text(encoding="utf-8")), folder)


def job_routes(store: JobStore, runner: JobRunner, bounds: Bounds) -> APIRouter:
    """Make the routes of jobs."""
    routes = APIRouter(prefix="/api")
    checker, checking = IsolatedProcess(), asyncio.Lock()
    followers = Followers(store, lambda: runner.stopping)

    def queued(asked: type[InputModel]) -> dict[str, Any]:
        return described(Job, asked, 429, 507, status=202, says="queued")

    def job_named(name: str) -> Job:
        job = store.job(name) if CHECKED.fullmatch(name) else None
        if job is None:
            raise ProblemError(404, "There is no job of that name.")
        return job

    def submit(kind: str, title: str, question: Mapping[str, Any]) -> Response:
        name = runner.submit(kind, title, question)
        if name is None:
            raise ProblemError(
                429,
                f"{bounds.waiting} jobs are waiting; try again later.",
                {"Retry-After": RETRY_SECONDS},
            )
        return answer(job_named(name), 202, {"Location": f"/api/jobs/{name}"})

    async def submit_file(request: Request, kind: str, section: str) -> Response:
        asked, checked = await read_file_question(request)
        if section not in checked["commands"]:
            raise InputError(
                f"text: given a {checked['kind']} file that serves {', '.join(checked['commands'])}; allowed "
                f"is one that serves {section}."
            )
        return await anyio.to_thread.run_sync(
            submit, kind, asked["name"].removesuffix(".toml"), asked
        )

    async def read_file_question(request: Request) -> tuple[dict[str, Any], dict[str, Any]]:
        """Read and check a file in a separate process with a limit of time, one at a time."""
        body = await read_body(request)
        async with checking:
            asked, checked = await anyio.to_thread.run_sync(check, body)
        if isinstance(asked, int):
            raise ProblemError(asked, checked)
        return asked, checked

    def check(body: bytes) -> Any:
        try:
            # A process that has just started takes its time on a busy machine.
            checker.call("crankfem.satellites.service.tasks:load_checks", time_limit=LOADING)
            task, limit = "crankfem.satellites.service.tasks:check_body", bounds.check_seconds
            return checker.call(task, body, time_limit=limit)
        except ProcessLostError as lost:
            raise InputError(f"text: given a file that cannot be checked: {lost}.") from None

    @routes.post("/throws/analysis", tags=["throws"], **queued(AnalysisQuestion))
    async def analyze_throw(request: Request) -> Response:
        """Analyze a throw by finite elements: compliances, 12 x 12 stiffness, reactions, error bars."""
        asked = await read_question(request, AnalysisQuestion)
        asked.read_throw(), asked.read_material(), asked.read_neighbors()
        return submit("analysis", "throw", asked.model_dump())

    @routes.post("/throws/stress", tags=["throws"], **queued(StressQuestion))
    async def analyze_stress(request: Request) -> Response:
        """Find the stresses at a throw's fillets."""
        asked = await read_question(request, StressQuestion)
        asked.read_throw(), asked.read_material()
        return submit("stress", "stress", asked.model_dump())

    @routes.post("/files/check", tags=["files"], **described(CheckedText, FileQuestion))
    async def check_uploaded(request: Request) -> Response:
        """Check a file: return its interpretation, or errors by field."""
        _, checked = await read_file_question(request)
        return answer(checked)

    @routes.post("/studies", tags=["files"], **queued(FileQuestion))
    async def run_study(request: Request) -> Response:
        """Run the study of a file with the sections [throw] and [study], and fit its equations."""
        return await submit_file(request, "study", "doe")

    @routes.post("/engines", tags=["files"], **queued(FileQuestion))
    async def run_engine(request: Request) -> Response:
        """Run a whole engine file: everything, and a report."""
        return await submit_file(request, "engine", "run")

    @routes.get("/health", tags=["service"], **described(Health))
    async def read_health() -> Response:
        """Return whether jobs run, and what is wrong."""
        return answer(runner.health())

    @routes.get("/jobs", tags=["jobs"], **described(Jobs))
    async def list_jobs() -> Response:
        """List the newest jobs."""
        jobs = await anyio.to_thread.run_sync(store.jobs, MOST_LISTED)
        return answer({"jobs": jobs})

    @routes.get("/jobs/{name}", tags=["jobs"], **described(Job, None, 404))
    async def read_job(name: str) -> Response:
        """Return how far a job is."""
        return answer(job_named(name))

    @routes.delete("/jobs/{name}", tags=["jobs"], **described(Job, None, 404, 409, 507))
    async def remove_job(name: str) -> Response:
        """Forget a job that has ended, with its files."""
        job = job_named(name)
        if job.state not in ENDED:
            raise ProblemError(409, "The job has not ended; cancel it first.")
        await anyio.to_thread.run_sync(store.remove, name)
        return answer(job)

    @routes.post("/jobs/{name}/cancel", tags=["jobs"], **described(Job, None, 404, 409, 507))
    async def cancel_job(name: str) -> Response:
        """Cancel a job that waits or runs."""
        if job_named(name).state in ENDED:
            raise ProblemError(409, "The job has ended already.")
        await anyio.to_thread.run_sync(runner.cancel, name)
        return answer(job_named(name))

    @routes.get("/jobs/{name}/events", tags=["jobs"], **described(EVENTS, None, 404))
    async def follow_job(name: str) -> Response:
        """Follow a job: an event with the whole job at each change, until it has ended."""
        job_named(name)

        async def events() -> AsyncIterator[bytes]:
            async for text in followers.follow(name):
                yield b"event: job\ndata: " + text + b"\n\n"

        return StreamingResponse(events(), media_type=EVENTS)

    def file_named(name: str, path: str) -> Response:
        job_named(name)
        file = store.file(name, path)
        if file is None:
            raise ProblemError(404, "The job has no such file, or not yet.")
        media = MEDIA.get(file.suffix, OTHER)
        return FileResponse(file, media_type=media, headers=BOXED)

    @routes.get("/jobs/{name}/result", tags=["jobs"], **described(JSON, None, 404))
    async def read_result(name: str) -> Response:
        """Return the numbers of a job, as soon as they are there, in SI units."""
        return file_named(name, RESULT)

    @routes.get("/jobs/{name}/report", tags=["jobs"], **described("text/html", None, 404))
    async def read_report(name: str) -> Response:
        """Return the report of an engine or of a throw."""
        job = job_named(name)
        if job.kind != "analysis" or job.state != "done":
            return file_named(name, REPORT)
        text = await anyio.to_thread.run_sync(throw_report, store.place(name))
        return Response(text, headers=BOXED, media_type=MEDIA[".html"])

    @routes.get("/jobs/{name}/files/{path:path}", tags=["jobs"], **described("*/*", None, 404))
    async def read_file(name: str, path: str) -> Response:
        """Return a file of a job, by the name that the job lists."""
        return file_named(name, path)

    return routes
