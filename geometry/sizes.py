"""Element sizes of a throw's mesh, and how many unknowns they will make.

They are planned from the throw's dimensions (small at fillets, sharp corners and bores, growing into the
bulk), or given at the nodes of an earlier mesh, for refining where that one was too coarse.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from crankbase.array_checks import Array, Integers
from geometry.parts import (
    Cylinder,
    Drilling,
    ThrowParts,
    distance_from_exits,
    distance_from_wall,
    throw_volume,
)
from geometry.shapes import outer_facets
from geometry.solid import BORE, OIL_HOLE, Zone

# Element sizes at factor 1, found by converging ordinary throws: at fillets beside their radius and,
# for large fillets, beside the web thickness; at sharp corners beside the web thickness; and how much
# elements grow per unit of distance from there.
ROOT_PER_FILLET = 0.8
FILLET_ROOT_PER_WEB = 0.20
ROOT_PER_WEB = 0.10
GROWTH = 0.5
# At bores, beside their radius and the wall round them.
SIZE_PER_BORE = 0.9
SIZE_PER_WALL = 1.5
# At journals, pins and bores beside their radius at any factor: larger ones cut chords off a cylinder.
LARGEST_ON_ROUND = 0.8
# On walls and exits of oil holes on the coarsest meshes, beside their radius and the factor, and at any.
COARSE_ON_HOLE, COARSE_ON_EXIT = 0.3, 0.4
COARSEST_ON_HOLE, COARSEST_ON_EXIT = 1.3, 1.8
# How much elements grow from oil holes on coarse meshes, beside the factor, and at most.
COARSE_GROWTH, FASTEST_GROWTH = 0.15, 1.0
ROUND, EXITS = "round", "exits"
# Nodes per item of `node_counts`, fitted to meshes of mixed throws (tests/campaigns/random_throws.py).
NODES_PER_COUNT = np.array([7.5, 7.5, 9.3, 3.9, 9.6])
LAYERS = 100
# Nodes of a mesh made from a map, for each regular element that the map asks for, and for each facet of
# the surface, cuts included; fitted to meshes of quarters, halves and whole throws.
NODES_PER_ELEMENT = 0.47
NODES_PER_FACET = 4.2
SHARES = {"quarter": 0.25, "half": 0.5, "full": 1.0}


@dataclass(frozen=True)
class SizeZone:
    """A region where elements are small.

    Attributes
    ----------
    zone : Zone
        The cylinder and one of its ends, or its bore, or all of its own surface ("round").
    sharp : bool
        Whether it is a sharp corner (a curve) rather than a surface.
    size : float
        Element size there [m].
    length : float
        Length round the cylinder [m].
    area : float
        Area of the surface, 0 for a corner [m^2].
    growth : float
        How much elements grow per unit of distance from it.
    """

    zone: Zone
    sharp: bool
    size: float
    length: float
    area: float
    growth: float = GROWTH


@dataclass(frozen=True)
class SizePlan:
    """Element sizes of a throw: in the bulk [m], and where they are smaller."""

    bulk: float
    zones: tuple[SizeZone, ...]

    def reach(self, zone: SizeZone) -> float:
        """Distance from a zone at which elements have grown to the bulk's size [m]."""
        return (self.bulk - zone.size) / zone.growth


def size_plan(parts: ThrowParts, factor: float) -> SizePlan:
    """Choose element sizes.

    Parameters
    ----------
    factor : float
        Scales all sizes; 1 gives about 1 % accuracy of the axial compliance.
    """
    webs = [web for web in parts.webs if web.end > web.start]
    thinnest = min(web.end - web.start for web in webs)
    bulk = factor * min(thinnest, *(pin.radius for pin in parts.pins))
    zones: list[SizeZone] = []
    for number, cylinder in enumerate(parts.cylinders):
        ends = []
        if number > 0:
            ends.append(("start", cylinder.start_fillet, parts.webs[number - 1]))
        if number < len(parts.cylinders) - 1:
            ends.append(("end", cylinder.end_fillet, parts.webs[number]))
        for end, fillet, web in ends:
            thickness = web.end - web.start if web.end > web.start else thinnest
            size = factor * root_size(fillet, thickness)
            zones.append(root_zone((number, end), cylinder.radius, fillet, min(bulk, size)))
        if cylinder.bore_radius > 0.0:
            apart = math.dist(cylinder.axis, cylinder.bore_axis)
            wall = cylinder.radius - cylinder.bore_radius - apart
            size = factor * min(SIZE_PER_BORE * cylinder.bore_radius, SIZE_PER_WALL * wall)
            largest = LARGEST_ON_ROUND * cylinder.bore_radius
            zones.append(bore_zone(number, cylinder, min(bulk, size, largest)))
        if LARGEST_ON_ROUND * cylinder.radius < bulk:
            length = 2.0 * math.pi * cylinder.radius
            area = length * (cylinder.end - cylinder.start)
            zones.append(
                SizeZone((number, ROUND), False, LARGEST_ON_ROUND * cylinder.radius, length, area)
            )
    for number, hole in enumerate(parts.drillings):
        wall = min(bulk, min(factor * SIZE_PER_BORE, largest_on_hole(factor)) * hole.radius)
        largest = max(1.0, min(COARSE_ON_EXIT * factor, COARSEST_ON_EXIT))
        outlet = min(
            wall, min(factor * ROOT_PER_FILLET, largest) * (hole.exit_radius or hole.radius)
        )
        zones += drilling_zones(number, hole, wall, outlet, growth_from_hole(factor))
    return SizePlan(bulk, tuple(zones))


