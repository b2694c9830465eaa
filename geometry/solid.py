"""The solid of a throw in gmsh's OpenCASCADE kernel: whole, or its half or quarter by symmetry.

A throw whose pins all are in the crank plane is symmetric about x = 0: the half x >= 0 is
sufficient. If its webs are equal it is symmetric about the middle as well, and a quarter
is enough. The parts are built cut, since cutting a whole solid afterwards is slow and may fail.
"""

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array
from crankbase.errors import MeshError
from geometry.gmsh_session import curvature_radius, middle_point
from geometry.parts import (
    Arc,
    Cylinder,
    Drilling,
    Line,
    Sector,
    ThrowParts,
    WebPlate,
    scaled_parts,
)

Entity = tuple[int, int]
# Radius of a journal where the kernel rounds exits, like one of 200 mm in millimeters.
LARGE = 100.0
# A tool ends so far outside the journal's surface, beside its radius, that it cuts nothing else.
BEYOND = 1.01
# The kernel's curves and roundings keep to their surfaces by this share of the journal's radius.
CURVE_TOLERANCE = 1e-5
# Points of a curve that tell where it lies.
SAMPLES = 7


def drilled_journal(
    gmsh: Any,
    journal: Cylinder,
    drillings: Sequence[Drilling],
    limit: float,
    revolve: Callable[[Any, Cylinder, bool], Entity],
    whole: bool,
) -> Entity:
    """Make the solid of a pin or main journal with its oil holes.

    Holes are drilled before the journal is united with its webs, and their exits rounded where it is large:
    the kernel's roundings have tolerances of 1e-4, whatever the size, and fail in small or involved solids.

    Parameters
    ----------
    journal : Cylinder
        Part of it before z = `limit`.
    drillings : sequence of Drilling
        The throw's.
    limit : float
        Where the part that is built is cut [m].
    revolve : callable
        Makes a journal without holes in gmsh's current model, whole or the half x >= 0.
    whole : bool
        Whether it is built whole.

    Raises
    ------
    MeshError
        If the kernel does not find an exit, or cannot round it.
    """
    holes = []
    for hole in drillings:
        lowest = min(hole.place, *(float(outlet.point[2]) for outlet in hole.exits)) - hole.radius
        reach = max(float(outlet.point[0]) for outlet in hole.exits) + hole.radius
        if hole.journal == journal.name and lowest < limit and (whole or reach > hole.axis[0]):
            holes.append(hole)

    def make(cylinder: Cylinder, drilled: Sequence[Drilling]) -> Entity:
        solid = revolve(gmsh, cylinder, whole)
        if whole:
            # The surface's seam goes to the middle of the widest gap between exits.
            exits = [outlet.angle_deg for hole in drilled for outlet in hole.exits]
            angles = np.sort(np.radians(exits))
            gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
            widest = int(np.argmax(gaps))
            clear = float(angles[widest] + 0.5 * gaps[widest])
            gmsh.model.occ.rotate([solid], *cylinder.axis, 0.0, 0.0, 0.0, 1.0, clear)
        return _drilled(gmsh, cylinder, drilled, solid)

    if not holes:
        return revolve(gmsh, journal, whole)
    if not any(hole.exit_radius for hole in holes):
        return make(journal, holes)
    before, scale = gmsh.model.getCurrent(), journal.radius / LARGE
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "journal.brep")
        gmsh.model.add("journal")
        try:
            make(*scaled_parts((journal, tuple(holes)), 1.0 / scale))
            gmsh.model.occ.synchronize()
            gmsh.write(file)
        finally:
            gmsh.model.remove()
            gmsh.model.setCurrent(before)
        gmsh.option.setNumber("Geometry.OCCScaling", scale)
        try:
            made = gmsh.model.occ.importShapes(file)
        finally:
            gmsh.option.setNumber("Geometry.OCCScaling", 1.0)
    return _only_volume(made)


