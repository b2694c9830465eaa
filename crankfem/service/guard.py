"""Who may ask, how much and how slowly; and one log line a request, without contents."""

import hmac
import re
import time
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from crankfem.service.bounds import LOOPBACK, Settings
from crankfem.service.log import log_line
from crankfem.service.problems import ProblemError, problem, problem_response

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
    """An application around the whole one.

    Parameters
    ----------
    app : ASGI application
    settings : Settings
    """

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
        name = _host_name(host)
        if name is None:
            return 400, "The header Host is no name or address, with or without a port."
        if self._loopback and name not in LOOPBACK:
            return 403, "This service answers to this machine's own names alone."
        origin = headers.get(b"origin")
        if origin is not None and urlsplit_host(origin.decode("latin-1")) != host:
            return 403, "Requests from pages of other origins are refused."
        if headers.get(b"sec-fetch-site") == b"cross-site" and _is_api(scope):
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


def is_key(given: str, key: str) -> bool:
    """Compare keys in constant time."""
    return hmac.compare_digest(given.encode(), key.encode())


def _brings(headers: dict[bytes, bytes], key: str) -> bool:
    kind, _, given = headers.get(b"authorization", b"").decode("latin-1").partition(" ")
    if kind.lower() == "bearer" and is_key(given, key):
        return True
    try:
        cookie = SimpleCookie(headers.get(b"cookie", b"").decode("latin-1")).get(COOKIE)
    except CookieError:
        return False
    return cookie is not None and is_key(cookie.value, key)


def urlsplit_host(origin: str) -> str | None:
    """Return host and port of an origin; None for what is none."""
    try:
        return urlsplit(origin).netloc or None
    except ValueError:
        return None


def _host_name(host: str) -> str | None:
    """Return the name or the address in a Host header, without its port; None for what is no such header."""
    read = HOST.fullmatch(host)
    return None if read is None else (read["address"] or read["name"]).lower()


def _too_large(most: int) -> str:
    return f"The body of the request is larger than {most / 1e6:g} MB."
