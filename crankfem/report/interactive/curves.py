"""Described curves on a screen."""

import numpy as np

from crankbase.drawing.curves import Band, Curves, Mark
from crankfem.report.interactive.curve_decimation import visible_points
from crankfem.report.interactive.style import (
    Figure,
    Part,
    axis,
    band,
    dots,
    layout,
    level,
    line,
    literal,
)

# Shares of the height that a thinned curve may miss, and of the width without a point to hover on.
UNSEEN, HOVER_STEP = 5e-4, 1.0 / 80.0
# Pixels beside a point on paper.
WIDER = 1.2


def figure_of(curves: Curves, title: str) -> Figure:
    """Return the traces and the layout of described curves.

    Orders come last in the legend, and behind them what is no main curve and waits to be requested.
    """
    along, (x_unit, y_unit) = curves.x, curves.units
    top = curves.top
    if top is None:
        top = max(float(np.nanmax(np.abs(own.values), initial=0.0)) for own in curves.series)
    traces: list[Part] = []
    told = f"<br>%{{x:.5g}} {x_unit}<br>%{{y:.4g}} {y_unit}"
    for own in sorted(curves.series, key=lambda one: (not one.main, one.role == "order")):
        kept = visible_points(along, own.values, UNSEEN * top, HOVER_STEP * float(np.ptp(along)))
        color, dash, width = own.line_style
        traces.append(
            line(
                along[kept],
                own.values[kept],
                own.name,
                color,
                literal(own.name) + told,
                width=WIDER * width,
                dash=dash,
                visible=True if own.main else "legendonly",
            )
        )
    for x, y, name, color in curves.dots:
        traces.append(dots(x, y, name, color, literal(name) + told))
    shapes: list[Part] = [level(0.0)] if curves.signed else []
    named: set[str] = set()
    drawn: list[Band | Mark] = [*curves.bands, *curves.marks]
    for one in drawn:
        # The first of several shapes stands in the legend, from where it switches all.
        legend = {
            "name": one.name,
            "legendgroup": one.name,
            "showlegend": one.name not in named,
        }
        named.add(one.name)
        shapes.append(
            _upright(one, **legend)
            if isinstance(one, Mark)
            else band(one.low, one.high, one.color, **legend)
        )
    ends = {} if curves.x_range is None else {"range": list(curves.x_range)}
    ticks = {} if curves.x_step is None else {"dtick": curves.x_step, "tick0": 0}
    if curves.signed:
        height: Part = {}
    elif curves.top is None:
        height = {"rangemode": "tozero"}
    else:
        height = {"range": [0.0, curves.top]}
    return traces, layout(
        axis(curves.x_label, **ends, **ticks),
        axis(curves.y_label, **height),
        title=title,
        shapes=shapes,
    )


def _upright(mark: Mark, **more: object) -> Part:
    return {
        "type": "line",
        "xref": "x",
        "yref": "paper",
        "x0": mark.place,
        "x1": mark.place,
        "y0": 0,
        "y1": 1,
        "line": {"color": mark.color, "width": 1, "dash": "dot"},
    } | more
