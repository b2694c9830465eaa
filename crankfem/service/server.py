"""The server: it listens, reports its address, and ends gracefully."""

import asyncio
import socket
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

import uvicorn
from pydantic_core import to_json
from starlette.types import Receive, Scope, Send
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from crankbase.errors import InputError
from crankfem.service.app import make_app
from crankfem.service.bounds import Settings
from crankfem.service.guard import REFUSED, Guard
from crankfem.service.problems import MEDIA_TYPE, problem, problem_response

LATE = HTTPStatus.REQUEST_TIMEOUT.value
WAIT = 1  # seconds after which a refused connection may be tried again
GRACE = 5  # seconds for requests under way when the service ends


def serve(settings: Settings, tell: Callable[[str], None]) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    settings : Settings
    tell : callable
        Called with the address when it accepts requests.

    Raises
    ------
    InputError
        If the folder or the port cannot be used.
    """
    app, runner = make_app(settings)
    bounds = settings.bounds
    late = _refusal(LATE, f"The request took longer than {bounds.seconds:g} s to arrive.")
    unread = _refusal(HTTPStatus.BAD_REQUEST, "The request is not HTTP/1.1.")
    full = Guard(_refuse_for_now, settings)

    class Protocol(AutoHTTPProtocol):  # type: ignore[misc, valid-type]
        """A connection: refused where there are too many, closed where a request does not come in time."""

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            if len(self.connections) > bounds.connections:
                self.app = full
            self._asked_before: Any = None
            self._look_later()

        def send_400_response(self, _: str) -> None:
            self.transport.write(unread)
            self.transport.close()

        def _look_later(self) -> None:
            asyncio.get_running_loop().call_later(bounds.seconds, self._look)

        def _look(self) -> None:
            # The cycle is that of the request whose head came last.
            asked = self.cycle
            waits = asked is None or asked.response_complete or asked.more_body
            if self.transport.is_closing():
                return
            if waits and asked is self._asked_before:
                if asked is None or asked.response_complete or not asked.response_started:
                    self.transport.write(late)
                if asked is not None:
                    asked.scope[REFUSED] = LATE
                self.transport.close()
            else:
                self._asked_before = asked
                self._look_later()

    config = uvicorn.Config(
        app,
        http=Protocol,
        ws="none",
        proxy_headers=False,
        access_log=False,
        log_level="warning",
        server_header=False,
        timeout_graceful_shutdown=GRACE,
        h11_max_incomplete_event_size=65536,
    )
    server = _Server(config, runner)
    with _listening(settings) as listener:
        host, port = listener.getsockname()[:2]
        shown = f"[{host}]" if ":" in host else host
        tell(f"http://{shown}:{port}/")
        server.run(sockets=[listener])


async def _refuse_for_now(scope: Scope, receive: Receive, send: Send) -> None:
    told = problem(
        HTTPStatus.SERVICE_UNAVAILABLE, "Too many connections are open; try again later."
    )
    response = problem_response(told, {"Connection": "close", "Retry-After": str(WAIT)})
    await response(scope, receive, send)


def _refusal(status: int, detail: str) -> bytes:
    """The answer to what does not arrive, or cannot be read, as a request."""
    told = to_json(problem(status, detail))
    head = f"HTTP/1.1 {status:d} {HTTPStatus(status).phrase}\r\nContent-Type: {MEDIA_TYPE}\r\n"
    return f"{head}Content-Length: {len(told)}\r\nConnection: close\r\n\r\n".encode() + told


class _Server(uvicorn.Server):
    def __init__(self, config: uvicorn.Config, runner: Any) -> None:
        super().__init__(config)
        self._runner = runner

    def handle_exit(self, sig: int, frame: Any) -> None:  # noqa: ARG002 - uvicorn's names
        # Who follows a job is let go first: the server waits for all that is under way, once.
        self._runner.announce_stop()
        self.force_exit = self.should_exit
        self.should_exit = True


def _listening(settings: Settings) -> socket.socket:
    host = "127.0.0.1" if settings.host == "localhost" else settings.host
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, settings.port))
    except OSError as error:
        listener.close()
        raise InputError(
            f"--host, --port: given {settings.host} and {settings.port}, which cannot be listened at "
            f"({error.strerror or error}); allowed is an address of this machine and a free port, 0 for any."
        ) from None
    return listener
