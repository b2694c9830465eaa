"""How a throw's surface moves when a dimension changes: the velocity of each node of its mesh's surface.

All surfaces of a throw are level sets of functions of its parts: planes, cylinders, tori and the faces
over a web's outline. A point on a level s(x, p) = 0 stays on it while the dimension p grows if it moves
along the normal by -(ds/dp) / |grad s|; along the surface it may move as it likes.
"""

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError, MeshError
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.parts import Arc, ThrowParts, WebPlate
from geometry.solid import OIL_HOLE, part_end
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record, values_by_path

Array = NDArray[np.float64]
Level = Callable[[Array], Array]

# Why a dimension has no slope, mostly.
ZERO = "it is zero: the throw has another shape with it"
# Of the surface of a cylinder, where its fillet starts: no bounding surface.
EDGE = "edge of"
# Parts that are meshed, the larger ones first.
PARTS = ("full", "half", "quarter")
# A facet lies on a level whose distance from its corners is below this share of the throw's length.
ON_LEVEL = 1e-6
# Of a dimension, and of the throw's length, for central differences of smooth functions.
STEP = 1e-5


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

    nodes: NDArray[np.int64]
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
    levels = bounding_levels(throw.parts, mesh.part)
    facets = six_node_triangles(mesh, np.concatenate(list(mesh.surfaces.values())))
    on_surface, places = np.unique(facets, return_inverse=True)
    points = mesh.points[on_surface]
    distances = np.array([np.abs(level(points)) for level in levels.values()])
    distances = distances[:, places.reshape(facets.shape)]
    # By the corners: edge nodes of mended elements lie beside the surface, and follow their corners.
    on_level = distances < ON_LEVEL * mesh.length
    apart = np.where(on_level[:, :, :3].all(axis=2), distances.max(axis=2), np.inf)
    edges = [number for number, name in enumerate(levels) if name.startswith(EDGE)]
    apart[edges] = np.inf
    nearest = apart.argmin(axis=0)
    known = np.isfinite(apart.min(axis=0))
    rounded = [name == OIL_HOLE for name, corners in mesh.surfaces.items() for _ in corners]
    if not np.all(known | np.array(rounded)):
        raise MeshError("the mesh has facets on none of the throw's surfaces.")
    held = on_level[nearest, np.arange(len(facets))] & known[:, None]
    # Beside the facets' surfaces, the ends of what a pin's loads act on, which nodes may not cross.
    pairs = [np.column_stack([np.repeat(nearest, 6)[held.ravel()], facets[held]])]
    for number in edges:
        nodes = facets[on_level[number] & on_level[number - 1]]
        pairs.append(np.column_stack([np.full(len(nodes), number), nodes]))
    numbers, nodes = np.unique(np.concatenate(pairs), axis=0).T
    normals = _normals(list(levels.values()), numbers, mesh.points[nodes], mesh.length * STEP)
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
        ends = [bounding_levels(end.parts, mesh.part) for end in (low, high)]
        if any(list(end) != list(levels) for end in ends):
            left_out[path] = "the throw's surfaces are others on both sides of it"
            continue
        less, more = (_values(list(end.values()), numbers, mesh.points[nodes]) for end in ends)
        speeds[path] = -(more - less) / (2.0 * STEP * value)
        beside[path] = (low, high)
    return BoundaryMotion(nodes, normals, speeds, beside, left_out)


def _values(levels: list[Level], numbers: NDArray[np.int64], points: Array) -> Array:
    values = np.empty(len(points))
    for number in np.unique(numbers):
        here = numbers == number
        values[here] = levels[number](points[here])
    return values


def _normals(levels: list[Level], numbers: NDArray[np.int64], points: Array, step: float) -> Array:
    """Unit normals of the levels, by central differences."""
    columns = [
        _values(levels, numbers, points + shift) - _values(levels, numbers, points - shift)
        for shift in step * np.eye(3)
    ]
    gradients = np.column_stack(columns)
    return np.asarray(gradients / np.linalg.norm(gradients, axis=1)[:, None])


