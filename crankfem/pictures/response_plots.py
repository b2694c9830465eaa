"""Diagrams of forced vibration: Campbell diagram, and amplitudes, loads, stresses over speed."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankfem.pictures.titles import add_title
from crankfem.record import RPM
from dynamics.checks import finite_array, place_of
from dynamics.response.resonance import Resonance
from dynamics.response.series import OrderSeries
from geometry.diagram_style import BLUE, COLORS, GRAY, GREEN, ORANGE, RED, figure, with_gaps
from geometry.errors import InputError

Array: TypeAlias = NDArray[np.float64]
Quantity: TypeAlias = Literal["twist", "displacement", "torque", "force", "stress"]
# Label of the axis, and what a value in SI is multiplied by.
QUANTITIES: dict[str, tuple[str, float]] = {
    "twist": ("amplitude [mrad]", 1e3),
    "displacement": ("amplitude [um]", 1e6),
    "torque": ("alternating torque [kN m]", 1e-3),
    "force": ("alternating force [kN]", 1e-3),
    "stress": ("alternating stress [MPa]", 1e-6),
}
RUNNING, BARRED = "#eef3f8", "#f6dcd9"
# Red is that of limits.
ORDER_COLORS = (BLUE, ORANGE, GREEN, "#7a5ba6", "#2a9d9d")
KIND_COLORS = {"major": RED, "minor": ORANGE}
# Orders that get a line of their own in a diagram over speed.
MAIN_ORDERS = 5
# Height of a diagram with unbounded speeds in medians of the plain sum.
BESIDE_UNBOUNDED = 4.0
# Least and further size of a resonance's dot [points], the latter at severity 1.
DOT, DOT_GROWTH = 2.5, 9.0


def plot_response_campbell(
    path: Path,
    frequencies: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    found: Sequence[Resonance],
    *,
    title: str = "",
) -> None:
    """Plot natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    path : Path
        SVG file.
    frequencies : array_like of shape (n,)
        Natural frequencies of elastic modes [Hz]; those above the range of the orders are left out.
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s].
    found : sequence of Resonance
        Dots grow with their severity.
    title : str, optional

    Raises
    ------
    InputError
        If the path is no SVG file in a folder that is there.
    """
    natural, lines = finite_array("frequencies", frequencies), finite_array("orders", orders)
    low, high = (speed * RPM for speed in speed_range)
    left, right = max(0.0, low - 0.15 * (high - low)), high + 0.15 * (high - low)
    met = [own.frequency for own in found]
    reach = float(np.max(lines)) * right / 60.0
    shown = natural[natural <= reach]
    top = 1.12 * (max(met) if met else float(shown[0]) if shown.size else reach)
    with figure(path, height=4.8) as axes:
        axes.axvspan(low, high, color=RUNNING, zorder=0)
        for order in lines.tolist():
            _order_line(axes, order, (left, right), top)
        for place, frequency in enumerate(natural[natural <= top].tolist()):
            color = COLORS[place % len(COLORS)]
            axes.axhline(frequency, color=color, linewidth=1.6, zorder=2)
            axes.annotate(
                f"mode {place + 1}: {frequency:.1f} Hz",
                (left, frequency),
                xytext=(4, 3),
                textcoords="offset points",
                fontsize=8,
                color=color,
            )
        for kind, color in KIND_COLORS.items():
            own = [one for one in found if one.kind == kind]
            for one in own:
                axes.plot(
                    one.speed_rpm,
                    one.frequency,
                    "X" if one.unbounded else "o",
                    color=color,
                    markersize=DOT + DOT_GROWTH * one.severity,
                    markeredgecolor="white",
                    markeredgewidth=0.5,
                    zorder=3,
                )
            if own:
                axes.plot([], [], "o", color=color, label=f"{kind} order")
        if any(one.unbounded for one in found):
            axes.plot([], [], "X", color=GRAY, label="unbounded: nothing damps it")
        axes.set_xlim(left, right)
        axes.set_ylim(0.0, top)
        axes.set_xlabel("crankshaft speed [1/min]")
        axes.set_ylabel("frequency [Hz]")
        if found:
            axes.legend(fontsize=8, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.03))
        add_title(axes, title)


def _order_line(axes: Any, order: float, ends: tuple[float, float], top: float) -> None:
    """Draw one order's line, its number where it leaves the diagram; whole orders are told."""
    left, right = ends
    whole = float(order).is_integer()
    axes.plot(
        ends,
        [order * end / 60.0 for end in ends],
        color=GRAY,
        linewidth=0.8 if whole else 0.35,
        zorder=1,
    )
    over = order * right / 60.0 > top
    speed = 60.0 * top / order if over else right
    if whole and speed > left:
        axes.annotate(
            f"{order:g}",
            (speed, min(order * right / 60.0, top)),
            xytext=(0, 2) if over else (3, 0),
            textcoords="offset points",
            fontsize=7,
            ha="center" if over else "left",
            va="bottom" if over else "center",
            annotation_clip=False,
        )


