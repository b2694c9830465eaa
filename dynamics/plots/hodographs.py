"""Hodographs: closed curves of rotating vectors, seen from the free end."""

import math
from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import COLORS, GRAY, new_axes
from crankbase.drawing.legends import legend_below, write_title
from crankbase.library_types import Axes
from dynamics.plots.quantities import KILO

DASHES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1.2)), (0, (6, 2, 1, 2, 1, 2)))
AXIS_LINE: Any = (0, (8, 3, 1, 3))
FORCE_LABELS = ("force to the right, $-F_x$ [kN]", "force upwards, $F_y$ [kN]")
MOMENT_LABELS = ("moment about $-x$ [kN m]", "moment about $y$ [kN m]")
MARGIN = 1.12
POINTS = 361
# Names up to so many letters stand three in a row under the axes.
SHORT = 14


class Curve(Protocol):
    """A closed curve; `dynamics.balance.hodograph.Hodograph` is one."""

    @property
    def major(self) -> float:
        """Largest distance from the origin."""

    def points(self, count: int = 181) -> tuple[FloatArray, FloatArray]:
        """Return x and y of points along it."""


def draw_hodographs(
    axes: Axes | None,
    curves: Mapping[str, Curve],
    labels: tuple[str, str],
    *,
    title: str = "",
    banks: Iterable[float] = (),
    empty: str = "balanced",
) -> Axes:
    """Draw hodographs, y up and x to the left, as seen from the free end: the shaft turns clockwise.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    curves : mapping of str to Curve
        By name [N or N m]; none leaves the axes empty, with `empty` in the middle.
    labels : tuple of two str
        Of the axes across and up.
    title : str, optional
    banks : iterable of float, optional
        Angles of the cylinders' axes, drawn as thin lines [rad].
    empty : str, optional

    Returns
    -------
    matplotlib.axes.Axes

    Notes
    -----
    A dot marks each vector at shaft angle zero, an arrowhead the direction of motion.
    """
    axes = new_axes(axes, width=4.6, height=5.6)
    reach = MARGIN * KILO * max((curve.major for curve in curves.values()), default=0.0) or 1.0
    if curves:
        for angle in sorted(set(banks)):
            across, up = math.sin(angle), math.cos(angle)
            ends = np.array([-1.0, 1.0]) * reach / max(abs(across), abs(up))
            axes.plot(ends * across, ends * up, color=GRAY, linewidth=0.7, linestyle=AXIS_LINE)
    for number, (name, curve) in enumerate(curves.items()):
        color = COLORS[number % len(COLORS)]
        left, upwards = (KILO * part for part in curve.points(POINTS))
        axes.plot(-left, upwards, color=color, linestyle=DASHES[number % len(DASHES)], label=name)
        axes.plot(-left[0], upwards[0], "o", color=color, markersize=4)
        _draw_arrow(axes, -left, upwards, color)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    if title:
        write_title(axes, title)
    if curves:
        short = max(len(name) for name in curves) <= SHORT
        legend_below(axes, min(len(curves), 3 if short else 2))
    else:
        axes.text(0.5, 0.5, empty, transform=axes.transAxes, ha="center", va="center")
        axes.set_xticks([])
        axes.set_yticks([])
    return axes


def _draw_arrow(axes: Axes, across: FloatArray, up: FloatArray, color: str) -> None:
    """Draw an arrowhead an eighth of the way along the curve, unless it is a point."""
    place = POINTS // 8
    tail, head = (across[place], up[place]), (across[place + 3], up[place + 3])
    if math.dist(tail, head) > 0.0:
        axes.annotate(
            "", head, tail, arrowprops={"arrowstyle": "-|>", "color": color, "mutation_scale": 11}
        )
