"""Designs of a study as dots: fitted and held-out ones."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import BLUE, GRAY, ORANGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

KINDS = ((False, BLUE, "o", "fitted runs"), (True, ORANGE, "D", "held out"))


def draw_runs(axes: "Axes", x: Array, y: Array, held_out: Mask) -> None:
    """Draw a dot for each design, in the units of the axes."""
    for held, color, marker, label in KINDS:
        chosen = held_out == held
        axes.plot(
            x[chosen], y[chosen], marker, color=color, markersize=3.5, alpha=0.75, label=label
        )


def draw_parity(axes: "Axes", by_fe: Array, by_equation: Array, held_out: Mask) -> None:
    """Draw values by an equation over those by finite elements, in the units of the axes."""
    ends = np.array([by_fe.min(), by_fe.max()])
    axes.plot(ends, ends, color=GRAY, linewidth=1.0)
    draw_runs(axes, by_fe, by_equation, held_out)


def draw_errors(axes: "Axes", x: Array, errors: Array, held_out: Mask) -> None:
    """Draw errors of an equation [%] over anything, with the line of no error."""
    axes.axhline(0.0, color=GRAY, linewidth=1.0)
    draw_runs(axes, x, errors, held_out)


def draw_section(axes: "Axes", x: Array, y: Array, on_line: Mask) -> None:
    """Draw finite element results on a section's line filled, those shifted to it open."""
    for those, filling, alpha, label in (
        (~on_line, "none", 0.45, "others, moved to this line"),
        (on_line, ORANGE, 1.0, "finite elements"),
    ):
        axes.plot(
            x[those],
            y[those],
            "o",
            color=ORANGE,
            markerfacecolor=filling,
            markersize=3.5,
            alpha=alpha,
            label=label if those.any() else None,
        )
