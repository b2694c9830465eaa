"""How a file is understood."""

from pathlib import Path
from typing import Annotated

import typer

from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json


@with_output(files=True, units=True)
def check(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE.toml",
            help="Engine, throw, hinge or chain file, or the name of a shipped one.",
            autocompletion=completion.any_input,
        ),
    ],
    picture: Annotated[
        Path | None,
        typer.Option(metavar="THROW.svg", help="Also draw the throw with its dimensions."),
    ] = None,
    *,
    out: Output,
) -> None:
    """Check a file: show how it is read, what is assumed, and which commands can use it."""
    from crankbase.errors import InputError
    from crankfem.analyses.file_check import check_file, check_record
    from crankfem.cli.tables.check_tables import print_check

    checked = check_file(file)
    record = check_record(checked)
    if picture is not None:
        from crankfem.analyses.throw.pictures.drawing import check_drawing_ending, write_drawing
        from crankfem.jobs.outputs import check_writable

        if checked.throw is None:
            raise InputError(
                f"--picture: given with a {checked.kind} file; allowed is a file with a throw, because "
                "that is drawn."
            )
        check_drawing_ending(picture)
        check_writable(picture, "picture", checked.path)
        record["picture"] = str(write_drawing(checked.throw, picture, checked.path.stem))
    if out.json:
        print_json(record)
        return
    print_check(record, out.units)
    if picture is not None:
        console.print_line(f"{picture} written.")
