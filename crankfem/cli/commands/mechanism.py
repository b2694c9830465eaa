"""Forces, loads, torque and balance of an engine's crank mechanism."""

from pathlib import Path
from typing import Annotated, Any, cast

import typer

from crankfem.cli import console
from crankfem.cli.commands.options import (
    EngineArgument,
    Output,
    SpeedOption,
    with_output,
)
from crankfem.cli.console import print_json
from dynamics.mechanism.rod_model_names import ROD_MODELS


@with_output(files=True, units=True)
def mechanism(
    engine: EngineArgument,
    speed: SpeedOption = None,
    model: Annotated[
        str, typer.Option(help=f"Of the rods' masses, one of: {', '.join(ROD_MODELS)}.")
    ] = "rigid",
    motored: Annotated[
        bool, typer.Option("--motored", help="Turn the engine without combustion.")
    ] = False,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write all forces over the cycle.")
    ] = None,
    pictures: Annotated[
        str | None, typer.Option(metavar="FOLDER", help="Write load diagrams and hodographs.")
    ] = None,
    *,
    out: Output,
) -> None:
    """Forces in the crank mechanism, load diagrams of the bearings, and the balance of the engine."""
    from crankbase.checks.choices import check_choice
    from crankfem.analyses.mechanism.balance_records import balance_record, hinged_rods_record
    from crankfem.analyses.mechanism.mechanism_records import force_columns, mechanism_record
    from crankfem.analyses.mechanism.mechanism_run import run_mechanism
    from crankfem.cli.angle_and_speed import parse_speed
    from crankfem.cli.column_file import write_columns
    from crankfem.cli.tables.mechanism_tables import (
        print_balance,
        print_hinged_rods,
        print_mechanism,
    )
    from crankfem.files.engine.input_files import mechanism_inputs
    from crankfem.files.engine.mechanism_file import load_mechanism
    from crankfem.jobs.outputs import check_outputs
    from crankfem.report.interactive.mechanism_plots import MECHANISM

    loaded, turning = load_mechanism(engine), parse_speed(speed)
    check_choice("--model", model, ROD_MODELS, "these are the models of a rod's mass")
    inputs = mechanism_inputs(loaded)
    folder = check_outputs(csv, pictures, *inputs, names=MECHANISM.files())
    run = run_mechanism(loaded, turning, cast(Any, model), motored=motored)
    record = mechanism_record(run)
    balanced, hinged = balance_record(run.balance), hinged_rods_record(run.hinged_rods)
    if csv is not None:
        write_columns(csv, *force_columns(run))
    made = [] if folder is None else MECHANISM.draw(folder, run)
    if out.json:
        print_json(
            record
            | {
                "balance": balanced,
                "hinged_rods": hinged,
                "pictures": [str(path) for path in made],
            }
        )
        return
    print_mechanism(record, out.units)
    print_balance(balanced, out.units)
    if hinged:
        print_hinged_rods(hinged, out.units)
    if csv is not None:
        console.output.print(f"Forces: {csv}", soft_wrap=True)
    if made:
        console.output.print(f"Pictures: {pictures} ({len(made)} files)", soft_wrap=True)
