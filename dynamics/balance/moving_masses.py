"""Reciprocating and rotating masses at the ends of the rods, and their forces by order."""

import cmath
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    complex_array,
    nonnegative_number,
    radians_of,
)
from crankbase.choices import check_choice, whole_number
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.summaries import summarized
from dynamics.engine.layout import EngineLayout, RotatingMass
from dynamics.engine.motions import checked_orders, parts_motion, turn_spectrum
from dynamics.plots.load_diagrams import FORCE_LABELS, MOMENT_LABELS, draw_hodographs

# An ellipse whose axes differ by less than this share is a circle; one so flat is a line.
ROUND_OFF = 1e-12
# Directions nearer to -90 deg than this [rad] are written as +90 deg.
FOLD = 1e-9


@summarized("order", "major", "minor", "sense", "angle_deg [deg]")
@dataclass(frozen=True)
class Hodograph:
    """One order of a plane vector: F(phi) = P exp(i k phi) + Q exp(-i k phi), an ellipse.

    Vectors are complex in the engine's frame, y - i x: the real part points up; angles count
    from there about +z, in the sense of rotation.

    Parameters
    ----------
    order : int
        k, cycles per revolution of the shaft.
    forward : complex
        P, the part that turns with the shaft, k times as fast.
    backward : complex
        Q, the part that turns against it.

    Raises
    ------
    InputError
        If the order is not a whole number of 1 or more, or a part is not finite.

    Examples
    --------
    >>> line = Hodograph(2, 100.0, 100.0)  # a force up and down
    >>> line.major, line.minor, line.sense, line.angle_deg
    (200.0, 0.0, 0, 0.0)
    """

    order: int
    forward: complex
    backward: complex

    def __post_init__(self) -> None:
        checked_orders([self.order])
        for name in ("forward", "backward"):
            part = getattr(self, name)
            if not cmath.isfinite(part):
                raise InputError(
                    f"{name}: given {part}; allowed are finite numbers, because the vector follows from "
                    "them."
                )

    @property
    def major(self) -> float:
        """Major semi-axis, |P| + |Q|: the largest value of the vector."""
        return abs(self.forward) + abs(self.backward)

    @property
    def minor(self) -> float:
        """Minor semi-axis, ||P| - |Q||: the least value of the vector."""
        return abs(abs(self.forward) - abs(self.backward))

    @property
    def sense(self) -> int:
        """1 where the vector turns with the shaft, -1 against it, 0 for a line (or nothing)."""
        if self.minor <= ROUND_OFF * self.major:
            return 0
        return 1 if abs(self.forward) > abs(self.backward) else -1

    @property
    def angle_deg(self) -> float | None:
        """Direction of the major axis [deg], above -90 to 90; none for a circle or a point.

        Mean of the arguments of P and Q.
        """
        if self._is_round:
            return None
        # The argument of a product is the sum of both; its half is known up to half turns.
        half = cmath.phase(_unit(self.forward) * _unit(self.backward)) / 2.0
        return 90.0 if half < FOLD - 0.5 * math.pi else math.degrees(half)

    @property
    def largest_at_deg(self) -> float | None:
        """First shaft angle from zero at which the vector is along the major axis [deg].

        This repeats every half cycle, 180/k. None for a circle or a point.
        """
        if self._is_round:
            return None
        half = cmath.phase(_unit(self.backward) / _unit(self.forward)) / 2.0
        return math.degrees(half % math.pi) / self.order

    @property
    def _is_round(self) -> bool:
        return self.major - self.minor <= ROUND_OFF * self.major

    @property
    def x(self) -> float:
        """Amplitude of the component along x, across the engine."""
        return self.amplitude_along(angle_deg=-90.0)

    @property
    def y(self) -> float:
        """Amplitude of the component along y, up and down."""
        return self.amplitude_along(angle_deg=0.0)

    def amplitude_along(self, *, angle_deg: float) -> float:
        """Return the amplitude of the component in a direction [deg].

        Notes
        -----
        Re(F exp(-i angle)) has the coefficient P exp(-i angle) + conj(Q) exp(i angle).
        """
        turn = cmath.exp(-1j * float(radians_of("angle_deg", angle_deg)))
        return abs(self.forward * turn + (self.backward * turn).conjugate())

    def at(self, *, shaft_angle_deg: ArrayLike) -> ComplexArray:
        """Return the vector y - i x at shaft angles [deg] of any shape.

        Raises
        ------
        InputError
            If an angle is not finite, or they are radians.
        """
        turn = np.exp(1j * self.order * radians_of("shaft_angle_deg", shaft_angle_deg))
        return np.asarray(self.forward * turn + self.backward / turn)

    def points(self, count: int = 181) -> tuple[FloatArray, FloatArray]:
        """Return x and y of points along the closed curve, each real of shape (count,)."""
        count = whole_number("count", count, 1, "so many points are wanted")
        vectors = self.at(
            shaft_angle_deg=np.degrees(np.linspace(0.0, 2.0 * np.pi / self.order, count))
        )
        return -vectors.imag, vectors.real

    def times(self, factor: complex) -> "Hodograph":
        """Return the hodograph of the vector times a complex number: scaled and turned."""
        return Hodograph(self.order, self.forward * factor, self.backward * factor)

    def plot(
        self, axes: Axes | None = None, *, quantity: Literal["force", "moment"] = "force"
    ) -> Axes:
        """Draw the curve of the vector as seen from the free end: y up, x to the left.

        Parameters
        ----------
        quantity : {"force", "moment"}, optional
            Quantity of the vector, for the labels; N and N m are shown as kN and kN m.

        Returns
        -------
        matplotlib.axes.Axes
            A dot marks the vector at shaft angle zero, an arrowhead the direction of motion.
        """
        check_choice("quantity", quantity, ("force", "moment"), "the axes have the unit of one")
        labels = FORCE_LABELS if quantity == "force" else MOMENT_LABELS
        name = f"order {self.order}"
        return draw_hodographs(axes, {name: self}, labels, title=f"{quantity} of {name}")

    def to_pandas(self, unit: str = "N", count: int = 181) -> DataFrame:
        """Return the vector at evenly spaced shaft angles over one revolution, both ends included."""
        most = whole_number("count", count, 2, "a turn has two ends")
        angles = np.linspace(0.0, 360.0, most)
        vector = self.at(shaft_angle_deg=angles)
        return table(
            {"shaft_angle": (angles, "deg"), "x": (-vector.imag, unit), "y": (vector.real, unit)}
        )


