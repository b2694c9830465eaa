"""Exciting forces by orders over a range of speeds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    Integers,
    check_sizes,
    complex_array,
    positive_vector,
    radians_of,
    read_only,
)
from crankbase.choices import check_some, whole_within
from crankbase.errors import InputError
from crankbase.frames import Dataset, grid
from crankbase.results import result
from dynamics.harmonics import Harmonics
from dynamics.plots.curves import Quantity, orders_and_speeds, quantity_display


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

    speeds: Array
    coefficients: ComplexArray

    @classmethod
    def of(cls, speeds: Array, amplitudes: ComplexArray) -> "OverSpeed":
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

    def pieces(self, speeds: Array) -> Integers:
        """Return the pieces of speeds; the first and the last one are extrapolated."""
        places = np.searchsorted(self.speeds, speeds, "right") - 1
        return np.asarray(np.clip(places, 0, len(self.coefficients) - 1))

    def at(self, order_index: Integers, speeds: Array) -> ComplexArray:
        """Return amplitudes at pairs of order and speed, which are broadcast, shape (..., n)."""
        pieces = self.pieces(speeds)
        above = (speeds - self.speeds[pieces])[..., np.newaxis]
        total = self.coefficients[pieces, 0, order_index]
        for power in range(1, self.coefficients.shape[1]):
            total = total * above + self.coefficients[pieces, power, order_index]
        return np.asarray(total)


# Room for the round-off of a speed at the end of a range.
ROOM = 1e-12


@result("orders", "speeds [rad/s]", "forces")
class OrderExcitation:
    """Forces on the nodes of a system, by order and speed.

    At the shaft angle phi the force is the real part of the sum over the orders k of
    F_k exp(i k phi), and an order acts at the angular frequency k times speed. The mean force is
    not included: it deforms the shaft, but does not make it vibrate.

    Parameters
    ----------
    orders : array_like of shape (K,)
        Above zero, ascending, in cycles per crankshaft revolution.
    speeds : array_like of shape (S,)
        Speed of the crankshaft [rad/s], above zero, ascending.
    forces : array_like of shape (K, S, n), complex
        Amplitudes of the forces on the n nodes [N m on a torsional chain, N on an axial one].
    pressing : array_like of shape (K, S, e), complex, optional
        Amplitudes of the forces with which the e elements of a chain push their ends apart, as forces
        within them would lengthen them; in the same units. They are among `forces`, -P on an element's
        first node and P on its second, and are no load of the element: that is its spring's less P.

    Raises
    ------
    InputError
        If orders or speeds are not above zero and ascending, or the forces are not finite numbers
        for every order, speed and node or element.
    """

    orders: Array
    speeds: Array
    forces: ComplexArray
    pressing: ComplexArray | None = None

    def __post_init__(self) -> None:
        orders = checked_orders(self.orders)
        speeds = checked_speeds(self.speeds)
        object.__setattr__(self, "orders", read_only(orders))
        object.__setattr__(self, "speeds", read_only(speeds))
        self._check("forces", self.forces, "n", "node")
        if self.pressing is not None:
            self._check("pressing", self.pressing, "e", "element")

    def _check(self, name: str, values: ArrayLike, count: str, place: str) -> None:
        """Check and keep the amplitudes of one kind."""
        array, known = complex_array(name, values), (self.orders.size, self.speeds.size)
        if array.ndim != 3 or array.shape[:2] != known:
            raise InputError(
                f"{name}: given an array of shape {array.shape}; allowed is ({known[0]}, {known[1]}, "
                f"{count}), because there is one for each order, speed and {place}."
            )
        check_sizes(name, array)
        array.setflags(write=False)
        object.__setattr__(self, name, array)

    @property
    def angular_frequencies(self) -> Array:
        """Angular frequency of each order at each speed [rad/s], (K, S)."""
        return np.outer(self.orders, self.speeds)

    @property
    def acting(self) -> ComplexArray:
        """Forces on the nodes, and after them those with which elements push, (K, S, n) or (K, S, n + e)."""
        if self.pressing is None:
            return self.forces
        return np.concatenate((self.forces, self.pressing), axis=2)

    def at_angle(self, speed_index: int, *, shaft_angle_deg: ArrayLike) -> Array:
        """Return the forces at shaft angles, all orders together, without their mean, (m, n).

        Parameters
        ----------
        speed_index : int
            Which of the speeds, from 0.
        shaft_angle_deg : array_like of shape (m,)
            [deg].

        Raises
        ------
        InputError
            If there is no such speed, or an angle is not a finite number.
        """
        place = checked_speed_index(speed_index, self.speeds)
        angles = radians_of("shaft_angle_deg", shaft_angle_deg, vector=True)
        return at_angles(self.orders, self.forces[:, place], angles)

    def at_speeds(self, speeds: ArrayLike) -> "OrderExcitation":
        """Return the excitation at other speeds within the range, interpolated.

        The amplitudes at three or more speeds are interpolated by a cubic spline, those at two linearly
        in the squared speed. Both are exact for constants and for quantities that, like inertia
        forces, grow with the square of the speed.

        Raises
        ------
        InputError
            If the speeds are not ascending, or outside the range.
        """
        wanted = checked_speeds(speeds)
        every = np.arange(self.orders.size)[:, np.newaxis]
        acting, count = acting_at(self, every, wanted), self.forces.shape[2]
        pressing = None if self.pressing is None else acting[:, :, count:]
        return OrderExcitation(self.orders, wanted, acting[:, :, :count], pressing)

    def to_xarray(self, quantity: Quantity | None = None) -> Dataset:
        """Return complex ``forces`` over order, speed and node.

        Units and errors are those of `crankbase.frames.grid`.

        `quantity`, for the unit of the axis, is that of `quantity_display`.
        """
        unit = quantity_display(quantity, "N m or N").unit
        over = ("order", "speed", "node")
        nodes = np.arange(self.forces.shape[2])
        return grid(
            {"forces": (over, self.forces, unit, "phasor of the exciting force or torque")},
            {
                **orders_and_speeds(self.orders, self.speeds),
                "node": (nodes, "1", "number of the node, from 0"),
            },
        )


def acting_at(excitation: OrderExcitation, order_index: Integers, speeds: Array) -> ComplexArray:
    """Return what acts at pairs of order and speed [rad/s] (m,), which are broadcast, interpolated."""
    low, high = excitation.speeds[[0, -1]]
    outside = (speeds < low * (1.0 - ROOM)) | (speeds > high * (1.0 + ROOM))
    if np.any(outside):
        raise InputError(
            f"speeds: given {speeds[outside][0]:g} rad/s; allowed are {low:g} to {high:g} rad/s, "
            "because the excitation is known between them."
        )
    over_speed = OverSpeed.of(excitation.speeds, excitation.acting)
    return over_speed.at(order_index, np.clip(speeds, low, high))


def phasors_of(harmonics: Harmonics, orders: ArrayLike) -> ComplexArray:
    """Return the amplitudes Y_k = A_k - i B_k of orders from the harmonics of samples.

    Parameters
    ----------
    orders : array_like of shape (K,)
        Ascending, in cycles per crankshaft revolution.

    Returns
    -------
    ndarray of shape (K,), complex
        Phases count from the same angle as those of the harmonics.

    Raises
    ------
    InputError
        If the samples do not resolve an order: a higher one would appear as a lower one, and at
        half the sampling rate they determine one part only.
    """
    wanted = checked_orders(orders)
    places = [harmonics.index_of(order) for order in wanted.tolist()]
    if harmonics.samples % 2 == 0 and places[-1] == harmonics.samples // 2 - 1:
        raise InputError(
            f"order: given {wanted[-1]:g}; allowed are those below {harmonics.highest_order:g}, because "
            f"{harmonics.samples} samples over one cycle show two values to each wave of it, which do not "
            "separate its amplitude from its phase."
        )
    return np.asarray(harmonics.cosine[places] - 1j * harmonics.sine[places])


def at_angles(orders: Array, phasors: ComplexArray, shaft_angles: Array) -> Array:
    """Return Re sum_k Y_k exp(i k phi): phasors (K, ...) at angles (m,) give (m, ...)."""
    turning = np.exp(1j * np.outer(shaft_angles, orders))
    return np.asarray(np.tensordot(turning, phasors, axes=1).real)


def checked_orders(orders: ArrayLike) -> Array:
    """Return orders (K,), above zero and ascending."""
    values = positive_vector("orders", orders, "", "they count cycles per crankshaft revolution")
    check_ascending("orders", values, "", "each order counts once")
    return values


def checked_speeds(speeds: ArrayLike) -> Array:
    """Return speeds (S,) [rad/s], above zero and ascending."""
    values = positive_vector("speeds", speeds, "rad/s", "an order of a shaft at rest is no motion")
    check_ascending("speeds", values, " rad/s", "a speed range runs from the lowest to the highest")
    return values


def checked_speed_index(speed_index: int, speeds: Array) -> int:
    """Return the index of a speed, from 0."""
    reason = f"there are {speeds.size} speeds"
    return whole_within("speed_index", speed_index, 0, speeds.size - 1, reason)


def check_ascending(field: str, values: Array, unit: str, why: str) -> None:
    """Refuse values that do not ascend, or are empty."""
    check_some(field, values, why)
    falling = np.flatnonzero(np.diff(values) <= 0.0)
    if falling.size:
        place = int(falling[0]) + 1
        raise InputError(
            f"{field}[{place}]: given {values[place]:g}{unit} after {values[place - 1]:g}{unit}; "
            f"allowed are ascending values, because {why}."
        )
