"""The application: all routes behind the guard, the page beside them."""

import asyncio
import logging
import os
import socket
import struct
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import cache
from http import HTTPStatus
from importlib.resources import files
from typing import Any

import uvicorn
from anyio import to_thread
from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute
from pydantic_core import to_json
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from crankbase.errors import InputError
from crankfem.analyses.provenance import program_version
from crankfem.satellites.service import asking
from crankfem.satellites.service.answers import Service
from crankfem.satellites.service.asking import (
    MEDIA_TYPE,
    KeyQuestion,
    problem,
    problem_response,
    read_question,
)
from crankfem.satellites.service.guard import (
    COOKIE,
    KEYED,
    REFUSED,
    SENT,
    SESSION,
    Guard,
    Settings,
    is_key,
    log_writer,
)
from crankfem.satellites.service.job_routes import job_routes
from crankfem.satellites.service.job_runner import JobRunner
from crankfem.satellites.service.job_store import JobStore
from crankfem.satellites.service.model_routes import Models, QuickRoutes, model_routes
from crankfem.satellites.service.model_routes import routes as throw_routes
from crankfem.satellites.service.responses import answer, described, record_schemas

# Functions of routes, called most often.
QUICK = ("evaluate_law", "look_up")
SCRIPT = "text/javascript; charset=utf-8"


