"""One look for all interactive diagrams: that of the static ones.

Figures are plain dicts in plotly's form, so that making them needs no plotly.
"""

import math
import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Integers
from crankbase.diagrams import (
    GRAY,
    STYLE,
    Band,
    Diagram,
    Dots,
    Limits,
    Line,
    Mark,
    Note,
    bracketed,
    display_unit,
    title_lines,
)
from crankbase.quantity import format_number
from regression.plans.factors import Factor

DIGITS = 5


def rounded(values: ArrayLike, digits: int = DIGITS) -> list[float | int | None]:
    """Round to significant digits, for JSON.

    Parameters
    ----------
    values : array_like of shape (n,)
    digits : int
        That stay.

    Returns
    -------
    list of n numbers
        None where a value is not finite; whole numbers as int, which saves their ".0".

    Examples
    --------
    >>> rounded([1234567.0, 0.0123456789, 2.0, float("inf")])
    [1234600, 0.012346, 2, None]
    """
    numbers = np.asarray(values, dtype=np.float64).tolist()
    return [shortest(float(f"{value:.{digits}g}")) for value in numbers]


def shortest(value: float) -> float | int | None:
    """Return a number as JSON writes it shortest: a whole one as int, None if it is not finite."""
    if not math.isfinite(value):
        return None
    return int(value) if value.is_integer() else value


# Plain JSON content in plotly's form.
Part = dict[str, Any]
# The traces and the layout of a figure.
Figure = tuple[list[Part], Part]

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
TEXT_COLOR, QUIET_COLOR = "#1d2733", "#5b6875"
GRID_COLOR = STYLE["grid.color"]
HEIGHT = 430  # pixels
TITLE_LINE = 20  # px that a further line of a title takes


