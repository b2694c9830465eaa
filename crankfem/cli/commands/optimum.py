"""The best throw of a model's family under limits."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import ModelArgument, Output, with_output
from crankfem.cli.console import print_json, print_line, print_table

if TYPE_CHECKING:
    from crankbase.tables.table import OutputUnits
    from crankfem.analyses.study.frequency_limits import Kind
    from regression.models.compliance_model import ComplianceModel
    from regression.optimum import Limit, Optimum


@with_output(units=True)
def optimum(
    model: ModelArgument,
    minimize: Annotated[
        str, typer.Option(metavar="NAME", help="Dimension or response to make smallest.")
    ],
    limits: Annotated[
        list[str] | None,
        typer.Option(
            "--limit",
            metavar='"NAME <= VALUE"',
            help="Bound on a response or dimension; may be repeated.",
        ),
    ] = None,
    engine: Annotated[
        str | None,
        typer.Option(
            metavar="ENGINE.toml",
            help="Engine whose frequencies are limited; takes some seconds.",
            autocompletion=completion.engines,
        ),
    ] = None,
    first_axial_frequency: Annotated[
        str | None,
        typer.Option(
            metavar='">= 40 Hz"',
            help="Lower bound on the crankshaft's first axial frequency, with --engine.",
        ),
    ] = None,
    first_torsional_frequency: Annotated[
        str | None,
        typer.Option(
            metavar='">= 40 Hz"',
            help="Lower bound on the crankshaft's first torsional frequency, with --engine.",
        ),
    ] = None,
    fixed: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Factor to keep fixed; may be repeated."),
    ] = None,
    no_margin: Annotated[
        bool,
        typer.Option(
            "--no-margin", help="Apply limits to the equations' values, without their bands."
        ),
    ] = False,
    *,
    out: Output,
) -> None:
    """Find the smallest value of a dimension or response, such as web thickness, under limits."""
    from crankfem.cli.model_arguments import model_dimensions, parse_limit
    from regression.models.compliance_model import ComplianceModel
    from regression.optimum import check_minimized, find_optimum

    loaded = ComplianceModel.load(model)
    check_minimized(loaded, minimize, "--minimize")
    held = model_dimensions(loaded, fixed or [])
    wanted = [parse_limit(loaded, text) for text in limits or []]
    bounds: dict[Kind, str | None] = {
        "axial": first_axial_frequency,
        "torsional": first_torsional_frequency,
    }
    wanted += _frequency_limits(loaded, engine, bounds)
    found = find_optimum(loaded, minimize, wanted, fixed=held, margins=not no_margin)
    if engine is not None:
        kept = (
            f"of the throw of {engine}, the ratio of its compliance in the shaft to the pinned one and "
            "its moment of inertia are kept as the throw changes"
        )
        found = replace(found, remarks=(*found.remarks, kept))
    if out.json:
        print_json(_record(found))
        return
    _print_optimum(loaded, found, out.units)


def _frequency_limits(
    model: "ComplianceModel", engine: str | None, bounds: "dict[Kind, str | None]"
) -> "list[Limit]":
    """Limits on the engine's frequencies; its throw is analyzed only if there are any."""
    from crankfem.cli.model_arguments import parse_bound

    given = {
        kind: parse_bound(f"--first-{kind}-frequency", text)
        for kind, text in bounds.items()
        if text is not None
    }
    if not given and engine is None:
        return []
    if engine is None:
        raise InputError(
            f"--first-{next(iter(given))}-frequency: given without --engine; allowed is both, because "
            "the frequency is that of a whole engine."
        )
    if not given:
        raise InputError(
            f"--engine: given {engine!r} without a frequency; allowed is both, like "
            '--first-axial-frequency ">= 40 Hz".'
        )
    for kind in given:
        if f"{kind}_compliance" not in model.responses:
            raise InputError(
                f"--first-{kind}-frequency: given for a model without {kind}_compliance; allowed is a model "
                "with it, because the frequency follows from it."
            )
    from crankfem.analyses.study.frequency_limits import engine_frequencies, frequency_limit
    from crankfem.files.engine.engine_file import load_engine

    frequencies = engine_frequencies(load_engine(engine))
    return [frequency_limit(kind, frequencies, model, bound) for kind, bound in given.items()]


def _record(found: "Optimum") -> dict[str, Any]:
    from crankfem.analyses.record import attributes

    return {
        **attributes(found, "minimized", "value", "unit", "factors", "dimensions"),
        "at_ends": list(found.at_ends),
        "limits": [
            attributes(check.limit, "name", "sign", "bound", "unit")
            | attributes(check, "value", "worst", "active")
            for check in found.limits
        ],
        "responses": {
            name: attributes(answer, "value", "lower", "upper", "unit", "inside")
            for name, answer in found.lookups.items()
        },
        "throw": None if found.throw is None else found.throw.model_dump(mode="json"),
        "remarks": list(found.remarks),
        "evaluations": found.evaluations,
    }


def _print_optimum(model: "ComplianceModel", found: "Optimum", units: "OutputUnits") -> None:
    from crankbase.tables.table import Column, Table
    from crankfem.cli.model_arguments import dimensions_text

    print_line(f"Smallest {found.minimized}: {units.quantity(found.value, found.unit, 4)}")
    for text in dimensions_text(model, found.factors):
        end = " (end of its range)" if text.partition(" ")[0] in found.at_ends else ""
        print_line(units.text(f"  {text}{end}"))
    if found.limits:
        names = ("limit", "bound", "by the equation", "worst in its band", "kept")
        print_table(
            Table(
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
                    for check in found.limits
                ],
            )
        )
    for remark in found.remarks:
        print_line(units.text(f"{remark[0].upper()}{remark[1:].rstrip('.')}."))
