"""Indicated work: the integral of the pressure over the volume around the cycle."""

import math

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_vector, positive_number
from crankbase.errors import InputError
from dynamics.cycle import checked_strokes


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
    pressing = finite_vector("pressure", pressure)
    slope = finite_vector("volume_slope", volume_slope)
    if pressing.size != slope.size or pressing.size == 0:
        raise InputError(
            f"volume_slope: given {slope.size} values for {pressing.size} of pressure; allowed is one "
            "for each and at least one, because they are multiplied at each angle."
        )
    return math.pi * checked_strokes(strokes) * float(pressing @ slope) / pressing.size


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


def periodic_slope(values: FloatArray, period: float) -> FloatArray:
    """Return the derivative of a smooth periodic function from even samples over its period.

    Parameters
    ----------
    values : ndarray of shape (m,)
        Samples over one period, without the closing one.
    period : float
        Length of the period.

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
