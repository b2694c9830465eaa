"""The surface of a whole throw, mirrored from its quarter, with displacements for pictures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.analysis import ThrowAnalysis
from fem.loads import six_node_triangles
from fem.symmetry import AXIAL, MIRROR_X, MIRROR_Z
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE

Array = NDArray[np.float64]

# A six-node triangle (corners 0 1 2, edge middles 3 4 5 on 01 12 02) as four flat ones.
SUBTRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
EDGE_PATHS = ((0, 3, 1), (1, 4, 2), (2, 5, 0))


@dataclass(frozen=True)
class Surface:
    """Triangles and element edges of a throw's outside.

    Attributes
    ----------
    points : (n, 3) array
        [m]
    triangles : (t, 3) array
        Flat triangles, four per element side.
    edges : (e, 3) array
        Element edges as corner, middle, corner.
    displacement : (n, 3) array
        Of the lengthened throw [m]; its size is arbitrary.
    """

    points: Array
    triangles: NDArray[np.int64]
    edges: NDArray[np.int64]
    displacement: Array


def stretched_quarter(analysis: ThrowAnalysis) -> Array:
    """Displacement (n, 3) of the quarter's nodes under an axial pull of 1 N, ends pinned [m]."""
    part = next(found for found in analysis.classes if found.symmetry == AXIAL)
    # Unknowns of the class: uy blocked, uz moves by half the lengthening, rx follows freely.
    half = 0.5 * analysis.axial_compliance("pinned")
    tilt = part.stiffness[2, 1] / part.stiffness[2, 2] * half
    return np.asarray(part.fields @ np.array([0.0, -half, tilt]))


def stretched_surface(analysis: ThrowAnalysis) -> Surface:
    """Surface of the whole throw under an axial force, ends pinned.

    Parameters
    ----------
    analysis : ThrowAnalysis
        With the axial symmetry class solved.

    Returns
    -------
    Surface
        Displacements are those of 1 N, both ends moving apart.
    """
    mesh = analysis.mesh
    displacement = stretched_quarter(analysis)
    outside = [
        corners
        for name, corners in mesh.surfaces.items()
        if name not in (CRANK_PLANE, MIDDLE_PLANE) and len(corners)
    ]
    sides = six_node_triangles(mesh, np.concatenate(outside))
    triangles = np.concatenate([sides[:, list(corners)] for corners in SUBTRIANGLES])
    edges = np.concatenate([sides[:, list(path)] for path in EDGE_PATHS])

    middle = np.array([0.0, 0.0, analysis.throw.length / 2.0])
    points: list[Array] = []
    moved: list[Array] = []
    all_triangles: list[NDArray[np.int64]] = []
    all_edges: list[NDArray[np.int64]] = []
    for mirror_x in (False, True):
        for mirror_z in (False, True):
            signs = np.ones(3)
            signs = signs * MIRROR_X[:3] if mirror_x else signs
            signs = signs * MIRROR_Z[:3] if mirror_z else signs
            offset = len(points) * len(mesh.points)
            points.append((mesh.points - middle) * signs + middle)
            moved.append(displacement * signs)
            # An odd number of mirrors turns the triangles inside out.
            turned = triangles[:, ::-1] if mirror_x != mirror_z else triangles
            all_triangles.append(turned + offset)
            all_edges.append(edges + offset)
    return Surface(
        np.concatenate(points),
        np.concatenate(all_triangles),
        np.concatenate(all_edges),
        np.concatenate(moved),
    )
