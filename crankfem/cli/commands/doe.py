"""Designs of experiments."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankbase.outputs import protect
from crankbase.quantity import parse_quantity
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, WorkersOption, with_output
from crankfem.cli.console import print_json
from crankfem.jobs.exit_codes import EXIT_INPUT

if TYPE_CHECKING:
    from regression.plans.plan import StudyPlan
    from regression.runs.study import StoreCheck, StudyCheck
    from regression.runs.study_table import StudyTable

# Damaged rows that are shown; --json has all.
MOST_ROWS = 10
ENGINE_FILE, STORE = ".toml", Path("runs.sqlite")
# Fewer held-out designs leave most of the box unseen.
FEW_HELD_OUT = 5


@with_output(files=True)
def doe(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY.toml",
            help="File with the sections throw and study; with --check also a store.",
            autocompletion=completion.engines,
        ),
    ],
    store: Annotated[Path, typer.Option(help="SQLite file of results.")] = STORE,
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
    import_: Annotated[
        list[Path] | None,
        typer.Option(
            "--import",
            metavar="FILE",
            help="CSV table of earlier or measured results, or another store; may be repeated.",
        ),
    ] = None,
    export: Annotated[
        Path | None,
        typer.Option(
            help="Table of all results to write: .csv or .parquet; with --mesh a folder of designs."
        ),
    ] = None,
    mesh: Annotated[
        str | None,
        typer.Option(
            metavar="KIND",
            help="For other solvers: write a table of the designs and a mesh (inp, msh, vtu, ...) or solid "
            "(step) of each into the folder of --export, and compute nothing.",
        ),
    ] = None,
    more: Annotated[
        int,
        typer.Option(
            help="Number of further runs to place where the equations are worst. The store keeps them; "
            "repeating the same number adds none."
        ),
    ] = 0,
    no_compute: Annotated[
        bool, typer.Option("--no-compute", help="Compute nothing; fit stored and imported results.")
    ] = False,
    plan: Annotated[
        bool, typer.Option("--plan", help="Show the plan without computing it.")
    ] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Verify the store's file and the checksum of each row.")
    ] = False,
    *,
    out: Output,
) -> None:
    """Run a design of experiments, or continue it where it stopped."""
    from crankfem.cli.tables.study_tables import (
        plan_record,
        print_comparisons,
        print_fits,
        print_plan,
    )
    from crankfem.files.engine.throw_file import load_study
    from crankfem.files.reading.data_files import input_path
    from crankfem.jobs.outputs import check_distinct_files, check_writable
    from regression.runs.exchange import FORMATS, check_export, export_table
    from regression.runs.store import damaged_rows_warning
    from regression.runs.study import read_study

    limits = {
        "time_limit": _quantity(time_limit, "s", "--time-limit"),
        "memory_limit": _quantity(memory_limit, "byte", "--memory-limit"),
    }
    if check:
        if plan or no_compute or more or mesh or export is not None or import_:
            raise InputError("--check: given with another task; allowed are --check and --store.")
        _check_store(study, store, out)
        return
    read = load_study(study)
    if plan and (export is not None or import_ or mesh or more):
        raise InputError(
            "--plan: given with --export, --import, --mesh or --more; allowed is --plan alone, because it "
            "computes, reads and writes nothing."
        )
    if more and no_compute:
        raise InputError("--more: given with --no-compute; allowed is one of the two.")
    if plan:
        if out.json:
            print_json(plan_record(read.planned))
        else:
            print_plan(read.planned)
        return
    if mesh is not None:
        if export is None or import_ or more:
            raise InputError(
                "--mesh: given without --export, or with --import or --more; it needs --export FOLDER, and "
                "computes and imports nothing."
            )
        if export.suffix in FORMATS:
            raise InputError(
                f"--export: given {export} with --mesh; allowed is a folder, because each design has a file."
            )
        protect(input_path(study), store)
        _export_designs(read, store, export, mesh, out)
        return
    files = [store, input_path(study), *(import_ or ())]
    if export is not None:
        check_export(export)
        check_distinct_files({"--store": store, "--export": export})
        check_writable(export, "table", *files, name=f"--export {export}")
    for file in import_ or ():
        _import(read, store, file, no_compute, out.quiet)
    if no_compute:
        table = read_study(store, read.key)
    else:
        table = _run(read, store, workers, {"dask": dask, "more": more, **limits}, out.quiet)

    def print_progress(text: str) -> None:
        # With --json nothing but the results may stand on standard output.
        if out.json:
            console.print_note(text, out.quiet)
        else:
            console.print_line(text)

    print_progress(_summary(table, store))
    if table.damaged:
        console.print_warning(f"{damaged_rows_warning(table.damaged, store)}; import them again.")
    held_out = int(table.held_out.sum())
    if 0 < held_out < FEW_HELD_OUT:
        print_progress(
            f"Note: only {held_out} held-out designs judge the fits; with fewer than {FEW_HELD_OUT} their "
            "largest error says little about the space between the runs."
        )
    if export is not None:
        count = export_table(table, export)
        print_progress(f"{count} rows written to {export}.")
    from crankfem.analyses.study.fit_records import study_record
    from crankfem.analyses.study.studies import fitted

    fits = fitted(table)
    record = study_record(table, fits.fits, fits.model)
    if out.json:
        print_json(record)
        return
    print_fits(record["fits"])
    print_comparisons(record["compared"])


def _summary(table: "StudyTable", store: Path) -> str:
    """State in a line what the study contains."""
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
    return f"{text}."


def _quantity(text: str | None, unit: str, option: str) -> float | None:
    return None if text is None else parse_quantity(text, unit, option)


def _export_designs(plan: "StudyPlan", store: Path, folder: Path, kind: str, out: Output) -> None:
    """Write a study's designs for other solvers, including those added in its store."""
    from crankfem.analyses.study.studies import TABLE, check_kind, export_designs
    from crankfem.jobs.outputs import make_output_folder
    from regression.runs.study import known_designs

    check_kind(kind)
    planned = known_designs(store, plan)
    made = make_output_folder("--export", folder, [TABLE], "table")
    assert made is not None
    with console.RunProgress(out.quiet) as progress:
        progress.step("Writing the designs")
        export = export_designs(
            planned, made, kind, lambda done, total: progress.design(done, total, None)
        )
    if out.json:
        print_json(
            {
                "table": str(export.table),
                "files": [str(file) for file in export.files],
                "written": export.written,
                "failures": {str(file): reason for file, reason in export.failures.items()},
            }
        )
        return
    present = len(export.files) - len(export.failures)
    console.print_line(
        f"{export.table} written: {len(export.files)} designs, of which {present} have a file in the folder ("
        f"{export.written} written now); lengths in m."
    )
    for file, reason in export.failures.items():
        console.print_line(f"Not written: {file}: {reason}")


