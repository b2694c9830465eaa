"""Motion of the parts of each cylinder as the shaft turns."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.cycle import even_angles
from dynamics.engine.cylinder import cylinder_crankpin, hinged_foot
from dynamics.engine.layout import EngineLayout
from dynamics.mechanism.motion import PointMotion, TurnMotion, carried_point, rod_turn
from dynamics.mechanism.rods import RodModel

# Angles among which a piston's ends of stroke are looked for, and steps of Newton's method after.
SEARCH_ANGLES = 360
NEWTON_STEPS = 8


@summarized("piston.place [m]")
@dataclass(frozen=True, eq=False)
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
    """Return the motion of a cylinder's parts.

    Parameters
    ----------
    engine : EngineLayout
    number : int
        Of the cylinder, from 1.
    shaft_angles_deg : array_like of shape (m,)
        [deg]

    Raises
    ------
    InputError
        If an angle is not a finite number, they are radians, or there is no such cylinder.
    """
    return parts_motion(engine, number, radians_of("shaft_angles_deg", shaft_angles_deg))


def parts_motion(engine: EngineLayout, number: int, shaft_angles: FloatArray) -> CylinderMotion:
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
) -> tuple[FloatArray, FloatArray]:
    """Return the inertia reduced to the crank, I in T = I w^2 / 2, and its derivative by the angle.

    Parameters
    ----------
    engine : EngineLayout
    models : tuple of n RodModel
        Of each cylinder's rod.
    shaft_angles_deg : array_like of shape (m,)
        [deg]

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
    if len(models) != len(engine.cylinders):
        raise InputError(
            f"models: given {len(models)} for {len(engine.cylinders)} cylinders; allowed is one for each, "
            "because each cylinder has a rod."
        )
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
