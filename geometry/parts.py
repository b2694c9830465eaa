"""A throw as the sequence of its solid parts: journal, web, pin, web ... journal; outlines, oil holes.

Everything that draws, builds, checks or weighs a throw uses these, never the input's optional fields.

Outlines of webs are convex, symmetric about the line from the web's foot to its tip. Coordinates (u, v):
v from the foot axis (main journal) towards the tip axis (crankpin), u across. Only the half u >= 0 is
described, from the lowest point on the line to the highest.

A straight oil hole goes through a pin or a main journal, across its axis. Points near it have coordinates
p, q, t: t along the hole from its intersection with the journal's axis, p across both axes, q across the
hole in the plane of both. With the tilt e the height over the journal's axis towards the hole's direction
is n = t cos e + q sin e, so the surface of a journal of radius R is at n = +-sqrt(R^2 - p^2). A rounded
exit is what is outside a ball of that radius that touches both the hole's wall and the journal's surface
from inside the material.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from typing import Any, Literal, TypeVar

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.errors import InputError
from crankbase.sentences import amount

Point = tuple[float, float]

# Points round a hole, where integrands are periodic, and across its rounding.
ROUND, ACROSS = 128, 16
# How deep an exit reaches into the hole: so many diameters, and at most half of the wall.
EXIT_DEPTH = 1.0
# Of the hole's radius: the largest stress is on the wall below exits of smaller radii.
SMALL_EXIT = 0.4
# Nodes lie on a hole's wall to this share of the journal's radius.
PLACE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Drilling:
    """An oil hole as built.

    Attributes
    ----------
    number : int
        From 1, in the order in which they are given.
    journal : str
        Name of the pin or main journal.
    axis : (x, y)
        The journal's [m].
    journal_radius, bore_radius : float
        The journal's, and its bore's or 0 [m].
    bore_axis : (x, y)
        [m]
    place : float
        Position along z at which its axis crosses the journal's [m].
    angle : float
        Direction from +y about +z [rad].
    tilt : float
        Inclination from the plane across the journal towards +z [rad].
    radius, exit_radius : float
        The hole's, and that of its rounded exits, 0 for sharp ones [m].
    through : bool
        Whether it has an exit on the other side as well; else it ends on the journal's axis or in its bore.
    """

    number: int
    journal: str
    axis: Point
    journal_radius: float
    bore_radius: float
    bore_axis: Point
    place: float
    angle: float
    tilt: float
    radius: float
    exit_radius: float
    through: bool

    @property
    def frame(self) -> Array:
        """Unit vectors of p, q and t, as rows (3, 3)."""
        sine, cosine = math.sin(self.angle), math.cos(self.angle)
        up, along = math.cos(self.tilt), math.sin(self.tilt)
        return np.array(
            [
                [cosine, sine, 0.0],
                [-along * sine, along * cosine, -up],
                [-up * sine, up * cosine, along],
            ]
        )

    @property
    def middle(self) -> Array:
        """Intersection of its axis with the journal's (3,) [m]."""
        return np.array([*self.axis, self.place])

    @property
    def exits(self) -> "tuple[DrillingExit, ...]":
        """Its exits from the journal."""
        return tuple(DrillingExit(self, side) for side in ((1.0, -1.0) if self.through else (1.0,)))

    @property
    def bore_place(self) -> Point:
        """Position of the bore's axis relative to the hole, p and n [m]."""
        x, y = np.subtract(self.bore_axis, self.axis)
        sine, cosine = math.sin(self.angle), math.cos(self.angle)
        return (float(x * cosine + y * sine), float(y * cosine - x * sine))

    @property
    def crosses_bore(self) -> bool:
        """Whether it runs into the journal's bore."""
        return abs(self.bore_place[0]) < self.radius + self.bore_radius and self.bore_radius > 0.0

    @property
    def inner_end(self) -> float:
        """End along t if it does not run through: on the journal's axis or in its bore [m]."""
        return self.bore_place[1] / math.cos(self.tilt) if self.crosses_bore else 0.0

    @property
    def volume(self) -> float:
        """Its volume in the journal [m^3], by quadrature to round-off."""
        return sum(outlet.wall_volume + outlet.rounding_volume for outlet in self.exits)

    def local(self, points: Array) -> Array:
        """Coordinates p, q, t (n, 3) of points (n, 3) [m]."""
        return np.asarray((points - self.middle) @ self.frame.T)

    def moved(self, angle: float, along: float, axis: Point, bore_axis: Point) -> "Drilling":
        """Return it turned by an angle [rad] about the shaft and moved along it, its journal's axes given."""
        place = self.place + along
        return replace(self, angle=self.angle + angle, place=place, axis=axis, bore_axis=bore_axis)

    def is_like(self, other: "Drilling") -> bool:
        """Whether another hole is the same one to round-off."""
        mine, its = ((h.radius, h.exit_radius, len(h.exits)) for h in (self, other))
        if not np.allclose(mine, its, rtol=1e-9, atol=0.0):
            return False
        size = self.journal_radius
        return all(
            any(
                np.allclose(near.point, far.point, rtol=0.0, atol=1e-9 * size)
                and np.allclose(near.direction, far.direction, rtol=0.0, atol=1e-9)
                for far in other.exits
            )
            for near in self.exits
        )


