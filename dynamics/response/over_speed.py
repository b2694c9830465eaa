"""Amplitudes interpolated between known speeds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, eq=False)
class OverSpeed:
    """Amplitudes by orders as piecewise polynomials of the speed.

    Parameters
    ----------
    speeds : ndarray of shape (S,)
        Ascending [rad/s].
    coefficients : complex ndarray of shape (pieces, powers, K, n)
        By powers of the speed above the piece's lower end, the highest first; one piece of one power
        for a single known speed.
    """

    speeds: FloatArray
    coefficients: ComplexArray

    @classmethod
    def of(cls, speeds: FloatArray, amplitudes: ComplexArray) -> "OverSpeed":
        """Return the curves through amplitudes (K, S, n).

        Notes
        -----
        A cubic spline, through three speeds a parabola. Two speeds alone are joined by a + b w^2,
        not linearly. All are exact for constants and squares of the speed.
        """
        values = amplitudes.swapaxes(0, 1)
        if speeds.size == 1:
            return cls(speeds, values[:, np.newaxis])
        if speeds.size == 2:
            square = (values[1] - values[0]) / (speeds[1] ** 2 - speeds[0] ** 2)
            return cls(speeds, np.array([[square, 2.0 * speeds[0] * square, values[0]]]))
        from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

        return cls(speeds, np.asarray(CubicSpline(speeds, values).c).swapaxes(0, 1))

    def pieces(self, speeds: FloatArray) -> NDArray[np.int64]:
        """Return the pieces of speeds; the first and the last one are extrapolated."""
        found = np.searchsorted(self.speeds, speeds, "right") - 1
        return np.asarray(np.clip(found, 0, len(self.coefficients) - 1))

    def at(self, order_index: NDArray[np.int64], speeds: FloatArray) -> ComplexArray:
        """Return amplitudes at pairs of order and speed, which are broadcast, shape (..., n)."""
        pieces = self.pieces(speeds)
        above = (speeds - self.speeds[pieces])[..., np.newaxis]
        total = self.coefficients[pieces, 0, order_index]
        for power in range(1, self.coefficients.shape[1]):
            total = total * above + self.coefficients[pieces, power, order_index]
        return np.asarray(total)
