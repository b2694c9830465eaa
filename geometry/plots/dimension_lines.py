"""A view of a technical drawing: outlines, center lines, and dimensions that keep clear of each other.

Lengths in meters are the drawing's own coordinates; sizes of arrows, gaps and letters are in points
on paper, so that every drawing reads alike whatever is drawn.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Flags
from crankbase.diagrams import BLUE
from crankbase.frames import Axes
from geometry.parts import Arc, Cylinder, Sector, WebPlate

Point = tuple[float, float]
Coordinates = float | Sequence[float] | Array


def place(web: WebPlate, u: Coordinates, v: Coordinates) -> Array:
    """Points (n, 2), x and y, of a web's coordinates u and v."""
    x, y = web.direction
    coordinates = np.column_stack(np.broadcast_arrays(u, v))
    return np.asarray(web.foot + coordinates @ np.array([(y, -x), (x, y)]))


def at_smaller_x(web: WebPlate, u: float, v: float) -> Point:
    """The one of the points (u, v) and (-u, v) that is near in the side view, right in the other."""
    x, y = min(place(web, [u, -u], [v, v]).tolist())
    return (x, y)


def outline_uv(web: WebPlate) -> Array:
    """Whole outline of a web in its coordinates u and v."""
    half = web.outline.polygon(48)
    return np.vstack([half, half[::-1] * (-1.0, 1.0)])


def sector_arc(sector: Sector, radius: float) -> Array:
    """Arc of a counterweight at a radius, in its web's coordinates u and v."""
    angles = np.linspace(-sector.half_angle, sector.half_angle, 97)
    return radius * np.column_stack([np.sin(angles), -np.cos(angles)])


def sector_uv(sector: Sector) -> Array:
    """Outline of a counterweight in its web's coordinates u and v."""
    inner, outer = (sector_arc(sector, r) for r in (sector.inner_radius, sector.outer_radius))
    sides = [np.linspace(inner[k], outer[k], 60) for k in (0, -1)]
    return np.vstack([sides[0], outer, sides[1][::-1], inner[::-1]])


def outline(web: WebPlate) -> Array:
    """Whole outline of a web, (n, 2) in x and y."""
    return place(web, *outline_uv(web).T)


def weight_outline(web: WebPlate, sector: Sector) -> Array:
    """Outline of a web's counterweight, (n, 2) in x and y."""
    return place(web, *sector_uv(sector).T)


def silhouette(web: WebPlate) -> Array:
    """Outline of a web with its counterweight, their points together, (n, 2) in x and y."""
    if web.sector is None:
        return outline(web)
    return np.vstack([outline(web), weight_outline(web, web.sector)])


def faces_at(web: WebPlate, v: float) -> Point:
    """Where along z a web starts and ends at one height v."""
    start, end = web.faces(np.array([v]))
    return float(start[0]), float(end[0])


def half_width(web: WebPlate, v: float) -> float:
    """Half of a web's width at one height v."""
    return float(web.outline.half_width(np.array([v]))[0])


def highest_full_width(web: WebPlate) -> float:
    """Height v, nearest to the tip, where a web has its full width."""
    centers = [p.center[1] for p in web.outline.pieces if isinstance(p, Arc)]
    within = [v for v in centers if web.outline.foot < v < web.outline.tip]
    heights = np.unique([*web.outline.heights, *within])
    widths = web.outline.half_width(heights)
    return float(heights[widths >= widths.max() * (1.0 - 1e-9)].max())


def distances_to_ends(web: WebPlate) -> Point:
    """Distances of a web's ends from the axes that it joins, the foot's first."""
    return (-web.outline.foot, web.outline.tip - web.distance)


def on_weight(web: WebPlate, points: Array) -> Flags:
    """Which points (u, v) of a web lie on its counterweight."""
    if web.sector is None:
        return np.zeros(len(points), dtype=bool)
    angle = np.arctan2(np.abs(points[:, 0]), -points[:, 1])
    reach = np.hypot(*points.T)
    return np.asarray((angle < web.sector.half_angle) & (reach > web.sector.inner_radius))


def has_flush_weight(web: WebPlate) -> bool:
    """Whether a web and its counterweight have one face towards the left end."""
    return web.sector is not None and web.sector.start == web.start


