"""The torsional vibration document for a classification society."""

from typing import Annotated

import typer

from crankfem.cli import console
from crankfem.cli.commands.options import EngineArgument, Output, StrictOption, with_output
from crankfem.cli.commands.strict import exit_unless_acceptable
from crankfem.cli.console import print_json


@with_output(files=True)
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
    from crankfem.analyses.vibration.records import run_record
    from crankfem.jobs.class_document import write_class_document

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
        for sentence in findings:
            console.print_line(sentence)
        console.print_path(f"Document: {made.page}")
    if strict:
        exit_unless_acceptable(run_record(made.run))
