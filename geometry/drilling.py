"""A straight oil hole through a pin or a main journal, across its axis: its exits and its volume.

Points near it have coordinates p, q, t: t along the hole from its intersection with the journal's axis, p
across both axes, q across the hole in the plane of both. With the tilt e the height over the journal's axis
towards the hole's direction is n = t cos e + q sin e, so the surface of a journal of radius R is at
n = +-sqrt(R^2 - p^2). A rounded exit is what is outside a ball of that radius that touches both the
hole's wall and the journal's surface from inside the material.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
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

    def holds(self, points: Array) -> NDArray[np.bool_]:
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
        any(_same(hole, other) for other in second) for hole in first
    )


def _same(hole: Drilling, other: Drilling) -> bool:
    mine, its = ((h.radius, h.exit_radius, len(h.exits)) for h in (hole, other))
    if not np.allclose(mine, its, rtol=1e-9, atol=0.0):
        return False
    size = hole.journal_radius
    return all(
        any(
            np.allclose(near.point, far.point, rtol=0.0, atol=1e-9 * size)
            and np.allclose(near.direction, far.direction, rtol=0.0, atol=1e-9)
            for far in other.exits
        )
        for near in hole.exits
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
