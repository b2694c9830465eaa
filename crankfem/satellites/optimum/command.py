"""The command `optimum`."""

from pathlib import Path
from typing import Annotated

import typer

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output


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
    from crankfem.files.reading.data_files import shipped_names
    from crankfem.satellites.optimum import searches

    question = searches.Question(
        minimize,
        limits or [],
        {"axial": first_axial_frequency, "torsional": first_torsional_frequency},
        not no_margin,
    )
    if vary:
        for option, value in (("--engine", engine), ("--fixed", fixed)):
            if value:
                raise InputError(
                    f"{option}: given with --vary; allowed is one of them, because the search changes the "
                    f"throw of {source} itself."
                )
        with console.RunProgress(out.quiet) as progress:
            answer = searches.among_throws(question, source, vary, progress.step)
            progress.finish()
    elif Path(source).suffix == ".toml" or source in shipped_names("engine"):
        raise InputError(
            f"{source}: given without --vary; allowed is an engine with --vary, like "
            "--vary web_width=300mm..380mm, because an engine alone does not say what may change."
        )
    else:
        answer = searches.in_model(question, Path(source), engine, fixed or [])
    if out.json:
        console.print_json(searches.optimum_record(answer.best))
    else:
        best = answer.best
        value = out.units.quantity(best.value, best.unit, 4)
        out.show(searches.optimum_parts(answer, out.units), f"Smallest {best.minimized}: {value}")
    if answer.stopped:
        console.exit_interrupted("Stopped. The best throw so far is shown.")
