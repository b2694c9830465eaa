"""A throw's parts laid out from its dimensions and their defaults."""

import math
from collections.abc import Sequence

from crankbase.errors import InputError
from geometry.drilling import Drilling
from geometry.outline import OUTLINES, obround
from geometry.parts import (
    LEFT_JOURNAL,
    RIGHT_JOURNAL,
    Cylinder,
    Point,
    Sector,
    Slope,
    ThrowParts,
    WebPlate,
)
from geometry.throw_dimensions import FurtherPin, ThrowDimensions, web_dimension

# The slope of a thinned web starts this share of the journal's diameter beyond its fillet.
COLLAR_MARGIN = 0.02


def throw_parts(throw: ThrowDimensions) -> ThrowParts:
    """Lay out the parts of a throw.

    Parameters
    ----------
    throw : ThrowDimensions

    Raises
    ------
    InputError
        If a web has no outline.
    """
    pins = pin_tables(throw)
    axes = [_crank_axis(_given(pin.crank_radius), pin.angle) for pin in pins]
    thicknesses = [
        web_dimension(throw, "left_web", "thickness")[1],
        *(_given(pin.web_thickness) for pin in pins[1:]),
        web_dimension(throw, "right_web", "thickness")[1],
    ]
    edges = _web_edges(throw, pins, thicknesses)
    cylinders = (
        _journal(throw, LEFT_JOURNAL, axes[0], 0.0, *edges[0]),
        *(
            _pin(pin, axis, number, *edges[number : number + 2])
            for number, (pin, axis) in enumerate(zip(pins, axes, strict=True))
        ),
        _journal(throw, RIGHT_JOURNAL, axes[-1], edges[-1][1] + throw.main_journal_length / 2.0,
                 *edges[-1][::-1]),
    )  # fmt: skip
    webs = (
        _end_web(throw, "left_web", *edges[0], axes[0], cylinders[:2], -1.0),
        *(
            _web_between(
                _given(pin.web_width), number, edges[number - 1], *axes[number - 2 : number]
            )
            for number, pin in enumerate(pins[1:], start=2)
        ),
        _end_web(throw, "right_web", *edges[-1], axes[-1], cylinders[-2:], 1.0),
    )
    return ThrowParts(cylinders, webs, _drillings(throw, cylinders))


def pin_tables(throw: ThrowDimensions) -> list[FurtherPin]:
    """Every pin of a throw with all of its dimensions; `angle` counts from the first."""
    # Its dimensions are the throw's, which are checked.
    first = FurtherPin.model_construct(
        angle=0.0,
        crank_radius=throw.crank_radius,
        diameter=throw.pin_diameter,
        length=throw.pin_length,
        fillet_radius=_own_or_common(throw.pin_fillet_radius, throw.fillet_radius),
        bore=throw.pin_bore,
        bore_offset=throw.pin_bore_offset,
        web_thickness=throw.web_thickness,
        web_width=throw.web_width,
    )
    return [
        first,
        *(first.changed(**pin.model_dump(exclude_none=True)) for pin in throw.further_pins),
    ]


def _drillings(throw: ThrowDimensions, cylinders: Sequence[Cylinder]) -> tuple[Drilling, ...]:
    """Lay out the oil holes; positions in main journals count from the throw's ends."""
    found = []
    for number, hole in enumerate(throw.oil_holes, start=1):
        names = [cylinder.name for cylinder in cylinders]
        if hole.part not in names:
            raise InputError(
                f"throw.oil_holes[{number - 1}].part: given {hole.part!r}; allowed are "
                f"{', '.join(names[1:-1])}, {LEFT_JOURNAL} and {RIGHT_JOURNAL}, the parts of this throw."
            )
        journal = cylinders[names.index(hole.part)]
        middle = {LEFT_JOURNAL: journal.start, RIGHT_JOURNAL: journal.end}.get(
            hole.part, 0.5 * (journal.start + journal.end)
        )
        found.append(
            Drilling(
                number=number,
                journal=journal.name,
                axis=journal.axis,
                journal_radius=journal.radius,
                bore_radius=journal.bore_radius,
                bore_axis=journal.bore_axis,
                place=middle + hole.position,
                angle=hole.angle,
                tilt=hole.tilt,
                radius=hole.diameter / 2.0,
                exit_radius=hole.exit_radius,
                through=hole.through,
            )
        )
    return tuple(found)


def _web_edges(
    throw: ThrowDimensions, pins: list[FurtherPin], thicknesses: list[float]
) -> list[tuple[float, float]]:
    """Where each web begins and ends along z [m]."""
    edges = []
    z = throw.main_journal_length / 2.0
    for thickness, pin in zip(thicknesses, [*pins, None], strict=True):
        edges.append((z, z + thickness))
        z += thickness + (0.0 if pin is None else _given(pin.length))
    return edges


