"""Equations fitted to a study."""

from pathlib import Path
from typing import Annotated

import typer

from crankfem import console, tables
from crankfem.commands.options import JsonOption
from crankfem.console import print_json


def fit(
    store: Annotated[Path, typer.Argument(metavar="RUNS.sqlite", help="Store of a study.")],
    model: Annotated[Path, typer.Option(help="Model file to write.")] = Path("model.json"),
    study: Annotated[
        str | None, typer.Option(help="First characters of the study's key, if there are several.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Fit equations to a study's results and save the best as a model."""
    from crankfem.results import study_record
    from crankfem.studies import fitted
    from regression.study import read_study

    found = fitted(read_study(store, study))
    found.model.save(model)
    record = study_record(found.table, found.fits)
    if json:
        print_json(record)
        return
    tables.print_fits(record["fits"])
    console.output.print(f"Model: {model}", soft_wrap=True)
