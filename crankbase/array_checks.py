"""Checks of arrays of SI values, and of single values that may be arrays without a dimension."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.choices import so_many
from crankbase.errors import InputError, quoted

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Squares and quotients of numbers beyond these are none that a computer has.
LARGEST, SMALLEST = 1e60, 1e-60
# [rad/s] A speed above this is a slip: the rim of a shaft of half a meter would outrun light.
HIGHEST_SPEED = 1e9
_SPEED_UNIT = "rad/s"


def finite_array(field: str, values: ArrayLike) -> Array:
    """Return values as a new array of finite floats of any shape.

    Raises
    ------
    InputError
        If a value is not a real number, not finite, larger than 1e60, or the rows are of unequal length.
    """
    raw = regular_array(field, values, "iuf", "real numbers only")
    array = np.array(raw, dtype=np.float64)
    check_sizes(field, array)
    return array


def check_sizes(field: str, array: Array | ComplexArray, largest: float = LARGEST) -> None:
    """Refuse numbers that are not finite, or too large for calculations.

    Parameters
    ----------
    array : ndarray of any shape
    """
    with np.errstate(over="ignore"):  # of complex numbers
        allowed = np.abs(array) <= largest
    if allowed.all():
        return
    place = np.argwhere(~allowed)[0]
    index = "".join(f"[{number}]" for number in place)
    value = array[tuple(place)]
    why = (
        f"numbers of up to {largest:g}, because larger ones exceed what a computer can calculate"
        if np.isfinite(value)
        else "finite numbers, because a missing or infinite value would spread to every result"
    )
    raise InputError(f"{field}{index}: given {value}; allowed are {why}.")


def check_shape(field: str, values: ArrayLike, *allowed: tuple[int, ...]) -> None:
    """Refuse an array that has none of the allowed shapes."""
    if np.shape(values) not in allowed:
        shapes = " or ".join("one number" if shape == () else str(shape) for shape in allowed)
        raise InputError(
            f"{field}: given an array of shape {np.shape(values)}; allowed is {shapes}, because every value "
            "is used at its place."
        )


def turning_speeds(field: str, speeds: ArrayLike) -> Array:
    """Return speeds of a shaft that may turn either way [rad/s], as an array of any shape.

    Raises
    ------
    InputError
        As `finite_array`, and if a speed is higher than 1e9 rad/s.
    """
    array = finite_array(field, speeds)
    check_sizes(field, array, HIGHEST_SPEED)
    return array


def finite_vector(field: str, values: ArrayLike) -> Array:
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
            "because the values form one row."
        )
    return array


def positive_vector(field: str, values: ArrayLike, unit: str, reason: str) -> Array:
    """Return values as a one-dimensional array, all above zero.

    Raises
    ------
    InputError
        As `finite_vector`, and if a value is zero or negative.
    """
    return _bounded_vector(field, values, unit, reason, zero_allowed=False)


def nonnegative_vector(field: str, values: ArrayLike, unit: str, reason: str) -> Array:
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


def one_for_each(
    field: str,
    values: ArrayLike,
    count: int,
    of: str,
    unit: str,
    reason: str,
    *,
    zero_allowed: bool = True,
) -> Array:
    """Return one value for each of `count` items; a single number applies to all.

    Parameters
    ----------
    field, of, unit, reason : str
        Name and owner of the values in messages, their unit, and why none may be
        negative.
    values : float or array_like of shape (count,)

    Raises
    ------
    InputError
        As `nonnegative_vector` or `positive_vector`, and if the length does not fit.
    """
    numbers = finite_array(field, values)
    array = np.full(count, numbers) if numbers.ndim == 0 else numbers
    checked = _bounded_vector(field, array, unit, reason, zero_allowed=zero_allowed)
    if checked.size != count:
        raise InputError(
            f"{field}: given {so_many(checked.size)} for {count} {of}; allowed is one for each, or a "
            "single number for all, because each has its own."
        )
    return checked


def complex_array(field: str, values: ArrayLike) -> ComplexArray:
    """Return values as a new complex array of any shape, finite or not.

    Raises
    ------
    InputError
        If a value is not a number, or the rows are of unequal length.
    """
    raw = regular_array(field, values, "iufc", "real and complex numbers")
    return np.array(raw, dtype=np.complex128)


def regular_array(field: str, values: ArrayLike, kinds: str, allowed: str) -> NDArray[np.generic]:
    """Return values as an array of one of numpy's kinds of numbers.

    Raises
    ------
    InputError
        If a value is of another kind, or the rows are of unequal length.
    """
    if np.ma.is_masked(values):
        raise InputError(
            f"{field}: given masked values; allowed are all values, because masked ones would count."
        )
    try:
        raw = np.asarray(values)
    except ValueError:
        raise InputError(
            f"{field}: given rows of unequal length; allowed is one regular array of numbers, "
            "because every value is used at its place."
        ) from None
    if raw.dtype.kind not in kinds:
        shown = f"values of type {raw.dtype.name}" if raw.ndim else repr(values)
        raise InputError(
            f"{field}: given {shown}; allowed are {allowed}, "
            "because text and other types carry no value in SI units."
        )
    return raw


def checked_range(field: str, ends: object, unit: str, reason: str) -> tuple[float, float]:
    """Return two finite numbers of zero or more, the first the lower.

    Raises
    ------
    InputError
        If they are not.
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


