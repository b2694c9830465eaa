"""Oil holes in a throw's solid: cutting, rounding of exits, and identification of their surfaces."""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import MeshError
from geometry.drilling import Drilling
from geometry.parts import Cylinder, ThrowParts, scaled_parts

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
    gmsh : module
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
    holes = [
        hole
        for hole in drillings
        if hole.journal == journal.name and _lowest(hole) < limit and (whole or _beside(hole))
    ]

    def make(one: Cylinder, drilled: Sequence[Drilling]) -> Entity:
        solid = revolve(gmsh, one, whole)
        if whole:
            gmsh.model.occ.rotate([solid], *one.axis, 0.0, 0.0, 0.0, 1.0, _clear_angle(drilled))
        return _drilled(gmsh, one, drilled, solid)

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
    made, _ = occ.cut([solid], [_tool(occ, journal, hole) for hole in holes])
    solid = _only_volume(made)
    radii: dict[int, float] = {}
    occ.synchronize()
    points = {curve: _points_on(gmsh, curve) for _, curve in gmsh.model.getEntities(1)}
    for hole in holes:
        if hole.exit_radius > 0.0:
            found = [curve for curve, on in points.items() if _is_edge(hole, on)]
            if not found:
                raise MeshError(f"the exits of oil hole {hole.number} were not found.")
            radii |= dict.fromkeys(found, hole.exit_radius)
    if radii:
        solid = _only_volume(occ.fillet([solid[1]], list(radii), list(radii.values())))
    return solid


def _clear_angle(holes: Sequence[Drilling]) -> float:
    """Angle from +y about +z in the middle of the widest gap between exits, for the surface's seam [rad]."""
    angles = np.sort(np.radians([outlet.angle_deg for hole in holes for outlet in hole.exits]))
    gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
    widest = int(np.argmax(gaps))
    return float(angles[widest] + 0.5 * gaps[widest])


def _only_volume(entities: Sequence[Entity]) -> Entity:
    return next(entity for entity in entities if entity[0] == 3)


def on_drilling(gmsh: Any, parts: ThrowParts, kind: str, tag: int, point: ArrayLike) -> bool:
    """Whether a surface of a kind, with a point on it, belongs to an oil hole."""
    for hole in parts.drillings:
        if kind == "Cylinder":
            low, high = gmsh.model.getParametrizationBounds(2, tag)
            middle = 0.5 * (np.asarray(low) + np.asarray(high))
            most, least, *_ = gmsh.model.getPrincipalCurvatures(tag, middle.tolist())
            if abs(max(abs(most[0]), abs(least[0])) * hole.radius - 1.0) > 1e-6:
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


def _lowest(hole: Drilling) -> float:
    """Where along z it begins [m]."""
    ends = [float(outlet.point[2]) for outlet in hole.exits] + [hole.place]
    return min(ends) - hole.radius


def _beside(hole: Drilling) -> bool:
    """Whether it reaches the half x >= 0."""
    return max(float(outlet.point[0]) for outlet in hole.exits) + hole.radius > hole.axis[0]


def _tool(occ: Any, journal: Cylinder, hole: Drilling) -> Entity:
    """The volume cut by the drill, and a little space around the journal."""
    reach = 2.0 * hole.journal_radius / np.cos(hole.tilt)
    start = -reach if hole.through else hole.inner_end
    low, way = hole.middle + start * hole.frame[2], (reach - start) * hole.frame[2]
    drill = (3, occ.addCylinder(*low.tolist(), *way.tolist(), hole.radius))
    length = journal.end - journal.start
    start, radius = journal.start - length, BEYOND * hole.journal_radius
    around = (3, occ.addCylinder(*hole.axis, start, 0.0, 0.0, 3.0 * length, radius))
    made, _ = occ.intersect([drill], [around])
    return _only_volume(made)


def _points_on(gmsh: Any, curve: int) -> NDArray[np.float64]:
    low, high = gmsh.model.getParametrizationBounds(1, curve)
    where = np.linspace(low[0], high[0], SAMPLES)
    return np.asarray(gmsh.model.getValue(1, curve, where.tolist()), float).reshape(-1, 3)


def _places(
    hole: Drilling, points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distances of points (n, 3) from the hole's axis and from the journal's [m]."""
    p, q, _ = hole.local(points).T
    return np.hypot(p, q), np.linalg.norm(points[:, :2] - hole.axis, axis=1)


def _is_edge(hole: Drilling, points: NDArray[np.float64]) -> bool:
    """Whether a curve with these points is where the hole's wall meets the journal's surface."""
    off, height = _places(hole, points)
    tolerance = CURVE_TOLERANCE * hole.journal_radius
    on_both = (np.abs(off - hole.radius) < tolerance) & (
        np.abs(height - hole.journal_radius) < tolerance
    )
    near = np.abs(points[:, 2] - hole.place) < 3.0 * hole.journal_radius
    return bool(np.all(on_both & near))
