"""Measured orders in a table with speed, order, amplitude and phase, or from a record of a wheel."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from crankbase.errors import InputError, quoted
from crankbase.exported_table import read_exported_table
from crankbase.input_file import InputFile
from crankbase.units import NoUnitError, OtherKindError, size_in
from crankbase.written_quantity import parse_quantity
from crankfem.files.sections.engine_sections import Engine
from crankfem.jobs.outputs import write_rows
from crankfem.satellites.measured.measured_orders import MEASURANDS, MeasuredOrders
from crankfem.satellites.measured.measurement import load, refuse_other_speeds
from crankfem.satellites.measured.records.units import read_unit
from crankfem.satellites.measured.wheel_constants import without_wheel

COLUMNS = ("speed", "order", "amplitude", "phase", "scatter")
# What else a table may tell: the change of the speed, what neighboring windows share, and another phase.
RAMP, OVERLAP, OF_MARK = "ramp", "overlap", "phase from mark"
# Two lines are of one window if their speeds differ by less, as a share.
SAME_SPEED = 1e-9


def write_orders(path: Path, measured: MeasuredOrders) -> Path:
    """Write a table as `read_orders` takes it, in SI; windows share what correlates their errors."""
    frame = measured.to_pandas()
    columns = dict(zip(frame, frame.to_numpy().T.tolist(), strict=True))
    columns[OVERLAP] = [max(0.0, 1.0 - measured.independent)] * len(frame)
    units = frame.attrs["units"] | {OVERLAP: "1"}
    heads = {"phase": "phase" if measured.zero_known else OF_MARK}
    rows = zip(*columns.values(), strict=True)
    names = [f"{heads.get(name, name)} [{units[name]}]" for name in columns]
    write_rows(path, names, ([f"{value:.12g}" for value in row] for row in rows))
    return path


def read_orders(
    path: str | Path,
    place: str,
    *,
    wheel: bool = True,
    overlap: float | None = None,
    zero_known: bool = True,
) -> MeasuredOrders:
    """Read a table of orders over the speed, a line for each speed and order.

    Parameters
    ----------
    path : path
        CSV or spreadsheet with the columns speed [1/min], order, amplitude [rad, deg, N m ...], phase [deg or
        rad] and scatter, in any order; perhaps ramp [rad/s^2], overlap, and "phase from mark" for phase.
    place : str
        Mass of the chain, or element for a torque, where it was measured.
    wheel : bool, optional
        Whether angles of whole orders hold the unknown constants of a toothed wheel.
    overlap : float, optional
        Share of its revolutions that a window has in common with the next one; by default that of the table.
    zero_known : bool, optional
        Whether phases count from the angle zero of the engine file; "phase from mark" never does.

    Raises
    ------
    InputError
        If a column is missing or has another kind of unit, or a speed lacks an order that others have.
    """
    table = read_exported_table(InputFile(Path(path)), "table of orders")
    names = [heading.casefold().partition("[")[0].strip() for heading in table.headings]
    of_mark = OF_MARK in names
    at = {name: names.index(name) for name in (*COLUMNS, RAMP, OVERLAP) if name in names}
    at |= {"phase": names.index(OF_MARK)} if of_mark else {}
    missing = [name for name in COLUMNS if name not in at]
    if missing:
        raise InputError(
            f"{path}: has no column {missing[0]}; allowed are {', '.join(COLUMNS)} in the header, with "
            "units, because each line is one order at one speed."
        )
    wrong = [line for name in at for line in table.wrong_cells(at[name], name)]
    if wrong:
        raise InputError("\n".join(wrong))
    listed = {name: table.numbers(place) for name, place in at.items()}
    shared = float(listed[OVERLAP][0]) if overlap is None and OVERLAP in at else overlap or 0.0
    if not 0.0 <= shared < 1.0:
        raise InputError(
            f"overlap: given {shared:g}; allowed is a share from 0 to below 1, because windows with all "
            "in common are one."
        )

    def unit(name: str, kinds: Sequence[str], allowed: str) -> tuple[str, float]:
        """Return the unit in SI of a column, of these kinds, and the size of its own."""
        written = table.units[at[name]] if table.units else ""
        for si in kinds:
            with suppress(NoUnitError, OtherKindError):
                return si, size_in(read_unit(written)[0], si)[0]
        raise InputError(f"{path}: {name}: given in {quoted(written)}; allowed {allowed}.")

    kinds = tuple(MEASURANDS)
    si, size = unit("amplitude", kinds, f"are {', '.join(kinds)} and deg, which are measured")
    quantity = MEASURANDS[si]
    _, scatter_size = unit("scatter", (si,), f"is {si}, or another unit of the amplitude's kind")
    _, turn = unit("phase", ("rad",), "are deg and rad, because it is an angle")
    _, rate = unit("speed", ("rad/s",), "is a unit like rad/s or 1/min")
    speeds, orders, scatter = (
        rate * listed["speed"],
        listed["order"],
        scatter_size * listed["scatter"],
    )
    amplitude = size * listed["amplitude"] * np.exp(1j * turn * listed["phase"])
    ramps = np.zeros(speeds.size)
    if RAMP in at:
        ramps = listed[RAMP] * unit(RAMP, ("rad/s^2",), "is a unit like rad/s^2")[1]
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
        correlation=np.maximum(0.0, 1.0 - apart * (1.0 - shared)),
        ramp=ramps[begins],
        wheel_constant=(every % 1.0 == 0.0) & wheel & (quantity == "angle"),
        cycle=2 if np.any(every % 1.0 == 0.5) else 1,
        zero_known=zero_known and not of_mark,
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
