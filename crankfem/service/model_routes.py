"""Models of finished studies and of a folder: listed, described, looked up."""

import re
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import anyio.to_thread
import numpy as np
from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from crankbase.checks.choices import is_number
from crankbase.errors import InputError, quoted
from crankbase.units.quantity import parse_quantity
from crankfem.service.answers import Lookups, ModelDescription, ModelNames
from crankfem.service.asking import LookupQuestion, read_question, read_record
from crankfem.service.bounds import Bounds
from crankfem.service.job_store import JobStore
from crankfem.service.law_answer import reactions_record
from crankfem.service.problems import ProblemError
from crankfem.service.responses import answer, described
from crankfem.service.tasks import MODEL
from geometry.throw import CrankThrow
from regression.models.compliance_model import ComplianceModel
from regression.response_kinds import ANGLE_LAWS

NAME = re.compile(r"[\w.+-]{1,80}", re.ASCII)
TOLD = ("value", "lower", "upper", "inside", "unit", "symbol", "support", "remarks", "band")
# From so many throws on a lookup is calculated beside the other requests.
MANY = 500
OF_JOB = "job-"
MOST_JOBS = 200
MOST_LOADED = 16
FRESH = 1.0  # seconds for which a model's file is not looked at again


class Models:
    """The available models: those of a folder by name, those of studies by ``job-NAME``.

    Parameters
    ----------
    folder : Path or None
    store : JobStore
    """

    def __init__(self, folder: Path | None, store: JobStore) -> None:
        self._folder, self._store = folder, store
        # By name: when it was looked for, the model, its file and when that was changed.
        self._known: dict[str, tuple[float, ComplianceModel | None, Path | None, int]] = {}

    def names(self) -> list[str]:
        """Return the names of all."""
        found = [] if self._folder is None else sorted(p.stem for p in self._folder.glob("*.json"))
        jobs = self._store.jobs(MOST_JOBS)
        return [name for name in found if NAME.fullmatch(name)] + [
            f"{OF_JOB}{job.id}" for job in jobs if _model_of(job.files) is not None
        ]

    def named(self, name: str) -> ComplianceModel:
        """Return a model.

        Raises
        ------
        ProblemError
            If there is none of that name.
        InputError
            If its file cannot be used.
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
            changed, model = path.stat().st_mtime_ns, _loaded(path)
            if len(self._known) >= MOST_LOADED:
                self._known.pop(next(iter(self._known)))
        self._known[name] = (now, model, path, changed)
        return model

    def _path(self, name: str) -> Path | None:
        if self._folder is not None and (self._folder / f"{name}.json").is_file():
            return self._folder / f"{name}.json"
        job = self._store.job(name.removeprefix(OF_JOB)) if name.startswith(OF_JOB) else None
        own = None if job is None else _model_of(job.files)
        return None if job is None or own is None else self._store.place(job.id) / own


def _model_of(files: Iterable[str]) -> str | None:
    """Return the model among a job's files, that of a study or of an engine's."""
    return next((name for name in files if name in (MODEL, f"results/{MODEL}")), None)


def _loaded(path: Path) -> ComplianceModel:
    try:
        return ComplianceModel.load(path)
    except InputError as error:
        raise InputError(str(error).replace(str(path), path.name)) from None


def model_routes(models: Models, bounds: Bounds) -> APIRouter:
    """Make the routes of models."""
    routes = APIRouter(prefix="/api/models", tags=["models"])

    @routes.post("/{name}/lookup", **described(Lookups, LookupQuestion, 404))
    async def look_up(request: Request, name: str) -> Response:
        """Look responses up for one throw, or for many whose dimensions are lists."""
        asked, model = await read_question(request, LookupQuestion), models.named(name)
        counts = {len(value) for value in asked.dimensions.values() if isinstance(value, list)}
        rows = max(counts, default=None)
        if rows is not None and rows > bounds.rows:
            raise InputError(
                f"dimensions: given {rows} throws; allowed is {bounds.rows} at most in one request."
            )
        if rows is None or rows < MANY:
            return answer(_lookups(model, asked, rows))
        return await anyio.to_thread.run_sync(lambda: answer(_lookups(model, asked, rows)))

    @routes.get("", **described(ModelNames))
    async def list_models() -> Response:
        """List the available models."""
        return answer({"models": models.names()})

    @routes.get("/{name}", **described(ModelDescription, None, 404, 422))
    async def describe_model(name: str) -> Response:
        """Return what a model answers, and for which throws."""
        return answer(_description(name, models.named(name)))

    return routes


def _description(name: str, model: ComplianceModel) -> dict[str, Any]:
    family = model.family
    known = ("symbol", "unit", "support", "equation", "band_error", "largest_fe_error")
    return {
        "name": name,
        "responses": {
            key: {part: getattr(one, part) for part in known}
            for key, one in model.responses.items()
        },
        "ranges": dict(family.ranges),
        "categories": {key: list(labels) for key, labels in family.categories.items()},
        "fixed": dict(family.fixed),
        "labels": dict(family.labels),
        "units": family.all_units,
        "material": dict(model.material),
    }


def _lookups(model: ComplianceModel, asked: LookupQuestion, rows: int | None) -> dict[str, Any]:
    dimensions = (
        {}
        if asked.throw is None
        else model.dimensions_of(read_record(CrankThrow, asked.throw, "throw"))
    )
    dimensions |= _dimensions(model, asked.dimensions)
    names = model.responses if asked.responses is None else dict.fromkeys(asked.responses)
    found: dict[str, Any] = {}
    refused: dict[str, str] = {}
    for name in names:
        angle = asked.gamma_deg if name in ANGLE_LAWS else None
        look = model.lookup if rows is None else model.lookups
        try:
            one = look(name, gamma_deg=angle, strict=asked.strict, **dimensions)
        except InputError as error:
            if asked.strict or asked.responses is not None:
                raise
            refused[name] = str(error)
            continue
        found[name] = {part: _plain(getattr(one, part)) for part in TOLD}
    if not found:
        raise InputError(
            next(iter(refused.values()), "responses: given none; allowed are those of the model.")
        )
    reactions = None
    if asked.pin_force is not None:
        made = model.reactions(
            asked.pin_force, asked.read_support(), strict=asked.strict, **dimensions
        )
        reactions = reactions_record(made)
    return {"rows": rows, "responses": found, "refused": refused, "reactions": reactions}


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _dimensions(model: ComplianceModel, given: Mapping[str, Any]) -> dict[str, Any]:
    """Take numbers as they are, and texts as quantities with units unless they are labels."""
    family = model.family
    labels = {*family.categories, *family.labels}
    for name in given:
        if name not in labels | family.all_units.keys():
            family.checked({name: given[name]})  # states that it is unknown

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
        if not all(type(one) is float for one in values):
            values = [read(name, one) for one in values]
        return values if name in labels else np.asarray(values, dtype=float)

    lengths = {name: len(value) for name, value in given.items() if isinstance(value, list)}
    for name, length in lengths.items():
        if length != max(lengths.values()):
            raise InputError(
                f"{name}: given {length} values beside {max(lengths.values())}; allowed are as many of each, "
                "one for each throw."
            )
    return {
        name: read_several(name, value) if isinstance(value, list) else read(name, value)
        for name, value in given.items()
    }
