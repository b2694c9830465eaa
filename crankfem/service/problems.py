"""Errors of the API: application/problem+json, with a message for each wrong field."""

import re
from collections.abc import Iterator
from http import HTTPStatus
from typing import Any

from pydantic_core import to_json
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Match

from crankbase.errors import InputError

METHODS = ("DELETE", "GET", "POST")  # that any path takes
MEDIA_TYPE = "application/problem+json"
_FIELD = re.compile(r"(?P<field>\[?[\w.-]+(?:\[\d+\][\w.]*)*\]?): ")


class ProblemError(Exception):
    """A request that is refused, with the status that says so.

    Parameters
    ----------
    status : int
    detail : str
        A sentence.
    headers : dict, optional
    """

    def __init__(self, status: int, detail: str, headers: dict[str, str] | None = None) -> None:
        super().__init__(detail)
        self.status, self.detail, self.headers = status, detail, headers or {}


def field_errors(error: InputError) -> list[dict[str, str]]:
    """Return the errors by field: "field", empty where a message names none, and "message"."""
    found = []
    for sentence in error.sentences:
        named = _FIELD.match(sentence)
        found.append({"field": named["field"] if named else "", "message": sentence})
    return found


def problem(status: int, detail: str, errors: list[dict[str, str]] | None = None) -> dict[str, Any]:
    """Return the content of a problem (RFC 9457), with `errors` by field."""
    return {
        "type": "about:blank",
        "title": HTTPStatus(status).phrase,
        "status": status,
        "detail": detail,
        "errors": errors or [],
    }


def problem_response(content: dict[str, Any], headers: dict[str, str] | None = None) -> Response:
    """Return a problem as response."""
    return Response(to_json(content), content["status"], headers, media_type=MEDIA_TYPE)


async def answer_error(_: Request, error: Exception) -> Response:
    """Answer a request that is refused, or input that cannot be used."""
    if isinstance(error, ProblemError):
        return problem_response(problem(error.status, error.detail), error.headers)
    assert isinstance(error, InputError)
    return problem_response(problem(422, error.sentences[0], field_errors(error)))


async def answer_http_error(request: Request, error: Exception) -> Response:
    """Answer a wrong path or method."""
    status = getattr(error, "status_code", 500)
    details = {404: "There is nothing at this path.", 405: "This path does not take this method."}
    detail = details.get(status, HTTPStatus(status).phrase + ".")
    headers = dict(getattr(error, "headers", None) or {})
    if status == HTTPStatus.METHOD_NOT_ALLOWED:
        headers["Allow"] = ", ".join(_methods(request))
    return problem_response(problem(status, detail), headers)


def _methods(request: Request) -> Iterator[str]:
    """Methods of all routes at the path of a request; a route alone names its own in its error."""
    for method in METHODS:
        scope = dict(request.scope) | {"method": method}
        if any(route.matches(scope)[0] is Match.FULL for route in request.app.routes):
            yield method


async def answer_fault(_: Request, error: Exception) -> Response:
    """Answer an internal error without its details."""
    return problem_response(
        problem(500, f"The service met {type(error).__name__}, an unexpected error.")
    )