def _unit(number: complex) -> complex:
    return number / abs(number)


def hodograph_sum(order: int, hodographs: Iterable[Hodograph]) -> Hodograph:
    """Return the hodograph of the sum of vectors of one order."""
    terms = list(hodographs)
    return Hodograph(
        order,
        _accurate_sum(term.forward for term in terms),
        _accurate_sum(term.backward for term in terms),
    )


def _accurate_sum(numbers: Iterable[complex]) -> complex:
    """Return the sum with round-off set to zero where terms cancel."""
    terms = list(numbers)
    return complex(math.fsum(term.real for term in terms), math.fsum(term.imag for term in terms))


def order_vectors(vectors: ArrayLike, orders: Sequence[int]) -> tuple[Hodograph, ...]:
    """Return the hodographs of some orders of a vector sampled over a revolution.

    Parameters
    ----------
    vectors : complex array_like of shape (m,)
        y - i x at m shaft angles, evenly over one revolution from zero, without the closing one.

    Returns
    -------
    tuple of Hodograph
        In the unit of the vectors.

    Raises
    ------
    InputError
        If a vector is not finite, or an order is not a whole number below half the number of
        samples.

    Examples
    --------
    >>> angle = 2 * np.pi * np.arange(12) / 12
    >>> (found,) = order_vectors(3 * np.exp(2j * angle) + np.exp(-2j * angle), [2])
    >>> round(found.major, 9), round(found.minor, 9), found.sense
    (4.0, 2.0, 1)
    """
    samples = complex_array("vectors", vectors)
    if samples.ndim != 1 or not np.all(np.isfinite(samples)):
        raise InputError(
            f"vectors: given an array of shape {samples.shape} with "
            f"{np.count_nonzero(~np.isfinite(samples))} "
            "values not finite; allowed is a row of finite ones, because they follow the shaft."
        )
    wanted = checked_orders(orders)
    if 2 * max(wanted) >= samples.size:
        raise InputError(
            f"orders: given {max(wanted)} with {samples.size} samples; allowed is less than half the number "
            "of samples over a turn, because they resolve no more."
        )
    coefficients = np.fft.fft(samples) / samples.size
    return tuple(
        Hodograph(order, complex(coefficients[order]), complex(coefficients[-order]))
        for order in wanted
    )


