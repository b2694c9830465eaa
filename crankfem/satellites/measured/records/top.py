"""Where a record over the crank angle has the firing top of a cylinder: said, and checked by its pressure."""

import math
from pathlib import Path

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.sentences import angle, finished
from crankfem.satellites.measured.records.record import Channel
from dynamics.cycle import checked_strokes, cycle_degrees
from dynamics.gas.pressure import CRANK_ANGLE, ENGINE, GasPressure, pressure_of_rows
from dynamics.sample_tables import SampleRows


def cylinder_pressure(pressure: Channel, zero: str | None = None, strokes: int = 4) -> GasPressure:
    """Return the mean cycle of a recorded pressure, as the core takes it; parameters as `firing_top`.

    Raises
    ------
    InputError
        As `firing_top` and `dynamics.gas.pressure.read_pressure_table`, or if the unit does not say whether
        the pressure is absolute.
    """
    top = firing_top(pressure, zero, strokes)
    if not pressure.reference:
        raise InputError(
            f"{pressure.name}: given in {pressure.unit}; allowed is a unit that says whether it is absolute "
            f'or above the atmosphere, like units = {{ {pressure.name} = "bar(a)" }} or "bar(g)".'
        )
    rows = SampleRows(
        Path(pressure.name),
        CRANK_ANGLE,
        f"{pressure.reference}_pressure_Pa",
        np.degrees(pressure.abscissa() - top),
        pressure.si(),
        tuple(range(1, len(pressure) + 1)),
        (),
    )
    return pressure_of_rows(rows, strokes)


def firing_top(pressure: Channel, zero: str | None = None, strokes: int = 4) -> float:
    """Return the angle [rad] in a record at which the cylinder of a pressure is at its firing top.

    Parameters
    ----------
    pressure : Channel
        Of the cylinder, over the crank angle, at least one whole cycle.
    zero : {"firing", "gas exchange"}, optional
        Which top of this cylinder is at angle zero; without it the peak decides between the two.
    strokes : {2, 4}, optional

    Raises
    ------
    InputError
        If the highest pressure of the cycles does not follow that top, or no top at zero.
    """
    if pressure.axis != "angle" or pressure.si_unit != "Pa":
        raise InputError(
            f"{pressure.name}: is in {pressure.si_unit or 'an unknown unit'} over {pressure.axis}; allowed "
            "is a pressure over the crank angle, whose peak tells the firing top."
        )
    cycle = cycle_degrees(checked_strokes(strokes))
    peak = _peak(np.degrees(pressure.abscissa()), pressure.si(), cycle, pressure.name)
    tops = {"firing": 0.0} | ({"gas exchange": 360.0} if cycle > 360.0 else {})
    if zero is not None:
        check_choice("zero", zero, tops, "these are the tops of a cylinder in its cycle")
    for name, top in tops.items():
        after = math.remainder(peak - top, cycle)
        if ENGINE.earliest <= after <= ENGINE.latest and zero in (None, name):
            return math.radians(top)
    expected = f"the {zero} top" if zero else "a top of this cylinder"
    raise InputError(
        finished(
            f"{pressure.name}: its highest pressure is at {angle(peak, 4)}, with {expected} at zero; allowed "
            f"are {angle(ENGINE.earliest)} to {angle(ENGINE.latest)} from the firing top: another top is at "
            "zero, or another cylinder's."
        )
    )


def _peak(degrees: Array, values: Array, cycle: float, name: str) -> float:
    """Return the median place of the highest values of whole cycles [deg], from 0 to `cycle`."""
    number = np.floor((degrees - degrees[0]) / cycle + 1e-9).astype(int)
    step = (degrees[-1] - degrees[0]) / max(degrees.size - 1, 1)
    whole = int((degrees[-1] - degrees[0] + step) / cycle + 1e-6)
    if whole < 1:
        raise InputError(
            finished(
                f"{name}: is recorded over {angle(float(np.ptp(degrees)), 4)}; allowed is a whole cycle of "
                f"{angle(cycle)} at least."
            )
        )
    places = np.array([degrees[number == k][np.argmax(values[number == k])] for k in range(whole)])
    around = np.exp(2j * np.pi * places / cycle)
    middle = np.angle(np.sum(around)) * cycle / (2.0 * np.pi)
    nearest = middle + np.median(np.mod(places - middle + 0.5 * cycle, cycle) - 0.5 * cycle)
    return float(np.mod(nearest, cycle))
