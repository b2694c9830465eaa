"""Curves over an angle or over the time."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from crankbase.checks.arrays import FloatArray

from crankbase.drawing.diagram_style import COLORS, with_gaps
from crankbase.drawing.legends import legend_inside

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Ticks stand this far apart over a turn, over a cycle of two, and over longer spans [deg].
TICKS = ((360.0, 60.0), (720.0, 90.0))
LINE = 1.4
# Room for the round-off of an angle.
SAME = 1.0 + 1e-9
FROM_TOP = "crank angle from the top [deg]"
FROM_FIRING = "crank angle from the firing top [deg]"


def draw_over_angle(
    axes: "Axes",
    angles: FloatArray,
    curves: Mapping[str, FloatArray],
    label: str,
    *,
    angle_label: str = "shaft angle [deg]",
    cyclic: bool = True,
    colors: Sequence[Any] = COLORS,
) -> None:
    """Draw curves over an angle; what is not finite leaves a gap.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    angles : ndarray of shape (m,)
        Ascending [rad].
    curves : mapping of str to ndarray of shape (m,)
        In the unit of the axis.
    label, angle_label : str
        Of the axes, with their units.
    cyclic : bool, optional
        Whether the even angles are those of a cycle without its closing sample, which is added.
    colors : sequence of colors, optional
        Of the curves in turn.
    """
    degrees = np.degrees(angles)
    if cyclic:
        degrees = np.append(degrees, 2.0 * degrees[-1] - degrees[-2])
    for place, (name, values) in enumerate(curves.items()):
        drawn = with_gaps(values)
        axes.plot(
            degrees,
            np.append(drawn, drawn[0]) if cyclic else drawn,
            color=colors[place % len(colors)],
            linewidth=LINE,
            label=name,
        )
    set_angle_axis(axes, float(degrees[0]), float(degrees[-1]), angle_label)
    axes.set_ylabel(label)
    if len(curves) > 1:
        legend_inside(axes)


def set_angle_axis(axes: "Axes", first: float, last: float, label: str) -> None:
    """Name the axis of an angle and put ticks at round angles [deg]."""
    span = last - first
    step = next((step for longest, step in TICKS if span <= SAME * longest), None)
    if step is not None and span > step:
        axes.set_xticks(np.arange(np.floor(first / step) * step, last + step, step))
    if span > 0.0:
        axes.set_xlim(first, last)
    axes.set_xlabel(label)


def draw_over_time(
    axes: "Axes", time: FloatArray, curves: Mapping[str, FloatArray], label: str
) -> None:
    """Draw curves over the time [s]; what is not finite leaves a gap."""
    for place, (name, values) in enumerate(curves.items()):
        axes.plot(
            time, with_gaps(values), color=COLORS[place % len(COLORS)], linewidth=LINE, label=name
        )
    if time[-1] > time[0]:
        axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time [s]")
    axes.set_ylabel(label)
    if len(curves) > 1:
        legend_inside(axes)
