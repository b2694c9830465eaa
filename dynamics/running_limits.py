"""Speeds within a range, and the longest duration of a motion."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.errors import InputError

# Speeds this near the end of a range, as a share, lie in it: 1.15 times a speed is rounded.
AT_END = 8.0 * float(np.finfo(np.float64).eps)
# Longest time that is followed, a day [s], and the most turns of a shaft: each takes milliseconds.
LONGEST_RUN, MOST_TURNS = 86_400.0, 20_000
# Most evaluations of a chain's equations in a search for its cycle or in a revolution, and of the moments
# on one shaft in a calculation: some ten seconds each.
MOST_EVALUATIONS, MOST_MOMENTS = 150_000, 500_000


def within(speeds: float | FloatArray, low: float, high: float) -> NDArray[np.bool_]:
    """Return which speeds are in a range, ends included within a few units in the last place."""
    return np.asarray(at_most(low, speeds) & at_most(speeds, high))


def at_most(one: float | FloatArray, other: float | FloatArray) -> NDArray[np.bool_]:
    """Return whether a speed is at most another, within a few units in the last place."""
    return np.asarray(one <= other * (1.0 + AT_END))


def run_time(field: str, value: float) -> float:
    """Return the duration of a motion [s], checked.

    Raises
    ------
    InputError
        If it is not a finite number above zero, or more than a day.
    """
    time = positive_number(field, value, "s", "time runs forward")
    if time > LONGEST_RUN:
        raise InputError(
            f"{field}: given {time:g} s; allowed is up to {LONGEST_RUN:g} s, a day, because a motion is "
            "followed turn by turn."
        )
    return time


def turns_followed(field: str, turns: float) -> float:
    """Return a number of revolutions of a motion, checked.

    Raises
    ------
    InputError
        If it is not a finite number above zero, or too large.
    """
    number = positive_number(field, turns, "", "the shaft turns forward")
    if number > MOST_TURNS:
        raise InputError(
            f"{field}: given {number:g}; allowed are up to {MOST_TURNS} turns, because each is followed by "
            "itself."
        )
    return number


def evaluation_counter(
    refusal: Callable[[float], InputError], most: int
) -> Callable[[float], None]:
    """Return what an integration calls at each evaluation, and what ends it after too many.

    Parameters
    ----------
    refusal : callable
        Returns the error for the time or angle at which the last evaluation is.
    most : int
        Evaluations that are allowed.
    """
    left = iter(range(most))

    def evaluated(reached: float) -> None:
        if next(left, None) is None:
            raise refusal(reached)

    return evaluated


def work_counter(field: str, given: float, unit: str, most: int) -> Callable[[float], None]:
    """Return an `evaluation_counter` whose error is that a motion is followed too far.

    Parameters
    ----------
    field : str
        How far it is followed; the counter is called with how far it has come.
    given : float
    unit : str
    most : int
    """

    def refusal(reached: float) -> InputError:
        allowed = f"{0.99 * reached:.4g} {unit}".strip()
        return InputError(
            f"{field}: given {f'{given:g} {unit}'.strip()}; allowed is {allowed} or less here, because a "
            "calculation has a limit of evaluations; another one can continue from there."
        )

    return evaluation_counter(refusal, most)


def too_many_turns(field: str, time: float, turns: float) -> InputError:
    """Return the error for a duration with too many revolutions of the shaft."""
    return InputError(
        f"{field}: given {time:g} s, in which the shaft turns {turns:g} times or more; allowed are "
        f"{MOST_TURNS} turns, because each is followed by itself."
    )
