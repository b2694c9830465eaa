"""Campbell diagrams: natural frequencies and orders over speed, and where they meet."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import COLORS, GRAY
from crankfem.analyses.shaft.motion import MOTION
from crankfem.report.interactive.style import (
    TEXT_COLOR,
    Figure,
    Part,
    axis,
    band,
    dots,
    layout,
    line,
    note,
    number,
)
from dynamics.plots.campbell import (
    FREQUENCY_LABEL,
    RUNNING,
    CampbellFrame,
    campbell_frame,
    mode_text,
)
from dynamics.plots.quantities import SPEED_LABEL
from dynamics.plots.stars import KIND_COLORS
from dynamics.response.damped_criticals import DampedCritical

Array = NDArray[np.float64]

# Least and further size of a resonance's dot [pixels], the latter at severity 1.
DOT, DOT_GROWTH = 5.0, 12.0
# Points along a straight line to hover on.
PLACES = 25
HEIGHT = 480


def campbell(
    kind: str,
    frequencies: Array,
    orders: Array,
    speed_range: tuple[float, float],
    found: Sequence[DampedCritical],
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
    found : sequence of DampedCritical
        Dots grow with their severity.
    title : str

    Returns
    -------
    traces : list of dict
    layout : dict
    """
    natural = np.asarray(frequencies, dtype=np.float64)
    frame = campbell_frame(natural, orders, speed_range, found)
    left, right = frame.ends
    traces = [_order_line(order, frame, first=not n) for n, order in enumerate(orders.tolist())]
    traces += [
        _mode_line(place, frequency, left, right)
        for place, frequency in enumerate(frame.natural.tolist())
    ]
    for name, color in KIND_COLORS.items():
        own = [one for one in found if one.kind == name]
        if own:
            traces.append(_dots(kind, f"{name} order", own, color))
    notes = [_order_label(order, frame) for order in frame.labeled(orders.tolist())]
    notes += [
        note(
            mode_text(place, frequency),
            color=COLORS[place % len(COLORS)],
            x=left,
            y=frequency,
            xanchor="left",
            yanchor="bottom",
            # Above the dots of weak resonances on the line.
            yshift=5,
            # Orders do not run through it.
            bgcolor="rgba(255, 255, 255, 0.85)",
        )
        for place, frequency in enumerate(frame.natural.tolist())
    ]
    made = layout(
        axis(SPEED_LABEL, range=[left, right], showgrid=False),
        axis(FREQUENCY_LABEL, range=[0.0, frame.top]),
        title=title,
        height=HEIGHT,
        shapes=[band(*frame.running, RUNNING, name="running range", showlegend=True)],
        annotations=notes,
    )
    # Dots of all sizes are one size in the legend.
    made["legend"] |= {"itemsizing": "constant"}
    return traces, made


def _order_line(order: float, frame: CampbellFrame, *, first: bool) -> Part:
    """Return one order's line as far as it is seen; the legend switches all of them at once."""
    speeds = np.linspace(frame.ends[0], frame.line_end(order)[0], PLACES)
    return line(
        speeds,
        order * speeds / 60.0,
        "orders",
        GRAY,
        f"order {order:g}<br>%{{x:.5g}} 1/min<br>%{{y:.5g}} Hz",
        width=1.1 if order.is_integer() else 0.5,
        legendgroup="orders",
        showlegend=first,
    )


def _order_label(order: float, frame: CampbellFrame) -> Part:
    speed, frequency, over = frame.line_end(order)
    side = {"xanchor": "center", "yanchor": "bottom"} if over else {"xanchor": "left"}
    return note(f"{order:g}", size=11, color=TEXT_COLOR, x=speed, y=frequency, **side)


def _mode_line(place: int, frequency: float, left: float, right: float) -> Part:
    return line(
        np.linspace(left, right, PLACES),
        np.full(PLACES, frequency),
        f"mode {place + 1}",
        COLORS[place % len(COLORS)],
        f"mode {place + 1}<br>{frequency:.5g} Hz",
        width=2.0,
    )


def _dots(kind: str, name: str, own: Sequence[DampedCritical], color: str) -> Part:
    """Return the resonances of major or of minor orders; what they tell stands in their text."""
    return dots(
        [one.speed_rpm for one in own],
        [one.frequency for one in own],
        name,
        color,
        "%{text}",
        size=[round(DOT + DOT_GROWTH * one.severity, 1) for one in own],
        text=[_hover_text(kind, one) for one in own],
        marker={"symbol": ["x" if one.unbounded else "circle" for one in own]},
    )


def _hover_text(kind: str, one: DampedCritical) -> str:
    motion = MOTION[kind]
    size = (
        "unbounded: nothing damps it"
        if one.unbounded
        else f"amplitude {number(one.first_amplitude / motion.size)} {motion.unit} of the free end, by "
        f"this order alone; peak of {one.place}"
    )
    return (
        f"<b>order {one.order:g}, mode {one.mode}</b> ({one.kind})<br>{one.speed_rpm:.5g} 1/min, "
        f"{one.frequency:.5g} Hz<br>{size}"
    )
