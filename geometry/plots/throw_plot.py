"""A throw or a row of throws on the axes of a diagram, to scale."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from geometry.parts import Cylinder, Point, Sector, Slope, ThrowParts, WebPlate
from geometry.plots.dimension_lines import CENTER, JOURNAL_COLOR, View
from geometry.plots.views import draw_end, draw_side

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
ThrowView = Literal["side", "left end"]
Drawing = Callable[[View], None]
Part = TypeVar("Part", Cylinder, WebPlate, Slope, Sector)

# Paper left round the drawing, and on each side for ticks and labels [points].
EDGE, LABELS = 6.0, 46.0
# However crowded: dimensions leave at least this share of the axes to what is drawn.
LEAST_SHARE = 0.3
# Scales at which a drawing is tried: what a point on paper stands for, as shares of the length drawn.
TRIALS = (1.0 / 400.0, 1.0 / 300.0)
WIDTH, HEIGHT = 7.2, 5.0  # of a new figure [inch]
LABELED: dict[ThrowView, tuple[str, str]] = {
    "side": ("z, along the shaft [m]", "y, from the shaft to the pin [m]"),
    "left end": ("-x, across the crank plane [m]", "y, from the shaft to the pin [m]"),
}


def plot_throw(
    axes: "Axes | None", parts: ThrowParts, view: ThrowView, dimensions: bool, title: str
) -> "Axes":
    """Draw one view of a throw.

    Parameters
    ----------
    axes : matplotlib.axes.Axes, optional
        New ones by default.
    view : {"side", "left end"}
    dimensions : bool
        Write all dimensions in mm, as on a technical drawing; without them the axes have scales.

    Raises
    ------
    InputError
        If the view is neither.
    """
    if not isinstance(view, str) or view not in LABELED:
        raise InputError(
            f"view: given {view!r}; allowed are {', '.join(LABELED)}, because a drawing has these two."
        )
    draw = draw_side if view == "side" else draw_end
    axes = new_axes(axes, width=WIDTH, height=HEIGHT)
    _draw_to_fit(axes, lambda sheet: draw(sheet, parts, dimensions), parts.length, not dimensions)
    if dimensions:
        axes.set_axis_off()
        write_title(axes, f"{title}, {view} view, lengths in mm".replace("end view", "end"))
    else:
        write_title(axes, f"{title}, {view} view".replace("end view", "end"))
        _label(axes, *LABELED[view])
    return axes


def plot_throws(
    axes: "Axes | None",
    throws: Sequence[ThrowParts],
    crank_angles: Sequence[float],
    ends: Sequence[tuple[float, float, float]],
) -> "Axes":
    """Draw the side view of throws in a row.

    Parameters
    ----------
    crank_angles : sequence of n float
        Of each throw about +z [rad].
    ends : sequence of (diameter, start, end)
        Cylinders beyond the first and the last throw [m].
    """
    starts = np.concatenate([[0.0], np.cumsum([parts.length for parts in throws])])
    placed = [
        positioned_parts(parts, angle, float(start))
        for parts, angle, start in zip(throws, crank_angles, starts[:-1], strict=True)
    ]
    length = float(starts[-1])
    axes = new_axes(axes, width=9.6, height=4.2)

    def draw(view: View) -> None:
        for diameter, low, high in ends:
            radius = 0.5 * diameter
            view.surface(
                [(low, -radius), (high, -radius), (high, radius), (low, radius)], JOURNAL_COLOR
            )
        for parts in placed:
            draw_side(view, parts, dimensions=False)
        view.stroke([(min([0.0, *_edges(ends)]), 0.0), (max([length, *_edges(ends)]), 0.0)], CENTER)
        below = float(view.low[1]) - 10.0 * view.point
        for number, parts in enumerate(placed, start=1):
            middle = 0.5 * (parts.cylinders[0].start + parts.length)
            view.write(str(number), (middle, below, "center"))

    _draw_to_fit(axes, draw, length, labels=True)
    write_title(
        axes, f"Crankshaft of {len(throws)} throw{'s' if len(throws) > 1 else ''}, side view"
    )
    _label(axes, "z, along the shaft from the middle of the first main journal [m]", "y [m]")
    return axes


def positioned_parts(parts: ThrowParts, angle: float, along: float) -> ThrowParts:
    """Return a throw's parts turned by an angle [rad] about +z and moved along the shaft [m]."""
    cosine, sine = math.cos(angle), math.sin(angle)

    def turned(point: Point) -> Point:
        return (cosine * point[0] - sine * point[1], sine * point[0] + cosine * point[1])

    def moved(part: Part, *places: str, **changes: Any) -> Part:
        return replace(part, **{name: getattr(part, name) + along for name in places}, **changes)

    def cylinder(one: Cylinder) -> Cylinder:
        axes = {name: turned(getattr(one, name)) for name in ("axis", "bore_axis")}
        return moved(one, "start", "end", "bore_start", "bore_end", **axes)

    def web(one: WebPlate) -> WebPlate:
        return moved(
            one,
            "start",
            "end",
            foot=turned(one.foot),
            tip=turned(one.tip),
            slopes=tuple(moved(slope, "face") for slope in one.slopes),
            sector=one.sector and moved(one.sector, "start", "end"),
        )

    cylinders = tuple(map(cylinder, parts.cylinders))
    axes = {one.name: (one.axis, one.bore_axis) for one in cylinders}
    holes = tuple(hole.moved(angle, along, *axes[hole.journal]) for hole in parts.drillings)
    return ThrowParts(cylinders, tuple(map(web, parts.webs)), holes)


def _edges(ends: Sequence[tuple[float, float, float]]) -> list[float]:
    return [place for _, low, high in ends for place in (low, high)]


def _draw_to_fit(axes: "Axes", draw: Drawing, length: float, labels: bool) -> None:
    """Draw so that letters and arrows have their own size on the axes, whatever is drawn.

    Letters take their room first; what is drawn is as large as the rest lets it be.
    """
    from matplotlib.figure import Figure

    figure = axes.figure
    box = axes.get_position()
    whole = 72.0 / figure.dpi * np.array([figure.bbox.width, figure.bbox.height])
    size = whole * (box.width, box.height)
    if figure.get_layout_engine() is not None and len(figure.axes) == 1:
        # These axes will fill the figure, less what the labels take.
        size = whole - (LABELS if labels else 0.0, LABELS)
    room = size - 2.0 * EDGE

    def drawn(on: "Axes", point: float) -> View:
        view = View(on, point)
        draw(view)
        return view

    # Drawn at two scales on a sheet that nobody sees: what grows with the scale are letters.
    scales = np.array(TRIALS) * length
    sheet = Figure().add_subplot()
    first, second = (np.subtract(*_reach(drawn(sheet, float(scale)))) for scale in scales)
    letters = (second - first) / (scales[1] - scales[0])
    body = first - scales[0] * letters
    view = drawn(axes, float(np.max(body / np.maximum(room - letters, LEAST_SHARE * room))))
    margin = EDGE * view.point
    axes.set_xlim(view.low[0] - margin, view.high[0] + margin)
    axes.set_ylim(view.low[1] - margin, view.high[1] + margin)
    axes.set_aspect("equal")


def _reach(view: View) -> tuple[Array, Array]:
    return view.high, view.low


def _label(axes: "Axes", across: str, up: str) -> None:
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.grid(visible=False)
