"""Harmonics: amplitudes as bars over the orders, and samples of a torque with their sum."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import BLUE, COLORS, GREEN, ORANGE, new_axes
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.library_types import Axes

ORDER_LABEL = "harmonic order [cycles per revolution]"
# Share of the distance of two orders that their bars take.
FILLED = 0.6
POINTS = 721
ANGLE_LABEL, TORQUE_LABEL = "crank angle [deg]", "torque of one throw [N m]"


def bar_width(orders: FloatArray) -> float:
    """Return the combined width of all bars of an order."""
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
        Label of the vertical axis, with its unit.
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


class Sum(Protocol):
    """A sum of harmonics; `dynamics.harmonics.Harmonics` is one."""

    @property
    def mean(self) -> float:
        """Mean value."""

    @property
    def strokes(self) -> int:
        """Strokes per cycle."""

    def at(self, *, crank_angle_deg: FloatArray) -> FloatArray:
        """Return the sum at crank angles [deg]."""


def over_cycle(samples: FloatArray, found: Sum) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles and the sum of harmonics at them, and the angles of samples, all in degrees.

    Parameters
    ----------
    samples : ndarray of shape (m,)
        Even over one cycle from crank angle zero.
    found : Sum

    Returns
    -------
    degrees, sums : ndarray of shape (p,)
    sampled : ndarray of shape (m,)
    """
    cycle = 180.0 * found.strokes
    degrees = np.linspace(0.0, cycle, POINTS)
    return (
        degrees,
        found.at(crank_angle_deg=degrees),
        np.arange(len(samples)) * cycle / len(samples),
    )


def draw_samples(
    axes: Axes | None,
    samples: FloatArray,
    found: Sum,
    *,
    summed: str = "sum of harmonics",
    title: str = "",
) -> Axes:
    """Draw samples of the torque of one throw, the sum of harmonics, and the mean.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    samples : ndarray of shape (m,)
        Even over one cycle from crank angle zero [N m].
    found : Sum
    summed : str, optional
        Words for the sum.
    title : str, optional

    Returns
    -------
    matplotlib.axes.Axes
    """
    axes = new_axes(axes)
    degrees, sums, sampled = over_cycle(samples, found)
    axes.plot(degrees, sums, color=BLUE, label=summed)
    axes.plot(sampled, samples, "o", color=ORANGE, markersize=3.5, label="table")
    axes.axhline(found.mean, color=GREEN, linestyle="--", linewidth=1.0, label="mean")
    axes.set_xlabel(ANGLE_LABEL)
    axes.set_ylabel(TORQUE_LABEL)
    legend_inside(axes)
    if title:
        write_title(axes, title)
    return axes
