"""A mesh in the terms of other programs: meshio's object, and lines of an input file of CalculiX and Abaqus.

In both, tetrahedra keep their order of nodes: the edges are 12 23 13 14 24 34, as in scikit-fem.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from crankbase.array_checks import Array, Integers
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.shapes import FACETS, facet_keys

FIELD_WIDTH = 20  # characters of a number that CalculiX and Abaqus read
ENTRIES_PER_LINE = 16


def surface_triangles(mesh: ThrowMesh) -> dict[str, Integers]:
    """Return the facets (t, 6) of each surface that has any: corners, then the middles of 01 12 02."""
    surfaces = {name: corners for name, corners in mesh.surfaces.items() if len(corners)}
    return {name: six_node_triangles(mesh, corners) for name, corners in surfaces.items()}


def set_name(surface: str) -> str:
    """Name of a surface where names are without blanks, such as LEFT_END."""
    return surface.upper().replace(" ", "_")


def meshio_mesh(
    points: Array,
    elements: Integers,
    surfaces: Mapping[str, Integers],
    point_data: Mapping[str, Array],
) -> Any:
    """Return a mesh as meshio's, with a flag for each named surface.

    Parameters
    ----------
    points : (n, 3) array
        [m]
    elements : (m, 10) array
    surfaces : mapping
        Facets (t, 6) by the name of their surface.
    point_data : mapping
        Values (n, ...) at the nodes.

    Returns
    -------
    meshio.Mesh
        Cells "tetra10", and "triangle6" of all named surfaces. The cell data of each surface's name are 1 on
        its triangles, and 0 elsewhere.
    """
    import meshio

    owner = np.repeat(np.arange(len(surfaces)), [len(facets) for facets in surfaces.values()])
    inside = np.zeros(len(elements), dtype=np.int8)
    return meshio.Mesh(
        points,
        [("tetra10", elements), ("triangle6", np.concatenate(list(surfaces.values())))],
        point_data=dict(point_data),
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


def inp_nodes_and_elements(points: Array, elements: Integers, name: str) -> Iterator[str]:
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
    for surface, facets in surface_triangles(mesh).items():
        yield f"*NSET, NSET={set_name(surface)}"
        numbers = (np.unique(facets) + 1).tolist()
        for start in range(0, len(numbers), ENTRIES_PER_LINE):
            yield ",".join(map(str, numbers[start : start + ENTRIES_PER_LINE]))
        yield f"*SURFACE, NAME={set_name(surface)}, TYPE=ELEMENT"
        places = order[np.searchsorted(keys, facet_keys(facets[:, :3]), sorter=order)]
        for element, face in zip(*np.divmod(places, len(FACETS)), strict=True):
            yield f"{element + 1},S{face + 1}"
