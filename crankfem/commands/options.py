"""Arguments and options that several commands share."""

from collections.abc import Sequence
from typing import Annotated, TypeVar

import typer

from geometry.errors import InputError

Choice = TypeVar("Choice", bound=str)

EngineArgument = Annotated[
    str, typer.Argument(metavar="ENGINE.toml", help="Engine file, or the name of a shipped engine.")
]
ThrowArgument = Annotated[
    str,
    typer.Argument(
        metavar="ENGINE.toml",
        help="Engine file, name of a shipped engine, or a STEP file of a throw.",
    ),
]
SpeedOption = Annotated[
    str | None,
    typer.Option(metavar='"1000 1/min"', help="Speed of an engine; its rated speed by default."),
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print machine-readable results on standard output.")
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
