"""Sentences on the use of limits and the speeds concerned."""

import numpy as np

from crankbase.units.quantity import format_quantity, quantities_apart
from dynamics.assessment.limits import VibrationLimit

# A limit that is used up to this share is told by what is above it.
SLIGHT = 1.5


def use_in_words(
    limit: VibrationLimit, speed: float, value: float, permitted: float, digits: int = 4
) -> str:
    """State the value of a quantity at a speed [rad/s] and the permitted value there."""
    at = format_quantity(speed, "rad/s", 4)
    reached, allowed = quantities_apart(value, permitted, limit.unit, digits)
    used = value / permitted
    if np.isinf(value):
        return f"unbounded at {at}, where {allowed} is permitted"
    if used <= 1.0:
        return f"at most {reached} at {at}, {100.0 * used:.3g} % of the permitted {allowed}"
    if used < SLIGHT:
        return f"{reached} at {at}, which exceeds the permitted {allowed} {shown_excess(used)}"
    return f"{reached} at {at}, {used:.3g} times the permitted {allowed}"


def limit_at(name: str, place: str) -> str:
    """Name a limit and where it is assessed; a limit for that location alone already has it in its name."""
    return name if name.endswith(f" of {place}") else f"{name}, {place}"


def shown_excess(used: float) -> str:
    """Write how far a limit is exceeded, such as "by 0.2 %" or "2.3 times", from its used share."""
    if np.isinf(used):
        return "without bounds"
    return f"by {100.0 * (used - 1.0):.2g} %" if used < SLIGHT else f"{used:.3g} times"


def shown_range(low: float, high: float) -> str:
    """Write a range of speeds [rad/s] in 1/min."""
    first = format_quantity(low, "rad/s", 4).removesuffix(" 1/min")
    return f"{first} to {format_quantity(high, 'rad/s', 4)}"