def bore_offset(cylinder: Cylinder) -> float:
    """How far a bore lies off its journal's axis, positive away from the shaft or to the first pin."""
    direction = cylinder.axis if cylinder.is_pin else (0.0, 1.0)
    off = np.subtract(cylinder.bore_axis, cylinder.axis)
    return round(float(off @ direction) / math.hypot(*direction), 12)


def circle(center: Point, radius: float) -> Array:
    """Points of a circle, (n, 2) in x and y."""
    angles = np.linspace(0.0, 2.0 * math.pi, 121)
    return np.array(center) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def mirror(points: ArrayLike) -> Array:
    """Points as seen from the left end, where x points to the left."""
    return np.asarray(points, dtype=float) * (-1.0, 1.0)


Box = tuple[float, float, float, float]
Side = Literal["left", "center", "right"]
Place = tuple[float, float, Side]
Style = Mapping[str, Any]

FONT = "DejaVu Sans"  # comes with matplotlib and has all signs
TEXT_SIZE = 8.0
LINE_HEIGHT = 1.35  # of the text size
LANE = 19.0  # from one dimension line to the next
ARROW, ARROW_HALF_WIDTH = 6.5, 1.3

INK = "#1b2733"
OUTLINE: Style = {"color": INK, "linewidth": 1.4, "solid_joinstyle": "round"}
EDGE: Style = {"color": INK, "linewidth": 0.6}
HIDDEN: Style = {"color": INK, "linewidth": 0.7, "dashes": (5.0, 2.5)}
CENTER: Style = {"color": "#8a6d3b", "linewidth": 0.6, "dashes": (12.0, 2.5, 2.0, 2.5)}
THIN_CENTER: Style = {**CENTER, "linewidth": 0.4}
DIMENSION: Style = {"color": BLUE, "linewidth": 0.6}
JOURNAL_COLOR, WEB_COLOR, OPEN = "#e9eef3", "#d5dee7", "white"
BEYOND = 8.0  # of a center line past what it is the center of [points]
ABOVE_SURFACES, ABOVE_LINES = 3.0, 5.0


@dataclass(frozen=True)
class Linear:
    """A distance along one axis, between the points where its extension lines start."""

    start: Point
    end: Point
    text: str


@dataclass(frozen=True)
class Callout:
    """A text beside the view with a leader to a circle, or to a point if the radius is 0."""

    center: Point
    radius: float
    text: str
    wish: float  # height at which the text would stand best


