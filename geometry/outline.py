"""Outlines of webs: convex, symmetric about the line from the web's foot to its tip.

Coordinates (u, v): v from the foot axis (main journal) towards the tip axis (crankpin), u across.
Only the half u >= 0 is described, from the lowest point on the line to the highest.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.quantity import format_quantity

Array = NDArray[np.float64]
Point = tuple[float, float]
OutlineName = Literal["obround", "rectangle"]
# Pieces shorter than this share of the width are left out: they would only breed tiny elements.
NEGLIGIBLE = 1e-9


@dataclass(frozen=True)
class Line:
    """A straight piece from `start` to `end` [m]."""

    start: Point
    end: Point

    def distance(self, point: Point) -> float:
        """Distance of a point from the piece [m]."""
        (u, v), (u_1, v_1) = self.start, self.end
        along, up = u_1 - u, v_1 - v
        share = ((point[0] - u) * along + (point[1] - v) * up) / (along * along + up * up)
        share = min(max(share, 0.0), 1.0)
        return math.hypot(u + share * along - point[0], v + share * up - point[1])

    @property
    def largest_u(self) -> float:
        """Largest distance u of the piece [m]."""
        return max(self.start[0], self.end[0])

    def half_width(self, v: Array) -> Array:
        """Distance u of the piece at heights v [m]."""
        (u_0, v_0), (u_1, v_1) = self.start, self.end
        return np.asarray(u_0 + (u_1 - u_0) * (v - v_0) / (v_1 - v_0))


@dataclass(frozen=True)
class Arc:
    """A circular piece, counterclockwise about `center`, shorter than half a turn [m]."""

    center: Point
    start: Point
    end: Point

    @property
    def radius(self) -> float:
        """Radius [m]."""
        return math.dist(self.center, self.start)

    def points(self, count: int) -> Array:
        """Points (count, 2) along the arc, both ends included [m]."""
        first, last = (
            math.atan2(p[1] - self.center[1], p[0] - self.center[0]) for p in (self.start, self.end)
        )
        angles = np.linspace(first, last, count)
        return np.asarray(
            np.column_stack([np.cos(angles), np.sin(angles)]) * self.radius + self.center
        )

    def distance(self, point: Point) -> float:
        """Distance of a point from the arc [m]."""
        reach = math.dist(point, self.center)
        if reach == 0.0:
            return self.radius
        first, angle, last = (
            math.atan2(p[1] - self.center[1], p[0] - self.center[0])
            for p in (self.start, point, self.end)
        )
        if first <= angle <= last:
            return abs(self.radius - reach)
        return min(math.dist(point, self.start), math.dist(point, self.end))

    @property
    def largest_u(self) -> float:
        """Largest distance u of the arc [m]."""
        if self.start[1] <= self.center[1] <= self.end[1]:
            return self.center[0] + self.radius
        return max(self.start[0], self.end[0])

    def half_width(self, v: Array) -> Array:
        """Distance u of the arc at heights v [m]."""
        return np.asarray(
            self.center[0] + np.sqrt(np.maximum(self.radius**2 - (v - self.center[1]) ** 2, 0.0))
        )


@dataclass(frozen=True)
class Outline:
    """The half u >= 0 of a web's outline.

    Attributes
    ----------
    pieces : tuple of Line or Arc
        From the foot's end (0, v) to the tip's.
    """

    pieces: tuple[Line | Arc, ...]

    @property
    def foot(self) -> float:
        """Height v of the end beyond the foot axis [m]."""
        return self.pieces[0].start[1]

    @property
    def tip(self) -> float:
        """Height v of the end beyond the tip axis [m]."""
        return self.pieces[-1].end[1]

    @property
    def heights(self) -> Array:
        """Heights v where one piece ends and the next begins, ascending [m]."""
        return np.unique([self.foot, *(piece.end[1] for piece in self.pieces)])

    @property
    def width(self) -> float:
        """Largest width, twice the largest u [m]."""
        return 2.0 * max(piece.largest_u for piece in self.pieces)

    def half_width(self, v: Array) -> Array:
        """Half of the width at heights v, 0 outside [m]."""
        width = np.zeros_like(v, dtype=float)
        for piece in self.pieces:
            low, high = piece.start[1], piece.end[1]
            if high > low:
                here = (v >= low) & (v <= high)
                width[here] = piece.half_width(v[here])
        return width

    def distance(self, v: float) -> float:
        """Distance of the point (0, v) on the line of symmetry from the outline [m]."""
        return min(piece.distance((0.0, v)) for piece in self.pieces)

    def polygon(self, per_arc: int = 24) -> Array:
        """Corners (n, 2) of the half outline for drawing, from the foot's end to the tip's [m]."""
        points: list[Array] = [np.array([self.pieces[0].start])]
        for piece in self.pieces:
            if isinstance(piece, Arc):
                points.append(piece.points(per_arc)[1:])
            else:
                points.append(np.array([piece.end]))
        return np.concatenate(points)


def obround(width: float, foot_radius: float, tip_radius: float, distance: float) -> Outline:
    """Hull of a circle about each axis, with straight sides where it would be wider than `width`.

    Parameters
    ----------
    width : float
        B [m].
    foot_radius, tip_radius : float
        Radii of the ends about the foot and the tip axis [m].
    distance : float
        Distance of the axes [m].

    Raises
    ------
    InputError
        If the width is reached nowhere, or one end encloses the other.
    """
    half, largest = 0.5 * width, max(foot_radius, tip_radius)
    if largest < half * (1.0 - 1e-9):
        raise InputError(
            f"both ends are narrower than the width of {format_quantity(width, 'm')}; allowed is a "
            f"distance of {format_quantity(half, 'm')} or more from an axis to the end beyond it."
        )
    if abs(foot_radius - tip_radius) >= distance * (1.0 - 1e-6) and distance > NEGLIGIBLE * width:
        raise InputError(
            f"the end of radius {format_quantity(largest, 'm')} swallows that of "
            f"{format_quantity(min(foot_radius, tip_radius), 'm')}; allowed is a difference below the "
            f"{format_quantity(distance, 'm')} between the axes."
        )
    sine = (foot_radius - tip_radius) / distance if distance > NEGLIGIBLE * width else 0.0
    cosine = math.sqrt(1.0 - sine**2)
    low = (foot_radius * cosine, foot_radius * sine)
    high = (tip_radius * cosine, distance + tip_radius * sine)
    foot, tip = (0.0, 0.0), (0.0, distance)
    pieces: list[Line | Arc] = [
        Arc(foot, (0.0, -foot_radius), low),
        Line(low, high),
        Arc(tip, high, (0.0, distance + tip_radius)),
    ]
    if largest > half * (1.0 + 1e-9):
        pieces = _clip(pieces, half)
    return Outline(_without_tiny(pieces, width))


def _clip(pieces: list[Line | Arc], half: float) -> list[Line | Arc]:
    """Cut a convex half outline by the straight side u = half."""
    before: list[Line | Arc] = []
    after: list[Line | Arc] = []
    lowest: float | None = None
    highest = 0.0
    for piece in pieces:
        for crossing in _crossings(piece, half):
            lowest = crossing if lowest is None else min(lowest, crossing)
            highest = max(highest, crossing)
    assert lowest is not None
    for piece in pieces:
        low, high = piece.start[1], piece.end[1]
        if low < lowest:
            end = piece.end if high <= lowest else (half, lowest)
            before.append(_between(piece, piece.start, end))
        if high > highest:
            start = piece.start if low >= highest else (half, highest)
            after.append(_between(piece, start, piece.end))
    return [*before, Line((half, lowest), (half, highest)), *after]


def _between(piece: Line | Arc, start: Point, end: Point) -> Line | Arc:
    return Arc(piece.center, start, end) if isinstance(piece, Arc) else Line(start, end)


def _crossings(piece: Line | Arc, half: float) -> list[float]:
    """Heights v where a piece crosses u = half."""
    low, high = piece.start[1], piece.end[1]
    if isinstance(piece, Line):
        (u_0, v_0), (u_1, v_1) = piece.start, piece.end
        if (u_0 - half) * (u_1 - half) >= 0.0:
            return []
        return [v_0 + (half - u_0) / (u_1 - u_0) * (v_1 - v_0)]
    if piece.radius <= half:
        return []
    rise = math.sqrt(piece.radius**2 - half**2)
    heights = (piece.center[1] - rise, piece.center[1] + rise)
    return [v for v in heights if low <= v <= high]


def rectangle(
    width: float,
    foot_end: float,
    tip_end: float,
    distance: float,
    corner_radius: float = 0.0,
    corner_chamfer: float = 0.0,
) -> Outline:
    """Rectangle with corners rounded by a radius, or cut by a chamfer at 45 deg, or sharp.

    Parameters
    ----------
    width : float
        B [m].
    foot_end, tip_end : float
        Distance of each end from its axis [m].
    distance : float
        Distance of the axes [m].
    corner_radius, corner_chamfer : float
        One of them 0 [m].

    Raises
    ------
    InputError
        If the corners are larger than the rectangle, or both rounded and cut.
    """
    half, low, high = 0.5 * width, -foot_end, distance + tip_end
    cut = max(corner_radius, corner_chamfer)
    largest = min(half, 0.5 * (high - low))
    if corner_radius > 0.0 and corner_chamfer > 0.0:
        raise InputError(
            "the corners have a radius and a chamfer; allowed is one of them, because a corner is either "
            "rounded or cut."
        )
    if cut > largest * (1.0 + 1e-9):
        raise InputError(
            f"the corners of {format_quantity(cut, 'm')} do not fit the rectangle; allowed is at most "
            f"{format_quantity(largest, 'm')}, half of its shorter side."
        )
    foot, tip = (0.0, low), (0.0, high)
    if cut == 0.0:
        corners = [foot, (half, low), (half, high), tip]
        return Outline(tuple(Line(a, b) for a, b in pairwise(corners)))
    stops = [(half - cut, low), (half, low + cut), (half, high - cut), (half - cut, high)]
    corner: list[Line | Arc]
    if corner_radius > 0.0:
        corner = [
            Arc((half - cut, low + cut), stops[0], stops[1]),
            Arc((half - cut, high - cut), stops[2], stops[3]),
        ]
    else:
        corner = [Line(stops[0], stops[1]), Line(stops[2], stops[3])]
    pieces = [Line(foot, stops[0]), corner[0], Line(stops[1], stops[2]), corner[1]]
    return Outline(_without_tiny([*pieces, Line(stops[3], tip)], width))


def _without_tiny(pieces: list[Line | Arc], width: float) -> tuple[Line | Arc, ...]:
    return tuple(p for p in pieces if math.dist(p.start, p.end) > NEGLIGIBLE * width)


@dataclass(frozen=True)
class OutlineKind:
    """Construction of the outline of a name.

    Attributes
    ----------
    make : callable
        Makes it of width, reach beyond the foot and the tip axis and their distance [m], and of its own
        `dimensions` by name.
    dimensions : tuple of str
        Names in `OUTLINE_DIMENSIONS` that it has.
    round_ends : bool
        Whether the reach beyond an axis is the radius of the end about it.
    """

    make: Callable[..., Outline]
    dimensions: tuple[str, ...] = ()
    round_ends: bool = False


OUTLINES: Mapping[OutlineName, OutlineKind] = {
    "obround": OutlineKind(obround, round_ends=True),
    "rectangle": OutlineKind(rectangle, ("corner_radius", "corner_chamfer")),
}
# Fields of a web that some outlines have and others not, and what of an outline they measure.
OUTLINE_DIMENSIONS = {"corner_radius": "corners", "corner_chamfer": "corners"}
