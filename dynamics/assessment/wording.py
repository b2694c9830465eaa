"""Sentences of limits, verdicts and findings, made from their fields."""

import numpy as np

from crankbase.units.number_formats import format_usage
from crankbase.units.quantity import format_quantity, quantities_apart
from dynamics.assessment.limits import VibrationLimit


def use_in_words(
    limit: VibrationLimit, speed: float, value: float, permitted: float, digits: int = 4
) -> str:
    """State the value of a quantity at a speed [rad/s] and the permitted value there."""
    at = format_quantity(speed, "rad/s", 4)
    reached, allowed = quantities_apart(value, permitted, limit.unit, digits)
    used = value / permitted
    if np.isinf(value):
        return f"unbounded at {at}, where {allowed} is permitted"
    most = "at most " if used <= 1.0 else ""
    return f"{most}{reached} at {at}, {format_usage(used)} of the permitted {allowed}"


def limit_at(name: str, place: str) -> str:
    """Name a limit and where it is assessed; a limit for that location alone already has it in its name."""
    return name if name.endswith(f" of {place}") else f"{name}, {place}"


def shown_range(low: float, high: float) -> str:
    """Write a range of speeds [rad/s] in 1/min."""
    first = format_quantity(low, "rad/s", 4).removesuffix(" 1/min")
    return f"{first} to {format_quantity(high, 'rad/s', 4)}"
