"""Any quantity that vibrates by orders: motions, loads, stresses."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.checks import ComplexArray, FloatArray, finite_vector
from dynamics.response.excitation import at_angles, checked_speed_index
from dynamics.response.synthesis import Synthesis, synthesis
from geometry.errors import InputError


@dataclass(frozen=True, eq=False)
class OrderSeries:
    """Values by order, speed and place: y = Re sum_k Y_k exp(i k phi) at the shaft angle phi.

    Parameters
    ----------
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speeds : ndarray of shape (S,)
        [rad/s].
    values : ndarray of shape (K, S, p), complex
        Zero where unbounded, so that sums stay numbers.
    unbounded : ndarray of shape (K, S), bool
        Where there is no steady vibration.
    names : tuple of p str
        Of the places.
    """

    orders: FloatArray
    speeds: FloatArray
    values: ComplexArray
    unbounded: NDArray[np.bool_]
    names: tuple[str, ...]

    @cached_property
    def amplitude(self) -> FloatArray:
        """Amplitude by order, speed and place, (K, S, p); inf where unbounded."""
        return with_unbounded(np.abs(self.values), self.unbounded)

    @cached_property
    def synthesis(self) -> Synthesis:
        """Sum of all orders over the cycle, and the plain sum of amplitudes, (S, p) each."""
        return synthesis(self.orders, self.speeds, self.values, self.unbounded)

    def at_angle(self, speed_index: int, shaft_angle: ArrayLike) -> FloatArray:
        """Return the values over shaft angles, all orders together, without their mean.

        Parameters
        ----------
        speed_index : int
            Which of the speeds, from 0.
        shaft_angle : array_like of shape (m,)
            [rad].

        Returns
        -------
        ndarray of shape (m, p)

        Raises
        ------
        InputError
            If there is no such speed, an angle is not finite, or the vibration is unbounded there.
        """
        place = checked_speed_index(speed_index, self.speeds)
        angles = finite_vector("shaft_angle", shaft_angle)
        if np.any(self.unbounded[:, place]):
            order = self.orders[np.flatnonzero(self.unbounded[:, place])[0]]
            raise InputError(
                f"speed_index: given {place}, where order {order:g} excites an undamped mode at its "
                "own frequency; allowed are speeds with a steady vibration, because this one grows "
                "without bounds."
            )
        return at_angles(self.orders, self.values[:, place], angles)


def with_unbounded(values: FloatArray, unbounded: NDArray[np.bool_]) -> FloatArray:
    """Return values (K, S, ...) with inf where the answer is unbounded (K, S)."""
    where = unbounded.reshape(unbounded.shape + (1,) * (values.ndim - unbounded.ndim))
    return np.where(where, np.inf, values)