def _drilled(gmsh: Any, journal: Cylinder, holes: Sequence[Drilling], solid: Entity) -> Entity:
    """Cut holes out of a journal and round their exits."""
    occ = gmsh.model.occ
    tools = []
    length = journal.end - journal.start
    for hole in holes:
        # The volume cut by the drill, and a little space around the journal.
        reach = 2.0 * hole.journal_radius / np.cos(hole.tilt)
        start = -reach if hole.through else hole.inner_end
        low, way = hole.middle + start * hole.frame[2], (reach - start) * hole.frame[2]
        drill = (3, occ.addCylinder(*low.tolist(), *way.tolist(), hole.radius))
        place = (*hole.axis, journal.start - length, 0.0, 0.0, 3.0 * length)
        around = (3, occ.addCylinder(*place, BEYOND * hole.journal_radius))
        made, _ = occ.intersect([drill], [around])
        tools.append(_only_volume(made))
    made, _ = occ.cut([solid], tools)
    solid = _only_volume(made)
    radii: dict[int, float] = {}
    occ.synchronize()
    points = {}
    for _, curve in gmsh.model.getEntities(1):
        low, high = gmsh.model.getParametrizationBounds(1, curve)
        along = np.linspace(low[0], high[0], SAMPLES)
        sampled = np.asarray(gmsh.model.getValue(1, curve, along.tolist()), float)
        points[curve] = sampled.reshape(-1, 3)
    for hole in holes:
        if hole.exit_radius > 0.0:
            edges = [curve for curve, on in points.items() if _is_edge(hole, on)]
            if not edges:
                raise MeshError(f"the exits of oil hole {hole.number} were not found.")
            radii |= dict.fromkeys(edges, hole.exit_radius)
    if radii:
        solid = _only_volume(occ.fillet([solid[1]], list(radii), list(radii.values())))
    return solid


def on_drilling(gmsh: Any, parts: ThrowParts, kind: str, tag: int, point: ArrayLike) -> bool:
    """Whether a surface of a kind, with a point on it, belongs to an oil hole."""
    for hole in parts.drillings:
        if kind == "Cylinder" and abs(hole.radius / curvature_radius(gmsh, tag) - 1.0) > 1e-6:
            continue
        off, height = _places(hole, np.atleast_2d(point))
        tolerance = CURVE_TOLERANCE * hole.journal_radius
        if height[0] > hole.journal_radius + tolerance:
            continue
        if kind == "Cylinder" and abs(off[0] - hole.radius) < tolerance:
            return True
        if kind == "Plane" and off[0] <= hole.radius and not hole.through:
            along = float(hole.local(np.atleast_2d(point))[0, 2])
            if abs(along - hole.inner_end) < tolerance:
                return True
        widest = hole.radius + 2.0 * hole.exit_radius
        if kind not in ("Cylinder", "Plane", "Torus") and off[0] < widest:
            return True
    return False


def _places(hole: Drilling, points: Array) -> tuple[Array, Array]:
    """Distances of points (n, 3) from the hole's axis and from the journal's [m]."""
    p, q, _ = hole.local(points).T
    return np.hypot(p, q), np.linalg.norm(points[:, :2] - hole.axis, axis=1)


def _is_edge(hole: Drilling, points: Array) -> bool:
    """Whether a curve with these points is where the hole's wall meets the journal's surface."""
    off, height = _places(hole, points)
    tolerance = CURVE_TOLERANCE * hole.journal_radius
    on_both = (np.abs(off - hole.radius) < tolerance) & (
        np.abs(height - hole.journal_radius) < tolerance
    )
    near = np.abs(points[:, 2] - hole.place) < 3.0 * hole.journal_radius
    return bool(np.all(on_both & near))


# Names of the surfaces, used for supports, loads and symmetry conditions.
LEFT_END = "left end"
RIGHT_END = "right end"
CRANK_PLANE = "crank plane"
MIDDLE_PLANE = "middle plane"
PIN = "pin"
MAIN_JOURNAL = "main journal"
FILLET = "fillet"
WEB = "web"
BORE = "bore"
OIL_HOLE = "oil hole"
COUNTERWEIGHT = "counterweight"


# Where elements are made small: (number of the cylinder, "start" or "end" or "bore").
Zone = tuple[int, str]


