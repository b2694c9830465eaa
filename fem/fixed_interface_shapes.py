"""Shapes of a throw with its end sections fixed: natural modes, and responses to inertia forces."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eigh

from fem.assembly import symmetric_product
from fem.class_modes import ClassProblem
from fem.condensation import CondensedClass
from fem.symmetry import SymmetryClass
from geometry.mesh import ThrowMesh

Array = NDArray[np.float64]

# Corrections of which the other shapes compose all but this share (of the square) are left out.
INDEPENDENT = 1e-9


@dataclass(frozen=True)
class FixedInterfaceShapes:
    """Shapes (3 n, m) with the end sections held, and their coupling to ends and pins."""

    symmetries: tuple[SymmetryClass, ...]
    squares: Array
    natural: NDArray[np.bool_]
    shapes: Array
    coupling: Array
    pin_loads: Array


def _fixed_interface_shapes(
    problem: ClassProblem, cutoff: float, inertia: Array
) -> tuple[Array, NDArray[np.bool_], Array]:
    """Squares (m,), whether natural (m,), and shapes (3 n, m) of one class.

    Corrections are the responses to forces `inertia` (3 n, c), without the natural modes in them.
    """
    modes = problem.up_to(cutoff)
    kept = modes.part(slice(0, int(np.count_nonzero(modes.frequencies <= cutoff))))
    natural = kept.shapes.reshape(3 * problem.nodes, -1)[problem.free]
    squares, corrections = _corrections(problem, natural, inertia[problem.free])
    shapes = problem.displacement(np.hstack([natural, corrections]))
    return (
        np.concatenate([kept.squares, squares]),
        np.repeat([True, False], [len(kept.squares), len(squares)]),
        shapes.reshape(3 * problem.nodes, -1),
    )


def _corrections(problem: ClassProblem, natural: Array, forces: Array) -> tuple[Array, Array]:
    """Static responses (f, c) to forces, orthogonal to natural modes and each other, and their w^2."""
    if not forces.shape[1]:
        return np.zeros(0), forces
    copies = problem.symmetry.copies
    answers = problem.factors.solve(forces)
    masses = copies * np.sum(answers * symmetric_product(problem.mass, answers), axis=0)
    answers = answers / np.sqrt(masses)
    for _ in range(2):  # once leaves rounding of the size of the natural modes' large shares
        answers -= natural @ (copies * natural.T @ symmetric_product(problem.mass, answers))
    mass = copies * answers.T @ symmetric_product(problem.mass, answers)
    sizes, directions = eigh(mass)
    independent = sizes > INDEPENDENT
    answers = answers @ (directions[:, independent] / np.sqrt(sizes[independent]))
    stiffness = copies * answers.T @ symmetric_product(problem.stiffness, answers)
    squares, directions = eigh(stiffness)
    return squares, answers @ directions


def shapes_of_class(
    problem: ClassProblem,
    part: CondensedClass,
    stiffness: sparse.csr_array,
    inertia: Array,
    cutoff: float,
    corrections: bool,
) -> FixedInterfaceShapes:
    """Find the shapes of one class up to a frequency, their mass with end motions and pin loads' work.

    Parameters
    ----------
    problem : ClassProblem
        Of the class, its end sections held.
    part : CondensedClass
    stiffness : (3 n, 3 n) sparse array
        Of the meshed part, upper triangle.
    inertia : (3 n, c) array
        Inertia forces of the static fields.
    cutoff : float
        Natural modes up to this frequency are kept [Hz].
    corrections : bool
        Whether to add the static response of those left out, one shape for each motion of rigid ends.

    Raises
    ------
    InputError
        If there are more modes than the mesh can represent.
    SolveError
        If the modes cannot be found.
    """
    # The inertia of what sections do beside their mean motions is too small to count.
    forces = inertia[:, : part.symmetry.ends.shape[1] if corrections else 0]
    squares, natural, shapes = _fixed_interface_shapes(problem, cutoff, forces)
    copies = part.symmetry.copies
    pin_fields = part.pin_fields.reshape(len(shapes), -1)
    # The fields are answers to the pin loads, so the shapes' work on them is the loads' on the shapes.
    works = copies * shapes.T @ symmetric_product(stiffness, pin_fields)
    pin_loads = np.zeros((len(part.pin_loads), len(squares), 6))
    for work, (pin, component) in zip(works.T, part.pin_components, strict=True):
        pin_loads[pin, :, component] = work
    return FixedInterfaceShapes(
        symmetries=(part.symmetry,) * len(squares),
        squares=squares,
        natural=natural,
        shapes=shapes,
        coupling=copies * part.shares.T @ (inertia.T @ shapes),
        pin_loads=pin_loads,
    )


def shapes_of_throw(
    mesh: ThrowMesh, one: CondensedClass, parts: Sequence[FixedInterfaceShapes]
) -> FixedInterfaceShapes:
    """Combine the shapes of all classes: natural modes first, ascending."""
    none = FixedInterfaceShapes(
        symmetries=(),
        squares=np.zeros(0),
        natural=np.zeros(0, dtype=bool),
        shapes=np.zeros((mesh.unknowns, 0)),
        coupling=np.zeros((2 * one.sections.count, 0)),
        pin_loads=np.zeros((len(one.pin_loads), 0, 6)),
    )
    parts = [none, *parts]
    symmetries = [symmetry for part in parts for symmetry in part.symmetries]
    squares = np.concatenate([part.squares for part in parts])
    natural = np.concatenate([part.natural for part in parts])
    order = np.lexsort((squares, ~natural))
    return FixedInterfaceShapes(
        symmetries=tuple(symmetries[place] for place in order),
        squares=squares[order],
        natural=natural[order],
        shapes=np.hstack([part.shapes for part in parts])[:, order],
        coupling=np.hstack([part.coupling for part in parts])[:, order],
        pin_loads=np.concatenate([part.pin_loads for part in parts], axis=1)[:, order],
    )
