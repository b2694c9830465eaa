"""What a search is asked on the command line, and how its optimum is shown."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from crankbase.choices import did_you_mean
from crankbase.errors import InputError
from crankbase.results import units as units_of
from crankbase.sentences import capital
from crankbase.table import Column, Main, OutputUnits, Table
from crankbase.written_quantity import parse_quantity
from crankfem.analyses.record import attributes
from crankfem.cli.arguments import (
    dimensions_text,
    model_dimensions,
    parse_quantities,
    parse_value,
)
from crankfem.cli.console import parse_pairs
from crankfem.files.engine.engine_file import load_engine
from crankfem.satellites.optimum.frequencies import Kind, engine_frequencies, frequency_limit
from crankfem.satellites.optimum.throw_search import SearchInterrupted, ThrowFamily, best_throw
from geometry.throw import CrankThrow
from regression.models.compliance_model import ComplianceModel
from regression.models.family import Family
from regression.optimum import Limit, Optimum, Searched, check_known, find_optimum
from regression.throw_values import field_unit


@dataclass(frozen=True)
class Question:
    """What is made smallest, under which limits: texts of the command line.

    Attributes
    ----------
    bounds : mapping
        Of first frequencies by the kind of vibration, None where there is none.
    margins : bool
        Whether limits are kept by the worst end of the bands.
    """

    minimize: str
    limits: Sequence[str]
    bounds: Mapping[Kind, str | None]
    margins: bool


@dataclass(frozen=True)
class Answer:
    """The best throw of a family; `stopped` if an interrupt ended the search."""

    best: Optimum
    family: Family
    stopped: bool = False


def in_model(question: Question, path: Path, engine: str | None, fixed: Sequence[str]) -> Answer:
    """Search in a model of a study; its limits on frequencies are those of an engine."""
    model = ComplianceModel.load(path)
    check_known(model, question.minimize, "--minimize")
    held = model_dimensions(model, fixed)
    limits = [parse_limit(model, text) for text in question.limits]
    remarks: tuple[str, ...] = ()
    bounds = _frequency_bounds(question)
    if bounds or engine is not None:
        if engine is None:
            raise InputError(
                f"--first-{next(iter(bounds))}-frequency: given without --engine; allowed is both, because "
                "the frequency is that of a whole engine."
            )
        if not bounds:
            raise InputError(
                f"--engine: given {engine!r} without a frequency; allowed is both, like "
                '--first-axial-frequency ">= 40 Hz".'
            )
        for kind in bounds:
            if f"{kind}_compliance" not in model.responses:
                raise InputError(
                    f"--first-{kind}-frequency: given for a model without {kind}_compliance; allowed is a "
                    "model with it, because the frequency follows from it."
                )
        read = load_engine(engine)
        model = model.of_material(read.material)
        of_engine = engine_frequencies(read)
        limits += [frequency_limit(kind, of_engine, model, bound) for kind, bound in bounds.items()]
        remarks = (
            f"of the throw of {engine}, the ratio of its compliance in the shaft to the pinned one and "
            "its moment of inertia are kept as the throw changes",
        )
    best = find_optimum(model, question.minimize, limits, fixed=held, margins=question.margins)
    return Answer(replace(best, remarks=(*best.remarks, *remarks)), model.family)


def among_throws(
    question: Question, engine: str, vary: Sequence[str], step: Callable[[str], object]
) -> Answer:
    """Search among the throws of an engine by finite elements; an interrupt ends with the best so far."""
    read = load_engine(engine)
    ranges = parse_pairs(vary, parse_range, "web_width=300mm..380mm")
    family = ThrowFamily(read, ranges)
    check_known(family, question.minimize, "--minimize")
    limits = [parse_limit(family, text) for text in question.limits]
    limits += [
        Limit((f"first_{kind}_frequency",), at_least=bound, unit="Hz")
        for kind, bound in _frequency_bounds(question).items()
    ]
    try:
        best = best_throw(
            read, ranges, question.minimize, limits, margins=question.margins, step=step
        )
    except SearchInterrupted as interrupt:
        if interrupt.best is None:
            raise
        return Answer(interrupt.best, family.family, stopped=True)
    return Answer(best, family.family)


def _frequency_bounds(question: Question) -> dict[Kind, float]:
    return {
        kind: parse_bound(f"--first-{kind}-frequency", text)
        for kind, text in question.bounds.items()
        if text is not None
    }


def optimum_record(best: Optimum) -> dict[str, Any]:
    """Return the record of an optimum, with its units."""
    whole = ("minimized", "value", "unit", "factors", "dimensions", "at_ends", "throw", "remarks")
    of_unit = dict.fromkeys(("value", "lower", "upper", "bound", "worst"), ".unit")
    return {
        **attributes(best, *whole, "evaluations"),
        "limits": [
            attributes(check.limit, "name", "sign", "bound", "unit")
            | attributes(check, "value", "worst", "active")
            for check in best.limits
        ],
        "responses": {
            name: attributes(answer, "value", "lower", "upper", "unit", "inside")
            for name, answer in best.lookups.items()
        },
        "units": of_unit
        | {"evaluations": "1"}
        | {
            f"{group}.{name}": field_unit(name) or "1"
            for group in ("factors", "dimensions")
            for name in getattr(best, group)
        }
        | units_of({"throw": best.throw}),
    }


def optimum_parts(answer: Answer, units: OutputUnits) -> Iterator[Table | str]:
    """Yield the remarks, the limits and the dimensions of an optimum."""
    best = answer.best
    for remark in best.remarks:
        yield Main(units.written(f"{capital(remark).rstrip('.')}."))
    if best.limits:
        names = ("limit", "bound", "value", "worst in its band", "kept")
        yield Table(
            "Limits",
            [Column(name, words=name == "kept") for name in names],
            [
                [
                    check.limit.name.replace("_", " "),
                    f"{check.limit.sign} {units.quantity(check.limit.bound, check.limit.unit, 4)}",
                    units.quantity(check.value, check.limit.unit, 4),
                    units.quantity(check.worst, check.limit.unit, 4),
                    "just" if check.active else "with room",
                ]
                for check in best.limits
            ],
            main=True,
        )
    for name, text in zip(best.factors, dimensions_text(answer.family, best.factors), strict=True):
        end = " (end of its range)" if name in best.at_ends else ""
        yield Main(units.written(f"  {text}{end}"))


_LIMIT = re.compile(r"\s*(?P<name>[\w.]+)\s*(?P<sign><=|>=)\s*(?P<value>.+?)\s*")
_BOUND = re.compile(r"\s*(?P<sign><=|>=)\s*(?P<value>.+?)\s*")


def parse_range(name: str, text: str) -> tuple[float, float]:
    """Read the range of a dimension of a throw, like "300mm..380mm" [SI].

    Examples
    --------
    >>> parse_range("web_width", "300..380 mm")
    (0.3, 0.38)
    """
    unit = field_unit(name)
    low, dots, high = text.partition("..")
    if not unit:
        meant = did_you_mean(name, CrankThrow.model_fields)
        raise InputError(
            f"--vary: given {name!r}; {meant}allowed are dimensions of a throw, like "
            "web_width=300mm..380mm."
        )
    if not dots:
        raise InputError(
            f"--vary: given {name}={text}; allowed is a range with two points, like 300mm..380mm."
        )
    first, last = parse_quantities(f"{low},{high}", unit, f"--vary {name}")
    return first, last


def parse_limit(model: Searched, text: str) -> Limit:
    """Read a limit on a response or dimension, like "axial_compliance <= 1.2e-9 m/N"."""
    match = _LIMIT.fullmatch(text)
    if match is None:
        raise InputError(
            f"--limit: given {text!r}; allowed is NAME <= VALUE or NAME >= VALUE, like "
            '"axial_compliance <= 1.2e-9 m/N".'
        )
    name = match["name"]
    response = model.responses.get(name)
    units = model.family.all_units
    check_known(model, name, "--limit")
    unit = units[name] if response is None else response.unit
    bound = parse_value(name, match["value"], unit)
    if match["sign"] == "<=":
        return Limit((name,), at_most=bound, unit=unit)
    return Limit((name,), at_least=bound, unit=unit)


def parse_bound(option: str, text: str) -> float:
    """Read a lower bound of a frequency, like ">= 40 Hz" or "40 Hz" [Hz]."""
    match = _BOUND.fullmatch(text)
    if match is not None and match["sign"] == "<=":
        raise InputError(
            f'{option}: given {text!r}; allowed is at least a frequency, like ">= 40 Hz", because a '
            "shaft is made stiffer to bring its frequency above the speeds."
        )
    value = parse_quantity(text if match is None else match["value"], "Hz", option)
    if not value > 0.0:
        raise InputError(f"{option}: given {text!r}; allowed is a frequency above 0 Hz.")
    return value
