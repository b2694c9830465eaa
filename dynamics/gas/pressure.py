"""The absolute pressure in a cylinder over one working cycle, its volume, and the work of the gas."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    checked_degrees,
    finite_array,
    finite_vector,
    positive_number,
    positive_vector,
    radians_of,
    read_only,
)
from crankbase.choices import so_many
from crankbase.diagrams import write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.input_file import GivenFile
from crankbase.monotone_curve import MonotoneCurve
from crankbase.sentences import angle, in_si, listed, with_sentences
from crankbase.summaries import summarized
from dynamics.cycle import (
    checked_strokes,
    cycle_degrees,
    first_not_increasing,
    is_even_cycle,
)
from dynamics.plots.curves import MEGA, draw_over_angle, from_top
from dynamics.sample_tables import (
    WIDEST_GAP,
    SampleRows,
    TableKind,
    TableReading,
    even_count,
    one_cycle,
    possible_cycles,
    read_sample_rows,
)

# [Pa] The standard atmosphere.
ATMOSPHERE = 101325.0
# [Pa] No piston engine stands more.
HIGHEST_PEAK = 50e6
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
@with_sentences
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
    assumed, solved : tuple of str
        Those of the remarks that tell of a value nobody gave, and of one that was solved for.

    Raises
    ------
    InputError
        If a number is not finite, a pressure is not positive, or the angles are not as above.
    """

    angles_deg: Array
    pressure: Array
    strokes: int
    source: str = ""
    remarks: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    solved: tuple[str, ...] = ()

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
    def changes(self) -> tuple[str, ...]:
        """The remarks but for what was assumed or solved."""
        return tuple(text for text in self.remarks if text not in self.assumed + self.solved)

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
    def angles_from_top(self) -> Array:
        """Crank angles of the samples, from -cycle/2 (excluded) to cycle/2 [deg]."""
        angles, cycle = self.angles_deg, self.cycle_deg
        return np.where(angles > cycle / 2.0, angles - cycle, angles)

    @property
    def lowest(self) -> float:
        """The lowest pressure [Pa]."""
        return float(np.min(self.pressure))

    def at(self, *, angle_deg: ArrayLike) -> Array:
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

        See Also
        --------
        crankbase.monotone_curve
        """
        folded = np.mod(checked_degrees("angle_deg", angle_deg), self.cycle_deg)
        return np.asarray(self._curve(folded), dtype=np.float64)

    @cached_property
    def _curve(self) -> MonotoneCurve:
        return _periodic_curve(self.angles_deg, self.pressure, self.cycle_deg)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the pressure over the crank angle from the firing top dead center."""
        axes = draw_over_angle(
            axes,
            np.radians(self.angles_deg),
            {"pressure": MEGA * self.pressure},
            "absolute pressure [MPa]",
            angle_label=from_top(self.strokes),
        )
        axes.set_ylim(bottom=0.0)
        write_title(axes, "Gas pressure")
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
    if is_even_cycle(degrees, cycle):
        step = cycle / degrees.size
        number = math.floor(degrees[0] / step + 1e-9)
        first = max(float(degrees[0]) - number * step, 0.0)
        moved = float(np.max(np.abs(degrees - degrees[0] - step * np.arange(degrees.size))))
        if moved > SILENT_SHIFT:
            remark = f"Angles were moved by up to {angle(moved, 2)} to their even places."
            remarks = (*remarks, remark)
        places = first + step * np.arange(degrees.size)
        values = np.roll(values, number)
    else:
        count = even_count(degrees, cycle)
        step = cycle / count
        remark = (
            f"The {degrees.size} uneven samples were replaced by {count} even ones in steps of "
            f"{angle(step, 4)} on a shape-preserving cubic curve through them."
        )
        remarks = (*remarks, remark)
        # One of the even samples is on the highest one.
        first = float(np.mod(degrees[int(np.argmax(values))], step))
        places = first + step * np.arange(count, dtype=np.float64)
        folded = degrees[0] + np.mod(places - degrees[0], cycle)
        curve = _periodic_curve(degrees, values, cycle)
        values = np.asarray(curve(folded), dtype=np.float64)
    return GasPressure(
        angles_deg=places, pressure=values, strokes=int(strokes), source=source, remarks=remarks
    )


def widest_gap(angles_deg: Array, cycle_deg: float) -> tuple[int, float]:
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