@dataclass(frozen=True)
class DrillingExit:
    """An exit of an oil hole: in its own direction (side 1) or at the other side (-1)."""

    drilling: Drilling
    side: float

    @property
    def angle_deg(self) -> float:
        """Direction from the journal's axis, from +y about +z, in (-180, 180] [deg]."""
        turned = math.degrees(self.drilling.angle) + (0.0 if self.side > 0.0 else 180.0)
        return round(180.0 - (180.0 - turned) % 360.0, 9) + 0.0

    @property
    def name(self) -> str:
        """For example "pin, oil hole 1 at 45 deg"."""
        return (
            f"{self.drilling.journal}, oil hole {self.drilling.number} at {self.angle_deg:.4g} deg"
        )

    @property
    def point(self) -> Array:
        """Point where the hole's axis leaves the journal (3,) [m]."""
        hole = self.drilling
        reach = self.side * hole.journal_radius / math.cos(hole.tilt)
        return np.asarray(hole.middle + reach * hole.frame[2])

    @property
    def direction(self) -> Array:
        """Unit vector (3,) along the hole, outward."""
        return np.asarray(self.side * self.drilling.frame[2])

    def surface(self, p: Array, q: Array) -> Array:
        """Position along t of the journal's surface."""
        hole = self.drilling
        height = np.sqrt(np.maximum(hole.journal_radius**2 - p**2, 0.0))
        return np.asarray((self.side * height - q * math.sin(hole.tilt)) / math.cos(hole.tilt))

    def inner(self, p: Array, q: Array) -> Array:
        """Start of the hole along t: at the bore, on the journal's axis, or at its end in a bore."""
        hole = self.drilling
        if not hole.crosses_bore:
            return np.zeros_like(p)
        across, along = hole.bore_place
        height = self.side * along + np.sqrt(
            np.maximum(hole.bore_radius**2 - (p - across) ** 2, 0.0)
        )
        return np.asarray((self.side * height - q * math.sin(hole.tilt)) / math.cos(hole.tilt))

    @property
    def wall_volume(self) -> float:
        """Volume of the hole between its inner end or the bore and the journal's surface [m^3]."""
        hole = self.drilling
        angles = 2.0 * math.pi * np.arange(ROUND) / ROUND
        p, weights = hole.radius * np.sin(angles), hole.radius**2 * np.cos(angles) ** 2
        weights *= 2.0 * math.pi / ROUND  # p runs over the hole twice, its width is 2 radius cos
        level = np.zeros_like(p)  # what is odd in q cancels
        return float(self.side * (weights @ (self.surface(p, level) - self.inner(p, level))))

    def rounding(self, angles: Array, share: Array) -> Array:
        """Places p, q, t (a, s, 3) on a rounded exit [m].

        They are at `angles` (a,) round the hole [rad], and at shares (s,) of the way from its wall (0) to
        the journal's surface (1).
        """
        hole = self.drilling
        reach, inside = hole.radius + hole.exit_radius, hole.journal_radius - hole.exit_radius
        cosine, sine = np.cos(angles), np.sin(angles)
        p, q = reach * cosine, reach * sine
        height = self.side * np.sqrt(inside**2 - p**2)
        up, along = math.cos(hole.tilt), math.sin(hole.tilt)
        center = np.stack([p, q, (height - q * along) / up], axis=-1)
        wall = np.stack([-cosine, -sine, np.zeros_like(p)], axis=-1)
        outward = np.stack([p, height * along, height * up], axis=-1) / inside
        opening = np.arccos(np.clip(np.sum(wall * outward, axis=-1), -1.0, 1.0))[:, None]
        first, second = np.sin((1.0 - share) * opening), np.sin(share * opening)
        arc = first[..., None] * wall[:, None] + second[..., None] * outward[:, None]
        return np.asarray(center[:, None] + hole.exit_radius * arc / np.sin(opening)[..., None])

    @property
    def rounding_volume(self) -> float:
        """Volume removed by rounding the exit: columns along the hole up to the surface [m^3]."""
        if self.drilling.exit_radius == 0.0:
            return 0.0
        angles = 2.0 * math.pi * np.arange(ROUND) / ROUND
        nodes, weights = np.polynomial.legendre.leggauss(ACROSS)
        share, step = 0.5 * (1.0 + nodes), 1e-5
        places = self.rounding(angles, share)
        along = self.rounding(angles + step, share) - self.rounding(angles - step, share)
        across = self.rounding(angles, share + step) - self.rounding(angles, share - step)
        area = (across[..., 0] * along[..., 1] - across[..., 1] * along[..., 0]) / (2.0 * step) ** 2
        p, q, t = np.moveaxis(places, -1, 0)
        height = self.side * (self.surface(p, q) - t)
        return float(np.sum(height * area @ (0.5 * weights)) * 2.0 * math.pi / ROUND)

    @property
    def rim(self) -> Array:
        """Places p, q, t (a, 3) round the opening, where the journal's surface is whole again [m]."""
        hole = self.drilling
        angles = 2.0 * math.pi * np.arange(ROUND) / ROUND
        if hole.exit_radius > 0.0:
            return np.asarray(self.rounding(angles, np.ones(1))[:, 0])
        p, q = hole.radius * np.cos(angles), hole.radius * np.sin(angles)
        return np.stack([p, q, self.surface(p, q)], axis=-1)

    @property
    def lip(self) -> Array:
        """Places p, q, t (a, 3) where the hole's wall ends and its rounding or the surface begins [m]."""
        angles = 2.0 * math.pi * np.arange(ROUND) / ROUND
        rounded = self.drilling.exit_radius > 0.0
        return np.asarray(self.rounding(angles, np.zeros(1))[:, 0]) if rounded else self.rim

    @property
    def radius(self) -> float:
        """Length scale of the stresses: the hole's radius if sharp, else the rounding's if not small [m]."""
        hole = self.drilling
        return max(hole.exit_radius, SMALL_EXIT * hole.radius) if hole.exit_radius else hole.radius

    def holds(self, points: Array) -> Flags:
        """Which points (n, 3) of the throw's fillets and oil holes are at this exit.

        The hole's wall to a depth of its diameter is part of it.
        """
        hole = self.drilling
        tolerance = PLACE_TOLERANCE * hole.journal_radius
        p, q, t = hole.local(points).T
        far = float(np.hypot(*self.rim[:, :2].T).max())
        off = np.hypot(p, q)
        depth = self.side * (self.surface(p, q) - t)
        wall = self.wall_volume / (math.pi * hole.radius**2)
        deepest = min(2.0 * EXIT_DEPTH * hole.radius, 0.5 * wall)
        near = (off > hole.radius - 1e3 * tolerance) & (off < far + 1e3 * tolerance)
        return np.asarray(near & (depth > -1e3 * tolerance) & (depth < deepest))


