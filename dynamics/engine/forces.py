"""Gas pressures and forces in the mechanism of every cylinder, by equilibrium of pistons and rods."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    checked_degrees,
    finite_array,
    nonnegative_number,
    radians_of,
    turning_speeds,
)
from crankbase.choices import whole_within
from crankbase.errors import InputError
from crankbase.frames import Axes, Dataset, grid
from crankbase.summaries import summarized
from dynamics.cycle import cycle_radians
from dynamics.engine import RodModelName
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.motions import CylinderMotion, checked_cylinder, parts_motion
from dynamics.engine.rods import RodModel
from dynamics.gas.cycle_values import GasCycle
from dynamics.gas.cylinder_volume import Position
from dynamics.gas.gas_cycle import FullLoad, GasCycleResult, gas_cycle
from dynamics.gas.pressure import ATMOSPHERE, GasPressure
from dynamics.plots.curves import FROM_FIRING, draw_over_angle
from dynamics.plots.quantities import KILO, angle_axis, number_axis


@summarized("speed [rad/s]", "model", "gas [N]", "torque [N m]")
@dataclass(frozen=True, eq=False)
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
    shaft_angles_deg: FloatArray
    speed: FloatArray
    crank_acceleration: FloatArray
    model: RodModelName
    gas: FloatArray
    side: FloatArray
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
    def tangential(self) -> FloatArray:
        """T, on the crankpin in the sense of rotation, of each cylinder (n, m) [N]."""
        return self.in_crank_frame.imag

    @property
    def radial(self) -> FloatArray:
        """Z, on the crankpin towards the shaft axis, of each cylinder (n, m) [N]."""
        return -self.in_crank_frame.real

    @property
    def torque(self) -> FloatArray:
        """R T, of each cylinder on the shaft, positive when it drives (n, m) [N m]."""
        return self.engine.crank_radius * self.tangential

    def plot(self, axes: Axes | None = None, cylinder: int = 1) -> Axes:
        """Draw gas force, tangential force and side force of a cylinder over its cycle."""
        place = whole_within("cylinder", cylinder, 1, len(self.gas), "the engine has that many") - 1
        since_firing = (
            np.radians(self.shaft_angles_deg) - np.radians(self.engine.firing_deg[place])
        ) % cycle_radians(self.engine.strokes)
        order = np.argsort(since_firing)
        curves = {
            "gas, towards the shaft": self.gas,
            "tangential, T": self.tangential,
            "side, N": self.side,
        }
        return draw_over_angle(
            axes,
            since_firing[order],
            {name: KILO * values[place][order] for name, values in curves.items()},
            "force [kN]",
            title=f"Forces of cylinder {cylinder}",
            angle_label=FROM_FIRING,
            cyclic=False,
        )

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


def mechanism_forces(
    engine: EngineLayout,
    speed: float | FloatArray,
    gas: ArrayLike = 0.0,
    *,
    shaft_angles_deg: ArrayLike,
    model: RodModelName = "rigid",
    friction: ArrayLike = 0.0,
    crank_acceleration: float | FloatArray = 0.0,
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
    if angles.size == 0:
        raise InputError(
            "shaft_angles_deg: given none; allowed are one or more, because forces are those at an angle."
        )
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
        inertia, moment = _inertia_forces(rod, motion, turning, gaining)
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
        from_wall = _wall_force_for(load, cylinder, carrier, motions[main])
        side[main] += from_wall
        piston_pin[main] -= 1j * from_wall
        foot[main] += load + 1j * from_wall
        crankpin[place] = (load + 1j * from_wall) * np.exp(
            1j * math.radians(carrier.bank_angle_deg)
        )
    return MechanismForces(
        engine, angles_deg, turning, gaining, model, pressing, side, piston_pin, foot, crankpin
    )


def spread_array(field: str, values: ArrayLike, shape: tuple[int, ...], reason: str) -> FloatArray:
    """Return finite values as an array, broadcast to a shape."""
    array = finite_array(field, values)
    try:
        return np.array(np.broadcast_to(array, shape))
    except ValueError:
        raise InputError(
            f"{field}: given an array of shape {array.shape}; allowed is a number or an array that fits "
            f"{shape}, because {reason}."
        ) from None


def over_angles(field: str, values: ArrayLike, angles: FloatArray) -> FloatArray:
    """Return a quantity of the shaft at each of its angles (m,) [rad]; see `spread_array`."""
    return spread_array(field, values, angles.shape, "there is one value for each shaft angle")


def _inertia_forces(
    rod: RodModel, motion: CylinderMotion, speed: FloatArray, crank_acceleration: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Return M a_D, and the moment required by the rod's motion about its foot."""
    force = rod.mass * motion.rod_point(rod.center).acceleration(speed, crank_acceleration)
    arm = rod.center * np.exp(1j * motion.rod.angle_rad)
    turning = rod.inertia * motion.rod.acceleration(speed, crank_acceleration)
    return force, turning + (np.conj(arm) * force).imag


def _wall_force_for(
    load: ComplexArray, hinged: EngineCylinder, carrier: EngineCylinder, motion: CylinderMotion
) -> FloatArray:
    """Return the contribution of the main piston's wall to N that balances a force at the slave pin."""
    if hinged.slave_pin is None:
        raise ValueError("the rod is not hinged")
    arm = hinged.slave_pin.place * np.exp(1j * motion.rod.angle_rad)
    moment = (np.conj(arm) * load).imag
    return np.asarray(-moment / (carrier.rod.length * np.cos(motion.rod.angle_rad)))


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

    def at(self, *, angle_deg: ArrayLike) -> FloatArray:
        """Return the absolute pressure [Pa] at angles [deg] from the firing top."""
        ...


def gas_forces(
    engine: EngineLayout,
    pressure: Pressure | Sequence[Pressure],
    crankcase_pressure: float = ATMOSPHERE,
    *,
    shaft_angles_deg: ArrayLike,
) -> FloatArray:
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
    """Return the cycle's parameters in all cylinders, from the first main one, and remarks on them."""
    number = engine.main_of(1)
    return load.parameters(
        engine.strokes, piston_position(engine, number), engine.cylinders[number - 1].area
    )


def full_load_cycles(load: FullLoad, engine: EngineLayout) -> tuple[GasCycleResult, ...]:
    """Return the cycle in each cylinder that reaches the pressures of full load, (n,)."""
    cycle, remarks = full_load_parameters(load, engine)

    def fired(position: Position, area: float) -> GasCycleResult:
        result = gas_cycle(
            cycle,
            position,
            area,
            peak_pressure=load.peak_pressure,
            mean_effective_pressure=load.mean_effective_pressure,
        )
        return replace(result, pressure=_with_remarks(result.pressure, remarks))

    return for_each_cylinder(engine, fired)


def motored_pressures(load: FullLoad, engine: EngineLayout) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder of the engine turned without combustion, (n,)."""
    cycle, remarks = full_load_parameters(load, engine)

    def motored(position: Position, area: float) -> GasPressure:
        return _with_remarks(gas_cycle(cycle, position, area, heat=0.0).pressure, remarks)

    return for_each_cylinder(engine, motored)


def _with_remarks(pressure: GasPressure, remarks: tuple[str, ...]) -> GasPressure:
    return replace(pressure, remarks=remarks + pressure.remarks)