def largest_on_hole(factor: float) -> float:
    """Largest size on an oil hole's wall beside its radius: some six elements round it, in the end five."""
    return min(max(LARGEST_ON_ROUND, COARSE_ON_HOLE * factor), COARSEST_ON_HOLE)


def growth_from_hole(factor: float) -> float:
    """How much elements grow per unit of distance from an oil hole."""
    return min(max(GROWTH, COARSE_GROWTH * factor), FASTEST_GROWTH)


def root_size(fillet: float, thickness: float) -> float:
    """Size of elements at a fillet of a radius, or at a sharp corner (0), on a web of a thickness [m]."""
    if fillet == 0.0:
        return ROOT_PER_WEB * thickness
    return min(ROOT_PER_FILLET * fillet, FILLET_ROOT_PER_WEB * thickness)


def root_zone(zone: Zone, radius: float, fillet: float, size: float) -> SizeZone:
    """Zone of a fillet, or of a sharp corner (0), round a cylinder of a radius [m]."""
    area = math.pi * math.pi * fillet * (radius + 0.36 * fillet)
    return SizeZone(zone, fillet == 0.0, size, 2.0 * math.pi * radius, area)


def bore_zone(number: int, cylinder: Cylinder, size: float) -> SizeZone:
    """Zone of a cylinder's bore."""
    length = 2.0 * math.pi * cylinder.bore_radius
    area = length * (cylinder.bore_end - cylinder.bore_start)
    return SizeZone((number, BORE), False, size, length, area)


def drilling_zones(
    number: int, hole: Drilling, wall: float, outlet: float, growth: float
) -> list[SizeZone]:
    """Zones of an oil hole: of its wall, and of its exits where these are finer."""
    length = 2.0 * math.pi * hole.radius
    area = 2.0 * hole.volume / hole.radius
    zones = [SizeZone((number, OIL_HOLE), False, wall, length, area, growth)]
    if outlet < wall:
        rounding = math.pi**2 * hole.exit_radius * (hole.radius + 0.36 * hole.exit_radius)
        exits = len(hole.exits)
        zone = (number, EXITS)
        zones.append(SizeZone(zone, False, outlet, exits * length, exits * rounding, growth))
    return zones


def predict_unknowns(parts: ThrowParts, factor: float, part: str) -> int:
    """Predict the number of displacement unknowns before meshing.

    Parameters
    ----------
    factor : float
        As for `size_plan`.
    part : {"quarter", "half", "full"}
        What will be meshed.
    """
    nodes = float(node_counts(parts, factor) @ NODES_PER_COUNT)
    return round(3.0 * SHARES[part] * nodes)


def node_counts(parts: ThrowParts, factor: float) -> Array:
    """What the number of nodes is made of, for the whole throw.

    Around a corner of length l, elements of size s(d) at a distance d fill layers of volume
    (3/2) pi l d dd; around a fillet or bore of area A layers of A dd, and beside a fillet those of its
    edges as well. The rest of the solid has the bulk size; surfaces have nodes of their own.

    Returns
    -------
    (5,) array
        Cells at sharp corners, cells at fillets and bores, faces of fillets and bores, cells in the
        bulk, faces of the outside.
    """
    plan = size_plan(parts, factor)
    counts = np.zeros(5)
    near = 0.0
    share = (np.arange(LAYERS) + 0.5) / LAYERS
    for zone in plan.zones:
        reach = plan.reach(zone)
        distance = reach * share
        flat = zone.zone[1] in (BORE, ROUND, OIL_HOLE)
        edges = 0.0 if flat else 1.5 * math.pi * zone.length * distance
        layers = (zone.area + edges) * reach / LAYERS
        cells = float(np.sum(layers / (zone.size + zone.growth * distance) ** 3))
        counts[0 if zone.sharp else 1] += cells
        counts[2] += zone.area / zone.size**2
        near += float(np.sum(layers))
    volume = throw_volume(parts)
    counts[3] = max(volume - near, 0.0) / plan.bulk**3
    # Rough area of the surface.
    area = sum(2.0 * math.pi * c.radius * (c.end - c.start) for c in parts.cylinders)
    for web in parts.webs:
        polygon = web.outline.polygon(12)
        height = web.outline.tip - web.outline.foot
        width = 2.0 * float(polygon[:, 0].max())
        area += 2.0 * width * height + 2.0 * (width + height) * (web.end - web.start)
        if web.sector is not None:
            area += 2.0 * web.sector.half_angle * web.sector.outer_radius**2
    counts[4] = area / plan.bulk**2
    return counts