# A force and where along the shaft it acts [m].
PlacedForce = tuple[float, Hodograph]


@summarized("reciprocating [kg]", "rotating [kg]", "lateral [kg m]")
@dataclass(frozen=True)
class MovingMasses:
    """The masses of one cylinder's moving parts that cause the inertia forces.

    Parameters
    ----------
    reciprocating : float
        At the piston pin: piston and the rod's share [kg].
    rotating : float
        At the crankpin [kg]; zero for a hinged rod, whose share is in the main rod's.
    lateral : float
        Static moment of mass off the rod's axis, positive to the side to which the crankpin
        moves as it passes the top [kg m]: the part that two masses on the axis omit.
    """

    reciprocating: float
    rotating: float
    lateral: float


def moving_masses(engine: EngineLayout) -> tuple[MovingMasses, ...]:
    """Return the masses of each cylinder's moving parts.

    Notes
    -----
    A point of a rod at u + i v moves as (1 - u/L) A + (u/L) B + i v exp(-i beta), A and B its
    ends. So a rod of mass M contributes exactly M u/L at B and M (1 - u/L) at A, and a static
    moment M v. A hinged rod's A is the slave pin, the point p + i q of the main rod, and is shared
    out again: (p/L) and (1 - p/L) of its mass go to the main rod's ends, and the static moment
    increases by q times it. Mikhina, Vyalkov 2024, Politekhnicheskiy molodezhnyy zhurnal no. 05 (94),
    do the same but neglect the static moment.

    Examples
    --------
    >>> from dynamics.engine.layout import EngineCylinder
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(length=0.5, mass=10.0, center_distance=0.15, inertia=0.3)
    >>> moving_masses(EngineLayout(0.1, [EngineCylinder(0.2, 7.0, rod)], [1]))
    (MovingMasses(reciprocating 10 kg, rotating 7 kg, lateral 0 kg m),)
    """
    reciprocating = [cylinder.piston_mass for cylinder in engine.cylinders]
    rotating = [0.0] * len(engine.cylinders)
    lateral = [0.0] * len(engine.cylinders)

    def share_out(place: int, mass: float, point: complex) -> float:
        """Distribute a mass to the ends of a rod; return the part at its foot."""
        at_piston = mass * point.real / engine.cylinders[place].rod.length
        reciprocating[place] += at_piston
        lateral[place] += mass * point.imag
        return mass - at_piston

    for place, cylinder in enumerate(engine.cylinders):
        at_foot = share_out(place, cylinder.rod.mass, cylinder.rod.center)
        if cylinder.slave_pin is not None:
            main = cylinder.slave_pin.main_cylinder - 1
            at_foot = share_out(main, at_foot, cylinder.slave_pin.place)
            rotating[main] += at_foot
        else:
            rotating[place] += at_foot
    return tuple(map(MovingMasses, reciprocating, rotating, lateral))