def _check_samples(angles: Array, values: Array, cycle: float) -> None:
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


def _periodic_curve(angles: Array, values: Array, cycle: float) -> MonotoneCurve:
    """Return the shape-preserving curve through ascending samples within one cycle."""
    wrapped = np.concatenate([angles[-REPEATED:] - cycle, angles, angles[:REPEATED] + cycle])
    return MonotoneCurve(wrapped, np.concatenate([values[-REPEATED:], values, values[:REPEATED]]))


CRANK_ANGLE = "crank_angle_deg"
UNITS = {"bar": 1e5, "MPa": 1e6, "kPa": 1e3, "Pa": 1.0}
# First and closing sample count as equal within this share of the highest pressure: measured
# curves are printed with three to five digits, and averaged cycles close to no better.
CLOSING_TOLERANCE = 1e-3


class Peak(NamedTuple):
    """Where the peak of a measured diagram can be.

    Attributes
    ----------
    lowest, highest : float
        [Pa]; any other is a wrong unit.
    earliest, latest : float
        From the top [deg].
    """

    lowest: float
    highest: float
    earliest: float
    latest: float
    why: str

    def check(self, rows: SampleRows, pressure: Array, cycle: float) -> None:
        """Refuse a diagram whose peak is not there (`InputError`)."""
        index = int(np.argmax(pressure))
        if not self.lowest <= pressure[index] <= self.highest:
            raise rows.value_error(
                index,
                f"given a peak of {rows.values[index]:g}, which is {pressure[index] / 1e6:g} MPa absolute; "
                f"allowed are {self.lowest / 1e6:g} to {self.highest / 1e6:g} MPa, because any other comes "
                "from a wrong unit in the header",
            )

        def fits(angle: float, range_: "Peak" = self) -> bool:
            return (angle - range_.earliest) % cycle <= range_.latest - range_.earliest

        peak, half = float(rows.angles[index]), cycle / 2.0
        if fits(peak):
            return
        hint = f"; the table looks shifted by {half:g} deg" if fits(peak + half) else ""
        if self is ENGINE and cycle == cycle_degrees(2) and fits(peak, COMPRESSOR):
            hint += (
                "; a compressor, whose pressure is highest before the top, needs engine.driven_by"
            )
        raise rows.angle_error(
            index,
            f"given the highest pressure at {peak:g} deg; allowed is a peak from {self.earliest:g} to "
            f"{self.latest:g} deg, because {self.why}{hint}",
        )


# Motored engines reach 1 MPa just before the top, fired ones have their peak after it. Compressors for
# polyethylene reach 350 MPa.
ENGINE = Peak(0.2e6, HIGHEST_PEAK, -10.0, 40.0, "angles count from the firing top dead center")
COMPRESSOR = Peak(
    0.1e6, 400e6, -150.0, 10.0, "angles count from the top dead center, where the delivery ends"
)

TABLE = TableKind(
    name="pressure table",
    angle_names=(CRANK_ANGLE,),
    value_names=tuple(
        f"{kind}_pressure_{unit}" for kind in ("absolute", "gauge") for unit in UNITS
    ),
    units=UNITS,
    si="Pa",
    headers=(
        f'"{CRANK_ANGLE},absolute_pressure_bar" or the like with "gauge" for "absolute" and '
        '"MPa", "kPa" or "Pa" for "bar"'
    ),
    header_says="which pressure is meant and in which units",
)


def read_pressure_table(
    path: GivenFile,
    strokes: int | None = None,
    *,
    fires: bool = True,
    reading: TableReading | None = None,
) -> GasPressure:
    """Read a pressure table.

    The file has comment lines that start with a number sign, which state the source; the
    header ``crank_angle_deg,absolute_pressure_bar``, or ``gauge`` for ``absolute`` and ``MPa``,
    ``kPa`` or ``Pa`` for ``bar``; then one sample a line. Angles count from the firing top dead
    center and cover one cycle, 720 deg in a four-stroke and 360 deg in a two-stroke engine,
    wherever it starts (0 to 720, -360 to 360). The mean of several cycles is taken. A closing sample that
    repeats the first is dropped. Uneven angles are resampled. 101325 Pa are added to gauge pressure. The
    remarks of the result state the changes.

    Parameters
    ----------
    strokes : int, optional
        Strokes per cycle, 2 or 4; by default found from the angles.
    fires : bool, optional
        Whether it is an engine's; that of a compressor is highest while it delivers, before the top.
    reading : TableReading, optional
        Which columns are meant, where the header does not say so.

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
        absolute pressure is not positive, the peak is outside 0.2 to 50 MPa (a wrong unit; of a
        compressor 0.1 to 400 MPa) or outside -10 to 40 deg (angles counted from elsewhere; of a
        compressor -150 to 10 deg).
    """
    return pressure_of_rows(read_sample_rows(path, TABLE, reading), strokes, fires=fires)


