"""Measured orders over the speed, which all records end in and all comparisons begin with."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from crankbase.array_checks import (
    Array,
    ComplexArray,
    Flags,
    Integers,
    check_shape,
    read_only,
)
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.frames import DataFrame, table
from crankbase.results import result
from dynamics.response.damped_criticals import DampedCritical
from dynamics.response.order_excitation import checked_orders

Measurand = Literal["angle", "torque", "axial", "pressure"]
UNITS: dict[Measurand, str] = {"angle": "rad", "torque": "N m", "axial": "m", "pressure": "Pa"}
MEASURANDS: dict[str, Measurand] = {unit: quantity for quantity, unit in UNITS.items()}
PRINTED_UNITS = {"rad": "deg", "N m": "kN m", "m": "mm", "Pa": "bar"}
# The note on orders with a constant of the wheel.
OF_WHEEL = (
    "Each whole order holds a constant of the wheel, which one sensor cannot tell from vibration; that of "
    "order 1 holds its eccentricity."
)


@result("orders", "speed [rad/s]", "place", "quantity", "method")
class MeasuredOrders:
    """Complex amplitudes of orders at several speeds, in the convention of the calculated responses.

    At the rigid angle phi, that of the mean rotation alone, the signal is Re sum_k X_k exp(i k phi). It is
    positive where the calculated one is: an angle in the direction of rotation, an axial motion towards the
    drive, and the torque in an element where it drives its first node forwards, as `ElementLoads.elastic`.
    Angles hold the part of the rigid body, as `ForcedResponse.nodes` does. The angle phi is zero where the
    engine file's shaft angle is; where `zero_known` is false it counts from the mark of the wheel, and the
    calculated amplitudes are X_k exp(-i k a), with a the unknown shaft angle at the mark.

    Parameters
    ----------
    orders : ndarray of shape (k,)
        Ascending, in cycles per crankshaft revolution.
    speed : ndarray of shape (m,)
        Mean speed of each window, in the order of time; speeds may repeat [rad/s].
    amplitude : ndarray of shape (m, k), complex
        [rad, N m, m or Pa, by the quantity].
    scatter : ndarray of shape (m, k)
        Standard deviation of the error of the real part, and of the imaginary part.
    place : str
        Mass of the chain, or element for a torque, where it was measured; empty if not known.
    quantity : {"angle", "torque", "axial", "pressure"}
        What was measured.
    correlation : ndarray of shape (m, m)
        Of the errors at two speeds, the same for every order: what windows share counts once.
    ramp : ndarray of shape (m,)
        Change of the speed with time [rad/s^2].
    wheel_constant : ndarray of shape (k,), bool
        Orders that hold one unknown complex constant besides, the same at all speeds: the pitch errors of
        the wheel and its eccentricity.
    cycle : {1, 2}
        Revolutions per working cycle.
    zero_known : bool
        Whether the angle counts from that of the engine file.
    method : str
        How the orders were found.
    notes : tuple of str
        What was mended, and what the record cannot tell; one sentence each.

    Raises
    ------
    InputError
        If shapes do not agree, or values are out of range.
    """

    orders: Array
    speed: Array
    amplitude: ComplexArray
    scatter: Array
    place: str
    quantity: Measurand
    correlation: Array
    ramp: Array
    wheel_constant: Flags
    cycle: int
    zero_known: bool
    method: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_choice("quantity", self.quantity, get_args(Measurand), "these can be calculated too")
        orders = checked_orders(self.orders)
        speed = np.asarray(self.speed, dtype=float)
        count, known = speed.size, orders.size
        if speed.ndim != 1 or not count or not np.all(np.isfinite(speed) & (speed > 0.0)):
            raise InputError("speed: allowed are finite speeds above zero, one for each window.")
        check_shape("amplitude", np.abs(self.amplitude), (count, known))
        check_shape("scatter", self.scatter, (count, known))
        check_shape("correlation", self.correlation, (count, count))
        check_shape("ramp", self.ramp, (count,))
        if np.shape(self.wheel_constant) != (known,):
            raise InputError("wheel_constant: allowed is one flag for each order.")
        if self.cycle not in (1, 2):
            raise InputError(f"cycle: given {self.cycle}; allowed are 1 and 2 revolutions.")
        for name, values in (
            ("orders", orders),
            ("speed", speed),
            ("amplitude", np.asarray(self.amplitude, dtype=complex)),
            ("scatter", np.asarray(self.scatter, dtype=float)),
            ("correlation", np.asarray(self.correlation, dtype=float)),
            ("ramp", np.asarray(self.ramp, dtype=float)),
            ("wheel_constant", np.asarray(self.wheel_constant, dtype=bool)),
        ):
            object.__setattr__(self, name, read_only(values.copy()))

    @property
    def unit(self) -> str:
        """Unit of the amplitudes."""
        return UNITS[self.quantity]

    @cached_property
    def independent(self) -> float:
        """Number of independent speeds over that of all: overlapping windows count once."""
        return float(self.speed.size / np.sum(self.correlation))

    def part(
        self, rows: Flags | Integers | None = None, columns: Flags | None = None
    ) -> "MeasuredOrders":
        """Return some speeds and some orders; all, unless given."""
        rows = np.arange(self.speed.size) if rows is None else np.arange(self.speed.size)[rows]
        columns = np.ones(self.orders.size, dtype=bool) if columns is None else columns
        return replace(
            self,
            orders=self.orders[columns],
            speed=self.speed[rows],
            amplitude=self.amplitude[rows][:, columns],
            scatter=self.scatter[rows][:, columns],
            correlation=self.correlation[np.ix_(rows, rows)],
            ramp=self.ramp[rows],
            wheel_constant=self.wheel_constant[columns],
        )

    def to_pandas(self) -> DataFrame:
        """Return a row for each speed and order; units are in ``frame.attrs["units"]``."""
        windows, orders = self.amplitude.shape
        return table(
            {
                "speed": (np.repeat(self.speed, orders), "rad/s"),
                "order": (np.tile(self.orders, windows), "1"),
                "amplitude": (np.abs(self.amplitude).ravel(), self.unit),
                "phase": (np.angle(self.amplitude).ravel(), "rad"),
                "scatter": (self.scatter.ravel(), self.unit),
                "ramp": (np.repeat(self.ramp, orders), "rad/s^2"),
            }
        )


def largest_lag(measured: MeasuredOrders, peaks: Iterable[DampedCritical]) -> float:
    """Return n dw/dt / (z w)^2 of the peaks passed, the largest: by so much a steady response is off."""
    low, high = float(measured.speed.min()), float(measured.speed.max())
    passed = [
        peak for peak in peaks if peak.has_peak and low <= peak.speed <= high and peak.in_band
    ]
    orders = np.array([peak.order for peak in passed])
    decay = np.array([peak.damping_ratio * 2.0 * np.pi * peak.mode_frequency for peak in passed])
    steepest = float(np.max(np.abs(measured.ramp)))
    return float(np.max(orders * steepest / decay**2, initial=0.0))


def agreeing_angle(orders: Array, products: ComplexArray, tried: Array) -> float:
    """Return the angle a [rad], of those tried, by which one set of orders turned agrees best with another.

    Parameters
    ----------
    products : ndarray of shape (k,), complex
        Sums over the speeds of X Y*, perhaps weighed, of the X_k that are turned by exp(-i k a).
    """
    turned = np.exp(-1j * np.outer(tried, orders))
    return float(tried[np.argmax((turned @ products).real)])
