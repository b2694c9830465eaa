"""Read the pressure in a cylinder over a cycle from a small CSV file."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from dynamics.cycle import PLACE_TOLERANCE, checked_strokes, cycle_degrees
from dynamics.gas.pressure import (
    ATMOSPHERE,
    HIGHEST_PEAK,
    WIDEST_GAP,
    GasPressure,
    gas_pressure,
    widest_gap,
)
from dynamics.sample_table import (
    SampleRows,
    TableKind,
    check_increasing,
    read_sample_rows,
    wrong_angle,
)

CRANK_ANGLE = "crank_angle_deg"
UNITS = {"bar": 1e5, "MPa": 1e6, "kPa": 1e3, "Pa": 1.0}
# First and closing sample count as equal within this share of the highest pressure: measured
# curves are printed with three to five digits, and averaged cycles close to no better.
CLOSING_TOLERANCE = 1e-3
# [Pa] A lower peak, like one above the highest, is a wrong unit: motored engines reach 1 MPa.
LOWEST_PEAK = 0.2e6
# [deg] Where a peak can lie: a motored engine has it just before the top, a fired one after it.
EARLIEST_PEAK, LATEST_PEAK = -10.0, 40.0

TABLE = TableKind(
    name="pressure table",
    angle_names=(CRANK_ANGLE,),
    value_names=tuple(
        f"{kind}_pressure_{unit}" for kind in ("absolute", "gauge") for unit in UNITS
    ),
    headers=(
        f'"{CRANK_ANGLE},absolute_pressure_bar" or the like with "gauge" for "absolute" and '
        '"MPa", "kPa" or "Pa" for "bar"'
    ),
    header_shows="it says the kind and the unit of the pressure",
    header_reason="it says which pressure is meant and in which units",
    sample_reason="every sample enters the curve",
)


def read_pressure_table(path: str | Path, strokes: int | None = None) -> GasPressure:
    """Read a pressure table.

    The file is CSV: comment lines that start with a number sign, which state the source; the
    header ``crank_angle_deg,absolute_pressure_bar``, or ``gauge`` for ``absolute`` and ``MPa``,
    ``kPa`` or ``Pa`` for ``bar``; then one sample a line. Angles count from the firing top dead
    center and cover one cycle, 720 deg in a four-stroke and 360 deg in a two-stroke engine,
    wherever it starts (0 to 720, -360 to 360). A closing sample that repeats the first is dropped.
    Uneven angles are resampled. To gauge pressure 101325 Pa are added. The remarks of the result
    say what was done.

    Parameters
    ----------
    path : str or Path
        The file.
    strokes : int, optional
        Strokes per cycle, 2 or 4; the angles show it by themselves.

    Returns
    -------
    GasPressure
        Angles [rad], absolute pressure [Pa], strokes, the comments as source, and remarks.

    Raises
    ------
    InputError
        With file and, where there is one, line: if the file cannot be read, the header or a number
        is wrong, angles do not increase, do not cover one cycle or leave a gap wider than 10 deg,
        the closing sample differs from the first by more than a thousandth of the peak, an
        absolute pressure is not positive, the peak lies outside 0.2 to 50 MPa (a wrong unit) or
        outside -10 to 40 deg (angles that count from elsewhere).
    """
    path = Path(path)
    if strokes is not None:
        checked_strokes(strokes)
    rows = read_sample_rows(path, TABLE)
    if rows.angles.size < 2:
        raise InputError(
            f"{path}: given {rows.angles.size} samples; allowed are samples over a whole cycle, "
            "because the pressure repeats with it."
        )
    check_increasing(path, rows)
    remarks: list[str] = []
    strokes = _found_strokes(path, rows, strokes)
    kind, _, unit = rows.value_name.split("_")
    pressure = UNITS[unit] * rows.values
    if kind == "gauge":
        pressure += ATMOSPHERE
        remarks.append(f"{ATMOSPHERE:g} Pa of atmosphere were added to the gauge pressure.")
    cycle = cycle_degrees(strokes)
    if _closes_cycle(rows.angles, cycle):
        _check_closing(path, rows, pressure)
        remarks.append(f"The closing sample at {rows.angles[-1]:g} deg was dropped.")
        rows = replace(rows, angles=rows.angles[:-1], values=rows.values[:-1])
        pressure = pressure[:-1]
    _check_gaps(path, rows, cycle)
    _check_pressure(path, rows, pressure)
    _check_peak_angle(path, rows, pressure, cycle)
    return gas_pressure(
        np.radians(rows.angles),
        pressure,
        strokes,
        source="\n".join(rows.comments),
        remarks=tuple(remarks),
    )


def _closes_cycle(angles: FloatArray, cycle: float) -> bool:
    """Tell whether the last angle lies one cycle after the first."""
    tolerance = PLACE_TOLERANCE * float(np.median(np.diff(angles)))
    return abs(float(angles[-1] - angles[0]) - cycle) <= tolerance


def _found_strokes(path: Path, rows: SampleRows, strokes: int | None) -> int:
    """Return the strokes whose cycle the angles cover."""
    possible = (4, 2) if strokes is None else (strokes,)
    span = float(rows.angles[-1] - rows.angles[0])
    for number in possible:
        cycle = cycle_degrees(number)
        if _closes_cycle(rows.angles, cycle) or cycle - WIDEST_GAP * (1.0 + 1e-9) <= span < cycle:
            return number
    lengths = " or ".join(f"{cycle_degrees(number):g} deg" for number in possible)
    raise InputError(
        f"{path}, line {rows.lines[-1]}: {rows.angle_name}: given angles from {rows.angles[0]:g} "
        f"to {rows.angles[-1]:g} deg; allowed is one cycle of {lengths}, with or without the "
        f"closing sample and open by {WIDEST_GAP:g} deg at most, because the pressure repeats with "
        "the cycle."
    )


def _check_closing(path: Path, rows: SampleRows, pressure: FloatArray) -> None:
    first, last = rows.values[0], rows.values[-1]
    if abs(pressure[-1] - pressure[0]) > CLOSING_TOLERANCE * np.max(np.abs(pressure)):
        raise InputError(
            f"{path}, line {rows.lines[-1]}: {rows.value_name}: given {last:g} for the closing "
            f"sample; allowed is the {first:g} of line {rows.lines[0]}, because the closing sample "
            "repeats the first one cycle later."
        )


def _check_gaps(path: Path, rows: SampleRows, cycle: float) -> None:
    index, gap = widest_gap(rows.angles, cycle)
    # The gap to the next cycle is small already, or the strokes would not have been found.
    if index > 0 and gap > WIDEST_GAP * (1.0 + 1e-9):
        wanted = (
            f"gaps of {WIDEST_GAP:g} deg at most, because a wider one may hide the pressure's rise"
        )
        raise wrong_angle(path, rows, index, wanted)


def _check_pressure(path: Path, rows: SampleRows, pressure: FloatArray) -> None:
    index = int(np.argmin(pressure))
    if pressure[index] <= 0.0:
        raise InputError(
            f"{path}, line {rows.lines[index]}: {rows.value_name}: given {rows.values[index]:g}; "
            "allowed is what gives an absolute pressure above zero, because no gas has less."
        )
    index = int(np.argmax(pressure))
    if not LOWEST_PEAK <= pressure[index] <= HIGHEST_PEAK:
        raise InputError(
            f"{path}, line {rows.lines[index]}: {rows.value_name}: given a peak of "
            f"{rows.values[index]:g}, which is {pressure[index] / 1e6:g} MPa absolute; allowed are "
            f"{LOWEST_PEAK / 1e6:g} to {HIGHEST_PEAK / 1e6:g} MPa, because any other comes from a "
            "wrong unit in the header."
        )


def _check_peak_angle(path: Path, rows: SampleRows, pressure: FloatArray, cycle: float) -> None:
    index = int(np.argmax(pressure))
    given = float(rows.angles[index])
    if _near_top(given, cycle):
        return
    half = cycle / 2.0
    hint = f"; the table looks shifted by {half:g} deg" if _near_top(given + half, cycle) else ""
    raise InputError(
        f"{path}, line {rows.lines[index]}: {rows.angle_name}: given the highest pressure at "
        f"{given:g} deg; allowed is a peak from {EARLIEST_PEAK:g} to {LATEST_PEAK:g} deg, because "
        f"angles count from the firing top dead center{hint}."
    )


def _near_top(angle: float, cycle: float) -> bool:
    """Tell whether a peak at the angle [deg] is one of combustion or compression at the top."""
    return (angle - EARLIEST_PEAK) % cycle <= LATEST_PEAK - EARLIEST_PEAK
