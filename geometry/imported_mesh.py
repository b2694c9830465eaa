"""Mesh a throw from a STEP file, like one given by dimensions."""

import hashlib
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError, MeshError
from geometry.cad_faces import opened_part
from geometry.gmsh_session import gmsh_errors
from geometry.imported import ImportedThrow, file_content
from geometry.mesh import MeshingStrategy, OnRemark, ThrowMesh, checked_mesh, try_strategies
from geometry.mesh_checks import check_budget, solid_properties
from geometry.recognition import PLACE_TOLERANCE
from geometry.size_fields import set_face_sizes, set_size_map
from geometry.sizes import GROWTH, ROOT_PER_FILLET, SIZE_PER_BORE, SizeMap, SizePlan
from geometry.solid import BORE, LEFT_END, RIGHT_END

Array = NDArray[np.float64]
# Nodes per volume of a cubed element size and per area of a squared one.
NODES_PER_CELL = 8.0
NODES_PER_FACE = 2.5
# Of rounded edges, with the nodes that their small elements bring with them on both sides.
NODES_PER_ROUNDED_FACE = 10.0
LAYERS = 100


def predict_imported_unknowns(throw: ImportedThrow, factor: float) -> int:
    """Predict the number of displacement unknowns, as `predict_unknowns` does but more roughly.

    Parameters
    ----------
    throw : ImportedThrow
    factor : float
        Scales all element sizes.
    """
    plan = _scaled(throw.plan, factor)
    share = (np.arange(LAYERS) + 0.5) / LAYERS
    cells, near, faces = 0.0, 0.0, throw.area / plan.bulk**2
    for zone in plan.zones:
        distance = plan.reach(zone) * share
        layers = (zone.area + 1.5 * math.pi * zone.length * distance) * plan.reach(zone) / LAYERS
        cells += float(np.sum(layers / (zone.size + GROWTH * distance) ** 3))
        near += float(np.sum(layers))
        faces += zone.area / zone.size**2
    cells += max(throw.volume - near, 0.0) / plan.bulk**3
    for radius, area in throw.curved:
        size = factor * max(ROOT_PER_FILLET * radius, throw.smallest)
        if size < plan.bulk:
            faces += NODES_PER_ROUNDED_FACE / NODES_PER_FACE * area / size**2
    return round(3.0 * (NODES_PER_CELL * cells + NODES_PER_FACE * faces))


def _scaled(plan: SizePlan, factor: float) -> SizePlan:
    """Sizes at another factor; elements larger than a hole's radius would not fill the part round it."""
    zones = tuple(
        replace(
            zone,
            size=zone.size * (min(factor, 1.0 / SIZE_PER_BORE) if zone.zone[1] == BORE else factor),
        )
        for zone in plan.zones
    )
    return SizePlan(factor * plan.bulk, zones)


def mesh_imported_throw(
    throw: ImportedThrow,
    size_factor: float = 1.0,
    sizes: SizeMap | None = None,
    attempts: tuple[str, ...] = (),
    on_remark: OnRemark | None = None,
) -> ThrowMesh:
    """Mesh an imported throw in this process.

    Parameters
    ----------
    throw : ImportedThrow
    size_factor, sizes, attempts, on_remark
        As for `mesh_throw`.

    Returns
    -------
    ThrowMesh
        Of the whole part, in the throw frame. All faces other than ends, pins, main journals,
        fillets and bores are "web".

    Raises
    ------
    InputError
        If the file has changed since it was imported, or the mesh would have too many unknowns.
    MeshError
        If all strategies fail; the message states the last reason.
    """
    if hashlib.sha256(file_content(Path(throw.path))).hexdigest() != throw.digest:
        raise InputError(
            f"{throw.path}: given a file that has changed since it was imported; allowed is the same, "
            "or import it again."
        )
    check_budget(
        predict_imported_unknowns(throw, size_factor)
        if sizes is None
        else sizes.expected_unknowns(size_factor),
        size_factor,
    )

    def mesh_by(rung: MeshingStrategy, failed: tuple[str, ...]) -> ThrowMesh:
        return _mesh_once(throw, size_factor, sizes, rung, failed)

    return try_strategies(mesh_by, attempts, on_remark)


def _mesh_once(
    throw: ImportedThrow,
    size_factor: float,
    sizes: SizeMap | None,
    rung: MeshingStrategy,
    attempts: tuple[str, ...],
) -> ThrowMesh:
    factor = size_factor * rung.share
    surfaces = {name: list(tags) for name, tags in throw.surfaces}
    opened = time.perf_counter()
    with opened_part(throw.path) as (gmsh, tag):
        for option, value in rung.options:
            gmsh.option.setNumber(option, value)
        with gmsh_errors("mesh the throw"):
            occ = gmsh.model.occ
            occ.rotate([(3, tag)], 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, throw.turned)
            occ.translate([(3, tag)], 0.0, 0.0, throw.shifted)
            occ.synchronize()
            solid = solid_properties(gmsh)
            seconds = time.perf_counter() - opened
            if sizes is None:
                _set_sizes(gmsh, throw, factor)
            else:
                set_size_map(gmsh, sizes, factor)
        mesh = checked_mesh(
            gmsh,
            surfaces,
            solid,
            part="full",
            length=throw.length,
            pins=tuple(pin.name for pin in throw.pins),
            size_factor=factor,
            attempts=attempts,
            geometry_seconds=seconds,
        )
    _check_ends(mesh)
    return mesh


def _set_sizes(gmsh: Any, throw: ImportedThrow, factor: float) -> None:
    """Sizes at fillets and corners by a field, elsewhere by curvature."""
    plan = _scaled(throw.plan, factor)
    # Elements round a circle, as long beside its radius as at fillets.
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 2.0 * math.pi / ROOT_PER_FILLET / factor)
    gmsh.option.setNumber("Mesh.MeshSizeMin", factor * throw.smallest)
    gmsh.option.setNumber("Mesh.MeshSizeMax", plan.bulk)
    if not plan.zones:
        return
    set_face_sizes(gmsh, throw.holes, dict(throw.fillets), dict(throw.corners), plan)


def _check_ends(mesh: ThrowMesh) -> None:
    """The surfaces' numbers must mean what they did when the part was read."""
    for name, place in ((LEFT_END, 0.0), (RIGHT_END, mesh.length)):
        off = np.abs(mesh.points[mesh.surfaces[name], 2] - place)
        if off.size == 0 or off.max() > 10.0 * PLACE_TOLERANCE * mesh.length:
            raise MeshError(f"the surface {name!r} of the file is not where it was.")