def axis(title: str, **more: Any) -> Part:
    """Return an axis with a thin grid; its title ends with the unit."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": GRID_COLOR,
        "gridwidth": 1,
        "zeroline": False,
        "showline": True,
        "linecolor": GRAY,
        "linewidth": 1,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": GRAY,
        "automargin": True,
    } | more


def layout(x: Part, y: Part, *, title: str = "", height: int = HEIGHT, **more: Any) -> Part:
    """Return the layout of a diagram with two axes; the title is shown as it is."""
    return plain_layout(title, height) | {"xaxis": x, "yaxis": y} | more


def plain_layout(title: str, height: int = HEIGHT) -> Part:
    """Return what the layouts of all figures share; the title is shown as it is."""
    lines = title_lines(title)
    return {
        "title": {
            "text": "<br>".join(map(literal, lines)),
            "font": {"size": 15},
            "x": 0.0,
            "xanchor": "left",
            "xref": "container",
            "y": 1.0,
            "yanchor": "top",
            # plotly moves the first of several lines up.
            "pad": {"l": 8, "t": 10 + TITLE_LINE * (len(lines) - 1)},
        },
        "font": {"family": FONT, "size": 13, "color": TEXT_COLOR},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "height": height,
        "margin": {"l": 64, "r": 16, "t": 44 + TITLE_LINE * (len(lines) - 1), "b": 52},
        "hovermode": "closest",
        "hoverlabel": {
            "bgcolor": "white",
            "bordercolor": GRAY,
            "font": {"family": FONT, "size": 13, "color": TEXT_COLOR},
            "align": "left",
        },
        "legend": {
            "font": {"size": 12},
            "bgcolor": "rgba(255,255,255,0.8)",
            "tracegroupgap": 2,
            "traceorder": "normal",
        },
    }


def line(
    x: ArrayLike,
    y: ArrayLike,
    name: str,
    color: str,
    hover: str,
    *,
    width: float = 1.6,
    dash: str = "solid",
    **more: Any,
) -> Part:
    """Return a curve; values that are not finite leave gaps.

    Parameters
    ----------
    x, y : array_like of shape (n,)
        In the units of the axes.
    name : str
        In the legend, shown as it is.
    hover : str
        What is told of a point, in plotly's template language, lines apart by ``<br>``.
    width : float
        In pixels.
    **more
        Further entries of the trace.
    """
    return {
        "type": "scatter",
        "mode": "lines",
        "x": rounded(x),
        "y": rounded(y),
        "name": literal(name),
        "line": {"color": color, "width": width, "dash": dash},
        "hovertemplate": hover + "<extra></extra>",
    } | more


def dots(
    x: ArrayLike, y: ArrayLike, name: str, color: str, hover: str, *, size: Any = 7.0, **more: Any
) -> Part:
    """Return points; arguments as for `line`, sizes in pixels."""
    marker = {"color": color, "size": size, "line": {"color": "white", "width": 0.7}}
    return {
        "type": "scatter",
        "mode": "markers",
        "x": rounded(x),
        "y": rounded(y),
        "name": literal(name),
        "marker": marker | more.pop("marker", {}),
        "hovertemplate": hover + "<extra></extra>",
    } | more


def shape(
    kind: str,
    low: tuple[float, float],
    high: tuple[float, float],
    axes: tuple[str, str] = ("x", "y"),
    **more: Any,
) -> Part:
    """Return a line, "rect" or "circle" from its lower left to its upper right corner, below everything."""
    return {
        "type": kind,
        "xref": axes[0],
        "yref": axes[1],
        "x0": float(low[0]),
        "x1": float(high[0]),
        "y0": float(low[1]),
        "y1": float(high[1]),
        "line": {"color": GRAY, "width": 1},
        "layer": "below",
    } | more


def band(low: float, high: float, color: str, **more: Any) -> Part:
    """Return a shaded range of x."""
    look = {"fillcolor": color, "line": {"width": 0}}
    return shape("rect", (low, 0.0), (high, 1.0), ("x", "paper"), **look, **more)


def level(number: int = 1) -> Part:
    """Return a line at zero across the whole diagram of the first or a further vertical axis."""
    across = "x domain" if number == 1 else f"x{number} domain"
    return shape("line", (0.0, 0.0), (1.0, 0.0), (across, "y" if number == 1 else f"y{number}"))


def note(text: str, *, size: int = 12, color: str = QUIET_COLOR, **place: Any) -> Part:
    """Return a text at a place, without an arrow."""
    return {"text": text, "showarrow": False, "font": {"size": size, "color": color}} | place


def choice(name: str, labels: Sequence[str], changes: Sequence[list[Any]]) -> Part:
    """Return a menu; each label comes with the arguments of plotly's update."""
    buttons = [
        {"method": "update", "label": label, "args": change}
        for label, change in zip(labels, changes, strict=True)
    ]
    return {
        "name": name,
        "type": "dropdown",
        "buttons": buttons,
        "active": 0,
        "showactive": True,
        "x": 1.0,
        "xanchor": "right",
        "y": 1.02,
        "yanchor": "bottom",
        "bgcolor": "white",
    }


def visibility_by_choice(owners: Sequence[int], count: int) -> list[list[bool]]:
    """Return which traces are visible under each of `count` choices, by the choice they belong to."""
    return [[owner == number for owner in owners] for number in range(count)]


def literal(text: str) -> str:
    """Write text that is shown as it is: plotly would read markup, and templates, out of it.

    Examples
    --------
    >>> literal("<b>R&D</b> %{x}")
    '&lt;b&gt;R&amp;D&lt;/b&gt; %&#123;x}'
    """
    return escape(text, quote=False).replace("%{", "%&#123;")


def number(value: float, digits: int = 4) -> str:
    """Write a number for a hover text or a legend; minus zero as zero.

    Examples
    --------
    >>> number(1949.2, 3)
    '1949'
    """
    return format_number(value + 0.0, digits)


