"""Element sizes told to gmsh: by the distance from where elements are small, or by a size map."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geometry.drilling import distance_from_exits, distance_from_wall
from geometry.parts import Cylinder, ThrowParts
from geometry.sizes import (
    EXITS,
    GROWTH,
    LARGEST_ON_ROUND,
    ROUND,
    SizeMap,
    SizePlan,
    SizeZone,
    growth_from_hole,
    largest_on_hole,
)
from geometry.solid import BORE, OIL_HOLE, Zone

# Elements are as small as at a fillet up to this share of its radius from the circle through its middle.
NEAR_FILLET = 0.5
FROM_OIL_HOLE = {OIL_HOLE: distance_from_wall, EXITS: distance_from_exits}


def set_sizes(gmsh: Any, parts: ThrowParts, plan: SizePlan, last: float) -> None:
    """Set the size field of the current model by the plan for a throw.

    Parameters
    ----------
    gmsh : module
        With the solid built.
    parts : ThrowParts
    plan : SizePlan
    last : float
        Where the solid ends along z; zones beyond are left out.
    """
    fields = []
    for zone in plan.zones:
        number, place = zone.zone
        if place in FROM_OIL_HOLE:
            distance = _formula(gmsh, FROM_OIL_HOLE[place](parts.drillings[number]))
            fields.append(_growing(gmsh, distance, zone.size, plan.bulk, growth=zone.growth))
            continue
        cylinder = parts.cylinders[number]
        if place in (BORE, ROUND):
            fields.append(_beside_cylinder(gmsh, *_surface(cylinder, place), zone.size, plan.bulk))
        elif (cylinder.start if place == "start" else cylinder.end) < last:
            fields.append(_beside_fillet(gmsh, cylinder, zone, plan.bulk))
    _set_least(gmsh, fields)


def set_face_sizes(
    gmsh: Any,
    holes: Sequence[Cylinder],
    fillets: Mapping[Zone, Sequence[int]],
    corners: Mapping[Zone, Sequence[int]],
    plan: SizePlan,
) -> None:
    """Set the size field of the current model by the plan for a CAD part.

    Parameters
    ----------
    gmsh : module
        With the solid read.
    holes : sequence of Cylinder
        Each as the bore of a cylinder; the plan's bores number them.
    fillets, corners : mapping
        Tags of the surfaces and curves of the plan's other zones.
    plan : SizePlan
    """
    fields = []
    groups: dict[tuple[str, float], list[int]] = {}
    for zone in plan.zones:
        if zone.zone[1] == BORE:
            hole = holes[zone.zone[0]]
            fields.append(_beside_cylinder(gmsh, *_surface(hole, BORE), zone.size, plan.bulk))
            continue
        key, tags = ("CurvesList", corners) if zone.sharp else ("SurfacesList", fillets)
        if zone.zone in tags:
            groups.setdefault((key, zone.size), []).extend(tags[zone.zone])
    for (key, size), found in groups.items():
        distance = gmsh.model.mesh.field.add("Distance")
        gmsh.model.mesh.field.setNumbers(distance, key, found)
        gmsh.model.mesh.field.setNumber(distance, "Sampling", 40)
        fields.append(_growing(gmsh, distance, size, plan.bulk))
    _set_least(gmsh, fields)


def set_size_map(
    gmsh: Any, sizes: SizeMap, factor: float, parts: ThrowParts | None = None, unit: float = 1.0
) -> None:
    """Let a size map rule the current model.

    Parameters
    ----------
    gmsh : module
    sizes : SizeMap
    factor : float
        Scales all sizes.
    parts : ThrowParts, optional
        On whose journals, bores and oil holes elements stay small beside the radius, whatever the map says.
    unit : float
        Length of 1 in the model [m].
    """
    points, wished = sizes.points / unit, factor * sizes.sizes / unit
    corners = points[sizes.tetrahedra].transpose(0, 2, 1).reshape(-1, 12)
    values = wished[sizes.tetrahedra]
    view = gmsh.view.add("sizes")
    gmsh.view.addListData(view, "SS", len(corners), np.hstack([corners, values]).ravel())
    field = gmsh.model.mesh.field.add("PostView")
    gmsh.model.mesh.field.setNumber(field, "ViewTag", view)
    # Points beside the straight elements of a curved surface take the size of the closest node.
    gmsh.model.mesh.field.setNumber(field, "UseClosest", 1)
    fields = [field]
    x, y, z = points.T
    bulk = float(wished.max())
    for hole in parts.drillings if parts else ():
        if (largest := largest_on_hole(sizes.first_factor) * hole.radius) < bulk:
            distance = _formula(gmsh, distance_from_wall(hole))
            growth = growth_from_hole(sizes.first_factor)
            fields.append(_growing(gmsh, distance, largest, bulk, growth=growth))
    for cylinder in parts.cylinders if parts else ():
        for place in (ROUND, BORE):
            axis, radius, start, end = _surface(cylinder, place)
            largest = LARGEST_ON_ROUND * radius
            beyond = np.maximum(np.abs(z - 0.5 * (start + end)) - 0.5 * (end - start), 0.0)
            off = np.hypot(np.hypot(x - axis[0], y - axis[1]) - radius, beyond)
            if radius > 0.0 and np.any(wished > largest + GROWTH * off):
                fields.append(_beside_cylinder(gmsh, axis, radius, start, end, largest, bulk))
    _set_least(gmsh, fields)


def _surface(cylinder: Cylinder, place: str) -> tuple[tuple[float, float], float, float, float]:
    """Axis, radius, start and end of a cylinder's own surface, or of its bore's."""
    if place == BORE:
        ends = cylinder.bore_start, cylinder.bore_end
        return cylinder.bore_axis, cylinder.bore_radius, *ends
    return cylinder.axis, cylinder.radius, cylinder.start, cylinder.end


def _beside_cylinder(
    gmsh: Any,
    axis: tuple[float, float],
    radius: float,
    start: float,
    end: float,
    size: float,
    bulk: float,
) -> int:
    """Let elements grow from a cylinder's surface."""
    middle, half = 0.5 * (start + end), 0.5 * (end - start)
    beyond = f"0.5*(Abs(z-({middle!r}))-{half!r}+Abs(Abs(z-({middle!r}))-{half!r}))"
    formula = f"Sqrt(({_radius(axis)}-{radius!r})^2+({beyond})^2)"
    return _growing(gmsh, _formula(gmsh, formula), size, bulk)


