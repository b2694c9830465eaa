"""Checks of the values of user functions: one clear sentence each."""

import math

from crankbase.errors import InputError, quoted


def checked_moment(field: str, given: float, speed: float, angle: float) -> float:
    """Return a moment [N m] from a user function, checked.

    Cheap enough for every step of an integration, which would never end with a value that is not
    finite.

    Parameters
    ----------
    field : str
        Whose moment it is.
    given : float
        [N m]
    speed, angle : float
        Arguments of the function [rad/s, rad].

    Raises
    ------
    InputError
        If it is not a finite number.
    """
    moment = _number(given)
    if not math.isfinite(moment):
        raise InputError(
            f"{field}: given a moment of {quoted(given)} N m at {speed:.6g} rad/s and a shaft angle of "
            f"{math.degrees(angle):.6g} deg; allowed are finite numbers, because the speed follows from "
            "the moments."
        )
    return moment


def checked_inertia(given: float, angle: float, least: float = 0.0) -> float:
    """Return an inertia [kg m^2] at an angle [rad].

    Raises
    ------
    InputError
        If it is not a finite number above `least`.
    """
    inertia = _number(given)
    if not least < inertia < math.inf:
        raise InputError(
            f"inertia: given {quoted(given)} kg m^2 at a shaft angle of {math.degrees(angle):.6g} deg; "
            "allowed are finite numbers clearly above zero, because a shaft without inertia has no speed "
            "that follows from the moments."
        )
    return inertia


def _number(given: float) -> float:
    """Return the value of a user function as a float, NaN if it is none."""
    try:
        return float(given)
    except (TypeError, ValueError, OverflowError):
        return math.nan
