"""A throw or a row of throws on the axes of a diagram, to scale, as a small SVG, and meshed."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from html import escape
from operator import itemgetter
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Integers
from crankbase.choices import check_choice
from crankbase.diagrams import GRAY, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes
from geometry.parts import Cylinder, Point, Sector, Slope, ThrowParts, WebPlate
from geometry.plots.dimension_lines import (
    CENTER,
    DIMENSION,
    INK,
    JOURNAL_COLOR,
    OUTLINE,
    TEXT_SIZE,
    Callout,
    Linear,
    Place,
    Style,
    View,
)
from geometry.plots.views import draw_end, draw_side

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
    axes: Axes | None, parts: ThrowParts, view: ThrowView, dimensions: bool, title: str
) -> Axes:
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
    check_choice("view", view, LABELED, "a drawing has these two")
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
    axes: Axes | None,
    throws: Sequence[ThrowParts],
    crank_angles: Sequence[float],
    ends: Sequence[tuple[float, float, float]],
) -> Axes:
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

    cylinders = tuple(
        moved(
            cylinder,
            "start",
            "end",
            "bore_start",
            "bore_end",
            axis=turned(cylinder.axis),
            bore_axis=turned(cylinder.bore_axis),
        )
        for cylinder in parts.cylinders
    )
    webs = tuple(
        moved(
            web,
            "start",
            "end",
            foot=turned(web.foot),
            tip=turned(web.tip),
            slopes=tuple(moved(slope, "face") for slope in web.slopes),
            sector=web.sector and moved(web.sector, "start", "end"),
        )
        for web in parts.webs
    )
    axes = {cylinder.name: (cylinder.axis, cylinder.bore_axis) for cylinder in cylinders}
    holes = tuple(hole.moved(angle, along, *axes[hole.journal]) for hole in parts.drillings)
    return ThrowParts(cylinders, webs, holes)


def _edges(ends: Sequence[tuple[float, float, float]]) -> list[float]:
    return [place for _, low, high in ends for place in (low, high)]


def _draw_to_fit(axes: Axes, draw: Drawing, length: float, labels: bool) -> None:
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

    def drawn(on: Axes, point: float) -> View:
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


def _label(axes: Axes, across: str, up: str) -> None:
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.grid(visible=False)


OutlineView = Literal["side", "front"]
DRAWINGS: dict[str, tuple[Callable[[View, ThrowParts, bool], None], str]] = {
    "side": (draw_side, "Side view of the throw, the shaft from left to right"),
    "front": (draw_end, "Front view of the throw, from its left end"),
}
# A point on paper stands for this share of the throw's length.
POINT, LETTERED_POINT = 1.0 / 300.0, 1.0 / 200.0
MARGIN = 6.0  # points
DIGITS = 5  # of a coordinate, in the thousandth part of a millimeter for a throw of a hundred


class _SvgView(View):
    """A view that is written as SVG at once, without matplotlib; of dimensions it has the letters."""

    def __init__(self, point: float, letters: Mapping[str, str]) -> None:
        nobody: Any = None
        super().__init__(nobody, point, lettered=True)
        self._letters = letters
        self._fields: dict[str, str] = {}
        self._shapes: list[tuple[float, str]] = []

    def named(self, field: str) -> str:
        """Return the letter of a dimension, "" if it has none."""
        name, half, _ = field.strip().partition(" / 2")
        letter = self._letters.get(name, "")
        if letter:
            letter += half.replace(" ", "")
            self._fields[letter] = name
        return letter

    def _letter(self, text: str) -> str:
        """Return the letter with which a text begins, "" for others, such as names of webs alone."""
        return max((known for known in self._fields if text.startswith(known)), key=len, default="")

    def stack(self, dimensions: Sequence[Linear], axis: int, side: int) -> None:
        """Draw distances that have letters."""
        super().stack([linear for linear in dimensions if self._letter(linear.text)], axis, side)

    def callouts(self, texts: Sequence[Callout]) -> None:
        """Write letters beside the view."""
        super().callouts([callout for callout in texts if self._letter(callout.text)])

    def leader(self, tip: Point, step: Point, text: str) -> None:
        """Draw a leader to a letter."""
        if self._letter(text):
            super().leader(tip, step, text)

    def angle(self, *_: Any) -> None:
        """Leave out angles, which have no letters."""

    def head(self, corners: Array) -> None:
        """Fill the triangle of an arrowhead."""
        self._add(corners, 3.0, f'fill="{DIMENSION["color"]}"', closed=True)

    def stroke(self, points: ArrayLike, style: Style = OUTLINE, closed: bool = False) -> None:
        """Draw a line through points."""
        path = np.asarray(points, dtype=float)
        dashes = ""
        if "dashes" in style:
            dashes = f' stroke-dasharray="{" ".join(f"{part:g}" for part in style["dashes"])}"'
        self._add(
            path,
            style.get("zorder", 3.0),
            f'fill="none" stroke="{style["color"]}" stroke-width="{style["linewidth"]:g}"{dashes}',
            closed,
        )

    def surface(self, points: ArrayLike, color: str, edge: float = 1.0) -> None:
        """Fill a polygon that later ones cover."""
        stroke = f' stroke="{INK}" stroke-width="{edge * OUTLINE["linewidth"]:g}"' if edge else ""
        self._add(np.asarray(points, dtype=float), 1.0, f'fill="{color}"{stroke}', closed=True)

    def write(self, text: str, *places: Place, upright: bool = False, **style: Any) -> int:
        """Write at the first place that is clear; without letters at the first."""
        if self._letters:
            return super().write(text, *places, upright=upright, **style)
        self.put(text, places[0], upright, style)
        return 0

    def put(self, text: str, at: Place, upright: bool, style: Style) -> None:
        """Write at a place; a letter has the name of its field."""
        x, y, side = at
        size = style.get("fontsize", TEXT_SIZE) * self.point
        letter = self._letter(text)
        base, _, index = letter.partition("_")
        shown = escape(text)
        if index:
            small = f'<tspan dy=".25em" font-size="70%">{index}</tspan>'
            shown = f"{base}{small}{escape(text.removeprefix(letter))}"
        anchor = {"left": "start", "center": "middle", "right": "end"}[side]
        turned = f' transform="rotate(-90 {x:.{DIGITS}g} {-y:.{DIGITS}g})"' if upright else ""
        of = f' data-field="{self._fields[letter]}"' if letter else ""
        self._shapes.append(
            (
                5.0,
                f'<text x="{x:.{DIGITS}g}" y="{-y:.{DIGITS}g}" font-size="{size:.3g}" dy=".35em" '
                f'text-anchor="{anchor}" font-family="sans-serif"{turned}{of}>{shown}</text>',
            )
        )

    def _add(self, path: Any, layer: float, look: str, closed: bool) -> None:
        self._reach(path)
        pieces, drawn = [], False
        for x, y in path.tolist():
            if x != x:  # a gap
                drawn = False
                continue
            pieces.append(f"{'L' if drawn else 'M'}{x:.{DIGITS}g} {0.0 - y:.{DIGITS}g}")
            drawn = True
        end = "Z" if closed else ""
        self._shapes.append(
            (layer, f'<path vector-effect="non-scaling-stroke" d="{"".join(pieces)}{end}" {look}/>')
        )

    def text(self, label: str) -> str:
        margin = MARGIN * self.point
        low, high = self.low - margin, self.high + margin
        width, height = high - low
        # Sorted by layer, else in the order in which they were drawn.
        shapes = "".join(shape for _, shape in sorted(self._shapes, key=itemgetter(0)))
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="{escape(label)}" '
            f'viewBox="{low[0]:.6g} {-high[1]:.6g} {width:.6g} {height:.6g}">'
            f"{shapes}</svg>"
        )


def outline_svg(
    parts: ThrowParts, view: OutlineView = "side", letters: Mapping[str, str] | None = None
) -> str:
    """Draw one view of a throw to scale.

    Parameters
    ----------
    view : {"side", "front"}
        From the side, z to the right and y up; or from the left end, where x points to the left.
    letters : mapping of str to str, optional
        Symbols by field of the throw, such as "D_km": dimensions that have one are drawn with it, and its
        text has the attribute ``data-field``. Without them no dimensions are drawn.

    Returns
    -------
    str
        An SVG whose units are meters.

    Raises
    ------
    InputError
        If the view is neither.
    """
    check_choice("view", view, DRAWINGS, "a throw is drawn from these two")
    draw, name = DRAWINGS[view]
    drawn = _SvgView((LETTERED_POINT if letters else POINT) * parts.length, letters or {})
    draw(drawn, parts, bool(letters))
    return drawn.text(name)


OUTSIDE, CUT = (0.78, 0.84, 0.90), (0.96, 0.80, 0.60)
LINE, LINE_WIDTH = "#44525f", 0.25
# A face that looks past the light has this share of its color.
DARKEST = 0.7
LIGHT = (-0.45, 0.65, 1.0)  # to the right, up and towards the eye of the view
ARROW = 0.14  # length of the frame's arrows as a share of the view's width


def plot_mesh(
    axes: Axes | None,
    points: Array,
    outside: Integers,
    cuts: Mapping[str, Integers],
    eye: Array,
    title: str,
) -> Axes:
    """Draw the facets that look towards the eye, the farthest first.

    Parameters
    ----------
    points : (n, 3) array
        [m]
    outside : (k, 3) array of int
        Corners of the facets, counterclockwise from outside.
    cuts : mapping of str to (k, 3) array of int
        Facets on planes of symmetry, by the plane's name.
    eye : (3,) array
        Direction to the eye.

    Raises
    ------
    InputError
        If the direction is not three finite numbers, or along y.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Patch

    frame = view_frame(eye)
    facets = np.concatenate([outside, *cuts.values()])
    is_cut = np.arange(len(facets)) >= len(outside)
    seen = points @ frame.T  # to the right, up, towards the eye
    corners = seen[facets]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    front = np.flatnonzero(normals[:, 2] > 0.0)
    order = front[np.argsort(corners[front, :, 2].mean(axis=1), kind="stable")]
    light = np.array(LIGHT) / np.linalg.norm(LIGHT)
    bright = DARKEST + (1.0 - DARKEST) * np.clip(normals[order] @ light, 0.0, 1.0)
    colors = np.where(is_cut[order, None], CUT, OUTSIDE) * bright[:, None]

    axes = new_axes(axes, width=6.4, height=5.6)
    axes.add_collection(
        PolyCollection(
            list(corners[order, :, :2]), facecolors=colors, edgecolors=LINE, linewidths=LINE_WIDTH
        )
    )
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    margin = 0.04 * float(np.max(high - low))
    # The throw's directions x, y, z in a corner.
    corner, width = low - margin, float(high[0] - low[0])
    for name, direction in zip("xyz", frame.T, strict=True):
        tip = corner + ARROW * width * direction[:2]
        text = corner + 1.25 * ARROW * width * direction[:2]
        axes.annotate(
            "",
            xy=(float(tip[0]), float(tip[1])),
            xytext=(float(corner[0]), float(corner[1])),
            arrowprops={"arrowstyle": "-|>", "color": GRAY, "linewidth": 1.0, "shrinkB": 0.0},
        )
        axes.text(float(text[0]), float(text[1]), name, ha="center", va="center", fontsize=9)
    axes.set_xlim(low[0] - 4.0 * margin, high[0] + margin)
    axes.set_ylim(low[1] - 4.0 * margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("across the view [m]")
    axes.set_ylabel("up the view [m]")
    write_title(axes, title)
    if cuts:
        cut = Patch(facecolor=CUT, edgecolor=LINE, label=f"cut: {', '.join(cuts)}")
        axes.legend(
            frameon=False, handles=[cut], fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0)
        )
    return axes


def view_frame(eye: Array) -> Array:
    """Directions to the right, up and towards the eye (3, 3), the crank upright.

    Raises
    ------
    InputError
        If the direction to the eye is not three finite numbers, or along y.
    """
    usable = eye.shape == (3,) and bool(np.all(np.isfinite(eye)))
    right = np.cross((0.0, 1.0, 0.0), eye) if usable else np.zeros(3)
    if float(np.linalg.norm(right)) <= 1e-6 * float(np.linalg.norm(eye)):
        raise InputError(
            f"eye: given {eye.tolist()}; allowed are three finite numbers not all along y, because the crank "
            "is upright in the view."
        )
    towards = eye / np.linalg.norm(eye)
    right = right / np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])
