"""One crank throw: its dimensions, their meaning, and checks whether it can be built."""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Literal, Self

from pydantic import model_validator

from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.sentences import kept
from geometry.parts import (
    LEFT_JOURNAL,
    OUTLINES,
    RIGHT_JOURNAL,
    Cylinder,
    Drilling,
    Point,
    Sector,
    Slope,
    ThrowParts,
    WebPlate,
    obround,
    throw_volume,
)
from geometry.throw_checks import check_throw, fits_plainly, throw_remarks
from geometry.throw_dimensions import FurtherPin, ThrowDimensions, web_dimension

# The slope of a thinned web starts this share of the journal's diameter beyond its fillet.
COLLAR_MARGIN = 0.02


def throw_parts(throw: ThrowDimensions) -> ThrowParts:
    """Lay out the parts of a throw.

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
    edges = []
    z = throw.main_journal_length / 2.0
    for thickness, pin in zip(thicknesses, [*pins, None], strict=True):
        edges.append((z, z + thickness))
        z += thickness + (0.0 if pin is None else _given(pin.length))
    cylinders = [_journal(throw, LEFT_JOURNAL, axes[0], 0.0, *edges[0])]
    for number, (pin, axis) in enumerate(zip(pins, axes, strict=True)):
        before, after = edges[number : number + 2]
        fillet = _given(pin.fillet_radius)
        share = 1.0 + _given(pin.bore_offset) / _given(pin.crank_radius)
        cylinders.append(
            Cylinder(
                name="pin" if number == 0 else f"pin {number + 1}",
                axis=axis,
                radius=_given(pin.diameter) / 2.0,
                start=before[1],
                end=after[0],
                # Where a web has no thickness, there is no fillet.
                start_fillet=fillet if before[1] > before[0] else 0.0,
                end_fillet=fillet if after[1] > after[0] else 0.0,
                bore_radius=_given(pin.bore) / 2.0,
                bore_axis=(axis[0] * share, axis[1] * share),
                bore_start=before[0],
                bore_end=after[1],
            )
        )
    length = edges[-1][1] + throw.main_journal_length / 2.0
    cylinders.append(_journal(throw, RIGHT_JOURNAL, axes[-1], length, *edges[-1][::-1]))
    webs = [_end_web(throw, "left_web", *edges[0], axes[0], cylinders[:2], -1.0)]
    for number, pin in enumerate(pins[1:], start=2):
        width = _given(pin.web_width)
        first, second = axes[number - 2 : number]
        outline = obround(width, width / 2.0, width / 2.0, math.dist(first, second))
        webs.append(WebPlate(f"web {number}", *edges[number - 1], first, second, outline))
    webs.append(_end_web(throw, "right_web", *edges[-1], axes[-1], cylinders[-2:], 1.0))
    return ThrowParts(tuple(cylinders), tuple(webs), _drillings(throw, cylinders))


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
    drillings = []
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
        drillings.append(
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
    return tuple(drillings)


def _journal(
    throw: ThrowDimensions, name: str, pin: Point, end: float, face: float, far_face: float
) -> Cylinder:
    """A half of a main journal between its free end and its web's face; the bore ends at the far one."""
    fillet = _own_or_common(throw.main_journal_fillet_radius, throw.fillet_radius)
    reach = math.hypot(*pin)
    x, y = (pin[0] / reach, pin[1] / reach)
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


def _given(value: float | None) -> float:
    """A dimension of a pin of `pin_tables`, all of which are there."""
    assert value is not None
    return value


def _own_or_common(special: float | None, common: float) -> float:
    return common if special is None else special


