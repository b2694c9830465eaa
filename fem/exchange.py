"""A solved throw for scikit-fem, meshio and PyVista: whole, under unit loads, ends pinned.

Fields are those of the finite elements, without correction for discretization: their energies are those of
`ThrowAnalysis.discrete`.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.summaries import frozen
from fem.fillet_peaks import LoadedThrow, under_unit_loads, unit_loads
from fem.material import Material
from fem.solver import QUADRATURE_ORDER
from fem.superelement import CondensedClass
from fem.symmetry import RIGID, radial_directions
from fem.whole_throw import whole_elements, whole_points, whole_surfaces
from geometry.any_throw import Throw
from geometry.mesh import ThrowMesh
from geometry.mesh_exchange import meshio_mesh
from geometry.shapes import facet_keys

if TYPE_CHECKING:
    from skfem import CellBasis, MeshTet2


@frozen("mesh.nelements", "basis.N", eq=False)
class SkfemThrow:
    """A whole throw as scikit-fem's mesh, with its displacements under unit loads, ends pinned.

    Attributes
    ----------
    mesh : skfem.MeshTet2
        In the throw frame [m]; its boundaries have the names of the surfaces, such as "left end", "pin" and
        "fillet".
    basis : skfem.CellBasis
        Of displacements, with the quadrature that the throw was solved with.
    displacement : mapping
        Load to the vector (N,) of the basis under it [m per N or N m]: "axial force", "torque", "bending in
        the crank plane", "bending across the crank plane", "radial force" (of several pins, "radial force
        on pin 1" and so on). Not corrected for discretization.
    """

    mesh: "MeshTet2"
    basis: "CellBasis"
    displacement: Mapping[str, Array]


def loaded_throw(
    throw: Throw, mesh: ThrowMesh, material: Material, classes: Sequence[CondensedClass]
) -> LoadedThrow:
    """Return the displacements of a solved throw under the unit loads, ends pinned.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All of the mesh, not corrected.
    """
    loads = unit_loads(radial_directions(throw))
    return under_unit_loads(mesh, loads, material, [part.up_to(RIGID) for part in classes])


def skfem_throw(loaded: LoadedThrow) -> SkfemThrow:
    """Return a loaded throw for scikit-fem."""
    from skfem import Basis, ElementTetP2, ElementVector, MeshTet1, MeshTet2

    mesh, whole = loaded.mesh, loaded.whole
    points, elements = whole_points(mesh, whole), whole_elements(whole, mesh.elements)
    corners, vertices = np.unique(elements[:, :4], return_inverse=True)
    linear = MeshTet1(*map(np.ascontiguousarray, (points[corners].T, vertices.reshape(-1, 4).T)))
    # Our nodes on the edges in the order of scikit-fem's edges.
    middles = np.empty(linear.edges.shape[1], dtype=np.int64)
    middles[linear.t2e] = elements[:, 4:].T
    keys = facet_keys(linear.facets.T.astype(np.int64))
    order = np.argsort(keys)
    boundaries = {
        name: order[
            np.searchsorted(keys, facet_keys(np.searchsorted(corners, facets[:, :3])), sorter=order)
        ]
        for name, facets in whole_surfaces(mesh, whole).items()
    }
    nodes = np.concatenate([corners, middles])
    curved = MeshTet2(np.ascontiguousarray(points[nodes].T), linear.t)
    curved = curved.with_boundaries(boundaries)
    basis = Basis(curved, ElementVector(ElementTetP2()), intorder=QUADRATURE_ORDER)
    displacement = {}
    for load, field in zip(loaded.loads, np.moveaxis(_displacements(loaded), -1, 0), strict=True):
        vector = displacement[load.name] = np.empty(basis.N)
        vector[basis.nodal_dofs], vector[basis.edge_dofs] = field[corners].T, field[middles].T
    return SkfemThrow(curved, basis, displacement)


def meshio_throw(loaded: LoadedThrow) -> Any:
    """Return a loaded throw for meshio, with displacements and stresses at the nodes."""
    mesh, whole = loaded.mesh, loaded.whole
    displacements = _displacements(loaded)
    stresses = whole.collect(loaded.stresses(whole.images))
    values = {}
    for number, load in enumerate(loaded.loads):
        per = load.unit if load.unit == "N" else f"({load.unit})"
        values[f"displacement, {load.name} [m/{per}]"] = displacements[..., number]
        values[f"stress, {load.name} [Pa/{per}]"] = stresses[:, number]
    return meshio_mesh(
        whole_points(mesh, whole),
        whole_elements(whole, mesh.elements),
        whole_surfaces(mesh, whole),
        values,
    )


def _displacements(loaded: LoadedThrow) -> Array:
    """Displacements (w, 3, k) of the whole throw's nodes under the loads [m]."""
    whole = loaded.whole
    return whole.collect([loaded.displacement(image) for image in whole.images])
