"""Lookups without a job: models of studies and of a folder, the law, formulas, checks."""

import re
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from anyio import to_thread
from fastapi import APIRouter
from fastapi.routing import APIRoute
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

from crankbase.choices import is_number
from crankbase.errors import InputError, quoted
from crankbase.model import field_extra
from crankbase.written_quantity import parse_quantity
from crankfem.analyses.file_check import throw_shape
from crankfem.analyses.record import Record, attributes
from crankfem.analyses.throw.formula_records import formulas_of
from crankfem.analyses.throw.law_record import LAW_BANDS, end_answers, neighbor_answers
from crankfem.files.reading.toml_text import record_values, toml_text
from crankfem.satellites.service.answers import (
    Formulas,
    Law,
    Lookups,
    ModelDescription,
    ModelNames,
    ValidThrow,
)
from crankfem.satellites.service.asking import (
    FormulasQuestion,
    LawQuestion,
    LookupQuestion,
    OutlineQuestion,
    ProblemError,
    ThrowQuestion,
    answer_error,
    answer_fault,
    read_question,
    read_record,
)
from crankfem.satellites.service.guard import Bounds
from crankfem.satellites.service.job_store import JobStore
from crankfem.satellites.service.responses import answer, described
from crankfem.satellites.service.tasks import MODEL
from fem.material import Material
from fem.supports import Neighbors
from geometry.plots.throw_plot import outline_svg
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Counterweight
from regression.law.superelement import law_reactions
from regression.law.throw_law import axial_law_slopes, dimension_ranges, throw_laws
from regression.models.compliance_model import ComplianceModel
from regression.models.lookup import ReactionLookup


def reactions_record(lookup: ReactionLookup) -> Record:
    """Return reactions by a law or a model: of each end force and moment, and how far they may be off."""
    ends = {"left": (lookup.left, lookup.band.left), "right": (lookup.right, lookup.band.right)}
    return {"support": lookup.support} | {
        side: end.to_record() | {f"{name}_band": error for name, error in band.to_record().items()}
        for side, (end, band) in ends.items()
    }


class QuickRoutes:
    """Calls the functions of some routes itself; an application answers everything else.

    Parameters
    ----------
    routes : sequence of APIRoute
        For POST, their functions of a request and of the parts of its path. The application has them
        too, and describes them.
    """

    def __init__(self, app: ASGIApp, routes: Sequence[APIRoute]) -> None:
        self._app = app
        self._routes = [(route, route.path_regex.fullmatch, route.endpoint) for route in routes]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope.get("method") == "POST":
            for route, matched, function in self._routes:
                match = matched(scope["path"])
                if match is not None:
                    scope["route"] = route
                    request = Request(scope, receive)
                    try:
                        response = await function(request, **match.groupdict())
                    except (InputError, ProblemError) as error:
                        response = await answer_error(request, error)
                    except ClientDisconnect:
                        raise
                    except Exception as error:
                        response = await answer_fault(request, error)
                        await response(scope, receive, send)
                        raise  # for the log
                    await response(scope, receive, send)
                    return
        await self._app(scope, receive, send)


NAME = re.compile(r"[\w.+-]{1,80}", re.ASCII)
SHOWN = ("value", "lower", "upper", "inside", "unit", "symbol", "support", "remarks", "band")
# From so many throws on a lookup is calculated beside the other requests.
MANY = 500
OF_JOB = "job-"
MOST_JOBS = 200
MOST_LOADED = 16
FRESH = 1.0  # seconds for which a model's file is not looked at again


class Models:
    """The available models: those of a folder by name, those of studies by ``job-NAME``."""

    def __init__(self, folder: Path | None, store: JobStore) -> None:
        self._folder, self._store = folder, store
        # By name: when it was looked for, the model, its file and when that was changed.
        self._known: dict[str, tuple[float, ComplianceModel | None, Path | None, int]] = {}

    def names(self) -> list[str]:
        """Return the names of all."""
        files = [] if self._folder is None else sorted(p.stem for p in self._folder.glob("*.json"))
        jobs = self._store.jobs(MOST_JOBS)
        return [name for name in files if NAME.fullmatch(name)] + [
            f"{OF_JOB}{job.id}" for job in jobs if _model_of(job.files) is not None
        ]

    def named(self, name: str) -> ComplianceModel:
        """Return a model.

        Raises
        ------
        ProblemError
            If there is none of that name.
        """
        seen, model, path, changed = self._known.get(name, (0.0, None, None, 0))
        now = time.monotonic()
        if model is not None and now - seen < FRESH:
            return model
        path = self._path(name) if NAME.fullmatch(name) else None
        if path is None or not path.is_file():
            self._known.pop(name, None)
            raise ProblemError(404, "There is no model of that name.")
        if model is None or path.stat().st_mtime_ns != changed:
            changed = path.stat().st_mtime_ns
            try:
                model = ComplianceModel.load(path)
            except InputError as error:
                raise InputError(str(error).replace(str(path), path.name)) from None
            if len(self._known) >= MOST_LOADED:
                self._known.pop(next(iter(self._known)))
        self._known[name] = (now, model, path, changed)
        return model

    def _path(self, name: str) -> Path | None:
        if self._folder is not None and (self._folder / f"{name}.json").is_file():
            return self._folder / f"{name}.json"
        job = self._store.job(name.removeprefix(OF_JOB)) if name.startswith(OF_JOB) else None
        model = None if job is None else _model_of(job.files)
        return None if job is None or model is None else self._store.place(job.id) / model


