"""Surfaces of triangles for a browser: their edges and their shading."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# An angle between faces that makes an edge [deg].
SHARP = 30.0


@dataclass(frozen=True, eq=False)
class TriangleSurface:
    """Triangles, counterclockwise from outside.

    Attributes
    ----------
    points : (n, 3) array
    triangles : (t, 3) array
    """

    points: Array
    triangles: Integers

    @property
    def face_normals(self) -> Array:
        """Normals (t, 3) of twice the triangles' area."""
        corners = self.points[self.triangles]
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    @property
    def point_normals(self) -> Array:
        """Unit normals (n, 3) of the points, those of their triangles weighted with the area."""
        summed = np.zeros_like(self.points)
        normals = self.face_normals
        for column in self.triangles.T:
            np.add.at(summed, column, normals)
        sizes = np.linalg.norm(summed, axis=1, keepdims=True)
        return np.asarray(summed / np.where(sizes > 0.0, sizes, 1.0))

    def edges(self) -> tuple[Integers, Integers, NDArray[np.bool_]]:
        """Edges between two triangles.

        Returns
        -------
        ends : (e, 2) array
            Points.
        sides : (e, 2) array
            Triangles on both sides.
        sharp : (e,) array of bool
            Whether they meet at more than the angle that makes an edge.
        """
        count = len(self.triangles)
        ends = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        owners = np.repeat(np.arange(count), 3)
        order = np.lexsort((ends[:, 1], ends[:, 0]))
        same = np.flatnonzero(np.all(ends[order][1:] == ends[order][:-1], axis=1))
        first, second = order[same], order[same + 1]
        sides = np.column_stack([owners[first], owners[second]])
        normals = self.face_normals
        sizes = np.linalg.norm(normals, axis=1)
        cosines = np.sum(normals[sides[:, 0]] * normals[sides[:, 1]], axis=1)
        limit = np.cos(np.deg2rad(SHARP)) * sizes[sides[:, 0]] * sizes[sides[:, 1]]
        return ends[first], sides, cosines < limit

    def sharp_edges(self, shortest: float = 0.0) -> Integers:
        """Edges (s, 2) at which the surface bends sharply.

        Parameters
        ----------
        shortest : float
            Least length of what hangs together; dents of single elements are shorter.
        """
        ends, _, sharp = self.edges()
        found = ends[sharp]
        pieces = _connected(found, len(self.points))[found[:, 0]]
        lengths = np.linalg.norm(np.subtract(*self.points[found.T]), axis=1)
        return found[np.bincount(pieces, lengths)[pieces] >= shortest] if len(found) else found

    def split_at_sharp_edges(self) -> tuple[Integers, Integers]:
        """Split the surface at sharp edges, so that shading does not round off its edges.

        Returns
        -------
        sources : (m,) array
            The point that each new point is a copy of.
        triangles : (t, 3) array
            Of new points.
        """
        count = len(self.triangles)
        _, sides, sharp = self.edges()
        patches = _connected(sides[~sharp], count)
        keys = self.triangles + len(self.points) * patches[:, None]
        unique, triangles = np.unique(keys, return_inverse=True)
        return unique % len(self.points), triangles.reshape(count, 3)


def _connected(pairs: Integers, count: int) -> Integers:
    """Return for each of some things the number of the group that pairs of them join."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def polylines(ends: Integers) -> list[list[int]]:
    """Join edges (e, 2) end to end to polylines, so that they are drawn in few strokes.

    Returns
    -------
    list of lists of points
        Each edge is in exactly one of them.
    """
    at: dict[int, list[int]] = {}
    pairs = ends.tolist()
    for number, pair in enumerate(pairs):
        for end in pair:
            at.setdefault(end, []).append(number)
    used = [False] * len(pairs)
    found = []
    # Odd points first: strokes that begin there need not begin in their middle.
    for start in sorted(at, key=lambda point: len(at[point]) % 2 == 0):
        while True:
            trail, here = [start], start
            while True:
                waiting = at[here]
                while waiting and used[waiting[-1]]:
                    waiting.pop()
                if not waiting:
                    break
                number = waiting.pop()
                used[number] = True
                first, second = pairs[number]
                here = second if here == first else first
                trail.append(here)
            if len(trail) == 1:
                break
            found.append(trail)
    return found
