"""Curves in polar coordinates: curvature, and the parallel curve on which a roller runs."""

import numpy as np

from crankbase.checks.arrays import ComplexArray, FloatArray
from crankbase.errors import InputError


def polar_curvature(radius: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the curvature of a curve rho(phi).

    Parameters
    ----------
    radius, first, second : ndarray of shape (m,)
        rho [m] and its derivatives by the angle [m/rad, m/rad^2].

    Returns
    -------
    ndarray of shape (m,)
        (rho^2 + 2 rho'^2 - rho rho'') / (rho^2 + rho'^2)^(3/2) [1/m], positive where the curve
        bends around the origin, like a circle about it.
    """
    square = radius**2 + first**2
    return np.asarray((square + first**2 - radius * second) / square**1.5)


def outer_parallel(
    angles: FloatArray, radius: FloatArray, first: FloatArray, distance: float
) -> ComplexArray:
    """Return the points outside a curve rho(phi) at a distance from it along its normals.

    Parameters
    ----------
    angles, radius, first : ndarray of shape (m,)
        phi [rad], rho [m] and its derivative [m/rad].
    distance : float
        Radius of a roller whose center runs along the curve [m].

    Returns
    -------
    complex ndarray of shape (m,)
        Points x + i y [m].

    Notes
    -----
    The tangent of rho exp(i phi) is (rho' + i rho) exp(i phi); the outer normal is -i times it.
    """
    direction = np.exp(1j * angles)
    normal = (radius - 1j * first) / np.hypot(radius, first)
    return np.asarray((radius + distance * normal) * direction)


def smallest_hollow(curvature: FloatArray) -> float:
    """Return the smallest radius of curvature where a curve bends away from the origin [m].

    Infinite if it does so nowhere. A larger roller outside the curve would undercut it.
    """
    least = float(np.min(curvature))
    return -1.0 / least if least < 0.0 else float("inf")


def check_roller(roller_radius: float, curvature: FloatArray) -> None:
    """Refuse a roller whose guide would have a cusp.

    Raises
    ------
    InputError
    """
    hollow = smallest_hollow(curvature)
    if roller_radius >= hollow:
        raise InputError(
            f"roller_radius: given {roller_radius:g} m; allowed is less than {hollow:.4g} m, because "
            "there the roller's path bends away from the axis with that radius, and the guide of a "
            "larger roller has a cusp."
        )
