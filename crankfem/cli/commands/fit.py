"""Equations fitted to a study."""

from pathlib import Path
from typing import Annotated

import typer

from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json


@with_output(files=True)
def fit(
    store: Annotated[
        Path,
        typer.Argument(
            metavar="RUNS.sqlite",
            help="Store of a study.",
            autocompletion=completion.files(".sqlite"),
        ),
    ],
    model: Annotated[Path, typer.Option(help="Model file to write.")] = Path("model.json"),
    study: Annotated[
        str | None,
        typer.Option(
            help="First characters of the study's key, or its file, if there are several."
        ),
    ] = None,
    form: Annotated[
        str | None, typer.Option(help="Form to use for every response in place of the chosen ones.")
    ] = None,
    response: Annotated[
        str | None,
        typer.Option(help="Response to print in detail; by default the axial compliance."),
    ] = None,
    plots: Annotated[Path | None, typer.Option(help="Folder to write diagrams to (SVG).")] = None,
    *,
    out: Output,
) -> None:
    """Fit equations to a study's results and save the best as a model."""
    from crankbase.errors import InputError
    from crankfem.analyses.study.fit_plots import fit_plot_files, plot_fits
    from crankfem.analyses.study.fit_records import compliance_model, study_record
    from crankfem.analyses.study.response_fits import fit_study
    from crankfem.analyses.study.studies import study_key
    from crankfem.cli.tables.study_tables import MAIN_RESPONSE, print_comparisons, print_fits
    from crankfem.jobs.outputs import check_writable, make_output_folder
    from regression.models.compliance_model import is_model
    from regression.runs.store import damaged_rows_warning
    from regression.runs.study import read_study

    if model.is_dir():
        raise InputError(
            f"--model: given {model}, which is a folder; allowed is a file to write, like "
            f"{model / 'model.json'}."
        )
    inputs = [store]
    if study is not None and study.endswith(".toml"):
        inputs.append(Path(study))
    check_writable(model, "model", *inputs, name=f"--model {model}", recognized=is_model)
    if study is not None and study.endswith(".toml"):
        study = study_key(study)
    table = read_study(store, study)
    if table.damaged:
        again = "run the study again (crankfem doe), which computes their designs"
        console.print_warning(f"{damaged_rows_warning(table.damaged, store)}; {again}.")
    fits = fit_study(table)
    if response is not None and response not in fits:
        raise InputError(
            f"response: given {response!r}; allowed are {', '.join(fits)}, which this study has."
        )
    shown = response or (MAIN_RESPONSE if MAIN_RESPONSE in fits else next(iter(fits)))
    folder = make_output_folder("--plots", plots, fit_plot_files(shown))
    made = compliance_model(table, fits, form)
    made.save(model)
    record = study_record(table, fits, made)
    written = [] if folder is None else plot_fits(folder, table, fits[shown], form)
    if out.json:
        print_json(record)
        return
    print_fits(record["fits"], shown, form)
    for name, reason in record["unfitted"].items():
        console.output.print(f"No equation for {name}: {reason}", soft_wrap=True, highlight=False)
    print_comparisons(record["compared"])
    if written:
        console.output.print(f"Diagrams: {', '.join(map(str, written))}", soft_wrap=True)
    console.output.print(f"Model: {model}", soft_wrap=True)
