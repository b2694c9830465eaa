"""Motion of each cylinder's parts, gas pressures and forces in them, loads of crankpins and bearings."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    checked_degrees,
    finite_array,
    finite_vector,
    nonnegative_number,
    positive_number,
    radians_of,
    turning_speeds,
)
from crankbase.choices import check_one_each, check_some, is_whole, whole_within
from crankbase.diagrams import (
    BLUE,
    GREEN,
    ORANGE,
    Dash,
    Diagram,
    Series,
    curve_diagram,
    draw_diagram,
    legend_inside,
    new_axes,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, Dataset, grid, table
from crankbase.quantity import format_number
from crankbase.sentences import in_si
from crankbase.summaries import frozen
from dynamics.cycle import check_even_cycle, cycle_degrees, even_angles, has_closing_sample
from dynamics.engine import RodModelName
from dynamics.engine.layout import (
    EngineLayout,
    check_distinct_positions,
    cylinder_crankpin,
    hinged_foot,
)
from dynamics.engine.rods import PointMotion, RodModel, TurnMotion, carried_point, rod_turn
from dynamics.gas.gas_cycle import FullLoad, GasCycle, GasCycleResult, gas_cycle
from dynamics.gas.pressure import ATMOSPHERE, GasPressure, Position
from dynamics.harmonics import Harmonics, harmonics
from dynamics.plots.curves import KILO, angle_axis, from_top, number_axis
from dynamics.plots.load_diagrams import Frame, check_polar, developed_load, draw_polar_loads

# Angles among which a piston's ends of stroke are looked for, and steps of Newton's method after.
SEARCH_ANGLES = 360
NEWTON_STEPS = 8


@frozen("piston.place [m]", eq=False)
class CylinderMotion:
    """Motion of one cylinder's parts in its own frame, s + i n, over shaft angles.

    Parameters
    ----------
    foot : PointMotion
        The rod's end: center of the crankpin, or of the slave pin.
    rod : TurnMotion
        Rotation of the rod.
    piston : PointMotion
        The piston pin.
    """

    foot: PointMotion
    rod: TurnMotion
    piston: PointMotion

    def rod_point(self, place: complex) -> PointMotion:
        """Return the motion of the point u + i v of the rod [m]."""
        return carried_point(self.foot, self.rod, place)


def cylinder_motion(
    engine: EngineLayout, number: int, *, shaft_angles_deg: ArrayLike
) -> CylinderMotion:
    """Return the motion of a cylinder's parts."""
    return parts_motion(engine, number, radians_of("shaft_angles_deg", shaft_angles_deg))


def parts_motion(engine: EngineLayout, number: int, shaft_angles: Array) -> CylinderMotion:
    """Return the motion of a cylinder's parts at shaft angles [rad] of shape (m,), unchecked."""
    cylinder = engine.cylinder(number)
    if cylinder.slave_pin is None:
        foot = cylinder_crankpin(cylinder, engine.crank_radius, shaft_angles)
    else:
        main = engine.cylinders[engine.main_of(number) - 1]
        foot = hinged_foot(engine.crank_radius, main, cylinder, shaft_angles)
    turn = rod_turn(foot, cylinder.rod.length, cylinder.pin_offset)
    return CylinderMotion(foot, turn, carried_point(foot, turn, complex(cylinder.rod.length)))


def piston_ends(engine: EngineLayout, number: int) -> tuple[float, float]:
    """Return the lowest and highest s of a piston pin over a revolution [m]."""
    angles = even_angles(2.0 * math.pi, SEARCH_ANGLES)
    places = parts_motion(engine, number, angles).piston.place.real
    ends = angles[[int(np.argmin(places)), int(np.argmax(places))]]
    for _ in range(NEWTON_STEPS):
        motion = parts_motion(engine, number, ends).piston
        ends = ends - motion.first.real / motion.second.real
    lowest, highest = parts_motion(engine, number, ends).piston.place.real.tolist()
    return lowest, highest


