"""Surfaces of a mesh: the curved triangles of its facets, and flat ones for pictures and files."""

import numpy as np
from numpy.typing import NDArray

from geometry.mesh import ThrowMesh
from geometry.shapes import EDGES

# A six-node triangle (corners 0 1 2, edge middles 3 4 5 on 01 12 02) as four flat ones.
SUBTRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


def six_node_triangles(mesh: ThrowMesh, corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the edge nodes of surface triangles (k, 3), in scikit-fem's order (01, 12, 02)."""
    size = len(mesh.points)
    ends = np.concatenate([mesh.elements[:, [a, b]] for a, b in EDGES])
    middles = np.concatenate([mesh.elements[:, node] for node in range(4, 10)])
    keys = ends.min(axis=1) * size + ends.max(axis=1)
    keys, first = np.unique(keys, return_index=True)
    middles = middles[first]
    edges = [corners[:, [a, b]] for a, b in ((0, 1), (1, 2), (0, 2))]
    wanted = [edge.min(axis=1) * size + edge.max(axis=1) for edge in edges]
    return np.column_stack([corners, *(middles[np.searchsorted(keys, w)] for w in wanted)])


def flat_triangles(mesh: ThrowMesh) -> NDArray[np.int64]:
    """Flat triangles (t, 3), four to each curved one, over all surfaces, cuts included."""
    sides = six_node_triangles(mesh, np.concatenate(list(mesh.surfaces.values())))
    return np.concatenate([sides[:, list(corners)] for corners in SUBTRIANGLES])
