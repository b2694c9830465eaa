"""A throw as the sequence of its solid parts: journal, web, pin, web ... journal.

Everything that draws, builds, checks or weighs a throw reads these, never the input's optional fields.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geometry.outline import Outline, obround, rectangle
from geometry.throw_sections import Web

if TYPE_CHECKING:
    from geometry.throw import CrankThrow

Array = NDArray[np.float64]
Point = tuple[float, float]
# The slope of a thinned web starts this share of the journal's diameter beyond its fillet.
COLLAR_MARGIN = 0.02
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
        Radius and reach along z [m].
    start_fillet, end_fillet : float
        Radii of the fillets on the webs, 0 for none [m].
    bore_radius : float
        0 for none [m].
    bore_axis : (x, y)
        [m]
    bore_start, bore_end : float
        Reach of the bore along z, the adjoining webs included [m].
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
    """A web's thickness falling from a height `start` to its end, `drop` there [m].

    `face` is the z of the face it is taken from, `inward` (+1 or -1) the direction into the web,
    `towards` +1 if it falls towards the tip, -1 towards the foot.
    """

    start: float
    end: float
    drop: float
    face: float
    inward: float
    towards: float

    def depth(self, v: Array) -> Array:
        """Material taken off at heights v [m]."""
        share = (v - self.start) / (self.end - self.start)
        return np.asarray(self.drop * np.clip(share, 0.0, None))


@dataclass(frozen=True)
class Sector:
    """A counterweight as built: radii, half of its angle [rad], reach along z [m]."""

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
        Reach along z [m].
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


@dataclass(frozen=True)
class ThrowParts:
    """The parts of a throw from its left end to its right.

    Attributes
    ----------
    cylinders : tuple of Cylinder
        Left main journal, pins, right main journal.
    webs : tuple of WebPlate
        One between each two cylinders; of no thickness between the halves of a split pin.
    """

    cylinders: tuple[Cylinder, ...]
    webs: tuple[WebPlate, ...]

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
        return all(abs(pin.axis[0]) <= 1e-9 * reach for pin in self.pins)

    @cached_property
    def mirrored(self) -> bool:
        """Whether the middle z = length / 2 is a plane of symmetry."""
        return _alike(_signature(self, False), _signature(self, True))


def throw_parts(throw: "CrankThrow") -> ThrowParts:
    """Lay out the parts of a throw.

    Parameters
    ----------
    throw : CrankThrow

    Raises
    ------
    InputError
        If a web has no outline.
    """
    journal_fillet = throw.main_journal_fillet_radius
    pin_fillet = throw.pin_fillet_radius
    journal_fillet = throw.fillet_radius if journal_fillet is None else journal_fillet
    pin_fillet = throw.fillet_radius if pin_fillet is None else pin_fillet

    pins = [(throw.crank_radius, 0.0, throw.pin_diameter, throw.pin_length, pin_fillet)]
    bores = [(throw.pin_bore, throw.pin_bore_offset)]
    between = []
    for further in throw.further_pins:
        pins.append(
            (
                _or(further.crank_radius, throw.crank_radius),
                further.angle,
                _or(further.diameter, throw.pin_diameter),
                _or(further.length, throw.pin_length),
                _or(further.fillet_radius, pin_fillet),
            )
        )
        bores.append(
            (_or(further.bore, throw.pin_bore), _or(further.bore_offset, throw.pin_bore_offset))
        )
        between.append(
            (
                _or(further.web_thickness, throw.web_thickness),
                _or(further.web_width, throw.web_width),
            )
        )
    axes = [_crank_axis(radius, angle) for radius, angle, *_ in pins]

    left, right = throw.left_web or Web(), throw.right_web or Web()
    thicknesses = [
        _or(left.thickness, throw.web_thickness),
        *(thickness for thickness, _ in between),
        _or(right.thickness, throw.web_thickness),
    ]
    half = throw.main_journal_length / 2.0
    edges = [0.0, half]
    for thickness, (_, _, _, length, _) in zip(thicknesses, pins, strict=False):
        edges += [edges[-1] + thickness, edges[-1] + thickness + length]
    edges += [edges[-1] + thicknesses[-1], edges[-1] + thicknesses[-1] + half]

    journal = (throw.main_journal_diameter / 2.0, throw.main_journal_bore / 2.0)
    journal_bores = [
        (
            direction[0] * throw.main_journal_bore_offset,
            direction[1] * throw.main_journal_bore_offset,
        )
        for direction in (_direction(axes[0]), _direction(axes[-1]))
    ]
    cylinders = [
        Cylinder(
            LEFT_JOURNAL, (0.0, 0.0), journal[0], 0.0, half, 0.0, journal_fillet,
            journal[1], journal_bores[0], 0.0, edges[2],
        )
    ]  # fmt: skip
    for place, ((radius, _, diameter, length, fillet), (bore, offset)) in enumerate(
        zip(pins, bores, strict=True)
    ):
        start = edges[2 * place + 2]
        x, y = axes[place]
        share = offset / radius
        cylinders.append(
            Cylinder(
                "pin" if place == 0 else f"pin {place + 1}",
                (x, y),
                diameter / 2.0,
                start,
                start + length,
                fillet if thicknesses[place] > 0.0 else 0.0,
                fillet if thicknesses[place + 1] > 0.0 else 0.0,
                bore / 2.0,
                (x * (1.0 + share), y * (1.0 + share)),
                edges[2 * place + 1],
                start + length + thicknesses[place + 1],
            )
        )
    cylinders.append(
        Cylinder(
            RIGHT_JOURNAL, (0.0, 0.0), journal[0], edges[-2], edges[-1], journal_fillet, 0.0,
            journal[1], journal_bores[1], edges[-3], edges[-1],
        )
    )  # fmt: skip

    webs = [_end_web(throw, left, "left web", edges[1], edges[2], axes[0], cylinders[:2], -1.0)]
    for place, (_, width) in enumerate(between):
        first, second = axes[place], axes[place + 1]
        webs.append(
            WebPlate(
                f"web {place + 2}",
                edges[2 * place + 3],
                edges[2 * place + 4],
                first,
                second,
                obround(width, width / 2.0, width / 2.0, math.dist(first, second)),
            )
        )
    webs.append(
        _end_web(throw, right, "right web", edges[-3], edges[-2], axes[-1], cylinders[-2:], 1.0)
    )
    return ThrowParts(tuple(cylinders), tuple(webs))


def _or(own: float | None, common: float) -> float:
    return common if own is None else own


def _crank_axis(radius: float, angle: float) -> Point:
    """Place of a pin's axis; exact for whole quarter turns, so that planar throws are planar."""
    quarters = angle / (0.5 * math.pi)
    if abs(quarters - round(quarters)) < 1e-12:
        x, y = ((0, 1), (-1, 0), (0, -1), (1, 0))[round(quarters) % 4]
        return (radius * x, radius * y)
    return (-radius * math.sin(angle), radius * math.cos(angle))


