"""Stresses over the fillets and oil holes of a whole throw."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.surface_stress import surface_stress
from fem.unit_loads import LoadedThrow, whole_facets, whole_nodes
from geometry.facets import six_node_triangles
from geometry.mesh import ThrowMesh
from geometry.solid import CRANK_PLANE, FILLET, LEFT_END, MIDDLE_PLANE, OIL_HOLE, RIGHT_END

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Surfaces where stresses are asked for, and those that are not free.
STRESSED = (FILLET, OIL_HOLE)
CUTS_AND_ENDS = (CRANK_PLANE, MIDDLE_PLANE, LEFT_END, RIGHT_END)


@dataclass(frozen=True)
class FilletSurface:
    """Nodes on the fillets and in the oil holes of a whole throw with their stresses.

    Attributes
    ----------
    nodes : (s,) array
        Their numbers by `fem.unit_loads.whole_nodes`.
    points : (s, 3) array
        [m]
    stress : (s, k, 6) array
        xx, yy, zz, xy, yz, zx under k loads [Pa].
    meshed : (s,) array of bool
        Which are on the meshed part itself, not only on its mirror images.
    normals : (s, 3) array
        Of the surface, outwards.
    """

    nodes: Integers
    points: Array
    stress: Array
    meshed: NDArray[np.bool_]
    normals: Array


def fillet_surface(loaded: LoadedThrow) -> FilletSurface:
    """Recover the stresses at fillets and oil holes of a loaded throw from the strains of the surface.

    The facets of the whole throw are used, so that points on a cut are treated like
    any other.
    """
    mesh = loaded.mesh
    facets, on_fillet = _facets_at_fillets(mesh)
    whole = whole_nodes(mesh)
    points = whole.collect([image.points(mesh.points) for image in whole.images])
    displacement = whole.collect([loaded.displacement(image) for image in whole.images])
    found = surface_stress(
        points,
        whole_facets(whole, facets),
        np.tile(on_fillet, len(whole.images)),
        displacement,
        loaded.material,
    )
    meshed = np.isin(found.nodes, whole.numbers[0])
    return FilletSurface(found.nodes, points[found.nodes], found.stress, meshed, found.normals)


def fillet_points(mesh: ThrowMesh) -> Array:
    """Nodes (p, 3) on the fillets and in the oil holes of a meshed part [m]."""
    corners = np.concatenate([mesh.surfaces[name] for name in STRESSED if name in mesh.surfaces])
    return np.asarray(mesh.points[np.unique(six_node_triangles(mesh, corners))])


def _facets_at_fillets(mesh: ThrowMesh) -> tuple[Integers, NDArray[np.bool_]]:
    """Facets (t, 6) on and next to fillets and oil holes, and which are on them."""
    free = [name for name in mesh.surfaces if name not in CUTS_AND_ENDS]
    corners = np.concatenate([mesh.surfaces[name] for name in free])
    kinds = [np.full(len(mesh.surfaces[name]), name in STRESSED) for name in free]
    on_fillet = np.concatenate(kinds)
    near = np.isin(corners, corners[on_fillet]).any(axis=1)
    return six_node_triangles(mesh, corners[near]), on_fillet[near]
