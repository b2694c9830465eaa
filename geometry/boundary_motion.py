"""How a throw's surface moves when a dimension changes: the velocity of each node of its mesh's surface.

All surfaces of a throw are level sets of functions of its parts: planes, cylinders, tori and the faces
over a web's outline. A point on a level s(x, p) = 0 stays on it while the dimension p grows if it moves
along the normal by -(ds/dp) / |grad s|; along the surface it may move as it likes, but where two surfaces
touch, as a fillet and its web: there each keeps its nodes.

Surfaces of several parts may have the same level, as counterweights of equal radius: a facet follows
the part that it bounds. Two parts never end in the same place on the same level, because checks of a throw
keep small steps out of it.
"""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, Integers
from crankbase.errors import InputError, MeshError
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.parts import Arc, Cylinder, Drilling, Point, Sector, ThrowParts, WebPlate
from geometry.solid import OIL_HOLE, part_end
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record, values_by_path

Bools = NDArray[np.bool_]
Level = Callable[[Array], Array]

# Why a dimension has no slope, mostly.
ZERO = "it is zero: the throw has another shape with it"
# Parts that are meshed, the larger ones first.
PARTS = ("full", "half", "quarter")
# A facet lies on a level whose distance from its corners is below this share of the throw's length.
ON_LEVEL = 1e-6
# Of a dimension, and of the throw's length, for central differences of smooth functions.
STEP = 1e-5


class Surface(NamedTuple):
    """A surface of a part of a throw.

    Attributes
    ----------
    level : callable
        Signed distance from it of points (n, 3) [m].
    reaches : callable
        Which points (n, 3) on its level can be on that part.
    within : str
        Of the line where a surface ends that touches another without an edge: its name. Such a line bounds
        nothing; nodes of that surface stay on it.
    """

    level: Level
    reaches: Callable[[Array], Bools] = lambda x: np.ones(len(x), dtype=bool)
    within: str = ""


@dataclass(frozen=True)
class BoundaryMotion:
    """What a dimension prescribes of the motion of the nodes on a mesh's surface.

    Attributes
    ----------
    nodes : (c,) array
        Node of each condition; nodes on edges and in corners have several.
    normals : (c, 3) array
        Unit normal of the surface there.
    speeds : dict of str to (c,) array
        Velocity along the normal, by dimension [per unit of the dimension].
    beside : dict of str to two CrankThrow
        The throw with the dimension smaller and larger by the share `STEP`.
    left_out : dict of str to str
        Dimensions that have none, and the reason.
    """

    nodes: Integers
    normals: Array
    speeds: dict[str, Array]
    beside: dict[str, tuple[CrankThrow, CrankThrow]]
    left_out: dict[str, str]


def lengths_of(throw: CrankThrow) -> dict[str, float]:
    """Return the dimensions of a throw that have a number, without oil holes, by path."""
    return {
        path: value
        for path, value in values_by_path(throw)
        if isinstance(value, float) and not path.startswith("oil_holes.")
    }


def with_length(throw: CrankThrow, path: str, value: float) -> CrankThrow:
    """Return a throw with another value of a dimension.

    Raises
    ------
    InputError
        If it cannot be built.
    """
    return CrankThrow(**changed_record(throw.model_dump(), {path: value}))


def boundary_motion(
    throw: CrankThrow, mesh: ThrowMesh, paths: Collection[str] | None = None
) -> BoundaryMotion:
    """Find the motion of a mesh's surface under dimensions of its throw: all, or those at some paths.

    Rounded exits of oil holes are left free.

    Raises
    ------
    MeshError
        If a facet lies on no other surface of the throw.
    """
    surfaces = bounding_surfaces(throw.parts, mesh.part)
    levels = [surface.level for surface in surfaces.values()]
    numbers, nodes = surface_conditions(surfaces, mesh)
    points = mesh.points[nodes]
    gradients = np.column_stack(
        [
            level_values(levels, numbers, points + shift)
            - level_values(levels, numbers, points - shift)
            for shift in mesh.length * STEP * np.eye(3)
        ]
    )
    normals = np.asarray(gradients / np.linalg.norm(gradients, axis=1)[:, None])
    speeds, beside, left_out = {}, {}, {}
    for path, value in lengths_of(throw).items():
        if paths is not None and path not in paths:
            continue
        if value == 0.0:
            left_out[path] = ZERO
            continue
        try:
            low, high = (
                with_length(throw, path, value * factor) for factor in (1.0 - STEP, 1.0 + STEP)
            )
        except InputError as error:
            left_out[path] = f"next to it no throw can be built ({error})"
            continue
        if any(PARTS.index(end.symmetry) < PARTS.index(mesh.part) for end in (low, high)):
            left_out[path] = f"next to it the {mesh.part} that is meshed does not make up the throw"
            continue
        ends = [bounding_surfaces(end.parts, mesh.part) for end in (low, high)]
        if any(list(end) != list(surfaces) for end in ends):
            left_out[path] = "the throw's surfaces are others on both sides of it"
            continue
        less, more = (
            level_values([surface.level for surface in end.values()], numbers, points)
            for end in ends
        )
        speeds[path] = -(more - less) / (2.0 * STEP * value)
        beside[path] = (low, high)
    return BoundaryMotion(nodes, normals, speeds, beside, left_out)


