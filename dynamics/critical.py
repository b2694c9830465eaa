"""Critical speeds: where an engine order meets a natural frequency, and which orders are major."""

import math
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    finite_vector,
    nonnegative_vector,
    positive_number,
    positive_vector,
)
from crankbase.choices import check_one_each, check_some, number_within
from crankbase.errors import InputError
from crankbase.frames import Row
from crankbase.quantity import RPM
from crankbase.results import Internal, Number, Part, Quantity, Result, Speed, result
from crankbase.sentences import amount
from crankbase.summaries import frozen
from dynamics.cycle import order_step
from dynamics.harmonics import Harmonics
from dynamics.indices import within


@result("stiffness", "frequency", "order", "resonant_speed")
class TwoMassCheck(Result):
    """Natural frequency of two inertias on a shaft, and the speed at which one order meets it.

    Parameters
    ----------
    harmonics : Harmonics or None
        Those of the exciting torque [N m], if given.
    """

    stiffness: Annotated[float, Quantity("N m/rad", "C_np, torsional stiffness of the shaft")]
    angular_frequency: Annotated[float, Quantity("rad/s", "w_c1, natural angular frequency")]
    order: Number
    harmonics: Internal[Harmonics | None] = None

    @property
    def frequency(self) -> Annotated[float, Quantity("Hz")]:
        """Natural frequency."""
        return self.angular_frequency / (2.0 * math.pi)

    @property
    def vibrations_per_minute(self) -> Annotated[float, Quantity("1/min")]:
        """Natural vibrations per minute."""
        return self.angular_frequency * RPM

    @cached_property
    def resonant_speed(self) -> Speed:
        """Crankshaft speed at which the order meets the natural frequency."""
        return self.angular_frequency / self.order

    @property
    def resonant_speed_rpm(self) -> float:
        """Crankshaft speed at which the order meets the natural frequency [1/min]."""
        return self.vibrations_per_minute / self.order

    @property
    def resolved(self) -> bool | None:
        """Whether the torque's samples resolve the order; None if no torque was given."""
        return None if self.harmonics is None else self.harmonics.resolves(self.order)

    @cached_property
    def statement(self) -> Part[str]:
        """One sentence on whether the given torque can resolve the order."""
        if self.harmonics is None:
            return f"No torque table is given: how strongly order {self.order:g} excites is open."
        table = self.harmonics
        revolutions = "two revolutions" if table.strokes == 4 else "one revolution"
        known = (
            f"{table.samples} samples over {revolutions} resolve orders up to "
            f"{table.highest_order:g}"
        )
        if table.resolves(self.order):
            torque = amount(table.amplitude[table.index_of(self.order)], "N m", 4, shown="N m")
            return f"{known}: this table excites order {self.order:g} with {torque}."
        if self.order < table.highest_order:
            known += f" in steps of {order_step(table.strokes):g}"
        return f"{known}: this table cannot excite order {self.order:g}."


def solid_shaft_stiffness(diameter: float, length: float, shear_modulus: float) -> float:
    """Return the torsional stiffness of a solid round shaft.

    Returns
    -------
    float
        C_np [N m/rad].

    Notes
    -----
    C_np = G J / L_np with J = pi d_b^4 / 32, (10) in Makushev, Polyakova, Omsk Scientific Bulletin
    2024 no. 3 (191), doi 10.25206/1813-8225-2024-191-39-47. The stiffness is the torque per
    radian of twist.
    """
    d = positive_number("diameter", diameter, "m", "a shaft has a cross section")
    L = positive_number("length", length, "m", "a shaft has a length")
    G = positive_number("shear_modulus", shear_modulus, "Pa", "the material resists shear")
    return G * math.pi * d**4 / (32.0 * L)


