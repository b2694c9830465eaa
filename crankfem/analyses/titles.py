"""What stands above a picture: of which engine it is, and at which speed."""

from typing import Any

import numpy as np

from crankbase.drawing.legends import plain_text
from crankbase.units.quantity import format_quantity


def at_speed(engine: str, speed: float) -> str:
    """Write an engine's name and a speed [rad/s].

    Examples
    --------
    >>> at_speed("8ChN 13/14", 2094.395)
    '8ChN 13/14, 20000 1/min'
    """
    return f"{engine}, {format_quantity(speed, 'rad/s', 5)}"


def add_title(axes: Any, title: str) -> None:
    """Put a title above all axes of a figure, as it is, unless it is empty."""
    if title:
        figure = np.atleast_1d(axes)[0].figure
        figure.suptitle(plain_text(title), fontsize=11, x=0.01, ha="left")
