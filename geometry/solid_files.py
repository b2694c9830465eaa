"""Write throws and crankshafts as STEP, and meshes in the formats of other programs."""

import math
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array, Integers
from crankbase.calls import ProcessLostError
from crankbase.choices import check_kind
from crankbase.errors import InputError, MeshError
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
    flattened,
    solid_properties,
)
from geometry.mesh_exchange import inp_lines, meshio_mesh, set_name, surface_triangles
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
    check_kind(
        "solid",
        solid,
        CrankThrow | Crankshaft,
        "a CrankThrow or a Crankshaft; an imported throw is in its STEP file",
    )
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
    if not isinstance(solid, CrankThrow):
        return text
    # Name the end and pin faces, by which `import_throw` finds them; gmsh writes no names.
    count = 0

    def numbered(_: re.Match[str]) -> str:
        nonlocal count
        count += 1
        return f"ADVANCED_FACE('face {count}'"

    text = re.sub(r"ADVANCED_FACE\(\s*''", numbered, text)
    for face in read_step(text.encode("ascii"), "the exported solid").faces:
        # Ends and pins are told apart by far more than the kernel's round-off.
        text = text.replace(f"'{face.name}'", f"'{_face_name(face, solid.parts)}'", 1)
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


# File endings that keep the curved elements, or only the surface as flat triangles, and what reads them.
SOLID_ENDINGS = {
    ".msh": "gmsh",
    ".vtu": "ParaView, PyVista",
    ".inp": "CalculiX, Abaqus",
    ".med": "Salome, code_aster",
}
SURFACE_ENDINGS = {".stl": "surface only"}
MESH_ENDINGS = SOLID_ENDINGS | SURFACE_ENDINGS
LISTED_ENDINGS = ", ".join(f"{ending} ({reader})" for ending, reader in MESH_ENDINGS.items())
VOLUME = "throw"
# Of an .inp file, with the surfaces' names.
INP_HEAD = """\
** Mesh of a crank throw, written by crankfem; lengths in m. For CalculiX and Abaqus: add
** material, supports and loads, or include this file in a deck with *INCLUDE, INPUT=...
** z along the shaft, from the center of the left end section; y to the first pin's axis.
** Elements THROW; sets of nodes, and surfaces of element faces: {}.
"""


def write_mesh(
    mesh: ThrowMesh, path: str | Path, point_data: dict[str, Array] | None = None
) -> Path:
    """Write a mesh with its named surfaces.

    Parameters
    ----------
    mesh : ThrowMesh
        Coordinates are written in m.
    path : path
        Its ending is the format: ``.msh`` and ``.med`` (volume and surfaces are groups, in a .med with names
        such as LEFT_END), ``.inp`` (each surface a set of nodes and a surface of element faces of such a
        name; for a deck to include), ``.vtu`` (cell data of each surface's name are 1 on it), ``.stl`` (flat
        triangles of the surfaces, each a solid of its name).
    point_data : dict, optional
        Values at the nodes (n, ...), such as displacements, in a ``.vtu``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, the values are not those of the nodes or the format has no place for them,
        or the file cannot be written or is not ours.
    """
    check_kind("mesh", mesh, ThrowMesh, "a ThrowMesh, as mesh_throw returns")
    check_kind("path", path, str | os.PathLike, "the name of a file")
    path = Path(path)
    ending = check_ending(path)
    for name, values in (point_data or {}).items():
        if ending != ".vtu":
            raise InputError(
                f"point_data: given {name!r} for a file ending in {ending}; allowed is .vtu, because the "
                "others hold the mesh alone."
            )
        if np.shape(values)[:1] != (len(mesh.points),):
            raise InputError(
                f"point_data[{name!r}]: given an array of shape {np.shape(values)}; allowed are "
                f"{len(mesh.points)} rows, because the mesh has that many nodes."
            )
    with write_errors(path), atomic_file(path, "mesh") as part:
        if ending == ".inp":
            head = INP_HEAD.format(", ".join(map(set_name, surface_triangles(mesh))))
            lines = "".join(f"{line}\n" for line in inp_lines(mesh))
            part.write_text(head + lines, encoding="ascii")
        elif ending == ".vtu":
            surfaces = surface_triangles(mesh)
            meshio_mesh(mesh.points, mesh.elements, surfaces, point_data or {}).write(part)
        elif ending in SURFACE_ENDINGS:
            part.write_text("".join(_stl_lines(mesh)), encoding="ascii")
        else:
            _write_by_gmsh(mesh, part, set_name if ending == ".med" else str)
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
            f"{path.name}: given the ending {path.suffix!r}; allowed for a mesh are {LISTED_ENDINGS}."
        )
    return ending


def _stl_lines(mesh: ThrowMesh) -> Iterator[str]:
    for surface, sides in surface_triangles(mesh).items():
        yield f"solid {set_name(surface)}\n"
        facets = mesh.points[flattened(sides)]
        normals = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        for (x, y, z), facet in zip(normals.tolist(), facets.tolist(), strict=True):
            yield f"facet normal {x:.9e} {y:.9e} {z:.9e}\nouter loop\n"
            for a, b, c in facet:
                yield f"vertex {a:.9e} {b:.9e} {c:.9e}\n"
            yield "endloop\nendfacet\n"
        yield f"endsolid {set_name(surface)}\n"


def _write_by_gmsh(mesh: ThrowMesh, path: Path, group_name: Callable[[str], str]) -> None:
    """Write discrete entities with physical groups, which are the groups of a .med file."""
    with gmsh_session(VOLUME) as gmsh:
        volume = gmsh.model.addDiscreteEntity(3)
        gmsh.model.mesh.addNodes(3, volume, np.arange(1, len(mesh.points) + 1), mesh.points.ravel())
        elements = mesh.elements[:, np.argsort(GMSH_TO_SKFEM)] + 1
        _add_elements(gmsh, volume, 11, elements, 1)
        gmsh.model.addPhysicalGroup(3, [volume], name=group_name(VOLUME))
        first = len(elements) + 1
        for name, facets in surface_triangles(mesh).items():
            surface = gmsh.model.addDiscreteEntity(2)
            # scikit-fem has the triangle's edges in the order 01 12 02, gmsh 01 12 20.
            _add_elements(gmsh, surface, 9, facets + 1, first)
            first += len(facets)
            gmsh.model.addPhysicalGroup(2, [surface], name=group_name(name))
        try:
            gmsh.write(str(path))
        except Exception as error:  # gmsh raises bare Exception
            raise InputError(f"{path}: cannot be written ({error}).") from None


def _add_elements(gmsh: Any, entity: int, kind: int, nodes: Integers, first: int) -> None:
    numbers = np.arange(first, first + len(nodes))
    gmsh.model.mesh.addElementsByType(entity, kind, numbers, nodes.ravel())
