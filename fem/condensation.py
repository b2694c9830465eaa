"""Static condensation of a throw's quarter to the rigid motions of its end section."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.assembly import symmetric_product
from fem.solver import solve_symmetric
from fem.symmetry import SymmetryClass
from geometry.mesh import ThrowMesh
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CondensedClass:
    """A quarter condensed for one symmetry class.

    Attributes
    ----------
    symmetry : SymmetryClass
        Which class.
    stiffness : (3, 3) array
        Stiffness of the quarter against unit motions of its end section.
    fields : (n, 3, 3) array
        Displacement (node, axis) for each unit motion.
    pin_load : (3, 3) array
        Work of a unit force on the pin (uniform on its surface; axis by axis) on each unit motion:
        entry (motion, axis). Zero where the class does not move the pin along the axis.
    solver : str
        Which solver did it.
    """

    symmetry: SymmetryClass
    stiffness: Array
    fields: Array
    pin_load: Array
    solver: str


def condense(
    mesh: ThrowMesh,
    stiffness: sparse.csr_array,
    pin_shapes: Array,
    symmetry: SymmetryClass,
    solver: str = "auto",
) -> CondensedClass:
    """Condense one symmetry class of a quarter.

    Parameters
    ----------
    mesh : ThrowMesh
        The quarter.
    stiffness : sparse array
        Upper triangle of its stiffness.
    pin_shapes : (n,) array
        Share of each node in a unit force spread uniformly over the quarter's pin surface.
    symmetry : SymmetryClass
        The class.
    solver : str
        See `fem.solver.solve_symmetric`.

    Raises
    ------
    SolveError
        If the system cannot be solved.
    """
    ends = nodes_on(mesh, LEFT_END)
    blocked = np.zeros((len(mesh.points), 3), dtype=bool)
    for name, axes in zip((CRANK_PLANE, MIDDLE_PLANE), symmetry.blocked_axes(), strict=True):
        blocked[np.ix_(nodes_on(mesh, name), np.array(axes))] = True
    blocked[ends] = True
    free = np.flatnonzero(~blocked.ravel())

    fields = np.zeros((len(mesh.points), 3, 3))
    fields[ends] = _rigid_motions(mesh.points[ends])[:, :, list(symmetry.end_unknowns)]
    columns = fields.reshape(-1, 3)
    # The quarter's share of the prescribed motion acts as a load on the free unknowns.
    loads = symmetric_product(stiffness, columns)[free]
    inner = stiffness[free][:, free].tocsr()
    columns[free], used = solve_symmetric(inner, -loads, solver)
    energy = columns.T @ symmetric_product(stiffness, columns)
    return CondensedClass(
        symmetry=symmetry,
        stiffness=0.5 * (energy + energy.T),
        fields=fields,
        pin_load=np.einsum("n,nam->ma", pin_shapes, fields),
        solver=used,
    )


def nodes_on(mesh: ThrowMesh, surface: str) -> NDArray[np.int64]:
    """Nodes (corners and edge middles) on one of the plane cuts of the quarter."""
    axis, position = {
        LEFT_END: (2, 0.0),
        CRANK_PLANE: (0, 0.0),
        MIDDLE_PLANE: (2, float(mesh.points[:, 2].max())),
    }[surface]
    tolerance = 1e-9 * float(np.abs(mesh.points).max())
    return np.flatnonzero(np.abs(mesh.points[:, axis] - position) < tolerance)


def _rigid_motions(points: Array) -> Array:
    """Displacements (n, 3, 6) of points at z = 0 for the six unit motions of their section."""
    motions = np.zeros((len(points), 3, 6))
    x, y = points[:, 0], points[:, 1]
    motions[:, 0, 0] = motions[:, 1, 1] = motions[:, 2, 2] = 1.0
    motions[:, 2, 3] = y
    motions[:, 2, 4] = -x
    motions[:, 0, 5] = -y
    motions[:, 1, 5] = x
    return motions
