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


# A triangle may turn so far when a point is taken away [cosine].
TURN = 0.95
# What a change of the values by their whole range, and a length, weigh beside a dent of the surface
# of the same size as the surface itself.
VALUE_WEIGHT, LENGTH_WEIGHT = 0.03, 1e-3


def decimate_triangles(surface: TriangleSurface, values: Array, most: int) -> TriangleSurface:
    """Take points away until few enough triangles are left, or no more can go unnoticed.

    Parameters
    ----------
    surface : TriangleSurface
        Closed.
    values : (n,) array
        Colors of the points: where they change steeply, points stay longer.
    most : int
        Triangles.

    Returns
    -------
    TriangleSurface
        With the points of the given one, of which some are not used any more.

    Notes
    -----
    A point is moved onto a neighbor and its two triangles beside that edge vanish, as in H. Hoppe,
    Progressive Meshes, SIGGRAPH 1996. Points on sharp edges stay.
    """
    points, triangles = surface.points, surface.triangles
    size = float(np.ptp(points, axis=0).max())
    weights = values * (VALUE_WEIGHT * size / max(float(np.ptp(values)), np.finfo(float).tiny))
    fixed = np.zeros(len(points), dtype=bool)
    fixed[surface.sharp_edges()] = True
    while len(triangles) > most:
        pairs, costs = _moves(TriangleSurface(points, triangles), weights, fixed)
        # Each takes two triangles with it.
        wanted = (len(triangles) - most + 1) // 2
        order = np.argsort(costs, kind="stable")
        goes = _independent_moves(pairs[order], triangles, len(points), wanted)
        triangles = goes[triangles]
        kept = np.all(triangles != np.roll(triangles, 1, axis=1), axis=1)
        if kept.all():
            break
        triangles = triangles[kept]
    return TriangleSurface(points, triangles)


def _moves(
    surface: TriangleSurface, weights: Array, fixed: NDArray[np.bool_]
) -> tuple[Integers, Array]:
    """Return from and to which point (m, 2) one may be moved, and what it costs (m,), one for a point."""
    points, triangles = surface.points, surface.triangles
    ends, _, _ = surface.edges()
    moves = np.concatenate([ends, ends[:, ::-1]])
    moves = moves[~fixed[moves[:, 0]]]
    if not len(moves):
        return moves, np.empty(0)
    # All triangles round each point, one point after the other.
    corners = triangles.ravel()
    sequence = np.argsort(corners, kind="stable")
    counts = np.bincount(corners, minlength=len(points))
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    each = counts[moves[:, 0]]
    first = np.concatenate(([0], np.cumsum(each)[:-1]))
    inside = np.arange(each.sum()) - np.repeat(first, each)
    round_it = sequence[np.repeat(starts[moves[:, 0]], each) + inside] // 3
    source, target = (np.repeat(column, each) for column in moves.T)
    old = surface.face_normals[round_it]
    changed = np.where(triangles[round_it] == source[:, None], target[:, None], triangles[round_it])
    new = TriangleSurface(points, changed).face_normals
    sizes = np.linalg.norm(old, axis=1)
    cosines = np.sum(old * new, axis=1) - TURN * sizes * np.linalg.norm(new, axis=1)
    vanishes = np.any(triangles[round_it] == target[:, None], axis=1)
    allowed = np.logical_and.reduceat((cosines > 0.0) | vanishes, first)
    away = points[target] - points[source]
    dents = np.maximum.reduceat(np.abs(np.sum(old * away, axis=1)) / sizes, first)
    lengths = np.linalg.norm(points[moves[:, 1]] - points[moves[:, 0]], axis=1)
    costs = dents + LENGTH_WEIGHT * lengths + np.abs(np.subtract(*weights[moves.T]))
    moves, costs = moves[allowed], costs[allowed]
    order = np.lexsort((costs, moves[:, 0]))
    best = order[np.unique(moves[order, 0], return_index=True)[1]]
    return moves[best], costs[best]


def _independent_moves(moves: Integers, triangles: Integers, count: int, most: int) -> Integers:
    """Choose independent moves, cheapest first, and return where points go (n,)."""
    around: list[set[int]] = [set() for _ in range(count)]
    for a, b, c in triangles.tolist():
        around[a] |= {b, c}
        around[b] |= {a, c}
        around[c] |= {a, b}
    goes = np.arange(count)
    touched = [False] * count
    for source, target in moves.tolist():
        ring = around[source]
        # With more than two common neighbors the surface would touch itself.
        if touched[source] or len(ring & around[target]) != 2 or any(touched[k] for k in ring):
            continue
        goes[source] = target
        touched[source] = True
        for point in ring:
            touched[point] = True
        most -= 1
        if most == 0:
            break
    return goes