def alike(first: tuple[Drilling, ...], second: tuple[Drilling, ...]) -> bool:
    """Whether oil holes are the same ones to round-off, in any order."""
    return len(first) == len(second) and all(
        any(hole.is_like(other) for other in second) for hole in first
    )


def distance_from_wall(hole: Drilling) -> str:
    """Formula of the distance from a hole's wall, drawn out through a bore that it crosses."""
    middle, (first, second, along) = hole.middle.tolist(), hole.frame.tolist()
    reach = hole.journal_radius / math.cos(hole.tilt)
    start = -reach if hole.through else hole.inner_end
    t, center, half = _length_along(middle, along), 0.5 * (reach + start), 0.5 * (reach - start)
    beyond = f"0.5*(Abs({t}-({center!r}))-{half!r}+Abs(Abs({t}-({center!r}))-{half!r}))"
    off = f"Sqrt(({_length_along(middle, first)})^2+({_length_along(middle, second)})^2)"
    return f"Sqrt(({off}-{hole.radius!r})^2+({beyond})^2)"


def _length_along(origin: list[float], way: list[float]) -> str:
    """Formula of the coordinate along a unit vector from a point."""
    return "+".join(
        f"({step!r})*({axis}-({start!r}))"
        for axis, start, step in zip("xyz", origin, way, strict=True)
    ).join("()")


