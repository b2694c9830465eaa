"""Studies: run one, list its designs or write them, import and export results, verify a store."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.outputs import protect
from crankbase.written_quantity import parse_quantity
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, WorkersOption, with_output
from crankfem.cli.console import print_json, print_parts
from crankfem.jobs.exit_codes import EXIT_INPUT

if TYPE_CHECKING:
    from crankbase.results import Result
    from crankbase.table import Table
    from regression.plans.plan import StudyPlan
    from regression.runs.study_table import StudyTable

# Fewer held-out designs leave most of the box unseen.
FEW_HELD_OUT = 5
StudyArgument = Annotated[
    str,
    typer.Argument(
        metavar="STUDY.toml",
        help="File with the sections throw and study.",
        autocompletion=completion.engines,
    ),
]
StoreArgument = Annotated[
    Path,
    typer.Argument(
        metavar="RUNS.sqlite", help="Store of a study.", autocompletion=completion.files(".sqlite")
    ),
]
StoreOption = Annotated[Path, typer.Option(help="SQLite file of results.")]
STORE = Path("runs.sqlite")
StudyOption = Annotated[
    str | None,
    typer.Option(help="First characters of the study's key, or its file, if there are several."),
]


def _print(made: "Result", parts: "Iterable[Table | str]", out: Output) -> None:
    if out.json:
        print_json(made)
    else:
        print_parts(parts)


@with_output(tables=True, source="study")
def doe(
    study: StudyArgument,
    store: StoreOption = STORE,
    workers: WorkersOption = 2,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Address of the scheduler of a Dask cluster to compute on, like tcp://10.0.0.1:8786.",
        ),
    ] = None,
    time_limit: Annotated[
        str | None, typer.Option(help='Time limit for one design, like "300 s".')
    ] = None,
    memory_limit: Annotated[
        str | None, typer.Option(help='Memory limit for one worker process, like "4 GB".')
    ] = None,
    more: Annotated[
        int,
        typer.Option(
            help="Number of further runs to place where the equations are worst. The store keeps them; "
            "repeating the same number adds none."
        ),
    ] = 0,
    *,
    out: Output,
) -> None:
    """Run a design of experiments, or continue it where it stopped."""
    from crankfem.analyses.study.fit_records import fitted_study
    from crankfem.analyses.study.studies import fitted
    from crankfem.analyses.study.study_results import comparison_parts
    from crankfem.files.engine.throw_file import load_study
    from regression.runs.store import damaged_rows_warning

    limits = {
        "time_limit": _quantity(time_limit, "s", "--time-limit"),
        "memory_limit": _quantity(memory_limit, "byte", "--memory-limit"),
    }
    plan = load_study(study)
    table = _run(plan, store, workers, {"dask": dask, "more": more, **limits}, out.quiet)

    def print_progress(text: str) -> None:
        # With --json nothing but the results may stand on standard output.
        if out.json:
            console.print_note(text, out.quiet)
        else:
            console.print_line(text)

    held_out = int(table.held_out.sum())
    text = (
        f"Study {table.plan.key[:6]}: {len(table.held_out) - held_out} runs and {held_out} held-out "
        f"designs in {store}; {table.computed} computed now, {len(table.failures)} without a result"
    )
    if table.added:
        text += f", {table.added} of the runs added to the plan's"
    if table.excluded:
        text += f", {len(table.excluded)} excluded by the plan"
    if table.extra:
        text += f", {len(table.extra)} imported rows"
    print_progress(f"{text}.")
    if table.damaged:
        console.print_warning(f"{damaged_rows_warning(table.damaged, store)}; import them again.")
    if 0 < held_out < FEW_HELD_OUT:
        print_progress(
            f"Note: only {held_out} held-out designs judge the fits; with fewer than {FEW_HELD_OUT} their "
            "largest error says little about the space between the runs."
        )
    fits = fitted(table)
    made = fitted_study(table, fits.fits, fits.model)
    if out.json:
        print_json(made)
        return
    next_ = f"crankfem fit {store} --model model.json"
    out.show(
        (*made.parts(), *comparison_parts(made.compared)),
        *made.answer(),
        f"All runs are in {store}. Save the equations: {next_}",
        f"Use them: {made.lookup_line('model.json')}",
    )


def _quantity(text: str | None, unit: str, option: str) -> float | None:
    return None if text is None else parse_quantity(text, unit, option)


def _run(
    plan: "StudyPlan", store: Path, workers: int, options: dict[str, Any], quiet: bool
) -> "StudyTable":
    from crankfem.analyses.study.studies import run_grown

    if options["dask"] is not None:
        from regression.runs.cluster import silence_dask_log

        silence_dask_log()
    with console.RunProgress(quiet) as progress:
        progress.step("Running the study")
        try:
            table = run_grown(plan, store, workers, progress.design, note=progress.warn, **options)
        except KeyboardInterrupt:
            if not progress.total:  # nothing of the store is known yet
                raise
            interrupted = True
        else:
            interrupted = False
            progress.finish()
    if interrupted:
        console.exit_interrupted(
            f"Stopped. {progress.finished_designs} are finished and kept in {store}; the same command "
            "continues where it stopped."
        )
    return table


@with_output(tables=True, source="study")
def plan(study: StudyArgument, *, out: Output) -> None:
    """List the designs of a study without computing them."""
    from crankfem.analyses.study.planned_designs import PlannedDesigns
    from crankfem.files.engine.throw_file import load_study

    planned = PlannedDesigns.of(load_study(study).planned)
    if out.json:
        print_json(planned)
        return
    *parts, answer = planned.parts()
    out.show(parts, answer)


@with_output(files=True, source="study")
def designs(
    study: StudyArgument,
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder to write to.")],
    mesh: Annotated[
        str, typer.Option(metavar="KIND", help="Mesh (inp, msh, vtu, ...) or solid (step) of each.")
    ] = "step",
    store: StoreOption = STORE,
    *,
    out: Output,
) -> None:
    """Write a study's designs for other solvers: a table, and a file of each design."""
    from crankfem.analyses.study.studies import TABLE, check_kind, export_designs
    from crankfem.files.engine.throw_file import load_study
    from crankfem.files.reading.data_files import input_path
    from crankfem.jobs.outputs import make_output_folder
    from regression.runs.study import known_designs

    check_kind(mesh)
    planned = known_designs(store, load_study(study))
    protect(input_path(study), store)
    made = make_output_folder("FOLDER", folder, [TABLE], "table")
    assert made is not None
    with console.RunProgress(out.quiet) as progress:
        progress.step("Writing the designs")
        written = export_designs(
            planned, made, mesh, lambda done, total: progress.design(done, total, None)
        )
    _print(written, written.parts(), out)