@cache
def text_size(text: str, size: float = TEXT_SIZE) -> Point:
    """Width and height of a text on paper [points]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    lines = text.split("\n")
    width = 0.0
    for line in lines:
        path = TextPath((0.0, 0.0), line, size=size, prop=FontProperties(family=FONT))
        width = max(width, float(path.get_extents().x1) if len(path.vertices) else 0.0)
    return width + 2.0, LINE_HEIGHT * size * len(lines)


class View:
    """One view, drawn to scale.

    Parameters
    ----------
    point : float
        What one point on paper stands for [m].
    lettered : bool, optional
        Whether dimensions have the names of their fields in place of their values.
    """

    def __init__(self, axes: Axes, point: float, lettered: bool = False) -> None:
        self.axes, self.point, self.lettered = axes, point, lettered
        self.low, self.high = np.full(2, np.inf), np.full(2, -np.inf)
        self._taken: list[Box] = []
        self._angles: list[tuple[str, list[Place]]] = []

    def label(self, size: str, field: str) -> str:
        """Return the text of a dimension: its size, or what its field is called."""
        return self.named(field) if self.lettered else size

    def named(self, field: str) -> str:
        """Return what the field of a dimension is called on the drawing."""
        return field

    def stroke(self, points: ArrayLike, style: Style = OUTLINE, closed: bool = False) -> None:
        """Draw a line through points, above the surfaces unless the style says otherwise."""
        path = np.asarray(points, dtype=float)
        path = np.vstack([path, path[:1]]) if closed else path
        self.axes.plot(*path.T, **{"zorder": ABOVE_SURFACES, **style})
        self._reach(path)

    def surface(self, points: ArrayLike, color: str, edge: float = 1.0) -> None:
        """Fill a polygon that later ones cover; its edge as a share of an outline's width."""
        from matplotlib.patches import Polygon

        path = np.asarray(points, dtype=float)
        self.axes.add_patch(
            Polygon(
                path,
                facecolor=color,
                edgecolor=OUTLINE["color"],
                linewidth=edge * OUTLINE["linewidth"],
                joinstyle="round",
                zorder=1.0,
            )
        )
        self._reach(path)

    def arrow(self, tip: Point, towards: Point, length: float = ARROW) -> None:
        """Draw an arrowhead that points in a direction, `length` in points."""
        direction = np.array(towards) / math.hypot(*towards)
        across = np.array([-direction[1], direction[0]])
        back = np.array(tip) - length * self.point * direction
        wing = ARROW_HALF_WIDTH / ARROW * length * self.point * across
        self.head(np.array([tip, back + wing, back - wing]))

    def head(self, corners: Array) -> None:
        """Fill the triangle of an arrowhead."""
        from matplotlib.patches import Polygon

        self.axes.add_patch(
            Polygon(corners, facecolor=DIMENSION["color"], linewidth=0.0, zorder=ABOVE_SURFACES)
        )

    def write(
        self, text: str, *places: Place, upright: bool = False, paper: str = "white", **style: Any
    ) -> int:
        """Write at the first place (x, y, side) where the text is clear of others; return which."""
        boxes = [
            self._box(text, place, upright, style.get("fontsize", TEXT_SIZE)) for place in places
        ]
        free = [i for i, box in enumerate(boxes) if not any(_meet(box, b) for b in self._taken)]
        chosen = free[0] if free else len(places) - 1
        background = {"facecolor": paper, "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
        self.put(text, places[chosen], upright, {**style, "bbox": background})
        self._taken.append(boxes[chosen])
        self._reach(np.reshape(boxes[chosen], (2, 2)))
        return chosen

    def put(self, text: str, at: Place, upright: bool, style: Style) -> None:
        """Write at a place, whatever is there."""
        x, y, side = at
        look: dict[str, Any] = {"fontsize": TEXT_SIZE, "color": INK, "family": FONT, **style}
        self.axes.text(
            x, y, text, ha=side, va="center", rotation=90.0 if upright else 0.0,
            zorder=ABOVE_LINES, linespacing=1.15, **look,
        )  # fmt: skip

    def stack(self, dimensions: Sequence[Linear], axis: int, side: int) -> None:
        """Draw distances along an axis in lanes outside all that is drawn, on side +1 or -1."""
        lanes: list[list[Linear]] = []
        for dimension in dimensions:
            for lane in lanes:
                if not any(self._side_by_side(dimension, other, axis) for other in lane):
                    lane.append(dimension)
                    break
            else:
                lanes.append([dimension])
        for lane in lanes:
            edge = float((self.high if side > 0 else self.low)[1 - axis])
            level = edge + side * LANE * self.point
            for dimension in lane:
                self._linear(dimension, axis, level, side)

    def angle(self, center: Point, radius: float, first: float, last: float, text: str) -> None:
        """Draw an arc with arrowheads from one direction to another [rad]; the text comes later."""
        angles = np.linspace(first, last, 61)
        unit = np.column_stack([np.cos(angles), np.sin(angles)])
        self.stroke(np.array(center) + radius * unit, DIMENSION)
        turn = 1.0 if last > first else -1.0
        lean = turn * 0.5 * ARROW * self.point / radius  # an arrowhead is straight, the arc is not
        for end, sign in ((first + lean, -turn), (last - lean, turn)):
            tip = np.array(center) + radius * np.array(
                [math.cos(end + sign * abs(lean)), math.sin(end + sign * abs(lean))]
            )
            self.arrow((tip[0], tip[1]), (-sign * math.sin(end), sign * math.cos(end)))
        width, height = text_size(text)
        places: list[Place] = []
        for share in (0.5, 0.35, 0.65, 0.2, 0.8):
            middle = first + share * (last - first)
            cosine, sine = math.cos(middle), math.sin(middle)
            clear = 0.5 * (abs(cosine) * width + abs(sine) * height) + 1.5
            reach = radius + clear * self.point
            places.append((center[0] + reach * cosine, center[1] + reach * sine, "center"))
        self._angles.append((text, places))

    def write_angles(self) -> None:
        """Write the texts of angles, which may stand anywhere along their arcs, after all others."""
        for text, places in self._angles:
            self.write(text, *places)
        self._angles.clear()

    def leader(self, tip: Point, step: Point, text: str) -> None:
        """Draw a leader from a text to a point; `step` leads from the point to the text [points]."""
        places: list[Place] = []
        for longer in (1.0, 1.4, 1.8, 2.2, 2.6):
            x, y = (tip[k] + longer * step[k] * self.point for k in (0, 1))
            x += math.copysign(6.0 * self.point, step[0])
            places.append((x, y, "left" if step[0] > 0.0 else "right"))
        x, y, _ = places[self.write(text, *places)]
        elbow = (x - math.copysign(5.0 * self.point, step[0]), y)
        self.stroke([tip, elbow, (x, y)], DIMENSION)
        self.arrow(tip, (tip[0] - elbow[0], tip[1] - elbow[1]))

    def callouts(self, texts: Sequence[Callout]) -> None:
        """Write texts in a column right of all that is drawn, each with a leader."""
        column = self.high[0] + 10.0 * self.point
        wished = sorted(texts, key=lambda callout: -callout.wish)
        heights = [text_size(callout.text)[1] + 3.0 for callout in wished]
        # Levels near the wished ones, descending, with room for the heights.
        groups: list[tuple[list[float], list[float]]] = []  # wishes and heights of touching texts
        for callout, height in zip(wished, heights, strict=True):
            groups.append(([callout.wish], [height * self.point]))
            while len(groups) > 1 and _levels(*groups[-2])[1][1] < _levels(*groups[-1])[1][0]:
                (first, first_heights), (second, second_heights) = groups[-2:]
                groups[-2:] = [(first + second, first_heights + second_heights)]
        levels = [level for group in groups for level in _levels(*group)[0]]
        for callout, level in zip(wished, levels, strict=True):
            elbow = np.array([column, level])
            away = elbow - callout.center
            tip = np.array(callout.center) + callout.radius * away / np.linalg.norm(away)
            shelf = (column + 5.0 * self.point, level)
            self.stroke(np.array([tip, elbow, shelf]), DIMENSION)
            self.keep_clear(tip, elbow)
            self.arrow((tip[0], tip[1]), (tip[0] - elbow[0], tip[1] - elbow[1]))
            self.write(callout.text, (shelf[0] + 1.5 * self.point, level, "left"))

    def keep_clear(self, start: Array, end: Array) -> None:
        """Let no later text stand on a line."""
        half = 1.5 * self.point
        count = int(np.linalg.norm(end - start) / half) + 1
        for x, y in np.linspace(start, end, count):
            self._taken.append((x - half, y - half, x + half, y + half))

    def _linear(self, dimension: Linear, axis: int, level: float, side: int) -> None:
        """Draw one distance with its line at a level."""

        def place(along: float, across: float) -> Point:
            return (along, across) if axis == 0 else (across, along)

        points = sorted((dimension.start, dimension.end), key=lambda p: p[axis])
        (low, high), point = (p[axis] for p in points), self.point
        for at in points:
            gap = math.copysign(2.0 * point, level - at[1 - axis])
            overshoot = side * 2.5 * point
            self.stroke(
                [place(at[axis], at[1 - axis] + gap), place(at[axis], level + overshoot)], DIMENSION
            )
        inside = high - low > 1.5 * ARROW * point
        tail = 0.0 if inside else 1.8 * ARROW * point
        self.stroke([place(low - tail, level), place(high + tail, level)], DIMENSION)
        length = min(ARROW, 0.42 * (high - low) / point) if inside else ARROW
        outward = 1.0 if inside else -1.0
        self.arrow(place(low, level), place(-outward, 0.0), length)
        self.arrow(place(high, level), place(outward, 0.0), length)

        width, height = text_size(dimension.text)
        middle, off = 0.5 * (low + high), (0.5 * height + 0.5) * point
        fits = width * point <= high - low - (0.0 if inside else np.inf)
        if axis == 1:
            if fits:
                self.write(dimension.text, (level - off, middle, "center"), upright=True)
            else:
                away: Side = "right" if side < 0 else "left"
                self.write(dimension.text, (level + side * 2.5 * point, middle, away))
            return
        rows = [level + off] if fits else []
        rows += [level + side * (off + 1.01 * k * height * point) for k in range(7)]
        chosen = self.write(dimension.text, *((middle, row, "center") for row in rows))
        if chosen > int(fits):
            stop = rows[chosen] - side * 0.5 * height * point
            self.stroke([place(middle, level), place(middle, stop)], DIMENSION)

    def _side_by_side(self, linear: Linear, other: Linear, axis: int) -> bool:
        """Whether two distances overlap and so need lanes of their own."""
        (a, b), (c, d) = (sorted((x.start[axis], x.end[axis])) for x in (linear, other))
        return min(b, d) - max(a, c) > 0.1 * self.point

    def _box(self, text: str, place: Place, upright: bool, size: float) -> Box:
        width, height = (extent * self.point for extent in text_size(text, size))
        if upright:
            width, height = height, width
        x = place[0] - {"left": 0.0, "center": 0.5, "right": 1.0}[place[2]] * width
        return (x, place[1] - 0.5 * height, x + width, place[1] + 0.5 * height)

    def _reach(self, points: Array) -> None:
        self.low = np.fmin(self.low, np.nanmin(points, axis=0))
        self.high = np.fmax(self.high, np.nanmax(points, axis=0))


def _meet(box: Box, other: Box) -> bool:
    return box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]


