"""The command `measured`."""

from typing import Annotated

import typer

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json

ENDINGS = (".csv", ".txt", ".tdms", ".mf4", ".uff", ".mat", ".h5", ".parquet")
TABLE = "measured_orders.csv"


@with_output(files=True, units=True, source="engine")
def measured(
    record: Annotated[
        str,
        typer.Argument(
            metavar="RECORD",
            help="Record of an instrument: times of pulses, or the voltage of a toothed wheel.",
            autocompletion=completion.files(*ENDINGS),
        ),
    ],
    teeth: Annotated[
        str,
        typer.Option(metavar="60-2", help="Teeth of the wheel: 120, 60-2 missing, 60+1 double."),
    ],
    engine: Annotated[
        str | None,
        typer.Option(
            metavar="ENGINE.toml",
            help="Engine whose calculated orders are compared; takes some seconds.",
            autocompletion=completion.engines,
        ),
    ] = None,
    at: Annotated[
        str,
        typer.Option(
            metavar="PLACE", help='Mass of the chain, or element for a torque, like "free end".'
        ),
    ] = "",
    orders: Annotated[
        str | None, typer.Option(metavar="3,4.5,6", help="Orders; by default those up to 12.")
    ] = None,
    wheel: Annotated[
        str | None, typer.Option(metavar="CHANNEL", help="Channel of the wheel, among several.")
    ] = None,
    signal: Annotated[
        str | None,
        typer.Option(metavar="CHANNEL", help="Channel of another sensor, such as a torque."),
    ] = None,
    mark_angle: Annotated[
        str | None,
        typer.Option(
            metavar='"84 deg"',
            help="Shaft angle of the engine file when the first tooth behind the mark passes.",
        ),
    ] = None,
    falling: Annotated[
        bool, typer.Option("--falling", help="Take the falling edges of a voltage.")
    ] = False,
    rate: Annotated[
        float | None,
        typer.Option(help="Samples in a second [1/s], if the record has no time."),
    ] = None,
    strokes: Annotated[
        int | None,
        typer.Option(help="Strokes per cycle without an engine, 2 or 4.", show_default="4"),
    ] = None,
    csv: Annotated[
        str | None,
        typer.Option(metavar="FOLDER", help="Write the orders as a table, which calibrate reads."),
    ] = None,
    pictures: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER", help="Write the map of orders, and the overlay with its page."
        ),
    ] = None,
    report: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder of a finished run of the engine: its report gets the overlay.",
        ),
    ] = None,
    *,
    out: Output,
) -> None:
    """Find the orders of vibration in a record, and compare them with those calculated of an engine."""
    from pathlib import Path

    from crankbase.outputs import check_output
    from crankbase.written_quantity import parse_quantity
    from crankfem.analyses.record import with_units
    from crankfem.files.engine.engine_file import load_engine
    from crankfem.jobs.outputs import check_outputs, make_output_folder
    from crankfem.satellites.measured.calibration.orders_table import write_orders
    from crankfem.satellites.measured.measurement import (
        load,
        refuse_other_places,
        refuse_other_speeds,
    )
    from crankfem.satellites.measured.overlay import overlay
    from crankfem.satellites.measured.reporting import FinishedRun
    from crankfem.satellites.measured.run import MAP, OVERLAY, PAGE, MeasuredVibration

    file = None if engine is None else load_engine(engine)
    if file is not None and at:
        refuse_other_places(file, [at])
    if strokes not in (None, 2, 4) or (strokes is not None and file is not None):
        raise InputError(
            f"--strokes: given {strokes}; allowed are 2 and 4 without --engine, because an engine file has "
            "its own."
        )
    if report is not None and file is None:
        raise InputError(
            "--report: given without --engine; allowed are both, because it shows measured orders over those "
            "calculated."
        )
    cycle = (file.engine.strokes if file is not None else strokes or 4) // 2
    check_outputs(None, None, Path(record))
    tables = make_output_folder("--csv", csv, [TABLE], "table")
    drawn = make_output_folder("--pictures", pictures, [MAP, *([] if file is None else [OVERLAY])])
    if drawn is not None and file is not None:
        check_output(drawn / PAGE, "report")
    finished = None
    if report is not None and file is not None:
        finished = FinishedRun.of(Path(report), file)
    with console.RunProgress(out.quiet) as progress:
        progress.step("Reading the record")
        measurement = load(
            record,
            teeth,
            wheel=wheel,
            signal=signal,
            place=at,
            cycle=cycle,
            mark_angle_deg=None
            if mark_angle is None
            else parse_quantity(mark_angle, "deg", "--mark-angle"),
            edge="falling" if falling else "rising",
            rate=rate,
        )
        if file is not None:
            refuse_other_speeds(measurement, file.engine.lowest_speed, file.engine.highest_speed)
        progress.step("Fitting orders")
        measured_orders = measurement.orders(None if orders is None else _numbers(orders))
        beside = None if file is None else overlay(measured_orders, file, progress.step)
        run = MeasuredVibration.of(Path(record).name, measured_orders, beside)
        written = [] if drawn is None else run.draw(drawn, progress.step)
        if finished is not None:
            progress.step("Writing the report")
            written.append(finished.add(run))
        progress.finish()
    if tables is not None:
        written.append(write_orders(tables / TABLE, measured_orders))
    if out.json:
        print_json(with_units(run))
        return
    out.show(run.parts(out.units), *(f"{path} written." for path in written), run.conclusion)


def _numbers(text: str) -> list[float]:
    """Return the orders of a text."""
    try:
        return sorted({float(part) for part in text.split(",")})
    except ValueError:
        raise InputError(
            f"--orders: given {text!r}; allowed are numbers with commas between them, like 3,4.5,6."
        ) from None
