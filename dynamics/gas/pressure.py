"""The absolute pressure in a cylinder over one working cycle."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import FloatArray, checked_degrees, positive_vector, read_only
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.input_file import GivenFile
from crankbase.summaries import summarized
from dynamics.cycle import (
    PLACE_TOLERANCE,
    checked_strokes,
    cycle_degrees,
    first_not_increasing,
    is_even_cycle,
)
from dynamics.plots.curves import FROM_FIRING, draw_over_angle
from dynamics.plots.quantities import MEGA
from dynamics.sample_table import SampleRows, TableKind, possible_cycles, read_sample_rows

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator


# [Pa] The standard atmosphere.
ATMOSPHERE = 101325.0
# [Pa] No piston engine stands more.
HIGHEST_PEAK = 50e6
# [deg] A wider gap between samples could hide the whole rise of the pressure.
WIDEST_GAP = 10.0
# [deg] Steps of samples that are made even, between which half the smallest gap is taken.
FINEST_STEP, COARSEST_STEP = 0.1, 1.0
# [deg] Angles moved less than this to their even places are taken as even without a remark.
SILENT_SHIFT = 1e-6
# The first sample lies within a step from the top, but for rounding [steps].
EVEN = 1e-6
# Samples repeated beyond either end of the cycle: slopes look at two neighbors on each side.
REPEATED = 3


@summarized(
    "peak_pressure [Pa]",
    "peak_angle_deg [deg]",
    "lowest [Pa]",
    "strokes",
    "angles_deg",
    "source",
    "remarks",
)
@dataclass(frozen=True, eq=False)
class GasPressure:
    """The absolute pressure in one cylinder, sampled evenly over one working cycle.

    Made by `gas_pressure`, which makes samples even; by `read_pressure_table`; and by
    `gas_cycle`.

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Crank angles [deg] from the firing top dead center, ascending in even steps from zero or
        below one step, without the closing sample.
    pressure : ndarray of shape (m,)
        Absolute pressure [Pa], positive.
    remarks : tuple of str
        Changes made to them, a sentence each.

    Raises
    ------
    InputError
        If a number is not finite, a pressure is not positive, or the angles are not as above.
    """

    angles_deg: FloatArray
    pressure: FloatArray
    strokes: int
    source: str = ""
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        cycle = cycle_degrees(checked_strokes(self.strokes))
        angles = checked_degrees("angles_deg", self.angles_deg, vector=True)
        values = positive_vector("pressure", self.pressure, "Pa", "it is absolute pressure")
        _check_samples(angles, values, cycle)
        step = cycle / angles.size
        placed = -EVEN * step <= angles[0] < (1.0 + EVEN) * step
        if not (placed and is_even_cycle(angles, cycle)):
            raise InputError(
                f"angles_deg: given {angles.size} from {angles[0]:g} to {angles[-1]:g} deg "
                "that are not even or do not begin at the top; allowed "
                "are even steps from there over the cycle, which gas_pressure makes of others."
            )
        object.__setattr__(self, "angles_deg", read_only(angles))
        object.__setattr__(self, "pressure", read_only(values))

    @property
    def cycle_deg(self) -> float:
        """Length of the cycle in crank angle [deg]."""
        return cycle_degrees(self.strokes)

    @property
    def peak_pressure(self) -> float:
        """The highest pressure [Pa]; it is a sample, as the curve between samples does not exceed them."""
        return float(np.max(self.pressure))

    @property
    def peak_angle_deg(self) -> float:
        """Crank angle of the highest sample [deg], from -cycle/2 (excluded) to cycle/2."""
        angle = float(self.angles_deg[int(np.argmax(self.pressure))])
        return angle - self.cycle_deg if angle > self.cycle_deg / 2.0 else angle

    @property
    def lowest(self) -> float:
        """The lowest pressure [Pa]."""
        return float(np.min(self.pressure))

    def at(self, *, angle_deg: ArrayLike) -> FloatArray:
        """Return the pressure at any crank angles.

        Parameters
        ----------
        angle_deg : array_like of any shape
            Crank angles from the firing top [deg]; the pressure repeats with the cycle.

        Returns
        -------
        ndarray of the same shape
            Absolute pressure [Pa]: a shape-preserving piecewise cubic through the samples,
            which exceeds neither of its two neighbors.

        Notes
        -----
        Slopes after F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304, as in
        scipy's PchipInterpolator.
        """
        folded = np.mod(checked_degrees("angle_deg", angle_deg), self.cycle_deg)
        return np.asarray(self._curve(folded), dtype=np.float64)

    @cached_property
    def _curve(self) -> "PchipInterpolator":
        return _periodic_curve(self.angles_deg, self.pressure, self.cycle_deg)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the pressure over the crank angle from the firing top dead center."""
        axes = draw_over_angle(
            axes,
            np.radians(self.angles_deg),
            {"pressure": MEGA * self.pressure},
            "absolute pressure [MPa]",
            title="Gas pressure",
            angle_label=FROM_FIRING,
        )
        axes.set_ylim(bottom=0.0)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return crank angles from the firing top and pressures, a row for each sample."""
        return table({"crank_angle": (self.angles_deg, "deg"), "pressure": (self.pressure, "Pa")})


def gas_pressure(
    pressure: ArrayLike,
    strokes: int = 4,
    *,
    angles_deg: ArrayLike,
    source: str = "",
    remarks: tuple[str, ...] = (),
) -> GasPressure:
    """Return the pressure over a cycle from samples, resampled evenly where necessary.

    Parameters
    ----------
    angles_deg : array_like of shape (m,)
        Crank angles from the firing top dead center [deg], strictly ascending over one cycle that
        may start anywhere, no gap wider than 10 deg, the closing sample left out.
    remarks : tuple of str, optional
        Earlier changes to them.

    Returns
    -------
    GasPressure
        Even samples. Angles that are even but for rounding are made exactly even. Uneven
        ones are replaced by even ones on the shape-preserving curve through the given samples, in
        steps of half the smallest gap (0.1 deg to 1 deg), one of them on the highest sample, so
        the peak is kept; a remark states it.

    Raises
    ------
    InputError
        If lengths differ, a number is not finite, a pressure is not positive, angles do not
        increase, cover more than the cycle, or leave a gap wider than 10 deg.

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.arange(-180.0, 180.0, 2.0)
    >>> peak = 9e6 * np.exp(-(((angle - 12.0) / 13.0) ** 2))
    >>> found = gas_pressure(2e5 + peak, 2, angles_deg=angle)
    >>> round(found.peak_pressure / 1e6, 2), round(found.peak_angle_deg, 9)
    (9.2, 12.0)
    """
    cycle = cycle_degrees(checked_strokes(strokes))
    degrees = checked_degrees("angles_deg", angles_deg, vector=True)
    values = positive_vector("pressure", pressure, "Pa", "it is absolute pressure")
    _check_samples(degrees, values, cycle)
    even = is_even_cycle(degrees, cycle)
    places, values, remark = (
        _even_angles_in_cycle(degrees, values, cycle)
        if even
        else _resampled(degrees, values, cycle)
    )
    return GasPressure(
        angles_deg=places,
        pressure=values,
        strokes=int(strokes),
        source=source,
        remarks=remarks + ((remark,) if remark else ()),
    )


def widest_gap(angles_deg: FloatArray, cycle_deg: float) -> tuple[int, float]:
    """Return the sample after the widest gap, 0 for the gap to the next cycle, and the gap [deg].

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Ascending angles [deg], at least one.
    """
    seam = angles_deg[0] + cycle_deg - angles_deg[-1]
    gaps = np.concatenate([[seam], np.diff(angles_deg)])
    index = int(np.argmax(gaps))
    return index, float(gaps[index])


def _check_samples(angles: FloatArray, values: FloatArray, cycle: float) -> None:
    """Refuse samples of which angles [deg] and values do not match."""
    if angles.size != values.size:
        raise InputError(
            f"angles_deg: given {angles.size} angles for {values.size} pressures; allowed is one angle "
            "for each pressure, because together they are the samples."
        )
    if angles.size < 2:
        raise InputError(
            f"angles_deg: given {angles.size} samples; allowed are samples over one cycle of "
            f"{cycle:g} deg, because the pressure repeats with it."
        )
    index = first_not_increasing(angles)
    if index is not None:
        raise InputError(
            f"angles_deg[{index}]: given {angles[index]:g} deg after {angles[index - 1]:g} deg; "
            "allowed are strictly increasing angles, because the samples follow the crank."
        )
    if angles[-1] - angles[0] > cycle - SILENT_SHIFT:
        raise InputError(
            f"angles_deg: given {angles[0]:g} to {angles[-1]:g} deg; allowed is one cycle of "
            f"{cycle:g} deg without the closing sample, because the pressure repeats with it."
        )
    index, gap = widest_gap(angles, cycle)
    if gap > WIDEST_GAP * (1.0 + 1e-9):
        raise InputError(
            f"angles_deg: given no sample for {gap:g} deg before {angles[index]:g} deg; allowed are "
            f"gaps of {WIDEST_GAP:g} deg at most, because a wider one may hide the pressure's rise."
        )


def _even_angles_in_cycle(
    angles: FloatArray, values: FloatArray, cycle: float
) -> tuple[FloatArray, FloatArray, str]:
    """Return even angles [deg] within the cycle for angles that are even but for rounding."""
    step = cycle / angles.size
    number = math.floor(angles[0] / step + 1e-9)
    offset = max(float(angles[0]) - number * step, 0.0)
    moved = float(np.max(np.abs(angles - angles[0] - step * np.arange(angles.size))))
    remark = f"Angles were moved by up to {moved:.2g} deg to their even places."
    places = offset + step * np.arange(angles.size)
    return places, np.roll(values, number), remark if moved > SILENT_SHIFT else ""


def _resampled(
    angles: FloatArray, values: FloatArray, cycle: float
) -> tuple[FloatArray, FloatArray, str]:
    """Return even samples on the curve through uneven ones, one of them on the peak, and a remark."""
    smallest = float(np.min(np.diff(angles, append=angles[0] + cycle)))
    step = min(max(smallest / 2.0, FINEST_STEP), COARSEST_STEP)
    count = math.ceil(cycle / step - 1e-9)
    step = cycle / count
    first = float(np.mod(angles[int(np.argmax(values))], step))
    places = first + step * np.arange(count, dtype=np.float64)
    curve = _periodic_curve(angles, values, cycle)
    folded = angles[0] + np.mod(places - angles[0], cycle)
    remark = (
        f"The {angles.size} uneven samples were replaced by {count} even ones in steps of "
        f"{step:.4g} deg on a shape-preserving cubic curve through them."
    )
    return places, np.asarray(curve(folded), dtype=np.float64), remark


def _periodic_curve(angles: FloatArray, values: FloatArray, cycle: float) -> "PchipInterpolator":
    """Return the shape-preserving curve through ascending samples within one cycle."""
    from scipy.interpolate import PchipInterpolator  # here: loading it takes a quarter second

    wrapped = np.concatenate([angles[-REPEATED:] - cycle, angles, angles[:REPEATED] + cycle])
    return PchipInterpolator(
        wrapped, np.concatenate([values[-REPEATED:], values, values[:REPEATED]])
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
    samples = read_sample_rows(path, TABLE)
    remarks: list[str] = []
    kind, _, unit = samples.value_name.split("_")
    pressure = UNITS[unit] * samples.values
    if kind == "gauge":
        pressure += ATMOSPHERE
        remarks.append(f"{ATMOSPHERE:g} Pa of atmosphere were added to the gauge pressure.")
    cycle_strokes, rows, pressure = one_cycle(samples, cycles, pressure, "pressure")
    if rows.angles.size < samples.angles.size:
        remarks.append(f"The closing sample at {samples.angles[-1]:g} deg was dropped.")
    _check_pressure(rows, pressure)
    _check_peak_angle(rows, pressure, cycles[cycle_strokes])
    return gas_pressure(
        pressure, cycle_strokes, source=rows.source, remarks=tuple(remarks), angles_deg=rows.angles
    )


def one_cycle(
    rows: SampleRows, cycles: Mapping[int, float], values: FloatArray, what: str
) -> tuple[int, SampleRows, FloatArray]:
    """Return the strokes, and rows and values over one cycle with small gaps, the closing sample dropped."""

    def closes(angles: FloatArray, cycle: float) -> bool:
        tolerance = PLACE_TOLERANCE * float(np.median(np.diff(angles)))
        return abs(float(angles[-1] - angles[0]) - cycle) <= tolerance

    widest = WIDEST_GAP * (1.0 + 1e-9)
    strokes = rows.strokes(
        cycles,
        lambda angles, cycle: (
            closes(angles, cycle) or 0.0 < cycle - float(angles[-1] - angles[0]) <= widest
        ),
        f" and open by {WIDEST_GAP:g} deg at most",
    )
    if closes(rows.angles, cycles[strokes]):
        rows.check_closing(values, CLOSING_TOLERANCE)
        rows = replace(rows, angles=rows.angles[:-1], values=rows.values[:-1])
        values = values[:-1]
    index, gap = widest_gap(rows.angles, cycles[strokes])
    # The gap to the next cycle is small already, or the strokes would not have been found.
    if index > 0 and gap > widest:
        raise rows.step_error(
            index,
            f"gaps of {WIDEST_GAP:g} deg at most, because a wider one may hide the {what}'s rise",
        )
    return strokes, rows, values


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
    peak, half = float(rows.angles[index]), cycle / 2.0
    if _near_top(peak, cycle):
        return
    hint = f"; the table looks shifted by {half:g} deg" if _near_top(peak + half, cycle) else ""
    raise rows.angle_error(
        index,
        f"given the highest pressure at {peak:g} deg; allowed is a peak from {EARLIEST_PEAK:g} to "
        f"{LATEST_PEAK:g} deg, because angles count from the firing top dead center{hint}",
    )


def _near_top(angle: float, cycle: float) -> bool:
    """Return whether a peak at the angle [deg] can be one of combustion or compression at the top."""
    return (angle - EARLIEST_PEAK) % cycle <= LATEST_PEAK - EARLIEST_PEAK
