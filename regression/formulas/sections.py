"""Round sections with a bore."""

import math


def round_inertia(diameter: float, bore: float) -> float:
    """Second moment of area of a round section with a concentric bore [m^4]."""
    return math.pi / 64.0 * (diameter**4 - bore**4)


def round_area(diameter: float, bore: float) -> float:
    """Area of a round section with a bore [m^2]."""
    return math.pi / 4.0 * (diameter**2 - bore**2)
