"""Checks of words, names and single numbers, and suggestions for wrong ones."""

import math
import operator
from collections.abc import Iterable, Sized
from difflib import get_close_matches
from numbers import Integral, Real
from types import UnionType
from typing import TypeGuard

from crankbase.errors import InputError, quoted


def check_choice(option: str, word: object, allowed: Iterable[str], because: str) -> None:
    """Refuse a word that is not allowed.

    Raises
    ------
    InputError
        If it is not a word, or not one of these.
    """
    words = list(allowed)
    if not isinstance(word, str) or word not in words:
        raise InputError(
            f"{option}: given {quoted(word)}; allowed are {', '.join(words)}, because {because}."
        )


def check_kind(field: str, value: object, kind: type | UnionType, allowed: str) -> None:
    """Refuse an object of another kind; `allowed` names what it must be."""
    if not isinstance(value, kind):
        raise InputError(f"{field}: given {quoted(value)}; allowed is {allowed}.")


def check_some(field: str, items: Sized, because: str) -> None:
    """Refuse a row of nothing."""
    if len(items) == 0:
        raise InputError(f"{field}: given none; allowed are one or more, because {because}.")


def so_many(count: int) -> str:
    """Return "1 value", "2 values" and so on."""
    return f"{count} value{'' if count == 1 else 's'}"


def check_one_each(field: str, count: int, wanted: int, of: str) -> None:
    """Refuse another number of values than one for each of something."""
    if count != wanted:
        raise InputError(
            f"{field}: given {so_many(count)} for {wanted} {of}; allowed is one for each, because each has "
            "its own."
        )


def check_not_given(option: str, setting: object, shown: str, because: str) -> None:
    """Refuse an option that does not apply to the chosen plot.

    Raises
    ------
    InputError
        If it is given, that is, neither None nor empty.
    """
    if setting is not None and (not isinstance(setting, tuple | list | dict | set) or setting):
        raise InputError(
            f"{option}: given {quoted(setting)} with {shown!r}; allowed is none, because {because}."
        )


def did_you_mean(word: str, names: Iterable[str], cutoff: float = 0.6, form: str = "{}") -> str:
    """Return "did you mean NAME? " of the closest name; nothing if none is close, or several share the word.

    Parameters
    ----------
    cutoff : float
        Required similarity, 0 to 1.
    form : str
        Format of a name, such as ``"[{}]"``.

    Examples
    --------
    >>> did_you_mean("lenght", ["length", "mass"])
    'did you mean length? '
    >>> did_you_mean("pressure", ["peak_pressure", "intake_pressure"])
    ''
    """
    known = list(names)
    if sum(word in name.split("_") for name in known) > 1:
        return ""
    close = get_close_matches(word, known, n=1, cutoff=cutoff)
    return f"did you mean {form.format(close[0])}? " if close else ""


def allowed_names(word: str, names: Iterable[str]) -> str:
    """Return the allowed names for an unknown one, the most similar first."""
    known = list(names)
    return f"{did_you_mean(word, known)}allowed are {', '.join(known)}"


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


def whole_within(field: str, number: object, low: int, high: int, reason: str) -> int:
    """Return a whole number from `low` to `high`.

    Raises
    ------
    InputError
        If it is not.
    """
    if not is_whole_within(number, low, high):
        allowed = f"is {low}" if low == high else f"are the whole numbers {low} to {high}"
        raise InputError(f"{field}: given {quoted(number)}; allowed {allowed}, because {reason}.")
    return int(number)


def number_within(
    field: str, number: object, low: float, high: float, unit: str, reason: str
) -> float:
    """Return a finite number from `low` to `high`.

    Raises
    ------
    InputError
        If it is not.
    """
    if not is_number(number) or not low <= number <= high:
        shown = f"{number:g} {unit}".rstrip() if is_number(number) else quoted(number)
        allowed = f"{low:g} to {high:g} {unit}".rstrip()
        raise InputError(f"{field}: given {shown}; allowed is {allowed}, because {reason}.")
    return float(number)


def whole_number(field: str, count: int, least: int, reason: str) -> int:
    """Return a whole number.

    Raises
    ------
    InputError
        If it is not a whole number, below `least`, or unrealistically large.
    """
    try:
        number = None if isinstance(count, bool) else operator.index(count)
    except TypeError:
        number = None
    if number is None or number < least:
        raise InputError(
            f"{field}: given {quoted(count)}; allowed are whole numbers of {least} or more, because {reason}."
        )
    if number > MOST_COUNTED:
        raise InputError(
            f"{field}: given {quoted(count)}; allowed is up to {MOST_COUNTED}, because more can be neither "
            "calculated nor kept."
        )
    return number
