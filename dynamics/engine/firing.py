"""Firing angles of the cylinders of an engine."""

import math
import re
from collections.abc import Sequence

import numpy as np

from crankbase.array_checks import FloatArray, finite_vector
from crankbase.choices import is_whole
from crankbase.errors import InputError
from dynamics.cycle import cycle_degrees

# Crank and cylinder axis count as in line within this angle [rad]; files give degrees.
IN_LINE = 1e-6
# Firings count as even, or as one, within this angle [rad], the digits of given angles.
EVEN = math.radians(0.5)
# Cylinders of a four-stroke engine of which all orders are tried: two tops in a cycle for each.
MOST_TRIED = 16
# No engine has more.
MOST_CYLINDERS = 48


def check_firing_order(firing_order: Sequence[int], cylinders: int) -> None:
    """Refuse an order that repeats or omits a cylinder."""
    order = list(firing_order)
    fault = _order_fault(order, cylinders)
    if fault is not None:
        raise InputError(
            f"firing_order: given {order}; allowed is each cylinder number from 1 to {cylinders} "
            f"once, because {fault}."
        )


def _order_fault(order: list[int], cylinders: int) -> str | None:
    """Return what is wrong with an order, or None."""
    for number in order:
        if not is_whole(number):
            return "cylinders have whole numbers"
        if not 1 <= number <= cylinders:
            return f"the engine has no cylinder {number}"
        if order.count(number) > 1:
            return f"it repeats cylinder {number}"
    missing = [number for number in range(1, cylinders + 1) if number not in order]
    return f"it omits cylinder {missing[0]}" if missing else None


def firing_order_from_text(text: str) -> tuple[int, ...]:
    """Return the cylinders of a firing order written in the usual way.

    Examples
    --------
    >>> firing_order_from_text("1-5-3-6-2-4")
    (1, 5, 3, 6, 2, 4)
    """
    parts = re.split(r"\s*[-,]\s*|\s+", text.strip())
    if not all(re.fullmatch("[0-9]{1,3}", part) for part in parts):
        raise InputError(
            f"firing_order: given {text!r}; allowed are cylinder numbers with dashes between them, like "
            '"1-5-3-6-2-4", or a list of them.'
        )
    return tuple(int(part) for part in parts)


def firing_angles_of_order(
    firing_order: Sequence[int], top_angles: Sequence[float], strokes: int
) -> tuple[float, ...]:
    """Return the shaft angle at which each cylinder fires, for even or uneven intervals.

    Parameters
    ----------
    top_angles : sequence of n float
        A shaft angle at which each cylinder's crank is along its axis, away from the shaft [rad].

    Returns
    -------
    tuple of n float
        Firing angles by cylinder [rad], from that of the first to fire, which is within the first
        revolution, to less than one cycle more. Each cylinder fires at the first of its tops after the
        preceding cylinder has fired.
    """
    tops = finite_vector("top_angles", list(top_angles)).tolist()
    check_firing_order(firing_order, len(tops))
    turn, cycle = 2.0 * math.pi, math.radians(cycle_degrees(strokes))
    angles = [0.0] * len(tops)
    first = _after(tops[firing_order[0] - 1], -IN_LINE, turn)
    last = first - IN_LINE
    for place, number in enumerate(firing_order):
        # After the first, the same angle means one turn later.
        last = _after(tops[number - 1], last if place == 0 else last + IN_LINE, turn)
        angles[number - 1] = last
        if last - first > cycle - IN_LINE:
            degrees = [round(math.degrees(angle % turn), 3) for angle in tops]
            raise InputError(
                f"firing_order: given {list(firing_order)}; allowed is an order whose cylinders reach "
                f"their tops (at {degrees} deg of the shaft, cylinder by cylinder) within one cycle of "
                f"{math.degrees(cycle):g} deg, because each fires at its top."
            )
    return tuple(angles)


def firing_intervals(firing_angles: Sequence[float], strokes: int) -> tuple[float, ...]:
    """Return the shaft angles from each firing to the next, over one cycle.

    Parameters
    ----------
    firing_angles : sequence of n float
        In any order, all within one cycle [rad].

    Returns
    -------
    tuple of n float
        [rad]; their sum is one cycle.

    Examples
    --------
    >>> [round(math.degrees(step)) for step in firing_intervals([0.0, math.pi], 4)]
    [180, 540]
    """
    angles = sorted(firing_angles)
    cycle = math.radians(cycle_degrees(strokes))
    following = [*angles[1:], angles[0] + cycle]
    return tuple(after - before for before, after in zip(angles, following, strict=True))


def repeating_intervals(intervals_deg: Sequence[float]) -> tuple[float, ...]:
    """Return the intervals that repeat through a cycle, once.

    Parameters
    ----------
    intervals_deg : sequence of float
        Between all firings of a cycle [deg].

    Examples
    --------
    >>> repeating_intervals([90.0, 30.0, 90.0, 30.0])
    (90.0, 30.0)
    """
    steps = tuple(intervals_deg)
    sizes = (size for size in range(1, len(steps) + 1) if not len(steps) % size)
    period = next(
        size
        for size in sizes
        if all(
            math.isclose(interval, steps[k % size], abs_tol=0.01)
            for k, interval in enumerate(steps)
        )
    )
    return steps[:period]


