"""Described curves on a screen."""

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.curves import Band, Curves, Mark
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

Array = NDArray[np.float64]


def visible_points(x: Array, y: Array, tolerance: float, step: float = np.inf) -> NDArray[np.int64]:
    """Choose the visible points of a curve: those without which it would look different.

    Parameters
    ----------
    x, y : (n,) arrays
        x ascending; y may have gaps (nan).
    tolerance : float
        By how much the curve through the chosen points may miss a point in y.
    step : float
        Largest distance in x between chosen points, so that there is always one to hover on.

    Returns
    -------
    (m,) array of int
        Ascending. Ends of the curve and of gaps stay, and of each gap its first point.

    Notes
    -----
    A piece is split at the point that is missed most, until none is missed by more than the tolerance
    (D. Douglas, T. Peucker, The Canadian Cartographer 10, 1973, 112-122, with distances in y).
    """
    known = np.isfinite(y)
    # Each point without a value next to one with a value keeps the gap.
    kept = ~known & np.append(True, known[:-1])
    edges = np.flatnonzero(np.diff(np.concatenate(([False], known, [False])).astype(np.int8)))
    pieces = [
        (int(first), int(last) - 1) for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]
    while pieces:
        first, last = pieces.pop()
        kept[[first, last]] = True
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        slope = (y[last] - y[first]) / (x[last] - x[first])
        missed = np.abs(y[inner] - y[first] - slope * (x[inner] - x[first]))
        if missed.max() > tolerance:
            middle = first + 1 + int(np.argmax(missed))
        elif x[last] - x[first] > step:
            middle = first + 1 + int(np.argmin(np.abs(x[inner] - 0.5 * (x[first] + x[last]))))
        else:
            continue
        pieces += [(first, middle), (middle, last)]
    return np.flatnonzero(kept)


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
        legend = {"name": one.name, "legendgroup": one.name, "showlegend": one.name not in named}
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
