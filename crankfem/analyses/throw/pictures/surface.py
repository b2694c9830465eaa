"""The surface of a whole throw, mirrored from its meshed part, with displacements or stresses."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fem.fields import displacement_field, images
from fem.fillet_peaks import FilletStresses
from fem.superelement import RZ, UZ
from fem.supports import end_motions
from fem.surface_stress import von_mises
from fem.throw_analysis import ThrowAnalysis
from fem.unit_loads import WholeNodes, whole_facets, whole_nodes
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE
from geometry.solid_files import write_mesh

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ThrowSurface:
    """Curved triangles of a throw's outside.

    Attributes
    ----------
    points : (n, 3) array
        All nodes of the throw, those on the cuts once [m].
    facets : (t, 6) array
        Corners, then edge middles, of each triangle, counterclockwise from outside.
    values : (n, ...) array
        At the nodes: displacements (n, 3) [m], or equivalent stresses (n, loads) [Pa].
    """

    points: Array
    facets: Integers
    values: Array


def write_vtu(analysis: ThrowAnalysis, path: str | Path) -> Path:
    """Write the solved mesh with its displacement under 1 N of axial pull, ends pinned.

    Parameters
    ----------
    analysis : ThrowAnalysis
    path : path
        File ending in ``.vtu`` or another format of `write_mesh` that carries values at nodes.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, or the file cannot be written.
    """
    field = displacement_field(analysis.classes, _stretched_ends(analysis))
    return write_mesh(analysis.mesh, path, {"displacement": field})


def stretched_surface(analysis: ThrowAnalysis) -> ThrowSurface:
    """Return the surface of the whole throw with displacements under an axial pull of 1 N, ends pinned."""
    mesh = analysis.mesh
    whole = whole_nodes(mesh)
    copies = images(mesh, analysis.classes, _stretched_ends(analysis))
    return ThrowSurface(
        whole_points(mesh, whole),
        whole_facets(whole, outside_facets(mesh)),
        whole.collect([copy.displacement for copy in copies]),
    )


def stressed_surface(stresses: FilletStresses) -> ThrowSurface:
    """Return the surface of the whole throw with equivalent stresses (von Mises) under all loads."""
    loaded, mesh = stresses.loaded, stresses.loaded.mesh
    whole = whole_nodes(mesh)
    equivalent = whole.collect([von_mises(part) for part in loaded.stresses(whole.images)])
    # Where it is known better.
    equivalent[stresses.surface.nodes] = von_mises(stresses.surface.stress)
    facets = whole_facets(whole, outside_facets(mesh))
    return ThrowSurface(whole_points(mesh, whole), facets, equivalent)


def whole_points(mesh: ThrowMesh, whole: WholeNodes) -> Array:
    """Return the nodes (n, 3) of a whole throw [m]."""
    return whole.collect([image.points(mesh.points) for image in whole.images])


def outside_facets(mesh: ThrowMesh) -> Integers:
    """Return the facets (t, 6) of the meshed part that are not on its cuts, by surface."""
    return six_node_triangles(mesh, np.concatenate(list(outside_corners(mesh).values())))


def outside_corners(mesh: ThrowMesh) -> dict[str, Integers]:
    """Return the corners of those facets, by the name of their surface."""
    return {
        name: corners
        for name, corners in mesh.surfaces.items()
        if name not in (CRANK_PLANE, MIDDLE_PLANE)
    }


def _stretched_ends(analysis: ThrowAnalysis) -> Array:
    """Motions (12,) of both ends under an axial pull of 1 N, moving apart by equal amounts."""
    motions = end_motions(analysis.superelement, "pinned")[:, 0]
    for unknown in (UZ, RZ):
        motions[[unknown, 6 + unknown]] -= 0.5 * (motions[unknown] + motions[6 + unknown])
    return motions
