"""Read the pressure in a cylinder over a cycle from a small CSV file."""

from dataclasses import replace

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.input_file import GivenFile
from dynamics.cycle import PLACE_TOLERANCE
from dynamics.gas.pressure import (
    ATMOSPHERE,
    HIGHEST_PEAK,
    WIDEST_GAP,
    GasPressure,
    gas_pressure,
    widest_gap,
)
from dynamics.sample_table import SampleRows, TableKind, possible_cycles, read_sample_rows

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
    header_says="which pressure is meant and in which units",
)


def read_pressure_table(path: GivenFile, strokes: int | None = None) -> GasPressure:
    """Read a pressure table.

    The file is CSV: comment lines that start with a number sign, which state the source; the
    header ``crank_angle_deg,absolute_pressure_bar``, or ``gauge`` for ``absolute`` and ``MPa``,
    ``kPa`` or ``Pa`` for ``bar``; then one sample a line. Angles count from the firing top dead
    center and cover one cycle, 720 deg in a four-stroke and 360 deg in a two-stroke engine,
    wherever it starts (0 to 720, -360 to 360). A closing sample that repeats the first is dropped.
    Uneven angles are resampled. 101325 Pa are added to gauge pressure. The remarks of the result
    state the changes.

    Parameters
    ----------
    path : path
        The file.
    strokes : int, optional
        Strokes per cycle, 2 or 4; by default found from the angles.

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
        absolute pressure is not positive, the peak is outside 0.2 to 50 MPa (a wrong unit) or
        outside -10 to 40 deg (angles counted from elsewhere).
    """
    cycles = possible_cycles(strokes)
    rows = read_sample_rows(path, TABLE)
    remarks: list[str] = []
    found = rows.strokes(
        cycles,
        lambda angles, cycle: closes_cycle(angles, cycle) or opens_little(angles, cycle),
        f" and open by {WIDEST_GAP:g} deg at most",
    )
    cycle = cycles[found]
    kind, _, unit = rows.value_name.split("_")
    pressure = UNITS[unit] * rows.values
    if kind == "gauge":
        pressure += ATMOSPHERE
        remarks.append(f"{ATMOSPHERE:g} Pa of atmosphere were added to the gauge pressure.")
    if closes_cycle(rows.angles, cycle):
        rows.check_closing(pressure, CLOSING_TOLERANCE)
        remarks.append(f"The closing sample at {rows.angles[-1]:g} deg was dropped.")
        rows = replace(rows, angles=rows.angles[:-1], values=rows.values[:-1])
        pressure = pressure[:-1]
    index, gap = widest_gap(rows.angles, cycle)
    # The gap to the next cycle is small already, or the strokes would not have been found.
    if index > 0 and gap > WIDEST_GAP * (1.0 + 1e-9):
        raise rows.step_error(
            index,
            f"gaps of {WIDEST_GAP:g} deg at most, because a wider one may hide the pressure's rise",
        )
    _check_pressure(rows, pressure)
    _check_peak_angle(rows, pressure, cycle)
    return gas_pressure(
        pressure, found, source=rows.source, remarks=tuple(remarks), angles_deg=rows.angles
    )


def closes_cycle(angles: FloatArray, cycle: float) -> bool:
    """Return whether the last angle is one cycle after the first."""
    tolerance = PLACE_TOLERANCE * float(np.median(np.diff(angles)))
    return abs(float(angles[-1] - angles[0]) - cycle) <= tolerance


def opens_little(angles: FloatArray, cycle: float) -> bool:
    """Return whether the angles leave no wide gap to the next cycle."""
    return 0.0 < cycle - float(angles[-1] - angles[0]) <= WIDEST_GAP * (1.0 + 1e-9)


def _check_pressure(rows: SampleRows, pressure: FloatArray) -> None:
    index = int(np.argmin(pressure))
    if pressure[index] <= 0.0:
        raise rows.value_error(
            index,
            f"given {rows.values[index]:g}; allowed is what gives an absolute pressure above zero, because "
            "no gas has less",
        )
    index = int(np.argmax(pressure))
    if not LOWEST_PEAK <= pressure[index] <= HIGHEST_PEAK:
        raise rows.value_error(
            index,
            f"given a peak of {rows.values[index]:g}, which is {pressure[index] / 1e6:g} MPa absolute; "
            f"allowed are {LOWEST_PEAK / 1e6:g} to {HIGHEST_PEAK / 1e6:g} MPa, because any other comes from "
            "a wrong unit in the header",
        )


def _check_peak_angle(rows: SampleRows, pressure: FloatArray, cycle: float) -> None:
    index = int(np.argmax(pressure))
    given, half = float(rows.angles[index]), cycle / 2.0
    if _near_top(given, cycle):
        return
    hint = f"; the table looks shifted by {half:g} deg" if _near_top(given + half, cycle) else ""
    raise rows.angle_error(
        index,
        f"given the highest pressure at {given:g} deg; allowed is a peak from {EARLIEST_PEAK:g} to "
        f"{LATEST_PEAK:g} deg, because angles count from the firing top dead center{hint}",
    )


def _near_top(angle: float, cycle: float) -> bool:
    """Return whether a peak at the angle [deg] can be one of combustion or compression at the top."""
    return (angle - EARLIEST_PEAK) % cycle <= LATEST_PEAK - EARLIEST_PEAK
