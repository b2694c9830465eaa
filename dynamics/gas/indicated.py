"""Indicated work: the integral of the pressure over the volume, once round the cycle."""

import math

import numpy as np
from numpy.typing import ArrayLike

from dynamics.checks import FloatArray, finite_vector, positive_number
from dynamics.cycle import checked_strokes
from geometry.errors import InputError


def indicated_work(pressure: ArrayLike, volume_slope: ArrayLike, strokes: int = 4) -> float:
    """Return the work of the gas on the piston over one cycle.

    Parameters
    ----------
    pressure : array_like of shape (m,)
        Pressure at even crank angles over the whole cycle [Pa], the closing sample left out. A
        constant pressure under the piston may be taken off or not: it does no work over a turn.
    volume_slope : array_like of shape (m,)
        Derivative of the volume by the crank angle there [m^3/rad]: piston area times the
        piston's way towards the shaft per radian.
    strokes : int, optional
        Strokes per cycle, 2 or 4.

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
    return _cycle_integral("pressure", pressure, "volume_slope", volume_slope, strokes)


def torque_work(torque: ArrayLike, strokes: int = 4) -> float:
    """Return the work of a torque over one cycle.

    Parameters
    ----------
    torque : array_like of shape (m,)
        Torque in the sense of rotation at even crank angles over the whole cycle [N m], the
        closing sample left out.
    strokes : int, optional
        Strokes per cycle, 2 or 4.

    Returns
    -------
    float
        Integral of the torque over the crank angle [J].

    Raises
    ------
    InputError
        If there is no torque or one is not finite.
    """
    values = finite_vector("torque", torque)
    return _cycle_integral("torque", values, "angle", np.ones(values.size), strokes)


def indicated_mean_effective_pressure(work: float, swept: float) -> float:
    """Return the work of one cycle per swept volume.

    Parameters
    ----------
    work : float
        Work of one cycle [J].
    swept : float
        Swept volume [m^3].

    Returns
    -------
    float
        Mean effective pressure [Pa].

    Raises
    ------
    InputError
        If the volume is not above zero.
    """
    return work / positive_number("swept", swept, "m^3", "the work is taken per swept volume")


def work_mismatch(
    pressure: ArrayLike, volume_slope: ArrayLike, torque: ArrayLike, strokes: int = 4
) -> float:
    """Return how far the work of the gas torque misses the indicated work.

    Parameters
    ----------
    pressure, volume_slope : array_like of shape (m,)
        As for `indicated_work`.
    torque : array_like of shape (m,)
        Torque of the gas force at the same crank angles [N m].
    strokes : int, optional
        Strokes per cycle, 2 or 4.

    Returns
    -------
    float
        Difference of the works, as a share of the work that goes to and fro, the integral of
        |p dV|; round-off for a torque that follows from the same pressure by equilibrium.

    Raises
    ------
    InputError
        If lengths differ or a number is not finite.
    """
    values = finite_vector("torque", torque)
    work = indicated_work(pressure, volume_slope, strokes)
    turned = np.abs(finite_vector("pressure", pressure))
    scale = indicated_work(turned, np.abs(finite_vector("volume_slope", volume_slope)), strokes)
    if values.size != turned.size:
        raise InputError(
            f"torque: given {values.size} values for {turned.size} pressures; allowed is one for "
            "each, because they are compared over the same cycle."
        )
    return abs(torque_work(values, strokes) - work) / scale if scale > 0.0 else 0.0


def periodic_slope(values: FloatArray, period: float) -> FloatArray:
    """Return the derivative of a smooth periodic function from even samples over its period.

    Parameters
    ----------
    values : ndarray of shape (m,)
        Samples over one period, the closing one left out.
    period : float
        Length of the period.

    Returns
    -------
    ndarray of shape (m,)
        The derivative of the Fourier series through the samples at the samples: exact up to
        round-off where the series has died out before half the sampling rate, as that of a piston's
        way has.
    """
    transform = np.fft.rfft(values)
    orders = np.arange(transform.size, dtype=np.float64)
    # An order at half the sampling rate alternates in sign and has no slope at the samples; here it
    # is imaginary and left out by the inverse transform.
    slope = np.fft.irfft(2j * math.pi / period * orders * transform, n=values.size)
    return np.asarray(slope, dtype=np.float64)


def _cycle_integral(
    first_name: str, first: ArrayLike, second_name: str, second: ArrayLike, strokes: int
) -> float:
    one, other = finite_vector(first_name, first), finite_vector(second_name, second)
    if one.size != other.size or one.size == 0:
        raise InputError(
            f"{second_name}: given {other.size} values for {one.size} of {first_name}; allowed is "
            "one for each and at least one, because they are multiplied at each angle."
        )
    return math.pi * checked_strokes(strokes) * float(one @ other) / one.size
