"""Tell gmsh the element sizes: small at fillets, sharp corners and bores, growing into the bulk."""

from typing import Any

from geometry.parts import Cylinder, ThrowParts
from geometry.sizes import GROWTH, SizePlan
from geometry.solid import NamedSolid


def set_sizes(gmsh: Any, parts: ThrowParts, named: NamedSolid, plan: SizePlan) -> None:
    """Set the size field of the current model.

    Parameters
    ----------
    gmsh : module
        With the solid built.
    parts : ThrowParts
    named : NamedSolid
        Where fillets and corners are.
    plan : SizePlan
    """
    field = gmsh.model.mesh.field
    sizes = []
    for (key, size), tags in _groups(named, plan).items():
        distance = field.add("Distance")
        field.setNumbers(distance, key, tags)
        field.setNumber(distance, "Sampling", 40)
        sizes.append(_threshold(field, distance, size, plan))
    for zone in plan.zones:
        if zone.zone[1] == "bore":
            # A formula: sampling the bore's surface takes gmsh a second.
            distance = field.add("MathEval")
            field.setString(distance, "F", _distance_from_bore(parts.cylinders[zone.zone[0]]))
            sizes.append(_threshold(field, distance, zone.size, plan))
    if len(sizes) > 1:
        least = field.add("Min")
        field.setNumbers(least, "FieldsList", sizes)
        sizes = [least]
    field.setAsBackgroundMesh(sizes[0])


def _groups(named: NamedSolid, plan: SizePlan) -> dict[tuple[str, float], list[int]]:
    """Surfaces of fillets and curves of corners, those of one size together."""
    groups: dict[tuple[str, float], list[int]] = {}
    for zone in plan.zones:
        if zone.zone[1] == "bore":
            continue
        key, tags = ("CurvesList", named.corners) if zone.sharp else ("SurfacesList", named.fillets)
        if zone.zone in tags:  # a cut may have left it out
            groups.setdefault((key, zone.size), []).extend(tags[zone.zone])
    return groups


def _threshold(field: Any, distance: int, size: float, plan: SizePlan) -> int:
    """Let elements grow from `size` at distance 0 to the bulk's size."""
    made = int(field.add("Threshold"))
    field.setNumber(made, "InField", distance)
    field.setNumber(made, "SizeMin", size)
    field.setNumber(made, "SizeMax", plan.bulk)
    field.setNumber(made, "DistMin", 0.0)
    field.setNumber(made, "DistMax", (plan.bulk - size) / GROWTH + 1e-6 * plan.bulk)
    return made


def _distance_from_bore(cylinder: Cylinder) -> str:
    """Formula of the distance from a bore's surface in x, y, z."""
    x, y = cylinder.bore_axis
    middle = 0.5 * (cylinder.bore_start + cylinder.bore_end)
    half = 0.5 * (cylinder.bore_end - cylinder.bore_start)
    beyond = f"0.5*(Abs(z-({middle!r}))-{half!r}+Abs(Abs(z-({middle!r}))-{half!r}))"
    return f"Sqrt((Sqrt((x-({x!r}))^2+(y-({y!r}))^2)-{cylinder.bore_radius!r})^2+({beyond})^2)"
