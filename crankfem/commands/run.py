"""The main job, and its report written again."""

from pathlib import Path
from typing import Annotated

import typer

from crankfem import console, fit_tables, formula_tables, tables
from crankfem.commands.options import EngineArgument, JsonOption, WorkersOption
from crankfem.console import print_json
from geometry.errors import InputError


def run(
    engine: EngineArgument,
    output: Annotated[
        str | None, typer.Option(help="Folder for the results; NAME-results by default.")
    ] = None,
    workers: WorkersOption = 2,
    json: JsonOption = False,
) -> None:
    """Do everything: throw, formulas, study, vibration, and a report, into one folder."""
    from crankfem.pipeline import REPORT, run_engine
    from crankfem.vibration.records import print_run

    with console.RunProgress() as progress:
        made = run_engine(engine, output, workers=workers, progress=progress)
        progress.finish()
    if json:
        print_json(made.results)
        return
    tables.print_throw(made.results["throw"])
    formula_tables.print_one_throw(made.results["formulas"], 180.0)
    if made.results["study"] is not None:
        fit_tables.print_main_fits(made.results["study"]["fits"])
    print_run(made.results["vibration"])
    console.output.print(f"Report: {made.folder / REPORT}", soft_wrap=True)


def report(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder of a finished run.")],
    json: JsonOption = False,
) -> None:
    """Write the report of a finished run again, from its results and pictures."""
    import json as json_module

    from jinja2 import TemplateError

    from crankfem.pipeline import REPORT, RESULTS
    from crankfem.report.writing import write_report

    path = folder / RESULTS
    if not path.is_file():
        raise InputError(
            f"{folder}: has no {RESULTS}; give the folder that crankfem run has written."
        )
    try:
        results = json_module.loads(path.read_text(encoding="utf-8"))
        made = write_report(results, folder / "pictures", folder / REPORT)
    except (OSError, ValueError, KeyError, TypeError, TemplateError) as error:
        raise InputError(
            f"{path}: is not what crankfem run writes ({error}); run it again."
        ) from None
    if json:
        print_json({"report": str(made)})
    else:
        console.output.print(f"Report: {made}", soft_wrap=True)