def even_firing_order(firing_angles: Sequence[float], strokes: int) -> tuple[int, ...] | None:
    """Return a firing order with even intervals for the same cranks.

    In a four-stroke engine each cylinder may fire at its top or one turn later.

    Parameters
    ----------
    firing_angles : sequence of n float
        Shaft angle at which each cylinder fires now [rad].

    Returns
    -------
    tuple of int or None
        Cylinder numbers, beginning with the one that fires first now, the lowest number of several; None
        if no order is even.

    Examples
    --------
    >>> even_firing_order([0.0, 2.0 * math.pi, math.pi, 3.0 * math.pi], 4)
    (1, 3, 2, 4)
    """
    count, first = len(firing_angles), min(firing_angles)
    step = math.radians(cycle_degrees(strokes)) / count
    slots: dict[int, int] = {}
    for number in sorted(range(1, count + 1), key=lambda cylinder: firing_angles[cylinder - 1]):
        for turn in range(strokes // 2):
            place = (firing_angles[number - 1] - first + turn * 2.0 * math.pi) / step
            slot = round(place)
            if abs(place - slot) * step < EVEN and slot % count not in slots:
                slots[slot % count] = number
                break
        else:
            return None
    return tuple(slots[place] for place in range(count))


def least_uneven_order(
    firing_angles: Sequence[float], strokes: int
) -> tuple[tuple[int, ...], tuple[float, ...]] | None:
    """Return the firing order whose intervals differ least for the same cranks, and its intervals.

    Returns
    -------
    order : tuple of int
        Cylinder numbers, beginning with the one that fires first now. Of orders with the same difference
        between longest and shortest interval that which repeats most often in a cycle, then the most even.
    intervals : tuple of float
        [rad].
    None
        If no order fires each cylinder at the first of its tops after the preceding one, or the cylinders
        of a four-stroke engine are too many to try all (`MOST_TRIED`).

    Examples
    --------
    >>> order, steps = least_uneven_order([0.0, math.pi / 2, math.pi, 3 * math.pi / 2], 4)
    >>> order, [round(math.degrees(step)) for step in steps]
    ((1, 2, 4, 3), [90, 180, 270, 180])
    """
    count, cycle = len(firing_angles), math.radians(cycle_degrees(strokes))
    if strokes == 4 and count > MOST_TRIED:
        return None
    first = int(np.argmin(firing_angles))
    now = np.asarray(firing_angles) - firing_angles[first]
    free = [place for place in range(count) if place != first] if strokes == 4 else []
    later = np.zeros((2 ** len(free), count))
    later[:, free] = np.arange(len(later))[:, np.newaxis] >> np.arange(len(free)) & 1
    angles = (now + 2.0 * math.pi * later) % cycle
    angles[cycle - angles < IN_LINE] = 0.0
    ordered = np.sort(angles, axis=1)
    steps = np.diff(ordered, axis=1, append=ordered[:, :1] + cycle)
    spread = np.where(
        np.max(steps, axis=1) <= 2.0 * math.pi + IN_LINE, np.ptp(steps, axis=1), np.inf
    )
    if not np.isfinite(np.min(spread)):
        return None
    even = np.flatnonzero(spread <= np.min(spread) + EVEN)

    def rank(row: int) -> tuple[int, float, tuple[int, ...]]:
        repeated = repeating_intervals(
            [round(math.degrees(interval), 1) for interval in steps[row]]
        )
        return len(repeated), round(float(np.sum(steps[row] ** 2)), 6), _order_of(angles[row])

    best = min(even.tolist(), key=rank)
    return _order_of(angles[best]), tuple(steps[best].tolist())


def _order_of(angles: FloatArray) -> tuple[int, ...]:
    return tuple((1 + np.argsort(np.round(angles, 9), kind="stable")).tolist())


def _after(angle: float, least: float, turn: float) -> float:
    """Return the first of angle + k turns that is above `least`."""
    return angle + turn * (math.floor((least - angle) / turn) + 1)


def check_order_of_angles(
    firing_order: Sequence[int], firing_angles: Sequence[float], strokes: int
) -> None:
    """Refuse a firing order that contradicts the firing angles.

    Cylinders that fire together may be in either order, and the order may begin with any
    cylinder, because the cycle repeats.

    Parameters
    ----------
    firing_angles : sequence of n float
        Shaft angle at which each cylinder fires, in any cycle [rad].
    """
    cycle = math.radians(cycle_degrees(strokes))
    angles = [firing_angles[number - 1] for number in firing_order]
    following = angles[1:] + angles[:1]
    once_round = sum(_angle_after(*ends, cycle) for ends in zip(angles, following, strict=True))
    # From each to the next and back to the first takes one cycle; none if all fire together.
    if once_round > 1.5 * cycle:
        allowed = list(firing_order_of_angles(firing_angles, strokes, firing_order[0]))
        raise InputError(
            f"firing_order: given {list(firing_order)}; allowed is {allowed}, because the firing "
            f"angles follow each other so in a cycle of {math.degrees(cycle):g} deg."
        )


def firing_order_of_angles(
    firing_angles: Sequence[float], strokes: int, first: int
) -> tuple[int, ...]:
    """Return the cylinder numbers in the order in which they fire."""
    cycle, start = math.radians(cycle_degrees(strokes)), firing_angles[first - 1]
    later = [round(_angle_after(start, angle, cycle), 9) for angle in firing_angles]
    others = (number for number in range(1, len(firing_angles) + 1) if number != first)
    return (first, *sorted(others, key=lambda number: (later[number - 1], number)))


def _angle_after(earlier: float, later: float, cycle: float) -> float:
    """Return how much later in the cycle the other angle is; zero within round-off if together."""
    apart = (later - earlier) % cycle
    return apart - cycle if cycle - apart < IN_LINE else apart