def pressure_of_rows(
    rows: SampleRows, strokes: int | None = None, *, fires: bool = True
) -> GasPressure:
    """Return the pressure of the rows of a table, or of a record; the rest as `read_pressure_table`."""
    cycles = possible_cycles(strokes)
    cycle_strokes, rows = one_cycle(rows, cycles, tolerance=CLOSING_TOLERANCE, what="pressure")
    remarks = rows.remarks
    kind, _, unit = rows.value_name.split("_")
    pressure = UNITS[unit] * rows.values
    if kind == "gauge":
        pressure += ATMOSPHERE
        added = f"{in_si(ATMOSPHERE, 'Pa')} of atmosphere were added to the gauge pressure."
        remarks = (added, *remarks)
    least = int(np.argmin(pressure))
    if pressure[least] <= 0.0:
        raise rows.value_error(
            least,
            f"given {rows.values[least]:g}; allowed is what gives an absolute pressure above zero, because "
            "no gas has less",
        )
    peak = ENGINE if fires else COMPRESSOR
    peak.check(rows, pressure, cycles[cycle_strokes])
    return gas_pressure(
        pressure, cycle_strokes, source=rows.source, remarks=remarks, angles_deg=rows.angles
    )


Position = Callable[[Array], Array]

# Places over one turn at which the highest and lowest position are looked for.
SEARCH_PLACES = 360
# A piston is back after one turn within this share of its stroke.
RETURN_TOLERANCE = 1e-9
# [deg] Offset pins and articulated rods move the highest position by a few degrees only.
FARTHEST_TOP = 30.0


@dataclass(frozen=True, eq=False)
class CylinderVolume:
    """Volume over a piston as a function of the crank angle from the nominal top.

    Made by `cylinder_volume`.

    Parameters
    ----------
    position : callable
        Position of the piston along the cylinder axis, away from the shaft [m], for an array of
        crank angles [rad].
    area : float
        Piston area [m^2].
    highest, lowest : float
        Highest and lowest position [m].
    top_angle_deg, bottom_angle_deg : float
        Crank angles of these, from -180 to 180 and from 0 to 360: 0 and 180 for a plain slider-crank,
        near them for an offset pin or an articulated rod.
    """

    position: Position
    area: float
    compression_ratio: float
    highest: float
    lowest: float
    top_angle_deg: float
    bottom_angle_deg: float

    @property
    def stroke(self) -> float:
        """Travel of the piston between its dead centers [m]."""
        return self.highest - self.lowest

    @property
    def swept(self) -> float:
        """Swept volume [m^3]."""
        return self.area * self.stroke

    @property
    def clearance(self) -> float:
        """Smallest volume [m^3]: swept volume over compression ratio less one."""
        return self.swept / (self.compression_ratio - 1.0)

    def at(self, *, angle_deg: ArrayLike) -> Array:
        """Return the volume [m^3] at crank angles of any shape."""
        angles = radians_of("angle_deg", angle_deg)
        position = np.asarray(self.position(angles.ravel()), dtype=np.float64)
        return (self.clearance + self.area * (self.highest - position)).reshape(angles.shape)