@with_output()
def import_(
    study: StudyArgument,
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="CSV table of earlier or measured results, or another store."
        ),
    ],
    store: StoreOption = STORE,
    alone: Annotated[
        bool,
        typer.Option(
            "--alone", help="The study will compute nothing: lines need not have all responses."
        ),
    ] = False,
    *,
    out: Output,
) -> None:
    """Import results into the store of a study; none of its own is replaced."""
    from crankfem.files.engine.throw_file import load_study
    from regression.runs.study import import_results

    imported = import_results(load_study(study), store, file, alone=alone)
    if imported.damaged:
        console.print_warning(f"{imported.damaged}.")
    _print(imported, imported.parts(), out)


@with_output(files=True)
def results(
    store: StoreArgument,
    file: Annotated[Path, typer.Argument(metavar="TABLE.csv", help=".csv or .parquet to write.")],
    study: StudyOption = None,
    *,
    out: Output,
) -> None:
    """Write all results of a study as a table."""
    from crankfem.analyses.study.studies import study_key
    from crankfem.jobs.outputs import check_writable
    from regression.runs.exchange import check_export, export_table
    from regression.runs.study import read_study

    check_export(file)
    check_writable(file, "table", store, name=str(file))
    written = export_table(read_study(store, study_key(study)), file)
    _print(written, written.parts(), out)


@with_output()
def verify(store: StoreArgument, *, out: Output) -> None:
    """Verify a store: its file, the checksum of each row, every study's plan."""
    from regression.runs.study import check_store

    check = check_store(store)
    _print(check, check.parts(), out)
    if not check.sound:
        remedy = (
            "use a copy of it, or give a new file name"
            if check.file_damage
            else "the next run of a study computes its damaged designs again"
        )
        console.exit_by_verdict(f"Error: {store} is damaged; {remedy}.", EXIT_INPUT)