def _levels(wishes: Sequence[float], heights: Sequence[float]) -> tuple[list[float], Point]:
    """Levels of touching texts about the mean of their wishes, and their upper and lower bound."""
    top = sum(wishes) / len(wishes) + 0.5 * sum(heights)
    edges = top - np.concatenate([[0.0], np.cumsum(heights)])
    return [float(level) for level in 0.5 * (edges[1:] + edges[:-1])], (edges[0], edges[-1])


Part = TypeVar("Part", Cylinder, WebPlate)


def millimeters(length: float) -> str:
    """Write a length for a drawing."""
    value = 1e3 * length
    text = f"{value:.{1 if abs(value) >= 100.0 else 2}f}"
    return text.rstrip("0").rstrip(".").replace("-", "−")


def degrees(angle: float) -> str:
    """Write an angle without its sign."""
    return f"{abs(math.degrees(angle)):.1f}".rstrip("0").rstrip(".") + "°"


def symbol(base: str, index: str) -> str:
    """Write a symbol with an index."""
    return rf"${base}_\mathrm{{{index}}}$"


def name_of(part: Cylinder | WebPlate) -> str:
    """Name a part on the drawing."""
    return "pin 1" if part.name == "pin" else part.name


def distinct_values(
    parts: Sequence[Part], value: Callable[[Part], object]
) -> list[tuple[Part, str]]:
    """Return the first part with each distinct value and, if there are several values, who has it."""
    groups: dict[str, list[Part]] = {}
    for part in parts:
        groups.setdefault(str(value(part)), []).append(part)
    return [
        (group[0], " " + ", ".join(name_of(part) for part in group) if len(groups) > 1 else "")
        for group in groups.values()
    ]


def corner_texts(web: WebPlate) -> dict[str, Point]:
    """Texts of the rounded or cut corners of an outline, from the tip on, and points (u, v) on them."""
    pieces = web.outline.pieces[::-1]
    arcs = [piece for piece in pieces if isinstance(piece, Arc)]
    texts: dict[str, Point] = {}
    for arc in arcs:
        about_axis = arc.center in ((0.0, 0.0), (0.0, web.distance))
        if about_axis and math.isclose(2.0 * arc.radius, web.outline.width, rel_tol=1e-6):
            continue  # an end of a plain obround, whose radius goes without saying
        points = arc.points(33)
        seen = points[~on_weight(web, points)]
        u, v = seen[len(seen) // 2] if len(seen) else points[16]
        texts.setdefault(f"$r$ {millimeters(arc.radius)}", (float(u), float(v)))
    if not arcs:
        for piece in pieces:
            (u_0, v_0), (u_1, v_1) = piece.start, piece.end
            if math.isclose(abs(u_1 - u_0), abs(v_1 - v_0)):  # others follow from widths and ends
                text = f"{millimeters(abs(u_1 - u_0))} × 45°"
                texts.setdefault(text, (0.5 * (u_0 + u_1), 0.5 * (v_0 + v_1)))
    return texts