def _model_of(files: Iterable[str]) -> str | None:
    """Return the model among a job's files, that of a study or of an engine's."""
    return next((name for name in files if name in (MODEL, f"results/{MODEL}")), None)


def model_routes(models: Models, bounds: Bounds) -> APIRouter:
    """Make the routes of models."""
    routes = APIRouter(prefix="/api/models", tags=["models"])

    @routes.post("/{name}/lookup", **described(Lookups, LookupQuestion, 404))
    async def look_up(request: Request, name: str) -> Response:
        """Look responses up for one throw, or for many whose dimensions are lists."""
        asked, model = await read_question(request, LookupQuestion), models.named(name)
        counts = {len(value) for value in asked.dimensions.values() if isinstance(value, list)}
        rows = max(counts, default=None)
        responses = len(model.responses) if asked.responses is None else len(asked.responses)
        if rows is not None and rows * responses > bounds.rows:
            raise InputError(
                f"dimensions: given {rows} throws for {responses} responses; allowed are "
                f"{bounds.rows // responses} throws at most in one request."
            )
        if rows is None or rows < MANY:
            return answer(_lookups(model, asked, rows))
        return await to_thread.run_sync(lambda: answer(_lookups(model, asked, rows)))

    @routes.get("", **described(ModelNames))
    async def list_models() -> Response:
        """List the available models."""
        names = await to_thread.run_sync(models.names)
        return answer({"models": names})

    @routes.get("/{name}", **described(ModelDescription, None, 404, 422))
    async def describe_model(name: str) -> Response:
        """Return what a model answers, and for which throws."""
        model = models.named(name)
        family = model.family
        known = ("symbol", "unit", "support", "equation", "band_error", "largest_fe_error")
        return answer(
            {
                "name": name,
                "responses": {
                    key: attributes(response, *known) for key, response in model.responses.items()
                },
                **attributes(family, "ranges", "categories", "fixed", "labels"),
                "units": family.all_units,
                "material": dict(model.material),
            }
        )

    return routes


def _lookups(model: ComplianceModel, asked: LookupQuestion, rows: int | None) -> dict[str, Any]:
    dimensions: dict[str, Any] = {}
    if asked.material is not None:
        model = model.of_material(read_record(Material, asked.material, "material"))
    if asked.throw is not None:
        dimensions |= model.dimensions_of(read_record(CrankThrow, asked.throw, "throw"))
    dimensions |= _dimensions(model, asked.dimensions)
    looked_up, refused = model.look_all_up(
        asked.responses,
        many=rows is not None,
        gamma_deg=asked.gamma_deg,
        strict=asked.strict,
        **dimensions,
    )
    if refused and (asked.strict or asked.responses is not None):
        raise next(iter(refused.values()))
    if not looked_up:
        raise InputError("responses: given none; allowed are those of the model.")
    reactions = None
    if asked.pin_force is not None:
        support = asked.read_support()
        reactions = reactions_record(
            model.reactions(asked.pin_force, support, strict=asked.strict, **dimensions)
        )
    return {
        "rows": rows,
        "responses": {name: attributes(lookup, *SHOWN) for name, lookup in looked_up.items()},
        "refused": {name: str(reason) for name, reason in refused.items()},
        "reactions": reactions,
    }


