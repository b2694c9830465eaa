"""One crank throw: its dimensions, their meaning, and checks whether it can be built."""

import math
from functools import cached_property
from typing import TYPE_CHECKING, Literal, Self

from pydantic import model_validator

from geometry.parts import LEFT_JOURNAL, RIGHT_JOURNAL, ThrowParts
from geometry.throw_checks import check_throw, fits_plainly, throw_remarks
from geometry.throw_dimensions import ThrowDimensions
from geometry.throw_layout import pin_tables, throw_parts
from geometry.volume import throw_volume

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
        axes: "Axes | None" = None,
        *,
        view: Literal["side", "left end"] = "side",
        dimensions: bool = True,
    ) -> "Axes":
        """Draw the throw to scale.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        view : {"side", "left end"}
            From the side, z to the right; or from the left end, where x points to the left.
        dimensions : bool
            Write all dimensions in mm; without them the axes have scales in m.

        Returns
        -------
        matplotlib.axes.Axes

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
