"""Journals, pins and holes of a CAD part as cylinders in the throw frame."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from geometry.cad_faces import Round
from geometry.parts import Cylinder, Point
from geometry.solid import BORE, Zone


def named_cylinders(
    names: Sequence[str],
    axes: Sequence[Point],
    row: Sequence[Round],
    spans: Sequence[Point],
    radii: Mapping[Zone, float],
    holes: Sequence[Cylinder],
) -> tuple[Cylinder, ...]:
    """Make cylinders of main journals and pins, with their fillets and bores.

    Parameters
    ----------
    names, axes, row, spans : sequences
        Names, axes in the throw frame, what was measured, and reach along z, fillets included [m].
    radii : mapping
        Radii of the fillets by number of the cylinder and end [m].
    holes : sequence of Cylinder
        Along the shaft; one through the middle of a journal or pin is its bore.
    """
    made = []
    for number, (name, axis, item, span) in enumerate(zip(names, axes, row, spans, strict=True)):
        start, end = radii.get((number, "start"), 0.0), radii.get((number, "end"), 0.0)
        cylinder = Cylinder(name, axis, item.radius, *span, start, end, 0.0, axis, *span)
        for hole in holes:
            inside = math.dist(hole.axis, axis) + hole.radius < item.radius
            through = hole.start < 0.5 * sum(span) < hole.end
            if inside and through and hole.radius > cylinder.bore_radius:
                cylinder = replace(
                    cylinder,
                    bore_radius=hole.radius,
                    bore_axis=hole.axis,
                    bore_start=hole.start,
                    bore_end=hole.end,
                )
        made.append(cylinder)
    return tuple(made)


def turned_place(axis: Point, turn: float) -> Point:
    """Turn a place about the shaft axis [m, rad]."""
    sine, cosine = math.sin(turn), math.cos(turn)
    return (cosine * axis[0] - sine * axis[1], sine * axis[0] + cosine * axis[1])


def hole_along(item: Round, turn: float, shift: float) -> Cylinder:
    """A hole in the throw frame, as the bore of a cylinder that the size fields know."""
    axis, radius = turned_place(item.axis, turn), -item.radius
    start, end = item.low + shift, item.high + shift
    return Cylinder(BORE, axis, radius, start, end, 0.0, 0.0, radius, axis, start, end)