def cylinder_volume(position: Position, area: float, compression_ratio: float) -> CylinderVolume:
    """Return the volume of a cylinder whose piston moves in a given way.

    Parameters
    ----------
    position : callable
        Position of the piston along the cylinder axis from any origin, growing away from the
        shaft [m], for an array of crank angles [rad] from the position of the crank along the cylinder
        axis. It is smooth and repeats every revolution.
    area : float
        Piston area [m^2].

    Examples
    --------
    >>> crank, rod, area = 0.06, 0.2, 0.01
    >>> def position(angle):
    ...     return crank * np.cos(angle) + np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)
    >>> volume = cylinder_volume(position, area, 16.0)
    >>> round(volume.stroke, 12), round(volume.clearance * 1e6, 9)
    (0.12, 80.0)
    """
    positive_number("area", area, "m^2", "gas presses on the piston")
    positive_number("compression_ratio", compression_ratio, "", "it is a ratio of volumes")
    if compression_ratio <= 1.0:
        raise InputError(
            f"compression_ratio: given {compression_ratio:g}; allowed is more than 1, because it "
            "is the largest over the smallest volume."
        )
    step = 2.0 * math.pi / SEARCH_PLACES
    places = step * np.arange(SEARCH_PLACES + 1, dtype=np.float64)
    positions = finite_array("position", position(places))
    way = float(np.ptp(positions))
    if way <= 0.0 or abs(positions[-1] - positions[0]) > RETURN_TOLERANCE * way:
        raise InputError(
            f"position: given {in_si(positions[0], 'm')} at 0 deg, {in_si(positions[-1], 'm')} at 360 deg "
            f"and a way of {in_si(way, 'm')} between; allowed is a piston that moves and is back after one "
            "turn, because its volume repeats with the turn."
        )
    top_angle, highest = _extreme(position, places[int(np.argmax(positions[:-1]))], step, 1.0)
    bottom_angle, lowest = _extreme(position, places[int(np.argmin(positions[:-1]))], step, -1.0)
    top_angle_deg = math.remainder(math.degrees(top_angle), 360.0)
    if abs(top_angle_deg) > FARTHEST_TOP:
        raise InputError(
            f"position: given one that is highest at {top_angle_deg:.4g} deg; allowed "
            f"are {-FARTHEST_TOP:g} to {FARTHEST_TOP:g} deg, because angles count from the nominal "
            "top dead center and the position away from the shaft."
        )
    return CylinderVolume(
        position=position,
        area=float(area),
        compression_ratio=float(compression_ratio),
        highest=highest,
        lowest=lowest,
        top_angle_deg=top_angle_deg,
        bottom_angle_deg=math.degrees(bottom_angle) % 360.0,
    )


def _extreme(position: Position, place: float, step: float, sign: float) -> tuple[float, float]:
    """Return angle and value of the highest (sign 1) or lowest (-1) position near an angle."""
    # The vertex of the parabola through three points about the angle is the next angle. Four rounds,
    # each ten times closer, leave the angle within 1e-8 rad and the value within round-off.
    angle = float(place)
    for _ in range(4):
        values = sign * position(np.array([angle - step, angle, angle + step]))
        curvature = float(values[0] - 2.0 * values[1] + values[2])
        if curvature >= 0.0:
            break
        move = 0.5 * float(values[0] - values[2]) / curvature
        angle += step * min(max(move, -1.0), 1.0)
        step /= 10.0
    return angle, float(position(np.array([angle]))[0])


def indicated_work(pressure: ArrayLike, volume_slope: ArrayLike, strokes: int = 4) -> float:
    """Return the work of the gas on the piston over one cycle.

    Parameters
    ----------
    pressure : array_like of shape (m,)
        Pressure at even crank angles over the whole cycle [Pa], without the closing sample. A
        constant pressure under the piston may be included or not: its work over a revolution is zero.
    volume_slope : array_like of shape (m,)
        Derivative of the volume by the crank angle there [m^3/rad]: piston area times the
        piston's travel towards the shaft per radian.

    Returns
    -------
    float
        Integral of p dV [J], by the trapezoidal rule, which on a periodic function is the mean.

    Raises
    ------
    InputError
        If lengths differ or a number is not finite.

    Examples
    --------
    >>> angle = np.radians(np.arange(0.0, 360.0, 1.0))
    >>> work = indicated_work(1e5 + 2e5 * np.sin(angle), 3e-3 * np.sin(angle), strokes=2)
    >>> round(work / math.pi, 9)
    600.0
    """
    pressing = finite_vector("pressure", pressure)
    slope = finite_vector("volume_slope", volume_slope)
    if pressing.size != slope.size or pressing.size == 0:
        raise InputError(
            f"volume_slope: given {so_many(slope.size)} for {pressing.size} of pressure; allowed is one "
            "for each and at least one, because they are multiplied at each angle."
        )
    return math.pi * checked_strokes(strokes) * float(pressing @ slope) / pressing.size


