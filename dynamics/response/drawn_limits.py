"""Checks of limits and barred ranges drawn over speeds."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, checked_range, regular_array
from crankbase.errors import InputError, quoted


def checked_limits(
    limits: Mapping[str, ArrayLike] | None, speed_count: int
) -> dict[str, FloatArray]:
    """Return limits for a diagram over speeds, each with a value at every speed.

    Parameters
    ----------
    limits : mapping of str to float or array_like of shape (S,), or None
        In SI; inf where none is stated.
    speed_count : int
        S.

    Raises
    ------
    InputError
        If it is not a mapping, or a limit is neither a number nor one for each speed, below zero or not
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
        array = np.array(regular_array(field, values, "iuf", "real numbers only"), dtype=float)
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
        If one is not a pair of finite numbers of zero or more, the lower first.
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
