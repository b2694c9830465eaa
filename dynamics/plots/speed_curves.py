"""Curves over the speed: the orders of a vibration with their sum, and plain curves."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.checks import FloatArray
from dynamics.plots.quantities import SPEED_LABEL, Shown
from geometry.diagram_style import BLUE, COLORS, GRAY, GREEN, ORANGE, RED, with_gaps
from geometry.plots.legends import legend_below, legend_inside
from geometry.units import RPM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BARRED = "#f6dcd9"
ALL_ORDERS = "#1c2733"
# Red is that of limits.
ORDER_COLORS = (BLUE, ORANGE, GREEN, "#7a5ba6", "#2a9d9d")
# Orders that get a line of their own in a diagram over speed.
MAIN_ORDERS = 5
# Height of a diagram with unbounded speeds in medians of the plain sum.
BESIDE_UNBOUNDED = 4.0
LEGEND_COLUMNS = 4


def main_orders_of(amplitudes: FloatArray, count: int) -> list[int]:
    """Return which orders have the largest peaks over the speeds, in ascending order.

    Parameters
    ----------
    amplitudes : ndarray of shape (K, S)
        What is not finite does not count.
    count : int
        How many at most.
    """
    peaks = np.max(np.where(np.isfinite(amplitudes), amplitudes, 0.0), axis=1)
    return [int(place) for place in np.sort(np.argsort(peaks)[::-1][: max(0, count)])]


def draw_orders(
    axes: "Axes",
    speeds: FloatArray,
    orders: FloatArray,
    amplitudes: FloatArray,
    count: int,
) -> None:
    """Draw the main orders over the speed, a line each; what is not finite leaves a gap.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    speeds : ndarray of shape (S,)
        [rad/s]
    orders : ndarray of shape (K,)
    amplitudes : ndarray of shape (K, S)
        In the unit of the axis.
    count : int
        How many orders, those with the largest peaks.
    """
    for drawn, order in enumerate(main_orders_of(amplitudes, count)):
        axes.plot(
            speeds * RPM,
            with_gaps(amplitudes[order]),
            color=ORDER_COLORS[drawn % len(ORDER_COLORS)],
            linewidth=1.1,
            label=f"order {orders[order]:g}",
        )


def draw_sums(axes: "Axes", speeds: FloatArray, total: FloatArray, plain: FloatArray) -> None:
    """Draw the sum of all orders over the cycle, and the plain sum of their amplitudes."""
    rpm = speeds * RPM
    axes.plot(
        rpm, with_gaps(total), color=ALL_ORDERS, linewidth=2.0, label="all orders (synthesis)"
    )
    axes.plot(rpm, with_gaps(plain), color=GRAY, linewidth=1.1, linestyle=":", label="plain sum")


def draw_barred(axes: "Axes", barred: Sequence[tuple[float, float]]) -> None:
    """Shade barred ranges of speed [rad/s]."""
    for count, (low, high) in enumerate(barred):
        axes.axvspan(
            low * RPM, high * RPM, color=BARRED, zorder=0, label=None if count else "barred"
        )


def draw_series(
    axes: "Axes",
    speeds: FloatArray,
    orders: FloatArray,
    by_order: FloatArray,
    total: FloatArray,
    plain: FloatArray,
    unbounded: NDArray[np.bool_],
    quantity: Shown,
    *,
    limits: Mapping[str, ArrayLike] | None = None,
    barred: Sequence[tuple[float, float]] = (),
    main_orders: int = MAIN_ORDERS,
) -> None:
    """Draw one place's main orders, synthesis and plain sum over the speed.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    speeds : ndarray of shape (S,)
        [rad/s]
    orders : ndarray of shape (K,)
    by_order : ndarray of shape (K, S)
        Amplitudes in SI; inf where unbounded.
    total, plain : ndarray of shape (S,)
        Of all orders together, and the sum of their amplitudes, in SI.
    unbounded : ndarray of shape (S,), bool
    quantity : Shown
    limits : mapping of str to float or array_like of shape (S,), optional
        In SI; inf where none is stated.
    barred : sequence of pairs of floats, optional
        Ranges of speed [rad/s], shaded.
    main_orders : int, optional
        How many orders, those with the largest peaks, get a line of their own.
    """
    factor = quantity.factor
    draw_barred(axes, barred)
    draw_orders(axes, speeds, orders, with_gaps(factor * by_order), main_orders)
    drawn = with_gaps(factor * plain)
    draw_sums(axes, speeds, factor * total, drawn)
    finish_over_speed(axes, speeds, drawn, unbounded, quantity, limits)


def finish_over_speed(
    axes: "Axes",
    speeds: FloatArray,
    plain: FloatArray,
    unbounded: NDArray[np.bool_],
    quantity: Shown,
    limits: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Draw limits and unbounded speeds, and set both axes and the legend.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    speeds : ndarray of shape (S,)
        [rad/s]
    plain : ndarray of shape (S,)
        Highest curve, in the unit of the axis; it sets the height.
    unbounded : ndarray of shape (S,), bool
    quantity : Shown
    limits : mapping of str to float or array_like of shape (S,), optional
        In SI; inf where none is stated.
    """
    rpm = speeds * RPM
    finite = plain[~unbounded]
    highest = float(np.max(finite, initial=0.0))
    if finite.size < plain.size:
        # Beside what has no bounds all else would be flat: let the curves leave at the top.
        highest = min(highest, BESIDE_UNBOUNDED * float(np.median(finite)) if finite.size else 0.0)
    for count, (name, limit) in enumerate((limits or {}).items()):
        values = np.broadcast_to(np.asarray(limit, dtype=float), rpm.shape)
        drawn = with_gaps(quantity.factor * values)
        axes.plot(
            rpm, drawn, color=RED, linewidth=1.4, linestyle=("--", "-.")[count % 2], label=name
        )
        highest = max(highest, float(np.nanmax(drawn, initial=0.0)))
    for count, speed in enumerate(rpm[unbounded].tolist()):
        axes.axvline(
            speed, color=RED, linewidth=0.8, linestyle=":", label=None if count else "unbounded"
        )
    set_speed_axis(axes, speeds)
    axes.set_ylim(0.0, 1.08 * highest if highest > 0.0 else 1.0)
    axes.set_ylabel(quantity.label)
    legend_below(axes, LEGEND_COLUMNS)


def draw_named_curves(
    axes: "Axes",
    speeds: FloatArray,
    curves: Mapping[str, FloatArray],
    label: str,
    *,
    dashed: bool = False,
) -> None:
    """Draw curves over the speed; what is not finite leaves a gap.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    speeds : ndarray of shape (S,)
        [rad/s]
    curves : mapping of str to ndarray of shape (S,)
        In the unit of the axis, none below zero.
    label : str
        Of the upright axis, with its unit.
    dashed : bool, optional
        Whether all but the first are.
    """
    for place, (name, values) in enumerate(curves.items()):
        axes.plot(
            speeds * RPM,
            with_gaps(np.asarray(values, dtype=np.float64)),
            color=COLORS[place % len(COLORS)],
            linestyle="--" if dashed and place else "-",
            linewidth=1.8 if dashed else 1.5,
            label=name,
        )
    set_speed_axis(axes, speeds)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(label)
    legend_inside(axes)


def set_speed_axis(axes: "Axes", speeds: FloatArray) -> None:
    """Name the axis of the speed and let it end with the speeds [rad/s], if they are several."""
    axes.set_xlabel(SPEED_LABEL)
    if len(speeds) > 1:
        axes.set_xlim(speeds[0] * RPM, speeds[-1] * RPM)
