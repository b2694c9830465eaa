"""Compliances, reactions and optima from a model, or from the law."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import GammaOption, ModelArgument, Output, with_output
from crankfem.cli.console import print_json, print_line, print_table

if TYPE_CHECKING:
    from crankbase.table import OutputUnits
    from crankfem.analyses.engine_optimum import Kind
    from regression.models.compliance_model import ComplianceModel
    from regression.models.lookup import Lookup
    from regression.optimum import Limit, Optimum


SUPPORTS = "End sections: pinned ones tilt freely, guided ones do not; a throw in a shaft is between the two."


@with_output(units=True)
def lookup(
    model: ModelArgument,
    dimensions: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME=VALUE...",
            help="Dimensions with units, and choices.",
            autocompletion=completion.dimensions,
        ),
    ] = None,
    throw: Annotated[
        str | None,
        typer.Option(
            metavar="ENGINE.toml",
            help="Use the dimensions of this file's throw; those given override them.",
            autocompletion=completion.engines,
        ),
    ] = None,
    gamma: GammaOption = None,
    pin_force: Annotated[
        str | None,
        typer.Option(
            metavar='"0, -100 kN, 0"',
            help="Also report reactions to a force on the pin: x, y, z in the throw's frame, or Z towards "
            'the shaft ("100 kN").',
        ),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Refuse throws outside the range of the model.")
    ] = False,
    *,
    out: Output,
) -> None:
    """Look up compliances in a model, or by the law (law in place of MODEL.json), with bands.

    Also reactions to a force on the pin. Example: crankfem lookup law --throw 6chn25-34 --pin-force "100 kN"
    """
    from crankfem.analyses.throw.law_record import LAW, LAW_BANDS, law_lookups
    from crankfem.analyses.throw.throw_record import reaction_results
    from crankfem.cli import arguments
    from crankfem.cli.tables.throw_tables import print_reactions

    angle = None if gamma is None else arguments.parse_gamma(gamma, out.quiet)
    force = None if pin_force is None else arguments.parse_pin_force(pin_force)
    refused: dict[str, InputError] = {}
    if str(model) == LAW:
        of_law, material = arguments.law_throw(dimensions or [], throw, out.quiet)
        law = law_lookups(of_law, material, angle)
        answers, react = law.answers, law.reactions
        used = arguments.throw_text(of_law)
    else:
        from regression.models.compliance_model import ComplianceModel

        if not_a_file(model) is None and not model.exists():
            raise InputError(
                f"{model}: does not exist; allowed are law and the path of a model file."
            )
        loaded = ComplianceModel.load(model)
        asked: dict[str, Any] = {}
        if throw is not None:
            asked |= loaded.dimensions_of(arguments.select_throw(throw, quiet=out.quiet)[0])
        asked |= arguments.model_dimensions(loaded, dimensions or [])
        without_law = set() if angle is None else _without_angle_law(loaded, angle)
        answers, refused = loaded.look_all_up(gamma_deg=angle, strict=strict, **asked)
        for name in (name for name in refused if strict and name not in without_law):
            raise refused[name]
        used = arguments.dimensions_text(loaded, asked)
        react = partial(loaded.reactions, strict=strict, **asked)
    reactions = None if force is None else reaction_results(react, force, angle)
    if out.json:
        content = answers | {name: {"refused": str(reason)} for name, reason in refused.items()}
        print_json(content if reactions is None else content | {"reactions": reactions})
        return
    if throw is not None:
        # Dimensions that the command line gives in place of the file.
        names = [pair.partition("=")[0].strip() for pair in dimensions or ()]
        changed = f" with {', '.join(names)} as given" if names else ""
        print_line(out.units.text(f"Throw of {throw}{changed}: {', '.join(used)}."))
    banded = _print_lookups(answers, angle is not None, out.units)
    if any(answer.support in ("pinned", "guided") for answer in answers.values()):
        print_line(SUPPORTS)
    if str(model) == LAW:
        print_line(LAW_BANDS)
    elif banded:
        _print_bands(loaded, banded)
    if reactions is not None:
        print_reactions(reactions, out.units)
    for name, reason in refused.items():
        print_line(out.units.text(f"{_title(name)}: left out; {reason}"))


def _without_angle_law(model: "ComplianceModel", gamma_deg: float) -> set[str]:
    """Name the responses between neighbors whose law the model cannot make; refuse if it makes none."""
    from regression.response_kinds import ANGLE_LAWS

    dependent = [name for name in model.responses if name in ANGLE_LAWS]
    if not dependent:
        raise InputError(
            f"--gamma: given {gamma_deg:g}; allowed only with a model of {' or '.join(ANGLE_LAWS)}, because "
            "nothing else depends on the angle."
        )
    without = {name for name in dependent if not model.responses.keys() >= set(ANGLE_LAWS[name])}
    if len(without) == len(dependent):
        model.angle_law(dependent[0])  # states what is missing
    return without


def _print_lookups(
    answers: dict[str, "Lookup"], with_angle: bool, units: "OutputUnits"
) -> list[str]:
    """Print a line for each response, those that depend on the angle first, then what all share."""
    from regression.response_kinds import ANGLE_LAWS, END_MOMENTS

    hidden = [name for name in answers if name in END_MOMENTS]
    answers = {name: answer for name, answer in answers.items() if name not in hidden} or answers
    between = [name for name in answers if with_angle and name in ANGLE_LAWS]
    others = [name for name in answers if name not in between]
    shared = [
        remark
        for remark in next(iter(answers.values())).remarks
        if all(remark in answer.remarks for answer in answers.values())
    ]
    for name in between:
        _print_lookup(name, answers[name], shared, units)
    if between and others:
        print_line("Independent of --gamma:")
    for name in others:
        _print_lookup(name, answers[name], shared, units)
    for remark in shared:
        print_line(units.text(remark))
    banded = [name for name, answer in answers.items() if answer.inside]
    return [part for n in banded for part in (ANGLE_LAWS[n] if n in between else (n,))]


def _print_lookup(name: str, answer: "Lookup", shared: list[str], units: "OutputUnits") -> None:
    value = units.quantity(answer.value, answer.unit, 4)
    support = f" ({answer.support})" if answer.support else ""
    if not answer.inside:
        place = "OUTSIDE the range, where no band applies"
    elif answer.lower is None or answer.upper is None:
        place = "its band is open, inside the range"
    else:
        lower, upper = (units.quantity(end, answer.unit, 4) for end in (answer.lower, answer.upper))
        place = f"{lower} to {upper}, inside the range"
    print_line(f"{_title(name)}: {value}{support}, {place}")
    for remark in answer.remarks:
        if remark not in shared:
            print_line(units.text(f"  {remark}"))


def _print_bands(model: "ComplianceModel", names: list[str]) -> None:
    """State the errors included in the bands, and those unknown."""
    from regression.fits.selection import COVERAGE
    from regression.models.response_query import FEWEST, equation_error, percent

    used = {name: model.responses[name] for name in names}

    def span(errors: list[float]) -> str:
        ends = dict.fromkeys(percent(error) for error in (min(errors), max(errors)))
        return " to ".join(ends)

    estimates = [
        response.largest_fe_error
        for response in used.values()
        if response.largest_fe_error is not None
    ]
    elements = f" and the finite elements' own estimate ({span(estimates)})" if estimates else ""
    equations = span([equation_error(response) for response in used.values()])
    of = "largest error of the equation at held-out designs and runs"
    if all(response.band_error is not None for response in used.values()):
        enough = min(response.band_designs for response in used.values()) >= FEWEST
        share = f"{100.0 * COVERAGE:g} % of throws"
        of = (
            f"error not exceeded by {share}"
            if enough
            else f"largest error, with too few for {share},"
        )
        of += " at designs not used in the fit"
    print_line(f"Bands: {of} ({equations}){elements}; --json lists them by response.")
    unjudged = [
        _title(name)
        for name, response in used.items()
        if response.band_error is None and response.largest_heldout_error is None
    ]
    if unjudged:
        print_line(f"  Error underestimated for lack of held-out designs: {', '.join(unjudged)}.")
    unknown = [_title(name) for name, response in used.items() if response.largest_fe_error is None]
    if unknown:
        print_line(f"  The error of the finite elements was not estimated: {', '.join(unknown)}.")


def _title(name: str) -> str:
    return name.replace("_", " ")


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
    from crankfem.cli.arguments import model_dimensions, parse_limit
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
    best = find_optimum(loaded, minimize, wanted, fixed=held, margins=not no_margin)
    if engine is not None:
        kept = (
            f"of the throw of {engine}, the ratio of its compliance in the shaft to the pinned one and "
            "its moment of inertia are kept as the throw changes"
        )
        best = replace(best, remarks=(*best.remarks, kept))
    if out.json:
        print_json(_optimum_record(best))
        return
    _print_optimum(loaded, best, out.units)


def _frequency_limits(
    model: "ComplianceModel", engine: str | None, bounds: "dict[Kind, str | None]"
) -> "list[Limit]":
    """Limits on the engine's frequencies; its throw is analyzed only if there are any."""
    from crankfem.cli.arguments import parse_bound

    limits = {
        kind: parse_bound(f"--first-{kind}-frequency", text)
        for kind, text in bounds.items()
        if text is not None
    }
    if not limits and engine is None:
        return []
    if engine is None:
        raise InputError(
            f"--first-{next(iter(limits))}-frequency: given without --engine; allowed is both, because "
            "the frequency is that of a whole engine."
        )
    if not limits:
        raise InputError(
            f"--engine: given {engine!r} without a frequency; allowed is both, like "
            '--first-axial-frequency ">= 40 Hz".'
        )
    for kind in limits:
        if f"{kind}_compliance" not in model.responses:
            raise InputError(
                f"--first-{kind}-frequency: given for a model without {kind}_compliance; allowed is a model "
                "with it, because the frequency follows from it."
            )
    from crankfem.analyses.engine_optimum import engine_frequencies, frequency_limit
    from crankfem.files.engine.engine_file import load_engine

    frequencies = engine_frequencies(load_engine(engine))
    return [frequency_limit(kind, frequencies, model, bound) for kind, bound in limits.items()]


def _optimum_record(best: "Optimum") -> dict[str, Any]:
    from crankbase.results import units
    from crankfem.analyses.record import attributes
    from regression.throw_values import field_unit

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
        | units({"throw": best.throw}),
    }


def _print_optimum(model: "ComplianceModel", best: "Optimum", units: "OutputUnits") -> None:
    from crankbase.table import Column, Table
    from crankfem.cli.arguments import dimensions_text

    print_line(f"Smallest {best.minimized}: {units.quantity(best.value, best.unit, 4)}")
    for name, text in zip(best.factors, dimensions_text(model, best.factors), strict=True):
        end = " (end of its range)" if name in best.at_ends else ""
        print_line(units.text(f"  {text}{end}"))
    if best.limits:
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
                    for check in best.limits
                ],
            )
        )
    for remark in best.remarks:
        print_line(units.text(f"{remark[0].upper()}{remark[1:].rstrip('.')}."))
