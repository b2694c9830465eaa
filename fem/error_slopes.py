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

from crankbase.array_checks import Array, Integers
from fem.correction import StressRecovery
from fem.material import Material
from fem.solver import SharedSolver, assemble_stiffness
from fem.superelement import CondensedClass, hold_ends, solve_given_ends
from fem.symmetry import RIGID, NodalLoads
from geometry.mesh import ThrowMesh

# A solution whose error has less than this share of the largest energy is a rigid motion.
RIGID_SHARE = 1e-12


@dataclass(frozen=True)
class ErrorAdjoint:
    """Estimated errors of the solutions of a class with rigid sections, and adjoint solutions.

    Of motions of sections that bend, the small corrections are taken not to change.

    Attributes
    ----------
    recovery : StressRecovery
        Of the mesh.
    motions : int
        Number of unit motions of the end sections.
    solutions : (n, 3, c) array
        Their fields, then those of loads on the pins.
    products : (m, c, c) array
        Mutual energies of their errors, by element [J].
    stresses : (m, 4, 6, c) array
        See `fem.correction.ErrorDuals`.
    fields : (n, 3, c) array
        Adjoint solutions g.
    forces : (n, 3, c) array
        That the end sections take under these.
    """

    recovery: StressRecovery
    motions: int
    solutions: Array
    products: Array
    stresses: Array
    fields: Array
    forces: Array

    @property
    def energies(self) -> Array:
        """Mutual energies (c, c) of the errors in the meshed part [J]."""
        return np.asarray(self.products.sum(axis=0))

    @property
    def shares(self) -> Array:
        """Sum over the unit motions of the share (m,) that each element has in the energy of the error."""
        energies = np.diagonal(self.products, axis1=1, axis2=2)[:, : self.motions]
        whole = energies.sum(axis=0)
        strained = whole > RIGID_SHARE * whole.max()
        return np.asarray((energies[:, strained] / whole[strained]).sum(axis=1))

    def slopes(
        self,
        part: CondensedClass,
        moving: Array,
        stiffness_slopes: Array,
        shifts: Sequence[Sequence[tuple[Integers, Array]]],
        loads: Sequence[Sequence[NodalLoads]],
    ) -> Array:
        """Derivatives (v, c, c) of the energies.

        Parameters
        ----------
        part : CondensedClass
        moving : (n, v, 3) array
            Velocities of the nodes.
        stiffness_slopes : (v, c, c) array
            Derivatives of the mutual energy of solutions (row) and adjoint solutions (column).
        shifts : by velocity, nodes and change of the unit motions prescribed there (s, 3, k)
        loads : by velocity, change of the unit loads on each pin
        """
        count = len(self.products[0])
        grown = self.recovery.growths(moving).T @ self.products.reshape(-1, count * count)
        halves = self.recovery.work_slopes(self.stresses, self.solutions, moving)
        halves += 0.5 * grown.reshape(halves.shape) - stiffness_slopes
        for half, of_ends, of_pins in zip(halves, shifts, loads, strict=True):
            for nodes, shift in of_ends:
                prescribed = shift[..., : self.motions]
                half[: self.motions] -= np.einsum("sak,sac->kc", prescribed, self.forces[nodes])
            for column, (pin, component) in enumerate(part.pin_components):
                load = of_pins[pin].of_class(part.symmetry)[..., component] / part.symmetry.copies
                work = np.einsum("sa,sac->c", load, self.fields[of_pins[pin].nodes])
                half[self.motions + column] += work
        return np.asarray(halves + halves.transpose(0, 2, 1))


def error_adjoints(
    mesh: ThrowMesh, material: Material, classes: Sequence[CondensedClass]
) -> list[ErrorAdjoint]:
    """Solve for the adjoints of all classes of a throw."""
    adjoints = []
    recovery = StressRecovery(mesh.points, mesh.elements)
    stiffness = assemble_stiffness(mesh.points, mesh.elements, material)
    held = hold_ends(mesh, stiffness, 0)
    still = np.zeros((len(held.ends), 0))
    solver = SharedSolver(classes[0].solver)
    for part in (each.up_to(RIGID) for each in classes):
        solutions = np.concatenate([part.fields, part.pin_fields], axis=2)
        duals = recovery.duals(solutions, material)
        loads = recovery.forces(duals.stresses).reshape(mesh.points.size, -1)
        fields, forces = (
            solved.reshape(solutions.shape)
            for solved in solve_given_ends(mesh, held, still, loads, part.symmetry, solver)
        )
        errors = duals.products, duals.stresses
        adjoints.append(
            ErrorAdjoint(recovery, part.fields.shape[2], solutions, *errors, fields, forces)
        )
    solver.close()
    return adjoints
