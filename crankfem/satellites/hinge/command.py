"""The elastic hinge that keeps a crank's speed constant."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json


@with_output(files=True, units=True)
def hinge(
    file: Annotated[
        str,
        typer.Argument(
            metavar="HINGE.toml",
            help="Hinge file, or the name of a shipped one.",
            autocompletion=completion.files(".toml", shipped=("hinge",)),
        ),
    ] = "crosshead-30-100",
    speed: Annotated[
        str | None,
        typer.Option(
            metavar='"142 1/min"',
            help="Other running point of the file to evaluate; all by default.",
        ),
    ] = None,
    kinematics: Annotated[
        str, typer.Option(help="Kinematics used for the guides: exact, series or printed.")
    ] = "exact",
    roller_radius: Annotated[
        str | None,
        typer.Option(
            metavar='"60 mm"', help="Radius of the rollers, in place of the one in the file."
        ),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Write all quantities over a revolution."),
    ] = None,
    pictures: Annotated[
        str | None,
        typer.Option(metavar="FOLDER", help="Write diagrams of moments, guides and speeds."),
    ] = None,
    *,
    out: Output,
) -> None:
    """Calculate the guides of an elastic hinge for constant crank speed, and the speed left uneven."""
    from crankbase.choices import check_choice
    from crankbase.written_quantity import parse_quantity
    from crankfem.analyses.record import with_units
    from crankfem.cli.console import write_columns
    from crankfem.jobs.outputs import check_outputs
    from crankfem.satellites.hinge.crosshead import KINEMATICS
    from crankfem.satellites.hinge.file import load_hinge
    from crankfem.satellites.hinge.run import (
        FILES,
        SURFACE,
        hinge_columns,
        plot_hinge,
        run_hinge,
    )

    other = None if speed is None else parse_quantity(speed, "rad/s", "--speed")
    loaded = load_hinge(file)
    if roller_radius is not None:
        radius = parse_quantity(roller_radius, "m", "--roller-radius")
        loaded = replace(loaded, roller_radius=radius)
    check_choice(
        "--kinematics", kinematics, KINEMATICS, "these are the ways to describe the mechanism"
    )
    names = [*FILES, *([SURFACE] if loaded.roller_radius else [])]
    folder = check_outputs(csv, pictures, loaded.path, *loaded.tables, names=names)
    run = run_hinge(loaded, cast(Any, kinematics), other)
    if csv is not None:
        write_columns(csv, hinge_columns(run))
    made = [] if folder is None else plot_hinge(folder, run)
    if out.json:
        pictures_made = [str(path) for path in made]
        print_json(with_units(run) | {"pictures": pictures_made})
        return
    files = [f"Over a revolution: {csv}"] if csv is not None else []
    files += [f"Pictures: {pictures} ({len(made)} files)"] if made else []
    *parts, answer = run.tables(out.units)
    out.show(parts, *files, answer)
