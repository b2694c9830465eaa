"""Vibration of an engine, or of a chain that a file describes."""

from typing import Annotated

import typer

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import (
    Output,
    SavedModelOption,
    StrictOption,
    check_has_limits,
    exit_unless_acceptable,
    with_output,
)
from crankfem.cli.console import print_json


@with_output(files=True, units=True, source="engine")
def vibration(
    engine: Annotated[
        str,
        typer.Argument(
            metavar="ENGINE.toml",
            help="Engine file, name of a shipped engine, or a chain file (such as mwm-six).",
            autocompletion=completion.engines_and_chains,
        ),
    ],
    coupled: Annotated[
        bool,
        typer.Option(
            "--coupled", help="Also calculate the whole crankshaft; takes some seconds more."
        ),
    ] = False,
    run_up: Annotated[
        str | None,
        typer.Option(
            metavar='"10 s"',
            help="Simulate the torsional vibration while the speed rises to the highest in this time.",
        ),
    ] = None,
    csv: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER",
            help="Write amplitudes over the speed by kind, and the axial force over the cycle.",
        ),
    ] = None,
    pictures: Annotated[
        str | None,
        typer.Option(metavar="FOLDER", help="Write mode shapes, Campbell diagrams and amplitudes."),
    ] = None,
    slopes: Annotated[
        bool,
        typer.Option(
            "--slopes", help="Also print how results change with each dimension and element."
        ),
    ] = False,
    model: SavedModelOption = None,
    strict: StrictOption = False,
    *,
    out: Output,
) -> None:
    """Calculate natural frequencies, forced vibration over the speeds, and a verdict on limits."""
    from crankfem.files.engine.file_kinds import any_sections, file_kind

    content = any_sections(engine)
    if content is None or file_kind(content) == "chain":
        options = (run_up, csv, pictures, model)
        others = coupled or slopes or strict or any(option is not None for option in options)
        if others:
            raise InputError(
                f"{engine}: is a chain file, which has no cylinders; allowed with it are --json, --units and "
                "--quiet, because the other options are about what an engine excites."
            )
        from crankfem.analyses.shaft.chain_vibration import chain_vibration

        chain = chain_vibration(content or engine)
        if out.json:
            print_json(chain)
        else:
            *parts, answer = chain.parts()
            out.show(parts, answer)
        return
    from crankbase.outputs import protect
    from crankbase.results import units as result_units
    from crankfem.analyses.engine_mechanism import engine_inputs, input_warnings
    from crankfem.analyses.findings import finding_parts, verdict_line, vibration_findings
    from crankfem.analyses.shaft.chains import MOTION
    from crankfem.analyses.shaft.sources import with_model
    from crankfem.analyses.vibration.axial_cycle import axial_cycle_columns
    from crankfem.analyses.vibration.engine_excitation import refuse_forced_vibration
    from crankfem.analyses.vibration.run import engine_vibration
    from crankfem.analyses.vibration.tables import vibration_parts
    from crankfem.cli.console import write_columns
    from crankfem.files.engine.engine_file import load_engine
    from crankfem.jobs.outputs import make_output_folder
    from crankfem.report.summary import worst_tables

    if run_up is not None:
        from crankfem.analyses.vibration.run_up import parse_duration, picture_run_up
        from crankfem.analyses.vibration.run_up import run_up as turned_up

    duration = None if run_up is None else parse_duration(run_up)
    read = load_engine(content if model is None else with_model(content, model))
    with content.with_lines():
        refuse_forced_vibration(read)
    if strict:
        check_has_limits(read)
    if csv is not None or pictures is not None:
        protect(*(file.path for file in engine_inputs(read)))
    tables = make_output_folder(
        "--csv", csv, [f"{column}.csv" for column in (*MOTION, "axial_force")], "table"
    )
    drawn = None
    if pictures is not None:
        from crankfem.report.interactive.vibration import VIBRATION

        known = read.gas is not None or read.gas_map is not None
        there = [*(["forced"] if known else []), *(["whole"] if coupled else [])]
        names = [*VIBRATION.files(there), *([] if run_up is None else ["run_up.svg"])]
        drawn = make_output_folder("--pictures", pictures, names)
    console.print_warnings(input_warnings(read), out.units)
    with console.RunProgress(out.quiet) as progress:
        run = engine_vibration(read, coupled=coupled, step=progress.step)
        speed_up = None
        if duration is not None:
            progress.step("Running up")
            speed_up = turned_up(run, duration)
        if slopes:
            progress.step("Differentiating")
        changes = run.slopes() if slopes else None
        progress.finish()
    written = []
    if tables is not None:
        for kind, forced in (run.forced_by_kind or {}).items():
            written.append(tables / f"{kind}.csv")
            write_columns(written[-1], *forced.columns())
        if run.axial_force is not None:
            written.append(tables / "axial_force.csv")
            write_columns(written[-1], *axial_cycle_columns(run.axial_force))
    if drawn is not None:
        written += VIBRATION.draw(drawn, run)
        if speed_up is not None:
            written.append(drawn / "run_up.svg")
            picture_run_up(written[-1], run, speed_up)
    if out.json:
        from crankfem.analyses.record import with_units

        concluded = vibration_findings(run, read)
        record = with_units(run) | {
            "findings": [finding.to_record() for finding in concluded],
            "files": [str(path) for path in written],
        }
        record["units"] |= result_units(concluded, "findings.")
        if speed_up is not None:
            record["run_up"] = speed_up.to_record()
            record["units"] |= result_units(speed_up, "run_up.")
        if changes is not None:
            record["slopes"] = changes.to_record()
            record["units"] |= result_units(changes, "slopes.")
        print_json(record)
    else:
        asked = [] if speed_up is None else [*speed_up.parts(out.units)]
        asked += [] if changes is None else [*changes.parts()]
        parts = [*asked, *worst_tables(run, out.units), *vibration_parts(run, out.units)]
        parts += finding_parts(vibration_findings(run, read), out.units)
        files = (("Tables", csv, tables), ("Pictures", pictures, drawn))
        written_to = [
            f"{kind}: {folder} ({sum(path.parent == made for path in written)} files)"
            for kind, folder, made in files
            if made is not None
        ]
        out.show(parts, *written_to, out.units.written(verdict_line(run)))
    if strict:
        exit_unless_acceptable(run)
