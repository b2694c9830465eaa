"""Who may ask, how much and how slowly; and one log line a request, without contents."""

import contextlib
import hmac
import re
import sys
import time
from dataclasses import dataclass
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
from crankfem.service.asking import ProblemError, problem, problem_response


def log_line(**entries: Any) -> None:
    """Write a line; one that finds no space, or no reader, is lost."""
    line = to_json({"time": round(time.time(), 3)} | entries).decode()
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.write(f"{line}\n")


LOOPBACK = ("127.0.0.1", "localhost", "::1")
SHORTEST_KEY = 16
MEGABYTE = 1_000_000


@dataclass(frozen=True)
class Bounds:
    """Limits of the service.

    Attributes
    ----------
    body : int
        Of a request [byte]; a lookup of 100,000 throws takes about 6 MB.
    seconds : float
        For a request to arrive, its head and then its body [s].
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
        Of one lookup.
    connections : int
        At a time.
    """

    body: int = 32 * MEGABYTE
    seconds: float = 10.0
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
    """

    folder: Path
    models: Path | None = None
    host: str = "127.0.0.1"
    port: int = 8765
    key: str | None = None
    bounds: Bounds = Bounds()

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


COOKIE = "crankfem_key"
API, SESSION = "/api", "/api/session"
# Of the request that brings the key, the only one whose body is read without it [byte].
KEY_BODY = 10_000
# Whoever passes a request on may take another of two than this service does.
ONCE = (b"host", b"content-length", b"transfer-encoding", b"authorization", b"origin")
# A name, or an IPv6 address in brackets, and a port.
HOST = re.compile(
    r"(?:\[(?P<address>[0-9A-Fa-f]*:[0-9A-Fa-f:.]*)\]|(?P<name>[\w.-]*))(?::[0-9]*)?", re.ASCII
)
# Where the server notes the status of what it refused itself.
REFUSED = "crankfem.refused"
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
            else:
                size += len(message.get("body", b""))
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
        key = self._settings.key
        needs_key = key is not None and _is_api(scope) and scope["path"] != SESSION
        if needs_key and not _brings(headers, str(key)):
            return 401, "The key of this service is missing or wrong."
        return None

    def _most(self, scope: Scope) -> int:
        """Largest body of a request [byte]."""
        return min(KEY_BODY, self._bounds.body) if scope["path"] == SESSION else self._bounds.body

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


def _brings(headers: dict[bytes, bytes], key: str) -> bool:
    kind, _, token = headers.get(b"authorization", b"").decode("latin-1").partition(" ")
    if kind.lower() == "bearer" and is_key(token, key):
        return True
    try:
        cookie = SimpleCookie(headers.get(b"cookie", b"").decode("latin-1")).get(COOKIE)
    except CookieError:
        return False
    return cookie is not None and is_key(cookie.value, key)


def _origin_host(origin: str) -> str | None:
    """Return host and port of an origin; None for what is none."""
    try:
        return urlsplit(origin).netloc or None
    except ValueError:
        return None


def _too_large(most: int) -> str:
    return f"The body of the request is larger than {most / 1e6:g} MB."