def _direction(axis: Point) -> Point:
    reach = math.hypot(*axis)
    return (axis[0] / reach, axis[1] / reach)


def _end_web(
    throw: "CrankThrow",
    own: Web,
    name: str,
    start: float,
    end: float,
    tip: Point,
    joined: list[Cylinder],
    outer: float,
) -> WebPlate:
    """Lay out a web between a main journal and a pin; `outer` is the z direction of the journal."""
    width = _or(own.width, throw.web_width)
    foot_end = _or(own.journal_end, _or(throw.web_journal_end, width / 2.0))
    tip_end = _or(own.pin_end, _or(throw.web_pin_end, width / 2.0))
    distance = math.hypot(*tip)
    if (own.outline or throw.web_outline) == "obround":
        outline = obround(width, foot_end, tip_end, distance)
    else:
        outline = rectangle(
            width,
            foot_end,
            tip_end,
            distance,
            _or(own.corner_radius, throw.web_corner_radius),
            _or(own.corner_chamfer, throw.web_corner_chamfer),
        )
    journal, pin = joined if outer < 0.0 else joined[::-1]
    thickness = end - start
    tip_thickness = _or(own.tip_thickness, _or(throw.web_tip_thickness, thickness))
    foot_thickness = _or(own.foot_thickness, _or(throw.web_foot_thickness, thickness))
    journal_face, pin_face = (start, end) if outer < 0.0 else (end, start)
    slopes = []
    if tip_thickness != thickness:
        begin = journal.collar + 2.0 * COLLAR_MARGIN * journal.radius
        drop = thickness - tip_thickness
        slopes.append(Slope(begin, outline.tip, drop, journal_face, -outer, 1.0))
    if foot_thickness != thickness:
        begin = distance - pin.collar - 2.0 * COLLAR_MARGIN * pin.radius
        drop = thickness - foot_thickness
        slopes.append(Slope(begin, outline.foot, drop, pin_face, outer, -1.0))

    weight = own.counterweight or throw.counterweight
    sector = None
    if weight is not None:
        middle = 0.5 * (start + end) - outer * weight.offset
        reach = 0.5 * _or(weight.thickness, thickness)
        low, high = middle - reach, middle + reach
        # Faces meant to be flush are exactly so.
        low = start if math.isclose(low, start, rel_tol=1e-9) else low
        high = end if math.isclose(high, end, rel_tol=1e-9) else high
        sector = Sector(weight.outer_radius, weight.inner_radius, 0.5 * weight.angle, low, high)
    return WebPlate(name, start, end, (0.0, 0.0), tip, outline, tuple(slopes), sector)


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


def _alike(first: object, second: object) -> bool:
    """Compare nested tuples, numbers to round-off."""
    if isinstance(first, list | tuple) and isinstance(second, list | tuple):
        return len(first) == len(second) and all(
            _alike(a, b) for a, b in zip(first, second, strict=True)
        )
    if isinstance(first, float | int) and isinstance(second, float | int):
        return math.isclose(first, second, rel_tol=1e-12, abs_tol=1e-12)
    return first == second
