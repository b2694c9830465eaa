"""Inertia of crank throws with their rods and pistons, as constants for torsional chains."""

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import (
    FloatArray,
    finite_array,
    nonnegative_number,
    nonnegative_vector,
    one_for_each,
    positive_number,
)
from crankbase.checks.choices import check_choice
from dynamics.cycle import even_angles
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import parts_motion
from dynamics.mechanism.rods import ConnectingRod, RodModel
from dynamics.torque.throws import checked_throws, throws_along_shaft

Reciprocating = Literal["half", "mean"]
# The reduced inertia is smooth and periodic: its mean over even angles converges exponentially.
MEAN_ANGLES = 360


def throw_inertia(
    solid_inertia_about_shaft: float,
    rod_rotating_mass: ArrayLike,
    reciprocating_mass: ArrayLike,
    crank_radius: float,
) -> float:
    """Return the equivalent constant moment of inertia of a throw with its rods and pistons.

    Parameters
    ----------
    solid_inertia_about_shaft : float
        Moment of inertia of the solid throw about the shaft axis, counterweights included
        [kg m^2].
    rod_rotating_mass : float or array_like
        Share of the connecting rod that rotates with the crankpin [kg]; one value for each rod where
        a throw carries several.
    reciprocating_mass : float or array_like
        Piston with pin, and the share of the rod that moves with it [kg]; one for each cylinder.
    crank_radius : float
        R [m].

    Returns
    -------
    float
        I + m_rot R^2 + m_rec R^2 / 2, summed over the cylinders [kg m^2].

    Raises
    ------
    InputError
        If the inertia or the radius is not above zero, or a mass is negative.

    Notes
    -----
    The piston moves by R (sin a + (lambda / 2) sin 2a) per radian of crank angle, so that its
    inertia at the shaft varies over the revolution; half of the reciprocating mass is the mean of
    that over the cycle to zeroth order in the crank ratio lambda (the next term is
    m_rec R^2 lambda^2 / 8). `throw_inertias` gives the exact mean, for hinged rods too. The
    variation itself, which excites secondary resonances in slow engines with heavy pistons, is
    not included in a chain of constant inertias.
    """
    solid = positive_number(
        "solid_inertia_about_shaft", solid_inertia_about_shaft, "kg m^2", "every throw has inertia"
    )
    rotating = _masses("rod_rotating_mass", rod_rotating_mass)
    reciprocating = _masses("reciprocating_mass", reciprocating_mass)
    R = positive_number("crank_radius", crank_radius, "m", "the stroke is twice as long")
    return float(solid + (rotating.sum() + reciprocating.sum() / 2.0) * R**2)


def throw_inertias(
    engine: EngineLayout,
    solid_inertias: ArrayLike,
    *,
    reciprocating: Reciprocating = "half",
    throws: Sequence[int] | None = None,
) -> FloatArray:
    """Return the constant inertia of each throw of an engine with its rods and pistons.

    Parameters
    ----------
    engine : EngineLayout
        Cylinders with rods, hinged ones too, and pistons.
    solid_inertias : float or array_like of shape (t,)
        Moment of inertia of each solid throw about the shaft axis, counterweights included, or of
        all [kg m^2].
    reciprocating : {"half", "mean"}, optional
        "half" replaces the rod by two masses at its pins, and takes half of the mass that moves with the
        piston (for a hinged rod, with the slave pin as if it were at the crankpin). "mean" takes the
        mean over a revolution of the inertia exactly reduced to the crank, with rigid rods.
    throws : sequence of n int, optional
        Throw of each cylinder, from 0 at the free end; by default found from positions and angles.

    Returns
    -------
    ndarray of shape (t,)
        [kg m^2]

    Raises
    ------
    InputError
        If the choice is unknown, the lengths differ, or an inertia is not above zero.

    Notes
    -----
    Exactly, a cylinder contributes m_p |x_p'|^2 + m |x_c'|^2 + J beta'^2, primes being derivatives by
    the shaft angle: piston, rod's center, rod's rotation.
    """
    why = "these are the constants that represent the inertia of pistons"
    check_choice("reciprocating", reciprocating, get_args(Reciprocating), why)
    groups = throws_along_shaft(engine) if throws is None else checked_throws(engine, throws)
    solids = one_for_each(
        "solid_inertias",
        solid_inertias,
        len(groups),
        "throws",
        "kg m^2",
        "every throw has inertia",
        zero_allowed=False,
    )
    own = _half_shares(engine) if reciprocating == "half" else _means(engine)
    shares = [sum(own[number - 1] for number in group) for group in groups]
    return np.asarray(solids + np.array(shares))


def cylinder_inertia(
    engine: EngineLayout, number: int, rod: ConnectingRod | RodModel, angles: FloatArray
) -> FloatArray:
    """Return the inertia of a cylinder's piston and rod, reduced to the crank, over its angle.

    Parameters
    ----------
    engine : EngineLayout
    number : int
        Of the cylinder, from 1.
    rod : ConnectingRod or RodModel
        Model of its rod.
    angles : ndarray of shape (m,)
        Of the shaft [rad].

    Returns
    -------
    ndarray of shape (m,)
        m_p |x_p'|^2 + m |x_c'|^2 + J beta'^2, primes being derivatives by the shaft angle: piston,
        rod's center, rod's rotation [kg m^2].
    """
    motion = parts_motion(engine, number, angles)
    inertia = engine.cylinders[number - 1].piston_mass * np.abs(motion.piston.first) ** 2
    inertia += rod.mass * np.abs(motion.rod_point(rod.center).first) ** 2
    return np.asarray(inertia + rod.inertia * motion.rod.first**2)


def _half_shares(engine: EngineLayout) -> list[float]:
    shares = []
    for cylinder in engine.cylinders:
        rod = cylinder.rod
        at_piston = rod.mass * rod.center_distance / rod.length
        moving = cylinder.piston_mass + at_piston
        shares.append((rod.mass - at_piston + moving / 2.0) * engine.crank_radius**2)
    return shares


def _means(engine: EngineLayout) -> list[float]:
    angles = even_angles(2.0 * np.pi, MEAN_ANGLES)
    return [
        float(np.mean(cylinder_inertia(engine, number, cylinder.rod, angles)))
        for number, cylinder in enumerate(engine.cylinders, start=1)
    ]


def _masses(field: str, masses: ArrayLike) -> FloatArray:
    why = "it adds to the inertia of the throw"
    given = finite_array(field, masses)
    if given.ndim == 0:
        return np.array([nonnegative_number(field, float(given), "kg", why)])
    return nonnegative_vector(field, given, "kg", why)
