"""Motion of the parts of each cylinder as the shaft turns."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    checked_degrees,
    positive_number,
    radians_of,
)
from crankbase.choices import is_whole, whole_within
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.cycle import even_angles
from dynamics.engine.layout import EngineLayout, cylinder_crankpin, hinged_foot
from dynamics.engine.rods import RodModel
from dynamics.engine.slider_crank import PointMotion, TurnMotion, carried_point, rod_turn
from dynamics.harmonics import Harmonics, harmonics

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
    """Return the motion of a cylinder's parts."""
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


# Samples over a turn are doubled until the upper orders are round-off: below this share of the
# largest value. A crank of 0.999 rod lengths still needs less than the most.
ROUND_OFF = 1e-14
TURN = 2.0 * np.pi
FEWEST, MOST = 64, 32768


def turn_spectrum(
    function: Callable[[FloatArray], NDArray[np.float64] | ComplexArray], highest: int
) -> ComplexArray:
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
) -> FloatArray:
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


def order_part(spectrum: Harmonics, order: int, angles: FloatArray) -> FloatArray:
    """Return one order of an acceleration at crank angles (m,) [rad], shape (m,) [m/s^2]."""
    place = spectrum.index_of(order)
    return np.asarray(
        spectrum.cosine[place] * np.cos(order * angles)
        + spectrum.sine[place] * np.sin(order * angles)
    )
