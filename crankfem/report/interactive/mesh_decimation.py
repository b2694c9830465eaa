"""Fewer triangles for a surface, where it is flat and its values hardly change."""

import numpy as np
from numpy.typing import NDArray

from crankfem.report.interactive.triangles import TriangleSurface

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

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