def balancing_masses(
    engine: EngineLayout, reciprocating_share: float = 0.0
) -> tuple[RotatingMass, ...]:
    """Return counterweights that cancel the rods' rotating masses, and a share of the reciprocating ones.

    Parameters
    ----------
    engine : EngineLayout
        Its own `rotating` masses are not counted.
    reciprocating_share : float, optional
        Share of the throw's reciprocating masses that is balanced as well. With 0.5 no first-order part
        that turns with the shaft is left, except that of mass off the rods' axes: in a V engine of
        90 deg nothing at all, in others the part that turns against the shaft.

    Returns
    -------
    tuple of RotatingMass
        One for each crankpin, opposite to it, in the plane of the main rod.

    Raises
    ------
    InputError
        If the share is negative or not finite.

    Notes
    -----
    The first order of one cylinder is m R w^2 cos(alpha) along its axis: half of it turns with the
    crankpin whatever the axis, half against it. A static moment S beside a rod's axis adds
    S lambda w^2 sin(alpha), lambda = R/L, along the axis, half of which turns 90 deg behind the
    crankpin and is not balanced here.
    """
    share = nonnegative_number(
        "reciprocating_share", reciprocating_share, "", "the weights are opposite to the crank"
    )
    pins: dict[int, float] = {}
    for number, masses in enumerate(moving_masses(engine), start=1):
        main = engine.main_of(number)
        balanced = masses.rotating + share * masses.reciprocating
        pins[main] = pins.get(main, 0.0) + balanced
    return tuple(
        RotatingMass(
            mass * engine.crank_radius,
            angle_deg=math.degrees(
                _opposite(math.radians(engine.cylinders[main - 1].crank_angle_deg))
            ),
            position=engine.cylinders[main - 1].position,
        )
        for main, mass in pins.items()
    )


def _opposite(angle: float) -> float:
    """Return the opposite direction [rad], 0 to below 2 pi."""
    return cmath.phase(-cmath.exp(1j * angle)) % (2.0 * math.pi)


def reciprocating_forces(
    engine: EngineLayout, masses: Sequence[float], speed: float, orders: Sequence[int]
) -> dict[int, list[PlacedForce]]:
    """Return the forces of masses at the piston pins, along the cylinders' axes.

    Parameters
    ----------
    masses : sequence of n float
        One for each cylinder [kg].

    Returns
    -------
    dict
        For each order the n forces, in the engine's frame [N].
    """
    numbers = range(1, len(engine.cylinders) + 1)

    def forces(angles: FloatArray) -> ComplexArray:
        motions = (parts_motion(engine, number, angles).piston for number in numbers)
        return np.array(
            [
                -mass * motion.acceleration(speed).real
                for mass, motion in zip(masses, motions, strict=True)
            ]
        )

    return cylinder_forces(engine, forces, orders)


def cylinder_forces(
    engine: EngineLayout, forces: Callable[[FloatArray], ComplexArray], orders: Sequence[int]
) -> dict[int, list[PlacedForce]]:
    """Return the orders of forces given in the cylinders' frames, in the engine's frame.

    Parameters
    ----------
    forces : callable
        Takes shaft angles (m,) [rad] and returns forces s + i n (n, m) [N].

    Returns
    -------
    dict
        For each order the n forces [N].
    """
    spectrum = turn_spectrum(forces, max(orders))
    by_order: dict[int, list[PlacedForce]] = {}
    for order in orders:
        ahead, back = spectrum[..., order].tolist(), spectrum[..., -order].tolist()
        by_order[order] = [
            (
                cylinder.position,
                Hodograph(order, forward, backward).times(
                    cmath.exp(1j * math.radians(cylinder.bank_angle_deg))
                ),
            )
            for cylinder, forward, backward in zip(engine.cylinders, ahead, back, strict=True)
        ]
    return by_order
