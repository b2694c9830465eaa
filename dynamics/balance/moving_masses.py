"""Reciprocating and rotating masses at the ends of the rods, and their forces by order."""

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import ComplexArray, FloatArray, nonnegative_number
from crankbase.summaries import summarized
from dynamics.balance.hodograph import Hodograph
from dynamics.engine.cylinder import RotatingMass
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import parts_motion
from dynamics.engine.orders import turn_spectrum

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

    Parameters
    ----------
    engine : EngineLayout

    Returns
    -------
    tuple of n MovingMasses

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
    >>> from dynamics.engine.cylinder import EngineCylinder
    >>> from dynamics.mechanism.rods import ConnectingRod
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
    engine : EngineLayout
    masses : sequence of n float
        One for each cylinder [kg].
    speed : float
        Of the shaft [rad/s].
    orders : sequence of int
        Cycles per revolution of the shaft.

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
    engine : EngineLayout
    forces : callable
        Takes shaft angles (m,) [rad] and returns forces s + i n (n, m) [N].
    orders : sequence of int
        Cycles per revolution of the shaft.

    Returns
    -------
    dict
        For each order the n forces [N].
    """
    spectrum = turn_spectrum(forces, max(orders))
    found: dict[int, list[PlacedForce]] = {}
    for order in orders:
        ahead, back = spectrum[..., order].tolist(), spectrum[..., -order].tolist()
        found[order] = [
            (
                cylinder.position,
                Hodograph(order, forward, backward).times(
                    cmath.exp(1j * math.radians(cylinder.bank_angle_deg))
                ),
            )
            for cylinder, forward, backward in zip(engine.cylinders, ahead, back, strict=True)
        ]
    return found
