"""Vibration over time: the band between its extremes, its amplitude, and the speed."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from crankbase.checks.arrays import FloatArray, finite_array
from numpy.typing import ArrayLike

from crankbase.drawing.diagram_style import BLUE, GRAY, ORANGE, new_axes
from crankbase.drawing.legends import legend_above, write_title
from crankbase.errors import InputError
from crankbase.units.units import RPM

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
    steady: tuple[FloatArray, FloatArray],
    factor: float,
) -> None:
    """Draw steady amplitudes where a run passes their speeds.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    time, speed : ndarray of shape (m,)
        Of the run [s, rad/s].
    steady : (speeds [rad/s], amplitudes)
        At constant speeds, ascending; see `checked_steady`.
    factor : float
        What amplitudes are multiplied by.
    """
    axes.plot(
        time,
        # Not a number outside of what is known: a gap.
        factor * np.interp(speed, *steady, left=np.nan, right=np.nan),
        color=ORANGE,
        linestyle="--",
        linewidth=1.3,
        label="steady amplitude at this speed",
    )


def checked_steady(
    steady: tuple[ArrayLike, ArrayLike] | None,
) -> tuple[FloatArray, FloatArray] | None:
    """Return speeds [rad/s] and the steady amplitudes at them.

    Raises
    ------
    InputError
        If it is no pair, speeds do not ascend, or there is not an amplitude for each.
    """
    if steady is None:
        return None
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


class RunCurve(NamedTuple):
    """What one element or node of a run does over the time.

    Parameters
    ----------
    values : ndarray of shape (m,)
        At all times, in the unit of the axis.
    envelope_time, amplitude : ndarray of shape (w,)
        Times [s] and amplitudes of the windows, the latter in the unit of the axis.
    turns : int
        Of the shaft in each window.
    factor : float
        What a value in SI is multiplied by.
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
    axes: "Axes | None",
    time: FloatArray,
    speed: FloatArray,
    curve: RunCurve,
    steady: tuple[ArrayLike, ArrayLike] | None,
) -> "Axes":
    """Draw what one element or node of a run does over the time, on new axes if none are given.

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
        As `checked_steady`.
    """
    known = checked_steady(steady)
    axes = new_axes(axes)
    draw_band(axes, time, curve.values)
    draw_amplitude(axes, curve.envelope_time, curve.amplitude, curve.turns)
    if known is not None:
        draw_steady(axes, time, speed, known, curve.factor)
    axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time [s]")
    axes.set_ylabel(curve.label)
    write_title(axes, curve.name, 9)
    legend_above(axes)
    return axes


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
