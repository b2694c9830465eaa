"""The application: all routes behind the guard, the page beside them."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import cache
from importlib.resources import files
from typing import Any

from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp

from crankbase.errors import InputError
from crankfem.analyses.provenance import program_version
from crankfem.service import problems
from crankfem.service.answers import Service
from crankfem.service.asking import KeyQuestion, read_question
from crankfem.service.bounds import Settings
from crankfem.service.guard import COOKIE, SESSION, Guard, is_key
from crankfem.service.job_routes import job_routes
from crankfem.service.job_runner import JobRunner
from crankfem.service.job_store import JobStore
from crankfem.service.model_routes import Models, model_routes
from crankfem.service.quick_routes import QuickRoutes
from crankfem.service.responses import answer, described, record_schemas
from crankfem.service.throw_routes import routes as throw_routes

# Functions of routes, called most often.
QUICK = ("evaluate_law", "look_up")
SCRIPT = "text/javascript; charset=utf-8"


def make_app(settings: Settings) -> tuple[ASGIApp, JobRunner]:
    """Make the application with its guard and its runner of jobs.

    Parameters
    ----------
    settings : Settings

    Raises
    ------
    InputError
        If its folder cannot be used.
    """
    store = JobStore(settings.folder)
    runner = JobRunner(store, settings.bounds)

    @asynccontextmanager
    async def living(_: FastAPI) -> AsyncIterator[None]:
        runner.start()
        yield
        runner.stop()
        store.close()

    handlers: dict[Any, Any] = {
        problems.ProblemError: problems.answer_error,
        InputError: problems.answer_error,
        HTTPException: problems.answer_http_error,
        Exception: problems.answer_fault,
    }
    models = model_routes(Models(settings.models, store), settings.bounds)
    quick = [
        route
        for route in [*throw_routes.routes, *models.routes]
        if isinstance(route, APIRoute) and route.name in QUICK
    ]
    app = FastAPI(
        title="crankfem",
        version=program_version(),
        summary="Crank throws: outline, compliances, reactions, stress; models; studies; whole engines.",
        openapi_url="/api/openapi.json",
        docs_url=None,
        redoc_url=None,
        lifespan=living,
        exception_handlers=handlers,
    )
    app.include_router(throw_routes)
    app.include_router(models)
    app.include_router(_service_routes(settings))
    app.include_router(job_routes(store, runner, settings.bounds))
    app.include_router(_page_routes())
    _describe(app)
    return Guard(QuickRoutes(app, quick), settings), runner


def _describe(app: FastAPI) -> None:
    """Add the records of quantities to the description of the API."""
    plain = app.openapi

    def openapi() -> dict[str, Any]:
        found = plain()
        found["components"]["schemas"] |= record_schemas()
        return found

    app.openapi = openapi  # type: ignore[method-assign]


def _service_routes(settings: Settings) -> APIRouter:
    routes = APIRouter(prefix="/api", tags=["service"])
    about = {
        "program": "crankfem",
        "version": program_version(),
        "rows": settings.bounds.rows,
        "body": settings.bounds.body,
    }

    @routes.get("", **described(Service))
    async def read_service() -> Response:
        """Return version and limits of the service."""
        return answer(about)

    @routes.post(SESSION.removeprefix("/api"), **described(Service, KeyQuestion))
    async def begin_session(request: Request) -> Response:
        """Give the key once, for a browser to bring it with each request."""
        asked = await read_question(request, KeyQuestion)
        if settings.key is None or not is_key(asked.key, settings.key):
            raise problems.ProblemError(401, "The key of this service is missing or wrong.")
        response = await read_service()
        response.set_cookie(COOKIE, settings.key, httponly=True, samesite="strict")
        return response

    return routes


def _page_routes() -> APIRouter:
    routes = APIRouter(include_in_schema=False)

    @routes.get("/")
    async def read_page() -> Response:
        return _page_file("index.html")

    @routes.get("/page/{name}")
    async def read_page_file(name: str) -> Response:
        return _page_file(name)

    return routes


def _page_file(name: str) -> Response:
    found = _page_files().get(name)
    if found is None:
        raise problems.ProblemError(404, "There is nothing at this path.")
    text, media = found
    return Response(text, media_type=media)


@cache
def _page_files() -> dict[str, tuple[bytes, str]]:
    """Return the page's files by name, and the two scripts of reports that draw the throw to turn."""
    from plotly.offline import get_plotlyjs

    media = {".html": "text/html; charset=utf-8", ".css": "text/css; charset=utf-8", ".js": SCRIPT}
    own = {
        file.name: (file.read_bytes(), media[f".{file.name.rpartition('.')[2]}"])
        for file in (files("crankfem.service") / "page").iterdir()
    }
    drawing = files("crankfem.report") / "templates" / "interactive.js"
    return own | {
        "plotly.js": (get_plotlyjs().encode(), SCRIPT),
        "interactive.js": (drawing.read_bytes(), SCRIPT),
    }
