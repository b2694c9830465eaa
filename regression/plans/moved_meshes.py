"""Which designs of a study share a mesh that is moved, whose it is, and which of them are anchors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from crankbase.array_checks import Array
from geometry.throw import CrankThrow
from geometry.topology import topology

Mesh = Literal["new", "moved"]
NEW_MESH: Mesh = "new"
MOVED_MESH: Mesh = "moved"
MESHES = (NEW_MESH, MOVED_MESH)
# A class of fewer designs for each factor does not repay its anchors.
FEWEST = 4
# With so few factors and so coarse an accuracy one anchor will do, until so many designs share more.
FEW_FACTORS, COARSE, MANY_DESIGNS = 3, 0.02, 100
# Anchors are solved to this, or to the study's accuracy if that is finer: a moved mesh leaves less than
# coarser ones do.
ANCHOR_ACCURACY = 0.01
# Anchors for each coefficient of a ratio that is linear in the factors.
ANCHORS = 1.5


@dataclass(frozen=True)
class MeshClass:
    """Designs of one topology that share a mesh.

    Attributes
    ----------
    number : int
        From 1.
    members, anchors : tuple of int
        Places of its designs, and of those with meshes of their own besides.
    throw : mapping
        The throw whose mesh is moved, as JSON content.
    """

    number: int
    members: tuple[int, ...]
    anchors: tuple[int, ...]
    throw: Mapping[str, Any]


def anchor_count(designs: int, factors: int, accuracy: float) -> int:
    """Number of anchors of a class of so many designs; 0 if it does not repay any."""
    if designs < FEWEST * factors:
        return 0
    if factors <= FEW_FACTORS and accuracy >= COARSE and designs < MANY_DESIGNS:
        return 1
    return math.ceil(ANCHORS * (factors + 1))


def mesh_classes(
    throws: Sequence[Mapping[str, Any]], values: Array, accuracy: float
) -> list[MeshClass]:
    """Sort throws into classes of one topology, those left out that do not repay a moved mesh.

    Parameters
    ----------
    throws : sequence
        As JSON content.
    values : (n, k) array
        Of the factors that are numbers, of the first n throws. These decide; the others only join.
    accuracy : float
        Of the anchors.
    """
    by_topology: dict[str, list[int]] = {}
    for place, record in enumerate(throws):
        by_topology.setdefault(topology(CrankThrow(**record)), []).append(place)
    spans = np.ptp(values, axis=0)
    coded = (values / np.where(spans > 0.0, spans, 1.0))[:, spans > 0.0]
    classes: list[MeshClass] = []
    for members in by_topology.values():
        deciding = [place for place in members if place < len(values)]
        count = anchor_count(len(deciding), coded.shape[1], accuracy)
        if count:
            anchors = [deciding[place] for place in _spread(coded[deciding], count)]
            number = len(classes) + 1
            classes.append(MeshClass(number, tuple(members), tuple(anchors), throws[anchors[0]]))
    return classes


def _spread(points: Array, count: int) -> list[int]:
    """Choose the point nearest to the middle, then again and again that farthest from the chosen ones."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    chosen = [int(np.linalg.norm(points - middle, axis=1).argmin())]
    away = np.full(len(points), np.inf)
    while len(chosen) < count:
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(away.argmax()))
    return chosen
