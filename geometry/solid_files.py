"""Write throws, crankshafts and meshes for other programs: STEP, gmsh's format, and others through meshio."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.calls import ProcessLostError
from crankbase.errors import InputError, MeshError, MissingLibraryError
from crankbase.input_file import STEP_ENDINGS
from crankbase.outputs import atomic_file, write_errors, write_text
from crankbase.processes import scratch_folder
from geometry.crankshaft import Crankshaft, make_shaft
from geometry.gmsh_session import gmsh_errors, gmsh_session, shared_process
from geometry.mesh import (
    GMSH_TO_SKFEM,
    ThrowMesh,
    check_solid,
    checked_part,
    flat_triangles,
    six_node_triangles,
    solid_properties,
)
from geometry.mesher import TIME_LIMIT
from geometry.parts import ThrowParts
from geometry.solid import LEFT_END, RIGHT_END, make_solid, remove_loose
from geometry.step_file import CYLINDER, PLANE, StepFace, read_step
from geometry.throw import CrankThrow


def write_step(solid: CrankThrow | Crankshaft, path: str | Path, part: str = "full") -> Path:
    """Write a solid as STEP (ISO 10303-21, AP 214), lengths in m.

    Faces of a throw's ends and pins are named "left end", "right end", "pin", "pin 2" ...

    Parameters
    ----------
    path : path
        A file ending in ``.step`` or ``.stp``.
    part : {"full", "half", "quarter", "auto"}
        Of a throw; only one that its symmetry allows.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, the throw lacks that symmetry, or the file cannot be written.
    MeshError
        If the kernel cannot build the solid.
    """
    path = Path(path)
    if path.suffix.lower() not in STEP_ENDINGS:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed are {', '.join(STEP_ENDINGS)}."
        )
    if isinstance(solid, CrankThrow):
        part = checked_part(solid, part)
    elif part not in ("full", "auto"):
        raise InputError(
            f"part: given {part!r}; allowed is 'full', because a crankshaft is written whole."
        )
    try:
        text = shared_process().call(
            "geometry.solid_files:step_text", solid, part, time_limit=TIME_LIMIT
        )
    except ProcessLostError as error:
        raise MeshError(f"the solid could not be built: {error}.") from None
    with write_errors(path):
        return write_text(path, text, "solid")


def step_text(solid: CrankThrow | Crankshaft, part: str) -> str:
    """Build a solid in this process and return its STEP file."""
    with gmsh_session("export") as gmsh, scratch_folder() as folder:
        with gmsh_errors("build the solid"):
            if isinstance(solid, CrankThrow):
                make_solid(gmsh, solid.parts, part)
                remove_loose(gmsh)
                check_solid(solid.parts, part, solid_properties(gmsh))
            else:
                make_shaft(gmsh, solid)
            file = folder / "solid.step"
            gmsh.write(str(file))
        text = file.read_text(encoding="ascii")
    # gmsh writes the numbers as they are, in m, and says that they are mm.
    text = text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)")
    return _with_names(text, solid.parts) if isinstance(solid, CrankThrow) else text


def _with_names(text: str, parts: ThrowParts) -> str:
    """Name the end and pin faces, by which `import_throw` finds them; gmsh writes no names."""
    count = 0

    def numbered(_: re.Match[str]) -> str:
        nonlocal count
        count += 1
        return f"ADVANCED_FACE('face {count}'"

    text = re.sub(r"ADVANCED_FACE\(\s*''", numbered, text)
    for face in read_step(text.encode("ascii"), "the exported solid").faces:
        # Ends and pins are told apart by far more than the kernel's round-off.
        text = text.replace(f"'{face.name}'", f"'{_face_name(face, parts)}'", 1)
    return text


def _face_name(face: StepFace, parts: ThrowParts) -> str:
    x, y, z = face.point
    near = 1e-6 * parts.length
    if face.kind == PLANE and abs(face.axis[2]) > 0.999:
        ends = {LEFT_END: 0.0, RIGHT_END: parts.length}
        return next((name for name, place in ends.items() if abs(z - place) < near), "")
    if face.kind == CYLINDER:
        for pin in parts.pins:
            alike = math.dist((x, y), pin.axis) < near and abs(face.radius - pin.radius) < near
            low = min(corner[2] for corner in face.corners)
            if alike and pin.start - near < low < pin.end + near:
                return pin.name
    return ""


# File endings that keep the curved elements, or only the surface as flat triangles, and their readers.
# Those that meshio would write with half of the mesh left out are not among them.
SOLID_ENDINGS = {
    ".msh": "gmsh",
    ".vtu": "ParaView",
    ".vtk": "ParaView",
    ".inp": "Abaqus, CalculiX",
    ".med": "Salome, code_aster",
}
SURFACE_ENDINGS = {".stl": "surface only", ".ply": "surface only", ".obj": "surface only"}
MESH_ENDINGS = SOLID_ENDINGS | SURFACE_ENDINGS
VOLUME = "throw"


def write_mesh(
    mesh: ThrowMesh, path: str | Path, point_data: dict[str, NDArray[np.float64]] | None = None
) -> Path:
    """Write a mesh with its named surfaces.

    Parameters
    ----------
    mesh : ThrowMesh
        Coordinates are written in m.
    path : path
        Its ending is the format: ``.msh`` (surfaces are physical groups), ``.inp`` (cell sets), ``.vtu``,
        ``.vtk``, ``.med`` (the cell data "surface" numbers volume and surfaces, in the order of
        the mesh's surfaces that are not empty), ``.stl``, ``.ply``, ``.obj`` (the surface alone).
    point_data : dict, optional
        Values at the nodes, such as displacements, for formats that support them.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, or the file cannot be written or is not ours.
    MissingLibraryError
        If the format needs a package that is not installed.
    """
    path = Path(path)
    ending = check_ending(path)
    try:
        with write_errors(path), atomic_file(path, "mesh") as part:
            if ending == ".msh":
                _write_msh(mesh, part)
            elif ending in SURFACE_ENDINGS:
                _meshio().Mesh(
                    mesh.points, [("triangle", flat_triangles(mesh).astype(np.int32))]
                ).write(part)
            else:
                _write_solid(mesh, part, point_data or {})
    except ImportError as error:
        package = error.name or str(error)
        raise MissingLibraryError(
            f"{path.name}: this format needs the Python package {package}, which is not installed; "
            "install it with: pip install 'crankfem[formats]'"
        ) from None
    return path


def check_ending(path: Path) -> str:
    """Return the ending of a file name in lower case.

    Raises
    ------
    InputError
        If meshes cannot be written with it.
    """
    ending = path.suffix.lower()
    if ending not in MESH_ENDINGS:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed for a mesh are "
            f"{', '.join(f'{name} ({reader})' for name, reader in MESH_ENDINGS.items())}."
        )
    return ending


def _meshio() -> Any:
    import meshio

    return meshio


def _write_solid(mesh: ThrowMesh, path: Path, point_data: dict[str, NDArray[np.float64]]) -> None:
    """Write elements and surfaces; the surfaces are sets in .inp files, elsewhere numbered."""
    names = [name for name, corners in mesh.surfaces.items() if len(corners)]
    triangles = [six_node_triangles(mesh, mesh.surfaces[name]) for name in names]
    if path.suffix.lower() == ".inp":
        cells = [("tetra10", mesh.elements), *(("triangle6", part) for part in triangles)]
        sets = {}
        for place, name in enumerate([VOLUME, *names]):
            chosen = [np.empty(0, dtype=np.int64) for _ in cells]
            chosen[place] = np.arange(len(cells[place][1]))
            sets[name.replace(" ", "_")] = chosen
        made = _meshio().Mesh(mesh.points, cells, cell_sets=sets)
    else:
        numbers = [np.full(len(part), number) for number, part in enumerate(triangles, start=1)]
        made = _meshio().Mesh(
            mesh.points,
            [("tetra10", mesh.elements), ("triangle6", np.concatenate(triangles))],
            point_data=point_data,
            cell_data={
                "surface": [np.zeros(len(mesh.elements), dtype=np.int64), np.concatenate(numbers)]
            },
        )
    made.write(path)


def _write_msh(mesh: ThrowMesh, path: Path) -> None:
    """Write through gmsh, as discrete entities with physical groups."""
    with gmsh_session("export") as gmsh:
        volume = gmsh.model.addDiscreteEntity(3)
        gmsh.model.mesh.addNodes(3, volume, np.arange(1, len(mesh.points) + 1), mesh.points.ravel())
        elements = mesh.elements[:, np.argsort(GMSH_TO_SKFEM)] + 1
        _add_elements(gmsh, volume, 11, elements, 1)
        gmsh.model.addPhysicalGroup(3, [volume], name=VOLUME)
        first = len(elements) + 1
        for name, corners in mesh.surfaces.items():
            if len(corners) == 0:
                continue
            surface = gmsh.model.addDiscreteEntity(2)
            # scikit-fem has the triangle's edges in the order 01 12 02, gmsh 01 12 20.
            triangles = six_node_triangles(mesh, corners) + 1
            _add_elements(gmsh, surface, 9, triangles, first)
            first += len(triangles)
            gmsh.model.addPhysicalGroup(2, [surface], name=name)
        try:
            gmsh.write(str(path))
        except Exception as error:  # gmsh raises bare Exception
            raise InputError(f"{path}: cannot be written ({error}).") from None


def _add_elements(gmsh: Any, entity: int, kind: int, nodes: NDArray[np.int64], first: int) -> None:
    numbers = np.arange(first, first + len(nodes))
    gmsh.model.mesh.addElementsByType(entity, kind, numbers, nodes.ravel())
