"""Compliances, reactions and optima from a model, or from the law."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from crankbase.sentences import capital, kept
from crankbase.table import Cell, Column, Main, Table
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import GammaOption, ModelArgument, Output, with_output
from crankfem.cli.console import print_json

if TYPE_CHECKING:
    from crankbase.table import OutputUnits
    from crankfem.analyses.engine_optimum import Kind
    from regression.models.compliance_model import ComplianceModel
    from regression.models.lookup import Lookup
    from regression.optimum import Limit, Optimum, Searched


ENDS = "End sections: pinned ones tilt freely, guided ones do not; a throw in a shaft is between the two."


@with_output(units=True, source="throw")
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
        bool,
        typer.Option(
            "--strict", help="Refuse throws outside the range of a model; the law always does."
        ),
    ] = False,
    *,
    out: Output,
) -> None:
    """Look up compliances in a model, or by the law (law in place of MODEL.json), with bands.

    Also reactions to a force on the pin. Example: crankfem lookup law --throw 6chn25-34 --pin-force "100 kN"
    """
    # Each way loads what it needs alone: finite elements, sections and the law take long.
    from crankfem.cli import arguments

    angle = None if gamma is None else arguments.parse_gamma(gamma, out.quiet)
    force = None if pin_force is None else arguments.parse_pin_force(pin_force)
    refused: dict[str, InputError] = {}
    by_law = str(model) == "law"
    if by_law:
        from crankfem.analyses.throw.law_record import LAW_BANDS, law_lookups

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
            of_file, material = arguments.select_throw(throw, quiet=out.quiet)
            loaded = loaded.of_material(material)
            asked |= loaded.dimensions_of(of_file)
        asked |= arguments.model_dimensions(loaded, dimensions or [])
        without_law = set() if angle is None else _without_angle_law(loaded, angle)
        answers, refused = loaded.look_all_up(gamma_deg=angle, strict=strict, **asked)
        for name in (name for name in refused if strict and name not in without_law):
            raise refused[name]
        used = arguments.dimensions_text(loaded, asked)
        react = partial(loaded.reactions, strict=strict, **asked)
    reactions = None
    if force is not None:
        from crankfem.analyses.throw.throw_record import reaction_results

        reactions = reaction_results(react, force, angle)
    if out.json:
        content = answers | {name: {"refused": str(reason)} for name, reason in refused.items()}
        print_json(content if reactions is None else content | {"reactions": reactions})
        return
    parts: list[Table | str] = []
    if reactions is not None:
        from crankfem.cli.tables.throw_tables import reaction_parts

        parts += reaction_parts(reactions, out.units)
    if throw is not None:
        # Dimensions that the command line gives in place of the file.
        names = [pair.partition("=")[0].strip() for pair in dimensions or ()]
        changed = f" with {', '.join(names)} as given" if names else ""
        parts.append(Main(out.units.written(f"Throw of {throw}{changed}: {', '.join(used)}.")))
    if any(answer.support in ("pinned", "guided") for answer in answers.values()):
        parts.append(ENDS)
    if by_law:
        parts.append(Main(LAW_BANDS))
    elif banded := _banded(answers, angle is not None):
        parts += _bands(loaded, banded)
    for name, reason in refused.items():
        parts.append(Main(out.units.written(f"{_title(name)}: left out; {reason}")))
    shown, *remarks = _answer_parts(answers, out.units)
    out.show(parts, *remarks, shown)


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


def _shown(answers: "dict[str, Lookup]") -> "dict[str, Lookup]":
    """Leave out responses from which reactions follow, unless there are no others."""
    from regression.response_kinds import END_MOMENTS

    return {n: answer for n, answer in answers.items() if n not in END_MOMENTS} or answers


def _banded(answers: "dict[str, Lookup]", with_angle: bool) -> list[str]:
    """Name the responses that have a band, those between neighbors by what their law takes."""
    from regression.response_kinds import ANGLE_LAWS

    banded = [name for name, answer in _shown(answers).items() if answer.inside]
    return [part for n in banded for part in (ANGLE_LAWS.get(n, (n,)) if with_angle else (n,))]


def _answer_parts(answers: "dict[str, Lookup]", units: "OutputUnits") -> "Iterator[Table | str]":
    """Return the table of responses, then their remarks, each once."""
    from regression.response_kinds import SUPPORTS

    shown = _shown(answers)

    def cells(row: "tuple[str, Lookup]") -> list[Cell]:
        name, answer = row
        ends = (answer.lower, answer.upper) if answer.inside else (None, None)
        values = [
            "none" if value is None else units.quantity(value, answer.unit, 4)
            for value in (answer.value, *ends)
        ]
        unit = values[0].partition(" ")[2]
        title = name.removesuffix(f"_{next(filter(name.endswith, SUPPORTS), '')}")
        return [_title(title), answer.support, *(v.removesuffix(f" {unit}") for v in values), unit]

    yield Table(
        "Values with their bands",
        [
            Column("response", words=True),
            Column("ends", words=True),
            *map(Column, ("value", "from", "to")),
            Column("unit", words=True),
        ],
        list(map(cells, shown.items())),
    )
    for name, answer in shown.items():
        if not answer.inside:
            yield Main(f"{_title(name)}: OUTSIDE the range, where no band applies")
        elif answer.lower is None or answer.upper is None:
            yield Main(f"{_title(name)}: its band is open, inside the range")
    with_remark: dict[str, list[str]] = {}
    for name, answer in shown.items():
        for remark in answer.remarks:
            with_remark.setdefault(remark, []).append(_title(name))
    for remark, names in with_remark.items():
        of = "" if len(names) == len(shown) else f"{', '.join(names)}: "
        yield units.written(f"{of}{kept(remark)}")


def _bands(model: "ComplianceModel", names: list[str]) -> Iterator[str]:
    """State the errors included in the bands, and those unknown."""
    from regression.fits.selection import COVERAGE
    from regression.models.response_query import FEWEST, equation_error, percent

    every = {name: model.responses[name] for name in names}
    processes = [response for response in every.values() if response.process]
    used = {name: response for name, response in every.items() if not response.process}
    if processes:
        most = max(response.process.band for response in processes if response.process)
        enough = min(response.band_designs for response in processes) >= FEWEST
        yield Main(
            f"Bands of Gaussian processes: up to {most:.3g} standard deviations at the throw, which hold "
            f"{f'{100.0 * COVERAGE:g} % of' if enough else 'the few'} designs not used in the fit, and the "
            "finite elements' own estimate."
        )
    if not used:
        return

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
    yield Main(f"Bands: {of} ({equations}){elements}; --json lists them by response.")
    unjudged = [
        _title(name)
        for name, response in used.items()
        if response.band_error is None and response.largest_heldout_error is None
    ]
    if unjudged:
        yield f"  Error underestimated for lack of held-out designs: {', '.join(unjudged)}."
    unknown = [_title(name) for name, response in used.items() if response.largest_fe_error is None]
    if unknown:
        yield f"  The error of the finite elements was not estimated: {', '.join(unknown)}."


def _title(name: str) -> str:
    return name.replace("_", " ")


@with_output(units=True, source="source engine")
def optimum(
    source: Annotated[
        str,
        typer.Argument(
            metavar="MODEL.json|ENGINE.toml",
            help="Model file; with --vary an engine file, or the name of a shipped engine.",
            autocompletion=completion.files(".json"),
        ),
    ],
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
            help="Engine whose frequencies are limited, with a model; takes some seconds.",
            autocompletion=completion.engines,
        ),
    ] = None,
    first_axial_frequency: Annotated[
        str | None,
        typer.Option(
            metavar='">= 40 Hz"',
            help="Lower bound on the crankshaft's first axial frequency, with --engine or --vary.",
        ),
    ] = None,
    first_torsional_frequency: Annotated[
        str | None,
        typer.Option(
            metavar='">= 40 Hz"',
            help="Lower bound on the crankshaft's first torsional frequency, with --engine or --vary.",
        ),
    ] = None,
    fixed: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Factor to keep fixed; may be repeated."),
    ] = None,
    no_margin: Annotated[
        bool,
        typer.Option(
            "--no-margin", help="Apply limits to the values themselves, without their bands."
        ),
    ] = False,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=LOW..HIGH",
            help="Dimension of the engine's throw to vary, by finite elements; may be repeated.",
        ),
    ] = None,
    *,
    out: Output,
) -> None:
    """Find the smallest value of a dimension or response, such as web thickness, under limits.

    In a model of a study; or by finite elements of an engine's throw, whose dimensions --vary names.
    """
    from crankfem.cli.arguments import model_dimensions, parse_limit
    from crankfem.files.reading.data_files import shipped_names
    from regression.models.compliance_model import ComplianceModel
    from regression.optimum import check_known, find_optimum

    bounds: dict[Kind, str | None] = {
        "axial": first_axial_frequency,
        "torsional": first_torsional_frequency,
    }
    if vary:
        for option, value in (("--engine", engine), ("--fixed", fixed)):
            if value:
                raise InputError(
                    f"{option}: given with --vary; allowed is one of them, because the search changes the "
                    f"throw of {source} itself."
                )
        _show_varied(source, vary, minimize, limits or [], bounds, not no_margin, out)
        return
    if Path(source).suffix == ".toml" or source in shipped_names("engine"):
        raise InputError(
            f"{source}: given without --vary; allowed is an engine with --vary, like "
            "--vary web_width=300mm..380mm, because an engine alone does not say what may change."
        )
    loaded = ComplianceModel.load(Path(source))
    check_known(loaded, minimize, "--minimize")
    held = model_dimensions(loaded, fixed or [])
    wanted = [parse_limit(loaded, text) for text in limits or []]
    loaded, frequencies = _frequency_limits(loaded, engine, bounds)
    wanted += frequencies
    best = find_optimum(loaded, minimize, wanted, fixed=held, margins=not no_margin)
    if engine is not None:
        kept = (
            f"of the throw of {engine}, the ratio of its compliance in the shaft to the pinned one and "
            "its moment of inertia are kept as the throw changes"
        )
        best = replace(best, remarks=(*best.remarks, kept))
    _show_optimum(loaded, best, out)


def _show_optimum(model: "Searched", best: "Optimum", out: Output) -> None:
    if out.json:
        print_json(_optimum_record(best))
        return
    value = out.units.quantity(best.value, best.unit, 4)
    parts = _optimum_parts(model, best, out.units)
    out.show(parts, f"Smallest {best.minimized}: {value}")


def _show_varied(
    engine: str,
    vary: list[str],
    minimize: str,
    limits: list[str],
    bounds: "dict[Kind, str | None]",
    margins: bool,
    out: Output,
) -> None:
    """Search among the throws of an engine by finite elements; an interrupt ends with the best so far."""
    from crankfem.analyses.throw_optimum import SearchInterrupted, ThrowFamily, best_throw
    from crankfem.cli.arguments import parse_bound, parse_limit, parse_range
    from crankfem.files.engine.engine_file import load_engine
    from regression.optimum import Limit, check_known

    read = load_engine(engine)
    ranges = console.parse_pairs(vary, parse_range, "web_width=300mm..380mm")
    family = ThrowFamily(read, ranges)
    check_known(family, minimize, "--minimize")
    wanted = [parse_limit(family, text) for text in limits]
    for kind, text in bounds.items():
        if text is not None:
            least = parse_bound(f"--first-{kind}-frequency", text)
            wanted.append(Limit((f"first_{kind}_frequency",), at_least=least, unit="Hz"))
    stopped = False
    try:
        with console.RunProgress(out.quiet) as progress:
            best = best_throw(read, ranges, minimize, wanted, margins=margins, step=progress.step)
            progress.finish()
    except SearchInterrupted as interrupt:
        if interrupt.best is None:
            raise
        best, stopped = interrupt.best, True
    _show_optimum(family, best, out)
    if stopped:
        console.exit_interrupted("Stopped. The best throw so far is shown.")


def _frequency_limits(
    model: "ComplianceModel", engine: str | None, bounds: "dict[Kind, str | None]"
) -> "tuple[ComplianceModel, list[Limit]]":
    """Model of the engine's material, and limits on its frequencies, for which its throw is analyzed."""
    from crankfem.cli.arguments import parse_bound

    limits = {
        kind: parse_bound(f"--first-{kind}-frequency", text)
        for kind, text in bounds.items()
        if text is not None
    }
    if not limits and engine is None:
        return model, []
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

    read = load_engine(engine)
    model = model.of_material(read.material)
    frequencies = engine_frequencies(read)
    return model, [
        frequency_limit(kind, frequencies, model, bound) for kind, bound in limits.items()
    ]


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


def _optimum_parts(
    model: "Searched", best: "Optimum", units: "OutputUnits"
) -> "Iterator[Table | str]":
    from crankfem.cli.arguments import dimensions_text

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
    for name, text in zip(best.factors, dimensions_text(model, best.factors), strict=True):
        end = " (end of its range)" if name in best.at_ends else ""
        yield Main(units.written(f"  {text}{end}"))