def read_only(array: Array) -> Array:
    """Return the same array, read-only."""
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
) -> Array:
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
        shown = f"an array of shape {raw.shape}" if raw.ndim else quoted(value)
        raise InputError(f"{field}: given {shown}; {allowed}.")
    number = float(raw)
    if not math.isfinite(number) or number < 0.0 or (number == 0.0 and not zero_allowed):
        raise InputError(f"{field}: given {_with_unit(number, unit)}; {allowed}.")
    _check_magnitudes(field, np.array(number), unit, zero_allowed=zero_allowed)
    return number


def _check_magnitudes(field: str, array: Array, unit: str, *, zero_allowed: bool) -> None:
    """Refuse numbers so large or small that their squares and quotients overflow or underflow."""
    largest = HIGHEST_SPEED if unit == _SPEED_UNIT else LARGEST
    least = 0.0 if zero_allowed else SMALLEST
    refused = (array > largest) | (array < least)
    if not np.any(refused):
        return
    place = tuple(np.argwhere(refused)[0])
    index = "".join(f"[{number}]" for number in place)
    raise InputError(
        f"{field}{index}: given {_with_unit(array[place], unit)}; allowed are numbers of "
        f"{least:g} to {_with_unit(largest, unit)}, because others exceed what a computer can calculate."
    )


TURNS = (2.0 * np.pi, 4.0 * np.pi)
# Even angles from so many on are held for radians where they cover a turn or two of these, but for rounding.
FEWEST_EVEN, SAME = 8, 1e-6
# Cranks divide a turn into so many parts; how close radians with two decimals, of two cranks with three, lie
# to such parts [deg].
PARTS, ROUNDED, ROUNDED_PAIR = np.arange(2, 13), 0.3, 0.1


def checked_degrees(field: str, angles_deg: ArrayLike, *, vector: bool = False) -> Array:
    """Return angles given in degrees as an array, of the same shape.

    Parameters
    ----------
    field : str
        Name of the values in messages.
    vector : bool, optional
        Whether they must be of shape (m,).

    Raises
    ------
    InputError
        If one is not a finite number, or they are evenly spread over 2 pi or 4 pi: nobody uses so many
        even steps over 6.283 or 12.566 degrees.
    """
    angles = (finite_vector if vector else finite_array)(field, angles_deg)
    if angles.ndim == 1 and angles.size >= FEWEST_EVEN:
        step = (angles[-1] - angles[0]) / (angles.size - 1)
        even = np.allclose(np.diff(angles), step, rtol=0.0, atol=SAME * abs(step))
        lengths = abs(step) * np.array([[angles.size - 1], [angles.size]])
        if even and np.any(np.isclose(lengths, TURNS, rtol=SAME, atol=0.0)):
            raise _radians_error(field, angles)
    return angles


def refuse_many_turns(field: str, angles: Iterable[float]) -> None:
    """Refuse angles of more than two turns [rad], which are probably degrees: (0, 120, 240)."""
    largest = max(angles, key=abs, default=0.0)
    if abs(largest) > TURNS[-1] * (1.0 + SAME):
        raise InputError(
            f"{field}: given {math.degrees(largest):.6g} deg ({largest:.6g} rad), more than two turns; "
            "allowed is -720 deg to 720 deg, in Python -4 pi to 4 pi rad, because the angles of records are "
            "in rad there."
        )


def radians_of(field: str, angles_deg: ArrayLike, *, vector: bool = False) -> Array:
    """Return angles given in degrees as radians; as `checked_degrees`."""
    return np.radians(checked_degrees(field, angles_deg, vector=vector))


def refuse_crank_radians(field: str, angles_deg: ArrayLike, *, written: bool = False) -> None:
    """Refuse angles of cranks, or at which cylinders fire, that are radians: [0, 2.09, 4.19].

    `written` is whether they are quantities with units, of a file or the command line. Interpreted as radians
    they are all within two revolutions and simple fractions of one, one twelfth or more, but they are not
    round numbers of degrees.
    """
    angles = finite_array(field, angles_deg).ravel()
    if angles.size < 2 or np.max(np.abs(angles)) > TURNS[-1] or np.ptp(angles) < 1.0:
        return
    taken, steps = np.degrees(angles)[:, np.newaxis], 360.0 / PARTS
    off = np.min(np.max(np.abs(taken - steps * np.round(taken / steps)), axis=0))
    halves = np.abs(2.0 * angles - np.round(2.0 * angles)) < SAME
    if off <= (ROUNDED if angles.size > 2 else ROUNDED_PAIR) and not np.all(halves):
        raise _radians_error(field, angles, written=written)


def refuse_radians_between(field: str, angle_deg: float, low_deg: float, high_deg: float) -> None:
    """Refuse one angle in degrees that is within given bounds if interpreted as radians.

    For angles that are always more than a few degrees.
    """
    taken = float(np.degrees(angle_deg))
    if low_deg < taken < high_deg:
        raise InputError(
            f"{field}: given {angle_deg:.6g} deg, which would be {taken:.4g} deg if it were radians; allowed "
            "are degrees: write numpy.degrees(...) around it."
        )


def _radians_error(field: str, angles: Array, *, written: bool = False) -> InputError:
    low, high = (f"{end + 0.0:.4g}" for end in (np.min(angles), np.max(angles)))
    largest = angles[np.argmax(np.abs(angles))]
    cure, unit = ": write numpy.degrees(...) around them", ""
    if written:
        cure, unit = f', or the unit rad, like "{largest:.4g} rad"', " deg"
    return InputError(
        f"{field}: given {angles.size} angles from {low} to {high}{unit}, those of turns in radians; "
        f"allowed are degrees{cure}."
    )