def _crank_axis(radius: float, angle: float) -> Point:
    """Position of a pin's axis; exact for multiples of 90 deg, so that planar throws are planar."""
    quarters = angle / (0.5 * math.pi)
    if abs(quarters - round(quarters)) < 1e-12:
        x, y = ((0, 1), (-1, 0), (0, -1), (1, 0))[round(quarters) % 4]
        return (radius * x, radius * y)
    return (-radius * math.sin(angle), radius * math.cos(angle))


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
    name, special = table.replace("_", " "), getattr(throw, table)

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
        raise InputError(f"throw.web_{field}: in the {name} {kept(str(error))}") from None
    journal, pin = joined if outer < 0.0 else joined[::-1]
    thickness = end - start
    tip_thickness = dimension("tip_thickness", thickness)
    foot_thickness = dimension("foot_thickness", thickness)
    journal_face, pin_face = (start, end) if outer < 0.0 else (end, start)
    slopes = []
    # The thickness is a difference of places: one that is meant to be it differs by rounding.
    if not math.isclose(tip_thickness, thickness, rel_tol=1e-9):
        begin = journal.collar + 2.0 * COLLAR_MARGIN * journal.radius
        drop = thickness - tip_thickness
        slopes.append(Slope(begin, outline.tip, drop, journal_face, -outer, 1.0))
    if not math.isclose(foot_thickness, thickness, rel_tol=1e-9):
        begin = distance - pin.collar - 2.0 * COLLAR_MARGIN * pin.radius
        drop = thickness - foot_thickness
        slopes.append(Slope(begin, outline.foot, drop, pin_face, outer, -1.0))

    weight = (special and special.counterweight) or throw.counterweight
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


_REVERSED = {LEFT_JOURNAL: RIGHT_JOURNAL, RIGHT_JOURNAL: LEFT_JOURNAL}


