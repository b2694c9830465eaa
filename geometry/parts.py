"""A throw as the sequence of its solid parts: journal, web, pin, web ... journal.

Everything that draws, builds, checks or weighs a throw uses these, never the input's optional fields.
"""

import math
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from geometry.drilling import Drilling, alike
from geometry.outline import Outline

Array = NDArray[np.float64]
Point = tuple[float, float]
Part = TypeVar("Part")
# Numbers of `Slope`, `Sector` and `Drilling` that are no lengths.
NOT_LENGTHS = ("inward", "towards", "half_angle", "angle", "tilt")
LEFT_JOURNAL, RIGHT_JOURNAL = "left main journal", "right main journal"


@dataclass(frozen=True)
class Cylinder:
    """A main journal's half or a crankpin.

    Attributes
    ----------
    name : str
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
    name : str
    start, end : float
        Extent along z [m].
    foot, tip : (x, y)
        Axes that it joins: the shaft's and the pin's; for a web between pins, theirs [m].
    outline : Outline
        In coordinates u, v from the foot.
    slopes : tuple of Slope
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
    factor : float
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

    found: list[tuple[object, ...]] = []
    for item in parts.cylinders:
        fillets = (item.start_fillet, item.end_fillet)
        found.append(
            (
                item.axis, item.radius, reach(item.start, item.end),
                fillets[::-1] if reverse else fillets, item.bore_radius, item.bore_axis,
            )
        )  # fmt: skip
    for web in parts.webs:
        joined = (web.foot, web.tip)
        between_pins = web.foot != (0.0, 0.0)
        found.append(
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
        found = found[:count][::-1] + found[count:][::-1]
    return found


def _equal_to_round_off(first: object, second: object) -> bool:
    """Whether nested tuples are equal, numbers to round-off."""
    if isinstance(first, list | tuple) and isinstance(second, list | tuple):
        return len(first) == len(second) and all(
            _equal_to_round_off(a, b) for a, b in zip(first, second, strict=True)
        )
    if isinstance(first, float | int) and isinstance(second, float | int):
        return math.isclose(first, second, rel_tol=1e-12, abs_tol=1e-12)
    return first == second
