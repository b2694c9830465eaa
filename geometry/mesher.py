"""Mesh throws in a separate process, so that a crash of the mesher is contained."""

import hashlib
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.calls import ProcessLostError
from crankbase.choices import check_kind
from crankbase.errors import InputError, MeshError
from geometry.gmsh_session import IsolatedProcess, gmsh_errors, shared_process
from geometry.imported import ImportedThrow, file_content
from geometry.mesh import (
    MESHING_STRATEGIES,
    MeshingStrategy,
    OnRemark,
    ThrowMesh,
    all_failed,
    check_budget,
    checked_mesh,
    mesh_throw,
    solid_properties,
    try_strategies,
)
from geometry.recognition import PLACE_TOLERANCE, opened_part
from geometry.sizes import (
    GROWTH,
    ROOT_PER_FILLET,
    SIZE_PER_BORE,
    SizeMap,
    SizePlan,
    predict_unknowns,
    set_face_sizes,
    set_size_map,
)
from geometry.solid import BORE, LEFT_END, RIGHT_END
from geometry.throw import CrankThrow

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


# Given by dimensions, or by a CAD part.
Throw = CrankThrow | ImportedThrow
# Seconds that one way of meshing may take, and more for each unknown; an ordinary quarter takes 0.2 s.
TIME_LIMIT = 60.0
SECONDS_PER_UNKNOWN = 2e-4


def mesh_isolated(
    throw: Throw,
    size_factor: float = 1.0,
    part: str = "auto",
    sizes: SizeMap | None = None,
    *,
    process: IsolatedProcess | None = None,
    time_limit: float = TIME_LIMIT,
) -> ThrowMesh:
    """Mesh a throw in a separate process.

    If a strategy ends the process or takes too long, a new one continues with the next strategy.

    Parameters
    ----------
    throw, size_factor, part, sizes
        As for `mesh_throw`, which describes the result and the errors.
    process : IsolatedProcess, optional
        Process for meshing; by default the one shared in this process.
    time_limit : float
        Time limit of one strategy [s]; larger for large meshes.

    Raises
    ------
    MeshError
        Also if gmsh crashes, or takes too long, with every strategy.
    """
    check_kind("throw", throw, Throw, "a CrankThrow, or what import_throw returns")
    process = shared_process() if process is None else process
    if isinstance(throw, ImportedThrow) and part not in ("auto", "full"):
        raise InputError(
            f"part: given {part!r}; allowed is 'full' or 'auto', because an imported throw is meshed whole."
        )
    limit = time_limit + SECONDS_PER_UNKNOWN * expected_unknowns(throw, size_factor, sizes)
    attempts: tuple[str, ...] = ()

    def note(made: tuple[str, ...]) -> None:
        nonlocal attempts
        attempts = made

    while len(attempts) < len(MESHING_STRATEGIES):
        try:
            mesh: ThrowMesh = process.call(
                "geometry.mesher:mesh_here",
                throw,
                size_factor,
                part,
                sizes,
                attempts,
                time_limit=limit,
                on_remark=note,
            )
        except ProcessLostError as error:
            attempts = (*attempts, f"{MESHING_STRATEGIES[len(attempts)].what}: {error}")
        else:
            return mesh
    raise all_failed(attempts)


def mesh_here(
    throw: Throw,
    size_factor: float = 1.0,
    part: str = "auto",
    sizes: SizeMap | None = None,
    attempts: tuple[str, ...] = (),
    on_remark: OnRemark | None = None,
) -> ThrowMesh:
    """Mesh any throw in this process; parameters, results and errors as for `mesh_throw`."""
    if isinstance(throw, ImportedThrow):
        return mesh_imported_throw(throw, size_factor, sizes, attempts, on_remark)
    return mesh_throw(throw, size_factor, part, sizes, attempts, on_remark)


def expected_unknowns(throw: Throw, size_factor: float, sizes: SizeMap | None = None) -> int:
    """Predict the number of unknowns of a throw's analysis with a size factor."""
    if sizes is not None:
        return sizes.expected_unknowns(size_factor)
    if isinstance(throw, ImportedThrow):
        return predict_imported_unknowns(throw, size_factor)
    return predict_unknowns(throw.parts, size_factor, throw.symmetry)
