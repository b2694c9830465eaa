"""The solid of a throw in gmsh's OpenCASCADE kernel: one quarter, cut by its two symmetry planes.

A throw with equal webs is symmetric about the crank plane (x = 0) and about the middle of its pin
(z = length / 2), so the quarter x >= 0, z <= length / 2 says everything about it.
"""

import math
from typing import Any

from geometry.errors import MeshError
from geometry.throw import CrankThrow

# Names of the quarter's surfaces, used for supports, loads and symmetry conditions.
LEFT_END = "left end"
CRANK_PLANE = "crank plane"
MIDDLE_PLANE = "middle plane"
PIN = "pin"
MAIN_JOURNAL = "main journal"
FILLET = "fillet"
WEB = "web"


def build_quarter(gmsh: Any, throw: CrankThrow) -> dict[str, list[int]]:
    """Build the quarter solid in the current gmsh model.

    Parameters
    ----------
    gmsh : module
        The initialized gmsh module, its current model empty.
    throw : CrankThrow
        The dimensions.

    Returns
    -------
    dict
        Surface tags by surface name.
    """
    half_journal = throw.main_journal_length / 2.0
    web_end = half_journal + throw.web_thickness
    middle = throw.length / 2.0
    journal = _half_journal(
        gmsh, 0.0, throw.main_journal_diameter / 2.0, 0.0, half_journal, throw.fillet_radius
    )
    pin = _half_journal(
        gmsh, throw.crank_radius, throw.pin_diameter / 2.0, middle, web_end, throw.fillet_radius
    )
    web = _half_web(gmsh, throw, half_journal)
    gmsh.model.occ.fuse([journal], [web, pin])
    gmsh.model.occ.synchronize()
    return _name_surfaces(gmsh, throw)


def _half_journal(
    gmsh: Any, axis_y: float, radius: float, free_z: float, web_z: float, fillet: float
) -> tuple[int, int]:
    """Revolve a journal's profile, the fillet included, by half a turn about its axis.

    Revolving the fillet with the journal never fails, unlike the kernel's own fillet operation.
    """
    occ = gmsh.model.occ
    towards_web = math.copysign(1.0, web_z - free_z)

    def point(height: float, z: float) -> int:
        return int(occ.addPoint(0.0, axis_y + height, z))

    corners = [point(0.0, free_z), point(radius, free_z)]
    if fillet > 0.0:
        start = web_z - towards_web * fillet
        corners += [point(radius, start), point(radius + fillet, web_z), point(0.0, web_z)]
        lines = [
            occ.addLine(corners[0], corners[1]),
            occ.addLine(corners[1], corners[2]),
            occ.addCircleArc(corners[2], point(radius + fillet, start), corners[3]),
            occ.addLine(corners[3], corners[4]),
            occ.addLine(corners[4], corners[0]),
        ]
    else:
        corners += [point(radius, web_z), point(0.0, web_z)]
        lines = [occ.addLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    profile = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    swept = occ.revolve([(2, profile)], 0.0, axis_y, 0.0, 0.0, 0.0, 1.0, -math.pi)
    return _only_volume(swept)


def _half_web(gmsh: Any, throw: CrankThrow, z: float) -> tuple[int, int]:
    """Extrude the half x >= 0 of the obround web."""
    occ = gmsh.model.occ
    half, radius = throw.web_width / 2.0, throw.crank_radius
    foot, low, high, head = (
        occ.addPoint(0.0, -half, z),
        occ.addPoint(half, 0.0, z),
        occ.addPoint(half, radius, z),
        occ.addPoint(0.0, radius + half, z),
    )
    lines = [
        occ.addCircleArc(foot, occ.addPoint(0.0, 0.0, z), low),
        occ.addLine(low, high),
        occ.addCircleArc(high, occ.addPoint(0.0, radius, z), head),
        occ.addLine(head, foot),
    ]
    outline = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    return _only_volume(occ.extrude([(2, outline)], 0.0, 0.0, throw.web_thickness))


def _only_volume(entities: list[tuple[int, int]]) -> tuple[int, int]:
    return next(entity for entity in entities if entity[0] == 3)


def place_tolerance(throw: CrankThrow) -> float:
    """Tolerance for telling places apart [m]: far below any part, far above gmsh's own 1e-7 m."""
    return 1e-3 * min(throw.main_journal_length, throw.pin_length, throw.web_thickness)


def _name_surfaces(gmsh: Any, throw: CrankThrow) -> dict[str, list[int]]:
    """Tell the surfaces apart by their kind and place."""
    tolerance = place_tolerance(throw)
    half_journal = throw.main_journal_length / 2.0
    web_end = half_journal + throw.web_thickness
    names: dict[str, list[int]] = {
        name: [] for name in (LEFT_END, CRANK_PLANE, MIDDLE_PLANE, PIN, MAIN_JOURNAL, FILLET, WEB)
    }
    for _, tag in gmsh.model.getEntities(2):
        _, _, z_low, x_high, _, z_high = gmsh.model.getBoundingBox(2, tag)
        kind = gmsh.model.getType(2, tag)
        if z_high < tolerance:
            name = LEFT_END
        elif z_low > throw.length / 2.0 - tolerance:
            name = MIDDLE_PLANE
        elif x_high < tolerance:
            name = CRANK_PLANE
        elif kind == "Torus":
            name = FILLET
        elif kind == "Cylinder" and z_high < half_journal + tolerance:
            name = MAIN_JOURNAL
        elif kind == "Cylinder" and z_low > web_end - tolerance:
            name = PIN
        else:
            name = WEB
        names[name].append(tag)
    for name, tags in names.items():
        if not tags and not (name == FILLET and throw.fillet_radius == 0.0):
            raise MeshError(f"the solid of the throw has no surface that is its {name}.")
    return names