def surface_conditions(
    surfaces: Mapping[str, Surface], mesh: ThrowMesh
) -> tuple[Integers, Integers]:
    """Number of the surface (c,) and node (c,) of each condition on a mesh's nodes, by ascending surface.

    Raises
    ------
    MeshError
        If a facet lies on none of the surfaces.
    """
    names = list(surfaces)
    facets = six_node_triangles(mesh, np.concatenate(list(mesh.surfaces.values())))
    on_surface, places = np.unique(facets, return_inverse=True)
    points = mesh.points[on_surface]
    distances = np.array([np.abs(surface.level(points)) for surface in surfaces.values()])
    distances = distances[:, places.reshape(facets.shape)]
    # By the corners: edge nodes of mended elements lie beside the surface, and follow their corners.
    on_level = distances < ON_LEVEL * mesh.length
    apart = np.where(on_level[:, :, :3].all(axis=2), distances.max(axis=2), np.inf)
    apart[[bool(surface.within) for surface in surfaces.values()]] = np.inf
    known = np.isfinite(apart.min(axis=0))
    rounded = [name == OIL_HOLE for name, corners in mesh.surfaces.items() for _ in corners]
    if not np.all(known | np.array(rounded)):
        raise MeshError("the mesh has facets on none of the throw's surfaces.")
    middles = mesh.points[facets[:, :3]].mean(axis=1)
    bounding = np.isfinite(apart) & [surface.reaches(middles) for surface in surfaces.values()]
    nearest = np.where(bounding | ~bounding.any(axis=0), apart, np.inf).argmin(axis=0)
    held = on_level[nearest, np.arange(len(facets))] & known[:, None]
    pairs = [np.column_stack([np.repeat(nearest, 6)[held.ravel()], facets[held]])]
    for number, surface in enumerate(surfaces.values()):
        if surface.within:
            whose = names.index(surface.within)
            nodes = facets[(nearest == whose)[:, None] & on_level[number] & on_level[whose]]
            pairs.append(np.column_stack([np.full(len(nodes), number), nodes]))
    numbers, nodes = np.unique(np.concatenate(pairs), axis=0).T
    return numbers, nodes


def level_values(levels: list[Level], numbers: Integers, points: Array) -> Array:
    """Value of each point's level (c,); numbers ascend."""
    starts = np.flatnonzero(np.diff(numbers, prepend=-1))
    parts = zip(numbers[starts].tolist(), np.split(points, starts[1:]), strict=True)
    return np.concatenate([levels[number](there) for number, there in parts])


def bounding_surfaces(parts: ThrowParts, part: str) -> dict[str, Surface]:
    """Return all surfaces that bound a throw, and the lines where such touch, by names of their own.

    Rounded exits of oil holes are none of them.
    """
    surfaces = {
        "left end": Surface(_plane(0.0)),
        "right end": Surface(_plane(part_end(parts, part))),
    }
    if part != "full":
        surfaces["crank plane"] = Surface(lambda x: x[:, 0])
    for cylinder in parts.cylinders:
        surfaces |= _cylinder_surfaces(cylinder)
    for web in parts.webs:
        surfaces |= {f"{web.name} {name}": surface for name, surface in _web_surfaces(web)}
        if web.sector:
            surfaces |= _sector_surfaces(web, web.sector)
    for hole in parts.drillings:
        surfaces |= _hole_surfaces(hole)
    return surfaces


def _cylinder_surfaces(cylinder: Cylinder) -> dict[str, Surface]:
    name, axis, radius = cylinder.name, cylinder.axis, cylinder.radius
    surfaces = {name: Surface(_round(axis, radius), _between(cylinder.start, cylinder.end))}
    if cylinder.bore_radius:
        wall = _round(cylinder.bore_axis, cylinder.bore_radius)
        first, last = cylinder.bore_start, cylinder.bore_end
        surfaces |= {
            f"bore of {name}": Surface(wall, _between(first, last)),
            f"start of bore of {name}": Surface(_plane(first), lambda x: wall(x) < 0.0),
            f"end of bore of {name}": Surface(_plane(last), lambda x: wall(x) < 0.0),
        }
    for end, fillet, web, z in (
        ("start", cylinder.start_fillet, cylinder.start, cylinder.start + cylinder.start_fillet),
        ("end", cylinder.end_fillet, cylinder.end, cylinder.end - cylinder.end_fillet),
    ):
        if fillet:
            fillet_name = f"{end} fillet of {name}"
            reaches = _between(min(web, z), max(web, z))
            surfaces[fillet_name] = Surface(_torus(axis, radius, fillet, z), reaches)
            surfaces[f"journal's end of {fillet_name}"] = Surface(_plane(z), within=fillet_name)
            surfaces[f"web's end of {fillet_name}"] = Surface(
                _round(axis, radius + fillet), within=fillet_name
            )
    return surfaces


