"""Static condensation of a throw's meshed part to the rigid motions of its end sections."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.assembly import symmetric_product
from fem.solver import solve_symmetric
from fem.symmetry import SymmetryClass
from geometry.mesh import ThrowMesh
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE, RIGHT_END

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CondensedClass:
    """A throw's meshed part condensed for one symmetry class of k unknowns.

    Attributes
    ----------
    symmetry : SymmetryClass
        Which class; the columns of its ``ends`` are the unit motions below.
    stiffness : (k, k) array
        Stiffness of the meshed part against the unit motions.
    fields : (n, 3, k) array
        Displacement (node, axis) for each unit motion.
    pin_loads : (pins, k, 3) array
        Work of a unit force on each whole pin (uniform on its surface; axis by axis) on each unit
        motion.
    solver : str
        Which solver did it.
    """

    symmetry: SymmetryClass
    stiffness: Array
    fields: Array
    pin_loads: Array
    solver: str


def condense(
    mesh: ThrowMesh,
    stiffness: sparse.csr_array,
    pin_shapes: Array,
    symmetry: SymmetryClass,
    solver: str = "auto",
) -> CondensedClass:
    """Condense one symmetry class of a throw's meshed part.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    stiffness : sparse array
        Upper triangle of its stiffness.
    pin_shapes : (pins, n) array
        Share of each node in a unit force spread uniformly over the meshed surface of each pin.
    symmetry : SymmetryClass
        The class, one of `fem.symmetry.symmetry_classes` of the part.
    solver : str
        See `fem.solver.solve_symmetric`.

    Raises
    ------
    SolveError
        If the system cannot be solved.
    """
    ends = symmetry.ends
    count = ends.shape[1]
    blocked = np.zeros((len(mesh.points), 3), dtype=bool)
    for surface, axes in symmetry.blocked_axes().items():
        blocked[np.ix_(nodes_on(mesh, surface), np.array(axes))] = True
    fields = np.zeros((len(mesh.points), 3, count))
    prescribed = {LEFT_END: ends[:6]}
    if not symmetry.middle_plane:
        prescribed[RIGHT_END] = ends[6:]
    for surface, motions in prescribed.items():
        section = nodes_on(mesh, surface)
        blocked[section] = True
        fields[section] = _rigid_motions(mesh.points[section]) @ motions
    free = np.flatnonzero(~blocked.ravel())

    columns = fields.reshape(-1, count)
    # The meshed part's share of the prescribed motion acts as a load on the free unknowns.
    loads = symmetric_product(stiffness, columns)[free]
    inner = stiffness[free][:, free].tocsr()
    columns[free], used = solve_symmetric(inner, -loads, solver)
    energy = columns.T @ symmetric_product(stiffness, columns)
    return CondensedClass(
        symmetry=symmetry,
        stiffness=0.5 * (energy + energy.T),
        fields=fields,
        pin_loads=np.einsum("pn,nak->pka", pin_shapes, fields) * symmetry.moves_pins,
        solver=used,
    )


def nodes_on(mesh: ThrowMesh, surface: str) -> NDArray[np.int64]:
    """Nodes (corners and edge middles) on one of the end sections or plane cuts."""
    axis, position = {
        LEFT_END: (2, 0.0),
        RIGHT_END: (2, mesh.length),
        CRANK_PLANE: (0, 0.0),
        MIDDLE_PLANE: (2, 0.5 * mesh.length),
    }[surface]
    tolerance = 1e-9 * float(np.abs(mesh.points).max())
    return np.flatnonzero(np.abs(mesh.points[:, axis] - position) < tolerance)


def _rigid_motions(points: Array) -> Array:
    """Displacements (n, 3, 6) of a section's points for the six unit motions of its center."""
    motions = np.zeros((len(points), 3, 6))
    x, y = points[:, 0], points[:, 1]
    motions[:, 0, 0] = motions[:, 1, 1] = motions[:, 2, 2] = 1.0
    motions[:, 2, 3] = y
    motions[:, 2, 4] = -x
    motions[:, 0, 5] = -y
    motions[:, 1, 5] = x
    return motions
