"""The throw as a dynamic superelement: motions of its end sections and internal shapes.

A throw's displacement is composed of the static fields for unit motions of its end sections (Guyan's
condensation) and of shapes with the end sections held, of which the lowest natural modes are the most
important (R. R. Craig, M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal
6, 1313-1319, 1968). The static fields do no work on the shapes, so stiffness falls into blocks; mass
couples them. Guyan's fields alone give the inertia of rigid motions exactly, that of others too small,
and so frequencies too high.

The modes left out still yield, like springs, to the inertia forces of moving end sections.
Their static response to these forces is one more shape for each motion (the residual modes of J.-G. Kim,
P.-S. Lee, An enhanced Craig-Bampton method, Int. J. Numer. Meth. Engng 103, 79-93, 2015, here with
amplitudes of their own). It takes the error from the second to the fourth power of the frequency
relative to the lowest mode left out.
"""

import math
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag, eigh

from crankbase.choices import is_number, whole_within
from crankbase.diagrams import GRAY, new_axes
from crankbase.errors import InputError, quoted
from crankbase.frames import table
from crankbase.summaries import summarized
from fem.assembly import symmetric_product
from fem.condensation import CondensedClass
from fem.material import Material
from fem.modes import ClassProblem, PartMatrices, check_resolved, class_problem, frequencies_of
from fem.plots import draw_frequencies
from fem.solver import SharedSolver
from fem.symmetry import (
    RIGID,
    SectionMotions,
    SymmetryClass,
    both_ends,
    section_turn,
    symmetry_classes,
)
from geometry.mesh import ThrowMesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
    mesh: ThrowMesh, symmetry_part: CondensedClass, parts: Sequence[FixedInterfaceShapes]
) -> FixedInterfaceShapes:
    """Combine the shapes of all classes: natural modes first, ascending."""
    none = FixedInterfaceShapes(
        symmetries=(),
        squares=np.zeros(0),
        natural=np.zeros(0, dtype=bool),
        shapes=np.zeros((mesh.unknowns, 0)),
        coupling=np.zeros((2 * symmetry_part.sections.count, 0)),
        pin_loads=np.zeros((len(symmetry_part.pin_loads), 0, 6)),
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


# Natural modes are kept up to this multiple of the highest frequency of interest. Frequencies of shafts
# of three to six throws, free or in bearings, are then within 0.05 % of their limit up to that
# frequency, whether it lies below the throw's first natural mode or at three times it (three throws;
# without corrections the same takes a multiple of 6 or more, and a multiple of 2 leaves 5 %).
CUTOFF_FACTOR = 1.5


@summarized("frequencies [Hz]", "stiffness", "highest_frequency [Hz]")
@dataclass(frozen=True)
class DynamicSuperelement:
    """A throw condensed to 2 n motions of its end sections and m amplitudes of internal shapes.

    Attributes
    ----------
    stiffness, mass : (2 n + m, 2 n + m) array
        Unknowns ux uy uz rx ry rz of the left, then of the right end section, in the throw frame (or
        that of the shaft, once turned); amplitudes of the bending of the left, then the right section
        [m], if sections bend; then the amplitudes of the shapes [sqrt(kg) m].
    pin_loads : (pins, 2 n + m, 6) array
        Loads on these unknowns equivalent to unit forces along x, y, z on each pin, and unit moments
        about them at its center.
    frequencies : (m,) array
        Of the shapes, with the end sections held [Hz]: natural modes ascending, then corrections.
    natural : int
        Number of natural modes among them.
    symmetries : tuple of m SymmetryClass
        The class of each shape.
    shapes : (n, 3, m) array
        Displacement of the meshed part's nodes in the throw frame, zero at the end sections; of unit
        modal mass of the whole throw, and orthogonal to each other [1/sqrt(kg)].
    highest_frequency : float
        Highest frequency of the superelement [Hz].
    cutoff_factor : float
        Natural modes were kept up to this multiple of it.
    sections : SectionMotions
        The n motions of an end section.
    """

    stiffness: Array
    mass: Array
    pin_loads: Array
    frequencies: Array
    natural: int
    symmetries: tuple[SymmetryClass, ...]
    shapes: Array = field(repr=False)
    highest_frequency: float
    cutoff_factor: float
    solver: str
    sections: SectionMotions = RIGID

    def turned(self, *, angle_deg: float) -> "DynamicSuperelement":
        """Return the superelement of the throw turned by an angle [deg] about the shaft, +z.

        The end motions are then in the shaft frame; pin loads stay in the frame of the throw.
        """
        return self._changed(section_turn(self.sections, math.radians(angle_deg)))

    def bending_turned(self, *, angle_deg: float) -> "DynamicSuperelement":
        """Return it with the sections' bending, and only that, in a turned frame."""
        turn = section_turn(self.sections, math.radians(angle_deg))
        return self._changed(block_diag(np.eye(12), turn[12:, 12:]))

    def shared_with(self, sections: SectionMotions) -> "DynamicSuperelement":
        """Return it in section motions over another ring; see `Superelement.shared_with`."""
        if sections == self.sections:
            return self
        shares = both_ends(self.sections.amplitudes_of(sections))
        return replace(self._changed(shares.T), sections=sections)

    def _changed(self, ends: Array) -> "DynamicSuperelement":
        """Return it with other motions of the end sections, matrix (2 n, 2 n)."""
        change = block_diag(ends, np.eye(len(self.frequencies)))
        return replace(
            self,
            stiffness=change @ self.stiffness @ change.T,
            mass=change @ self.mass @ change.T,
            pin_loads=change @ self.pin_loads,
        )

    def with_modes(self, count: int) -> "DynamicSuperelement":
        """Return Craig's and Bampton's superelement of the lowest natural modes; of none, Guyan's.

        Corrections are left out.

        Raises
        ------
        InputError
            If it has fewer natural modes.
        """
        whole_within("count", count, 0, self.natural, "the superelement has no more natural modes")
        kept = slice(0, 2 * self.sections.count + count)
        return replace(
            self,
            stiffness=self.stiffness[kept, kept],
            mass=self.mass[kept, kept],
            pin_loads=self.pin_loads[:, kept],
            frequencies=self.frequencies[:count],
            natural=count,
            symmetries=self.symmetries[:count],
            shapes=self.shapes[:, :, :count],
        )

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kind of each shape: "natural mode" or "correction"."""
        corrections = len(self.frequencies) - self.natural
        return ("natural mode",) * self.natural + ("correction",) * corrections

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the frequencies of the shapes, with the highest frequency of the superelement."""
        axes = new_axes(axes)
        draw_frequencies(
            axes, self.frequencies, self.kinds, "Shapes of the throw with its end sections held"
        )
        axes.axhline(self.highest_frequency, color=GRAY, linestyle="--", label="made for")
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the shapes, numbered from 1.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {
                "shape": (np.arange(1, len(self.frequencies) + 1), ""),
                "frequency": (self.frequencies, "Hz"),
                "kind": (list(self.kinds), ""),
            }
        )


