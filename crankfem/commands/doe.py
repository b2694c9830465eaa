"""Designs of experiments."""

from pathlib import Path
from typing import Annotated

import typer

from crankfem import console, tables
from crankfem.commands.options import JsonOption, WorkersOption
from crankfem.console import print_json


def doe(
    study: Annotated[
        str, typer.Argument(metavar="STUDY.toml", help="File with the sections throw and study.")
    ],
    store: Annotated[Path, typer.Option(help="SQLite file of results.")] = Path("runs.sqlite"),
    workers: WorkersOption = 2,
    json: JsonOption = False,
) -> None:
    """Run a design of experiments, or continue it where it stopped."""
    from crankfem.engine_file import load_study
    from crankfem.results import study_record
    from crankfem.studies import fitted
    from regression.study import run_plan

    plan = load_study(study)
    with console.RunProgress() as progress:
        progress.step("Running the study")
        table = run_plan(plan, store, workers, progress.design)
        progress.finish()
    found = fitted(table)
    record = study_record(found.table, found.fits)
    if json:
        print_json(record)
        return
    console.output.print(
        f"{record['runs']} runs and {record['held_out']} held-out designs in {store}; "
        f"{record['computed_now']} computed now, {len(record['failures'])} failed.",
        soft_wrap=True,
    )
    tables.print_fits(record["fits"])
