"""Inertia forces and moments of the moving parts on the engine, by order, and the masses behind them."""

import cmath
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    complex_array,
    finite_array,
    nonnegative_number,
    positive_number,
    radians_of,
)
from crankbase.choices import check_choice, whole_number
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.results import Flat, Internal, Part, Quantity, Result, result
from dynamics.engine.forces import checked_cylinder, checked_orders, parts_motion, turn_spectrum
from dynamics.engine.layout import EngineLayout, RotatingMass, check_distinct_positions
from dynamics.plots.load_diagrams import FORCE_LABELS, MOMENT_LABELS, draw_hodographs

# An ellipse whose axes differ by less than this share is a circle; one so flat is a line; a sum so small
# beside its terms is zero.
ROUND_OFF = 1e-12
# Directions nearer to -90 deg than this [rad] are written as +90 deg.
FOLD = 1e-9

# In the unit of the vector.
Component = Annotated[float, Quantity("..")]
Share = Annotated[float | None, Quantity("1")]
Kilogram = Annotated[float, Quantity("kg")]


@result("order", "major", "minor", "sense", "angle_deg", eq=True)
class Hodograph(Result):
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

    order: Internal[int]
    forward: Annotated[complex, Quantity("..")]
    backward: Annotated[complex, Quantity("..")]

    def __post_init__(self) -> None:
        checked_orders([self.order])
        for name in ("forward", "backward"):
            part = getattr(self, name)
            if not cmath.isfinite(part):
                raise InputError(
                    f"{name}: given {part}; allowed are finite numbers, because the vector follows from "
                    "them."
                )

    @cached_property
    def major(self) -> Component:
        """Major semi-axis, |P| + |Q|: the largest value of the vector."""
        return abs(self.forward) + abs(self.backward)

    @cached_property
    def minor(self) -> Component:
        """Minor semi-axis, ||P| - |Q||: the least value of the vector."""
        return abs(abs(self.forward) - abs(self.backward))

    @cached_property
    def sense(self) -> Annotated[int, Quantity("1")]:
        """1 where the vector turns with the shaft, -1 against it, 0 for a line (or nothing)."""
        if self.minor <= ROUND_OFF * self.major:
            return 0
        return 1 if abs(self.forward) > abs(self.backward) else -1

    @cached_property
    def angle_deg(self) -> Annotated[float | None, Quantity("deg")]:
        """Direction of the major axis [deg], above -90 to 90; none for a circle or a point.

        Mean of the arguments of P and Q.
        """
        if self._is_round:
            return None
        # The argument of a product is the sum of both; its half is known up to half turns.
        half = cmath.phase(_unit(self.forward) * _unit(self.backward)) / 2.0
        return 90.0 if half < FOLD - 0.5 * math.pi else math.degrees(half)

    @cached_property
    def largest_at_deg(self) -> Annotated[float | None, Quantity("deg")]:
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

    @cached_property
    def x(self) -> Component:
        """Amplitude of the component along x, across the engine."""
        return self.amplitude_along(angle_deg=-90.0)

    @cached_property
    def y(self) -> Component:
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

    def points(self, count: int = 181) -> tuple[Array, Array]:
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
    """Return the sum, zero where it is round-off of its terms."""
    terms = list(numbers)
    total = complex(math.fsum(term.real for term in terms), math.fsum(term.imag for term in terms))
    return total if abs(total) > ROUND_OFF * math.fsum(map(abs, terms)) else 0.0j


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


@result("reciprocating", "rotating", "lateral", eq=True)
class MovingMasses(Result):
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

    cylinder: int
    reciprocating: Kilogram
    rotating: Kilogram
    lateral: Annotated[float, Quantity("kg m", key="lateral_static_moment")]


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
    moments: list[list[float]] = [[] for _ in engine.cylinders]

    def share_out(place: int, mass: float, point: complex) -> float:
        """Distribute a mass to the ends of a rod; return the part at its foot."""
        at_piston = mass * point.real / engine.cylinders[place].rod.length
        reciprocating[place] += at_piston
        moments[place].append(mass * point.imag)
        return mass - at_piston

    for place, cylinder in enumerate(engine.cylinders):
        at_foot = share_out(place, cylinder.rod.mass, cylinder.rod.center)
        if cylinder.slave_pin is not None:
            main = cylinder.slave_pin.main_cylinder - 1
            at_foot = share_out(main, at_foot, cylinder.slave_pin.place)
            rotating[main] += at_foot
        else:
            rotating[place] += at_foot
    lateral = [_accurate_sum(terms).real for terms in moments]
    numbers = range(1, len(reciprocating) + 1)
    return tuple(map(MovingMasses, numbers, reciprocating, rotating, lateral))


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
    for masses in moving_masses(engine):
        main = engine.main_of(masses.cylinder)
        balanced = masses.rotating + share * masses.reciprocating
        pins[main] = pins.get(main, 0.0) + balanced
    weights = []
    for main, mass in pins.items():
        cylinder = engine.cylinders[main - 1]
        opposite = cmath.phase(-cmath.exp(1j * math.radians(cylinder.crank_angle_deg)))
        weights.append(
            RotatingMass(
                mass * engine.crank_radius,
                angle_deg=math.degrees(opposite % (2.0 * math.pi)),
                position=cylinder.position,
            )
        )
    return tuple(weights)


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

    def forces(angles: Array) -> ComplexArray:
        motions = (parts_motion(engine, number, angles).piston for number in numbers)
        return np.array(
            [
                -mass * motion.acceleration(speed).real
                for mass, motion in zip(masses, motions, strict=True)
            ]
        )

    return cylinder_forces(engine, forces, orders)