def plot_over_speed(
    path: Path,
    series: OrderSeries,
    place: int | str,
    quantity: Quantity,
    *,
    limits: Mapping[str, ArrayLike] | None = None,
    barred: Sequence[tuple[float, float]] = (),
    main_orders: int = MAIN_ORDERS,
    title: str = "",
) -> None:
    """Plot one place's main orders, synthesis and plain sum over speed.

    Parameters
    ----------
    path : Path
        SVG file.
    series : OrderSeries
        Motion of nodes, loads or stresses of elements, at two speeds or more.
    place : int or str
        Which of them, by number from 0 or name.
    quantity : {"twist", "displacement", "torque", "force", "stress"}
        What the values are: it names the axis and gives the unit.
    limits : mapping of str to float or array_like of shape (S,), optional
        Limits by name, in SI, constant or over the speeds; inf where none is stated.
    barred : sequence of pairs of floats, optional
        Barred ranges of speed [rad/s], shaded.
    main_orders : int, optional
        How many orders, those with the largest peaks, get a line of their own.
    title : str, optional

    Raises
    ------
    InputError
        If the place or the quantity is unknown, or the path no SVG file in a folder that is there.
    """
    if quantity not in QUANTITIES:
        raise InputError(f"quantity: given {quantity!r}; allowed are {', '.join(QUANTITIES)}.")
    number = place_of("place", place, series.names, "the series", "one curve is that of one place")
    label, factor = QUANTITIES[quantity]
    rpm = series.speeds * RPM
    by_order = with_gaps(factor * series.amplitude[:, :, number])
    both = series.synthesis
    total = with_gaps(factor * both.amplitude[:, number])
    plain = with_gaps(factor * both.plain_sum[:, number])
    peaks = np.max(np.where(np.isnan(by_order), 0.0, by_order), axis=1)
    main = np.sort(np.argsort(peaks)[::-1][: max(0, main_orders)])
    with figure(path, height=4.4) as axes:
        for count, (low, high) in enumerate(barred):
            axes.axvspan(
                low * RPM, high * RPM, color=BARRED, zorder=0, label=None if count else "barred"
            )
        for shown, order in enumerate(main.tolist()):
            axes.plot(
                rpm,
                by_order[order],
                color=ORDER_COLORS[shown % len(ORDER_COLORS)],
                linewidth=1.1,
                label=f"order {series.orders[order]:g}",
            )
        axes.plot(rpm, total, color="#1c2733", linewidth=2.0, label="all orders (synthesis)")
        axes.plot(rpm, plain, color=GRAY, linewidth=1.1, linestyle=":", label="plain sum")
        finite = plain[~both.unbounded]
        highest = float(np.max(finite, initial=0.0))
        if finite.size < plain.size:
            # Beside what has no bounds all else would be flat: let the curves leave at the top.
            highest = min(
                highest, BESIDE_UNBOUNDED * float(np.median(finite)) if finite.size else 0.0
            )
        for count, (name, limit) in enumerate((limits or {}).items()):
            drawn = with_gaps(factor * np.broadcast_to(np.asarray(limit, dtype=float), rpm.shape))
            axes.plot(
                rpm, drawn, color=RED, linewidth=1.4, linestyle=("--", "-.")[count % 2], label=name
            )
            highest = max(highest, float(np.nanmax(drawn, initial=0.0)))
        for count, speed in enumerate(rpm[both.unbounded].tolist()):
            axes.axvline(
                speed, color=RED, linewidth=0.8, linestyle=":", label=None if count else "unbounded"
            )
        axes.set_xlim(rpm[0], rpm[-1])
        axes.set_ylim(0.0, 1.08 * highest if highest > 0.0 else 1.0)
        axes.set_xlabel("crankshaft speed [1/min]")
        axes.set_ylabel(label)
        axes.set_title(series.names[number], fontsize=10)
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
        add_title(axes, title)
