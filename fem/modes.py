"""Natural modes of an unsupported throw, and the throw as a dynamic superelement.

Every mode of a throw is symmetric or antisymmetric about each plane that cuts it, so each symmetry
class of the meshed part is an eigenvalue problem of its own. Its lowest modes are found by Lanczos'
method with shifted inversion (ARPACK's implicit restarts: R. B. Lehoucq, D. C. Sorensen, C. Yang,
ARPACK Users' Guide, SIAM 1998). The shift is below all eigenvalues, so that the matrix to factorize,
K + s M, is positive definite though a free throw can move as a rigid body.

The displacement of a dynamic superelement is composed of the static fields for unit motions of its end
sections (Guyan's condensation) and of shapes with the end sections held, of which the lowest natural
modes are the most important (R. R. Craig, M. C. C. Bampton, Coupling of substructures for dynamic
analyses, AIAA Journal 6, 1313-1319, 1968). The static fields do no work on the shapes, so stiffness falls
into blocks; mass couples them. Guyan's fields alone give the inertia of rigid motions exactly, that of
others too small, and so frequencies too high.

The modes left out still yield, like springs, to the inertia forces of moving end sections.
Their static response to these forces is one more shape for each motion (the residual modes of J.-G. Kim,
P.-S. Lee, An enhanced Craig-Bampton method, Int. J. Numer. Meth. Engng 103, 79-93, 2015, here with
amplitudes of their own). It takes the error from the second to the fourth power of the frequency
relative to the lowest mode left out.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from crankbase.array_checks import Array, Flags, Integers, nonnegative_number, positive_number
from crankbase.choices import is_number, whole_within
from crankbase.diagrams import GRAY, new_axes
from crankbase.errors import InputError, SolveError, quoted
from crankbase.frames import Axes, table
from crankbase.summaries import frozen
from fem.material import Material
from fem.plots import draw_frequencies
from fem.solver import (
    Factorization,
    SharedSolver,
    assemble_mass,
    assemble_stiffness,
    symmetric_product,
)
from fem.superelement import (
    RX,
    RY,
    RZ,
    UX,
    UY,
    UZ,
    CondensedClass,
    blocked_unknowns,
    uncoupled,
    unit_end_motions,
)
from fem.symmetry import (
    MIRROR_X,
    MIRROR_Z,
    RIGID,
    SectionMotions,
    SymmetryClass,
    both_ends,
    diagonal_blocks,
    section_turn,
    symmetry_classes,
)
from geometry.mesh import ThrowMesh
from geometry.shapes import element_volumes

# A mode is taken if K x and w^2 M x differ by no more than this share of their size. Lanczos leaves
# some 1e-11; a frequency's error goes with the square of its mode's.
LARGEST_RESIDUAL = 1e-6
# Lanczos stops at this residual of the inverted problem.
LANCZOS_TOLERANCE = 1e-10
# Squares of frequencies that differ by less than this share are not told apart.
SAME = 1e-8
MOST_MODES = 500
# So many modes of a class are sought at first where only a highest frequency is given.
FIRST_GUESS = 2
# Lanczos keeps twice as many vectors as there are modes and these; more save no solves.
SPARE_VECTORS = 6


@dataclass(frozen=True)
class PartMatrices:
    """Stiffness and mass of a meshed part, upper triangles (3 n, 3 n)."""

    stiffness: sparse.csr_array
    mass: sparse.csr_array

    @classmethod
    def of_mesh(cls, mesh: ThrowMesh, material: Material) -> "PartMatrices":
        """Assemble both."""
        return cls(
            assemble_stiffness(mesh.points, mesh.elements, material),
            assemble_mass(mesh.points, mesh.elements, material.density),
        )


@dataclass(frozen=True)
class ClassModes:
    """The lowest modes of a throw in one symmetry class, ascending.

    Attributes
    ----------
    squares : (k,) array
        Squares of the angular frequencies [rad^2/s^2]; a rigid motion's may be slightly negative.
    shapes : (n, 3, k) array
        Displacement of the meshed part's nodes, of unit modal mass of the whole throw [1/sqrt(kg)].
    residuals : (k,) array
        Difference of K x and w^2 M x relative to (w^2 + s) M x, s the shift.
    """

    symmetry: SymmetryClass
    squares: Array
    shapes: Array
    residuals: Array
    solver: str

    @property
    def frequencies(self) -> Array:
        """Frequencies (k,) [Hz]."""
        return frequencies_of(self.squares)

    def part(self, chosen: slice) -> "ClassModes":
        """Return some of the modes."""
        return ClassModes(
            self.symmetry,
            self.squares[chosen],
            self.shapes[:, :, chosen],
            self.residuals[chosen],
            self.solver,
        )


@dataclass(frozen=True)
class ClassProblem:
    """The eigenvalue problem K x = w^2 M x of one symmetry class of a meshed part, factorized.

    Attributes
    ----------
    nodes : int
        Number of nodes of the meshed part.
    free : (f,) array
        Unknowns of the meshed part that are free.
    stiffness, mass : (f, f) sparse arrays
        Upper triangles.
    shift : float
        s [rad^2/s^2].
    factors : Factorization
        Of K + s M.
    """

    symmetry: SymmetryClass
    nodes: int
    free: Integers
    stiffness: sparse.csr_array
    mass: sparse.csr_array
    shift: float
    factors: Factorization

    @property
    def most_modes(self) -> int:
        """Largest number of modes: the mesh can represent only a share of its unknowns."""
        return min(MOST_MODES + 6, len(self.free) // 4)

    def lowest(self, count: int) -> ClassModes:
        """Return the lowest modes, rigid motions included.

        Raises
        ------
        InputError
            If there are more than the mesh can represent.
        SolveError
            If a mode does not satisfy its equation.
        """
        if count > self.most_modes:
            raise InputError(
                f"count: given so that {count} modes of one symmetry class are needed; allowed are "
                f"{self.most_modes}, because this mesh is too coarse for more."
            )
        return self._checked(*self._completed(*self._lanczos(count)))

    def up_to(self, frequency: float) -> ClassModes:
        """Return all modes up to a frequency [Hz] and, to miss none, some above it.

        Raises
        ------
        InputError
            If there are more than the mesh can represent.
        SolveError
            If a mode does not satisfy its equation.
        """
        ceiling = (2.0 * np.pi * frequency) ** 2
        count = min(FIRST_GUESS, self.most_modes)
        while True:
            squares, vectors = self._lanczos(count)
            if squares[0] > ceiling:  # the lowest of all is not missed, nor anything below it
                return self._checked(squares, vectors)
            if squares[-1] > ceiling:
                squares, vectors = self._completed(squares, vectors)
            if squares[-1] > ceiling:
                return self._checked(squares, vectors)
            if count == self.most_modes:
                raise InputError(
                    f"highest_frequency: given so that modes are needed up to {frequency:.6g} Hz; "
                    f"allowed is up to {frequencies_of(squares[-1]):.6g} Hz, because this mesh is too "
                    "coarse for more."
                )
            # The number of modes grows with the frequency to a power between one and three.
            growth = min(4.0, ceiling / max(float(squares[-1]), 0.25 * ceiling))
            count = min(self.most_modes, int(growth * count) + 2)

    def displacement(self, vectors: Array) -> Array:
        """Displacement (n, 3, k) of all nodes from the free unknowns' (f, k)."""
        shapes = np.zeros((3 * self.nodes, vectors.shape[1]))
        shapes[self.free] = vectors
        return shapes.reshape(self.nodes, 3, -1)

    def _completed(self, squares: Array, vectors: Array) -> tuple[Array, Array]:
        """The lowest eigenvalues (k,) and vectors (f, k), with the number of those given, none missed.

        Of modes with the same frequency Lanczos' method finds only one, unless rounding brings the
        others in. So the modes found are removed, and the search is repeated below them.
        """
        while True:
            square, vector = self._lanczos(1, vectors)
            if square[0] >= squares[-1] - SAME * (squares[-1] + self.shift):
                return squares, vectors
            order = np.argsort(np.append(squares, square))[: len(squares)]
            squares = np.append(squares, square)[order]
            vectors = np.hstack([vectors, vector])[:, order]

    def _lanczos(self, count: int, known: Array | None = None) -> tuple[Array, Array]:
        """Lowest eigenvalues (k,), ascending, and vectors (f, k) of unit mass of the meshed part.

        Those of known vectors (f, m) are left out.
        """
        size = len(self.free)
        known = np.zeros((size, 0)) if known is None else known
        whole_mass = self._whole_mass
        known_inertia = whole_mass @ known

        def solve(side: Array) -> Array:
            answer = self.factors.solve(np.asarray(side).reshape(-1, 1))[:, 0]
            return np.asarray(answer - known @ (known_inertia.T @ answer))

        # The start has a share of every mode, more of the lower ones, and is the same in every run.
        start = np.random.default_rng(known.shape[1]).standard_normal(size)
        try:
            squares, vectors = eigsh(
                self.stiffness,
                count,
                M=whole_mass,
                sigma=-self.shift,
                OPinv=LinearOperator((size, size), matvec=solve, dtype=np.float64),
                v0=solve(whole_mass @ start),
                ncv=min(size, 2 * count + SPARE_VECTORS),
                tol=LANCZOS_TOLERANCE,
            )
        except ArpackError as error:
            raise SolveError(f"The modes could not be found: {error}") from error
        order = np.argsort(squares)
        return np.asarray(squares)[order], np.asarray(vectors)[:, order]

    @cached_property
    def _whole_mass(self) -> sparse.csr_array:
        return sparse.csr_array(self.mass + sparse.triu(self.mass, k=1).T)

    def _checked(self, squares: Array, vectors: Array) -> ClassModes:
        inertia = symmetric_product(self.mass, vectors)
        difference = symmetric_product(self.stiffness, vectors) - inertia * squares
        scale = (np.abs(squares) + self.shift) * np.linalg.norm(inertia, axis=0)
        residuals = np.linalg.norm(difference, axis=0) / scale
        if not np.all(residuals <= LARGEST_RESIDUAL):
            raise SolveError(
                f"A mode leaves a relative residual of {np.max(residuals):.1e} (allowed "
                f"{LARGEST_RESIDUAL:.0e}): {self.factors.solver} or the mesh is not accurate enough."
            )
        # A shape's sign is free; its largest displacement is made positive.
        largest = np.take_along_axis(vectors, np.abs(vectors).argmax(axis=0)[None], axis=0)
        shapes = self.displacement(vectors * np.sign(largest) / np.sqrt(self.symmetry.copies))
        return ClassModes(self.symmetry, squares, shapes, residuals, self.factors.solver)

    def corrections(self, natural: Array, forces: Array) -> tuple[Array, Array]:
        """Static responses (f, c) to forces, orthogonal to natural modes and each other, and their w^2."""
        if not forces.shape[1]:
            return np.zeros(0), forces
        copies = self.symmetry.copies
        answers = self.factors.solve(forces)
        masses = copies * np.sum(answers * symmetric_product(self.mass, answers), axis=0)
        answers = answers / np.sqrt(masses)
        for _ in range(2):  # once leaves rounding of the size of the natural modes' large shares
            answers -= natural @ (copies * natural.T @ symmetric_product(self.mass, answers))
        mass = copies * answers.T @ symmetric_product(self.mass, answers)
        sizes, directions = eigh(mass)
        independent = sizes > INDEPENDENT
        answers = answers @ (directions[:, independent] / np.sqrt(sizes[independent]))
        stiffness = copies * answers.T @ symmetric_product(self.stiffness, answers)
        squares, directions = eigh(stiffness)
        return squares, answers @ directions