def build_solid(gmsh: Any, parts: ThrowParts, part: str) -> dict[str, list[int]]:
    """Build a throw in the current gmsh model.

    Parameters
    ----------
    gmsh : module
        The initialized gmsh module, its current model empty.
    part : {"quarter", "half", "full"}
        Part to build; the throw must have that symmetry.

    Returns
    -------
    dict
        Surface tags by surface name.
    """
    make_solid(gmsh, parts, part)
    remove_loose(gmsh)
    tolerance = position_tolerance(parts)
    names = [LEFT_END, *([RIGHT_END] if part != "quarter" else [])]
    names += [CRANK_PLANE] if part != "full" else []
    names += [MIDDLE_PLANE] if part == "quarter" else []
    names += [*(pin.name for pin in parts.pins), MAIN_JOURNAL, FILLET, WEB]
    surfaces: dict[str, list[int]] = {name: [] for name in names}
    last = part_end(parts, part)
    for _, tag in gmsh.model.getEntities(2):
        kind = gmsh.model.getType(2, tag)
        point = middle_point(gmsh, 2, tag)
        if kind == "Plane":
            _, _, z_low, x_high, _, z_high = gmsh.model.getBoundingBox(2, tag)
            if z_high < tolerance:
                name = LEFT_END
            elif z_low > last - tolerance:
                name = MIDDLE_PLANE if part == "quarter" else RIGHT_END
            elif part != "full" and x_high < tolerance:
                name = CRANK_PLANE
            elif on_drilling(gmsh, parts, kind, tag, point):
                name = OIL_HOLE
            else:
                name = _web_or_counterweight(parts, point)
        elif on_drilling(gmsh, parts, kind, tag, point):
            name = OIL_HOLE
        else:
            name = _round_surface(parts, kind, point, tolerance)
        surfaces.setdefault(name, []).append(tag)
    return surfaces


def part_end(parts: ThrowParts, part: str) -> float:
    """End of a part of a throw along z [m]."""
    return parts.length / 2.0 if part == "quarter" else parts.length


def remove_loose(gmsh: Any) -> None:
    """Synchronize and remove what bounds no solid: profiles that were revolved, centers of arcs."""
    occ = gmsh.model.occ
    occ.synchronize()
    for dimension in (2, 1, 0):
        loose = [
            entity
            for entity in gmsh.model.getEntities(dimension)
            if len(gmsh.model.getAdjacencies(*entity)[0]) == 0
        ]
        if loose:
            occ.remove(loose)
            occ.synchronize()


def make_solid(gmsh: Any, parts: ThrowParts, part: str) -> Entity:
    """Make the solid alone, leaving behind what it was made from; parameters as for `build_solid`."""
    occ = gmsh.model.occ
    whole = part == "full"
    limit = part_end(parts, part)
    cylinders = [
        cylinder
        if cylinder.end <= limit
        # The bore's tool passes the cut, so that the two do not share a face.
        else replace(cylinder, end=limit, end_fillet=0.0, bore_end=cylinder.end)
        for cylinder in parts.cylinders
        if cylinder.start < limit
    ]
    webs = [
        replace(web, end=min(web.end, limit))
        for web in parts.webs
        if web.start < min(limit, web.end)
    ]
    pieces = [
        drilled_journal(gmsh, cylinder, parts.drillings, limit, _revolved, whole)
        for cylinder in cylinders
    ]
    for web in webs:
        pieces.append(_plate(gmsh, web, whole))
        if web.sector is not None:
            pieces.append(_sector(gmsh, web, web.sector, whole))
    solid, _ = occ.fuse(pieces[:1], pieces[1:])
    tools = []
    margin = 0.1 * parts.length  # a bore's tool stands out at the throw's ends
    for cylinder in cylinders:
        if cylinder.bore_radius:
            start, end = cylinder.bore_start, cylinder.bore_end
            start -= margin if start == 0.0 else 0.0
            end += margin if end == parts.length else 0.0
            way = (0.0, 0.0, end - start)
            tag = occ.addCylinder(*cylinder.bore_axis, start, *way, cylinder.bore_radius)
            tools.append((3, int(tag)))
    if tools:
        solid, _ = occ.cut(solid, tools)
    return _only_volume(solid)