def _beside_fillet(gmsh: Any, cylinder: Cylinder, zone: SizeZone, bulk: float) -> int:
    """Let elements grow from a fillet or a sharp corner at an end of a cylinder."""
    if zone.zone[1] == "start":
        fillet, end, inward = cylinder.start_fillet, cylinder.start, 1.0
    else:
        fillet, end, inward = cylinder.end_fillet, cylinder.end, -1.0
    off = (1.0 - math.sqrt(0.5)) * fillet  # where the fillet's middle lies off cylinder and web
    along = f"z-({end + inward * off!r})"
    formula = f"Sqrt(({_radius(cylinder.axis)}-{cylinder.radius + off!r})^2+({along})^2)"
    return _growing(gmsh, _formula(gmsh, formula), zone.size, bulk, NEAR_FILLET * fillet)


def _radius(axis: tuple[float, float]) -> str:
    """Formula of the distance from an axis."""
    return f"Sqrt((x-({axis[0]!r}))^2+(y-({axis[1]!r}))^2)"


def _formula(gmsh: Any, formula: str) -> int:
    """Field of a formula in x, y, z: sampling surfaces takes gmsh far longer."""
    made = int(gmsh.model.mesh.field.add("MathEval"))
    gmsh.model.mesh.field.setString(made, "F", formula)
    return made


def _growing(
    gmsh: Any, distance: int, size: float, bulk: float, near: float = 0.0, growth: float = GROWTH
) -> int:
    """Let elements grow from `size` at a distance to the bulk's size."""
    field = gmsh.model.mesh.field
    made = int(field.add("Threshold"))
    field.setNumber(made, "InField", distance)
    field.setNumber(made, "SizeMin", size)
    field.setNumber(made, "SizeMax", bulk)
    field.setNumber(made, "DistMin", near)
    field.setNumber(made, "DistMax", near + (bulk - size) / growth + 1e-6 * bulk)
    return made


def _set_least(gmsh: Any, fields: list[int]) -> None:
    """Let the least of several fields rule the model."""
    field = gmsh.model.mesh.field
    if len(fields) > 1:
        least = field.add("Min")
        field.setNumbers(least, "FieldsList", fields)
        fields = [least]
    field.setAsBackgroundMesh(fields[0])
