"""Write meshes for other programs: gmsh's own format through gmsh, all others through meshio."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError, MissingLibraryError
from crankbase.outputs import atomic_file, write_errors
from geometry.facets import flat_triangles, six_node_triangles
from geometry.gmsh_session import gmsh_session
from geometry.mesh import GMSH_TO_SKFEM, ThrowMesh

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
ENDINGS = SOLID_ENDINGS | SURFACE_ENDINGS
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
    if ending not in ENDINGS:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed for a mesh are "
            f"{', '.join(f'{name} ({reader})' for name, reader in ENDINGS.items())}."
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
