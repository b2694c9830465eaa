"""Arguments and options that several commands share."""

from typing import Annotated

import typer

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
