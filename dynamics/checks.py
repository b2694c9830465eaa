"""Checks of numbers and arrays that come from outside, each failing with one clear sentence."""

import math
import operator
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError, quoted

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

# Squares and quotients of numbers beyond these are none that a computer has.
LARGEST, SMALLEST = 1e60, 1e-60
# [rad/s] A speed above this is a slip: the rim of a shaft of half a meter would outrun light.
HIGHEST_SPEED = 1e9
_SPEED_UNIT = "rad/s"
# Speeds this near the end of a range, as a share, lie in it: 1.15 times a speed is rounded.
AT_END = 8.0 * float(np.finfo(np.float64).eps)
# No samples, steps, cycles or places are as many.
MOST_COUNTED = 10_000_000
# Longest time that is followed, a day [s], and the most turns of a shaft: each takes milliseconds.
LONGEST_RUN, MOST_TURNS = 86_400.0, 20_000


def finite_array(field: str, values: ArrayLike) -> FloatArray:
    """Return values as a new array of finite floats of any shape.

    Raises
    ------
    InputError
        If a value is not a real number, not finite, larger than 1e60, or the rows are of unequal length.
    """
    raw = _regular_array(field, values, "iuf", "real numbers only")
    array = np.array(raw, dtype=np.float64)
    check_sizes(field, array)
    return array


def check_sizes(field: str, array: FloatArray | ComplexArray, largest: float = LARGEST) -> None:
    """Refuse numbers that are not finite, or larger than can be calculated with.

    Parameters
    ----------
    field : str
    array : ndarray of any shape
    largest : float, optional

    Raises
    ------
    InputError
    """
    with np.errstate(over="ignore"):  # of complex numbers
        wrong = ~(np.abs(array) <= largest)
    if not np.any(wrong):
        return
    place = np.argwhere(wrong)[0]
    index = "".join(f"[{number}]" for number in place)
    value = array[tuple(place)]
    why = (
        f"numbers of up to {largest:g}, because larger ones leave what a computer can calculate"
        if np.isfinite(value)
        else "finite numbers, because a missing or infinite value would spread to every result"
    )
    raise InputError(f"{field}{index}: given {value}; allowed are {why}.")


def turning_speeds(field: str, speeds: ArrayLike) -> FloatArray:
    """Return speeds of a shaft that may turn either way [rad/s], as an array of any shape.

    Raises
    ------
    InputError
        As `finite_array`, and if a speed is higher than 1e9 rad/s.
    """
    array = finite_array(field, speeds)
    check_sizes(field, array, HIGHEST_SPEED)
    return array


def within(speeds: float | FloatArray, low: float, high: float) -> NDArray[np.bool_]:
    """Tell which speeds lie in a range; both ends do, a few units in the last place either way."""
    return np.asarray(at_most(low, speeds) & at_most(speeds, high))


def at_most(one: float | FloatArray, other: float | FloatArray) -> NDArray[np.bool_]:
    """Tell whether a speed is another or less, a few units in the last place aside."""
    return np.asarray(one <= other * (1.0 + AT_END))


def finite_vector(field: str, values: ArrayLike) -> FloatArray:
    """Return values as a new one-dimensional array of finite floats.

    Raises
    ------
    InputError
        As `finite_array`, and if the array has not exactly one dimension.
    """
    array = finite_array(field, values)
    if array.ndim != 1:
        raise InputError(
            f"{field}: given an array of {array.ndim} dimensions; allowed is one dimension, "
            "because the values stand in a row."
        )
    return array


def positive_vector(field: str, values: ArrayLike, unit: str, reason: str) -> FloatArray:
    """Return values as a one-dimensional array, all above zero.

    Raises
    ------
    InputError
        As `finite_vector`, and if a value is zero or negative.
    """
    return _bounded_vector(field, values, unit, reason, zero_allowed=False)


def nonnegative_vector(field: str, values: ArrayLike, unit: str, reason: str) -> FloatArray:
    """Return values as a one-dimensional array, none below zero.

    Raises
    ------
    InputError
        As `finite_vector`, and if a value is negative.
    """
    return _bounded_vector(field, values, unit, reason, zero_allowed=True)


def positive_number(field: str, value: float, unit: str, reason: str) -> float:
    """Return one finite float above zero.

    Raises
    ------
    InputError
        If the value is not a finite real number above zero.
    """
    return _bounded_number(field, value, unit, reason, zero_allowed=False)