def bounding_levels(parts: ThrowParts, part: str) -> dict[str, Level]:
    """Return the signed distances from all surfaces that bound a throw, by names of their own.

    After each fillet comes the plane where it starts. Rounded exits of oil holes are none of them.
    """
    levels: dict[str, Level] = {"left end": _plane(0.0), "right end": _plane(part_end(parts, part))}
    if part != "full":
        levels["crank plane"] = lambda x: x[:, 0]
    for cylinder in parts.cylinders:
        name, radius = cylinder.name, cylinder.radius
        levels[name] = _round(cylinder.axis, radius)
        if cylinder.bore_radius:
            levels[f"bore of {name}"] = _round(cylinder.bore_axis, cylinder.bore_radius)
            levels[f"start of bore of {name}"] = _plane(cylinder.bore_start)
            levels[f"end of bore of {name}"] = _plane(cylinder.bore_end)
        for end, fillet, z in (
            ("start", cylinder.start_fillet, cylinder.start + cylinder.start_fillet),
            ("end", cylinder.end_fillet, cylinder.end - cylinder.end_fillet),
        ):
            if fillet:
                levels[f"{end} fillet of {name}"] = _torus(cylinder.axis, radius, fillet, z)
                levels[f"{EDGE} {end} fillet of {name}"] = _plane(z)
    for web in parts.webs:
        levels |= {f"{web.name} {name}": level for name, level in _web_levels(web)}
    for hole in parts.drillings:
        levels[f"oil hole {hole.number}"] = _drilled(hole.local, hole.radius)
        if not hole.through:
            levels[f"end of oil hole {hole.number}"] = _bottom(hole.local, hole.inner_end)
    return levels


def _web_levels(web: WebPlate) -> Iterator[tuple[str, Level]]:
    # Between the halves of a split pin there is no web, but what one half stands over the other.
    yield "start", _plane(web.start)
    if web.end <= web.start:
        return
    yield "end", _plane(web.end)
    for number, piece in enumerate(web.outline.pieces):
        (u_0, v_0), (u_1, v_1) = piece.start, piece.end
        if isinstance(piece, Arc):
            yield f"arc {number}", _over(web, _circle(piece.center, piece.radius))
        else:
            yield f"side {number}", _over(web, _line(u_0, v_0, u_1 - u_0, v_1 - v_0))
    for slope in web.slopes:
        run, fall = slope.end - slope.start, slope.inward * slope.drop
        # In v and z: through the face where the slope starts.
        yield f"slope {slope.towards:+.0f}", _inclined(web, slope.start, slope.face, run, fall)
    if sector := web.sector:
        yield "start of counterweight", _plane(sector.start)
        yield "end of counterweight", _plane(sector.end)
        yield "counterweight", _over(web, _circle((0.0, 0.0), sector.outer_radius))
        if sector.inner_radius:
            yield "inside of counterweight", _over(web, _circle((0.0, 0.0), sector.inner_radius))
        sine, cosine = math.sin(sector.half_angle), math.cos(sector.half_angle)
        yield "edge of counterweight", _over(web, _line(0.0, 0.0, sine, -cosine))


def _plane(z: float) -> Level:
    return lambda x: x[:, 2] - z


def _round(axis: tuple[float, float], radius: float) -> Level:
    return lambda x: np.hypot(x[:, 0] - axis[0], x[:, 1] - axis[1]) - radius


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


def _line(u: float, v: float, du: float, dv: float) -> Callable[[Array, Array], Array]:
    size = math.hypot(du, dv)
    return lambda along, up: ((along - u) * dv - (up - v) * du) / size


def _inclined(web: WebPlate, start: float, face: float, run: float, fall: float) -> Level:
    size = math.hypot(run, fall)
    return lambda x: ((x[:, 2] - face) * run - (_across(web, x)[1] - start) * fall) / size


def _drilled(local: Callable[[Array], Array], radius: float) -> Level:
    def level(x: Array) -> Array:
        p, q, _ = local(x).T
        return np.asarray(np.hypot(p, q) - radius)

    return level


def _bottom(local: Callable[[Array], Array], end: float) -> Level:
    return lambda x: local(x)[:, 2] - end
