"""Curves over an angle or over time."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import COLORS, new_axes, with_gaps
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.library_types import Axes

# Ticks stand this far apart over a turn, over a cycle of two, and over longer spans [deg].
TICKS = ((360.0, 60.0), (720.0, 90.0))
LINE = 1.4
# Room for the round-off of an angle.
SAME = 1.0 + 1e-9
FROM_TOP = "crank angle from the top [deg]"
FROM_FIRING = "crank angle from the firing top [deg]"


def draw_over_angle(
    axes: Axes | None,
    angles: FloatArray,
    curves: Mapping[str, FloatArray],
    label: str,
    *,
    title: str = "",
    angle_label: str = "shaft angle [deg]",
    cyclic: bool = True,
    colors: Sequence[Any] = COLORS,
) -> Axes:
    """Draw curves over an angle, with gaps where values are not finite.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    angles : ndarray of shape (m,)
        Ascending [rad].
    curves : mapping of str to ndarray of shape (m,)
        In the unit of the axis.
    label, angle_label : str
        Of the axes, with their units.
    title : str, optional
    cyclic : bool, optional
        Whether the even angles are a cycle without its closing sample, which is added.
    colors : sequence of colors, optional
        Of the curves in turn.

    Returns
    -------
    matplotlib.axes.Axes
    """
    degrees = np.degrees(angles)
    if cyclic:
        degrees = np.append(degrees, 2.0 * degrees[-1] - degrees[-2])
        curves = {name: np.append(values, values[0]) for name, values in curves.items()}
    axes = new_axes(axes)
    _draw_curves(axes, degrees, curves, label, title, colors)
    first, last = float(degrees[0]), float(degrees[-1])
    step = next((step for longest, step in TICKS if last - first <= SAME * longest), None)
    if step is not None and last - first > step:
        axes.set_xticks(np.arange(np.floor(first / step) * step, last + step, step))
    if last > first:
        axes.set_xlim(first, last)
    axes.set_xlabel(angle_label)
    return axes


def draw_over_time(
    axes: Axes | None,
    time: FloatArray,
    curves: Mapping[str, FloatArray],
    label: str,
    *,
    title: str = "",
) -> Axes:
    """Draw curves over the time [s], with gaps where values are not finite. See `draw_over_angle`."""
    axes = new_axes(axes)
    _draw_curves(axes, time, curves, label, title, COLORS)
    if time[-1] > time[0]:
        axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time [s]")
    return axes


def _draw_curves(
    axes: Axes,
    along: FloatArray,
    curves: Mapping[str, FloatArray],
    label: str,
    title: str,
    colors: Sequence[Any],
) -> None:
    for place, (name, values) in enumerate(curves.items()):
        color = colors[place % len(colors)]
        axes.plot(along, with_gaps(values), color=color, linewidth=LINE, label=name)
    axes.set_ylabel(label)
    if title:
        write_title(axes, title)
    if len(curves) > 1:
        legend_inside(axes)
