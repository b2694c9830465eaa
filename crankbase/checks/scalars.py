"""Definition of numbers and whole numbers: True and False are neither."""

import math
import operator
from numbers import Integral, Real
from typing import TypeGuard

from crankbase.errors import InputError, quoted

# No samples, steps, cycles or places are as many.
MOST_COUNTED = 10_000_000


def is_number(value: object) -> TypeGuard[float]:
    """Whether this is one finite real number; True and False are not.

    Examples
    --------
    >>> is_number(1), is_number(0.5), is_number("1"), is_number(True), is_number(math.nan)
    (True, True, False, False, False)
    """
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number larger than any float
        return False


def is_whole(value: object) -> TypeGuard[int]:
    """Whether this is a whole number by its type: True and 2.0 are not."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def is_whole_within(value: object, low: int, high: int) -> TypeGuard[int]:
    """Whether this is a whole number from `low` to `high`."""
    return is_whole(value) and low <= value <= high


def whole_within(field: str, given: object, low: int, high: int, reason: str) -> int:
    """Return a whole number from `low` to `high`.

    Raises
    ------
    InputError
        If it is not.
    """
    if not is_whole_within(given, low, high):
        allowed = f"is {low}" if low == high else f"are the whole numbers {low} to {high}"
        raise InputError(f"{field}: given {quoted(given)}; allowed {allowed}, because {reason}.")
    return int(given)


def whole_number(field: str, given: int, least: int, reason: str) -> int:
    """Return a whole number.

    Raises
    ------
    InputError
        If it is not a whole number, below `least`, or unrealistically large.
    """
    try:
        number = None if isinstance(given, bool) else operator.index(given)
    except TypeError:
        number = None
    if number is None or number < least:
        raise InputError(
            f"{field}: given {quoted(given)}; allowed are whole numbers of {least} or more, because {reason}."
        )
    if number > MOST_COUNTED:
        raise InputError(
            f"{field}: given {quoted(given)}; allowed is up to {MOST_COUNTED}, because more can be neither "
            "calculated nor kept."
        )
    return number