def two_mass_frequency(stiffness: float, inertia_1: float, inertia_2: float) -> float:
    """Return the natural angular frequency of two free inertias joined by a shaft.

    Parameters
    ----------
    stiffness : float
        C_np [N m/rad].

    Returns
    -------
    float
        w_c1 [rad/s].

    Notes
    -----
    w_c1 = sqrt(C_np (J_MAX + J_np) / (J_MAX J_np)), (11) in Makushev, Polyakova 2024,
    doi 10.25206/1813-8225-2024-191-39-47.
    """
    c = positive_number("stiffness", stiffness, "N m/rad", "the shaft holds the inertias together")
    why = "both ends of the shaft vibrate against each other"
    first = positive_number("inertia_1", inertia_1, "kg m^2", why)
    second = positive_number("inertia_2", inertia_2, "kg m^2", why)
    return math.sqrt(c / first + c / second)


def two_mass_check(
    *,
    diameter: float,
    length: float,
    shear_modulus: float,
    inertia_1: float,
    inertia_2: float,
    order: float,
    harmonics: Harmonics | None = None,
) -> TwoMassCheck:
    """Check a crankshaft as two inertias on an equivalent solid shaft.

    Parameters
    ----------
    diameter, length : float
        d_b and L_np of the equivalent shaft [m].
    shear_modulus : float
        G [Pa].
    inertia_1, inertia_2 : float
        J_MAX and J_np [kg m^2].
    harmonics : Harmonics, optional
        Those of the exciting torque [N m], to check whether they resolve the order.

    Raises
    ------
    InputError
        If a value is not a finite number above zero.

    Notes
    -----
    (10) to (14) in Makushev, Polyakova 2024, doi 10.25206/1813-8225-2024-191-39-47.
    """
    stiffness = solid_shaft_stiffness(diameter, length, shear_modulus)
    return TwoMassCheck(
        stiffness=stiffness,
        angular_frequency=two_mass_frequency(stiffness, inertia_1, inertia_2),
        order=positive_number("order", order, "", "it counts cycles per revolution"),
        harmonics=harmonics,
    )


# A vector sum counts as full within this share of its largest possible value.
FULL_SUM_TOLERANCE = 1e-6
HIGHEST_ORDER = 1e5


@frozen("mode", "frequency [Hz]", "order", "speed [rad/s]", "speed_rpm [1/min]")
class CriticalSpeed:
    """A speed at which one order of the excitation meets one natural frequency.

    Parameters
    ----------
    mode : int
        Index of the frequency among those given, from 0. In a free chain, where 0 is the
        rigid-body mode, it equals the number of the mode's nodes.
    frequency : float
        Natural frequency [Hz].
    order : float
        Order of the excitation, in cycles per crankshaft revolution.
    """

    mode: int
    frequency: float
    order: float
    speed: float

    @property
    def speed_rpm(self) -> float:
        """Speed of the crankshaft [1/min]."""
        return self.speed * RPM

    def row(self) -> Row:
        """Return the columns of a table of critical speeds, each value with its unit; see `table_of`.

        Modes are counted from 1, in the order of the given frequencies: with those of the elastic
        modes alone this is the number used for resonances.
        """
        return {
            "mode": (self.mode + 1, "1"),
            "frequency": (self.frequency, "Hz"),
            "order": (self.order, "1"),
            "speed": (self.speed, "rad/s"),
        }


def engine_orders(strokes: int, highest: float) -> Array:
    """Return the orders of an engine up to a highest one.

    Parameters
    ----------
    strokes : int
        Strokes per cycle: 4 gives 0.5, 1, 1.5 ..., 2 gives 1, 2, 3 ...
    highest : float
        Highest order, in cycles per crankshaft revolution.

    Raises
    ------
    InputError
        If strokes is neither 2 nor 4, or `highest` is below the lowest order or above 1e5.
    """
    step = order_step(strokes)
    limit = positive_number("highest", highest, "", "orders count cycles per revolution")
    reason = "no cycle is known so finely that higher orders are more than noise"
    number_within("highest", limit, 0.0, HIGHEST_ORDER, "", reason)
    count = math.floor(limit / step * (1.0 + 1e-12))
    if count == 0:
        raise InputError(
            f"highest: given {limit:g}; allowed is {step:g} or more, because that is the lowest "
            f"order of an engine with {strokes} strokes per cycle."
        )
    return step * np.arange(1, count + 1, dtype=np.float64)


