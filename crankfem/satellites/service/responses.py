"""Responses of the service, and their description for the API."""

from typing import Any

from pydantic import BaseModel
from pydantic_core import to_json
from starlette.responses import Response

from crankbase.model import InputModel, field_extra, part_kind
from crankfem.satellites.service.answers import Problem
from crankfem.satellites.service.asking import MEDIA_TYPE
from fem.material import Material
from geometry.throw import CrankThrow

JSON = "application/json"
REF = "#/components/schemas/"
RECORDS: tuple[type[InputModel], ...] = (CrankThrow, Material)
REFUSALS = {
    400: "no JSON",
    401: "the key is missing or wrong",
    403: "a foreign origin",
    404: "nothing of that name",
    405: "another method",
    408: "the request took too long to arrive",
    409: "not now",
    413: "too large",
    415: "another media type",
    422: "input that cannot be used, with a sentence for each wrong field",
    429: "the queue is full; Retry-After gives the time to wait",
    500: "a fault of the service",
    503: "busy, or jobs cannot be recorded or run; try again later",
    507: "the disk is full",
}


def answer(content: Any, status: int = 200, headers: dict[str, str] | None = None) -> Response:
    """Return content as JSON; numbers that are not finite are null."""
    text = to_json(content, inf_nan_mode="null")
    return Response(text, status, headers, media_type=JSON)


def described(
    kind: type[BaseModel] | str,
    asked: type[InputModel] | None = None,
    *refused: int,
    status: int = 200,
    says: str = "",
) -> dict[str, Any]:
    """Describe a route: its answer (a model, or a media type), its request, its errors."""
    codes = {401, 403, 503, *refused}
    if asked is not None:
        codes |= {400, 408, 413, 415, 422}
    options: dict[str, Any] = {"response_model": None, "status_code": status}
    if isinstance(kind, str):
        good: dict[str, Any] = {"content": {kind: {"schema": {"type": "string"}}}}
    else:
        good = {"model": kind}
    options["responses"] = {status: good | {"description": says or "answered"}} | {
        code: {
            "description": REFUSALS[code],
            "content": {MEDIA_TYPE: {"schema": {"$ref": f"{REF}{Problem.__name__}"}}},
        }
        for code in sorted(codes)
    }
    if asked is not None:
        schema: dict[str, Any] = asked.model_json_schema(ref_template=f"{REF}{{model}}")
        fields = schema["properties"]
        for name, record in (("throw", CrankThrow), ("material", Material)):
            if name in fields:
                named = {"$ref": f"{REF}{record.__name__}"}
                needed = asked.model_fields[name].is_required()
                fields[name] = named if needed else {"anyOf": [named, {"type": "null"}]}
        options["openapi_extra"] = {
            "requestBody": {"required": True, "content": {JSON: {"schema": schema}}}
        }
    return options


def record_schemas() -> dict[str, Any]:
    """Return the schemas of records of quantities, and of problems."""
    schemas = {kind.__name__: _record_schema(kind) for kind in RECORDS}
    whole: dict[str, Any] = Problem.model_json_schema(ref_template=f"{REF}{{model}}")
    schemas |= whole.pop("$defs")
    return schemas | {Problem.__name__: whole}


def _record_schema(kind: type[InputModel]) -> dict[str, Any]:
    properties = kind.model_json_schema()["properties"]
    fields: dict[str, Any] = {}
    for name, info in kind.model_fields.items():
        unit, part = field_extra(info, "unit"), part_kind(info)
        if part is not None:
            inner = _record_schema(part)
            if field_extra(info, "many"):
                inner = {"type": "array", "items": inner}
        elif unit is not None:
            low, high = field_extra(info, "minimum_si"), field_extra(info, "maximum_si")
            number = {"type": "number"} | ({} if low is None else {"minimum": low})
            number |= {} if high is None else {"maximum": high}
            inner = {"anyOf": [number, {"type": "string"}]}
        else:
            inner = properties[name]
        meaning = f"{info.description or name}{f' [{unit}]' if unit else ''}"
        optional = {} if info.is_required() else {"anyOf": [inner, {"type": "null"}]}
        fields[name] = (optional or inner) | {"description": meaning}
        if symbol := field_extra(info, "symbol"):
            fields[name]["title"] = symbol
    return {
        "type": "object",
        "properties": fields,
        "required": [name for name, info in kind.model_fields.items() if info.is_required()],
        "additionalProperties": False,
    }
