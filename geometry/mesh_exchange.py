"""A mesh in the terms of other programs: meshio's object, and lines of an input file of CalculiX and Abaqus.

In both, tetrahedra keep their order of nodes: the edges are 12 23 13 14 24 34, as in scikit-fem.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.shapes import FACETS, facet_keys

FIELD_WIDTH = 20  # characters of a number that CalculiX and Abaqus read
ENTRIES_PER_LINE = 16


def named_surfaces(mesh: ThrowMesh) -> dict[str, NDArray[np.int64]]:
    """Return the corners (k, 3) of the facets of each surface that has any."""
    return {name: corners for name, corners in mesh.surfaces.items() if len(corners)}


def set_name(surface: str) -> str:
    """Name of a surface where names are without blanks, such as LEFT_END."""
    return surface.upper().replace(" ", "_")


def meshio_mesh(
    mesh: ThrowMesh, point_data: Mapping[str, NDArray[np.float64]] | None = None
) -> Any:
    """Return a mesh as meshio's, with a flag for each named surface.

    Returns
    -------
    meshio.Mesh
        Cells "tetra10", and "triangle6" of all named surfaces. The cell data of each surface's name are 1 on
        its triangles, and 0 elsewhere.
    """
    import meshio

    surfaces = named_surfaces(mesh)
    triangles = six_node_triangles(mesh, np.concatenate(list(surfaces.values())))
    owner = np.repeat(np.arange(len(surfaces)), [len(corners) for corners in surfaces.values()])
    inside = np.zeros(len(mesh.elements), dtype=np.int8)
    return meshio.Mesh(
        mesh.points,
        [("tetra10", mesh.elements), ("triangle6", triangles)],
        point_data=dict(point_data or {}),
        cell_data={
            name: [inside, (owner == number).astype(np.int8)]
            for number, name in enumerate(surfaces)
        },
    )


def number_field(value: float) -> str:
    """Write a number with enough digits to identify it, or as many as fit into a field.

    Of doubles that do not fit the relative error is below 1e-12.
    """
    text = repr(float(value))
    return text if len(text) <= FIELD_WIDTH else f"{value:.12e}"


def inp_nodes_and_elements(
    points: NDArray[np.float64], elements: NDArray[np.int64], name: str
) -> Iterator[str]:
    """Lines of the nodes, in the set MESH, and of the elements (C3D10), in a set of that name."""
    yield "*NODE, NSET=MESH"
    for number, place in enumerate(points.tolist(), start=1):
        yield f"{number},{','.join(map(number_field, place))}"
    yield f"*ELEMENT, TYPE=C3D10, ELSET={name}"
    for number, nodes in enumerate((elements + 1).tolist(), start=1):
        yield f"{number},{','.join(map(str, nodes))}"


def inp_lines(mesh: ThrowMesh) -> Iterator[str]:
    """Lines of a mesh: its nodes and elements, and of each named surface the nodes and the element faces."""
    yield from inp_nodes_and_elements(mesh.points, mesh.elements, "THROW")
    keys = facet_keys(mesh.elements[:, FACETS].reshape(-1, 3))
    order = np.argsort(keys)
    for surface, corners in named_surfaces(mesh).items():
        yield f"*NSET, NSET={set_name(surface)}"
        numbers = (np.unique(six_node_triangles(mesh, corners)) + 1).tolist()
        for start in range(0, len(numbers), ENTRIES_PER_LINE):
            yield ",".join(map(str, numbers[start : start + ENTRIES_PER_LINE]))
        yield f"*SURFACE, NAME={set_name(surface)}, TYPE=ELEMENT"
        places = order[np.searchsorted(keys, facet_keys(corners), sorter=order)]
        for element, face in zip(*np.divmod(places, len(FACETS)), strict=True):
            yield f"{element + 1},S{face + 1}"
