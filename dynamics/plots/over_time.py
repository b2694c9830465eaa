"""Vibration over time: the band between its extremes, its amplitude, and the speed."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dynamics.checks import FloatArray, finite_array
from dynamics.plots.quantities import RPM
from geometry.diagram_style import BLUE, GRAY, ORANGE
from geometry.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Columns of the band between extremes: more cannot be told apart in print.
COLUMNS = 600


def draw_band(axes: "Axes", time: FloatArray, values: FloatArray) -> None:
    """Shade the band between a vibration's extremes over the time [s]."""
    edges, low, high = _extremes(time, values)
    axes.fill_between(edges, low, high, color=BLUE, alpha=0.3, linewidth=0.0, label="extremes")


def draw_amplitude(axes: "Axes", time: FloatArray, amplitude: FloatArray, turns: int) -> None:
    """Draw the amplitude in windows of so many turns over the time [s]."""
    label = f"amplitude over {'each turn' if turns == 1 else f'{turns} turns'}"
    axes.plot(time, amplitude, color=BLUE, linewidth=1.6, label=label)


def draw_steady(
    axes: "Axes",
    time: FloatArray,
    speed: FloatArray,
    steady: tuple[ArrayLike, ArrayLike],
    factor: float,
) -> None:
    """Draw steady amplitudes where a run passes their speeds.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    time, speed : ndarray of shape (m,)
        Of the run [s, rad/s].
    steady : (speeds [rad/s], amplitudes)
        At constant speeds, ascending.
    factor : float
        What amplitudes are multiplied by.

    Raises
    ------
    InputError
        If speeds do not ascend, or there is not an amplitude for each.
    """
    axes.plot(
        time,
        _passed(speed, steady) * factor,
        color=ORANGE,
        linestyle="--",
        linewidth=1.3,
        label="steady amplitude at this speed",
    )


def draw_speed(axes: "Axes", time: FloatArray, speed: FloatArray) -> None:
    """Draw the speed [rad/s] over the time [s]."""
    places = np.linspace(0, time.size - 1, COLUMNS).astype(int)
    axes.plot(time[places], speed[places] * RPM, color=GRAY, linewidth=1.6)
    axes.set_ylabel("speed [1/min]")
    axes.set_xlabel("time [s]")
    axes.set_xlim(time[0], time[-1])


def _extremes(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times and the extremes of the values around them, few enough for a small file."""
    columns = min(COLUMNS, time.size)
    starts = np.unique(np.linspace(0, time.size, columns, endpoint=False).astype(int))
    return time[starts], np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)


def _passed(speed: FloatArray, steady: tuple[ArrayLike, ArrayLike]) -> FloatArray:
    """Return steady amplitudes at the speeds of a run, not a number outside of what is known."""
    known, amplitude = (finite_array("steady", values) for values in steady)
    if known.ndim != 1 or known.shape != amplitude.shape or np.any(np.diff(known) <= 0.0):
        raise InputError(
            f"steady: given arrays of shapes {known.shape} and {amplitude.shape}; allowed are ascending "
            "speeds and an amplitude for each, because they are drawn over the speeds of the run."
        )
    return np.interp(speed, known, amplitude, left=np.nan, right=np.nan)
