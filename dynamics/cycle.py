"""The working cycle: its length in crank angle, its order step, and even angles over it."""

import math

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError

# A sample may lie off its even place by this share of the step: room for angles printed rounded.
PLACE_TOLERANCE = 0.02
# An order that was calculated is a multiple of the step within this share of it.
ON_STEP = 1e-9


def checked_strokes(strokes: int) -> int:
    """Return the number of strokes per cycle, 2 or 4."""
    if strokes not in (2, 4):
        raise InputError(
            f"strokes: given {strokes!r}; allowed are 2 and 4, because the cycle takes one or two "
            "crankshaft revolutions."
        )
    return int(strokes)


def cycle_degrees(strokes: int) -> float:
    """Return the length of one cycle in degrees of crank angle: 720 or 360."""
    return 180.0 * checked_strokes(strokes)


def cycle_radians(strokes: int) -> float:
    """Return the length of one cycle in radians of crank angle: 4 pi or 2 pi."""
    return math.pi * checked_strokes(strokes)


def order_step(strokes: int) -> float:
    """Return the lowest harmonic order, in cycles per crankshaft revolution: 0.5 or 1."""
    return 2.0 / checked_strokes(strokes)


def order_numbers(orders: Array, strokes: int) -> Array:
    """Return how many steps of the cycle's orders each order is (K,); others are refused."""
    step = order_step(strokes)
    numbers = np.round(orders / step)
    between = np.flatnonzero(np.abs(orders / step - numbers) > ON_STEP * numbers)
    if between.size:
        first = int(between[0])
        raise InputError(
            f"orders[{first}]: given {orders[first]:g}; allowed are multiples of {step:g}, because "
            f"a cycle of {strokes} strokes has no others."
        )
    return np.asarray(numbers)


def even_angles(length: float, count: int) -> Array:
    """Return `count` even angles over a length from zero, the closing one left out (count,)."""
    return np.asarray(length / count * np.arange(count), dtype=np.float64)


def mean_step(angles_deg: Array) -> float:
    """Return the mean distance between neighbors of n >= 2 increasing angles, shape (n,)."""
    return float((angles_deg[-1] - angles_deg[0]) / (angles_deg.size - 1))


def first_not_increasing(angles_deg: Array) -> int | None:
    """Return the index of the first angle that is not above the one before it, or None."""
    falling = np.flatnonzero(np.diff(angles_deg) <= 0.0)
    return int(falling[0]) + 1 if falling.size else None


def first_uneven(angles_deg: Array) -> int | None:
    """Return the index of the angle after the most unusual gap, or None for even angles."""
    step = mean_step(angles_deg)
    even = angles_deg[0] + step * np.arange(angles_deg.size)
    if np.all(np.abs(angles_deg - even) <= PLACE_TOLERANCE * step):
        return None
    gaps = np.diff(angles_deg)
    return int(np.argmax(np.abs(gaps - np.median(gaps)))) + 1


def has_closing_sample(angles_deg: Array, cycle_deg: float) -> bool:
    """Return whether the last of the evenly spaced angles is one cycle after the first."""
    span = float(angles_deg[-1] - angles_deg[0])
    return abs(span - cycle_deg) <= 2 * PLACE_TOLERANCE * mean_step(angles_deg)


def covers_cycle(angles_deg: Array, cycle_deg: float) -> bool:
    """Return whether the next evenly spaced angle would be the first one of the next cycle."""
    step = mean_step(angles_deg)
    span = float(angles_deg[-1] - angles_deg[0])
    return abs(span + step - cycle_deg) <= 2 * PLACE_TOLERANCE * step


def is_even_cycle(angles_deg: Array, cycle_deg: float) -> bool:
    """Return whether increasing angles are even over one cycle, the closing one left out."""
    return first_uneven(angles_deg) is None and covers_cycle(angles_deg, cycle_deg)


def check_even_cycle(field: str, angles_deg: Array, cycle_deg: float) -> None:
    """Refuse angles that are not even over one cycle, the closing one left out.

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Two angles or more [deg], starting anywhere.
    cycle_deg : float
        Length of the cycle [deg].
    """
    shown = f"given {angles_deg.size} angles from {angles_deg[0]:g} to {angles_deg[-1]:g} deg"
    falling, uneven = first_not_increasing(angles_deg), first_uneven(angles_deg)
    index = uneven if falling is None else falling
    if index is not None:
        wanted = (
            f"even steps (here {np.median(np.diff(angles_deg)):g} deg), because all samples count alike"
            if falling is None
            else "strictly increasing angles, because the samples follow the crank"
        )
        raise InputError(
            f"{field}[{index}]: given {angles_deg[index]:g} deg after {angles_deg[index - 1]:g} deg; "
            f"allowed are {wanted}."
        )
    if has_closing_sample(angles_deg, cycle_deg):
        raise InputError(
            f"{field}: {shown}, which includes the closing sample; leave it out, because it repeats the "
            f"first sample one cycle of {cycle_deg:g} deg later."
        )
    if not covers_cycle(angles_deg, cycle_deg):
        raise InputError(
            f"{field}: {shown}, which cover {angles_deg.size * mean_step(angles_deg):g} deg with their "
            f"step; allowed is one cycle of {cycle_deg:g} deg, because the samples repeat with it."
        )
