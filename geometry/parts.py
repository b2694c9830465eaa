"""A throw as the sequence of its solid parts: journal, web, pin, web ... journal.

Everything that draws, builds, checks or weighs a throw uses these, never the input's optional fields.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
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
    if isinstance(first, list | tuple) and isinstance(second, list | tuple):
        return len(first) == len(second) and all(
            _equal_to_round_off(a, b) for a, b in zip(first, second, strict=True)
        )
    if isinstance(first, float | int) and isinstance(second, float | int):
        return math.isclose(first, second, rel_tol=1e-12, abs_tol=1e-12)
    return first == second


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
