"""Forces, loads, torque and balance of an engine's crank mechanism."""

from pathlib import Path
from typing import Annotated, cast

import typer

from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands.options import EngineArgument, Output, SpeedOption, with_output
from crankfem.cli.console import print_json
from dynamics.engine import ROD_MODELS, RodModelName

ROD_MODELS_FILE = "rod_models.svg"


@with_output(files=True, units=True)
def mechanism(
    engine: EngineArgument,
    speed: SpeedOption = None,
    model: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MODEL",
            help=f"Model of the rods' masses, one of: {', '.join(ROD_MODELS)}; give it twice to compare the "
            "crankpin loads.",
            show_default="rigid",
        ),
    ] = None,
    motored: Annotated[
        bool, typer.Option("--motored", help="Motor the engine without combustion.")
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
    """Calculate forces in the crank mechanism, bearing loads, and the balance of the engine."""
    from crankfem.analyses.mechanism.balance_records import (
        hinged_rods_record,
        mechanism_balance_record,
    )
    from crankfem.analyses.mechanism.mechanism_records import (
        acceleration_record,
        force_columns,
        mechanism_record,
    )
    from crankfem.analyses.mechanism.mechanism_run import hinged_group, run_mechanism
    from crankfem.analyses.mechanism.plots import plot_model_difference
    from crankfem.analyses.mechanism.rod_models import (
        model_difference,
        model_difference_record,
        rod_mass_records,
    )
    from crankfem.analyses.titles import at_speed
    from crankfem.cli.angle_and_speed import parse_speed
    from crankfem.cli.column_file import write_columns
    from crankfem.cli.tables.mechanism_tables import (
        print_balance,
        print_balanced_masses,
        print_hinged_rods,
        print_mechanism,
        print_rod_models,
    )
    from crankfem.files.engine.input_files import mechanism_inputs
    from crankfem.files.engine.mechanism_file import load_mechanism
    from crankfem.jobs.outputs import check_outputs
    from crankfem.report.interactive.mechanism import MECHANISM

    loaded, turning, models = load_mechanism(engine), parse_speed(speed), _rod_models(model)
    inputs = mechanism_inputs(loaded)
    names = [*MECHANISM.files(), *([ROD_MODELS_FILE] if len(models) == 2 else [])]
    folder = check_outputs(csv, pictures, *inputs, names=names)
    console.print_warnings(loaded.warnings, out.units)
    run = run_mechanism(loaded, turning, models[0], motored=motored)
    compared = None if len(models) == 1 else model_difference(run, models[1])
    record = mechanism_record(run) | {
        "rod_masses": rod_mass_records(run.layout),
        "model_difference": None if compared is None else model_difference_record(compared),
    }
    balanced, hinged = mechanism_balance_record(run), hinged_rods_record(run.hinged_rods)
    group = hinged_group(run.layout)
    pistons = acceleration_record(run.layout, run.speed, group) if group else None
    if csv is not None:
        write_columns(csv, *force_columns(run, compared))
    made = [] if folder is None else MECHANISM.draw(folder, run)
    if folder is not None and compared is not None:
        title = f"{compared.first.name}, {at_speed(loaded.name, run.speed)}"
        plot_model_difference(folder / ROD_MODELS_FILE, compared, title=title)
        made.append(folder / ROD_MODELS_FILE)
    if out.json:
        print_json(
            record
            | {
                "balance": balanced,
                "hinged_rods": hinged,
                "accelerations": pistons,
                "pictures": [str(path) for path in made],
            }
        )
        return
    print_mechanism(record, out.units)
    if model:
        print_rod_models(record, out.units)
    print_balanced_masses(balanced, out.units)
    print_balance(balanced, out.units)
    if pistons is not None:
        print_hinged_rods(hinged, pistons, out.units)
    if csv is not None:
        console.output.print(f"Forces: {csv}", soft_wrap=True)
    if made:
        console.output.print(f"Pictures: {pictures} ({len(made)} files)", soft_wrap=True)


def _rod_models(given: list[str] | None) -> list[RodModelName]:
    """Return the one model of the rods' mass, or the two to be compared."""
    models = given or ["rigid"]
    for model in models:
        check_choice("--model", model, ROD_MODELS, "these are the models of a rod's mass")
    if len(models) > 2 or len(set(models)) < len(models):
        raise InputError(
            f"--model: given {', '.join(models)}; allowed are one model or two different ones, because one "
            "is compared with the other."
        )
    return cast(list[RodModelName], models)
