"""Requests to the service: their bodies, read by the models of the files.

Quantities are numbers in SI units or texts with units, as ``0.17`` or ``"170 mm"``.
"""

import re
from collections.abc import Mapping
from http import HTTPStatus
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BeforeValidator, Field, WithJsonSchema
from pydantic_core import from_json, to_json
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Match

from crankbase.choices import is_number
from crankbase.errors import InputError, first_sentences
from crankbase.model import InputModel, field_extra, part_kind, quantity_field
from crankbase.written_quantity import parse_quantity
from fem.material import STEEL, Material
from fem.supports import Neighbors, Support
from geometry.throw import CrankThrow

METHODS = ("DELETE", "GET", "POST")  # that any path takes
MEDIA_TYPE = "application/problem+json"
_FIELD = re.compile(r"(?P<field>\[?[\w.-]+(?:\[\d+\][\w.]*)*\]?): ")


class ProblemError(Exception):
    """A request that is refused, with the status that says so.

    Parameters
    ----------
    detail : str
        A sentence.
    """

    def __init__(self, status: int, detail: str, headers: dict[str, str] | None = None) -> None:
        super().__init__(detail)
        self.status, self.detail, self.headers = status, detail, headers or {}


def field_errors(error: InputError) -> list[dict[str, str]]:
    """Return the first errors by field: "field", empty where a message names none, and "message"."""
    errors = []
    for sentence in first_sentences(str(error)):
        named = _FIELD.match(sentence)
        errors.append({"field": named["field"] if named else "", "message": sentence})
    return errors


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
        # Of all routes at the path: a route alone names its own.
        scopes = [dict(request.scope) | {"method": method} for method in METHODS]
        headers["Allow"] = ", ".join(
            scope["method"]
            for scope in scopes
            if any(route.matches(scope)[0] is Match.FULL for route in request.app.routes)
        )
    return problem_response(problem(status, detail), headers)


async def answer_fault(_: Request, error: Exception) -> Response:
    """Answer an internal error without its details."""
    return problem_response(
        problem(500, f"The service met {type(error).__name__}, an unexpected error.")
    )


Asked = TypeVar("Asked", bound=InputModel)


def _newtons(given: object) -> object:
    """Read a force with its unit; what is no text is left to the field."""
    if not isinstance(given, str):
        return given
    try:
        return parse_quantity(given, "N", "")
    except InputError as error:
        raise ValueError(str(error).removeprefix(": ")) from None


Force = Annotated[
    float,
    BeforeValidator(_newtons),
    WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string"}]}),
]
Pin = tuple[Force, Force, Force]
JSON = b"application/json"
# Of a question, but for a file with its tables: a lookup of many throws has one list for each dimension.
MOST_LISTS, MOST_TEXTS = 500, 25_000
UNIT_FORCE = 1e5  # towards the shaft [N]


class DimensionsQuestion(InputModel):
    """A throw."""

    throw: dict[str, Any] = Field(description="dimensions of the throw")

    def read_throw(self) -> CrankThrow:
        """Return the throw."""
        return read_record(CrankThrow, self.throw, "throw")


class ThrowQuestion(DimensionsQuestion):
    """A throw and its material."""

    material: dict[str, Any] | None = Field(None, description="of the throw; steel by default")

    def read_material(self) -> Material:
        """Return the material."""
        material = self.material
        return STEEL if material is None else read_record(Material, material, "material")


class OutlineQuestion(DimensionsQuestion):
    """A throw and from where to look at it."""

    view: Literal["side", "front"] = Field("side", description="from where to look")
    letters: bool = Field(False, description="whether dimensions are drawn, with their letters")


def _angle(default: float | None, meaning: str = "angle between neighboring cranks [deg]") -> Any:
    return quantity_field(meaning, "", minimum=-360.0, maximum=360.0, default=default)


class FormulasQuestion(ThrowQuestion):
    """A throw between equal neighbors."""

    gamma_deg: float = _angle(180.0)


class NeighborsQuestion(InputModel):
    """Angles to the neighbors of a throw."""

    gamma_deg: float | None = _angle(None)
    left_gamma_deg: float | None = _angle(
        None, "angle to the left neighbor where it differs, for reactions and finite elements [deg]"
    )

    def read_neighbors(self) -> Neighbors | None:
        """Return the support by neighbors, None without an angle."""
        if self.gamma_deg is None:
            if self.left_gamma_deg is None:
                return None
            raise InputError(
                "gamma_deg: missing; the angle to the right neighbor [deg] must be given together with that "
                "to the left one."
            )
        left = self.gamma_deg if self.left_gamma_deg is None else self.left_gamma_deg
        return Neighbors(left, self.gamma_deg)


class ReactionsQuestion(NeighborsQuestion):
    """A force on the pin and how the ends are supported, where reactions are wanted."""

    pin_force: Pin | None = Field(
        None, description="force on the pin across the shaft, in the throw frame, x y z [N]"
    )
    support: Literal["pinned", "guided", "neighbors"] = Field(
        "pinned", description="of the ends; neighbors are equal throws at gamma_deg"
    )

    def read_support(self) -> Support:
        """Return the support."""
        neighbors = self.read_neighbors()
        if self.support != "neighbors":
            return self.support
        if neighbors is None:
            raise InputError(
                "gamma_deg: missing; the angle between neighboring cranks [deg] must be given with the "
                "support neighbors."
            )
        return neighbors


