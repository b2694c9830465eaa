"""The main job, and its report written again."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankbase.errors import InputError
from crankbase.table import Main, Table
from crankfem.cli import console
from crankfem.cli.commands.options import (
    EngineArgument,
    Output,
    SavedModelOption,
    StrictOption,
    WorkersOption,
    check_has_limits,
    exit_unless_acceptable,
    with_output,
)
from crankfem.cli.console import print_json

if TYPE_CHECKING:
    from crankbase.table import OutputUnits
    from crankfem.analyses.run_results import RunResults


@with_output(files=True, units=True, source="engine")
def run(
    engine: EngineArgument,
    output: Annotated[
        str | None, typer.Option(help="Folder for the results; NAME-results by default.")
    ] = None,
    workers: WorkersOption = 2,
    model: SavedModelOption = None,
    strict: StrictOption = False,
    *,
    out: Output,
) -> None:
    """Run everything: throw, formulas, study, vibration, and a report, into one folder.

    With --quiet only the path of the report is printed.
    """
    from crankfem.analyses.findings import verdict_line
    from crankfem.jobs.pipeline import run_engine
    from crankfem.jobs.run_computation import RunInputs, read_inputs

    source: str | RunInputs = engine
    if strict or model is not None:
        source = read_inputs(engine, model)
        if strict:
            check_has_limits(source.engine_file)
    progress = console.RunProgress(out.quiet)
    try:
        with progress:
            made = run_engine(source, output, workers=workers, progress=progress)
            progress.finish()
    except KeyboardInterrupt:
        if not progress.total:  # there is no study, or nothing of it is known yet
            raise
        console.exit_interrupted(
            f"Stopped. {progress.finished_designs} are finished and kept; the same command reuses them."
        )
    if out.json:
        print_json(made.results)
    elif out.quiet:
        console.print_path(str(made.report))
    else:
        verdict = verdict_line(made.results.vibration, made.results.strength)
        parts = _parts(made.results, out.units)
        out.show(parts, f"Report: {made.report}", out.units.written(verdict))
    if strict:
        exit_unless_acceptable(made.results.vibration)


def _parts(results: "RunResults", units: "OutputUnits") -> Iterator[Table | str]:
    from crankbase.sentences import joined
    from crankfem.analyses.findings import finding_parts
    from crankfem.report.summary import engine_facts, worst_tables

    yield from worst_tables(results.vibration, units)
    yield from finding_parts(results.findings, units)
    yield Main(units.written(f"{results.engine.name}: {joined('; ', engine_facts(results))}."))
    for part in _details(results, units):
        yield str(part) if isinstance(part, str) else replace(part, main=False)


def _details(results: "RunResults", units: "OutputUnits") -> Iterator[Table | str]:
    from crankfem.analyses.run_results import NamedThrow
    from crankfem.analyses.vibration.tables import vibration_parts
    from crankfem.cli.tables.throw_tables import one_throw_parts

    throws: Mapping[str, Any] = results.throws or {"": results}
    for name, throw in throws.items():
        if isinstance(throw, NamedThrow):
            cranks = "crank" if len(throw.cranks) == 1 else "cranks"
            yield f"Throw {name}: {cranks} {', '.join(map(str, throw.cranks))}."
        yield throw.throw.loaded_table(units)
        yield from throw.throw.parts(units)
        yield from one_throw_parts(throw.formulas, units=units)
    if results.study is not None:
        yield from results.study.main_parts()
    yield from vibration_parts(results.vibration, units)


@with_output(files=True)
def report(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder of a finished run.")],
    *,
    out: Output,
) -> None:
    """Write the report of a finished run again, from its results and pictures."""
    from jinja2 import TemplateError

    from crankbase.outputs import check_output, is_regular_file, protect, recording_run_files
    from crankfem.analyses.run_results import RunResults
    from crankfem.jobs.run_files import PICTURES, REPORT, RESULTS
    from crankfem.report.writing import render_report, write_report_text

    path = folder / RESULTS
    if not is_regular_file(path):
        raise InputError(
            f"{folder}: has no {RESULTS}; give the folder that crankfem run has written."
        )
    protect(path)
    with recording_run_files():
        check_output(folder / REPORT, "report")
    content = path.read_bytes()
    try:
        text, unread = render_report(RunResults.from_json(content), folder / PICTURES)
    except (
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        ArithmeticError,
        TemplateError,
    ) as error:
        raise InputError(
            f"{path}: is not what crankfem run writes ({error}); run it again."
        ) from None
    made = write_report_text(folder / REPORT, text)
    if unread is not None:
        console.print_note(f"Note: {unread}", out.quiet)
    if out.json:
        print_json({"report": str(made)})
    else:
        console.print_path(str(made) if out.quiet else f"Report: {made}")