def _revolved(gmsh: Any, cylinder: Cylinder, whole: bool) -> Entity:
    """Revolve a journal's profile, fillets included, about its axis.

    Revolving the fillet with the journal never fails, unlike the kernel's own fillet operation.
    """
    occ = gmsh.model.occ
    axis_x, axis_y = cylinder.axis
    radius = cylinder.radius

    def point(height: float, z: float) -> int:
        return int(occ.addPoint(axis_x, axis_y + height, z))

    start, end = cylinder.start, cylinder.end
    lines = []
    first = last = point(0.0, start)
    if cylinder.start_fillet > 0.0:
        r = cylinder.start_fillet
        rim, foot = point(radius + r, start), point(radius, start + r)
        lines.append(occ.addLine(last, rim))
        lines.append(occ.addCircleArc(rim, point(radius + r, start + r), foot))
        last = foot
    else:
        corner = point(radius, start)
        lines.append(occ.addLine(last, corner))
        last = corner
    if cylinder.end_fillet > 0.0:
        r = cylinder.end_fillet
        foot, rim = point(radius, end - r), point(radius + r, end)
        lines.append(occ.addLine(last, foot))
        lines.append(occ.addCircleArc(foot, point(radius + r, end - r), rim))
        last = rim
    else:
        corner = point(radius, end)
        lines.append(occ.addLine(last, corner))
        last = corner
    center = point(0.0, end)
    lines += [occ.addLine(last, center), occ.addLine(center, first)]
    profile = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    turn = 2.0 * math.pi if whole else -math.pi
    swept = occ.revolve([(2, profile)], axis_x, axis_y, 0.0, 0.0, 0.0, 1.0, turn)
    return _only_volume(swept)


class _Frame:
    """Places points of a web's own coordinates u, v in space."""

    def __init__(self, gmsh: Any, web: WebPlate, whole: bool) -> None:
        self._occ = gmsh.model.occ
        self._foot, (self._x, self._y) = web.foot, web.direction
        # A half is built on the side x > 0, whichever way its web points.
        self._across = (self._y, -self._x) if whole else (1.0, 0.0)

    def point(self, u: float, v: float, z: float) -> int:
        x = self._foot[0] + u * self._across[0] + v * self._x
        y = self._foot[1] + u * self._across[1] + v * self._y
        return int(self._occ.addPoint(x, y, z))

    def across(self, width: float) -> tuple[float, float, float]:
        return (width * self._across[0], width * self._across[1], 0.0)


def _outline_face(
    gmsh: Any, frame: _Frame, pieces: Sequence[Line | Arc], z: float, whole: bool
) -> int:
    """Plane face between a half outline and its mirror image, or the line of symmetry."""
    occ = gmsh.model.occ

    def side(sign: float, first: int, last: int) -> list[int]:
        curves, begin = [], first
        for number, piece in enumerate(pieces):
            stop = (
                last
                if number == len(pieces) - 1
                else frame.point(sign * piece.end[0], piece.end[1], z)
            )
            if isinstance(piece, Arc):
                middle = frame.point(sign * piece.center[0], piece.center[1], z)
                curves.append(occ.addCircleArc(begin, middle, stop))
            else:
                curves.append(occ.addLine(begin, stop))
            begin = stop
        return curves

    low, high = (frame.point(0.0, v, z) for v in (pieces[0].start[1], pieces[-1].end[1]))
    curves = side(1.0, low, high)
    if whole:
        curves += [-curve for curve in side(-1.0, low, high)[::-1]]
    else:
        curves.append(occ.addLine(high, low))
    return int(occ.addPlaneSurface([occ.addCurveLoop(curves)]))


