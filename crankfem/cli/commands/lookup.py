"""Compliances and reactions from a model, or from the law."""

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from crankbase.sentences import kept
from crankbase.table import Cell, Column, Main, Table
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import GammaOption, ModelArgument, Output, with_output
from crankfem.cli.console import print_json

if TYPE_CHECKING:
    from crankbase.table import OutputUnits
    from regression.models.compliance_model import ComplianceModel
    from regression.models.lookup import Lookup


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
    from regression.response_kinds import ANGLE_LAWS

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
            from geometry.any_throw import with_dimensions

            of_file, material = arguments.select_throw(throw, quiet=out.quiet)
            loaded = loaded.of_material(material)
            asked |= loaded.dimensions_of(with_dimensions(of_file))
        asked |= arguments.model_dimensions(loaded, dimensions or [])
        without_law = set() if angle is None else _without_angle_law(loaded, angle)
        answers, refused = loaded.look_all_up(gamma_deg=angle, strict=strict, **asked)
        for name in (name for name in refused if strict and name not in without_law):
            raise refused[name]
        used = arguments.dimensions_text(loaded.family, asked)
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
    else:
        banded = [name for name, answer in _shown(answers).items() if answer.inside]
        if angle is not None:  # then by what their law takes
            banded = [part for name in banded for part in ANGLE_LAWS.get(name, (name,))]
        if banded:
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