def _journal(
    throw: ThrowDimensions, name: str, pin: Point, end: float, face: float, far_face: float
) -> Cylinder:
    """A half of a main journal between its free end and its web's face; the bore ends at the far one."""
    fillet = _own_or_common(throw.main_journal_fillet_radius, throw.fillet_radius)
    x, y = _direction(pin)
    offset = throw.main_journal_bore_offset
    left = end < face
    return Cylinder(
        name=name,
        axis=(0.0, 0.0),
        radius=throw.main_journal_diameter / 2.0,
        start=min(end, face),
        end=max(end, face),
        start_fillet=0.0 if left else fillet,
        end_fillet=fillet if left else 0.0,
        bore_radius=throw.main_journal_bore / 2.0,
        bore_axis=(x * offset, y * offset),
        bore_start=min(end, far_face),
        bore_end=max(end, far_face),
    )


def _pin(
    pin: FurtherPin,
    axis: Point,
    number: int,
    before: tuple[float, float],
    after: tuple[float, float],
) -> Cylinder:
    """A crankpin between two webs; where one has no thickness, there is no fillet."""
    fillet = _given(pin.fillet_radius)
    share = 1.0 + _given(pin.bore_offset) / _given(pin.crank_radius)
    return Cylinder(
        name="pin" if number == 0 else f"pin {number + 1}",
        axis=axis,
        radius=_given(pin.diameter) / 2.0,
        start=before[1],
        end=after[0],
        start_fillet=fillet if before[1] > before[0] else 0.0,
        end_fillet=fillet if after[1] > after[0] else 0.0,
        bore_radius=_given(pin.bore) / 2.0,
        bore_axis=(axis[0] * share, axis[1] * share),
        bore_start=before[0],
        bore_end=after[1],
    )


def _web_between(
    width: float, number: int, edges: tuple[float, float], first: Point, second: Point
) -> WebPlate:
    """The obround web before pin `number`."""
    outline = obround(width, width / 2.0, width / 2.0, math.dist(first, second))
    return WebPlate(f"web {number}", *edges, first, second, outline)


def _given(value: float | None) -> float:
    """A dimension of a pin of `pin_tables`, all of which are there."""
    assert value is not None
    return value


def _own_or_common(own: float | None, common: float) -> float:
    return common if own is None else own


def _crank_axis(radius: float, angle: float) -> Point:
    """Position of a pin's axis; exact for multiples of 90 deg, so that planar throws are planar."""
    quarters = angle / (0.5 * math.pi)
    if abs(quarters - round(quarters)) < 1e-12:
        x, y = ((0, 1), (-1, 0), (0, -1), (1, 0))[round(quarters) % 4]
        return (radius * x, radius * y)
    return (-radius * math.sin(angle), radius * math.cos(angle))


def _direction(axis: Point) -> Point:
    reach = math.hypot(*axis)
    return (axis[0] / reach, axis[1] / reach)


def _end_web(
    throw: ThrowDimensions,
    table: str,
    start: float,
    end: float,
    tip: Point,
    joined: Sequence[Cylinder],
    outer: float,
) -> WebPlate:
    """Lay out a web between a main journal and a pin; `outer` is the z direction of the journal."""
    name, own = table.replace("_", " "), getattr(throw, table)

    def dimension(kind: str, otherwise: float = 0.0) -> float:
        return _own_or_common(web_dimension(throw, table, kind)[1], otherwise)

    width, distance = dimension("width"), math.hypot(*tip)
    foot_end, tip_end = (dimension(kind, width / 2.0) for kind in ("journal_end", "pin_end"))
    outline_kind = OUTLINES[web_dimension(throw, table, "outline")[1]]
    besides = {kind: dimension(kind) for kind in outline_kind.dimensions}
    try:
        outline = outline_kind.make(width, foot_end, tip_end, distance, **besides)
    except InputError as error:
        field = next((kind for kind, value in besides.items() if value > 0.0), "journal_end")
        raise InputError(f"throw.web_{field}: in the {name} {error}") from None
    journal, pin = joined if outer < 0.0 else joined[::-1]
    thickness = end - start
    tip_thickness = dimension("tip_thickness", thickness)
    foot_thickness = dimension("foot_thickness", thickness)
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

    weight = (own and own.counterweight) or throw.counterweight
    sector = None
    if weight is not None:
        middle = 0.5 * (start + end) - outer * weight.offset
        reach = 0.5 * _own_or_common(weight.thickness, thickness)
        low, high = middle - reach, middle + reach
        # Faces meant to be flush are exactly so.
        low = start if math.isclose(low, start, rel_tol=1e-9) else low
        high = end if math.isclose(high, end, rel_tol=1e-9) else high
        sector = Sector(weight.outer_radius, weight.inner_radius, 0.5 * weight.angle, low, high)
    return WebPlate(name, start, end, (0.0, 0.0), tip, outline, tuple(slopes), sector)
