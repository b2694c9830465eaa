"""Immediate answers about a throw: whether it can be built, its outline, the formulas."""

from anyio import to_thread
from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from crankbase.model import InputModel, field_extra
from crankfem.analyses.file_check import shape_record
from crankfem.analyses.throw.formula_records import formula_records
from crankfem.service.answers import Formulas, Law, ValidThrow
from crankfem.service.asking import (
    FormulasQuestion,
    LawQuestion,
    OutlineQuestion,
    ThrowQuestion,
    read_question,
)
from crankfem.service.law_answer import law_answer
from crankfem.service.responses import answer, described
from fem.supports import Neighbors
from geometry.plots.throw_outline import outline_svg

SVG = "image/svg+xml"
routes = APIRouter(prefix="/api/throws", tags=["throws"])


@routes.post("/law", **described(Law, LawQuestion))
async def evaluate_law(request: Request) -> Response:
    """Return compliances, c and reactions of a throw by the law, with bands, without finite elements."""
    asked = await read_question(request, LawQuestion)
    throw, material, support = asked.read_throw(), asked.read_material(), asked.read_support()

    def found() -> Response:
        return answer(law_answer(throw, material, asked.gamma_deg, asked.pin_force, support))

    # A chain of throws takes long enough to hold others up.
    return await to_thread.run_sync(found) if isinstance(support, Neighbors) else found()


@routes.post("/validate", **described(ValidThrow, ThrowQuestion))
async def validate_throw(request: Request) -> Response:
    """Check a throw: return the results of its dimensions, and the same as a TOML file."""
    asked = await read_question(request, ThrowQuestion)
    throw, material = asked.read_throw(), asked.read_material()
    return answer(
        {
            "shape": shape_record(throw),
            "dimensions": throw.model_dump(mode="json", exclude_defaults=True),
            "material": material.model_dump(),
            "toml": "\n".join([*_toml("throw", throw), *_toml("material", material)]) + "\n",
        }
    )


@routes.post("/outline", **described(SVG, OutlineQuestion))
async def outline_throw(request: Request) -> Response:
    """Draw the side or front view of a throw to scale."""
    asked = await read_question(request, OutlineQuestion)
    return Response(outline_svg(asked.read_throw().parts, asked.view), media_type=SVG)


@routes.post("/formulas", **described(Formulas, FormulasQuestion))
async def evaluate_formulas(request: Request) -> Response:
    """Evaluate all published formulas for a throw."""
    asked = await read_question(request, FormulasQuestion)
    return answer(formula_records(asked.read_throw(), asked.read_material(), asked.gamma_deg))


def _toml(section: str, record: InputModel, many: bool = False) -> list[str]:
    """Write a record as a section of a file, its parts as sections of their own."""
    lines, parts = [f"[[{section}]]" if many else f"[{section}]"], []
    for name in record.model_fields_set & set(type(record).model_fields):
        value, info = getattr(record, name), type(record).model_fields[name]
        unit = field_extra(info, "unit")
        if isinstance(value, InputModel):
            parts += ["", *_toml(f"{section}.{name}", value)]
        elif isinstance(value, tuple):
            for one in value:
                parts += ["", *_toml(f"{section}.{name}", one, many=True)]
        elif unit == "":
            lines.append(f"{name} = {value!r}")
        elif isinstance(value, float):
            lines.append(f'{name} = "{value!r} {unit}"')
        elif value is not None:
            lines.append(f'{name} = "{value}"')
    return [*lines, *parts, ""] if not many and "." not in section else [*lines, *parts]