@contextmanager
def class_problem(
    mesh: ThrowMesh,
    matrices: PartMatrices,
    symmetry: SymmetryClass,
    *,
    shift: float = 0.0,
    held_ends: bool = False,
    solver: str | SharedSolver = "auto",
) -> Iterator[ClassProblem]:
    """Set up and factorize the eigenvalue problem of one symmetry class.

    Parameters
    ----------
    shift : float
        s of K + s M [rad^2/s^2]; positive unless the ends are held.
    held_ends : bool
        Whether the end sections are held.
    solver : str or SharedSolver
        See `fem.solver.SharedSolver`; the classes of one mesh share a pattern.

    Yields
    ------
    ClassProblem

    Raises
    ------
    SolveError
        If the matrix cannot be factorized.
    """
    blocked = blocked_unknowns(mesh, symmetry, ends=held_ends)
    free = np.flatnonzero(~blocked.ravel())
    stiffness = matrices.stiffness[free][:, free].tocsr()
    mass = matrices.mass[free][:, free].tocsr()
    shifted = (stiffness + shift * mass).tocsr() if shift else stiffness
    # Nodes that the cuts block along some axes stay whole, so that the classes share a pattern.
    whole = np.flatnonzero(np.repeat(~blocked.all(axis=1), 3))
    of_nodes = matrices.stiffness[whole][:, whole].tocsr()
    if shift:
        of_nodes = (of_nodes + shift * matrices.mass[whole][:, whole]).tocsr()
    shared = solver if isinstance(solver, SharedSolver) else SharedSolver(solver, few_sides=False)
    factors = shared.factorize(uncoupled(of_nodes, blocked.ravel()[whole]))
    inside = np.searchsorted(whole, free)

    def apply(sides: Array) -> Array:
        motions = np.zeros((len(whole), sides.shape[1]))
        motions[inside] = sides
        return factors.apply(motions)[inside]

    try:
        yield ClassProblem(
            symmetry,
            len(mesh.points),
            free,
            stiffness,
            mass,
            shift,
            replace(factors, upper=shifted, apply=apply),
        )
    finally:
        if shared is not solver:
            shared.close()


