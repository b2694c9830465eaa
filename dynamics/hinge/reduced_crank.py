"""A crosshead engine reduced to its crank: inertia, piston travel and the moment of the weights."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import checked_degrees
from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.engine.forces import rod_models
from dynamics.engine.motions import parts_motion, reduced_inertia
from dynamics.hinge.crosshead import CrossheadEngine

Kinematics = Literal["exact", "series", "printed"]
KINEMATICS: tuple[Kinematics, ...] = get_args(Kinematics)


@summarized("inertia [kg m^2]", "travel_rate [m]", "weight_moment [N m]")
@dataclass(frozen=True, eq=False)
class ReducedCrank:
    """An engine of one degree of freedom reduced to its crank, arrays of shape (m,).

    Parameters
    ----------
    inertia : ndarray
        I, in T = I w^2 / 2 [kg m^2].
    inertia_rate : ndarray
        dI/dphi [kg m^2/rad].
    travel_rate : ndarray
        Travel of the piston towards the shaft per crank angle, dx/dphi [m/rad].
    weight_moment : ndarray
        Moment of the weights of crank and rod, positive when it drives [N m].
    """

    inertia: FloatArray
    inertia_rate: FloatArray
    travel_rate: FloatArray
    weight_moment: FloatArray


def reduced_crank(
    engine: CrossheadEngine, kinematics: Kinematics = "exact", *, angles_deg: ArrayLike
) -> ReducedCrank:
    """Reduce an engine to its crank.

    Parameters
    ----------
    engine : CrossheadEngine
    kinematics : str, optional
        "exact"; "series", in which velocities end at the second harmonic; or "printed", the series
        with the sign of the rod's second harmonic as printed in the source.
    angles_deg : array_like of shape (m,)
        Crank angles from the top dead center [deg].

    Raises
    ------
    InputError
        If there are no such kinematics, an angle is not a finite number, or they are radians.

    Notes
    -----
    The series is that of A. N. Zotov, E. Sh. Imaeva, Transport i khranenie nefteproduktov i
    uglevodorodnogo syr'ya 2024 no. 1-2, pp. 50-55, doi 10.24412/0131-4270-2024-1-2-50-55: with
    lambda = R / L, dx = R (sin phi + lambda/2 sin 2 phi) dphi, and
    cos gamma = 1 - lambda^2/4 + lambda^2/4 cos 2 phi for the rod's angle gamma. Its equations (2),
    (6), (7), (8) give the rod's center of mass the velocity R (sin phi - lambda l_1/(2 L) sin 2 phi)
    along the cylinder. From s = R cos phi + l_1 cos gamma it is plus: with l_1 = L the center of
    mass is at the crosshead, whose velocity has a plus in the same papers.
    """
    check_choice(
        "kinematics", kinematics, KINEMATICS, "these are the ways to describe the mechanism"
    )
    places_deg = checked_degrees("angles_deg", angles_deg, vector=True)
    places = np.radians(places_deg)
    if kinematics != "exact":
        return _series(engine, places, 1.0 if kinematics == "series" else -1.0)
    layout = engine.layout
    motion = parts_motion(layout, 1, places)
    rod_rise = motion.rod_point(engine.rod.center).first.imag
    return ReducedCrank(
        *reduced_inertia(layout, rod_models(layout, "rigid"), shaft_angles_deg=places_deg),
        travel_rate=-motion.piston.first.real,
        weight_moment=_weight_moment(engine, places, rod_rise),
    )


def _series(engine: CrossheadEngine, angles: FloatArray, sign: float) -> ReducedCrank:
    """Reduce with velocities up to the second harmonic; `sign` is that of the rod's own."""
    rod, radius, ratio = engine.rod, engine.crank_radius, engine.crank_ratio
    if rod.center_offset != 0.0:
        raise InputError(
            f"rod center_offset: given {rod.center_offset:g} m; allowed is 0 with the series, because it "
            "is for rods with the center of mass on their axis."
        )
    near = sign * rod.center_distance / rod.length
    far = 1.0 - rod.center_distance / rod.length
    sine, cosine = np.sin(angles), np.cos(angles)
    sine_2, cosine_2 = np.sin(2.0 * angles), np.cos(2.0 * angles)
    rod_cosine = 1.0 - 0.25 * ratio**2 + 0.25 * ratio**2 * cosine_2
    swing = ratio * cosine / rod_cosine
    swing_rate = ratio * (-sine / rod_cosine + 0.5 * ratio**2 * sine_2 * cosine / rod_cosine**2)
    travel_rate = radius * (sine + 0.5 * ratio * sine_2)
    travel_second = radius * (cosine + ratio * cosine_2)
    along = radius * (sine + 0.5 * ratio * near * sine_2)
    along_rate = radius * (cosine + ratio * near * cosine_2)
    across, across_rate = radius * far * cosine, -radius * far * sine
    inertia = (
        engine.crank_inertia
        + engine.sliding_mass * travel_rate**2
        + rod.mass * (along**2 + across**2)
        + rod.inertia * swing**2
    )
    rate = 2.0 * (
        engine.sliding_mass * travel_rate * travel_second
        + rod.mass * (along * along_rate + across * across_rate)
        + rod.inertia * swing * swing_rate
    )
    # The source joins the series of cos gamma to the exact derivative of gamma.
    exact_cosine = np.sqrt(1.0 - (ratio * sine) ** 2)
    rod_rise = (rod.length - rod.center_distance) * rod_cosine * ratio * cosine / exact_cosine
    return ReducedCrank(inertia, rate, travel_rate, _weight_moment(engine, angles, rod_rise))


def _weight_moment(engine: CrossheadEngine, angles: FloatArray, rod_rise: FloatArray) -> FloatArray:
    """Return the weights' moment from the rise of the rod's center by angle [m/rad]."""
    crank_rise = engine.crank_center_distance * np.cos(angles)
    return -engine.gravity * (engine.crank_mass * crank_rise + engine.rod.mass * rod_rise)
