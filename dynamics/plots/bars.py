"""Bars over the orders: amplitudes of harmonics."""

from collections.abc import Mapping

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import COLORS, new_axes
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.library_types import Axes

ORDER_LABEL = "harmonic order [cycles per revolution]"
# Share of the distance of two orders that their bars take.
FILLED = 0.6


def bar_width(orders: FloatArray) -> float:
    """Return the width of all bars of an order together."""
    return FILLED * float(orders[0] if len(orders) < 2 else np.min(np.diff(orders)))


def draw_harmonics(
    axes: Axes | None,
    orders: FloatArray,
    amplitudes: Mapping[str, FloatArray],
    label: str,
    *,
    title: str = "",
) -> Axes:
    """Draw amplitudes by order, side by side if there are several of each order.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    orders : ndarray of shape (K,)
        Ascending.
    amplitudes : mapping of str to ndarray of shape (K,)
        By name, in the unit of the axis.
    label : str
        Of the upright axis, with its unit.
    title : str, optional

    Returns
    -------
    matplotlib.axes.Axes
    """
    axes = new_axes(axes)
    width = bar_width(orders)
    each = width / len(amplitudes)
    for place, (name, heights) in enumerate(amplitudes.items()):
        shift = (place - 0.5 * (len(amplitudes) - 1)) * each
        axes.bar(orders + shift, heights, width=each, color=COLORS[place % len(COLORS)], label=name)
    axes.set_xlabel(ORDER_LABEL)
    axes.set_ylabel(label)
    if title:
        write_title(axes, title)
    if len(amplitudes) > 1:
        legend_inside(axes)
    return axes
