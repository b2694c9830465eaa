"""The closed part of the cycle, from intake closing to exhaust opening, by the first law."""

import math

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_vector
from dynamics.gas.cycle_values import GasCycle
from dynamics.gas.cylinder_volume import CylinderVolume

# The combustion is integrated over r, where r^4 is the share of its duration: the rate of heat
# release, which may begin as any power of the share, begins smoothly over r. Parts besides those
# between the angles asked for, and Gauss points in each, bring the integral to 1e-12 for
# shapes up to 10.
ROOT_POWER = 4
PARTS = 96
GAUSS_POINTS = 6


def motored_pressure(cycle: GasCycle, volume: CylinderVolume, angle: ArrayLike) -> FloatArray:
    """Return the pressure without combustion, isentropic from the closing of the intake.

    Parameters
    ----------
    cycle : GasCycle
        Intake pressure, intake closing and ratio of heat capacities g.
    volume : CylinderVolume
        Volume V over the piston.
    angle : array_like of any shape
        Crank angles within the closed part [rad].

    Returns
    -------
    ndarray of the same shape
        p_closing (V_closing / V)^g [Pa].
    """
    ratio = volume.at(cycle.intake_closes) / volume.at(angle)
    return np.asarray(cycle.intake_pressure * ratio**cycle.heat_capacity_ratio, dtype=np.float64)


def pressure_rise_per_heat(cycle: GasCycle, volume: CylinderVolume, angle: ArrayLike) -> FloatArray:
    """Return by how much one joule of heat raises the pressure.

    Parameters
    ----------
    cycle : GasCycle
        Combustion and ratio of heat capacities g.
    volume : CylinderVolume
        Volume V over the piston.
    angle : array_like of shape (m,)
        Crank angles within the closed part [rad], in any order.

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
    d(p V^g) = (g - 1) V^(g - 1) dQ, so that the pressure is that without combustion plus the heat
    times this rise. The integral is taken by Gauss's rule in parts.
    """
    angles = finite_vector("angle", angle)
    share = (angles - cycle.combustion_start) / cycle.combustion_duration
    root = np.clip(share, 0.0, 1.0) ** (1.0 / ROOT_POWER)
    ends, place = np.unique(
        np.concatenate([root, np.linspace(0.0, 1.0, PARTS + 1)]), return_inverse=True
    )
    integrals = np.concatenate([[0.0], np.cumsum(_part_integrals(cycle, volume, ends))])
    exponent = cycle.heat_capacity_ratio
    closing = float(volume.at(cycle.intake_closes))
    relative = volume.at(angles) / closing
    rise = (exponent - 1.0) / closing * integrals[place[: angles.size]] / relative**exponent
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
    angle = cycle.combustion_start + cycle.combustion_duration * root**ROOT_POWER
    relative = volume.at(angle) / float(volume.at(cycle.intake_closes))
    integrand = burnt_by_root * relative ** (cycle.heat_capacity_ratio - 1.0)
    return np.asarray((half * integrand) @ weights, dtype=np.float64)
