"""Checks of the values of user functions: one clear sentence each."""

import math

from crankbase.errors import InputError, quoted


def checked_moment(
    field: str, given: float, speed: float, angle: float, largest: float = math.inf
) -> float:
    """Return a moment [N m] that a given function has returned.

    Cheap enough for every step of an integration, which would never end with a value that is not
    finite.

    Parameters
    ----------
    field : str
        Whose moment it is.
    given : float
        [N m]
    speed, angle : float
        Where the function was asked [rad/s, rad].
    largest : float, optional
        [N m]

    Raises
    ------
    InputError
        If it is not a finite number, or larger than that.
    """
    moment = _number(given)
    if not (math.isfinite(moment) and abs(moment) <= largest):
        raise InputError(
            f"{field}: given a moment of {quoted(given)} N m at {speed:.6g} rad/s and a shaft angle of "
            f"{math.degrees(angle):.6g} deg; allowed are finite numbers"
            f"{'' if largest == math.inf else f' of up to {largest:g}'}, because the speed follows from the "
            "moments."
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
