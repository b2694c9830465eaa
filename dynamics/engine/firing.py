"""When each cylinder of an engine fires."""

import math
from collections.abc import Sequence

from dynamics.checks import finite_vector
from dynamics.cycle import cycle_degrees
from geometry.errors import InputError

# Crank and cylinder axis count as in line within this angle [rad]; files give degrees.
IN_LINE = 1e-6


def check_firing_order(firing_order: Sequence[int], cylinders: int) -> None:
    """Refuse an order that repeats or omits a cylinder.

    Raises
    ------
    InputError
    """
    wanted = range(1, cylinders + 1)
    given = list(firing_order)
    if sorted(given) == list(wanted):
        return
    reason = "each cylinder fires once a cycle"
    for number in given:
        if number not in wanted:
            reason = f"the engine has no cylinder {number}"
        elif given.count(number) > 1:
            reason = f"it repeats cylinder {number}"
        else:
            continue
        break
    else:
        missing = next(number for number in wanted if number not in given)
        reason = f"it omits cylinder {missing}"
    raise InputError(
        f"firing_order: given {given}; allowed is each cylinder number from 1 to {cylinders} once, "
        f"because {reason}."
    )


def firing_angles_of_order(
    firing_order: Sequence[int], top_angles: Sequence[float], strokes: int
) -> tuple[float, ...]:
    """Return the shaft angle at which each cylinder fires, even intervals or not.

    Parameters
    ----------
    firing_order : sequence of n int
        Cylinder numbers from 1.
    top_angles : sequence of n float
        A shaft angle at which each cylinder's crank lies along its axis, away from the shaft [rad].
    strokes : int
        Strokes per cycle, 2 or 4.

    Returns
    -------
    tuple of n float
        Firing angles by cylinder [rad], from that of the first to fire, which lies in one turn from
        zero, to less than one cycle more. Each cylinder fires at the first of its tops after the
        one before it has fired.

    Raises
    ------
    InputError
        If the order repeats or omits a cylinder, or its tops do not come within one cycle in that
        order.
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


def _after(angle: float, least: float, turn: float) -> float:
    """Return the first of angle + k turns that is above `least`."""
    return angle + turn * (math.floor((least - angle) / turn) + 1)


def firing_order_of_angles(firing_angles: Sequence[float]) -> tuple[int, ...]:
    """Return the cylinder numbers in the order in which they fire, lower numbers first at a tie."""
    return tuple(sorted(range(1, len(firing_angles) + 1), key=lambda n: firing_angles[n - 1]))