def _import(plan: "StudyPlan", store: Path, file: Path, alone: bool, quiet: bool) -> None:
    from regression.runs.study import import_results

    got = import_results(plan, store, file, alone=alone)
    left_out = f"; {got.left_out} do not belong to this study" if got.left_out else ""
    unused = f"; {got.coinciding} at the study's own designs are not used" if got.coinciding else ""
    console.print_note(
        f"{file}: {got.designs} finished designs and {got.rows} further rows imported{left_out}{unused}.",
        quiet,
    )
    if got.damaged:
        console.print_warning(f"{got.damaged}.")


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


def _check_store(study: str, store: Path, out: Output) -> None:
    """Check a store, or that of a study file."""
    from crankfem.files.engine.throw_file import load_study
    from regression.runs.study import check_store

    if (path := Path(study)).is_file() and path.suffix != ENGINE_FILE:
        if store != STORE:
            raise InputError(
                f"--store: given {store} together with the store {path}; allowed is one of them."
            )
        store = path
    else:
        load_study(study)
    check = check_store(store)
    if out.json:
        print_json(check)
    else:
        _print_check(check)
    if not check.sound:
        remedy = (
            "use a copy of it, or give a new file name"
            if check.file_damage
            else "the next run of a study computes its damaged designs again"
        )
        console.exit_by_verdict(f"Error: {store} is damaged; {remedy}.", EXIT_INPUT)


def _print_check(check: "StoreCheck") -> None:
    if check.file_damage:
        console.print_line(f"SQLite cannot trust the file: {check.file_damage}.")
        return
    counts = ", ".join(f"{number} {status}" for status, number in check.designs.items() if number)
    rows = f"{len(check.damaged_rows)} damaged" if check.damaged_rows else "no row damaged"
    console.print_line(f"{check.store}: {counts or 'no design computed'}; {rows}.")
    for place, why in list(check.damaged_rows.items())[:MOST_ROWS]:
        console.print_line(f"- {place}: {why}.")
    if len(check.damaged_rows) > MOST_ROWS:
        console.print_line(
            f"... and {len(check.damaged_rows) - MOST_ROWS} more; --json has them all."
        )
    for study in check.studies:
        console.print_line(_study_text(study))
    if not check.studies:
        console.print_line(
            f"It holds no study: run one from its file, crankfem doe STUDY.toml --store {check.store}."
        )


def _study_text(study: "StudyCheck") -> str:
    name = f"Study {study.study[:6]}"
    if study.designs is None:
        return (
            f"{name}: its plan is damaged; run it from its file, and its finished designs are used."
            if study.damaged
            else f"{name}: of another version of the finite element model."
        )
    text = f"{name}: {study.designs} designs, {study.missing} without a result"
    return f"{text}; {study.damaged} is damaged." if study.damaged else f"{text}."
