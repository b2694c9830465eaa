"""Who may ask, how much and how slowly; and one log line a request, without contents."""

import contextlib
import hmac
import logging
import os
import queue
import re
import secrets
import threading
import time
from dataclasses import dataclass, field
from functools import cache
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from pydantic_core import to_json
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from crankbase.calls import GIGABYTE
from crankbase.choices import is_whole_within
from crankbase.errors import InputError
from crankfem.satellites.service.asking import ProblemError, problem, problem_response


class LogWriter(logging.Handler):
    """Writes lines to standard error from a thread of its own: nothing else waits for whoever reads them.

    Lines that find no space, or no reader, are lost.
    """

    def __init__(self) -> None:
        super().__init__()
        self._lines: queue.Queue[str] = queue.Queue(MOST_LINES)
        threading.Thread(target=self._write, daemon=True).start()

    def write(self, line: str) -> None:
        """Have a line written."""
        with contextlib.suppress(queue.Full):
            self._lines.put_nowait(line)

    def emit(self, record: logging.LogRecord) -> None:
        """Have what a library logs written."""
        self.write(self.format(record))

    def drain(self) -> None:
        """Wait for the lines to be written, a little."""
        deadline = time.monotonic() + DRAINING
        while self._lines.unfinished_tasks and time.monotonic() < deadline:
            time.sleep(0.01)

    def _write(self) -> None:
        while True:
            left = f"{self._lines.get()}\n".encode()
            # No buffer of Python's: its lock would be held at the end of the process, too.
            with contextlib.suppress(OSError):
                while left:
                    left = left[os.write(STANDARD_ERROR, left) :]
            self._lines.task_done()


STANDARD_ERROR = 2
# Lines that wait to be written; seconds for them when the service ends.
MOST_LINES, DRAINING = 1000, 1.0


@cache
def log_writer() -> LogWriter:
    """Return the writer of the log, which begins with its first line."""
    return LogWriter()


def log_line(**entries: Any) -> None:
    """Write a line of the log."""
    log_writer().write(to_json({"time": round(time.time(), 3)} | entries).decode())


LOOPBACK = ("127.0.0.1", "localhost", "::1")
SHORTEST_KEY = 16
MEGABYTE = 1_000_000


@dataclass(frozen=True)
class Bounds:
    """Limits of the service.

    Attributes
    ----------
    body : int
        Of a lookup of many throws, or of a file with its tables [byte]; 100,000 throws take about 6 MB.
    small_body : int
        Of any other request [byte].
    seconds : float
        For a request to arrive, its head and then its body; and for so much of an answer to be read
        as `reading` demands [s].
    reading : float
        Least speed at which an answer must be read [byte/s].
    waiting : int
        Jobs that may wait.
    running : int
        Jobs that run at a time.
    workers : int
        Worker processes of each study.
    job_seconds : float
        For one job [s].
    job_memory : float
        For the process of one job and all that it starts [byte].
    check_seconds : float
        For reading and checking an uploaded file [s].
    rows : int
        Of one lookup: throws, each counted once for every response.
    connections : int
        At a time; beyond, whoever waits longest without a key gives way.
    """

    body: int = 8 * MEGABYTE
    small_body: int = MEGABYTE // 10
    seconds: float = 10.0
    reading: float = 2000.0
    waiting: int = 20
    running: int = 1
    workers: int = 2
    job_seconds: float = 4 * 3600.0
    job_memory: float = 8.0 * GIGABYTE
    check_seconds: float = 30.0
    rows: int = 200_000
    connections: int = 500


