"""The surface of a whole throw, mirrored from its meshed part, with displacements for pictures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.fields import displacement_field, images
from fem.superelement import RZ, UZ
from fem.supports import end_motions
from fem.throw_analysis import ThrowAnalysis
from geometry.facets import SUBTRIANGLES, six_node_triangles
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE

Array = NDArray[np.float64]

# The edges of a six-node triangle: corner, middle, corner.
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


def stretched_part(analysis: ThrowAnalysis) -> Array:
    """Displacement (n, 3) of the mesh's nodes under an axial pull of 1 N, ends pinned [m]."""
    return displacement_field(analysis.classes, _stretched_ends(analysis))


def stretched_surface(analysis: ThrowAnalysis) -> Surface:
    """Surface of the whole throw under an axial force, ends pinned.

    Parameters
    ----------
    analysis : ThrowAnalysis

    Returns
    -------
    Surface
        Displacements are those of 1 N, both ends moving apart.
    """
    mesh = analysis.mesh
    outside = [
        corners
        for name, corners in mesh.surfaces.items()
        if name not in (CRANK_PLANE, MIDDLE_PLANE) and len(corners)
    ]
    sides = six_node_triangles(mesh, np.concatenate(outside))
    triangles = np.concatenate([sides[:, list(corners)] for corners in SUBTRIANGLES])
    edges = np.concatenate([sides[:, list(path)] for path in EDGE_PATHS])
    copies = images(mesh, analysis.classes, _stretched_ends(analysis))
    offsets = np.arange(len(copies)) * len(mesh.points)
    return Surface(
        points=np.concatenate([copy.points for copy in copies]),
        triangles=np.concatenate(
            [
                (triangles[:, ::-1] if copy.inside_out else triangles) + offset
                for copy, offset in zip(copies, offsets, strict=True)
            ]
        ),
        edges=np.concatenate([edges + offset for offset in offsets]),
        displacement=np.concatenate([copy.displacement for copy in copies]),
    )


def _stretched_ends(analysis: ThrowAnalysis) -> Array:
    """Motions (12,) of both ends under an axial pull of 1 N, moving apart by equal amounts."""
    motions = end_motions(analysis.superelement, "pinned")[:, 0]
    for unknown in (UZ, RZ):
        motions[[unknown, 6 + unknown]] -= 0.5 * (motions[unknown] + motions[6 + unknown])
    return motions
