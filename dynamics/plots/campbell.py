"""The Campbell diagram: natural frequencies and order lines over the speed, and where they meet."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from dynamics.checks import FloatArray
from dynamics.plots.order_kinds import KIND_COLORS
from dynamics.plots.quantities import SPEED_LABEL
from geometry.diagram_style import COLORS, GRAY
from geometry.units import RPM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RUNNING = "#eef3f8"
# Least and further size of a resonance's dot [points], the latter at severity 1.
DOT, DOT_GROWTH = 2.5, 9.0


class Meeting(Protocol):
    """What a dot of the diagram is drawn from; `dynamics.response.resonance.Resonance` is one."""

    @property
    def frequency(self) -> float:
        """Natural frequency [Hz]."""

    @property
    def speed_rpm(self) -> float:
        """Speed of the crankshaft [1/min]."""

    @property
    def severity(self) -> float:
        """Size of the dot, 0 to 1."""

    @property
    def kind(self) -> str:
        """Whether the order is "major" or "minor"."""

    @property
    def unbounded(self) -> bool:
        """Whether nothing damps it."""


def draw_campbell(
    axes: "Axes",
    natural: FloatArray,
    orders: FloatArray,
    speed_range: tuple[float, float],
    found: Sequence[Meeting],
) -> None:
    """Draw natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    natural : ndarray of shape (n,)
        Natural frequencies [Hz]; those above the range of the orders are left out.
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s].
    found : sequence of Meeting
        Dots grow with their severity.
    """
    low, high = (speed * RPM for speed in speed_range)
    # Limits may hold above the running range, and resonances lie there.
    last = max((own.speed_rpm for own in found), default=high)
    left, right = max(0.0, low - 0.15 * (high - low)), max(high, last) + 0.15 * (high - low)
    met = [own.frequency for own in found]
    reach = float(np.max(orders)) * right / 60.0
    shown = natural[natural <= reach]
    top = 1.12 * (max(met) if met else float(shown[0]) if shown.size else reach)
    axes.axvspan(low, high, color=RUNNING, zorder=0)
    for order in orders.tolist():
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
    axes.set_xlabel(SPEED_LABEL)
    axes.set_ylabel("frequency [Hz]")
    if found:
        axes.legend(
            fontsize=8, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.03), frameon=False
        )


def _order_line(axes: "Axes", order: float, ends: tuple[float, float], top: float) -> None:
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