def _plate(gmsh: Any, web: WebPlate, whole: bool) -> Entity:
    """Extrude a web's outline and cut its slopes."""
    occ = gmsh.model.occ
    frame = _Frame(gmsh, web, whole)
    face = _outline_face(gmsh, frame, web.outline.pieces, web.start, whole)
    plate = _only_volume(occ.extrude([(2, face)], 0.0, 0.0, web.end - web.start))
    for slope in web.slopes:
        # The tool stands out of the web everywhere but at the slope.
        reach = web.outline.tip - web.outline.foot
        end = slope.end + slope.towards * 0.1 * reach
        depth = slope.drop * (end - slope.start) / (slope.end - slope.start)
        outside = slope.face - slope.inward * (web.end - web.start)
        corners = [
            (slope.start, slope.face),
            (end, slope.face + slope.inward * depth),
            (end, outside),
            (slope.start, outside),
        ]
        points = [frame.point(-2.0 * reach, v, z) for v, z in corners]
        lines = [occ.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
        side = occ.addPlaneSurface([occ.addCurveLoop(lines)])
        made, _ = occ.cut(
            [plate], [_only_volume(occ.extrude([(2, side)], *frame.across(4.0 * reach)))]
        )
        plate = _only_volume(made)
    return plate


def _sector(gmsh: Any, web: WebPlate, sector: Sector, whole: bool) -> Entity:
    """Extrude a counterweight."""
    occ = gmsh.model.occ
    frame = _Frame(gmsh, web, whole)
    sine, cosine = math.sin(sector.half_angle), math.cos(sector.half_angle)
    z, center = sector.start, frame.point(0.0, 0.0, sector.start)

    def at(radius: float, side: float) -> int:
        return frame.point(side * radius * sine, -radius * cosine, z)

    def arc(first: int, last: int) -> int:
        return int(occ.addCircleArc(first, center, last))

    outer, right_outer = frame.point(0.0, -sector.outer_radius, z), at(sector.outer_radius, 1.0)
    left_outer = at(sector.outer_radius, -1.0) if whole else outer
    curves = [arc(right_outer, outer)] + ([arc(outer, left_outer)] if whole else [])
    if sector.inner_radius > 0.0:
        inner, right_inner = frame.point(0.0, -sector.inner_radius, z), at(sector.inner_radius, 1.0)
        left_inner = at(sector.inner_radius, -1.0) if whole else inner
        curves += [occ.addLine(left_outer, left_inner)]
        curves += ([arc(left_inner, inner)] if whole else []) + [arc(inner, right_inner)]
        curves += [occ.addLine(right_inner, right_outer)]
    else:
        curves += [occ.addLine(left_outer, center), occ.addLine(center, right_outer)]
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    return _only_volume(occ.extrude([(2, face)], 0.0, 0.0, sector.end - sector.start))


def _only_volume(entities: Sequence[Entity]) -> Entity:
    return next(entity for entity in entities if entity[0] == 3)


def position_tolerance(parts: ThrowParts) -> float:
    """Tolerance for distinguishing positions [m]: far below any part, far above gmsh's own 1e-7 m."""
    lengths = [c.end - c.start for c in parts.cylinders]
    lengths += [web.end - web.start for web in parts.webs if web.end > web.start]
    return 1e-3 * min(lengths)


def _round_surface(parts: ThrowParts, kind: str, point: Any, tolerance: float) -> str:
    """Name a curved surface by a point on it."""
    x, y, z = point
    for cylinder in parts.cylinders:
        reach = math.dist((x, y), cylinder.axis)
        if not cylinder.start - tolerance < z < cylinder.end + tolerance:
            continue
        if kind == "Torus" and cylinder.radius < reach < cylinder.collar * (1.0 + 1e-9):
            return FILLET
        if kind == "Cylinder" and abs(reach - cylinder.radius) < 1e-6 * cylinder.radius:
            return cylinder.name if cylinder.is_pin else MAIN_JOURNAL
    for cylinder in parts.cylinders:
        if kind != "Cylinder" or cylinder.bore_radius == 0.0:
            continue
        off = abs(math.dist((x, y), cylinder.bore_axis) - cylinder.bore_radius)
        inside = cylinder.bore_start - tolerance < z < cylinder.bore_end + tolerance
        if inside and off < 1e-6 * cylinder.radius:
            return BORE
    return _web_or_counterweight(parts, point)


def _web_or_counterweight(parts: ThrowParts, point: Any) -> str:
    """Tell a counterweight's outside from the rest of the webs."""
    x, y, z = point
    for web in parts.webs:
        if web.sector is None:
            continue
        low, high = min(web.start, web.sector.start), max(web.end, web.sector.end)
        a, b = web.direction
        v, u = x * a + y * b, abs(x * b - y * a)
        width = float(web.outline.half_width(np.array([v]))[0])
        if low <= z <= high and v < 0.0 and u > width * (1.0 + 1e-9):
            return COUNTERWEIGHT
    return WEB