def cylinder_forces(
    engine: EngineLayout, forces: Callable[[Array], ComplexArray], orders: Sequence[int]
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


BalanceModel = Literal["rigid", "two-mass"]
# Forces below this share of the sum of all masses times R w^2 are round-off.
BALANCED = 1e-12


@result("force", "moment", eq=True)
class Resultant(Result):
    """A force on the engine and its moment about a point of the shaft axis, both of one order.

    The moment is the sum of z e_z x F: a force at z turned by 90 deg.
    """

    force: Annotated[Hodograph, Quantity("N")]
    moment: Annotated[Hodograph, Quantity("N m")]


@result("reciprocating", "rotating", "lateral", eq=True)
class BalanceParts(Result):
    """The inertia forces of one order and their moments, by the masses that make them.

    Parameters
    ----------
    reciprocating : Resultant
        Of the masses at the piston pins.
    rotating : Resultant
        Of the masses at the crankpins and of counterweights; first order only.
    lateral : Resultant
        Of masses off the rods' axes, slave pins included; zero in the two-mass model.
    """

    reciprocating: Resultant
    rotating: Resultant
    lateral: Resultant


@result(
    "order",
    "force: force.major [N]",
    "moment: moment.major [N m]",
    "force_balanced",
    "moment_balanced",
    eq=True,
)
class OrderBalance(Result):
    """The inertia forces of one order and their moments.

    Parameters
    ----------
    order : int
        Cycles per revolution of the shaft.
    total : Resultant
        All parts together.
    force_scale : float
        Scale of the forces: sum of all moving masses times R w^2 [N].
    moment_scale : float
        Scale of the moments: the former times the largest distance of a cylinder from the point [N m].
    """

    order: int
    total: Flat[Resultant]
    parts: BalanceParts
    force_scale: Annotated[float, Quantity("N")]
    moment_scale: Annotated[float, Quantity("N m")]

    @property
    def force(self) -> Hodograph:
        """The whole force [N]."""
        return self.total.force

    @property
    def moment(self) -> Hodograph:
        """The whole moment [N m]."""
        return self.total.moment

    @cached_property
    def force_balanced(self) -> Part[bool]:
        """Whether the force is zero within round-off."""
        return self.force.major <= BALANCED * self.force_scale

    @cached_property
    def moment_balanced(self) -> Part[bool]:
        """Whether the moment is zero within round-off."""
        return self.moment.major <= BALANCED * self.moment_scale


@result("speed", "model", "rows", "about", "rotating", eq=True)
class Balance(Result):
    """The balance of an engine at one speed.

    Parameters
    ----------
    speed : float
        Of the shaft [rad/s]; forces are proportional to its square.
    about : float
        Point of the shaft axis about which moments are taken [m].
    masses : tuple of MovingMasses
        Of each cylinder.
    rotating : tuple of RotatingMass
        Further masses on the shaft.
    rows : tuple of OrderBalance
        One for each order.
    banks_deg : tuple of float
        Angles of the cylinders' axes [deg].
    """

    speed: Annotated[float, Quantity("rad/s")]
    about: Annotated[float, Quantity("m")]
    model: BalanceModel
    masses: tuple[MovingMasses, ...]
    rotating: tuple[RotatingMass, ...]
    rows: Annotated[tuple[OrderBalance, ...], Quantity(key="orders")]
    banks_deg: Internal[tuple[float, ...]] = ()

    def of(self, order: int) -> OrderBalance:
        """Return one order."""
        for row in self.rows:
            if row.order == order:
                return row
        raise InputError(
            f"order: given {order}; allowed are {', '.join(str(row.order) for row in self.rows)}, "
            "because these were calculated."
        )

    def plot(self, axes: Axes | None = None, *, show: Literal["force", "moment"] = "force") -> Axes:
        """Draw the residual forces or moments, a curve for each order that is not balanced.

        Returns
        -------
        matplotlib.axes.Axes
            Seen from the free end: y up, x to the left; thin lines are the cylinders' axes.
        """
        check_choice("show", show, ("force", "moment"), "inertia leaves these over")
        curves = unbalanced(self, show)
        empty = "balanced: orders " + ", ".join(str(row.order) for row in self.rows)
        if show == "force":
            banks = map(math.radians, self.banks_deg)
            return draw_hodographs(
                axes, curves, FORCE_LABELS, title="inertia force", banks=banks, empty=empty
            )
        title = f"moment of inertia forces about z = {self.about:.4g} m"
        return draw_hodographs(axes, curves, MOMENT_LABELS, title=title, empty=empty)

    def to_pandas(self) -> DataFrame:
        """Return one row for each order: semi-axes, direction and amplitudes of force and moment."""
        columns: dict[str, tuple[list[Any], str]] = {
            "order": ([row.order for row in self.rows], "1")
        }
        for name, unit in (("force", "N"), ("moment", "N m")):
            hodographs: list[Hodograph] = [getattr(row, name) for row in self.rows]
            for part in ("major", "minor", "x", "y"):
                columns[f"{name}_{part}"] = [getattr(vector, part) for vector in hodographs], unit
            angles = [vector.angle_deg for vector in hodographs]
            columns[f"{name}_angle"] = (
                [math.nan if angle is None else angle for angle in angles],
                "deg",
            )
            columns[f"{name}_balanced"] = (
                [getattr(row, f"{name}_balanced") for row in self.rows],
                "",
            )
        return table(columns)


def unbalanced(engine_balance: Balance, of: Literal["force", "moment"]) -> dict[str, Hodograph]:
    """Return the forces or moments of the orders that are not balanced, by name."""
    return {
        f"order {row.order}": getattr(row, of)
        for row in engine_balance.rows
        if not getattr(row, f"{of}_balanced")
    }


def balance(
    engine: EngineLayout,
    speed: float,
    orders: Sequence[int] = (1, 2, 4),
    *,
    about: float | None = None,
    model: BalanceModel = "rigid",
) -> Balance:
    """Find the inertia forces and moments that act on the engine at constant speed, by order.

    Parameters
    ----------
    engine : EngineLayout
        With `rotating` masses for counterweights and the unbalance of the throws.
    about : float, optional
        Point of the shaft axis about which moments are taken [m]; by default the middle of the cylinders.
    model : str, optional
        "rigid": pistons and rods exactly. "two-mass": masses at the ends of the rods only; a
        hinged rod's foot is distributed to the main rod's ends. They differ if a mass is off a
        rod's axis.

    Raises
    ------
    InputError
        If the speed is not above zero, an order is not a whole number of 1 or more, two cylinders of a
        bank are at the same position, or there is no such model.

    Notes
    -----
    The force is minus the sum of mass times acceleration, exact: orders come from a fast Fourier
    transform with enough samples to avoid aliasing. A hinged rod's foot acts in
    the plane of the main rod. Gas forces leave no net force on the engine, nor a moment about x or y.

    Examples
    --------
    >>> from dynamics.engine.layout import EngineCylinder
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(length=0.15, mass=0.6, center_distance=0.05, inertia=0.002)
    >>> engine = EngineLayout(
    ...     0.045,
    ...     [
    ...         EngineCylinder(0.09, 0.5, rod, crank_angle_deg=angle, position=0.1 * place)
    ...         for place, angle in enumerate((0, 180, 180, 0))
    ...     ],
    ...     [1, 3, 4, 2],
    ... )
    >>> found = balance(engine, 600.0)
    >>> found.of(1).force_balanced, found.of(2).force_balanced
    (True, False)
    >>> round(found.of(2).force.major)  # 4 m R w^2 (lambda + lambda^3 / 4 + ...)
    13928
    """
    turning = positive_number("speed", speed, "rad/s", "the shaft turns")
    check_distinct_positions(engine)
    wanted = checked_orders(orders)
    check_choice(
        "model", model, get_args(BalanceModel), "these are the ways to count the rods' mass"
    )
    places = [cylinder.position for cylinder in engine.cylinders]
    middle = 0.5 * (min(places) + max(places))
    point = middle if about is None else float(finite_array("about", about))
    masses = moving_masses(engine)
    moving = sum(moving_mass.reciprocating + moving_mass.rotating for moving_mass in masses)
    statics = sum(mass.static_moment for mass in engine.rotating)
    force_scale = (moving * engine.crank_radius + statics) * turning**2
    reach = max(engine.crank_radius, *(abs(place - point) for place in places))
    moving_at_pistons = [moving_mass.reciprocating for moving_mass in masses]
    to_and_fro = reciprocating_forces(engine, moving_at_pistons, turning, wanted)
    beside = _lateral(engine, masses, turning, wanted) if model == "rigid" else {}
    with_the_crank = _rotating(engine, masses, turning)

    def resultant(order: int, *forces: PlacedForce) -> Resultant:
        moments = (force.times(1j * (place - point)) for place, force in forces)
        return Resultant(
            hodograph_sum(order, (force for _, force in forces)), hodograph_sum(order, moments)
        )

    rows = []
    for order in wanted:
        to_fro, side = to_and_fro[order], beside.get(order, [])
        turns = with_the_crank if order == 1 else []
        rows.append(
            OrderBalance(
                order,
                total=resultant(order, *to_fro, *turns, *side),
                parts=BalanceParts(
                    resultant(order, *to_fro), resultant(order, *turns), resultant(order, *side)
                ),
                force_scale=force_scale,
                moment_scale=force_scale * reach,
            )
        )
    return Balance(
        turning,
        point,
        model,
        masses,
        tuple(engine.rotating),
        tuple(rows),
        tuple(cylinder.bank_angle_deg for cylinder in engine.cylinders),
    )


def _lateral(
    engine: EngineLayout, masses: Sequence[MovingMasses], speed: float, orders: Sequence[int]
) -> dict[int, list[PlacedForce]]:
    """Return the forces of the static moments S beside the rods: -S i d^2/dt^2 exp(i t)."""
    if not any(mass.lateral for mass in masses):
        return {}
    numbers = range(1, len(engine.cylinders) + 1)

    def forces(angles: Array) -> ComplexArray:
        turns = (parts_motion(engine, number, angles).rod for number in numbers)
        return np.array(
            [
                -1j
                * mass.lateral
                * speed**2
                * (1j * turn.second - turn.first**2)
                * np.exp(1j * turn.angle_rad)
                for mass, turn in zip(masses, turns, strict=True)
            ]
        )

    return cylinder_forces(engine, forces, orders)


def _rotating(
    engine: EngineLayout, masses: Sequence[MovingMasses], speed: float
) -> list[PlacedForce]:
    at_pins = [
        (
            cylinder.position,
            mass.rotating * engine.crank_radius,
            math.radians(cylinder.crank_angle_deg),
        )
        for cylinder, mass in zip(engine.cylinders, masses, strict=True)
    ]
    on_shaft = [
        (mass.position, mass.static_moment, math.radians(mass.angle_deg))
        for mass in engine.rotating
    ]
    return [
        (place, Hodograph(1, static * speed**2 * cmath.exp(1j * angle), 0j))
        for place, static, angle in (*at_pins, *on_shaft)
    ]


@result("major", "minor", "turn_deg", eq=True)
class HodographChange(Result):
    """The difference between two hodographs.

    Parameters
    ----------
    major, minor : float or None
        Change of the semi-axes as a share of the other's; none where the other's is zero.
    turn_deg : float or None
        Rotation of the major axis about +z [deg], -90 to 90; none where one has no major axis.
    """

    major: Share
    minor: Share
    turn_deg: Annotated[float | None, Quantity("deg")]


HINGED_CASES = {
    "side_by_side": "rods side by side",
    "kinematics": "movement alone",
    "masses": "masses alone",
    "hinged": "hinged rods",
}


def hodograph_change(hodograph: Hodograph, reference: Hodograph) -> HodographChange:
    """Return how a hodograph differs from a reference."""
    turn = (
        None
        if hodograph.angle_deg is None or reference.angle_deg is None
        else math.remainder(hodograph.angle_deg - reference.angle_deg, 180.0)
    )
    # The minor axis of a line is round-off.
    minor = hodograph.minor / reference.minor - 1.0 if reference.sense else None
    major = hodograph.major / reference.major - 1.0 if reference.major else None
    return HodographChange(major, minor, turn)


@result("hodograph", "change", eq=True)
class ChangedHodograph(Result):
    """A hodograph, and how it differs from a reference."""

    hodograph: Annotated[Hodograph, Quantity("..", flat=True)]
    change: HodographChange


@result("order", "curves", eq=True)
class HingedRodEffects(Result):
    """Inertia forces of one order [N], with rods side by side and hinged, and the separate effects.

    Parameters
    ----------
    side_by_side : Hodograph
        Each hinged rod replaced by a copy of the main rod, and its reciprocating mass by that of
        the main rod's cylinder.
    kinematics : Hodograph
        Actual piston motion, masses of the main rods' cylinders.
    masses : Hodograph
        Piston motion of rods side by side, actual masses.
    hinged : Hodograph
        Actual motion and masses.
    """

    order: int
    side_by_side: Internal[Hodograph]
    kinematics: Internal[Hodograph]
    masses: Internal[Hodograph]
    hinged: Internal[Hodograph]

    @property
    def changes(self) -> Annotated[dict[str, ChangedHodograph], Quantity("N", flat=True)]:
        """The four forces, each with its difference from rods side by side."""
        forces = {name: getattr(self, name) for name in HINGED_CASES}
        return {
            name: ChangedHodograph(force, hodograph_change(force, self.side_by_side))
            for name, force in forces.items()
        }

    @property
    def curves(self) -> dict[str, Hodograph]:
        """The four forces by name."""
        return {words: getattr(self, name) for name, words in HINGED_CASES.items()}

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the four forces as seen from the free end: y up, x to the left."""
        return draw_hodographs(axes, self.curves, FORCE_LABELS, title=f"order {self.order}")

    def to_pandas(self) -> DataFrame:
        """Return one row for each of the four forces: semi-axes and amplitudes."""
        hodographs = list(self.curves.values())
        return table(
            {
                "case": (list(self.curves), ""),
                "order": ([self.order] * len(hodographs), "1"),
                "major": ([hodograph.major for hodograph in hodographs], "N"),
                "minor": ([hodograph.minor for hodograph in hodographs], "N"),
                "x": ([hodograph.x for hodograph in hodographs], "N"),
                "y": ([hodograph.y for hodograph in hodographs], "N"),
            }
        )


def hinged_rod_effects(
    engine: EngineLayout,
    speed: float,
    orders: Sequence[int] = (1, 2),
    cylinders: Sequence[int] | None = None,
) -> tuple[HingedRodEffects, ...]:
    """Separate the effects of the hinged rods' kinematics and masses on the inertia forces.

    Parameters
    ----------
    engine : EngineLayout
        With at least one hinged rod.
    cylinders : sequence of int, optional
        Numbers of the cylinders whose forces are added, such as the two of one throw; all by
        default.

    Returns
    -------
    tuple of HingedRodEffects
        One for each order. Reciprocating masses only, as `moving_masses` gives them.

    Raises
    ------
    InputError
        If none of the cylinders has a hinged rod, there is no such cylinder, an order is not a
        whole number of 1 or more, or the speed is not above zero.

    Notes
    -----
    After Mikhina, Vyalkov 2024, Politekhnicheskiy molodezhnyy zhurnal no. 05 (94).
    """
    positive_number("speed", speed, "rad/s", "the shaft turns")
    wanted = checked_orders(orders)
    count = len(engine.cylinders)
    chosen = range(1, count + 1) if cylinders is None else cylinders
    numbers = [checked_cylinder(engine, number) for number in chosen]
    if all(engine.main_of(number) == number for number in numbers):
        raise InputError(
            f"cylinders: given {numbers}, none of which has a hinged rod; allowed are cylinders with one, "
            "because their effect is calculated."
        )
    reciprocating = [masses.reciprocating for masses in moving_masses(engine)]
    # The engine with copies of the main rods in place of the hinged ones, and masses of the main cylinders.
    side_by_side, of_mains = [], []
    for number, cylinder in enumerate(engine.cylinders, start=1):
        place = engine.main_of(number) - 1
        main = engine.cylinders[place]
        side_by_side.append(
            replace(cylinder, rod=main.rod, pin_offset=main.pin_offset, slave_pin=None)
        )
        of_mains.append(reciprocating[place])
    beside = replace(engine, cylinders=side_by_side)

    def forces(layout: EngineLayout, masses: Sequence[float]) -> list[Hodograph]:
        by_order = reciprocating_forces(layout, masses, speed, wanted)
        return [
            hodograph_sum(order, (by_order[order][number - 1][1] for number in numbers))
            for order in wanted
        ]

    cases = (
        forces(beside, of_mains),
        forces(engine, of_mains),
        forces(beside, reciprocating),
        forces(engine, reciprocating),
    )
    return tuple(
        HingedRodEffects(order, *each)
        for order, each in zip(wanted, zip(*cases, strict=True), strict=True)
    )
