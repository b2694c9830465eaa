"""The cycle model at crank angles: a pressure that is linear in the heat, and the heat for a target."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_vector, nonnegative_number
from crankbase.checks.scalars import is_number
from crankbase.errors import InputError
from dynamics.gas.cycle_values import BOTTOM, GasCycle
from dynamics.gas.cylinder_volume import CylinderVolume
from dynamics.gas.indicated import indicated_work, periodic_slope
from dynamics.gas.pressure import HIGHEST_PEAK

# The combustion is integrated over r, where r^4 is the share of its duration: the rate of heat
# release, which may begin as any power of the share, begins smoothly over r. Parts besides those
# between the angles asked for, and Gauss points in each, bring the integral to 1e-12 for
# shapes up to 10.
ROOT_POWER = 4
PARTS = 96
GAUSS_POINTS = 6


@dataclass(frozen=True, eq=False)
class CycleSamples:
    """A cycle at even crank angles: pressure = motored + heat * rise.

    Parameters
    ----------
    motored : ndarray of shape (m,)
        Absolute pressure without heat [Pa].
    rise : ndarray of shape (m,)
        Rise of the pressure for one joule of heat [Pa/J], zero where the cylinder is open.
    volume_slope : ndarray of shape (m,)
        Derivative of the volume by the crank angle [m^3/rad].
    swept : float
        Swept volume [m^3].
    strokes : int
        Strokes per cycle, 2 or 4.
    """

    motored: FloatArray
    rise: FloatArray
    volume_slope: FloatArray
    swept: float
    strokes: int

    def pressure(self, heat: float) -> FloatArray:
        """Return the pressure [Pa] for a heat [J]."""
        return self.motored + heat * self.rise

    def peak(self, heat: float) -> float:
        """Return the highest pressure [Pa] for a heat [J]."""
        return float(np.max(self.pressure(heat)))

    def work(self, heat: float) -> float:
        """Return the indicated work [J] for a heat [J]."""
        return indicated_work(self.pressure(heat), self.volume_slope, self.strokes)

    def mean_pressure(self, heat: float) -> float:
        """Return the indicated mean effective pressure [Pa] for a heat [J]."""
        return self.work(heat) / self.swept

    @property
    def work_per_heat(self) -> float:
        """Increase of the indicated work per joule of heat [J/J]."""
        return indicated_work(self.rise, self.volume_slope, self.strokes)

    def heat_for_peak(self, peak: float) -> float:
        """Return the heat [J] at which the first sample reaches the peak [Pa]."""
        rising = self.rise > 0.0
        return float(np.min((peak - self.motored[rising]) / self.rise[rising]))

    def heat_for_mean_pressure(self, mean_pressure: float) -> float:
        """Return the heat [J] for an indicated mean effective pressure [Pa]."""
        return (mean_pressure * self.swept - self.work(0.0)) / self.work_per_heat


def cycle_samples(cycle: GasCycle, volume: CylinderVolume, angles_deg: FloatArray) -> CycleSamples:
    """Return the cycle at its samples.

    Parameters
    ----------
    cycle : GasCycle
        Its parameters.
    volume : CylinderVolume
        The volume over the piston.
    angles_deg : ndarray of shape (m,)
        Even crank angles from zero over the cycle, the closing one left out.

    Returns
    -------
    CycleSamples
        Pressure and volume slope there.
    """
    # 1 where the cylinder is closed, 0 where it is open, between in the blow-down.
    share = 1.0 - _smooth_step(angles_deg, cycle.exhaust_opens_deg, BOTTOM)
    share[angles_deg >= cycle.intake_closes_deg + cycle.cycle_deg] = 1.0
    closed = share > 0.0
    within = np.where(angles_deg > BOTTOM, angles_deg - cycle.cycle_deg, angles_deg)[closed]
    # The pressure of the exhaust, then of the intake, passing over in the overlap.
    passed = _smooth_step(angles_deg, cycle.overlap_begins_deg, cycle.overlap_ends_deg)
    open_pressure = cycle.exhaust_pressure + passed * (
        cycle.intake_pressure - cycle.exhaust_pressure
    )
    motored = open_pressure.copy()
    motored[closed] += share[closed] * (
        motored_pressure(cycle, volume, within) - open_pressure[closed]
    )
    rise = np.zeros(angles_deg.size)
    rise[closed] = share[closed] * pressure_rise_per_heat(cycle, volume, within)
    return CycleSamples(
        motored=motored,
        rise=rise,
        volume_slope=periodic_slope(volume.at(angle_deg=angles_deg), math.radians(cycle.cycle_deg)),
        swept=volume.swept,
        strokes=cycle.strokes,
    )


def _smooth_step(angles: FloatArray, begin: float, end: float) -> FloatArray:
    """Return 3 t^2 - 2 t^3, from 0 at the start to 1 at the end, with zero slope at both."""
    share = np.clip((angles - begin) / (end - begin), 0.0, 1.0)
    return np.asarray(share**2 * (3.0 - 2.0 * share), dtype=np.float64)


def motored_pressure(cycle: GasCycle, volume: CylinderVolume, angle_deg: ArrayLike) -> FloatArray:
    """Return the pressure without combustion, isentropic from the closing of the intake.

    Parameters
    ----------
    cycle : GasCycle
        Intake pressure, intake closing and ratio of heat capacities g.
    volume : CylinderVolume
        Volume V over the piston.
    angle_deg : array_like of any shape
        Crank angles within the closed part.

    Returns
    -------
    ndarray of the same shape
        p_closing (V_closing / V)^g [Pa].
    """
    ratio = volume.at(angle_deg=cycle.intake_closes_deg) / volume.at(angle_deg=angle_deg)
    return np.asarray(cycle.intake_pressure * ratio**cycle.heat_capacity_ratio, dtype=np.float64)


def pressure_rise_per_heat(
    cycle: GasCycle, volume: CylinderVolume, angle_deg: ArrayLike
) -> FloatArray:
    """Return the pressure rise per joule of heat.

    Parameters
    ----------
    cycle : GasCycle
        Combustion and ratio of heat capacities g.
    volume : CylinderVolume
        Volume V over the piston.
    angle_deg : array_like of shape (m,)
        Crank angles within the closed part, in any order.

    Returns
    -------
    ndarray of shape (m,)
        (g - 1) / V(angle)^g times the integral of V^(g - 1) dx from the start of the combustion, x
        the burnt share [Pa/J].

    Raises
    ------
    InputError
        If an angle is not a finite number.

    Notes
    -----
    x = (1 - exp(-a t^(m + 1))) / c with t = (angle - s) / d from 0 to 1 and a = -ln(1 - c): the law of
    I. I. Wiebe (Brennverlauf und Kreisprozess von Verbrennungsmotoren, 1970), which reaches the
    completeness c at the end of the duration d, scaled so that it reaches 1.

    The first law for a gas with constant heat capacities, dQ = d(p V) / (g - 1) + p dV, is
    d(p V^g) = (g - 1) V^(g - 1) dQ, so the pressure is that without combustion plus the heat
    times this rise. The integral is evaluated by Gauss quadrature in parts.
    """
    angles_deg = finite_vector("angle_deg", angle_deg)
    share = (angles_deg - cycle.combustion_start_deg) / cycle.combustion_duration_deg
    root = np.clip(share, 0.0, 1.0) ** (1.0 / ROOT_POWER)
    ends, place = np.unique(
        np.concatenate([root, np.linspace(0.0, 1.0, PARTS + 1)]), return_inverse=True
    )
    integrals = np.concatenate([[0.0], np.cumsum(_part_integrals(cycle, volume, ends))])
    exponent = cycle.heat_capacity_ratio
    closing = float(volume.at(angle_deg=cycle.intake_closes_deg))
    relative = volume.at(angle_deg=angles_deg) / closing
    rise = (exponent - 1.0) / closing * integrals[place[: angles_deg.size]] / relative**exponent
    return np.asarray(rise, dtype=np.float64)


def _part_integrals(cycle: GasCycle, volume: CylinderVolume, ends: FloatArray) -> FloatArray:
    """Return the integrals of (V / V_closing)^(g - 1) dx between neighboring ends of shape (n,).

    The ends are roots r of the share t = r^q of the duration; dx = a (m + 1) t^m exp(-a t^(m + 1))
    dt / c and dt = q r^(q - 1) dr.
    """
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    half = 0.5 * np.diff(ends)[:, np.newaxis]
    root = ends[:-1, np.newaxis] + half * (1.0 + nodes)
    factor = -math.log1p(-cycle.wiebe_completeness)
    power = ROOT_POWER * (cycle.wiebe_shape + 1.0)
    burnt_by_root = (
        factor
        / cycle.wiebe_completeness
        * power
        * root ** (power - 1.0)
        * np.exp(-factor * root**power)
    )
    angle_deg = cycle.combustion_start_deg + cycle.combustion_duration_deg * root**ROOT_POWER
    relative = volume.at(angle_deg=angle_deg) / float(volume.at(angle_deg=cycle.intake_closes_deg))
    integrand = burnt_by_root * relative ** (cycle.heat_capacity_ratio - 1.0)
    return np.asarray((half * integrand) @ weights, dtype=np.float64)


def allowed_heat(state: CycleSamples, heat: float) -> float:
    """Return a heat [J] whose peak is not above that of real engines.

    Raises
    ------
    InputError
    """
    nonnegative_number("heat", heat, "J", "combustion releases heat")
    most = state.heat_for_peak(HIGHEST_PEAK)
    if heat > most:
        raise InputError(
            f"heat: given {heat:g} J; allowed are 0 to {most:.6g} J, because more drives the peak above "
            f"{format_mpa(HIGHEST_PEAK)}, which no piston engine withstands."
        )
    return float(heat)


def heat_for_peak(state: CycleSamples, peak_pressure: float) -> float:
    """Return the heat [J] that gives a peak pressure [Pa].

    Raises
    ------
    InputError
    """
    peak = checked_peak(peak_pressure, state.peak(0.0))
    return max(state.heat_for_peak(peak), 0.0)


def checked_peak(peak: float, lowest: float) -> float:
    """Return a peak [Pa] from the lowest, that of compression alone, to the highest of real engines.

    Raises
    ------
    InputError
    """
    # The lowest peak is found to round-off, and it may be what is asked for.
    if not is_number(peak) or not lowest * (1.0 - 1e-12) <= peak <= HIGHEST_PEAK:
        raise InputError(
            f"peak_pressure: given {format_mpa(peak)}; allowed are {mpa_rounded_up(lowest)} to "
            f"{format_mpa(HIGHEST_PEAK)}, because compression alone gives the lowest and no piston engine "
            "withstands more than the highest."
        )
    return max(float(peak), lowest)


def heat_for_mean_pressure(state: CycleSamples, mean_pressure: float) -> float:
    """Return the heat [J] that gives an indicated mean effective pressure [Pa].

    Raises
    ------
    InputError
    """
    lowest = state.mean_pressure(0.0)
    if state.work_per_heat <= 0.0:
        raise no_work_error(mean_pressure)
    highest = state.mean_pressure(state.heat_for_peak(HIGHEST_PEAK))
    inside = is_number(mean_pressure) and mean_pressure <= highest
    if not inside or mean_pressure < lowest - 1e-12 * abs(lowest):
        raise InputError(
            f"mean_effective_pressure: given {format_mpa(mean_pressure)}; allowed are "
            f"{mpa_rounded_up(lowest)} to "
            f"{mpa_rounded_down(highest)}, because no heat gives the lowest and the highest "
            "drives the peak to "
            f"{format_mpa(HIGHEST_PEAK)}."
        )
    return max(state.heat_for_mean_pressure(mean_pressure), 0.0)


def no_work_error(mean_pressure: float) -> InputError:
    """Return the error for a combustion whose heat does no work."""
    return InputError(
        f"mean_effective_pressure: given {format_mpa(mean_pressure)}; allowed is what a later combustion "
        "gives, because the heat of this one is all released too early to do work."
    )


def mpa_rounded_up(pressure: float) -> str:
    """Return a least pressure in MPa with four digits, rounded up, so that the printed value is allowed."""
    return format_mpa(_rounded(pressure, np.ceil))


def mpa_rounded_down(pressure: float) -> str:
    """Return a largest pressure in MPa with four digits, rounded down."""
    return format_mpa(_rounded(pressure, np.floor))


def _rounded(pressure: float, to_whole: Callable[[float], float]) -> float:
    if not pressure or not np.isfinite(pressure):
        return pressure
    step = 10.0 ** (np.floor(np.log10(abs(pressure))) - 3)
    return float(to_whole(pressure / step) * step)


def format_mpa(pressure: float) -> str:
    """Return a pressure in MPa for a message, or the given value if it is none."""
    return f"{pressure / 1e6:.6g} MPa" if is_number(pressure) else repr(pressure)
