"""Equations fitted to a study."""

from pathlib import Path
from typing import Annotated

import typer

from crankbase.table import Main
from crankfem.cli import console
from crankfem.cli.commands.doe import StoreArgument, StudyOption
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json


@with_output(files=True, tables=True)
def fit(
    store: StoreArgument,
    model: Annotated[Path, typer.Option(help="Model file to write.")] = Path("model.json"),
    study: StudyOption = None,
    form: Annotated[
        str | None, typer.Option(help="Form in place of the chosen ones, such as Gaussian process.")
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
    from crankfem.analyses.study.fit_records import compliance_model, fitted_study
    from crankfem.analyses.study.response_fits import fit_study
    from crankfem.analyses.study.studies import study_key
    from crankfem.analyses.study.study_results import comparison_parts
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
    table = read_study(store, study_key(study))
    if table.damaged:
        again = "run the study again (crankfem doe), which computes their designs"
        console.print_warning(f"{damaged_rows_warning(table.damaged, store)}; {again}.")
    fits = fit_study(table, form)
    if response is not None and response not in fits:
        raise InputError(
            f"response: given {response!r}; allowed are {', '.join(fits)}, which this study has."
        )
    made = compliance_model(table, fits, form)
    fitted = fitted_study(table, fits, made)
    shown = response or fitted.main_response
    folder = make_output_folder("--plots", plots, fit_plot_files(shown))
    made.save(model)
    written = [] if folder is None else plot_fits(folder, table, fits[shown], form)
    if out.json:
        print_json(fitted)
        return
    unfitted = [
        Main(f"No equation for {name}: {reason}") for name, reason in fitted.unfitted.items()
    ]
    parts = [*fitted.parts(shown, form), *unfitted, *comparison_parts(fitted.compared)]
    diagrams = [f"Diagrams: {', '.join(map(str, written))}"] if written else []
    saved = [f"Model: {model}", f"Use it: {fitted.lookup_line(str(model))}"]
    out.show([*parts, *diagrams], *fitted.answer(shown, form), *saved)
