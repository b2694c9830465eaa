"""Campbell diagrams: natural frequencies and orders over speed, and where they meet."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crankfem.pictures.interactive.style import (
    TEXT_COLOR,
    Figure,
    Part,
    axis,
    band,
    dots,
    layout,
    line,
    number,
)
from crankfem.vibration.motion import MOTION
from dynamics.response.resonance import Resonance
from geometry.diagram_style import COLORS, GRAY, ORANGE, RED
from geometry.units import RPM

Array = NDArray[np.float64]

RUNNING_COLOR = "#eef3f8"
KIND_COLORS = {"major": RED, "minor": ORANGE}
# Least and further size of a resonance's dot [pixels], the latter at severity 1.
DOT, DOT_GROWTH = 5.0, 12.0
# Points along a straight line to hover on.
PLACES = 25
# Share of the running range shown on both sides of it.
MARGIN = 0.15
HEIGHT = 480


def campbell(
    kind: str,
    frequencies: Array,
    orders: Array,
    speed_range: tuple[float, float],
    found: Sequence[Resonance],
    title: str,
) -> Figure:
    """Draw natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    kind : {"axial", "torsional"}
    frequencies : (n,) array
        Of the elastic modes [Hz].
    orders : (K,) array
        In cycles per revolution.
    speed_range : tuple of two floats
        Running range [rad/s].
    found : sequence of Resonance
        Dots grow with their severity.
    title : str

    Returns
    -------
    traces : list of dict
    layout : dict
    """
    low, high = (speed * RPM for speed in speed_range)
    # Limits may hold above the running range, and resonances lie there.
    last = max((own.speed_rpm for own in found), default=high)
    left, right = max(0.0, low - MARGIN * (high - low)), max(high, last) + MARGIN * (high - low)
    met = [one.frequency for one in found]
    reach = float(np.max(orders)) * right / 60.0
    natural = np.asarray(frequencies, dtype=np.float64)
    shown = natural[natural <= reach]
    top = 1.12 * (max(met) if met else float(shown[0]) if shown.size else reach)
    traces = [_order_line(order, left, right, top, first=not n) for n, order in enumerate(orders)]
    traces += [
        _mode_line(place, frequency, left, right)
        for place, frequency in enumerate(natural[natural <= top].tolist())
    ]
    for name, color in KIND_COLORS.items():
        own = [one for one in found if one.kind == name]
        if own:
            traces.append(_dots(kind, f"{name} order", own, color))
    notes = [
        _order_label(order, right, top) for order in orders.tolist() if _whole(order, left, top)
    ]
    notes += [
        {
            "x": left,
            "y": frequency,
            "text": f"mode {place + 1}: {frequency:.1f} Hz",
            "showarrow": False,
            "xanchor": "left",
            "yanchor": "bottom",
            "font": {"size": 12, "color": COLORS[place % len(COLORS)]},
        }
        for place, frequency in enumerate(natural[natural <= top].tolist())
    ]
    made = layout(
        axis("crankshaft speed [1/min]", range=[left, right], showgrid=False),
        axis("frequency [Hz]", range=[0.0, top]),
        title=title,
        height=HEIGHT,
        shapes=[band(low, high, RUNNING_COLOR, name="running range", showlegend=True)],
        annotations=notes,
    )
    # Dots of all sizes are one size in the legend.
    made["legend"] |= {"itemsizing": "constant"}
    return traces, made


def _order_line(order: float, left: float, right: float, top: float, *, first: bool) -> Part:
    """Return one order's line as far as it is seen; the legend switches all of them at once."""
    speeds = np.linspace(left, min(right, 60.0 * top / order), PLACES)
    whole = float(order).is_integer()
    return line(
        speeds,
        order * speeds / 60.0,
        "orders",
        GRAY,
        f"order {order:g}<br>%{{x:.5g}} 1/min<br>%{{y:.5g}} Hz",
        width=1.1 if whole else 0.5,
        legendgroup="orders",
        showlegend=first,
    )


def _whole(order: float, left: float, top: float) -> bool:
    """Whether an order is told at its line's end: whole ones that are seen."""
    return order.is_integer() and 60.0 * top / order > left


def _order_label(order: float, right: float, top: float) -> Part:
    over = order * right / 60.0 > top
    return {
        "x": 60.0 * top / order if over else right,
        "y": top if over else order * right / 60.0,
        "text": f"{order:g}",
        "showarrow": False,
        "xanchor": "center" if over else "left",
        "yanchor": "bottom" if over else "middle",
        "font": {"size": 11, "color": TEXT_COLOR},
    }


def _mode_line(place: int, frequency: float, left: float, right: float) -> Part:
    return line(
        np.linspace(left, right, PLACES),
        np.full(PLACES, frequency),
        f"mode {place + 1}",
        COLORS[place % len(COLORS)],
        f"mode {place + 1}<br>{frequency:.5g} Hz",
        width=2.0,
    )


def _dots(kind: str, name: str, own: Sequence[Resonance], color: str) -> Part:
    """Return the resonances of major or of minor orders; what they tell stands in their text."""
    return dots(
        [one.speed_rpm for one in own],
        [one.frequency for one in own],
        name,
        color,
        "%{text}",
        size=[round(DOT + DOT_GROWTH * one.severity, 1) for one in own],
        text=[_told(kind, one) for one in own],
        marker={"symbol": ["x" if one.unbounded else "circle" for one in own]},
    )


def _told(kind: str, one: Resonance) -> str:
    motion = MOTION[kind]
    size = (
        "unbounded: nothing damps it"
        if one.unbounded
        else f"amplitude {number(one.amplitude / motion.size)} {motion.unit}, of this order alone"
    )
    return (
        f"<b>order {one.order:g}, mode {one.mode}</b> ({one.kind})<br>{one.speed_rpm:.5g} 1/min, "
        f"{one.frequency:.5g} Hz<br>{size}"
    )