def make_app(settings: Settings) -> tuple[ASGIApp, JobRunner]:
    """Make the application with its guard and its runner of jobs."""
    store = JobStore(settings.folder)
    runner = JobRunner(store, settings.bounds)

    @asynccontextmanager
    async def living(_: FastAPI) -> AsyncIterator[None]:
        runner.start()
        yield
        runner.stop()
        store.close()

    handlers: dict[Any, Any] = {
        asking.ProblemError: asking.answer_error,
        InputError: asking.answer_error,
        HTTPException: asking.answer_http_error,
        Exception: asking.answer_fault,
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
    plain = app.openapi

    def openapi() -> dict[str, Any]:
        schema = plain()
        schema["components"]["schemas"] |= record_schemas()
        return schema

    app.openapi = openapi  # type: ignore[method-assign]
    return Guard(QuickRoutes(app, quick), settings), runner


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
            raise asking.ProblemError(401, "The key of this service is missing or wrong.")
        response = await read_service()
        response.set_cookie(COOKIE, settings.session, httponly=True, samesite="strict")
        return response

    return routes


def _page_routes() -> APIRouter:
    routes = APIRouter(include_in_schema=False)

    @routes.get("/")
    async def read_page() -> Response:
        return await read_page_file("index.html")

    @routes.get("/page/{name}")
    async def read_page_file(name: str) -> Response:
        page = await to_thread.run_sync(_page_files)
        if name not in page:
            raise asking.ProblemError(404, "There is nothing at this path.")
        text, media = page[name]
        return Response(text, media_type=media)

    return routes


@cache
def _page_files() -> dict[str, tuple[bytes, str]]:
    """Return the page's files by name, and the two scripts of reports that draw the throw to turn."""
    from plotly.offline import get_plotlyjs

    media = {".html": "text/html; charset=utf-8", ".css": "text/css; charset=utf-8", ".js": SCRIPT}
    page = {
        file.name: (file.read_bytes(), media[f".{file.name.rpartition('.')[2]}"])
        for file in (files("crankfem.satellites.service") / "page").iterdir()
    }
    drawing = files("crankfem.report") / "templates" / "interactive.js"
    return page | {
        "plotly.js": (get_plotlyjs().encode(), SCRIPT),
        "interactive.js": (drawing.read_bytes(), SCRIPT),
    }


LATE = HTTPStatus.REQUEST_TIMEOUT.value
WAIT = 1  # seconds after which a refused connection may be tried again
UNREAD = 262_144  # bytes of an answer that the system takes before they are read
GRACE = 5  # seconds for requests under way when the service ends


def serve(settings: Settings, tell: Callable[[str], None]) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    tell : callable
        Called with the address when it accepts requests.
    """
    app, runner = make_app(settings)
    bounds = settings.bounds
    late = _refusal(LATE, f"The request took longer than {bounds.seconds:g} s to arrive.")
    unread = _refusal(HTTPStatus.BAD_REQUEST, "The request is not HTTP/1.1.")
    full = Guard(_refuse_for_now, settings)

    class Protocol(AutoHTTPProtocol):  # type: ignore[misc, valid-type]
        """A connection: closed where a request does not come in time, or its answer is not read.

        Where there are too many, the one of them that waits longest for its client makes room; where none
        does, or all of those have brought the key, the new one is refused.
        """

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self.since, self._lost = time.monotonic(), False
            self._asked_before: Any = None
            self._delivered = 0
            if len(self.connections) > bounds.connections:
                silent = [
                    other for other in self.connections if other is not self and other.waits()
                ]
                if silent:
                    min(silent, key=lambda other: other.since).drop()
                else:
                    self.app = full
            self._look_later()

        def connection_lost(self, exc: Exception | None) -> None:
            self._lost = True
            super().connection_lost(exc)

        def drop(self) -> None:
            """Close it at once; without lingering the system, too, forgets what is not read."""
            line = self.transport.get_extra_info("socket")
            line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            self.transport.abort()

        def waits(self) -> bool:
            """Return whether it waits for a client that has not brought the key."""
            asked = self.cycle
            if asked is None:
                return True
            unread = self.transport.get_write_buffer_size() > 0
            waiting = asked.response_complete or asked.more_body or unread
            return waiting and KEYED not in asked.scope

        def send_400_response(self, _: str) -> None:
            self.transport.write(unread)
            self.transport.close()

        def _look_later(self) -> None:
            asyncio.get_running_loop().call_later(bounds.seconds, self._look)

        def _look(self) -> None:
            if self._lost:
                return
            # The cycle is that of the request whose head came last.
            asked, unread = self.cycle, self.transport.get_write_buffer_size()
            delivered = (0 if asked is None else asked.scope.get(SENT, 0)) - unread
            little = delivered - self._delivered < bounds.reading * bounds.seconds
            before, self._asked_before, self._delivered = self._asked_before, asked, delivered
            if asked is not before:
                self.since = time.monotonic()
            elif unread and little:
                self.drop()
                return
            elif not (self.transport.is_closing() or unread) and (
                asked is None or asked.response_complete or asked.more_body
            ):
                if asked is None or asked.response_complete or not asked.response_started:
                    self.transport.write(late)
                if asked is not None:
                    asked.scope[REFUSED] = LATE
                self.transport.close()
            self._look_later()

    config = uvicorn.Config(
        app,
        http=Protocol,
        ws="none",
        proxy_headers=False,
        access_log=False,
        log_config=None,
        log_level="warning",
        server_header=False,
        timeout_graceful_shutdown=GRACE,
        h11_max_incomplete_event_size=65536,
    )
    logging.getLogger().addHandler(log_writer())
    # Jobs and their files, also those that their processes write, are for the user alone.
    os.umask(0o077)
    try:
        with _listening(settings) as listener:
            host, port = listener.getsockname()[:2]
            shown = f"[{host}]" if ":" in host else host
            server = _Server(config, runner, lambda: tell(f"http://{shown}:{port}/"))
            server.run(sockets=[listener])
    finally:
        log_writer().drain()


async def _refuse_for_now(scope: Scope, receive: Receive, send: Send) -> None:
    fault = problem(
        HTTPStatus.SERVICE_UNAVAILABLE, "Too many connections are open; try again later."
    )
    response = problem_response(fault, {"Connection": "close", "Retry-After": str(WAIT)})
    await response(scope, receive, send)


def _refusal(status: int, detail: str) -> bytes:
    """The answer to what does not arrive, or cannot be read, as a request."""
    body = to_json(problem(status, detail))
    head = f"HTTP/1.1 {status:d} {HTTPStatus(status).phrase}\r\nContent-Type: {MEDIA_TYPE}\r\n"
    return f"{head}Content-Length: {len(body)}\r\nConnection: close\r\n\r\n".encode() + body


class _Server(uvicorn.Server):
    def __init__(self, config: uvicorn.Config, runner: Any, tell: Callable[[], None]) -> None:
        super().__init__(config)
        self._runner, self._tell = runner, tell

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            self._tell()

    def handle_exit(self, sig: int, frame: Any) -> None:  # noqa: ARG002 - uvicorn's names
        # Who follows a job is let go first: the server waits for all that is under way, once.
        self._runner.stopping = True
        self.force_exit = self.should_exit
        self.should_exit = True


def _listening(settings: Settings) -> socket.socket:
    host = "127.0.0.1" if settings.host == "localhost" else settings.host
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Of each connection: the system would keep some megabytes for those who do not read.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNREAD)
        listener.bind((host, settings.port))
    except OSError as error:
        listener.close()
        raise InputError(
            f"--host, --port: given {settings.host} and {settings.port}, which cannot be listened at "
            f"({error.strerror or error}); allowed is an address of this machine and a free port, 0 for any."
        ) from None
    return listener
