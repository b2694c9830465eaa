"""The kinetic energy of a shaft for a given mean speed, from the energy gained."""

import numpy as np

from crankbase.checks.arrays import FloatArray

# A shaft that has less than this share of the swing of energy left at its slowest is taken as not
# coming round.
LEAST_ENERGY = 1e-6
# Lowest energy that is tried at all, as a share of the highest.
TRIED_ENERGY = 1e-12


def mean_speed(energy: FloatArray, inertia: FloatArray) -> float:
    """Return the mean over time of the speed [rad/s].

    Parameters
    ----------
    energy, inertia : ndarray of shape (m,)
        Kinetic energy [J] and inertia [kg m^2] at even angles over a period.
    """
    return 1.0 / float(np.mean(np.sqrt(0.5 * inertia / energy)))


def slowest_mean_speed(gained: FloatArray, inertia: FloatArray) -> float:
    """Return the least mean speed at which a shaft completes a revolution [rad/s].

    Parameters
    ----------
    gained, inertia : ndarray of shape (m,)
        Energy gained since the first angle [J], not constant, and inertia [kg m^2], at
        even angles.
    """
    swing = float(np.ptp(gained))
    return mean_speed(gained - gained.min() + LEAST_ENERGY * swing, inertia)


def energy_for_mean_speed(gained: FloatArray, inertia: FloatArray, speed: float) -> float | None:
    """Return the kinetic energy at the first angle of a shaft with a given mean speed.

    Parameters
    ----------
    gained, inertia : ndarray of shape (m,)
        As for `slowest_mean_speed`; the energy gained may be constant.
    speed : float
        Required mean over time [rad/s].

    Returns
    -------
    float or None
        [J]; None if the shaft does not complete a revolution at this speed.

    Notes
    -----
    The mean speed grows with the energy: one root, between a shaft that barely completes the revolution
    and one whose least energy is that of the largest inertia at the required speed.
    """
    from scipy.optimize import brentq

    swing, lacking = float(np.ptp(gained)), -float(gained.min())

    def excess(above: float) -> float:
        return mean_speed(gained + (lacking + above), inertia) - speed

    # A little more, for the swing may be lost beside it in round-off.
    highest = (1.0 + 1e-9) * (0.5 * speed**2 * float(inertia.max()) + swing)
    lowest = max(LEAST_ENERGY * swing, TRIED_ENERGY * highest)
    if excess(lowest) > 0.0:
        return None
    return lacking + float(brentq(excess, lowest, highest, rtol=1e-14, xtol=1e-12))