@dataclass(frozen=True)
class Settings:
    """Where the service listens, who may ask, and where its jobs lie.

    Attributes
    ----------
    folder : Path
        Of jobs and their files.
    models : Path or None
        Folder of compliance models.
    port : int
        Port; 0 for any free one.
    key : str or None
        That every request to the API must bring; always there where others than this machine can ask.
    session : str
        What a browser that has given the key brings in its place, until the service ends.
    """

    folder: Path
    models: Path | None = None
    host: str = "127.0.0.1"
    port: int = 8765
    key: str | None = field(default=None, repr=False)
    bounds: Bounds = Bounds()
    session: str = field(default_factory=secrets.token_urlsafe, repr=False)

    def __post_init__(self) -> None:
        if not is_whole_within(self.port, 0, 65535):
            raise InputError(
                f"--port: given {self.port!r}; allowed is 0 to 65535, 0 for any free one."
            )
        if self.key is not None and (len(self.key) < SHORTEST_KEY or not self.key.isascii()):
            raise InputError(
                f"key: given one of {len(self.key)} characters; allowed are {SHORTEST_KEY} or more, all "
                "ASCII, because shorter ones can be guessed."
            )
        if not self.host.strip():
            raise InputError(
                f"--host: given {self.host!r}; allowed is an address or a name of this machine, because "
                "an empty one would mean all of its addresses."
            )
        if not self.is_loopback and self.key is None:
            raise InputError(
                f"--host: given {self.host!r} without a key; allowed is {LOOPBACK[0]}, or --key-file beside "
                "--host, because whoever reaches this machine could use the service."
            )
        if self.models is not None and not self.models.is_dir():
            raise InputError(
                f"--models: given {self.models}, which is not a folder; allowed is one with "
                "compliance models."
            )

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can ask."""
        return self.host in LOOPBACK

    @property
    def who(self) -> str:
        """Who is answered, in words."""
        if self.is_loopback:
            return "this machine alone" + ("" if self.key is None else ", with the key")
        return "OPEN TO OTHER MACHINES that reach this one and bring the key; without TLS"


COOKIE = "crankfem_session"
API, SESSION = "/api", "/api/session"
# Of the request that brings the key, the only one whose body is read without it [byte].
KEY_BODY = 10_000
# Requests whose bodies may be large.
LARGE = re.compile(r"/api/(?:files/check|studies|engines|models/[^/]*/lookup)")
# An answer is handed on in pieces of this size: the next one when the last was read [byte].
PIECE = 65536
# Whoever passes a request on may take another of two than this service does.
ONCE = (b"host", b"content-length", b"transfer-encoding", b"authorization", b"origin")
# A name, or an IPv6 address in brackets, and a port.
HOST = re.compile(
    r"(?:\[(?P<address>[0-9A-Fa-f]*:[0-9A-Fa-f:.]*)\]|(?P<name>[\w.-]*))(?::[0-9]*)?", re.ASCII
)
# Where the server notes the status of what it refused itself, and the guard how much it answered and whether
# the request brought the key.
REFUSED, SENT, KEYED = "crankfem.refused", "crankfem.sent", "crankfem.keyed"
# The page takes nothing from elsewhere; plotly writes styles and makes pictures of what it draws.
POLICY_NAME = b"content-security-policy"
POLICY = (
    POLICY_NAME,
    b"default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    b"connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'",
)
# An answer of the API is no page.
API_POLICY = (POLICY_NAME, b"default-src 'none'; style-src 'unsafe-inline'")
HEADERS = [
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cache-control", b"no-store"),
]


class Guard:
    """An application around the whole one."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self._app, self._settings, self._bounds = app, settings, settings.bounds
        self._loopback = settings.is_loopback

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        start, status, size = time.perf_counter(), 0, 0

        async def sending(message: Message) -> None:
            nonlocal status, size
            if message["type"] == "http.response.start":
                status = message["status"]
                headers = message["headers"]
                if all(name != POLICY_NAME for name, _ in headers):
                    headers.append(API_POLICY if _is_api(scope) else POLICY)
                headers.extend(HEADERS)
            body = message.get("body", b"")
            for place in range(PIECE, len(body), PIECE):
                size = scope[SENT] = size + PIECE
                piece = body[place - PIECE : place]
                await send({"type": "http.response.body", "body": piece, "more_body": True})
            if body:
                last = body[(len(body) - 1) // PIECE * PIECE :]
                size = scope[SENT] = size + len(last)
                message = {**message, "body": last}
            await send(message)

        try:
            headers = dict(scope["headers"])
            refusal = self._refusal(scope, headers)
            if refusal is not None:
                response = problem_response(problem(*refusal), {"Connection": "close"})
                await response(scope, receive, sending)
                return
            await self._app(scope, self._bounded(receive, self._most(scope)), sending)
        except ClientDisconnect:
            status = scope.get(REFUSED, 0)  # the server answered, or nobody did
        finally:
            # What was asked for in a path stays out: the route tells which kind of request it was.
            route = getattr(scope.get("route"), "path", None)
            log_line(
                method=scope["method"],
                route=route,
                status=status,
                bytes=size,
                milliseconds=round(1e3 * (time.perf_counter() - start), 3),
            )

    def _refusal(self, scope: Scope, headers: dict[bytes, bytes]) -> tuple[int, str] | None:
        if len(headers) < len(scope["headers"]):
            names = [name for name, _ in scope["headers"]]
            for header in ONCE:
                if names.count(header) > 1:
                    return 400, f"The request has {header.decode().title()} more than once."
        length = headers.get(b"content-length")
        if length is not None and b"transfer-encoding" in headers:
            return 400, "The request has both Content-Length and Transfer-Encoding."
        host = headers.get(b"host", b"").decode("latin-1")
        read = HOST.fullmatch(host)
        if read is None:
            return 400, "The header Host is no name or address, with or without a port."
        if self._loopback and (read["address"] or read["name"]).lower() not in LOOPBACK:
            return 403, "This service answers to this machine's own names alone."
        origin = headers.get(b"origin")
        foreign = origin is not None and _origin_host(origin.decode("latin-1")) != host
        if foreign or (headers.get(b"sec-fetch-site") == b"cross-site" and _is_api(scope)):
            return 403, "Requests from pages of other origins are refused."
        most = self._most(scope)
        if length is not None and not (length.isdigit() and float(length) <= most):
            return 413, _too_large(most)
        if self._settings.key is not None and _is_api(scope) and scope["path"] != SESSION:
            if not _brings(headers, self._settings.key, self._settings.session):
                return 401, "The key of this service is missing or wrong."
            scope[KEYED] = True
        return None

    def _most(self, scope: Scope) -> int:
        """Largest body of a request [byte]."""
        most = self._bounds.small_body
        if scope["path"] == SESSION:
            most = KEY_BODY
        elif LARGE.fullmatch(scope["path"]):
            most = self._bounds.body
        return min(most, self._bounds.body)

    @staticmethod
    def _bounded(receive: Receive, most: int) -> Receive:
        """Count the bytes of a body as they come, whatever its headers say."""
        taken = 0

        async def receiving() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > most:
                raise ProblemError(413, _too_large(most), {"Connection": "close"})
            return message

        return receiving


def _is_api(scope: Scope) -> bool:
    return str(scope["path"]).startswith(f"{API}/") or scope["path"] == API


def is_key(text: str, key: str) -> bool:
    """Compare keys in constant time."""
    return hmac.compare_digest(text.encode(), key.encode())


def _brings(headers: dict[bytes, bytes], key: str, session: str) -> bool:
    kind, _, token = headers.get(b"authorization", b"").decode("latin-1").partition(" ")
    if kind.lower() == "bearer" and is_key(token, key):
        return True
    try:
        cookie = SimpleCookie(headers.get(b"cookie", b"").decode("latin-1")).get(COOKIE)
    except CookieError:
        return False
    return cookie is not None and is_key(cookie.value, session)


def _origin_host(origin: str) -> str | None:
    """Return host and port of an origin; None for what is none."""
    try:
        return urlsplit(origin).netloc or None
    except ValueError:
        return None


def _too_large(most: int) -> str:
    return f"The body of the request is larger than {most / 1e6:g} MB."
