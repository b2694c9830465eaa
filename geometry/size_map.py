"""Element sizes given at the nodes of an earlier mesh, for refining where that one was too coarse."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Nodes of a mesh made from a map, for each regular element that the map asks for, and for each facet of
# the surface, cuts included; fitted to meshes of quarters, halves and whole throws.
NODES_PER_ELEMENT = 0.47
NODES_PER_FACET = 4.2
FACETS = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


@dataclass(frozen=True)
class SizeMap:
    """Wished element sizes in and around a meshed part.

    Attributes
    ----------
    points : (n, 3) array
        Corner nodes [m].
    tetrahedra : (m, 4) array
        Numbers of corner nodes.
    sizes : (n,) array
        Wished size of the elements at each node [m]; between nodes it is interpolated.
    """

    points: NDArray[np.float64]
    tetrahedra: NDArray[np.int64]
    sizes: NDArray[np.float64]

    def expected_unknowns(self, factor: float = 1.0) -> int:
        """Predict the displacement unknowns of a mesh made with `factor` times these sizes."""
        corners = self.points[self.tetrahedra]
        volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
        sizes = factor * self.sizes[self.tetrahedra].mean(axis=1)
        elements = float(np.sum(volumes / regular_volume(sizes)))
        outside = self._outside()
        first, second, third = self.points[outside].transpose(1, 0, 2)
        areas = 0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1)
        sides = factor * self.sizes[outside].mean(axis=1)
        facets = float(np.sum(areas / (0.25 * np.sqrt(3.0) * sides**2)))
        return round(3.0 * (NODES_PER_ELEMENT * elements + NODES_PER_FACET * facets))

    def _outside(self) -> NDArray[np.int64]:
        """Facets (k, 3) that bound one element only."""
        facets = self.tetrahedra[:, FACETS].reshape(-1, 3)
        low, middle, high = np.sort(facets, axis=1).T
        size = len(self.points)
        _, first, count = np.unique(
            (low * size + middle) * size + high, return_index=True, return_counts=True
        )
        return np.asarray(facets[first[count == 1]])


def element_sizes(
    points: NDArray[np.float64], tetrahedra: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Edges (m,) of regular tetrahedra with the volumes of these straight ones (m, 4) [m]."""
    corners = points[tetrahedra]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    return np.asarray(np.cbrt(volumes / regular_volume(np.ones(1))))


def regular_volume(size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Volume of a regular tetrahedron with edges of that size [m^3]."""
    return np.asarray(size**3 / (6.0 * np.sqrt(2.0)))


def set_size_map(gmsh: Any, sizes: SizeMap, factor: float) -> None:
    """Let a size map rule the current model.

    Parameters
    ----------
    gmsh : module
    sizes : SizeMap
    factor : float
        Scales all sizes.
    """
    corners = sizes.points[sizes.tetrahedra].transpose(0, 2, 1).reshape(-1, 12)
    values = factor * sizes.sizes[sizes.tetrahedra]
    view = gmsh.view.add("sizes")
    gmsh.view.addListData(view, "SS", len(corners), np.hstack([corners, values]).ravel())
    field = gmsh.model.mesh.field.add("PostView")
    gmsh.model.mesh.field.setNumber(field, "ViewTag", view)
    # Points beside the straight elements of a curved surface take the size of the closest node.
    gmsh.model.mesh.field.setNumber(field, "UseClosest", 1)
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
