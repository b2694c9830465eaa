"""When the cylinders of a torque table fire: --firing-order or --firing-angles."""

import math

from crankbase.errors import InputError
from crankfem.cli.quantity_list import parse_quantities
from dynamics.cycle import cycle_degrees
from dynamics.engine.firing import MOST_CYLINDERS, firing_order_from_text


def firing_angles_deg(order: str | None, angles: str | None, *, strokes: int) -> list[float]:
    """Return the shaft angle at which each cylinder fires [deg]; none without options.

    Parameters
    ----------
    order : str or None
        Numbers of the cylinders as they fire, at even steps over the cycle.
    angles : str or None
        With a unit each, or one at the end for all.
    strokes : int
        Per cycle, 2 or 4.

    Raises
    ------
    InputError
        If both are given, or one cannot be read.

    Examples
    --------
    >>> firing_angles_deg("1-3-4-2", None, strokes=4)
    [0.0, 540.0, 180.0, 360.0]
    >>> firing_angles_deg(None, "0, 90 deg", strokes=2)
    [0.0, 90.0]
    """
    if order is not None and angles is not None:
        raise InputError(
            f"--firing-order: given {order!r} with --firing-angles; allowed is one of them, because each "
            "defines when the cylinders fire."
        )
    if angles is not None:
        return _angles(angles)
    return [] if order is None else _even_angles(order, cycle_degrees(strokes))


def _even_angles(order: str, cycle: float) -> list[float]:
    try:
        numbers = firing_order_from_text(order)
    except InputError as error:
        raise InputError(f"--firing-order:{str(error).removeprefix('firing_order:')}") from None
    count = len(numbers)
    if count > MOST_CYLINDERS or sorted(numbers) != list(range(1, count + 1)):
        raise InputError(
            f"--firing-order: given {order!r}; allowed is each number from 1 to that of the last cylinder, "
            f'at most {MOST_CYLINDERS}, once, like "1-3-4-2", because each cylinder fires once in a cycle.'
        )
    return [cycle * numbers.index(number) / count for number in range(1, count + 1)]


def _angles(text: str) -> list[float]:
    # Rounding takes away what the way over radians adds.
    angles = [
        round(math.degrees(angle), 9) for angle in parse_quantities(text, "rad", "--firing-angles")
    ]
    if len(angles) > MOST_CYLINDERS:
        raise InputError(
            f"--firing-angles: given {len(angles)} angles; allowed are at most {MOST_CYLINDERS}, one for "
            "each cylinder."
        )
    return angles
