"""Inertia forces of the cylinders by order, each with its place along the shaft."""

import cmath
from collections.abc import Callable, Sequence

import numpy as np
from crankbase.checks.arrays import ComplexArray, FloatArray

from dynamics.balance.hodograph import Hodograph
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import cylinder_motion
from dynamics.engine.orders import turn_spectrum

# A force and where along the shaft it acts [m].
PlacedForce = tuple[float, Hodograph]


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
        Cycles per turn of the shaft.

    Returns
    -------
    dict
        For each order the n forces, in the engine's frame [N].
    """
    numbers = range(1, len(engine.cylinders) + 1)

    def forces(angles: FloatArray) -> ComplexArray:
        motions = (cylinder_motion(engine, number, angles).piston for number in numbers)
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
        Cycles per turn of the shaft.

    Returns
    -------
    dict
        For each order the n forces [N].
    """
    spectrum = turn_spectrum(forces, max(orders))
    found: dict[int, list[PlacedForce]] = {}
    for order in orders:
        ahead, back = spectrum.of(order).tolist(), spectrum.of(-order).tolist()
        found[order] = [
            (
                cylinder.position,
                Hodograph(order, forward, backward).times(cmath.exp(1j * cylinder.bank_angle)),
            )
            for cylinder, forward, backward in zip(engine.cylinders, ahead, back, strict=True)
        ]
    return found
