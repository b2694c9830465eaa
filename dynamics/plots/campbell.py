"""The Campbell diagram: natural frequencies and order lines over the speed, and where they meet."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from crankbase.array_checks import Array
from crankbase.diagrams import COLORS, GRAY, Band, Diagram, Dots, Limits, Line, Note, draw_diagram
from crankbase.frames import Axes
from crankbase.quantity import RPM
from dynamics.plots.curves import SPEED_LABEL
from dynamics.plots.harmonics import KIND_COLORS

RUNNING = "#eef3f8"
# Points along a straight line to hover on.
PLACES = 25
# Least distance of the orders' labels, as a share of the side along which they stand.
LABEL_ROOM = 0.045
# Share of the running range shown on both sides of it, and of the height what is highest takes.
MARGIN, HEADROOM = 0.15, 1.12


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
    natural: Array

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
    natural: Array,
    orders: Array,
    speed_range: tuple[float, float],
    meetings: Sequence[Meeting],
) -> CampbellFrame:
    """Return the contents of a Campbell diagram; arguments as for `campbell`."""
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


def campbell(
    natural: Array,
    orders: Array,
    speed_range: tuple[float, float],
    meetings: Sequence[Meeting],
    texts: Sequence[str] = (),
) -> Diagram:
    """Describe natural frequencies and order lines over speed, with a dot at each resonance.

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
    texts : sequence of str, optional
        What a screen tells of each meeting.
    """
    frame = campbell_frame(natural, orders, speed_range, meetings)
    left, right = frame.ends
    lines, notes, dots = [], [], []
    for order in orders.tolist():
        speeds = np.linspace(left, frame.line_end(order)[0], PLACES)
        hover = f"order {order:g}<br>%{{x:.5g}} 1/min<br>%{{y:.5g}} Hz"
        width = 0.9 if float(order).is_integer() else 0.4
        lines.append(
            Line(speeds, order * speeds / 60.0, "orders", GRAY, hover, width, group="orders")
        )
    for order in frame.labeled(orders.tolist()):
        speed, frequency, over = frame.line_end(order)
        notes.append(Note(f"{order:g}", speed, frequency, "above" if over else "right"))
    for place, frequency in enumerate(frame.natural.tolist()):
        name, color = f"mode {place + 1}", COLORS[place % len(COLORS)]
        along, hover = np.linspace(left, right, PLACES), f"{name}<br>{frequency:.5g} Hz"
        lines.append(Line(along, np.full(PLACES, frequency), name, color, hover, 1.6))
        notes.append(Note(f"{name}: {frequency:.1f} Hz", left, frequency, "line", color))
    for kind, color in KIND_COLORS.items():
        alike = [place for place, meeting in enumerate(meetings) if meeting.kind == kind]
        if alike:
            dots.append(
                Dots(
                    [meetings[place].speed_rpm for place in alike],
                    [meetings[place].frequency for place in alike],
                    f"{kind} order",
                    color,
                    "".join("X" if meetings[place].unbounded else "o" for place in alike),
                    [meetings[place].severity for place in alike],
                    "%{text}",
                    [texts[place] for place in alike] if texts else (),
                )
            )
    return Diagram(
        Limits(SPEED_LABEL, frame.ends),
        Limits("frequency [Hz]", (0.0, frame.top)),
        lines,
        dots,
        notes,
        (Band(*frame.running, RUNNING, "running range"),),
        lines_named=False,
    )


def draw_campbell(
    axes: Axes,
    natural: Array,
    orders: Array,
    speed_range: tuple[float, float],
    meetings: Sequence[Meeting],
) -> None:
    """Draw `campbell` on axes, with its legend."""
    draw_diagram(axes, campbell(natural, orders, speed_range, meetings))
    if any(meeting.unbounded for meeting in meetings):
        axes.plot([], [], "X", color=GRAY, label="unbounded: nothing damps it")
    if meetings:
        axes.legend(
            fontsize=8, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.03), frameon=False
        )
