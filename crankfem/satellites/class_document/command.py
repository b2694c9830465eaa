"""The command `class`."""

from typing import Annotated

import typer

from crankbase.table import Main
from crankfem.cli import console
from crankfem.cli.commands.options import (
    EngineArgument,
    Output,
    StrictOption,
    exit_unless_acceptable,
    with_output,
)
from crankfem.cli.console import print_json


@with_output(files=True, tables=True, source="engine")
def class_(
    engine: EngineArgument,
    output: Annotated[
        str,
        typer.Option(
            metavar="FOLDER", help="Folder for the document, its tables as CSV and its diagrams."
        ),
    ],
    strict: StrictOption = False,
    *,
    out: Output,
) -> None:
    """Write the torsional vibration document for a classification society, as HTML for A4."""
    from crankfem.satellites.class_document.writing import write_class_document

    with console.RunProgress(out.quiet) as progress:
        made = write_class_document(engine, output, progress)
        progress.finish()
    findings = made.parts[0].sentences
    if out.json:
        verdict = made.run.assessment
        print_json(
            {
                "document": str(made.page),
                "tables": [str(path) for path in made.tables],
                "status": None if verdict is None else verdict.decision.status,
                "findings": list(findings),
            }
        )
    elif out.quiet:
        console.print_path(str(made.page))
    else:
        first, *further = map(Main, findings)
        out.show(further, f"Document: {made.page}", first)
    if strict:
        exit_unless_acceptable(made.run)
