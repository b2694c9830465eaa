"""The Campbell diagram: natural frequencies and order lines over the speed, and where they meet."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.diagrams import COLORS, GRAY
from crankbase.tables.frames import Axes
from crankbase.units.units import RPM
from dynamics.plots.harmonics import KIND_COLORS
from dynamics.plots.quantities import SPEED_LABEL

RUNNING = "#eef3f8"
# Least and further size of a resonance's dot [points], the latter at severity 1.
DOT, DOT_GROWTH = 2.5, 9.0
# Least distance of the orders' labels, as a share of the side along which they stand.
LABEL_ROOM = 0.045
# Share of the running range shown on both sides of it, and of the height what is highest takes.
MARGIN, HEADROOM = 0.15, 1.12
FREQUENCY_LABEL = "frequency [Hz]"


class Meeting(Protocol):
    """The source of a dot of the diagram; `dynamics.response.resonance.Resonance` is one."""

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
        """Whether it is undamped."""


class CampbellFrame(NamedTuple):
    """Contents of a Campbell diagram, the same on paper and on a screen.

    Attributes
    ----------
    running : tuple of two floats
        Running range [1/min].
    ends : tuple of two floats
        Of the axis of the speed [1/min].
    top : float
        Of the axis of the frequency [Hz].
    natural : ndarray of shape (m,)
        Natural frequencies shown [Hz].
    """

    running: tuple[float, float]
    ends: tuple[float, float]
    top: float
    natural: FloatArray

    def line_end(self, order: float) -> tuple[float, float, bool]:
        """Return where an order's line ends [1/min, Hz], and whether it does so at the top."""
        right = self.ends[1]
        over = order * right / 60.0 > self.top
        speed = 60.0 * self.top / order if over else right
        return speed, min(order * right / 60.0, self.top), over

    def labeled(self, orders: Sequence[float]) -> list[float]:
        """Return the orders whose lines have labels at their ends: whole ones, shown and far enough apart."""
        labels, last = [], -LABEL_ROOM
        for order in sorted(orders):
            speed, frequency, over = self.line_end(order)
            if not float(order).is_integer() or speed <= self.ends[0]:
                continue
            # Up along the right side, then to the left along the top, in shares of both.
            share = (self.ends[1] - speed) / (self.ends[1] - self.ends[0])
            place = 1.0 + share if over else frequency / self.top
            if place - last >= LABEL_ROOM:
                labels.append(order)
                last = place
        return labels


def campbell_frame(
    natural: FloatArray,
    orders: FloatArray,
    speed_range: tuple[float, float],
    meetings: Sequence[Meeting],
) -> CampbellFrame:
    """Return the contents of a Campbell diagram; arguments as for `draw_campbell`."""
    low, high = (speed * RPM for speed in speed_range)
    # Limits may hold above the running range, and resonances lie there.
    last = max((meeting.speed_rpm for meeting in meetings), default=high)
    margin = MARGIN * (high - low)
    left, right = max(0.0, low - margin), max(high, last) + margin
    met = [meeting.frequency for meeting in meetings]
    reach = float(np.max(orders)) * right / 60.0
    shown = natural[natural <= reach]
    top = HEADROOM * (max(met) if met else float(shown[0]) if shown.size else reach)
    return CampbellFrame((low, high), (left, right), top, natural[natural <= top])


def mode_text(place: int, frequency: float) -> str:
    """Return the label at the line of a mode, from 0, of a frequency [Hz]."""
    return f"mode {place + 1}: {frequency:.1f} Hz"


def draw_campbell(
    axes: Axes,
    natural: FloatArray,
    orders: FloatArray,
    speed_range: tuple[float, float],
    meetings: Sequence[Meeting],
) -> None:
    """Draw natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    natural : ndarray of shape (n,)
        Natural frequencies [Hz]; those above the range of the orders are left out.
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s].
    meetings : sequence of Meeting
        Dots grow with their severity.
    """
    frame = campbell_frame(natural, orders, speed_range, meetings)
    (low, high), (left, right), top = frame.running, frame.ends, frame.top
    axes.axvspan(low, high, color=RUNNING, zorder=0)
    labeled = frame.labeled(orders.tolist())
    for order in orders.tolist():
        _order_line(axes, order, frame, labeled=order in labeled)
    for place, frequency in enumerate(frame.natural.tolist()):
        color = COLORS[place % len(COLORS)]
        axes.axhline(frequency, color=color, linewidth=1.6, zorder=2)
        axes.annotate(
            mode_text(place, frequency),
            (left, frequency),
            xytext=(4, 5),
            textcoords="offset points",
            fontsize=8,
            color=color,
            # Orders do not run through it.
            bbox={"facecolor": "white", "alpha": 0.85, "edgecolor": "none", "pad": 0.8},
        )
    for kind, color in KIND_COLORS.items():
        alike = [meeting for meeting in meetings if meeting.kind == kind]
        for meeting in alike:
            axes.plot(
                meeting.speed_rpm,
                meeting.frequency,
                "X" if meeting.unbounded else "o",
                color=color,
                markersize=DOT + DOT_GROWTH * meeting.severity,
                markeredgecolor="white",
                markeredgewidth=0.5,
                zorder=3,
            )
        if alike:
            axes.plot([], [], "o", color=color, label=f"{kind} order")
    if any(meeting.unbounded for meeting in meetings):
        axes.plot([], [], "X", color=GRAY, label="unbounded: nothing damps it")
    axes.set_xlim(left, right)
    axes.set_ylim(0.0, top)
    axes.set_xlabel(SPEED_LABEL)
    axes.set_ylabel(FREQUENCY_LABEL)
    if meetings:
        axes.legend(
            fontsize=8, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.03), frameon=False
        )


def _order_line(axes: Axes, order: float, frame: CampbellFrame, *, labeled: bool) -> None:
    """Draw one order's line, with its number at its end if it is labeled."""
    axes.plot(
        frame.ends,
        [order * end / 60.0 for end in frame.ends],
        color=GRAY,
        linewidth=0.8 if order.is_integer() else 0.35,
        zorder=1,
    )
    speed, frequency, over = frame.line_end(order)
    if labeled:
        axes.annotate(
            f"{order:g}",
            (speed, frequency),
            xytext=(0, 2) if over else (3, 0),
            textcoords="offset points",
            fontsize=7,
            ha="center" if over else "left",
            va="bottom" if over else "center",
            annotation_clip=False,
        )