class CrankThrow(ThrowDimensions):
    """The dimensions of one crank throw, from the middle of one main journal to that of the next.

    The first eight describe an ordinary throw: equal obround webs (the hull of two circles of
    diameter B about the shaft and the crankpin axis), with fillets of one radius at both ends of
    journals and pin, on the web. All others are optional.

    Parameters
    ----------
    crank_radius, main_journal_diameter, pin_diameter : float
        R, D_km, D_shm [m].
    main_journal_length, pin_length : float
        L_km, L_shm [m], each between the webs (of the main journal, half belongs to each throw).
    web_width, web_thickness : float
        B, h [m].
    fillet_radius : float, optional
        Radius of the fillets at main journals and pin [m]; 0 for sharp corners.
    main_journal_fillet_radius, pin_fillet_radius : float, optional
        If the two differ [m].
    main_journal_bore, pin_bore : float, optional
        d_km, d_shm [m]: diameters of bores that run through journal or pin and the adjacent webs; in
        a web they end where they meet the other journal.
    main_journal_bore_offset, pin_bore_offset : float, optional
        Distances of the bores' axes from the journals' [m], positive from the shaft towards the pin.
    web_outline : {"obround", "rectangle"}, optional
    web_journal_end, web_pin_end : float, optional
        Distance from the shaft and from the pin axis to the web's ends [m], B / 2 by default. In an
        obround web they are the radii of the ends: smaller than B / 2 narrows the web, larger ones
        are cut by its straight sides.
    web_corner_radius, web_corner_chamfer : float, optional
        Of a rectangle's corners [m].
    web_tip_thickness, web_foot_thickness : float, optional
        Thickness at the pin end and at the journal end [m]: the web becomes thinner along a slope on
        its outer face from the main journal's fillet to the pin end, and on its inner face from the
        pin's fillet to the journal end.
    counterweight : Counterweight, optional
        On both webs.
    left_web, right_web : Web, optional
        Fields that differ on one web.
    further_pins : tuple of FurtherPin, optional
        Pins that follow the first if a bearing is missing, or the other half of a split pin.
    oil_holes : tuple of OilHole, optional
        Straight drillings across pins and main journals.

    Raises
    ------
    InputError
        If a dimension is missing, out of range, or does not fit the others.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.285, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> round(throw.length, 6)
    0.395

    Frozen; `changed` makes another one, with all checks:

    >>> round(throw.changed(web_thickness=0.075).length, 6)
    0.409
    """

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if not fits_plainly(self):
            check_throw(self, self.parts)
        return self

    @cached_property
    def parts(self) -> ThrowParts:
        """The throw as the sequence of its parts, left to right."""
        return throw_parts(self)

    @property
    def pin_axes(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) of the pins' axes [m]."""
        return tuple(pin.axis for pin in self.parts.pins)

    @property
    def length(self) -> float:
        """Length of the throw along the shaft, the distance of the main bearings [m]."""
        return self.parts.length

    @property
    def overlap(self) -> float:
        """Overlap s of main journal and pin, negative without overlap [m]."""
        return 0.5 * (self.main_journal_diameter + self.pin_diameter) - self.crank_radius

    @property
    def volume(self) -> float:
        """Volume of the throw [m^3], from its parts."""
        return throw_volume(self.parts)

    @property
    def filleted(self) -> bool:
        """Whether every journal and pin has fillets on its webs."""
        return all(
            fillet > 0.0
            for web, *joined in zip(
                self.parts.webs, self.parts.cylinders, self.parts.cylinders[1:], strict=False
            )
            for fillet in (joined[0].end_fillet, joined[1].start_fillet)
        )

    @property
    def symmetry(self) -> str:
        """The smallest part that is sufficient: "quarter", "half" (x >= 0) or "full"."""
        if not self.parts.planar:
            return "full"
        return "quarter" if self.parts.mirrored and not self.further_pins else "half"

    @property
    def remarks(self) -> tuple[str, ...]:
        """Unusual features that can be built but are hardly intended, one sentence each."""
        return throw_remarks(self.parts)

    def plot(
        self,
        axes: Axes | None = None,
        *,
        view: Literal["side", "left end"] = "side",
        dimensions: bool = True,
    ) -> Axes:
        """Draw the throw to scale.

        Parameters
        ----------
        view : {"side", "left end"}
            From the side, z to the right; or from the left end, where x points to the left.
        dimensions : bool
            Write all dimensions in mm; without them the axes have scales in m.

        Raises
        ------
        InputError
            If the view is neither.
        """
        from geometry.plots.throw_plot import plot_throw

        return plot_throw(axes, self.parts, view, dimensions, "Crank throw")

    def reversed(self) -> "CrankThrow":
        """Return the same throw described from its other end.

        It is turned by half a turn about y, and about z until its last pin, now the first, is at +y.
        """
        pins = pin_tables(self)
        last = pins[-1].angle
        turned = [
            pin.changed(
                angle=_whole_turn(last - pin.angle),
                web_thickness=after.web_thickness,
                web_width=after.web_width,
            )
            for pin, after in zip(pins[-2::-1], pins[:0:-1], strict=True)
        ]
        first = pins[-1]
        names = [pin.name for pin in self.parts.pins]
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return CrankThrow(
            **values
            | {
                "left_web": self.right_web,
                "right_web": self.left_web,
                "crank_radius": first.crank_radius,
                "pin_diameter": first.diameter,
                "pin_length": first.length,
                "pin_fillet_radius": first.fillet_radius,
                "pin_bore": first.bore,
                "pin_bore_offset": first.bore_offset,
                "further_pins": tuple(turned),
                "oil_holes": tuple(
                    hole.changed(
                        part=_REVERSED.get(hole.part) or names[-1 - names.index(hole.part)],
                        position=-hole.position,
                        angle=_whole_turn(last - hole.angle),
                        tilt=-hole.tilt,
                    )
                    for hole in self.oil_holes
                ),
            }
        )


def _whole_turn(angle: float) -> float:
    """Angle within (-pi, pi] [rad]."""
    turned = -((-angle + math.pi) % (2.0 * math.pi) - math.pi)
    return 0.0 if turned == 0.0 else turned