def frequencies_of(squares: Array) -> Array:
    """Frequencies [Hz] from squares of angular frequencies [rad^2/s^2]; below zero is rounding."""
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi))


def check_resolved(mesh: ThrowMesh, material: Material, frequency: float) -> None:
    """Refuse a frequency whose shear waves are shorter than two elements of mean size."""
    volume = float(element_volumes(mesh.points, mesh.elements).sum())
    size = (6.0 * np.sqrt(2.0) * volume / len(mesh.elements)) ** (1.0 / 3.0)
    highest = float(np.sqrt(material.shear_modulus / material.density) / (2.0 * size))
    if frequency > highest:
        raise InputError(
            f"highest_frequency: given {frequency:.4g} Hz; allowed is up to {highest:.4g} Hz on this mesh, "
            "because shorter waves have fewer than two elements."
        )


# Kinds of motion of an end section, and how a mode is named after them (see `name_of_motion`).
KINDS = {"bending": [UX, UY, RX, RY], "axial": [UZ], "torsion": [RZ]}
EVIDENT = 0.9
PURE = 0.999


def end_motions_of(mesh: ThrowMesh, symmetry: SymmetryClass, shape: Array) -> Array:
    """Motions (12,) of both end sections that best fit a displacement (n, 3) of the meshed part."""
    nodes, motions = zip(*unit_end_motions(mesh, symmetry), strict=True)
    columns = np.concatenate(motions).reshape(-1, symmetry.ends.shape[1])
    fit = np.linalg.lstsq(columns, shape[np.concatenate(nodes)].ravel(), rcond=None)
    return np.asarray(symmetry.ends @ fit[0])


