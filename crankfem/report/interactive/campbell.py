"""Campbell diagrams: natural frequencies and orders over speed, and where they meet."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import BLUE, COLORS, GRAY, GREEN, ORANGE
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.titles import short_name
from crankfem.analyses.vibration.modes import SourceResult, mode_label
from crankfem.report.interactive.style import (
    TEXT_COLOR,
    Figure,
    Part,
    axis,
    band,
    choice,
    dots,
    layout,
    level,
    line,
    line_style,
    literal,
    note,
    number,
    visibility_by_choice,
)
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.crankshaft.surroundings import RZ, UX, UY, UZ
from dynamics.plots.campbell import (
    FREQUENCY_LABEL,
    RUNNING,
    CampbellFrame,
    campbell_frame,
    mode_text,
)
from dynamics.plots.harmonics import KIND_COLORS
from dynamics.plots.mode_shapes import chain_places, crosses_on_axis
from dynamics.plots.quantities import SPEED_LABEL
from dynamics.response.damped_criticals import DampedCritical

# Modes that are drawn before anybody asks for the others, and all that are there.
SHAPES_SHOWN, SHAPES = 3, 8


def mode_shapes(result: SourceResult, title: str) -> Figure:
    """Draw the first elastic mode shapes of a chain.

    Parameters
    ----------
    result : SourceResult
    title : str

    Returns
    -------
    traces : list of dict
        For each mode its shape, then where it does not move.
    layout : dict
    """
    modes, chain = result.modes, result.chain.chain
    names = [literal(name) for name in result.chain.nodes]
    moved = MOTION[result.chain.kind].quantity
    places = chain_places(len(names), chain.connections)
    traces: list[Part] = []
    last = min(modes.rigid + SHAPES, len(modes.frequencies))
    for shown, mode in enumerate(range(modes.rigid, last)):
        shape, still = modes.shapes[:, mode], modes.node_positions[mode]
        label = f"mode {shown + 1}: {mode_label(modes.frequencies[mode], still)}"
        color = line_style(shown)["color"]
        shared: Part = {
            "legendgroup": f"mode {shown + 1}",
            "visible": True if shown < SHAPES_SHOWN else "legendonly",
        }
        # Chains may branch: each connection is a line of its own.
        x = [place for pair in chain.connections for place in (*places[list(pair)], np.nan)]
        told = [name for pair in chain.connections for name in (*(names[end] for end in pair), "")]
        y = [value for pair in chain.connections for value in (*shape[list(pair)], np.nan)]
        traces.append(
            line(
                x,
                y,
                label,
                **line_style(shown),
                hover=f"%{{text}}<br>relative {moved} %{{y:.3f}}<br>{label}",
                mode="lines+markers",
                marker={"size": 6},
                text=told,
                **shared,
            )
        )
        if still:
            traces.append(
                _nodes(
                    still, crosses_on_axis(still, chain.connections, places), label, color, shared
                )
            )
    return traces, layout(
        axis(
            "",
            tickvals=places.tolist(),
            ticktext=[
                "<br>".join(literal(part) for part in short_name(name).split("\n"))
                for name in result.chain.nodes
            ],
            range=[float(places.min()) - 0.4, float(places.max()) + 0.4],
        ),
        axis(f"relative {moved} [1]", range=[-1.1, 1.1]),
        title=title,
        shapes=[level(0.0, GRAY)],
    )


def _nodes(
    still: tuple[float, ...], places: list[float], label: str, color: str, shared: Part
) -> Part:
    """Return crosses where a mode does not move, on the axis."""
    return dots(
        places,
        np.zeros(len(places)),
        label,
        color,
        f"{label}<br>node at %{{text}}",
        size=9,
        text=[number(place, 3) for place in still],
        marker={"symbol": "x-thin", "line": {"color": color, "width": 2}},
        showlegend=False,
        **shared,
    )


Array = NDArray[np.float64]

MODES_SHOWN = 10


def shaft_modes(modes: ShaftModes, radius: float, title: str) -> Figure:
    """Draw axial, torsional and lateral motion along the shaft, one elastic mode at a time.

    Parameters
    ----------
    modes : ShaftModes
    radius : float
        Crank radius: rotation about the shaft is shown as the displacement there [m].
    title : str

    Returns
    -------
    traces : list of dict
        Four for each mode; a menu chooses the mode.
    layout : dict
    """
    shown = range(modes.rigid, min(modes.rigid + MODES_SHOWN, len(modes.names)))
    order = np.argsort(modes.positions, kind="stable")
    places = 1e3 * modes.positions[order]
    traces: list[Part] = []
    labels = []
    for count, mode in enumerate(shown):
        motion = modes.motions[order, :, mode]
        curves = {
            "axial": motion[:, UZ],
            "torsional, at the crank radius": radius * motion[:, RZ],
            "lateral, x": motion[:, UX],
            "lateral, y": motion[:, UY],
        }
        every = np.concatenate(list(curves.values()))
        # The largest displacement is 1.
        largest = every[np.argmax(np.abs(every))] or 1.0
        labels.append(f"{modes.frequencies[mode]:.1f} Hz: {modes.label(mode)}")
        for (name, curve), color, dash in zip(
            curves.items(),
            (BLUE, ORANGE, GREEN, GREEN),
            ("solid", "solid", "solid", "dash"),
            strict=True,
        ):
            traces.append(
                line(
                    places,
                    curve / largest,
                    name,
                    color,
                    f"{name}<br>%{{y:.3f}} of the largest<br>at %{{x:.5g}} mm",
                    dash=dash,
                    mode="lines+markers",
                    marker={"size": 5},
                    visible=count == 0,
                )
            )
    turns = visibility_by_choice(np.repeat(np.arange(len(labels)), 4).tolist(), len(labels))
    return traces, layout(
        axis("position along the shaft [mm]"),
        axis("relative displacement [1]", range=[-1.1, 1.1]),
        title=title,
        shapes=[level(0.0)],
        updatemenus=[choice("mode", labels, [[{"visible": turn}] for turn in turns])],
    )


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
