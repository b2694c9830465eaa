"""Element sizes given at the nodes of an earlier mesh, for refining where that one was too coarse."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

# A mesh made from a map has so many corner nodes and edge middles for each element that the map asks
# for: between the 1.33 of the inside and the more of surfaces, fitted to meshes of mixed throws.
NODES_PER_ELEMENT = 1.9


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
        return round(3.0 * NODES_PER_ELEMENT * elements)


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