def name_of_motion(motions: Array, length: float) -> str:
    """Describe a mode from the motions of the end sections.

    Rotations count as displacements at a distance of half the throw's length, shares are of the sum of
    squares. Two kinds of motion are named unless one has 90 %; a plane, and a symmetry about the
    throw's middle, only where the motion has nothing else.

    Parameters
    ----------
    motions : (12,) array
        Of the left, then the right end section [m, rad].
    length : float
        Of the throw [m].
    """
    scaled = motions * np.tile([1.0, 1.0, 1.0, *[0.5 * length] * 3], 2)
    total = float(scaled @ scaled)
    if total == 0.0:
        return "end sections at rest"
    squares = (scaled**2).reshape(2, 6).sum(axis=0) / total
    shares = {kind: float(squares[places].sum()) for kind, places in KINDS.items()}
    first, second = sorted(shares, key=lambda kind: shares[kind], reverse=True)[:2]
    name = first if shares[first] >= EVIDENT else f"{first} with {second}"
    for mirrored, symmetric, antisymmetric in (
        (np.tile(MIRROR_X, 2) * scaled, " in the crank plane", " across the crank plane"),
        (np.roll(np.tile(MIRROR_Z, 2) * scaled, 6), ", symmetric", ", antisymmetric"),
    ):
        parity = float(mirrored @ scaled) / total
        if abs(parity) >= PURE:
            name += symmetric if parity > 0.0 else antisymmetric
    return name


# The shift's angular frequency is this share of wave speed / length, the order of a throw's first
# elastic mode; far from it Lanczos takes more steps, with the same result.
SHIFT_SHARE = 0.3
# A motion is one without stiffness if its w^2 is below this share of the shift: rounding leaves 1e-13,
# a bar a hundred times as long as thick bends with 3e-2.
NO_STIFFNESS = 1e-6