def critical_speeds(
    frequencies: ArrayLike, orders: ArrayLike, speed_range: tuple[float, float]
) -> tuple[CriticalSpeed, ...]:
    """Find the speeds within a range at which an order meets a natural frequency.

    Parameters
    ----------
    frequencies : array_like of shape (n,)
        Natural frequencies [Hz]; 0, a rigid-body mode, has no critical speed.
    orders : array_like of shape (K,)
        Orders of the excitation, in cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Lowest and highest crankshaft speed [rad/s], both included.

    Returns
    -------
    tuple of CriticalSpeed
        In ascending speed.

    Raises
    ------
    InputError
        If a frequency is negative, an order is not above zero, or the range is not above zero and
        ascending.

    Notes
    -----
    order * speed = 2 pi f, (13) in Makushev, Polyakova 2024,
    doi 10.25206/1813-8225-2024-191-39-47.
    """
    natural = nonnegative_vector("frequencies", frequencies, "Hz", "they count vibrations in time")
    excited = positive_vector("orders", orders, "", "they count cycles per revolution")
    limits = positive_vector(
        "speed_range", speed_range, "rad/s", "a critical speed is that of a turning shaft"
    )
    if limits.size != 2 or not limits[0] < limits[1]:
        shown = ", ".join(f"{limit:g}" for limit in limits)
        raise InputError(
            f"speed_range: given ({shown}) rad/s; allowed is the lowest speed and then a higher "
            "one, because critical speeds are looked for between them."
        )
    return meetings(natural, excited, *limits.tolist())


def meetings(natural: Array, orders: Array, low: float, high: float) -> tuple[CriticalSpeed, ...]:
    """Return `critical_speeds` of checked frequencies, orders and ends."""
    speeds = (2.0 * math.pi * natural)[:, np.newaxis] / orders
    crossings = (
        CriticalSpeed(mode, float(natural[mode]), float(orders[k]), float(speeds[mode, k]))
        for mode, k in np.argwhere(within(speeds, low, high)).tolist()
    )
    return tuple(
        sorted(crossings, key=lambda meeting: (meeting.speed, meeting.mode, meeting.order))
    )


def vector_sums(
    orders: ArrayLike, firing_angles: ArrayLike, weights: ArrayLike | None = None
) -> Array:
    """Sum the unit phasors of all cylinders for each order.

    Parameters
    ----------
    orders : array_like of shape (K,)
        Orders, in cycles per crankshaft revolution.
    firing_angles : array_like of shape (J,)
        Crank angle in the cycle at which each cylinder fires [rad].
    weights : array_like of shape (J,), optional
        Displacement of the mode shape at each cylinder; 1 by default.

    Returns
    -------
    ndarray of shape (K,)
        | sum over j of w_j exp(i order angle_j) |; the number of cylinders at a major order when
        all weights are 1.
    """
    excited = positive_vector("orders", orders, "", "they count cycles per revolution")
    angles = finite_vector("firing_angles", firing_angles)
    check_some("firing_angles", angles, "each cylinder fires")
    shares = np.ones(angles.size) if weights is None else finite_vector("weights", weights)
    check_one_each("weights", shares.size, angles.size, "firing angles")
    phasors = np.exp(1j * np.outer(excited, angles))
    return np.asarray(np.abs(phasors @ shares), dtype=np.float64)


def major_orders(orders: ArrayLike, firing_angles: ArrayLike) -> Array:
    """Return those orders at which all cylinders act in phase.

    Returns
    -------
    ndarray of shape (L,)
        The major orders, in the sequence given; for even firing, the multiples of the number of
        ignitions per revolution.
    """
    sums = vector_sums(orders, firing_angles)
    cylinders = np.size(firing_angles)
    return finite_vector("orders", orders)[sums >= (1.0 - FULL_SUM_TOLERANCE) * cylinders]
