"""The absolute pressure in a cylinder over one working cycle."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import checked_degrees
from crankbase.checks.arrays import FloatArray, positive_vector, read_only
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from dynamics.cycle import checked_strokes, cycle_degrees, first_not_increasing, is_even_cycle
from dynamics.plots.curves import FROM_FIRING, draw_over_angle
from dynamics.plots.quantities import MEGA

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
    strokes : int
        Strokes per cycle, 2 or 4.
    source : str
        Origin of the samples.
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

        Raises
        ------
        InputError
            If an angle is not a finite number, or they are radians.

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
        """Draw the pressure over the crank angle from the firing top dead center.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
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
        """Return crank angles from the firing top and pressures, a row for each sample.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
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
    pressure : array_like of shape (m,)
        Absolute pressure [Pa], positive.
    strokes : int, optional
        Strokes per cycle, 2 or 4.
    angles_deg : array_like of shape (m,)
        Crank angles from the firing top dead center [deg], strictly ascending over one cycle that
        may start anywhere, no gap wider than 10 deg, the closing sample left out.
    source : str, optional
        Origin of the samples.
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
    given = checked_degrees("angles_deg", angles_deg, vector=True)
    values = positive_vector("pressure", pressure, "Pa", "it is absolute pressure")
    _check_samples(given, values, cycle)
    even = is_even_cycle(given, cycle)
    places, values, remark = (
        _even_angles_in_cycle(given, values, cycle) if even else _resampled(given, values, cycle)
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
    cycle_deg : float
        Length of the cycle [deg].
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