def indicated_mean_effective_pressure(work: float, swept: float) -> float:
    """Return the work of one cycle per swept volume.

    Returns
    -------
    float
        Mean effective pressure [Pa].
    """
    return work / positive_number("swept", swept, "m^3", "the work is taken per swept volume")


def periodic_slope(values: Array, period: float) -> Array:
    """Return the derivative of a smooth periodic function from even samples over its period.

    Parameters
    ----------
    values : ndarray of shape (m,)
        Samples over one period, without the closing one.

    Returns
    -------
    ndarray of shape (m,)
        The derivative of the Fourier series through the samples at the samples: exact up to
        round-off if the series has decayed before half the sampling rate, as that of a piston's
        travel.
    """
    transform = np.fft.rfft(values)
    orders = np.arange(transform.size, dtype=np.float64)
    # An order at half the sampling rate alternates in sign and has no slope at the samples; here it
    # is imaginary and left out by the inverse transform.
    slope = np.fft.irfft(2j * math.pi / period * orders * transform, n=values.size)
    return np.asarray(slope, dtype=np.float64)


# Where a diesel engine's compression is undisturbed: after valves close, before ignition [deg].
FIT_FROM, FIT_TO = -100.0, -40.0
FEWEST_SAMPLES = 4


def compression_line(
    pressure: GasPressure, volume: CylinderVolume, low: float = FIT_FROM, high: float = FIT_TO
) -> tuple[float, float]:
    """Return slope and level of ln p over ln V between two crank angles [deg], by least squares."""
    angles = pressure.angles_from_top
    within = (angles >= low) & (angles <= high)
    if np.count_nonzero(within) < FEWEST_SAMPLES:
        raise InputError(
            f"fit_from_deg: given a range with {np.count_nonzero(within)} samples; allowed are "
            f"{FEWEST_SAMPLES} or more, because the exponent is fitted to them."
        )
    size = np.log(volume.at(angle_deg=angles[within]))
    slope, level = np.polyfit(size, np.log(pressure.pressure[within]), 1)
    return float(slope), float(level)


def motored_from_compression(
    pressure: GasPressure,
    volume: CylinderVolume,
    *,
    fit_from_deg: float = FIT_FROM,
    fit_to_deg: float = FIT_TO,
) -> GasPressure:
    """Estimate the pressure in a cylinder that does not fire from the diagram of a fired one.

    Parameters
    ----------
    fit_from_deg, fit_to_deg : float, optional
        Crank angles [deg] before the top between which the diagram shows pure compression.

    Returns
    -------
    GasPressure
        The diagram itself up to `fit_to_deg`; from there to the bottom after the top the lower one of
        the diagram and of the polytrope through the compression; then the diagram again. A remark
        states the exponent.

    Raises
    ------
    InputError
        If the range is not before the top, has fewer than four samples, or the pressure does
        not rise there as in compression.

    Notes
    -----
    ln p = ln C - n ln V is fitted by least squares. The fitted n includes heat to the walls during
    compression, and the same is assumed for expansion; the lower of both curves passes to the
    blow-down without the valve timing.
    """
    low, high = (
        float(finite_array(name, value))
        for name, value in (("fit_from_deg", fit_from_deg), ("fit_to_deg", fit_to_deg))
    )
    if not -180.0 <= low < high < 0.0:
        raise InputError(
            f"fit_from_deg: given {low:g} deg to {high:g} deg; allowed is a range "
            "from -180 deg to below 0, because the gas is compressed there."
        )
    angles = pressure.angles_from_top
    size = np.log(volume.at(angle_deg=angles))
    slope, level = compression_line(pressure, volume, low, high)
    if not -2.0 < slope < -1.0:
        raise InputError(
            f"pressure: given a diagram with the polytropic exponent {-slope:.3g} between "
            f"{low:g} and {high:g} deg; allowed is one from 1 to 2, because "
            "compression of a gas has such."
        )
    polytrope = np.exp(level + slope * size)
    after = (angles > high) & (angles <= 180.0)
    motored = np.where(after, np.minimum(pressure.pressure, polytrope), pressure.pressure)
    fitted = listed(np.radians([low, high]).tolist(), "rad", between=" to ")
    remark = (
        f"Without combustion: compression with the exponent {-slope:.4g}, fitted from {fitted}, and "
        "expansion along the same curve."
    )
    return replace(pressure, pressure=motored, remarks=(*pressure.remarks, remark))
