"""Residual inertia forces and moments of the moving parts on the engine, by order."""

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from crankbase.array_checks import ComplexArray, FloatArray, finite_array, positive_number
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.summaries import summarized
from dynamics.balance.moving_masses import (
    Hodograph,
    MovingMasses,
    PlacedForce,
    cylinder_forces,
    hodograph_sum,
    moving_masses,
    reciprocating_forces,
)
from dynamics.engine.layout import EngineLayout, check_distinct_positions
from dynamics.engine.motions import checked_cylinder, checked_orders, parts_motion
from dynamics.plots.load_diagrams import FORCE_LABELS, MOMENT_LABELS, draw_hodographs

BalanceModel = Literal["rigid", "two-mass"]
# Forces below this share of the sum of all masses times R w^2 are round-off.
BALANCED = 1e-12


@dataclass(frozen=True)
class Resultant:
    """A force and its moment, both of one order.

    Parameters
    ----------
    force : Hodograph
        On the engine [N].
    moment : Hodograph
        Moment vector about a point of the shaft axis [N m], the sum of z e_z x F: a force at z
        turned by 90 deg.
    """

    force: Hodograph
    moment: Hodograph


@summarized(
    "order",
    "force: force.major [N]",
    "moment: moment.major [N m]",
    "force_balanced",
    "moment_balanced",
)
@dataclass(frozen=True)
class OrderBalance:
    """The inertia forces of one order and their moments.

    Parameters
    ----------
    order : int
        Cycles per revolution of the shaft.
    total : Resultant
        All parts together.
    reciprocating : Resultant
        Of the masses at the piston pins.
    rotating : Resultant
        Of the masses at the crankpins and of counterweights; first order only.
    lateral : Resultant
        Of masses off the rods' axes, slave pins included; zero in the two-mass model.
    force_scale : float
        Scale of the forces: sum of all moving masses times R w^2 [N].
    moment_scale : float
        Scale of the moments: the former times the largest distance of a cylinder from the point [N m].
    """

    order: int
    total: Resultant
    reciprocating: Resultant
    rotating: Resultant
    lateral: Resultant
    force_scale: float
    moment_scale: float

    @property
    def force(self) -> Hodograph:
        """The whole force [N]."""
        return self.total.force

    @property
    def moment(self) -> Hodograph:
        """The whole moment [N m]."""
        return self.total.moment

    @property
    def force_balanced(self) -> bool:
        """Whether the force is zero within round-off."""
        return self.force.major <= BALANCED * self.force_scale

    @property
    def moment_balanced(self) -> bool:
        """Whether the moment is zero within round-off."""
        return self.moment.major <= BALANCED * self.moment_scale


@summarized("speed [rad/s]", "model", "rows", "about [m]", "rotating: engine.rotating")
@dataclass(frozen=True)
class Balance:
    """The balance of an engine at one speed.

    Parameters
    ----------
    speed : float
        Of the shaft [rad/s]; forces are proportional to its square.
    about : float
        Point of the shaft axis about which moments are taken [m].
    rows : tuple of OrderBalance
        One for each order.
    """

    engine: EngineLayout
    speed: float
    about: float
    model: BalanceModel
    rows: tuple[OrderBalance, ...]

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
            banks = [math.radians(cylinder.bank_angle_deg) for cylinder in self.engine.cylinders]
            return draw_hodographs(
                axes, curves, FORCE_LABELS, title="inertia force", banks=banks, empty=empty
            )
        title = f"moment of inertia forces about z = {self.about:.4g} m"
        return draw_hodographs(axes, curves, MOMENT_LABELS, title=title, empty=empty)

    def to_pandas(self) -> DataFrame:
        """Return one row for each order: semi-axes, direction and amplitudes of force and moment."""
        columns: dict[str, tuple[list[object], str]] = {
            "order": ([row.order for row in self.rows], "1")
        }
        for name, unit in (("force", "N"), ("moment", "N m")):
            hodographs: list[Hodograph] = [getattr(row, name) for row in self.rows]
            for part in ("major", "minor", "x", "y"):
                columns[f"{name}_{part}"] = (
                    [getattr(hodograph, part) for hodograph in hodographs],
                    unit,
                )
            angles = [
                math.nan if hodograph.angle_deg is None else hodograph.angle_deg
                for hodograph in hodographs
            ]
            columns[f"{name}_angle"] = (list(angles), "deg")
            kept = [getattr(row, f"{name}_balanced") for row in self.rows]
            columns[f"{name}_balanced"] = (kept, "")
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
                reciprocating=resultant(order, *to_fro),
                rotating=resultant(order, *turns),
                lateral=resultant(order, *side),
                force_scale=force_scale,
                moment_scale=force_scale * reach,
            )
        )
    return Balance(engine, turning, point, model, tuple(rows))


def _lateral(
    engine: EngineLayout, masses: Sequence[MovingMasses], speed: float, orders: Sequence[int]
) -> dict[int, list[PlacedForce]]:
    """Return the forces of the static moments S beside the rods: -S i d^2/dt^2 exp(i t)."""
    if not any(mass.lateral for mass in masses):
        return {}
    numbers = range(1, len(engine.cylinders) + 1)

    def forces(angles: FloatArray) -> ComplexArray:
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


@dataclass(frozen=True)
class HodographChange:
    """The difference between two hodographs.

    Parameters
    ----------
    major, minor : float or None
        Change of the semi-axes as a share of the other's; none where the other's is zero.
    turn_deg : float or None
        Rotation of the major axis about +z [deg], -90 to 90; none where one has no major axis.
    """

    major: float | None
    minor: float | None
    turn_deg: float | None


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


@summarized("order", "curves")
@dataclass(frozen=True)
class HingedRodEffects:
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
    side_by_side: Hodograph
    kinematics: Hodograph
    masses: Hodograph
    hinged: Hodograph

    @property
    def curves(self) -> dict[str, Hodograph]:
        """The four forces by name."""
        return {
            "rods side by side": self.side_by_side,
            "movement alone": self.kinematics,
            "masses alone": self.masses,
            "hinged rods": self.hinged,
        }

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
    beside = _side_by_side(engine)
    reciprocating = [masses.reciprocating for masses in moving_masses(engine)]
    of_mains = [reciprocating[engine.main_of(number) - 1] for number in range(1, count + 1)]

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


def _side_by_side(engine: EngineLayout) -> EngineLayout:
    """Return the engine with copies of the main rods in place of the hinged ones."""
    mains = [
        engine.cylinders[engine.main_of(number) - 1]
        for number in range(1, len(engine.cylinders) + 1)
    ]
    cylinders = [
        replace(cylinder, rod=main.rod, pin_offset=main.pin_offset, slave_pin=None)
        for cylinder, main in zip(engine.cylinders, mains, strict=True)
    ]
    return replace(engine, cylinders=cylinders)