def dynamic_superelement(
    mesh: ThrowMesh,
    material: Material,
    classes: Sequence[CondensedClass],
    highest_frequency: float,
    *,
    cutoff_factor: float = CUTOFF_FACTOR,
    corrections: bool = True,
    solver: str = "auto",
) -> DynamicSuperelement:
    """Build a throw's dynamic superelement from its static condensation.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    material : Material
        That of the condensation.
    classes : sequence of CondensedClass
        All symmetry classes of the part, condensed with rigid end sections or such that bend.
    highest_frequency : float
        Highest frequency of interest [Hz]; 0 for Guyan's superelement, which
        has no shapes.
    cutoff_factor : float
        All natural modes with the end sections held up to this multiple of it are kept, at least 1.
    corrections : bool
        Whether to add the static response of the modes left out, one shape for each end motion.
    solver : {"auto", "pardiso", "superlu"}
        Equation solver.

    Raises
    ------
    InputError
        If a number is out of range, the classes do not belong to the mesh, or their end sections are
        not rigid.
    SolveError
        If the modes cannot be found.
    """
    if not (is_number(highest_frequency) and highest_frequency >= 0.0):
        raise InputError(
            f"highest_frequency: given {quoted(highest_frequency)}; allowed is a finite frequency from 0 Hz, "
            "because modes are kept in proportion to it."
        )
    if not (is_number(cutoff_factor) and cutoff_factor >= 1.0):
        raise InputError(
            f"cutoff_factor: given {quoted(cutoff_factor)}; allowed is a finite number from 1, because modes "
            "below the highest frequency must not be missing."
        )
    _check_classes(mesh, classes)
    check_resolved(mesh, material, highest_frequency)
    matrices = PartMatrices.of_mesh(mesh, material)
    cutoff = cutoff_factor * highest_frequency
    sections = classes[0].sections
    stiffness, mass = np.zeros((2, 2 * sections.count, 2 * sections.count))
    shapes = []
    with closing(SharedSolver(solver, few_sides=False)) as shared:
        for part in classes:
            shares, copies = part.shares, part.symmetry.copies
            fields = part.fields.reshape(mesh.unknowns, -1)
            inertia = symmetric_product(matrices.mass, fields)
            stiffness += copies * shares.T @ part.stiffness @ shares
            mass += copies * shares.T @ (fields.T @ inertia) @ shares
            if cutoff > 0.0:
                with class_problem(
                    mesh, matrices, part.symmetry, held_ends=True, solver=shared
                ) as problem:
                    shapes.append(
                        shapes_of_class(
                            problem, part, matrices.stiffness, inertia, cutoff, corrections
                        )
                    )
    inside = shapes_of_throw(mesh, classes[0], shapes)
    end_pin_loads = sum(part.shares.T @ part.pin_loads for part in classes)
    count = len(inside.squares)
    mass = np.block([[mass, inside.coupling], [inside.coupling.T, np.eye(count)]])
    return DynamicSuperelement(
        stiffness=block_diag(0.5 * (stiffness + stiffness.T), np.diag(inside.squares)),
        mass=0.5 * (mass + mass.T),
        pin_loads=np.concatenate([end_pin_loads, inside.pin_loads], axis=1),
        frequencies=frequencies_of(inside.squares),
        natural=int(np.count_nonzero(inside.natural)),
        symmetries=inside.symmetries,
        shapes=inside.shapes.reshape(len(mesh.points), 3, count),
        highest_frequency=highest_frequency,
        cutoff_factor=cutoff_factor,
        solver=classes[0].solver,
        sections=sections,
    )


def _check_classes(mesh: ThrowMesh, classes: Sequence[CondensedClass]) -> None:
    """Refuse classes of another mesh, and end sections that are not rigid."""
    wanted = symmetry_classes(mesh.part)
    if {part.symmetry for part in classes} != set(wanted) or len(classes) != len(wanted):
        raise InputError(
            f"classes: given {len(classes)}; allowed are the {len(wanted)} of a {mesh.part} mesh, each "
            "once, because only all of them together make the throw."
        )
    for part in classes:
        if len(part.fields) != len(mesh.points):
            raise InputError(
                f"classes: given fields at {len(part.fields)} nodes; allowed are the "
                f"{len(mesh.points)} of the mesh, because they must be condensed from it."
            )
        if part.end_sections != "rigid":
            raise InputError(
                f"classes: given {part.end_sections!r} end sections; allowed are rigid ones, because "
                "natural modes with the ends held are computed for these only."
            )
