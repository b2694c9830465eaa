"""Amplitudes of a vibration that changes over time, by revolution."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice
from crankbase.checks.scalars import whole_number
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes
from crankbase.summaries import summarized
from crankbase.units.units import RPM
from dynamics.indices import node_index
from dynamics.plots.angle_curves import draw_over_time
from dynamics.plots.quantities import MOVING
from dynamics.plots.speed_curves import draw_named_curves
from dynamics.transient.curve_selection import OF_ELEMENTS, Moving


@summarized("turns", "time [s]", "speed [rad/s]", "motion", "torque")
@dataclass(frozen=True, eq=False)
class Envelope:
    """Half of the range within each window of whole revolutions.

    Parameters
    ----------
    turns : int
        In one window.
    time : ndarray of shape (w,)
        Middle of each window [s].
    speed : ndarray of shape (w,)
        Speed there [rad/s].
    motion : ndarray of shape (w, n)
        Of each node [rad or m].
    torque : ndarray of shape (w, e)
        Of each element [N m or N].
    """

    turns: int
    time: FloatArray
    speed: FloatArray
    motion: FloatArray
    torque: FloatArray

    def plot(
        self,
        axes: Axes | None = None,
        place: int = 0,
        *,
        quantity: Moving = "torque",
        over: Literal["speed", "time"] = "speed",
    ) -> Axes:
        """Draw the amplitude of one element or node over the speed or the time.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        place : int, optional
            Element, or node for "twist" and "displacement", from 0.
        quantity : {"torque", "force", "twist", "displacement"}, optional
        over : {"speed", "time"}, optional

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If there is no such element, node, quantity or axis.
        """
        check_choice("quantity", quantity, MOVING, "amplitudes of these are known")
        check_choice("over", over, ("speed", "time"), "amplitudes are known over these")
        of_element = quantity in OF_ELEMENTS
        values = self.torque if of_element else self.motion
        index = node_index("place", place, values.shape[1])
        label, factor = MOVING[quantity]
        name = f"amplitude over {self.turns} turn{'s' if self.turns > 1 else ''}"
        axes = new_axes(axes)
        if over == "speed":
            draw_named_curves(axes, self.speed, {name: factor * values[:, index]}, label)
            low, high = RPM * float(self.speed.min()), RPM * float(self.speed.max())
            if high > low:
                axes.set_xlim(low, high)
        else:
            draw_over_time(axes, self.time, {name: factor * values[:, index]}, label)
            axes.set_ylim(bottom=0.0)
        write_title(axes, f"{'element' if of_element else 'node'} {index}, {name}")
        return axes


def envelope_over(
    time: FloatArray,
    speed: FloatArray,
    shaft_angle: FloatArray,
    motion: FloatArray,
    torque: FloatArray,
    turns: int,
) -> Envelope:
    """Return the envelope of a motion sampled over time.

    Parameters
    ----------
    time, speed, shaft_angle : ndarray of shape (m,)
        [s, rad/s, rad]
    motion, torque : ndarray of shape (m, n) and (m, e)
    turns : int
        Revolutions of the shaft in one window: those after which the orders repeat, or more.

    Raises
    ------
    InputError
        If the motion is shorter than one window, or the number is not whole.

    Notes
    -----
    Windows begin at the start; an incomplete one at the end is not used. Half of the range
    excludes whatever is constant over the window, such as the twist by mean torque.
    """
    count = whole_number("turns", turns, 1, "a window takes whole turns of the shaft")
    window = 2.0 * np.pi * count
    # Room for round-off, so that n whole windows are n.
    whole = int((shaft_angle[-1] - shaft_angle[0]) / window + 1e-9)
    if whole < 1:
        raise InputError(
            f"turns: given {count}; allowed are at most "
            f"{(shaft_angle[-1] - shaft_angle[0]) / (2.0 * np.pi):.3g}, because the motion lasts for so "
            "many turns of the shaft."
        )
    edges = shaft_angle[0] + window * np.arange(whole + 1)
    starts = np.searchsorted(shaft_angle, edges - 1e-9 * window)
    middles = 0.5 * (edges[1:] + edges[:-1])

    def half_ranges(values: FloatArray) -> FloatArray:
        found = [
            half_peak_to_peak(values[max(first - 1, 0) : last + 1])
            for first, last in pairwise(starts.tolist())
        ]
        return np.array(found).reshape(whole, values.shape[1])

    times = np.interp(middles, shaft_angle, time)
    return Envelope(
        turns=count,
        time=times,
        speed=np.interp(times, time, speed),
        motion=half_ranges(motion),
        torque=half_ranges(torque),
    )


def half_peak_to_peak(values: FloatArray) -> FloatArray:
    """Return half of the peak-to-peak value of samples (m, k), (k,).

    The extremes are those of the parabolas through the highest and the lowest sample and its
    neighbors: with samples half a radian of a sine apart, the highest sample may miss the peak by
    3 %, the parabola by 0.02 %.
    """
    if not values.shape[1]:
        return np.zeros(0)
    return np.asarray(0.5 * (_peak(values) + _peak(-values)))


def _peak(values: FloatArray) -> FloatArray:
    columns = np.arange(values.shape[1])
    places = np.argmax(values, axis=0)
    highest = values[places, columns]
    # At either end there is one neighbor only, and the sample stands.
    inside = (places > 0) & (places < len(values) - 1)
    before = np.where(inside, values[places - 1, columns], highest)
    after = np.where(inside, values[np.minimum(places + 1, len(values) - 1), columns], highest)
    bend = 2.0 * highest - before - after
    above = np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros_like(bend), where=bend > 0.0)
    return np.asarray(highest + above)