def reduced_inertia(
    engine: EngineLayout, models: tuple[RodModel, ...], *, shaft_angles_deg: ArrayLike
) -> tuple[Array, Array]:
    """Return the inertia reduced to the crank, I in T = I w^2 / 2, and its derivative by the angle.

    Parameters
    ----------
    models : tuple of n RodModel
        Of each cylinder's rod.

    Returns
    -------
    ndarray of shape (m,)
        I [kg m^2], shaft and flywheel included.
    ndarray of shape (m,)
        dI/dphi, per radian [kg m^2/rad].

    Raises
    ------
    InputError
        If an angle is not a finite number, they are radians, or there is not one model for each cylinder.
    """
    check_one_each("models", len(models), len(engine.cylinders), "cylinders")
    shaft_angles = radians_of("shaft_angles_deg", shaft_angles_deg)
    inertia = np.full(shaft_angles.shape, float(engine.shaft_inertia))
    derivative = np.zeros(shaft_angles.shape)
    for number, (cylinder, model) in enumerate(zip(engine.cylinders, models, strict=True), start=1):
        motion = parts_motion(engine, number, shaft_angles)
        for mass, point in (
            (cylinder.piston_mass, motion.piston),
            (model.mass, motion.rod_point(model.center)),
        ):
            inertia += mass * np.abs(point.first) ** 2
            derivative += 2.0 * mass * (np.conj(point.first) * point.second).real
        inertia += model.inertia * motion.rod.first**2
        derivative += 2.0 * model.inertia * motion.rod.first * motion.rod.second
    return inertia, derivative


# Samples over a turn are doubled until the upper orders are round-off: below this share of the
# largest value. A crank of 0.999 rod lengths still needs less than the most.
ROUND_OFF = 1e-14
TURN = 2.0 * np.pi
FEWEST, MOST = 64, 32768


