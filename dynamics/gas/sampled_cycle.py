"""The cycle model at even crank angles, as a pressure that is linear in the heat."""

from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray
from dynamics.gas.closed_cycle import motored_pressure, pressure_rise_per_heat
from dynamics.gas.cycle_values import BOTTOM, GasCycle
from dynamics.gas.cylinder_volume import CylinderVolume
from dynamics.gas.indicated import indicated_work, periodic_slope


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
        """By how much one more joule of heat raises the indicated work [J/J]."""
        return indicated_work(self.rise, self.volume_slope, self.strokes)

    def heat_for_peak(self, peak: float) -> float:
        """Return the heat [J] at which the first sample reaches the peak [Pa]."""
        rising = self.rise > 0.0
        return float(np.min((peak - self.motored[rising]) / self.rise[rising]))

    def heat_for_mean_pressure(self, mean_pressure: float) -> float:
        """Return the heat [J] for an indicated mean effective pressure [Pa]."""
        return (mean_pressure * self.swept - self.work(0.0)) / self.work_per_heat


def cycle_samples(cycle: GasCycle, volume: CylinderVolume, angles: FloatArray) -> CycleSamples:
    """Return the cycle at its samples.

    Parameters
    ----------
    cycle : GasCycle
        Its parameters.
    volume : CylinderVolume
        The volume over the piston.
    angles : ndarray of shape (m,)
        Even crank angles from zero over the cycle [rad], the closing one left out.

    Returns
    -------
    CycleSamples
        Pressure and volume slope there.
    """
    share = _closed_share(cycle, angles)
    closed = share > 0.0
    within = np.where(angles > BOTTOM, angles - cycle.cycle, angles)[closed]
    open_pressure = _open_pressure(cycle, angles)
    motored = open_pressure.copy()
    motored[closed] += share[closed] * (
        motored_pressure(cycle, volume, within) - open_pressure[closed]
    )
    rise = np.zeros(angles.size)
    rise[closed] = share[closed] * pressure_rise_per_heat(cycle, volume, within)
    return CycleSamples(
        motored=motored,
        rise=rise,
        volume_slope=periodic_slope(volume.at(angles), cycle.cycle),
        swept=volume.swept,
        strokes=cycle.strokes,
    )


def _closed_share(cycle: GasCycle, angles: FloatArray) -> FloatArray:
    """Return 1 where the cylinder is closed, 0 where it is open, between in the blow-down."""
    share = 1.0 - _smooth_step(angles, cycle.exhaust_opens, BOTTOM)
    return np.where(angles >= cycle.intake_closes + cycle.cycle, 1.0, share)


def _open_pressure(cycle: GasCycle, angles: FloatArray) -> FloatArray:
    """Return the pressure of the exhaust, then of the intake, passing over in the overlap [Pa]."""
    passed = _smooth_step(angles, cycle.overlap_begins, cycle.overlap_ends)
    return cycle.exhaust_pressure + passed * (cycle.intake_pressure - cycle.exhaust_pressure)


def _smooth_step(angles: FloatArray, begin: float, end: float) -> FloatArray:
    """Return 3 t^2 - 2 t^3, from 0 at the begin to 1 at the end with no slope at either."""
    share = np.clip((angles - begin) / (end - begin), 0.0, 1.0)
    return np.asarray(share**2 * (3.0 - 2.0 * share), dtype=np.float64)
