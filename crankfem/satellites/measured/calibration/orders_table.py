"""Measured orders from a table with speed, order, amplitude and phase, or from a record of a wheel."""

from pathlib import Path

import numpy as np

from crankbase.errors import InputError, quoted
from crankbase.exported_table import ExportedTable, read_exported_table
from crankbase.input_file import InputFile
from crankbase.quantity import parse_quantity
from crankbase.units import NoUnitError, OtherKindError, size_in
from crankfem.files.sections.engine_sections import Engine
from crankfem.satellites.measured.measured_orders import UNITS, Measurand, MeasuredOrders
from crankfem.satellites.measured.measurement import load, refuse_other_speeds
from crankfem.satellites.measured.wheel_constants import without_wheel

COLUMNS = ("speed", "order", "amplitude", "phase", "scatter")
# Two lines are of one window if their speeds differ by less, as a share.
SAME_SPEED = 1e-9
DEGREES = {"deg": np.pi / 180.0, "°": np.pi / 180.0, "rad": 1.0}


def read_orders(
    path: str | Path,
    place: str,
    *,
    wheel: bool = True,
    overlap: float = 0.0,
    zero_known: bool = True,
) -> MeasuredOrders:
    """Read a table of orders over the speed, a line for each speed and order.

    Parameters
    ----------
    path : path
        CSV or spreadsheet with the columns speed [1/min], order, amplitude [rad, deg, N m ...], phase [deg or
        rad] and scatter, in any order.
    place : str
        Mass of the chain, or element for a torque, where it was measured.
    wheel : bool, optional
        Whether angles of whole orders hold the unknown constants of a toothed wheel.
    overlap : float, optional
        Share of its revolutions that a window has in common with the next one.
    zero_known : bool, optional
        Whether phases count from the angle zero of the engine file.

    Raises
    ------
    InputError
        If a column is missing or has another kind of unit, or a speed lacks an order that others have.
    """
    if not 0.0 <= overlap < 1.0:
        raise InputError(
            f"overlap: given {overlap:g}; allowed is a share from 0 to below 1, because windows with all "
            "in common are one."
        )
    table = read_exported_table(InputFile(Path(path)), "table of orders")
    names = [heading.casefold().partition("[")[0].strip() for heading in table.headings]
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise InputError(
            f"{path}: has no column {missing[0]}; allowed are {', '.join(COLUMNS)} in the header, with "
            "units, because each line is one order at one speed."
        )
    at = {name: names.index(name) for name in COLUMNS}
    wrong = [line for name in COLUMNS for line in table.wrong_cells(at[name], name)]
    if wrong:
        raise InputError("\n".join(wrong))
    quantity, size = _quantity(path, table, at["amplitude"])
    _, scatter_size = _quantity(path, table, at["scatter"])
    turn = DEGREES.get(table.units[at["phase"]].casefold())
    if turn is None:
        raise InputError(
            f"{path}: phase: given in {quoted(table.units[at['phase']])}; allowed are deg and rad, because "
            "it is an angle."
        )
    speeds = table.numbers(at["speed"]) * _size(path, table, at["speed"], "rad/s", "speed")
    orders = table.numbers(at["order"])
    amplitude = (
        size * table.numbers(at["amplitude"]) * np.exp(1j * turn * table.numbers(at["phase"]))
    )
    scatter = scatter_size * table.numbers(at["scatter"])
    # Lines of one window follow each other; speeds may repeat.
    begins = np.flatnonzero(
        (np.abs(np.diff(speeds, prepend=-1.0)) > SAME_SPEED * speeds)
        | (np.diff(orders, prepend=np.inf) <= 0.0)
    )
    count, every = begins.size, np.unique(orders)
    if orders.size != count * every.size or np.any(orders.reshape(count, -1) != every):
        raise InputError(
            f"{path}: given {orders.size} lines of {count} speeds and {every.size} orders; allowed are all "
            "orders, ascending, at each speed, because they are fitted together."
        )
    apart = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    shape = count, every.size
    return MeasuredOrders(
        orders=every,
        speed=speeds[begins],
        amplitude=amplitude.reshape(shape),
        scatter=scatter.reshape(shape),
        place=place,
        quantity=quantity,
        correlation=np.maximum(0.0, 1.0 - apart * (1.0 - overlap)),
        ramp=np.zeros(count),
        wheel_constant=(every % 1.0 == 0.0) & wheel & (quantity == "angle"),
        cycle=2 if np.any(every % 1.0 == 0.5) else 1,
        zero_known=zero_known,
        method=f"table {Path(path).name}",
    )


def wheel_orders(
    engine: Engine, path: str, place: str, teeth: str, mark_angle: str | None, trusted: bool
) -> MeasuredOrders:
    """Return the orders of a record of a toothed wheel on an engine.

    Parameters
    ----------
    engine : Engine
        Whose strokes make the cycle and whose speeds the record must have.
    mark_angle : str or None
        Shaft angle when the first tooth behind the gap passes, with its unit.
    trusted : bool
        Whether the wheel has no constants at whole orders.

    Raises
    ------
    InputError
        If the record cannot be read, or does not fit what is said of it.
    """
    angle = None if mark_angle is None else parse_quantity(mark_angle, "deg", "--mark-angle")
    measurement = load(path, teeth, place=place, cycle=engine.strokes // 2, mark_angle_deg=angle)
    refuse_other_speeds(measurement, engine.lowest_speed, engine.highest_speed)
    orders = measurement.orders()
    none = np.zeros(orders.orders.size)
    return without_wheel(orders, none) if trusted else orders


def _quantity(path: str | Path, table: ExportedTable, column: int) -> tuple[Measurand, float]:
    """Return what a column of amplitudes is, and the size of its unit in SI."""
    unit = table.units[column] if table.units else ""
    if unit.casefold() in DEGREES:
        return "angle", DEGREES[unit.casefold()]
    for quantity, si in UNITS.items():
        try:
            return quantity, size_in(unit, si)[0]
        except (NoUnitError, OtherKindError):
            continue
    raise InputError(
        f"{path}: {table.headings[column]}: given in {quoted(unit)}; allowed are {', '.join(UNITS.values())} "
        "and deg, because these are measured."
    )


def _size(path: str | Path, table: ExportedTable, column: int, si: str, name: str) -> float:
    unit = table.units[column] if table.units else ""
    try:
        return size_in(unit, si)[0]
    except (NoUnitError, OtherKindError):
        raise InputError(
            f"{path}: {name}: given in {quoted(unit)}; allowed is a unit like {si} or 1/min."
        ) from None