@frozen("frequencies [Hz]", "symmetries", "solver")
class ThrowModes:
    """Elastic modes of an unsupported throw, by ascending frequency.

    Attributes
    ----------
    frequencies : (k,) array
        [Hz]
    symmetries : tuple of k SymmetryClass
        The class of each mode.
    names : tuple of k str
        Description of each mode from its end sections.
    shapes : (n, 3, k) array
        Displacement of the meshed part's nodes, of unit modal mass of the whole throw [1/sqrt(kg)].
    residuals : (k,) array
        Difference of K x and w^2 M x, relative to their size.
    rigid_frequencies : (6,) array
        Frequencies of the rigid motions, nonzero by rounding only [Hz].
    """

    frequencies: Array
    symmetries: tuple[SymmetryClass, ...]
    names: tuple[str, ...]
    shapes: Array = field(repr=False)
    residuals: Array = field(repr=False)
    rigid_frequencies: Array = field(repr=False)
    solver: str

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the frequencies by their number, colored by the kind of motion."""
        axes = new_axes(axes, width=9.0)
        kinds = [name.partition(",")[0] for name in self.names]
        draw_frequencies(axes, self.frequencies, kinds, "Free modes of the throw")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the modes, numbered from 1.

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
                "mode": (np.arange(1, len(self.frequencies) + 1), ""),
                "frequency": (self.frequencies, "Hz"),
                "name": (list(self.names), ""),
                "residual": (self.residuals, "1"),
            }
        )


def free_modes(
    mesh: ThrowMesh,
    material: Material,
    *,
    count: int | None = None,
    highest_frequency: float | None = None,
    solver: str = "auto",
) -> ThrowModes:
    """Elastic modes of the whole throw, free in space, its end sections free to warp.

    Parameters
    ----------
    mesh : ThrowMesh
        Of the throw or the part of it required by its symmetry; either gives all modes.
    count : int, optional
        Number of modes, 1 to 500, or
    highest_frequency : float, optional
        highest frequency [Hz]; one of the two.
    solver : {"auto", "pardiso", "superlu"}
        Equation solver.

    Returns
    -------
    ThrowModes
        Sorted by frequency over all symmetry classes.

    Raises
    ------
    InputError
        If not one of `count` and `highest_frequency` is given, or it is out of range.
    SolveError
        If a mode does not satisfy its equation, or there are not six rigid motions.
    """
    _check_mode_count(count, highest_frequency)
    if highest_frequency is not None:
        check_resolved(mesh, material, highest_frequency)
    matrices = PartMatrices.of_mesh(mesh, material)
    shift = (SHIFT_SHARE / mesh.length) ** 2 * material.youngs_modulus / material.density

    def solve(symmetry: SymmetryClass, elastic: int | None) -> ClassModes:
        with class_problem(mesh, matrices, symmetry, shift=shift, solver=solver) as problem:
            if highest_frequency is not None:
                return problem.up_to(highest_frequency)
            return problem.lowest(rigid_count(symmetry) + (elastic or 0))

    symmetries = symmetry_classes(mesh.part)
    if count is None:
        classes = [solve(symmetry, None) for symmetry in symmetries]
    else:
        classes = _lowest_modes(solve, symmetries, count)
    rigid = _checked_rigid_squares(classes, shift)

    elastic = [modes.part(slice(rigid_count(modes.symmetry), None)) for modes in classes]
    frequencies = np.concatenate([modes.frequencies for modes in elastic])
    order = np.argsort(frequencies, kind="stable")[:count]
    if highest_frequency is not None:
        order = order[frequencies[order] <= highest_frequency]
    owners = [modes.symmetry for modes in elastic for _ in modes.squares]
    chosen = tuple(owners[place] for place in order)
    shapes = np.concatenate([modes.shapes for modes in elastic], axis=2)[:, :, order]
    return ThrowModes(
        frequencies=frequencies[order],
        symmetries=chosen,
        names=tuple(
            name_of_motion(end_motions_of(mesh, symmetry, shapes[:, :, mode]), mesh.length)
            for mode, symmetry in enumerate(chosen)
        ),
        shapes=shapes,
        residuals=np.concatenate([modes.residuals for modes in elastic])[order],
        rigid_frequencies=frequencies_of(np.abs(rigid)),
        solver=classes[0].solver,
    )


def rigid_count(symmetry: SymmetryClass) -> int:
    """How many of the six rigid motions of a throw, about its middle, are of this class."""
    return int(np.count_nonzero(symmetry.central_motions))


def _check_mode_count(count: int | None, highest_frequency: float | None) -> None:
    if (count is None) == (highest_frequency is None):
        raise InputError(
            f"count, highest_frequency: given {quoted(count)} and {quoted(highest_frequency)}; allowed is "
            "one of them, because each alone says how many modes there are."
        )
    if count is not None:
        reason = "higher modes have waves shorter than a throw's details"
        whole_within("count", count, 1, MOST_MODES, reason)
    if highest_frequency is not None:
        reason = "a free throw has modes of any height"
        positive_number("highest_frequency", highest_frequency, "Hz", reason)


def _lowest_modes(
    solve: Callable[[SymmetryClass, int], ClassModes],
    symmetries: Sequence[SymmetryClass],
    count: int,
) -> list[ClassModes]:
    """Modes of all classes, so many of each that the `count` lowest elastic ones are among them.

    Each class is first solved for its even share and two more, and again for twice as many if the
    last of them is still below the highest one required.
    """
    wanted = dict.fromkeys(symmetries, min(count, -(-count // len(symmetries)) + 2))
    solved = {symmetry: solve(symmetry, number) for symmetry, number in wanted.items()}
    while True:
        elastic = np.concatenate([solved[each].squares[rigid_count(each) :] for each in symmetries])
        highest = np.sort(elastic)[count - 1]
        short = [
            each
            for each in symmetries
            if solved[each].squares[-1] < highest and wanted[each] < count
        ]
        if not short:
            return list(solved.values())
        for each in short:
            wanted[each] = min(count, 2 * wanted[each])
            solved[each] = solve(each, wanted[each])


def _checked_rigid_squares(classes: Sequence[ClassModes], shift: float) -> Array:
    """w^2 (6,) of the rigid motions, after a check of their number in each class."""
    stiffless = [np.abs(modes.squares) < NO_STIFFNESS * shift for modes in classes]
    expected = [rigid_count(modes.symmetry) for modes in classes]
    if [int(np.count_nonzero(which)) for which in stiffless] != expected:
        raise SolveError(
            f"The free throw has {sum(int(np.count_nonzero(which)) for which in stiffless)} motions "
            "without stiffness instead of six: its mesh is not in one piece, or not whole."
        )
    return np.concatenate(
        [modes.squares[:number] for modes, number in zip(classes, expected, strict=True)]
    )


# Corrections of which the other shapes compose all but this share (of the square) are left out.
INDEPENDENT = 1e-9


@dataclass(frozen=True)
class FixedInterfaceShapes:
    """Shapes (3 n, m) with the end sections held, and their coupling to ends and pins."""

    symmetries: tuple[SymmetryClass, ...]
    squares: Array
    natural: Flags
    shapes: Array
    coupling: Array
    pin_loads: Array


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
    modes = problem.up_to(cutoff)
    kept = modes.part(slice(0, int(np.count_nonzero(modes.frequencies <= cutoff))))
    natural = kept.shapes.reshape(3 * problem.nodes, -1)[problem.free]
    correction_squares, answers = problem.corrections(natural, forces[problem.free])
    squares = np.concatenate([kept.squares, correction_squares])
    shapes = problem.displacement(np.hstack([natural, answers])).reshape(3 * problem.nodes, -1)
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
        natural=np.arange(len(squares)) < len(kept.squares),
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


@frozen("frequencies [Hz]", "stiffness", "highest_frequency [Hz]")
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
        return self._changed(diagonal_blocks(np.eye(12), turn[12:, 12:]))

    def shared_with(self, sections: SectionMotions) -> "DynamicSuperelement":
        """Return it in section motions over another ring; see `Superelement.shared_with`."""
        if sections == self.sections:
            return self
        shares = both_ends(self.sections.amplitudes_of(sections))
        return replace(self._changed(shares.T), sections=sections)

    def _changed(self, ends: Array) -> "DynamicSuperelement":
        """Return it with other motions of the end sections, matrix (2 n, 2 n)."""
        change = diagonal_blocks(ends, np.eye(len(self.frequencies)))
        return replace(
            self,
            stiffness=change @ self.stiffness @ change.T,
            mass=change @ self.mass @ change.T,
            pin_loads=change @ self.pin_loads,
        )

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kind of each shape: "natural mode" or "correction"."""
        corrections = len(self.frequencies) - self.natural
        return ("natural mode",) * self.natural + ("correction",) * corrections

    def plot(self, axes: Axes | None = None) -> Axes:
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
    reason = "modes are kept in proportion to it"
    nonnegative_number("highest_frequency", highest_frequency, "Hz", reason)
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
        stiffness=diagonal_blocks(0.5 * (stiffness + stiffness.T), np.diag(inside.squares)),
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