def _web_surfaces(web: WebPlate) -> Iterator[tuple[str, Surface]]:
    def over(x: Array) -> Bools:
        u, v = _across(web, x)
        return np.asarray(u < web.outline.half_width(v))

    # Between the halves of a split pin there is no web, but what one half stands over the other.
    if web.end <= web.start:
        yield "start", Surface(_plane(web.start))
        return
    yield "start", Surface(_plane(web.start), over)
    yield "end", Surface(_plane(web.end), over)
    beside = _between(web.start, web.end)
    for number, piece in enumerate(web.outline.pieces):
        if not isinstance(piece, Arc):
            yield f"side {number}", Surface(_over(web, _line(piece.start, piece.end)), beside)
            continue
        yield f"arc {number}", Surface(_over(web, _circle(piece.center, piece.radius)), beside)
        for end, joint in (("start", piece.start), ("end", piece.end)):
            if joint[0] > 0.0:
                across = _over(web, _line(piece.center, joint))
                yield f"{end} of arc {number}", Surface(across, within=f"{web.name} arc {number}")
    for slope in web.slopes:
        run, fall = slope.end - slope.start, slope.inward * slope.drop
        # In v and z: through the face where the slope starts.
        inclined = _inclined(web, slope.start, slope.face, run, fall)
        yield f"slope {slope.towards:+.0f}", Surface(inclined, over)


def _sector_surfaces(web: WebPlate, sector: Sector) -> dict[str, Surface]:
    whole, thick = sector.half_angle, _between(sector.start, sector.end)

    def ring(x: Array) -> Bools:
        radii = np.hypot(*_across(web, x))
        return (radii > sector.inner_radius) & (radii < sector.outer_radius)

    def spanned(x: Array) -> Bools:
        u, v = _across(web, x)
        return np.asarray(np.arctan2(u, -v) < whole)

    def face(x: Array) -> Bools:
        return ring(x) & spanned(x)

    def rim(x: Array) -> Bools:
        return thick(x) & spanned(x)

    center = (0.0, 0.0)
    edge = _line(center, (math.sin(whole), -math.cos(whole)))
    surfaces = {
        "start of": Surface(_plane(sector.start), face),
        "end of": Surface(_plane(sector.end), face),
        "outside of": Surface(_over(web, _circle(center, sector.outer_radius)), rim),
        "edge of": Surface(_over(web, edge), lambda x: thick(x) & ring(x)),
    }
    if sector.inner_radius:
        inside = _over(web, _circle(center, sector.inner_radius))
        surfaces["inside of"] = Surface(inside, rim)
    return {f"{place} {web.name} counterweight": each for place, each in surfaces.items()}


def _between(start: float, end: float) -> Callable[[Array], Bools]:
    return lambda x: (x[:, 2] > start) & (x[:, 2] < end)


def _plane(z: float) -> Level:
    return lambda x: x[:, 2] - z


def _round(axis: tuple[float, float], radius: float) -> Level:
    return lambda x: np.hypot(x[:, 0] - axis[0], x[:, 1] - axis[1]) - radius


def _hole_surfaces(hole: Drilling) -> dict[str, Surface]:
    def wall(x: Array) -> Array:
        p, q, _ = hole.local(x).T
        return np.asarray(np.hypot(p, q) - hole.radius)

    surfaces = {f"oil hole {hole.number}": Surface(wall)}
    if not hole.through:
        end = Surface(lambda x: hole.local(x)[:, 2] - hole.inner_end)
        surfaces[f"end of oil hole {hole.number}"] = end
    return surfaces


def _torus(axis: tuple[float, float], radius: float, fillet: float, z: float) -> Level:
    reach = _round(axis, radius + fillet)
    return lambda x: np.hypot(reach(x), x[:, 2] - z) - fillet


def _across(web: WebPlate, x: Array) -> tuple[Array, Array]:
    (a, b), (x_0, y_0) = web.direction, web.foot
    along, up = x[:, 0] - x_0, x[:, 1] - y_0
    return np.abs(along * b - up * a), along * a + up * b


def _over(web: WebPlate, outline: Callable[[Array, Array], Array]) -> Level:
    return lambda x: outline(*_across(web, x))


def _circle(center: tuple[float, float], radius: float) -> Callable[[Array, Array], Array]:
    return lambda u, v: np.hypot(u - center[0], v - center[1]) - radius


def _line(start: Point, end: Point) -> Callable[[Array, Array], Array]:
    (u, v), (du, dv) = start, (end[0] - start[0], end[1] - start[1])
    size = math.hypot(du, dv)
    return lambda along, up: ((along - u) * dv - (up - v) * du) / size


def _inclined(web: WebPlate, start: float, face: float, run: float, fall: float) -> Level:
    size = math.hypot(run, fall)
    return lambda x: ((x[:, 2] - face) * run - (_across(web, x)[1] - start) * fall) / size
