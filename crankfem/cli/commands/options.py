"""Arguments and options that several commands share."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from crankbase.errors import InputError
from crankbase.outputs import replacing_files
from crankfem.cli.commands import completion

Choice = TypeVar("Choice", bound=str)


def _set_replacement_rules(command: typer.Context, force: bool) -> bool:
    """Set by which rules the command that begins writes its files."""
    command.with_resource(replacing_files(force))
    return force


EngineArgument = Annotated[
    str,
    typer.Argument(
        metavar="ENGINE.toml",
        help="Engine file, or the name of a shipped engine.",
        autocompletion=completion.engines,
    ),
]
ThrowArgument = Annotated[
    str,
    typer.Argument(
        metavar="ENGINE.toml",
        help="Engine file, name of a shipped engine, or a STEP file of a throw.",
        autocompletion=completion.engines_and_parts,
    ),
]
ModelArgument = Annotated[
    Path,
    typer.Argument(
        metavar="MODEL.json", help="Model file.", autocompletion=completion.files(".json")
    ),
]
SpeedOption = Annotated[
    str | None,
    typer.Option(metavar='"1000 1/min"', help="Speed of an engine; its rated speed by default."),
]
GammaOption = Annotated[
    str | None,
    typer.Option(
        "--gamma",
        "--gamma-deg",
        metavar='"120 deg"',
        help="Angle between neighboring cranks; a bare number is in degrees.",
        show_default="180 deg",
    ),
]
JsonOption = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Print machine-readable results in SI units, nothing else, on standard output.",
    ),
]
QuietOption = Annotated[
    bool, typer.Option("--quiet", "-q", help="Nothing on standard error but errors.")
]
ForceOption = Annotated[
    bool,
    typer.Option(
        "--force",
        help="Replace files too that crankfem has not made, but none that is read here.",
        callback=_set_replacement_rules,
    ),
]
UnitsOption = Annotated[
    str | None,
    typer.Option(
        metavar='"in, lbf, ksi"',
        help="Units to print in, any that are known; or imperial. JSON and files stay in SI units.",
        show_default="SI",
    ),
]
StrictOption = Annotated[
    bool,
    typer.Option(
        "--strict", help="End with code 4 if limits are exceeded, with 2 if nothing can be judged."
    ),
]
ThrowOption = Annotated[
    str | None,
    typer.Option(
        "--throw",
        metavar="NAME",
        help="Which of several throws, each a section [throws.NAME]; that at the free end by default.",
        show_default=False,
    ),
]
WorkersOption = Annotated[int, typer.Option(help="Worker processes of the study.")]


def checked_choice(option: str, given: str, allowed: Sequence[Choice], reason: str) -> Choice:
    """Return what was given as the one of the allowed texts that it is.

    Raises
    ------
    InputError
        If it is none of them.
    """
    for choice in allowed:
        if given == choice:
            return choice
    raise InputError(
        f"{option}: given {given!r}; allowed are {', '.join(allowed)}, because {reason}."
    )