def _dimensions(model: ComplianceModel, query: Mapping[str, Any]) -> dict[str, Any]:
    """Take numbers as they are, and texts as quantities with units unless they are labels."""
    family = model.family
    labels = {*family.categories, *family.labels}
    for name in query:
        if name not in labels | family.all_units.keys():
            family.checked({name: query[name]})  # states that it is unknown

    def read(name: str, value: Any) -> Any:
        if isinstance(value, str):
            return value if name in labels else parse_quantity(value, family.unit(name), name)
        if not is_number(value):
            raise InputError(
                f"{name}: given {quoted(value)}; allowed is a number in SI units, a text with its unit, or a "
                "list of them."
            )
        return value

    def read_several(name: str, values: list[Any]) -> Any:
        if not values:
            raise InputError(f"{name}: given an empty list; allowed is one value or more.")
        if not all(type(number) is float for number in values):
            values = [read(name, number) for number in values]
        return values if name in labels else np.asarray(values, dtype=float)

    lengths = {name: len(value) for name, value in query.items() if isinstance(value, list)}
    for name, length in lengths.items():
        if length != max(lengths.values()):
            raise InputError(
                f"{name}: given {length} values beside {max(lengths.values())}; allowed are as many of each, "
                "one for each throw."
            )
    return {
        name: read_several(name, value) if isinstance(value, list) else read(name, value)
        for name, value in query.items()
    }


SVG = "image/svg+xml"
# Symbols of dimensions, also of the counterweight.
LETTERS = {
    f"{before}{name}": letter
    for before, record in (("", CrankThrow), ("counterweight.", Counterweight))
    for name, info in record.model_fields.items()
    if (letter := field_extra(info, "symbol"))
}
routes = APIRouter(prefix="/api/throws", tags=["throws"])


@routes.post("/law", **described(Law, LawQuestion))
async def evaluate_law(request: Request) -> Response:
    """Return compliances, c and reactions of a throw by the law, with bands, without finite elements."""
    asked = await read_question(request, LawQuestion)
    throw, material, support = asked.read_throw(), asked.read_material(), asked.read_support()
    rigidity = {"poisson_ratio": material.poisson_ratio}

    def evaluated() -> Response:
        axial, torsional = throw_laws(throw, youngs_modulus=material.youngs_modulus, **rigidity)
        values = {
            f"{name.removesuffix('_guided')}_{lookup.support}": lookup
            for name, lookup in end_answers(axial, torsional).items()
            if lookup.support
        }
        if asked.gamma_deg is not None:
            between = neighbor_answers(axial, asked.gamma_deg)
            values |= {f"{name}_neighbors": lookup for name, lookup in between.items()}
        remarks = [f"{LAW_BANDS} The ratio closest to a limit of the law: {axial.nearest_limit}."]
        reactions = None
        if asked.pin_force is not None and not throw.parts.mirrored:
            remarks.append("No reactions: the law has those of throws with equal webs only.")
        elif asked.pin_force is not None:
            reactions = reactions_record(law_reactions(throw, asked.pin_force, support, **rigidity))
        shared = attributes(axial, "ratio", "tier", "nearest_limit")
        ranges = dimension_ranges(throw) if asked.ranges else None
        slopes = axial_law_slopes(throw, **rigidity) if asked.slopes else None
        found = {"values": values, "reactions": reactions, "ranges": ranges, "slopes": slopes}
        told = {"remarks": remarks, "not_used": _without_density(asked)}
        return answer(shared | found | told)

    # A chain of throws takes long enough to hold others up.
    return await to_thread.run_sync(evaluated) if isinstance(support, Neighbors) else evaluated()


@routes.post("/validate", **described(ValidThrow, ThrowQuestion))
async def validate_throw(request: Request) -> Response:
    """Check a throw: return the results of its dimensions, and the same as a TOML file."""
    asked = await read_question(request, ThrowQuestion)
    throw, material = asked.read_throw(), asked.read_material()
    return answer(
        {
            "shape": throw_shape(throw).to_record(),
            "dimensions": throw.model_dump(mode="json", exclude_defaults=True),
            "material": material.model_dump(),
            "toml": toml_text({"throw": record_values(throw), "material": record_values(material)}),
        }
    )


@routes.post("/outline", **described(SVG, OutlineQuestion))
async def outline_throw(request: Request) -> Response:
    """Draw the side or front view of a throw to scale."""
    asked = await read_question(request, OutlineQuestion)
    letters, parts = LETTERS if asked.letters else None, asked.read_throw().parts
    drawn = await to_thread.run_sync(outline_svg, parts, asked.view, letters)
    return Response(drawn, media_type=SVG)


@routes.post("/formulas", **described(Formulas, FormulasQuestion))
async def evaluate_formulas(request: Request) -> Response:
    """Evaluate all published formulas for a throw."""
    asked = await read_question(request, FormulasQuestion)
    formulas = formulas_of(asked.read_throw(), asked.read_material(), asked.gamma_deg)
    return answer(formulas.to_record() | {"not_used": _without_density(asked)})


def _without_density(asked: ThrowQuestion) -> list[str]:
    """Name what compliances do not depend on, where it is given."""
    return ["material.density"] if asked.material is not None else []
