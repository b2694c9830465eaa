"""How the correction of a throw's results changes with its dimensions.

The mutual energy E of the estimated errors of two solutions u and w (`fem.correction`) is a product of both
with a matrix Q of the mesh, E = u' Q w. Where the mesh moves with velocity v, dQ is known and

    dE = du' Q w + u' Q dw + u' dQ w

With the adjoint solution g, K g = Q w with the end sections held, nothing is solved for each dimension:
K du = -dK u for a unit motion u of the end sections, so that

    du' Q w = g' K du = -g' dK u,

but for the work of the forces that g takes at the end sections on the change of the motion prescribed
there, and under a load on a pin that of its change on g. dK is that of `fem.sensitivities.energy_slopes`.

In dQ, the elements' stresses change as their gradients do, -grad u grad v, and energies with the volumes. The
polynomials fitted to stresses move along: where v is a linear map over a patch of elements that is
exact, else neglected.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.correction import StressRecovery
from fem.material import Material
from fem.solver import SharedSolver, Stopwatch, assemble_stiffness
from fem.superelement import CondensedClass, hold_ends, solve_given_ends
from geometry.mesh import ThrowMesh

Array = NDArray[np.float64]

# A solution whose error has less than this share of the largest energy is a rigid motion.
RIGID_SHARE = 1e-12


@dataclass(frozen=True)
class ErrorAdjoint:
    """Estimated errors of a class's solutions, and adjoint solutions.

    Attributes
    ----------
    solutions : (n, 3, c) array
        Fields of unit motions of the end sections, then of loads on the pins.
    products : (m, c, c) array
        Mutual energies of their errors, by element [J].
    stresses : (m, 4, 6, c) array
        See `fem.correction.ErrorDuals`.
    fields : (n, 3, c) array
        Adjoint solutions g.
    forces : (n, 3, c) array
        That the end sections take under these.
    """

    solutions: Array
    products: Array
    stresses: Array
    fields: Array
    forces: Array

    @property
    def energies(self) -> Array:
        """Mutual energies (c, c) of the errors in the meshed part [J]."""
        return np.asarray(self.products.sum(axis=0))

    def shares(self, count: int) -> Array:
        """Sum of the share (m,) that each element has in the error's energy, over the first solutions."""
        energies = np.diagonal(self.products, axis1=1, axis2=2)[:, :count]
        whole = energies.sum(axis=0)
        strained = whole > RIGID_SHARE * whole.max()
        return np.asarray((energies[:, strained] / whole[strained]).sum(axis=1))

    def slopes(self, recovery: StressRecovery, moving: Array, stiffness_slopes: Array) -> Array:
        """Derivatives (v, c, c) of the energies, but for what acts at end sections and pins; one half.

        Parameters
        ----------
        moving : (n, v, 3) array
            Velocities of the nodes.
        stiffness_slopes : (v, c, c) array
            Derivatives of the mutual energy of solutions (row) and adjoint solutions (column).
        """
        count = len(self.products[0])
        grown = recovery.growths(moving).T @ self.products.reshape(-1, count * count)
        works = recovery.work_slopes(self.stresses, self.solutions, moving)
        return np.asarray(works - stiffness_slopes + 0.5 * grown.reshape(works.shape))


def error_adjoints(
    mesh: ThrowMesh, material: Material, recovery: StressRecovery, classes: Sequence[CondensedClass]
) -> list[ErrorAdjoint]:
    """Solve for the adjoints of all classes of a throw with rigid end sections."""
    watch, adjoints = Stopwatch(), []
    stiffness = assemble_stiffness(mesh.points, mesh.elements, material)
    held = hold_ends(mesh, stiffness, 0)
    still = np.zeros((len(held.ends), 0))
    solver = SharedSolver(classes[0].solver, watch)
    for part in classes:
        solutions = np.concatenate([part.fields, part.pin_fields], axis=2)
        duals = recovery.duals(solutions, material)
        loads = recovery.forces(duals.stresses).reshape(mesh.points.size, -1)
        fields, forces = (
            found.reshape(solutions.shape)
            for found in solve_given_ends(mesh, held, still, loads, part.symmetry, solver, watch)
        )
        adjoints.append(ErrorAdjoint(solutions, duals.products, duals.stresses, fields, forces))
    solver.close()
    return adjoints
