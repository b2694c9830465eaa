"""Mode shapes of a chain over its nodes."""

import numpy as np

from crankbase.drawing.diagram_style import GRAY
from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.titles import short_name
from crankfem.analyses.vibration.modes import SourceResult, mode_label
from crankfem.report.interactive.style import (
    Figure,
    Part,
    axis,
    dots,
    layout,
    level,
    line,
    line_style,
    literal,
    number,
)
from dynamics.plots.mode_shapes import chain_places, crosses_on_axis

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