def turn_spectrum(function: Callable[[Array], Array | ComplexArray], highest: int) -> ComplexArray:
    """Return the Fourier coefficients of functions of the shaft angle, f = sum of c_k exp(i k phi).

    Parameters
    ----------
    function : callable
        Takes shaft angles (m,) [rad] and returns values (..., m).

    Returns
    -------
    complex ndarray of shape (..., N)
        c_k in the order of the fast Fourier transform: 0, 1 ... N/2 - 1, -N/2 ... -1. The number of
        samples N over a revolution is so large that orders from 3/8 of it are round-off. The aliases of
        all required orders are beyond these, so they are round-off, too.
    """
    count = FEWEST
    while count * 3 // 8 <= highest:
        count *= 2
    while count <= MOST:
        values = np.asarray(function(even_angles(TURN, count)))
        coefficients = np.fft.fft(values) / count
        upper = coefficients[..., 3 * count // 8 : count - 3 * count // 8 + 1]
        if np.all(np.abs(upper) <= ROUND_OFF * np.max(np.abs(values), initial=0.0)):
            return np.asarray(coefficients)
        count *= 2
    raise InputError(
        f"orders: given a mechanism whose orders do not fade out within {MOST} samples over a turn; "
        "allowed are rods clearly longer than crank radius plus offset, because others jerk."
    )


def checked_orders(orders: Sequence[int]) -> tuple[int, ...]:
    """Return orders as integers."""
    numbers = list(orders)
    whole = [order for order in numbers if is_whole(order) and order >= 1]
    if not numbers or len(whole) != len(numbers) or len(set(numbers)) != len(numbers):
        raise InputError(
            f"orders: given {numbers}; allowed are different whole numbers of 1 or more, because "
            "inertia forces repeat every turn."
        )
    return tuple(int(order) for order in numbers)


def checked_cylinder(engine: EngineLayout, number: int) -> int:
    """Return the number of a cylinder."""
    count = len(engine.cylinders)
    return whole_within("cylinder", number, 1, count, f"the engine has {count} cylinders")


def piston_acceleration(
    engine: EngineLayout, number: int, speed: float, *, angles_deg: ArrayLike
) -> Array:
    """Return the acceleration of a piston towards the shaft, at constant speed.

    Parameters
    ----------
    number : int
        Of the cylinder, from 1; its rod may be hinged to another.
    angles_deg : array_like of shape (m,)
        Crank angle [deg], counted from the position in which the crank is along this cylinder's axis.

    Returns
    -------
    ndarray of shape (m,)
        [m/s^2], positive at the top: R w^2 (cos alpha + lambda cos 2 alpha + ...). The piston's
        inertia force, away from the shaft, is mass times this.

    Raises
    ------
    InputError
        If the engine has no such cylinder, an angle is not finite or the speed not above zero.
    """
    place = checked_cylinder(engine, number)
    turning = positive_number("speed", speed, "rad/s", "the shaft turns")
    shaft = (
        checked_degrees("angles_deg", angles_deg, vector=True)
        + engine.cylinders[place - 1].top_shaft_angle_deg
    )
    return -parts_motion(engine, place, np.radians(shaft)).piston.acceleration(turning).real


def acceleration_orders(
    engine: EngineLayout, number: int, speed: float, highest: int = 8
) -> Harmonics:
    """Return the orders of a piston's acceleration towards the shaft, exact to round-off.

    Returns
    -------
    Harmonics
        Orders 1, 2 ... per revolution [m/s^2], with the crank angle counted as in `piston_acceleration`.

    Raises
    ------
    InputError
        As `piston_acceleration`, and if `highest` is not a whole number of 1 or more.

    Notes
    -----
    With a rod on the crankpin and no pin offset the first order is R w^2 and the higher odd ones
    are zero. The same holds for a hinged rod whose pin is, from the main rod, at the angle
    between the cylinders: sin beta has odd orders only, and so has the motion of the slave pin across
    the other cylinder, whose square has even ones.

    Examples
    --------
    >>> from math import pi
    >>> from dynamics.engine.layout import EngineCylinder
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(length=0.65, mass=40.0, center_distance=0.2, inertia=2.0)
    >>> engine = EngineLayout(0.13, [EngineCylinder(0.26, 44.1, rod)], [1])
    >>> acceleration_orders(engine, 1, 1000 * pi / 30).amplitude[:4].round(2).tolist()
    [1425.61, 288.03, 0.0, 2.94]
    """
    checked_orders([highest])
    spectrum = turn_spectrum(
        lambda angles: piston_acceleration(engine, number, speed, angles_deg=np.degrees(angles)),
        highest,
    )
    angles = even_angles(360.0, spectrum.shape[-1])
    return harmonics(piston_acceleration(engine, number, speed, angles_deg=angles), strokes=2)


def order_part(spectrum: Harmonics, order: int, angles: Array) -> Array:
    """Return one order of an acceleration at crank angles (m,) [rad], shape (m,) [m/s^2]."""
    place = spectrum.index_of(order)
    return np.asarray(
        spectrum.cosine[place] * np.cos(order * angles)
        + spectrum.sine[place] * np.sin(order * angles)
    )


@frozen("speed [rad/s]", "model", "gas [N]", "torque [N m]", eq=False)
class MechanismForces:
    """Forces over shaft angles, cylinder by cylinder: arrays of shape (n, m) [N].

    Parameters
    ----------
    speed : ndarray of shape (m,)
        Of the shaft at these angles [rad/s].
    crank_acceleration : ndarray of shape (m,)
        [rad/s^2]
    gas : ndarray of shape (n, m)
        On the piston, towards the shaft.
    side : ndarray of shape (n, m)
        N, of the wall on the piston, positive to the side to which the crankpin moves as it passes
        the top: P tan(beta) for a massless rod.
    piston_pin : complex ndarray of shape (n, m)
        Of the rod on the piston pin, s + i n in the cylinder's frame.
    foot : complex ndarray of shape (n, m)
        Of the rod on the pin at its other end, s + i n in the cylinder's frame: the crankpin (with
        the force of hinged rods), or the slave pin.
    crankpin : complex ndarray of shape (n, m)
        Contribution of each cylinder to the force on its crankpin, y - i x in the engine's frame.
        A cylinder with a hinged rod acts through the main rod; its contribution is that of its own gas
        and masses.
    """

    engine: EngineLayout
    shaft_angles_deg: Array
    speed: Array
    crank_acceleration: Array
    model: RodModelName
    gas: Array
    side: Array
    piston_pin: ComplexArray
    foot: ComplexArray
    crankpin: ComplexArray

    @property
    def in_crank_frame(self) -> ComplexArray:
        """Contributions to the crankpin's force in the frame that turns with it, -Z + i T (n, m)."""
        cranks = np.array(
            [math.radians(cylinder.crank_angle_deg) for cylinder in self.engine.cylinders]
        )
        turn: ComplexArray = np.exp(
            -1j * (cranks[:, np.newaxis] + np.radians(self.shaft_angles_deg))
        )
        return self.crankpin * turn

    @property
    def tangential(self) -> Array:
        """T, on the crankpin in the sense of rotation, of each cylinder (n, m) [N]."""
        return self.in_crank_frame.imag

    @property
    def radial(self) -> Array:
        """Z, on the crankpin towards the shaft axis, of each cylinder (n, m) [N]."""
        return -self.in_crank_frame.real

    @property
    def torque(self) -> Array:
        """R T, of each cylinder on the shaft, positive when it drives (n, m) [N m]."""
        return self.engine.crank_radius * self.tangential

    def plot(self, axes: Axes | None = None, cylinder: int = 1) -> Axes:
        """Draw gas force, tangential force and side force of a cylinder over its cycle."""
        whole_within("cylinder", cylinder, 1, len(self.gas), "the engine has that many")
        axes = new_axes(axes)
        draw_diagram(axes, piston_forces(self, cylinder))
        write_title(axes, f"Forces of cylinder {cylinder}")
        legend_inside(axes)
        return axes

    def to_xarray(self) -> Dataset:
        """Return all forces over cylinder and shaft angle, with the speed."""
        over = ("cylinder", "shaft_angle")
        return grid(
            {
                "gas": (over, self.gas, "N", "gas force on the piston, towards the shaft"),
                "side": (over, self.side, "N", "side force of the wall on the piston"),
                "tangential": (over, self.tangential, "N", "tangential force on the crankpin"),
                "radial": (over, self.radial, "N", "radial force on the crankpin"),
                "torque": (over, self.torque, "N m", "torque on the shaft"),
                "piston_pin": (over, self.piston_pin, "N", "force on the piston pin, s + i n"),
                "foot": (over, self.foot, "N", "force on the rod's lower pin, s + i n"),
                "crankpin": (over, self.crankpin, "N", "force on the crankpin, y - i x"),
                "speed": (("shaft_angle",), self.speed, "rad/s", "shaft speed"),
            },
            {
                "cylinder": number_axis(len(self.gas), "cylinder"),
                "shaft_angle": angle_axis(self.shaft_angles_deg),
            },
        )


def piston_forces(forces: MechanismForces, cylinder: int) -> Diagram:
    """Describe gas force, tangential force and side force of a cylinder, from 1, over its cycle."""
    since_firing = (
        forces.shaft_angles_deg - forces.engine.firing_deg[cylinder - 1]
    ) % cycle_degrees(forces.engine.strokes)
    order = np.argsort(since_firing)
    looks: tuple[tuple[Array, str, Dash, str], ...] = (
        (forces.gas, BLUE, "solid", "gas, towards the shaft"),
        (forces.tangential, ORANGE, "dash", "tangential, T"),
        (forces.side, GREEN, "dashdot", "side, N"),
    )
    return curve_diagram(
        since_firing[order],
        tuple(
            Series(name, KILO * values[cylinder - 1][order], color=color, dash=dash)
            for values, color, dash, name in looks
        ),
        from_top(forces.engine.strokes),
        "force [kN]",
        signed=True,
        x_step=90.0,
    )


def mechanism_forces(
    engine: EngineLayout,
    speed: float | Array,
    gas: ArrayLike = 0.0,
    *,
    shaft_angles_deg: ArrayLike,
    model: RodModelName = "rigid",
    friction: ArrayLike = 0.0,
    crank_acceleration: float | Array = 0.0,
) -> MechanismForces:
    """Find the forces on pistons, rods and crankpins.

    Parameters
    ----------
    speed : float or ndarray of shape (m,)
        Of the shaft [rad/s].
    gas : array_like of shape (n, m), (m,) or a number
        Force on each piston towards the shaft [N].
    friction : array_like of shape (n, m), (m,) or a number
        Force on each piston along its axis, positive away from the shaft [N].
    crank_acceleration : float or ndarray of shape (m,), optional
        [rad/s^2]

    Raises
    ------
    InputError
        If an array is not finite or does not fit (speed and acceleration included), or there is no
        such model.

    Notes
    -----
    With F_A and F_B on the rod at crankpin and piston pin, M its mass, a_D the acceleration of its
    center of mass, t its rotation: F_A + F_B = M a_D, AB x F_B = J t'' + AD x M a_D, and for the
    piston of mass m: Re F_B = -(gas - friction) - m a_B, N = Im F_B. A hinged rod is solved first;
    the force at its foot loads the main rod, whose own piston balances the moment from the wall.
    Replaces (5) to (12) of Yamanin, Zhukov, Baryshnikov 2018, doi
    10.21821/2309-5180-2018-10-1-191-200, for any of their rod models.
    """
    angles_deg = checked_degrees("shaft_angles_deg", shaft_angles_deg, vector=True)
    angles = np.radians(angles_deg)
    check_some("shaft_angles_deg", angles, "forces are those at an angle")
    shape = (len(engine.cylinders), angles.size)
    turning = over_angles("speed", turning_speeds("speed", speed), angles)
    gaining = over_angles("crank_acceleration", crank_acceleration, angles)
    reason = "there is a value for each cylinder and shaft angle"
    pressing = spread_array("gas", gas, shape, reason)
    rubbing = spread_array("friction", friction, shape, reason)
    side = np.zeros(shape)
    piston_pin, foot, crankpin = (np.zeros(shape, dtype=np.complex128) for _ in range(3))
    motions = [parts_motion(engine, number + 1, angles) for number in range(shape[0])]
    for place, cylinder in enumerate(engine.cylinders):
        rod, motion = cylinder.rod.model(model), motions[place]
        acceleration = motion.piston.acceleration(turning, gaining).real
        along = -(pressing[place] - rubbing[place]) - cylinder.piston_mass * acceleration
        # M a_D, and the moment that the rod's motion about its foot requires.
        inertia = rod.mass * motion.rod_point(rod.center).acceleration(turning, gaining)
        arm = rod.center * np.exp(1j * motion.rod.angle_rad)
        moment = rod.inertia * motion.rod.acceleration(turning, gaining)
        moment = moment + (np.conj(arm) * inertia).imag
        sine, cosine = np.sin(motion.rod.angle_rad), np.cos(motion.rod.angle_rad)
        at_piston = along + 1j * (moment / rod.length + along * sine) / cosine
        side[place] += at_piston.imag
        piston_pin[place] -= at_piston
        at_foot = at_piston - inertia
        foot[place] += at_foot
        main = engine.main_of(place + 1) - 1
        if main == place:
            crankpin[place] = at_foot * np.exp(1j * math.radians(cylinder.bank_angle_deg))
            continue
        carrier = engine.cylinders[main]
        load = at_foot * np.exp(
            1j * (math.radians(cylinder.bank_angle_deg - carrier.bank_angle_deg))
        )
        if cylinder.slave_pin is None:
            raise ValueError("the rod is not hinged")
        # What the wall of the main piston adds to N, to balance the force at the slave pin.
        carrier_angle = motions[main].rod.angle_rad
        arm = cylinder.slave_pin.place * np.exp(1j * carrier_angle)
        from_wall = -(np.conj(arm) * load).imag / (carrier.rod.length * np.cos(carrier_angle))
        side[main] += from_wall
        piston_pin[main] -= 1j * from_wall
        foot[main] += load + 1j * from_wall
        crankpin[place] = (load + 1j * from_wall) * np.exp(
            1j * math.radians(carrier.bank_angle_deg)
        )
    return MechanismForces(
        engine, angles_deg, turning, gaining, model, pressing, side, piston_pin, foot, crankpin
    )


def spread_array(field: str, values: ArrayLike, shape: tuple[int, ...], reason: str) -> Array:
    """Return finite values as an array, broadcast to a shape."""
    array = finite_array(field, values)
    try:
        return np.array(np.broadcast_to(array, shape))
    except ValueError:
        raise InputError(
            f"{field}: given an array of shape {array.shape}; allowed is a number or an array that fits "
            f"{shape}, because {reason}."
        ) from None


def over_angles(field: str, values: ArrayLike, angles: Array) -> Array:
    """Return a quantity of the shaft at each of its angles (m,) [rad]; see `spread_array`."""
    return spread_array(field, values, angles.shape, "there is one value for each shaft angle")


def pin_groups(engine: EngineLayout) -> tuple[tuple[int, ...], ...]:
    """Return the numbers of the cylinders that load each main rod's foot, main cylinder first."""
    groups: dict[int, list[int]] = {}
    for number in range(1, len(engine.cylinders) + 1):
        groups.setdefault(engine.main_of(number), []).append(number)
    return tuple(
        tuple(sorted(group, key=lambda number: number != main))
        for main, group in sorted(groups.items())
    )


def rod_models(engine: EngineLayout, model: RodModelName) -> tuple[RodModel, ...]:
    """Return the model of each cylinder's rod."""
    return tuple(cylinder.rod.model(model) for cylinder in engine.cylinders)


def summed(forces: MechanismForces, cylinders: Sequence[int]) -> ComplexArray:
    """Return the force of several cylinders on their common crankpin, y - i x (m,) [N]."""
    return np.asarray(forces.crankpin[[number - 1 for number in cylinders]].sum(axis=0))


class Cyclic(Protocol):
    """What repeats with the working cycle."""

    @property
    def strokes(self) -> int:
        """Strokes per cycle, 2 or 4."""
        ...


Curve = TypeVar("Curve", bound=Cyclic)


class Pressure(Cyclic, Protocol):
    """A pressure over the working cycle."""

    def at(self, *, angle_deg: ArrayLike) -> Array:
        """Return the absolute pressure [Pa] at angles [deg] from the firing top."""
        ...


def gas_forces(
    engine: EngineLayout,
    pressure: Pressure | Sequence[Pressure],
    crankcase_pressure: float = ATMOSPHERE,
    *,
    shaft_angles_deg: ArrayLike,
) -> Array:
    """Return the gas force on each piston towards the shaft.

    Parameters
    ----------
    pressure : GasPressure or sequence of n GasPressure
        One for all cylinders, each counted from its own firing top, or one for each cylinder.
    crankcase_pressure : float, optional
        Absolute pressure under the pistons [Pa].

    Returns
    -------
    ndarray of shape (n, m)
        (p - p_crankcase) times piston area [N].

    Raises
    ------
    InputError
        If there is not one pressure for each cylinder, or its cycle has other strokes.
    """
    angles = radians_of("shaft_angles_deg", shaft_angles_deg, vector=True)
    under = nonnegative_number("crankcase_pressure", crankcase_pressure, "Pa", "it is absolute")
    return np.array(
        [
            cylinder.area * (curve.at(angle_deg=np.degrees(angles - firing)) - under)
            for cylinder, firing, curve in zip(
                engine.cylinders,
                np.radians(engine.firing_deg),
                pressure_of_each("pressure", pressure, engine),
                strict=True,
            )
        ]
    )


def pressure_of_each(
    field: str, pressure: Curve | Sequence[Curve], engine: EngineLayout
) -> list[Curve]:
    """Return the pressure in each cylinder of an engine, each over a cycle of the engine's strokes."""
    count = len(engine.cylinders)
    pressures = list(pressure) if isinstance(pressure, Sequence) else [pressure] * count
    if len(pressures) != count:
        raise InputError(
            f"{field}: given {len(pressures)} for {count} cylinders; allowed is one for all, or one for "
            "each cylinder, because each piston has its own force."
        )
    for curve in pressures:
        if curve.strokes != engine.strokes:
            raise InputError(
                f"{field}: given a cycle of {curve.strokes} strokes; allowed is {engine.strokes}, because "
                "that is the engine's."
            )
    return pressures


def piston_position(engine: EngineLayout, number: int) -> Position:
    """Return the position of a cylinder's piston over the angle from its firing top.

    Returns
    -------
    callable
        Angles [rad] of shape (m,) to positions of the piston pin along the cylinder axis, away from the
        shaft [m], as required by `gas_cycle`.
    """
    checked = checked_cylinder(engine, number)
    firing = np.radians(engine.firing_deg[checked - 1])
    return lambda angle: parts_motion(engine, checked, firing + angle).piston.place.real


Result = TypeVar("Result")


def for_each_cylinder(
    engine: EngineLayout, calculate: Callable[[Position, float], Result]
) -> tuple[Result, ...]:
    """Calculate something of each cylinder's piston and area, once for all whose pistons move alike."""
    results: dict[object, Result] = {}
    places = []
    for number, cylinder in enumerate(engine.cylinders, start=1):
        main = engine.cylinders[engine.main_of(number) - 1]
        turned = round(math.radians(cylinder.bank_angle_deg - main.bank_angle_deg), 12)
        pin = None if cylinder.slave_pin is None else cylinder.slave_pin.place
        alike = (cylinder.bore, cylinder.rod, cylinder.pin_offset, main.rod, turned, pin)
        if alike not in results:
            results[alike] = calculate(piston_position(engine, number), cylinder.area)
        places.append(alike)
    return tuple(results[alike] for alike in places)


def full_load_parameters(load: FullLoad, engine: EngineLayout) -> tuple[GasCycle, tuple[str, ...]]:
    """Return the cycle's parameters in all cylinders, from the first main one, and what is assumed."""
    number = engine.main_of(1)
    return load.parameters(
        engine.strokes, piston_position(engine, number), engine.cylinders[number - 1].area
    )


def full_load_cycles(load: FullLoad, engine: EngineLayout) -> tuple[GasCycleResult, ...]:
    """Return the cycle in each cylinder that reaches the pressures of full load, (n,)."""
    cycle, assumed = full_load_parameters(load, engine)

    def fired(position: Position, area: float) -> GasCycleResult:
        result = gas_cycle(
            cycle,
            position,
            area,
            peak_pressure=load.peak_pressure,
            mean_effective_pressure=load.mean_effective_pressure,
        )
        return replace(result, pressure=_with_assumed(result.pressure, assumed))

    return for_each_cylinder(engine, fired)


def motored_pressures(load: FullLoad, engine: EngineLayout) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder of the engine turned without combustion, (n,)."""
    cycle, assumed = full_load_parameters(load, engine)

    def motored(position: Position, area: float) -> GasPressure:
        return _with_assumed(gas_cycle(cycle, position, area, heat=0.0).pressure, assumed)

    return for_each_cylinder(engine, motored)


def _with_assumed(pressure: GasPressure, assumed: tuple[str, ...]) -> GasPressure:
    return replace(pressure, remarks=assumed + pressure.remarks, assumed=assumed + pressure.assumed)


FEWEST_ANGLES = 3


@frozen("name", "maximum [N]", "maximum_angle_deg [deg]", "mean [N]", "angles_deg", eq=False)
class LoadDiagram:
    """The force on one bearing over a working cycle.

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Shaft angles [deg], even over one cycle, closing sample left out.
    force : complex ndarray of shape (m,)
        y - i x in the engine's frame [N]: of the rods on the crankpin, or of the main journal on its
        bearing.
    crank_angle_deg : float
        Angle of the crank that the rotating frame follows, about +z, counted from +y, when the shaft
        angle is zero [deg]: the crankpin's own; that of cylinder 1 for a main bearing.
    """

    name: str
    angles_deg: Array
    force: ComplexArray
    crank_angle_deg: float

    @property
    def in_crank_frame(self) -> ComplexArray:
        """Force in the frame that turns with the crank, -Z + i T, shape (m,) [N]."""
        return np.asarray(
            self.force * np.exp(-1j * np.radians(self.crank_angle_deg + self.angles_deg))
        )

    @property
    def magnitude(self) -> Array:
        """Size of the force, shape (m,) [N]."""
        return np.abs(self.force)

    @property
    def mean(self) -> float:
        """Mean size of the force over the cycle [N]."""
        return float(np.mean(self.magnitude))

    @property
    def maximum(self) -> float:
        """Largest size of the force at the sampled angles [N]."""
        return float(np.max(self.magnitude))

    @property
    def maximum_angle_deg(self) -> float:
        """Shaft angle of the largest force [deg]."""
        return float(self.angles_deg[int(np.argmax(self.magnitude))])

    def specific_pressure(self, diameter: float, length: float) -> Array:
        """Return the magnitude of the force over the journal's projected area, shape (m,) [Pa].

        Parameters
        ----------
        diameter, length : float
            Of the bearing surface [m].
        """
        across = positive_number("bearing diameter", diameter, "m", "it is a length")
        along = positive_number("bearing length", length, "m", "it is a length")
        return self.magnitude / (across * along)

    def columns(self) -> dict[str, Array]:
        """Return the columns of a table of the diagram, each of shape (m,), units in the names."""
        turning = self.in_crank_frame
        return {
            "shaft_angle_deg": self.angles_deg,
            "force_x_N": -self.force.imag,
            "force_y_N": self.force.real,
            "tangential_N": turning.imag,
            "radial_N": -turning.real,
            "magnitude_N": self.magnitude,
        }

    def plot(
        self, axes: Axes | None = None, *, frame: Frame | None = None, mark_step_deg: float = 30.0
    ) -> Axes:
        """Draw the polar load diagram in a frame, or the magnitude of the force over the shaft angle.

        Parameters
        ----------
        frame : {"crank", "engine"}, optional
            "crank": the locus of the force vector in the frame that turns with the crank, tangential
            force to the right, radial force (towards the shaft) down. "engine": in the fixed frame,
            seen from the free end. By default the magnitude of the force over the shaft angle.
        mark_step_deg : float, optional
            Interval of the dots on the locus in shaft angle [deg]; only with a frame.
        """
        check_polar("crank" if frame is None else frame, mark_step_deg)
        if frame is None:
            axes = new_axes(axes)
            draw_diagram(axes, developed_load(self))
            write_title(
                axes,
                f"{self.name}: mean {format_number(KILO * self.mean, 4)} kN, maximum "
                f"{format_number(KILO * self.maximum, 4)} kN",
            )
            return axes
        axes = new_axes(axes, width=6.4, height=6.4)
        draw_polar_loads(axes, [(self.name, self)], frame, mark_step_deg)
        write_title(axes, self.name)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return the force in both frames, a row for each shaft angle."""
        forces = {
            name[:-2]: (force, "N") for name, force in self.columns().items() if name[-2:] == "_N"
        }
        return table({"shaft_angle": (self.angles_deg, "deg"), **forces})


def crankpin_loads(forces: MechanismForces) -> tuple[LoadDiagram, ...]:
    """Return the load of each crankpin bearing.

    Parameters
    ----------
    forces : MechanismForces
        At even angles over one working cycle; a closing sample is left out.

    Returns
    -------
    tuple of LoadDiagram
        One for each rod on the crankshaft, in the order of the cylinders: rods side by side on one
        pin have bearings of their own, rods hinged to a main rod load its bearing.

    Raises
    ------
    InputError
        If the angles are not even over one cycle.

    Notes
    -----
    The force is that of the rod on the pin, including the rod's inertia; the pin exerts the opposite
    force on the rod's bearing.
    """
    used = _one_cycle(forces)
    diagrams = []
    for group in pin_groups(forces.engine):
        noun = "cylinder" if len(group) == 1 else "cylinders"
        numbers = " and ".join(str(number) for number in group)
        diagrams.append(
            LoadDiagram(
                f"crankpin, {noun} {numbers}",
                forces.shaft_angles_deg[:used],
                summed(forces, group)[:used],
                forces.engine.cylinders[group[0] - 1].crank_angle_deg,
            )
        )
    return tuple(diagrams)


def main_bearing_loads(
    forces: MechanismForces, bearing_positions: ArrayLike
) -> tuple[LoadDiagram, ...]:
    """Return the load of each main bearing, as if the shaft were hinged at every bearing.

    Each force acts on the two adjacent bearings according to the lever: statically determinate. A
    continuous shaft shares every load among all bearings, by its own stiffness
    and the bearings'; loads on the bearings next to the force are then usually smaller, and loads
    two bearings away not zero.

    Parameters
    ----------
    bearing_positions : array_like of shape (k,)
        Of the bearings' middles along the shaft, ascending [m].

    Returns
    -------
    tuple of k LoadDiagram
        Of the journals on their bearings. Rods load the shaft at the position of the cylinder whose
        rod is on the crankpin, rotating masses at their own. Weights are neglected.

    Raises
    ------
    InputError
        If the angles are not even over one cycle, there are fewer than two bearings, their positions
        do not ascend, a load is not between them, or cylinders are at the same position.
    """
    used = _one_cycle(forces)
    bearings = finite_vector("bearing_positions", bearing_positions)
    if bearings.size < 2 or np.any(np.diff(bearings) <= 0.0):
        raise InputError(
            f"bearing_positions: given {bearings.tolist()} m; allowed are two or more ascending "
            "positions, because every load lies between two bearings."
        )
    engine, angles = forces.engine, forces.shaft_angles_deg
    check_distinct_positions(engine)
    groups = {f"cylinder {group[0]}": group for group in pin_groups(engine)}
    places = {name: engine.cylinders[group[0] - 1].position for name, group in groups.items()}
    loads = [summed(forces, group) for group in groups.values()]
    turned = np.radians(angles)
    # A mass at r turns with it: its force on the shaft is -m r'' = m r (w^2 - i w').
    swing = forces.speed**2 - 1j * forces.crank_acceleration
    for number, mass in enumerate(engine.rotating, start=1):
        places[f"rotating mass {number}"] = mass.position
        loads.append(
            mass.static_moment * swing * np.exp(1j * (math.radians(mass.angle_deg) + turned))
        )
    for name, place in places.items():
        if not bearings[0] <= place <= bearings[-1]:
            raise InputError(
                f"{name}: position: given {in_si(place, 'm')}; allowed is "
                f"{in_si(bearings[0], 'm')} to {in_si(bearings[-1], 'm')}, because a load "
                "beyond the end bearings needs the shaft's stiffness to be shared."
            )
    # Bearing j takes the share of a load that a hat function has at its place.
    shares = np.array(
        [np.interp(list(places.values()), bearings, hat) for hat in np.eye(bearings.size)]
    )
    carried = shares @ np.array(loads)[:, :used]
    crank_angle = engine.cylinders[0].crank_angle_deg
    return tuple(
        LoadDiagram(f"main bearing {number}", angles[:used], force, crank_angle)
        for number, force in enumerate(carried, start=1)
    )


def _one_cycle(forces: MechanismForces) -> int:
    """Return how many of the angles are in one cycle, without the closing one."""
    degrees, cycle = forces.shaft_angles_deg, cycle_degrees(forces.engine.strokes)
    if degrees.size < FEWEST_ANGLES:
        raise InputError(
            f"shaft_angles_deg: given {degrees.size} angles; allowed are even steps over one cycle of "
            f"{cycle:g} deg, because a load's mean is taken over the cycle."
        )
    used = degrees.size - has_closing_sample(degrees, cycle)
    check_even_cycle("shaft_angles_deg", degrees[:used], cycle)
    return used