def nonnegative_number(field: str, value: float, unit: str, reason: str) -> float:
    """Return one finite float that is zero or above.

    Raises
    ------
    InputError
        If the value is not a finite real number of zero or more.
    """
    return _bounded_number(field, value, unit, reason, zero_allowed=True)


def run_time(field: str, value: float) -> float:
    """Return a time that a motion is followed for [s].

    Raises
    ------
    InputError
        If it is no finite number above zero, or more than a day.
    """
    time = positive_number(field, value, "s", "time runs forward")
    if time > LONGEST_RUN:
        raise InputError(
            f"{field}: given {time:g} s; allowed is up to {LONGEST_RUN:g} s, a day, because a motion is "
            "followed turn by turn."
        )
    return time


def turns_followed(field: str, turns: float) -> float:
    """Return a number of turns that a motion is followed for.

    Raises
    ------
    InputError
        If it is no finite number above zero, or more than can be followed.
    """
    number = positive_number(field, turns, "", "the shaft turns forward")
    if number > MOST_TURNS:
        raise InputError(
            f"{field}: given {number:g}; allowed are up to {MOST_TURNS} turns, because each is followed by "
            "itself."
        )
    return number


def too_many_turns(field: str, time: float, turns: float) -> InputError:
    """Return the error for a time in which a shaft turns more often than can be followed."""
    return InputError(
        f"{field}: given {time:g} s, in which the shaft turns {turns:g} times or more; allowed are "
        f"{MOST_TURNS} turns, because each is followed by itself."
    )


def is_whole(value: object) -> bool:
    """Tell whether a value is a whole number by its type: neither True nor 2.0 names a cylinder."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def whole_number(field: str, given: int, least: int, reason: str) -> int:
    """Return a whole number.

    Raises
    ------
    InputError
        If it is no whole number, below `least`, or more than anything is counted to.
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


def one_for_each(
    field: str,
    values: ArrayLike,
    count: int,
    of: str,
    unit: str,
    reason: str,
    *,
    zero_allowed: bool = True,
) -> FloatArray:
    """Return one value for each of what there are `count`; a single number stands for all.

    Parameters
    ----------
    field, of, unit, reason : str
        What to call the values and what they belong to in messages, their unit, and why none may be
        negative.
    values : float or array_like of shape (count,)
    count : int
    zero_allowed : bool, optional

    Raises
    ------
    InputError
        As `nonnegative_vector` or `positive_vector`, and if the length does not fit.
    """
    given = finite_array(field, values)
    array = np.full(count, given) if given.ndim == 0 else given
    checked = _bounded_vector(field, array, unit, reason, zero_allowed=zero_allowed)
    if checked.size != count:
        raise InputError(
            f"{field}: given {checked.size} values for {count} {of}; allowed is one for each, or a "
            "single number for all, because each has its own."
        )
    return checked


def complex_array(field: str, values: ArrayLike) -> ComplexArray:
    """Return values as a new complex array of any shape, finite or not.

    Raises
    ------
    InputError
        If a value is no number, or the rows are of unequal length.
    """
    raw = _regular_array(field, values, "iufc", "real and complex numbers")
    return np.array(raw, dtype=np.complex128)


def _regular_array(field: str, values: ArrayLike, kinds: str, allowed: str) -> NDArray[np.generic]:
    """Return values as an array of one of numpy's kinds of numbers.

    Raises
    ------
    InputError
        If a value is of another kind, or the rows are of unequal length.
    """
    try:
        raw = np.asarray(values)
    except ValueError:
        raise InputError(
            f"{field}: given rows of unequal length; allowed is one regular array of numbers, "
            "because every value is used at its place."
        ) from None
    if raw.dtype.kind not in kinds:
        raise InputError(
            f"{field}: given values of type {raw.dtype.name}; allowed are {allowed}, "
            "because text and other types carry no value in SI units."
        )
    return raw


def checked_limits(
    limits: Mapping[str, ArrayLike] | None, speed_count: int
) -> dict[str, FloatArray]:
    """Return limits that are drawn over speeds, each with a value at every speed.

    Parameters
    ----------
    limits : mapping of str to float or array_like of shape (S,), or None
        In SI; inf where none is stated.
    speed_count : int
        S.

    Raises
    ------
    InputError
        If it is no mapping, or a limit is neither a number nor one for each speed, below zero or not
        a number.
    """
    if limits is None:
        return {}
    if not isinstance(limits, Mapping):
        raise InputError(
            f"limits: given {quoted(limits)}; allowed is a mapping of names to limits, because each is drawn "
            "with its name."
        )
    found = {}
    for name, values in limits.items():
        field = f"limits[{name!r}]"
        array = np.array(_regular_array(field, values, "iuf", "real numbers only"), dtype=float)
        if array.shape not in ((), (speed_count,)):
            raise InputError(
                f"{field}: given an array of shape {array.shape}; allowed is one number, or "
                f"{speed_count}, because a limit is constant or has a value at each speed."
            )
        if not np.all(array >= 0.0):
            worst = float(array[~(array >= 0.0)].flat[0])
            raise InputError(
                f"{field}: given {worst:g}; allowed are numbers of zero or more, inf where no limit is "
                "stated, because amplitudes are compared with it."
            )
        found[str(name)] = np.array(np.broadcast_to(array, (speed_count,)))
    return found


