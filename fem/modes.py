"""Natural modes of an unsupported throw, over all of its symmetry classes.

Every mode of a throw is symmetric or antisymmetric about each plane that cuts it, so each symmetry
class of the meshed part is an eigenvalue problem of its own. Its lowest modes are found by Lanczos'
method with shifted inversion (ARPACK's implicit restarts: R. B. Lehoucq, D. C. Sorensen, C. Yang,
ARPACK Users' Guide, SIAM 1998). The shift is below all eigenvalues, so that the matrix to factorize,
K + s M, is positive definite though a free throw can move as a rigid body.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from crankbase.choices import is_number, whole_within
from crankbase.diagrams import new_axes
from crankbase.errors import InputError, SolveError, quoted
from crankbase.frames import table
from crankbase.summaries import summarized
from fem.assembly import assemble_mass, assemble_stiffness, symmetric_product
from fem.condensation import blocked_unknowns, uncoupled, unit_end_motions
from fem.material import Material
from fem.plots import draw_frequencies
from fem.solver import Factorization, SharedSolver
from fem.superelement import RX, RY, RZ, UX, UY, UZ
from fem.symmetry import MIRROR_X, MIRROR_Z, SymmetryClass, symmetry_classes
from geometry.mesh import ThrowMesh
from geometry.shapes import element_volumes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Array = NDArray[np.float64]

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
    free: NDArray[np.int64]
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


@summarized("frequencies [Hz]", "symmetries", "solver")
@dataclass(frozen=True)
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

    def plot(self, axes: "Axes | None" = None) -> "Axes":
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
    if highest_frequency is not None and not (
        is_number(highest_frequency) and highest_frequency > 0.0
    ):
        raise InputError(
            f"highest_frequency: given {quoted(highest_frequency)}; allowed is a finite frequency above 0 "
            "Hz, because a free throw has modes of any height."
        )


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