def distance_from_exits(hole: Drilling) -> str:
    """Formula of the distance from balls that hold a hole's exits."""
    formulas = []
    for outlet in hole.exits:
        x, y, z = outlet.point.tolist()
        rim = hole.middle + outlet.rim @ hole.frame
        ball = float(np.linalg.norm(rim - outlet.point, axis=1).max())
        off = f"(Sqrt((x-({x!r}))^2+(y-({y!r}))^2+(z-({z!r}))^2)-{ball!r})"
        formulas.append(f"(0.5*({off}+Abs({off})))")
    return formulas[0] if len(formulas) == 1 else f"Min({formulas[0]},{formulas[1]})"


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
            f"both ends are narrower than the width of {amount(width, 'm')}; allowed is a "
            f"distance of {amount(half, 'm')} or more from an axis to the end beyond it."
        )
    if abs(foot_radius - tip_radius) >= distance * (1.0 - 1e-6) and distance > NEGLIGIBLE * width:
        raise InputError(
            f"the end of radius {amount(largest, 'm')} swallows that of "
            f"{amount(min(foot_radius, tip_radius), 'm')}; allowed is a difference below the "
            f"{amount(distance, 'm')} between the axes."
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
            f"the corners of {amount(cut, 'm')} do not fit the rectangle; allowed is at most "
            f"{amount(largest, 'm')}, half of its shorter side."
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


Part = TypeVar("Part")
# Numbers of `Slope`, `Sector` and `Drilling` that are no lengths.
NOT_LENGTHS = ("inward", "towards", "half_angle", "angle", "tilt")
LEFT_JOURNAL, RIGHT_JOURNAL = "left main journal", "right main journal"


@dataclass(frozen=True)
class Cylinder:
    """A main journal's half or a crankpin.

    Attributes
    ----------
    axis : (x, y)
        [m]
    radius, start, end : float
        Radius and extent along z [m].
    start_fillet, end_fillet : float
        Radii of the fillets on the webs, 0 for none [m].
    bore_radius : float
        0 for none [m].
    bore_axis : (x, y)
        [m]
    bore_start, bore_end : float
        Extent of the bore along z, the adjoining webs included [m].
    """

    name: str
    axis: Point
    radius: float
    start: float
    end: float
    start_fillet: float
    end_fillet: float
    bore_radius: float
    bore_axis: Point
    bore_start: float
    bore_end: float

    @property
    def is_pin(self) -> bool:
        """Whether it is a crankpin."""
        return self.name not in (LEFT_JOURNAL, RIGHT_JOURNAL)

    @property
    def collar(self) -> float:
        """Radius of the larger fillet's foot on the web [m]."""
        return self.radius + max(self.start_fillet, self.end_fillet)


@dataclass(frozen=True)
class Slope:
    """Decrease of a web's thickness from a height `start` to its end, by `drop` there [m].

    `face` is the z of the face that slopes, `inward` (+1 or -1) the direction into the web,
    `towards` +1 if it falls towards the tip, -1 towards the foot.
    """

    start: float
    end: float
    drop: float
    face: float
    inward: float
    towards: float

    def depth(self, v: Array) -> Array:
        """Material removed at heights v [m]."""
        share = (v - self.start) / (self.end - self.start)
        return np.asarray(self.drop * np.clip(share, 0.0, None))


@dataclass(frozen=True)
class Sector:
    """A counterweight as built: radii, half of its angle [rad], extent along z [m]."""

    outer_radius: float
    inner_radius: float
    half_angle: float
    start: float
    end: float


@dataclass(frozen=True)
class WebPlate:
    """A web.

    Attributes
    ----------
    start, end : float
        Extent along z [m].
    foot, tip : (x, y)
        Axes that it joins: the shaft's and the pin's; for a web between pins, theirs [m].
    outline : Outline
        In coordinates u, v from the foot.
    sector : Sector or None
        Its counterweight, about the foot.
    """

    name: str
    start: float
    end: float
    foot: Point
    tip: Point
    outline: Outline
    slopes: tuple[Slope, ...] = ()
    sector: Sector | None = None

    @property
    def direction(self) -> Point:
        """Unit vector (x, y) from foot to tip; +y if they coincide."""
        x, y = self.tip[0] - self.foot[0], self.tip[1] - self.foot[1]
        length = math.hypot(x, y)
        return (x / length, y / length) if length > 0.0 else (0.0, 1.0)

    @property
    def distance(self) -> float:
        """Distance of the axes that it joins [m]."""
        return math.dist(self.foot, self.tip)

    def faces(self, v: Array) -> tuple[Array, Array]:
        """Start and end along z at heights v from its foot [m]."""
        start, end = np.full_like(v, self.start), np.full_like(v, self.end)
        for slope in self.slopes:
            if slope.inward > 0.0:
                start += slope.depth(v)
            else:
                end -= slope.depth(v)
        return start, end


@dataclass(frozen=True)
class ThrowParts:
    """The parts of a throw from its left end to its right.

    Attributes
    ----------
    cylinders : tuple of Cylinder
        Left main journal, pins, right main journal.
    webs : tuple of WebPlate
        One between each two cylinders; of no thickness between the halves of a split pin.
    drillings : tuple of Drilling
        Oil holes.
    """

    cylinders: tuple[Cylinder, ...]
    webs: tuple[WebPlate, ...]
    drillings: tuple[Drilling, ...] = ()

    @property
    def pins(self) -> tuple[Cylinder, ...]:
        """The crankpins."""
        return self.cylinders[1:-1]

    @property
    def length(self) -> float:
        """Length along the shaft [m]."""
        return self.cylinders[-1].end

    @cached_property
    def planar(self) -> bool:
        """Whether the crank plane x = 0 is a plane of symmetry."""
        reach = max(abs(pin.axis[1]) for pin in self.pins)
        flipped = tuple(replace(hole, angle=-hole.angle) for hole in self.drillings)
        return all(abs(pin.axis[0]) <= 1e-9 * reach for pin in self.pins) and alike(
            flipped, self.drillings
        )

    @cached_property
    def mirrored(self) -> bool:
        """Whether the middle z = length / 2 is a plane of symmetry."""
        flipped = tuple(
            replace(hole, place=self.length - hole.place, tilt=-hole.tilt)
            for hole in self.drillings
        )
        return _equal_to_round_off(_signature(self, False), _signature(self, True)) and alike(
            flipped, self.drillings
        )


def scaled_parts(parts: Part, factor: float) -> Part:
    """Scale all lengths of a throw's parts, to 12 decimals: parts that differ in size alone become equal.

    Parameters
    ----------
    parts : ThrowParts, or one of them
    """

    def scaled(item: Any) -> Any:
        if isinstance(item, float):
            return round(item * factor, 12)
        if isinstance(item, tuple):
            return tuple(map(scaled, item))
        if not is_dataclass(item) or isinstance(item, type):
            return item
        names = [field.name for field in fields(item) if field.name not in NOT_LENGTHS]
        return replace(item, **{name: scaled(getattr(item, name)) for name in names})

    made: Part = scaled(parts)
    return made


def _signature(parts: ThrowParts, reverse: bool) -> list[tuple[object, ...]]:
    """All that shapes the throw, seen from its left end or (`reverse`) mirrored from its right."""

    def place(z: float) -> float:
        return parts.length - z if reverse else z

    def reach(start: float, end: float) -> Point:
        return (place(end), place(start)) if reverse else (place(start), place(end))

    places: list[tuple[object, ...]] = []
    for item in parts.cylinders:
        fillets = (item.start_fillet, item.end_fillet)
        places.append(
            (
                item.axis, item.radius, reach(item.start, item.end),
                fillets[::-1] if reverse else fillets, item.bore_radius, item.bore_axis,
            )
        )  # fmt: skip
    for web in parts.webs:
        joined = (web.foot, web.tip)
        between_pins = web.foot != (0.0, 0.0)
        places.append(
            (
                reach(web.start, web.end),
                joined[::-1] if reverse and between_pins else joined,
                tuple((type(p).__name__, p.start, p.end) for p in web.outline.pieces),
                tuple((s.start, s.drop, place(s.face), s.towards) for s in web.slopes),
                None
                if web.sector is None
                else (
                    web.sector.outer_radius, web.sector.inner_radius, web.sector.half_angle,
                    reach(web.sector.start, web.sector.end),
                ),
            )
        )  # fmt: skip
    count = len(parts.cylinders)
    if reverse:
        places = places[:count][::-1] + places[count:][::-1]
    return places


def _equal_to_round_off(first: object, second: object) -> bool:
    """Whether nested tuples are equal, numbers to round-off."""
    if first == second:
        return True
    if isinstance(first, list | tuple) and isinstance(second, list | tuple):
        return len(first) == len(second) and all(
            _equal_to_round_off(a, b) for a, b in zip(first, second, strict=True)
        )
    if isinstance(first, float | int) and isinstance(second, float | int):
        return math.isclose(first, second, rel_tol=1e-12, abs_tol=1e-12)
    return False


GAUSS_POINTS, PANELS = 10, 8
HALVINGS = 45


def throw_volume(parts: ThrowParts) -> float:
    """Volume of a throw [m^3]: journals, fillets, webs, counterweights, less bores and oil holes."""
    volume = 0.0
    for cylinder in parts.cylinders:
        area = math.pi * (cylinder.radius**2 - cylinder.bore_radius**2)
        volume += area * (cylinder.end - cylinder.start)
        for fillet in (cylinder.start_fillet, cylinder.end_fillet):
            volume += fillet_volume(cylinder.radius, fillet)
    for web, before, after in zip(parts.webs, parts.cylinders, parts.cylinders[1:], strict=False):
        if web.end > web.start:
            volume += _web_volume(web) - _bored(web, before) - _bored(web, after)
        if web.sector is not None:
            volume += _sector_volume(web, web.sector, after if before.is_pin else before)
    return volume - sum(hole.volume for hole in parts.drillings)


def fillet_volume(journal_radius: float, fillet_radius: float) -> float:
    """Volume between a cylinder, a flat web face and the fillet that joins them (Pappus) [m^3]."""
    area = fillet_radius**2 * (1.0 - math.pi / 4.0)
    # First moment of the square r x r less its quarter circle, about the journal's surface.
    square = fillet_radius**2 * 0.5 * fillet_radius
    quarter = math.pi / 4.0 * fillet_radius**2 * (1.0 - 4.0 / (3.0 * math.pi)) * fillet_radius
    return 2.0 * math.pi * (journal_radius * area + square - quarter)


def web_thickness(web: WebPlate, v: Array) -> Array:
    """Thickness of a web at heights v from its foot [m]."""
    start, end = web.faces(v)
    return end - start


def _web_volume(web: WebPlate) -> float:
    heights = [*web.outline.heights, *(slope.start for slope in web.slopes)]
    return _integral(
        lambda v: 2.0 * web.outline.half_width(v) * web_thickness(web, v), np.array(heights)
    )


def counterweight_moment(parts: ThrowParts) -> Array:
    """Return the integral of (x, y) over what the counterweights add to their webs, (2,) [m^4]."""
    moment = np.zeros(2)
    for web, before, after in zip(parts.webs, parts.cylinders, parts.cylinders[1:], strict=False):
        if web.sector is not None:
            journal = after if before.is_pin else before
            volume, first = (_sector_volume(web, web.sector, journal, power) for power in (0, 1))
            moment += volume * np.array(web.foot) + first * np.array(web.direction)
    return moment


def _sector_volume(web: WebPlate, sector: Sector, journal: Cylinder, power: int = 0) -> float:
    """Volume that a counterweight adds to its web, less the journal's bore through it [m^3].

    Or the integral of a power of the height from the web's foot over that volume.
    """
    bore, center = journal.bore_radius, _height(web, journal)
    cosine, tangent = math.cos(sector.half_angle), math.tan(sector.half_angle)
    radii = (sector.outer_radius, sector.inner_radius)
    heights = [
        *(-r for r in radii),
        *(-r * cosine for r in radii),
        *(v for v in web.outline.heights if -sector.outer_radius < v < 0.0),
        *(s.start for s in web.slopes if -sector.outer_radius < s.start < 0.0),
        *(v for v in (center - bore, center + bore) if v < 0.0),
        0.0,
    ]

    def bored(v: Array) -> Array:
        return np.sqrt(np.maximum(bore**2 - (v - center) ** 2, 0.0))

    def reach(v: Array) -> tuple[Array, Array, Array]:
        """Where the counterweight begins and ends beside the line of symmetry, and the web ends."""
        low = np.sqrt(np.maximum(sector.inner_radius**2 - v**2, 0.0))
        high = np.sqrt(np.maximum(sector.outer_radius**2 - v**2, 0.0))
        if sector.half_angle < 0.5 * math.pi - 1e-12:
            high = np.minimum(high, -v * tangent)
        return low, high, web.outline.half_width(v)

    def area(v: Array) -> Array:
        low, high, width = reach(v)
        outside = np.maximum(high - np.maximum(width, low), 0.0)
        inside = np.maximum(np.minimum(high, width) - low, 0.0)
        start, end = web.faces(v)
        shared = np.maximum(np.minimum(end, sector.end) - np.maximum(start, sector.start), 0.0)
        thickness = sector.end - sector.start
        # Where the web is thinned, the counterweight fills it up, but not the bore.
        filled = max(min(web.end, sector.end) - max(web.start, sector.start), 0.0) - shared
        hole = np.maximum(np.minimum(np.minimum(high, width), bored(v)) - low, 0.0)
        added = outside * thickness + inside * (thickness - shared) - hole * filled
        return np.asarray(2.0 * added * v**power)

    # Where the outlines cross, the integrand has a kink.
    fine = np.linspace(-sector.outer_radius, 0.0, 401)
    gaps: tuple[Callable[[Array], Array], ...] = (
        lambda v: reach(v)[1] - reach(v)[2],
        lambda v: reach(v)[0] - reach(v)[2],
        lambda v: reach(v)[1] - bored(v),
    )
    for gap in gaps:
        signs = np.sign(gap(fine))
        places = np.flatnonzero(signs[:-1] * signs[1:] < 0.0)
        if len(places):
            heights.extend(_roots(gap, fine[places], fine[places + 1]))
    # The web may be thinned so far that the counterweight's face comes out of it.
    for slope in web.slopes:
        for face in (sector.start, sector.end):
            depth = (face - slope.face) * slope.inward
            if 0.0 < depth < slope.drop:
                heights.append(slope.start + depth / slope.drop * (slope.end - slope.start))
    return _integral(area, np.clip(heights, -sector.outer_radius, 0.0))


def _roots(function: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Bisect intervals at whose ends a function has other signs; scipy's takes longer to load than a mesh."""
    sign = np.sign(function(low))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = np.sign(function(middle)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.asarray(0.5 * (low + high))


def _bored(web: WebPlate, cylinder: Cylinder) -> float:
    """Volume that a cylinder's bore takes out of a web [m^3]."""
    radius = cylinder.bore_radius
    if radius == 0.0:
        return 0.0
    center = _height(web, cylinder)
    heights = [center - radius, center + radius]
    heights += [s.start for s in web.slopes if heights[0] < s.start < heights[1]]
    return _integral(
        lambda v: (
            2.0 * np.sqrt(np.maximum(radius**2 - (v - center) ** 2, 0.0)) * web_thickness(web, v)
        ),
        np.array(heights),
    )


def _height(web: WebPlate, cylinder: Cylinder) -> float:
    """Height v of a bore's axis in a web's coordinates [m]."""
    (x, y), (a, b) = web.foot, web.direction
    return (cylinder.bore_axis[0] - x) * a + (cylinder.bore_axis[1] - y) * b


@cache
def _panels() -> tuple[Array, Array]:
    """Gauss points on (-1, 1), a few on each of several panels."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    middles = (2.0 * np.arange(PANELS) + 1.0) / PANELS - 1.0
    return (middles[:, None] + nodes / PANELS).ravel(), np.tile(weights / PANELS, PANELS)


def _integral(function: Callable[[Array], Array], breaks: Array) -> float:
    """Integrate between breakpoints; the sine takes the roots at the ends of arcs out."""
    nodes, weights = _panels()
    angles = 0.5 * math.pi * nodes
    total = 0.0
    breaks = np.unique(breaks)
    for low, high in pairwise(breaks):
        half = 0.5 * (high - low)
        v = 0.5 * (low + high) + half * np.sin(angles)
        total += float(np.sum(function(v) * np.cos(angles) * weights) * half * 0.5 * math.pi)
    return total
