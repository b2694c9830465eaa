"""Functions of the crank angle that repeat every revolution, given at even angles."""

import math
from typing import TYPE_CHECKING

import numpy as np

from crankbase.checks.arrays import FloatArray
from dynamics.cycle import even_angles

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

TURN = 2.0 * math.pi


def turn_integral(samples: FloatArray) -> float:
    """Return the integral over a revolution of a function given at even angles.

    The plain sum is exact for all harmonics that the samples resolve.
    """
    return TURN * float(np.mean(samples))


def antiderivative(samples: FloatArray) -> FloatArray:
    """Return the integral from the first angle to each one, for samples of mean zero.

    Harmonic by harmonic. A mean is left out: its integral would not be periodic.
    """
    spectrum = np.fft.rfft(samples)
    spectrum[1:] /= 1j * np.arange(1, spectrum.size)
    spectrum[0] = 0.0
    found = np.fft.irfft(spectrum, samples.size)
    return np.asarray(found - found[0])


def periodic_spline(samples: FloatArray) -> "CubicSpline":
    """Return the cubic spline that repeats every turn through samples at even angles."""
    from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

    angles = np.append(even_angles(TURN, samples.size), TURN)
    return CubicSpline(angles, np.append(samples, samples[0]), bc_type="periodic")
