"""Titles of pictures with engine and speed, and names below an axis."""

from typing import Any

import numpy as np

from crankbase.diagrams import plain_text
from crankbase.quantity import format_quantity

# Below an axis: longer names take a line for each word.
LONGEST_NAME = 9


def at_speed(engine: str, speed: float) -> str:
    """Write an engine's name and a speed [rad/s].

    Examples
    --------
    >>> at_speed("8ChN 13/14", 2094.395)
    '8ChN 13/14, 20000 1/min'
    """
    return f"{engine}, {format_quantity(speed, 'rad/s', 5)}"


def add_title(axes: Any, title: str) -> None:
    """Put a title above all axes of a figure, unchanged, unless it is empty."""
    if title:
        figure = np.atleast_1d(axes)[0].figure
        figure.suptitle(plain_text(title), fontsize=11, x=0.01, ha="left")


def short_name(name: str) -> str:
    r"""Return a node's name for the axis below a diagram; a node within a shaft of several parts has none.

    Examples
    --------
    >>> short_name("main bearing 7, flywheel, thrust bearing"), short_name("intermediate flange")
    ('7\nflywheel\nthrust', 'intermediate\nflange')
    """
    if " - " in name:
        return ""
    plain = name.replace("cylinder ", "cyl. ").replace("main bearing ", "")
    parts = plain.replace(" bearing", "").split(", ")
    return "\n".join(
        part.replace(" ", "\n") if len(part) > LONGEST_NAME else part for part in parts
    )