class LawQuestion(ThrowQuestion, ReactionsQuestion):
    """A throw; with a force on its pin, the reactions are reported too."""

    ranges: bool = Field(
        False,
        description="whether the range of the law is wanted in each dimension, the others kept",
    )
    slopes: bool = Field(
        False, description="whether the change of e_n, ends pinned, with each dimension is wanted"
    )


class AnalysisQuestion(ThrowQuestion, NeighborsQuestion):
    """A throw for finite elements."""

    pin_force: Pin | None = Field(
        None,
        description="force on the first pin in the throw frame, x y z [N]; 100 kN towards the shaft if none",
    )
    accuracy: float = quantity_field(
        "wished relative accuracy of e_n", "", minimum=0.002, maximum=0.1, default=0.01
    )
    stress: bool = Field(False, description="whether stresses at the fillets are wanted")


class StressQuestion(ThrowQuestion):
    """A throw for the stresses at its fillets."""

    accuracy: float = quantity_field(
        "wished relative accuracy of the stresses", "", minimum=0.02, maximum=0.2, default=0.05
    )


class LookupQuestion(ReactionsQuestion):
    """Dimensions to look up in a model: numbers, texts, or lists of them for many throws."""

    throw: dict[str, Any] | None = Field(None, description="throw whose dimensions are used")
    material: dict[str, Any] | None = Field(
        None, description="of the throws, of the model's Poisson's ratio; the model's by default"
    )
    dimensions: dict[str, Any] = Field(
        {}, description="value or list of values by name; these change the throw's"
    )
    responses: list[str] | None = Field(None, description="which; all of the model by default")
    strict: bool = Field(False, description="refuse throws outside the range of the model")


class FileQuestion(InputModel):
    """A file as text, and the tables that it names."""

    text: str = Field(description="content of the TOML file; to be checked, also of a STEP file")
    name: str = Field("engine.toml", description="name of the file")
    tables: dict[str, str] = Field({}, description="content of each table by the name of its file")


class KeyQuestion(InputModel):
    """The key of the service."""

    key: str = Field(description="key of the service")


async def read_body(request: Request) -> bytes:
    """Return the body of a request.

    Raises
    ------
    ProblemError
        If it is said to be anything but JSON.
    """
    media = next(
        (value for name, value in request.scope["headers"] if name == b"content-type"), b""
    )
    if media != JSON and media.partition(b";")[0].strip().lower() != JSON:
        raise ProblemError(415, "The body of the request must be application/json.")
    return await request.body()


async def read_question(request: Request, kind: type[Asked]) -> Asked:
    """Read the body of a request; what it holds is counted before it is read.

    Raises
    ------
    ProblemError
        If it is no JSON object, or has too many lists or texts.
    """
    body = await read_body(request)
    if body.count(b"[") + body.count(b"{") > MOST_LISTS or body.count(b'"') > 2 * MOST_TEXTS:
        raise ProblemError(
            413,
            f"The body of the request has more than {MOST_LISTS} lists and tables, or more than {MOST_TEXTS} "
            "names and texts; allowed are so many, because a question about one throw has some ten, and one "
            "about many takes their dimensions as lists of numbers in SI units.",
        )
    return parse_question(body, kind)


def parse_question(body: bytes, kind: type[Asked]) -> Asked:
    """Parse the body of a request.

    Raises
    ------
    ProblemError
        If it is no JSON object.
    """
    try:
        content = from_json(body, allow_inf_nan=False)
    except ValueError as error:
        raise ProblemError(400, f"The body of the request is not JSON: {error}.") from None
    if not isinstance(content, dict):
        raise ProblemError(400, "The body of the request is not a JSON object.")
    return kind(**content)


def read_record(kind: type[Asked], values: Mapping[str, Any], section: str) -> Asked:
    """Read a record of quantities, each a number in SI units or a text with its unit; null is not given."""
    values = {name: value for name, value in values.items() if value is not None}
    if section == kind.section and all(type(value) in (float, int) for value in values.values()):
        return kind(**values)
    return kind.from_text(_texts(kind, values), section)


def _texts(kind: type[InputModel], values: Mapping[str, Any]) -> dict[str, object]:
    """Give numbers their SI units, as a file must have them."""
    texts: dict[str, object] = {}
    for name, value in values.items():
        info = kind.model_fields.get(name)
        unit, part = (None, None) if info is None else (field_extra(info, "unit"), part_kind(info))
        if unit and is_number(value):
            value = f"{value!r} {unit}"
        elif part is not None and isinstance(value, Mapping):
            value = _texts(part, {n: v for n, v in value.items() if v is not None})
        elif part is not None and isinstance(value, list):
            value = [
                _texts(part, element) if isinstance(element, Mapping) else element
                for element in value
            ]
        texts[name] = value
    return texts
