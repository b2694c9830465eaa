"""Vibration over time: the band between its extremes, its amplitude, and the speed."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_array
from crankbase.drawing.diagram_style import BLUE, GRAY, ORANGE, new_axes
from crankbase.drawing.legends import legend_above, write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes
from crankbase.units.units import RPM

# Columns of the band between extremes: more cannot be told apart in print.
COLUMNS = 600


class RunCurve(NamedTuple):
    """The motion or load of one element or node over time.

    Parameters
    ----------
    values : ndarray of shape (m,)
        At all times, in the unit of the axis.
    envelope_time, amplitude : ndarray of shape (w,)
        Times [s] and amplitudes of the windows, the latter in the unit of the axis.
    turns : int
        Of the shaft in each window.
    factor : float
        Factor from SI to the unit of the axis.
    label : str
        Of the axis, with its unit.
    name : str
        Of the element or node.
    """

    values: FloatArray
    envelope_time: FloatArray
    amplitude: FloatArray
    turns: int
    factor: float
    label: str
    name: str


def plot_run(
    axes: Axes | None,
    time: FloatArray,
    speed: FloatArray,
    curve: RunCurve,
    steady: tuple[ArrayLike, ArrayLike] | None,
) -> Axes:
    """Draw the motion or load of one element or node over time, on new axes by default.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
    time, speed : ndarray of shape (m,)
        [s, rad/s]
    curve : RunCurve
    steady : (speeds [rad/s], amplitudes in SI) or None
        At constant speeds, ascending, drawn where the run passes these speeds.

    Raises
    ------
    InputError
        If steady is not a pair, its speeds do not ascend, or there is not an amplitude for each.
    """
    known = None if steady is None else _checked_steady(steady)
    axes = new_axes(axes)
    # The extremes in columns, few enough for a small file.
    columns = min(COLUMNS, time.size)
    starts = np.unique(np.linspace(0, time.size, columns, endpoint=False).astype(int))
    low, high = np.minimum.reduceat(curve.values, starts), np.maximum.reduceat(curve.values, starts)
    label = "extremes"
    axes.fill_between(time[starts], low, high, color=BLUE, alpha=0.3, linewidth=0.0, label=label)
    label = f"amplitude over {'each turn' if curve.turns == 1 else f'{curve.turns} turns'}"
    axes.plot(curve.envelope_time, curve.amplitude, color=BLUE, linewidth=1.6, label=label)
    if known is not None:
        # Not a number outside of what is known: a gap.
        steadily = curve.factor * np.interp(speed, *known, left=np.nan, right=np.nan)
        label = "steady amplitude at this speed"
        axes.plot(time, steadily, color=ORANGE, linestyle="--", linewidth=1.3, label=label)
    axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time [s]")
    axes.set_ylabel(curve.label)
    write_title(axes, curve.name, 9)
    legend_above(axes)
    return axes


def draw_speed(axes: Axes, time: FloatArray, speed: FloatArray) -> None:
    """Draw the speed [rad/s] over the time [s]."""
    places = np.linspace(0, time.size - 1, COLUMNS).astype(int)
    axes.plot(time[places], speed[places] * RPM, color=GRAY, linewidth=1.6)
    axes.set_ylabel("speed [1/min]")
    axes.set_xlabel("time [s]")
    axes.set_xlim(time[0], time[-1])


def _checked_steady(steady: tuple[ArrayLike, ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """Return ascending speeds [rad/s] and the steady amplitudes at them."""
    if not isinstance(steady, tuple | list) or len(steady) != 2:
        raise InputError(
            f"steady: given {steady!r}; allowed is a pair of speeds and amplitudes, because these are drawn "
            "over the speeds of the run."
        )
    known, amplitude = (finite_array("steady", values) for values in steady)
    if known.ndim != 1 or known.shape != amplitude.shape or np.any(np.diff(known) <= 0.0):
        raise InputError(
            f"steady: given arrays of shapes {known.shape} and {amplitude.shape}; allowed are ascending "
            "speeds and an amplitude for each, because they are drawn over the speeds of the run."
        )
    return known, amplitude