def checked_barred(barred: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return barred ranges of speed [rad/s].

    Raises
    ------
    InputError
        If one is no pair of finite numbers of zero or more, the lower first.
    """
    if isinstance(barred, str) or not isinstance(barred, Sequence | np.ndarray):
        raise InputError(
            f"barred: given {quoted(barred)}; allowed are pairs of speeds in rad/s, because each "
            "range is shaded."
        )
    reason = "a range from one to the other is shaded"
    return [
        checked_range(f"barred[{place}]", ends, "rad/s", reason)
        for place, ends in enumerate(barred)
    ]


def checked_range(field: str, ends: object, unit: str, reason: str) -> tuple[float, float]:
    """Return two finite numbers of zero or more, the first the lower.

    Raises
    ------
    InputError
        If they are not such.
    """
    try:
        raw = np.asarray(ends)
    except ValueError:  # rows of unequal length
        raw = np.array(None)
    if raw.shape == (2,) and raw.dtype.kind in "iuf" and 0.0 <= raw[0] < raw[1] < math.inf:
        return float(raw[0]), float(raw[1])
    raise InputError(
        f"{field}: given {quoted(ends)}; allowed are two finite numbers in {unit}, the lower first, because "
        f"{reason}."
    )


def read_only(array: FloatArray) -> FloatArray:
    """Return the same array, closed to writing."""
    array.setflags(write=False)
    return array


def _with_unit(value: float, unit: str) -> str:
    return f"{value:g} {unit}".rstrip()


def _allowed(unit: str, reason: str, *, zero_allowed: bool) -> str:
    least = "zero or more" if zero_allowed else "more than zero"
    where = f" in {unit}" if unit else ""
    return f"allowed are finite numbers of {least}{where}, because {reason}"


def _bounded_vector(
    field: str, values: ArrayLike, unit: str, reason: str, *, zero_allowed: bool
) -> FloatArray:
    array = finite_vector(field, values)
    refused = np.flatnonzero(array < 0.0 if zero_allowed else array <= 0.0)
    if refused.size:
        first = int(refused[0])
        raise InputError(
            f"{field}[{first}]: given {_with_unit(array[first], unit)}; "
            f"{_allowed(unit, reason, zero_allowed=zero_allowed)}."
        )
    _check_magnitudes(field, array, unit, zero_allowed=zero_allowed)
    return array


def _bounded_number(
    field: str, value: float, unit: str, reason: str, *, zero_allowed: bool
) -> float:
    allowed = _allowed(unit, reason, zero_allowed=zero_allowed)
    raw = np.asarray(value)
    if raw.ndim != 0 or raw.dtype.kind not in "iuf":
        given = f"an array of shape {raw.shape}" if raw.ndim else quoted(value)
        raise InputError(f"{field}: given {given}; {allowed}.")
    number = float(raw)
    if not math.isfinite(number) or number < 0.0 or (number == 0.0 and not zero_allowed):
        raise InputError(f"{field}: given {_with_unit(number, unit)}; {allowed}.")
    _check_magnitudes(field, np.array(number), unit, zero_allowed=zero_allowed)
    return number


def _check_magnitudes(field: str, array: FloatArray, unit: str, *, zero_allowed: bool) -> None:
    """Refuse numbers so large or small that their squares and quotients are none that a computer has."""
    largest = HIGHEST_SPEED if unit == _SPEED_UNIT else LARGEST
    least = 0.0 if zero_allowed else SMALLEST
    refused = (array > largest) | (array < least)
    if not np.any(refused):
        return
    place = tuple(np.argwhere(refused)[0])
    index = "".join(f"[{number}]" for number in place)
    raise InputError(
        f"{field}{index}: given {_with_unit(array[place], unit)}; allowed are numbers of "
        f"{least:g} to {_with_unit(largest, unit)}, because others leave what a computer can calculate."
    )
