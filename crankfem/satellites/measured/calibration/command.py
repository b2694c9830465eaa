"""The command `calibrate`."""

from typing import Annotated

import typer

from crankfem.cli import console
from crankfem.cli.commands.options import EngineArgument, Output, with_output
from crankfem.jobs.exit_codes import EXIT_INPUT


@with_output(units=True, files=True, source="engine")
def calibrate(
    engine: EngineArgument,
    records: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORD...",
            help="Records of a toothed wheel (--teeth), or tables of orders: columns speed, order, "
            "amplitude, phase and scatter, with units.",
        ),
    ],
    at: Annotated[
        list[str],
        typer.Option(
            metavar="PLACE",
            help='Mass, or element for a torque, of each record in turn, like "free end"; then of --predict.',
        ),
    ],
    teeth: Annotated[
        str | None, typer.Option(metavar="60-2", help="Teeth of the wheel less those of its gap.")
    ] = None,
    mark_angle: Annotated[
        str | None,
        typer.Option(
            metavar='"12 deg"', help="Shaft angle when the first tooth behind the gap passes."
        ),
    ] = None,
    move: Annotated[
        list[str] | None,
        typer.Option(
            metavar="GROUP=TOLERANCE",
            help="What may move within the maker's tolerance, like flywheel.inertia=5% or "
            "torsional_compliance=10%; by default what the section ranges of the file has.",
        ),
    ] = None,
    gains: Annotated[
        bool, typer.Option("--gains", help="Find the gain of each cylinder, and a weak one.")
    ] = False,
    predict: Annotated[
        list[str] | None,
        typer.Option(metavar="RECORD", help="One left out of the fit, to be predicted."),
    ] = None,
    trusted_wheel: Annotated[
        bool,
        typer.Option(
            "--trusted-wheel",
            help="Angles hold no constants of a toothed wheel at whole orders.",
        ),
    ] = False,
    overlap: Annotated[
        float | None,
        typer.Option(
            help="Of a table: share of its revolutions that a window has in common with the next.",
            show_default="that of the table",
        ),
    ] = None,
    zero_unknown: Annotated[
        bool,
        typer.Option(
            "--zero-unknown",
            help="Of a table: phases count from a mark, not from the engine's zero.",
        ),
    ] = False,
    profile: Annotated[
        bool, typer.Option("--profile", help="Find intervals by profile likelihood, too.")
    ] = False,
    sample: Annotated[
        bool,
        typer.Option(
            "--sample", help="Find intervals by samples of the posterior, too (crankfem[sampling])."
        ),
    ] = False,
    output: Annotated[
        str | None,
        typer.Option(metavar="FITTED.toml", help="Write the engine file with the fitted values."),
    ] = None,
    *,
    out: Output,
) -> None:
    """Fit an engine's values to measured orders; tell what they cannot, and the new verdict."""
    from crankbase.errors import InputError
    from crankfem.analyses.record import with_units
    from crankfem.files.engine.engine_file import load_engine
    from crankfem.satellites.measured.calibration.calibrated import calibrate as calibrated
    from crankfem.satellites.measured.calibration.groups import parsed_group
    from crankfem.satellites.measured.calibration.orders_table import read_orders, wheel_orders
    from crankfem.satellites.measured.calibration.told import calibration_parts
    from crankfem.satellites.measured.measured_orders import MeasuredOrders
    from crankfem.satellites.measured.measurement import refuse_other_places

    paths = [*records, *(predict or ())]
    if len(at) != len(paths):
        raise InputError(
            f"--at: given {len(at)} for {len(paths)} records; allowed is one for each, --predict last, "
            "because orders are compared where they were measured."
        )
    if len({*paths}) < len(paths):
        raise InputError(
            "records: given one twice; allowed is each once, because it would count twice."
        )
    if mark_angle is not None and teeth is None:
        raise InputError(
            "--mark-angle: given without --teeth; allowed are both, because it is that of a wheel's gap."
        )

    def measured(path: str, place: str) -> MeasuredOrders:
        if teeth is None:
            return read_orders(
                path,
                place,
                wheel=not trusted_wheel,
                overlap=overlap,
                zero_known=not zero_unknown,
            )
        return wheel_orders(file.engine, path, place, teeth, mark_angle, trusted_wheel)

    file = load_engine(engine)
    refuse_other_places(file, at)
    tables = {}
    with console.RunProgress(out.quiet) as progress:
        for path, place in zip(paths, at, strict=True):
            progress.step(f"Reading {path}")
            tables[path] = measured(path, place)
        made = calibrated(
            file,
            {path: tables[path] for path in records},
            dict(parsed_group(text) for text in move or ()),
            gains=gains,
            predict={path: tables[path] for path in predict or ()},
            output=output,
            profiles=profile,
            samples=sample,
            step=progress.step,
        )
        progress.finish()
    if out.json:
        console.print_json(with_units(made))
    else:
        *parts, answer = calibration_parts(made)
        out.show(parts, *(f"Written: {path}" for path in made.files), answer)
    if output is not None and not made.files:
        console.exit_by_verdict(
            f"Error: --output: {output} is not written, because the records do not fit.", EXIT_INPUT
        )