def marked_up(text: str) -> str:
    r"""Write the mathematics of a label, as matplotlib reads it, in plotly's markup.

    Examples
    --------
    >>> marked_up(r"$L_{\mathrm{shm}}$ by FE [$10^{-9}$ m/N]")
    'L<sub>shm</sub> by FE [10<sup>-9</sup> m/N]'
    """
    text = re.sub(r"\$(\w+)\$", r"\1", text)
    text = re.sub(r"\$(\w+)_\{\\mathrm\{(\w+)\}\}\$", r"\1<sub>\2</sub>", text)
    return re.sub(r"\$(\w+)\^\{(-?\w+)\}\$", r"\1<sup>\2</sup>", text)


def with_unit(number: str, unit: str) -> str:
    """Write a number, or what stands for one, before a unit that may begin with a power of ten."""
    return f"{number}·{unit}" if unit.startswith("10<") else f"{number} {unit}"


def design_texts(factors: tuple[Factor, ...], values: Array) -> list[str]:
    """Return a text for each design (n, k) that says its dimensions, one a line."""
    columns = []
    for place, factor in enumerate(factors):
        text, size = display_unit(factor.unit)
        shown = values[:, place] if factor.labels else values[:, place] / size
        unit = marked_up(text) if factor.unit else ""
        name, labels = literal(factor.name.replace("_", " ")), [*map(literal, factor.labels)]
        columns.append(
            [
                f"{name} " + (labels[round(value)] if labels else f"{value:.5g} {unit}".strip())
                for value in shown.tolist()
            ]
        )
    return ["<br>".join(lines) for lines in zip(*columns, strict=True)]


def visible_points(x: Array, y: Array, tolerance: float, step: float = np.inf) -> Integers:
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


# Sizes of dots [pixels]: of those without weights by symbol, and at weights 0 and 1.
DOT_SIZES = {"o": 7.0, "x": 9.0, "_": 22.0}
LEAST_DOT, DOT_GROWTH = 5.0, 12.0
SYMBOLS = {
    "o": "circle",
    "D": "diamond",
    "O": "circle-open",
    "X": "x",
    "x": "x-thin",
    "_": "line-ew-open",
}


def diagram_figure(diagram: Diagram, title: str, height: int = HEIGHT) -> Figure:
    """Return the traces and the layout of a described diagram."""
    shapes = _described_bands((*diagram.bands, *diagram.marks))
    shapes += [
        shape("circle" if part.round else "rect", part.low, part.high, fillcolor=part.color)
        for part in diagram.shapes
    ]
    x, y = _described_axis(diagram.x), _described_axis(diagram.y)
    if diagram.level or diagram.equal:
        shapes.append(level())
    if diagram.equal:
        shapes.append(shape("line", (0.0, 0.0), (0.0, 1.0), ("x", "y domain")))
        x |= {"constrain": "domain"}
        y |= {"constrain": "domain", "scaleanchor": "x"}
    made = layout(
        x,
        y,
        title=title,
        height=height,
        shapes=shapes,
        annotations=[_described_note(text) for text in diagram.notes],
    )
    if any(dots.weights is not None for dots in diagram.dots):
        # Dots of all sizes are one size in the legend.
        made["legend"] |= {"itemsizing": "constant"}
    return described_traces(diagram), made


def _described_bands(described: Iterable[Band | Mark]) -> list[Part]:
    shapes = []
    named: set[str] = set()
    for mark in described:
        # The first of several shapes stands in the legend, from where it switches all.
        legend: Part = {
            "name": mark.name,
            "legendgroup": mark.name,
            "showlegend": mark.name not in named,
        }
        named.add(mark.name)
        if isinstance(mark, Band):
            shapes.append(band(mark.low, mark.high, mark.color, **legend))
            continue
        look = {"color": mark.color, "width": 1, "dash": "dot"}
        place = (mark.place, 0.0), (mark.place, 1.0)
        shapes.append(shape("line", *place, ("x", "paper"), line=look, layer="above", **legend))
    return shapes