@dataclass(frozen=True)
class SizeMap:
    """Required element sizes in and around a meshed part.

    Attributes
    ----------
    points : (n, 3) array
        Corner nodes [m].
    tetrahedra : (m, 4) array
        Numbers of corner nodes.
    sizes : (n,) array
        Required size of the elements at each node [m]; interpolated between nodes.
    first_factor : float
        Size factor of the first mesh, whose limits hold at oil holes.
    """

    points: Array
    tetrahedra: Integers
    sizes: Array
    first_factor: float = 1.0

    def expected_unknowns(self, factor: float = 1.0) -> int:
        """Predict the displacement unknowns of a mesh made with `factor` times these sizes."""
        corners = self.points[self.tetrahedra]
        volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
        sizes = factor * self.sizes[self.tetrahedra].mean(axis=1)
        elements = float(np.sum(volumes / regular_volume(sizes)))
        _, outside = outer_facets(self.tetrahedra)
        first, second, third = self.points[outside].transpose(1, 0, 2)
        areas = 0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1)
        sides = factor * self.sizes[outside].mean(axis=1)
        facets = float(np.sum(areas / (0.25 * np.sqrt(3.0) * sides**2)))
        return round(3.0 * (NODES_PER_ELEMENT * elements + NODES_PER_FACET * facets))


def element_sizes(points: Array, tetrahedra: Integers) -> Array:
    """Edges (m,) of regular tetrahedra with the volumes of these straight ones (m, 4) [m]."""
    corners = points[tetrahedra]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    return np.asarray(np.cbrt(volumes / regular_volume(np.ones(1))))


def sizes_at_corners(points: Array, tetrahedra: Integers, sizes: Array) -> SizeMap:
    """Size map of sizes (m,) of elements (m, 4): at each corner the geometric mean of those round it."""
    vertices, number = np.unique(tetrahedra, return_inverse=True)
    number = number.reshape(tetrahedra.shape)
    total = np.bincount(number.ravel(), np.repeat(np.log(sizes), 4))
    return SizeMap(points[vertices], number, np.exp(total / np.bincount(number.ravel())))


def regular_volume(size: Array) -> Array:
    """Volume of a regular tetrahedron with edges of that size [m^3]."""
    return np.asarray(size**3 / (6.0 * np.sqrt(2.0)))


# Elements are as small as at a fillet up to this share of its radius from the circle through its middle.
NEAR_FILLET = 0.5
FROM_OIL_HOLE = {OIL_HOLE: distance_from_wall, EXITS: distance_from_exits}


def set_sizes(gmsh: Any, parts: ThrowParts, plan: SizePlan, last: float) -> None:
    """Set the size field of the current model by the plan for a throw.

    Parameters
    ----------
    gmsh : module
        With the solid built.
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
            continue
        if place == "start":
            fillet, end, inward = cylinder.start_fillet, cylinder.start, 1.0
        else:
            fillet, end, inward = cylinder.end_fillet, cylinder.end, -1.0
        if end < last:
            # From a fillet, or a sharp corner; off is where the fillet's middle lies off cylinder and web.
            off = (1.0 - math.sqrt(0.5)) * fillet
            along = f"z-({end + inward * off!r})"
            formula = f"Sqrt(({_radius(cylinder.axis)}-{cylinder.radius + off!r})^2+({along})^2)"
            distance = _formula(gmsh, formula)
            fields.append(_growing(gmsh, distance, zone.size, plan.bulk, NEAR_FILLET * fillet))
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
    """
    fields = []
    groups: dict[tuple[str, float], list[int]] = {}
    for zone in plan.zones:
        if zone.zone[1] == BORE:
            hole = holes[zone.zone[0]]
            fields.append(_beside_cylinder(gmsh, *_surface(hole, BORE), zone.size, plan.bulk))
            continue
        key, tagged = ("CurvesList", corners) if zone.sharp else ("SurfacesList", fillets)
        if zone.zone in tagged:
            groups.setdefault((key, zone.size), []).extend(tagged[zone.zone])
    for (key, size), grouped_tags in groups.items():
        distance = gmsh.model.mesh.field.add("Distance")
        gmsh.model.mesh.field.setNumbers(distance, key, grouped_tags)
        gmsh.model.mesh.field.setNumber(distance, "Sampling", 40)
        fields.append(_growing(gmsh, distance, size, plan.bulk))
    _set_least(gmsh, fields)


def set_size_map(
    gmsh: Any, sizes: SizeMap, factor: float, parts: ThrowParts | None = None, unit: float = 1.0
) -> None:
    """Let a size map rule the current model.

    Parameters
    ----------
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