def _described_axis(limits: Limits) -> Part:
    more: Part = {}
    if limits.ends is not None:
        to_curves = limits.ends[1] is None
        more = {"rangemode": "tozero"} if to_curves else {"range": list(limits.ends)}
    if limits.step:
        more |= {"dtick": limits.step, "tick0": 0}
    if limits.ticks is not None:
        names = ["<br>".join(map(literal, name.split("\n"))) for name in limits.ticks.values()]
        more |= {"tickvals": list(limits.ticks), "ticktext": names}
    return axis(marked_up(limits.label), **more)


def _described_note(described: Note) -> Part:
    if described.side == "line":
        # Above the dots of weak resonances on the line, and orders do not run through it.
        look: Part = {
            "xanchor": "left",
            "yanchor": "bottom",
            "yshift": 5,
            "bgcolor": "rgba(255, 255, 255, 0.85)",
        }
        return note(described.text, color=described.color, x=described.x, y=described.y, **look)
    look = {
        "middle": {},
        "right": {"xanchor": "left"},
        "above": {"xanchor": "center", "yanchor": "bottom"},
    }[described.side]
    return note(described.text, size=11, color=TEXT_COLOR, x=described.x, y=described.y, **look)


def described_traces(diagram: Diagram) -> list[Part]:
    """Return the traces of a described diagram, lines before dots."""
    traces: list[Part] = []
    named: set[tuple[str, str]] = set()
    parts: list[Line | Dots] = [*diagram.lines, *diagram.dots]
    values = (
        f"<br>%{{x:.5g}} {bracketed(diagram.x.label)}<br>%{{y:.4g}} {bracketed(diagram.y.label)}"
    )
    top = diagram.y.ends and diagram.y.ends[1]
    if top is None:
        tops = (float(np.nanmax(np.abs(curve.y), initial=0.0)) for curve in diagram.lines)
        top = max(tops, default=0.0)
    for drawn in parts:
        more: Part = {} if drawn.main else {"visible": "legendonly"}
        if drawn.group:
            key = (drawn.group, drawn.name)
            more |= {"legendgroup": drawn.group, "showlegend": key not in named}
            named.add(key)
        if drawn.numbers:
            more["customdata"] = drawn.numbers
        if isinstance(drawn, Line):
            x, y = np.asarray(drawn.x), np.asarray(drawn.y)
            if not drawn.hover:
                kept = visible_points(x, y, UNSEEN * top, HOVER_STEP * float(np.ptp(x)))
                x, y = x[kept], y[kept]
            if drawn.marker:
                more |= {"mode": "lines+markers", "marker": {"size": round(2.0 * drawn.marker)}}
            if drawn.texts:
                more["text"] = [literal(text) for text in drawn.texts]
            width = round(WIDER * drawn.width, 2)
            traces.append(
                line(
                    x,
                    y,
                    drawn.name,
                    drawn.color,
                    drawn.hover or literal(drawn.name) + values,
                    width=width,
                    dash=drawn.dash,
                    **more,
                )
            )
            continue
        symbols = [SYMBOLS[symbol] for symbol in drawn.symbols]
        more["marker"] = {
            "symbol": symbols[0] if len(symbols) == 1 and drawn.weights is None else symbols
        }
        if drawn.symbols in ("x", "_", "O"):
            more["marker"]["line"] = {"color": drawn.color, "width": 2}
        size: Any = DOT_SIZES.get(drawn.symbols, 7.0)
        if drawn.weights is not None:
            size = [round(LEAST_DOT + DOT_GROWTH * weight, 1) for weight in drawn.weights]
        if drawn.texts:
            more["text"] = list(drawn.texts)
        traces.append(
            dots(
                drawn.x,
                drawn.y,
                drawn.name,
                drawn.color,
                drawn.hover or literal(drawn.name) + values,
                size=size,
                **more,
            )
        )
    return traces
