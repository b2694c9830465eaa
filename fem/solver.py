"""Solve symmetric positive definite systems; the only module that selects the library.

Every run checks its solution: reciprocity, rigid motions, definiteness, balance. Rotations are measured
as length x angle, so that all figures are shares. Figures of round-off are below 1e-11 for throws of all
kinds (tests/campaigns/random_throws.py draws such); an error of 1e-6 in a solution appears as about the
same figure.
"""

import copy
import os
import sys
import time
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from crankbase.errors import InputError, SolveError
from fem.assembly import AXES, BlockMatrix, node_blocks, symmetric_product
from fem.loads import rigid_motions


class Stopwatch:
    """Adds up the seconds of named pieces of work.

    Attributes
    ----------
    seconds : dict
        By name, in the order of first use.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def lap(self, name: str) -> Iterator[None]:
        """Measure the time of the block under this name, minus the named times inside it."""
        inside = sum(self.seconds.values())
        self.seconds.setdefault(name, 0.0)
        start = time.perf_counter()
        try:
            yield
        finally:
            named = sum(self.seconds.values()) - inside
            # Times taken elsewhere may be longer than the block, which then took none itself.
            self.seconds[name] += max(0.0, time.perf_counter() - start - named)

    def add(self, seconds: Mapping[str, float]) -> None:
        """Add times measured elsewhere, such as in another process."""
        for name, value in seconds.items():
            self.seconds[name] = self.seconds.get(name, 0.0) + value


Array = NDArray[np.float64]

# Residuals are measured as `residual_shares` does. This is what factors in double precision leave.
ROUND_OFF = 1e-13
# A step that gains less than one digit is the last; what is left then may be no more than this.
LAST = 1e-11
MOST_STEPS = 8


def residual_shares(
    upper: sparse.csr_array, size: float, solution: Array, sides: Array
) -> tuple[Array, Array]:
    """Return b - A x (n, k), and its size relative to b, or to the possible round-off of A x.

    Parameters
    ----------
    upper : (n, n) sparse array
        Upper triangle of A.
    size : float
        Largest sum of magnitudes in a row of it.
    solution, sides : (n, k) arrays
        x and b.
    """
    residual = sides - symmetric_product(upper, solution)
    of_product = size * np.linalg.norm(solution, axis=0)
    scale = np.maximum(np.linalg.norm(sides, axis=0), 1e-3 * of_product)
    return residual, np.linalg.norm(residual, axis=0) / np.maximum(scale, np.finfo(float).tiny)


def refined_solution(
    upper: sparse.csr_array, size: float, sides: Array, rough: Callable[[Array], Array]
) -> Array | None:
    """Solve A x = b with an approximate solver, repeatedly for the residual.

    Parameters
    ----------
    upper, size, sides
        As for `residual_shares`.
    rough : callable
        Gives approximately x for b; called with right sides of size one.

    Returns
    -------
    (n, k) array or None
        None if the steps do not converge to round-off.
    """
    solution, residual, last = np.zeros(sides.shape), sides, np.inf
    for _ in range(MOST_STEPS):
        largest = np.abs(residual).max(axis=0, initial=0.0)
        largest = np.where(largest > 0.0, largest, 1.0)
        solution = solution + largest * rough(residual / largest)
        residual, shares = residual_shares(upper, size, solution, sides)
        worst = float(shares.max(initial=0.0))
        if worst <= ROUND_OFF:
            return solution
        if not worst <= 0.1 * last:
            return solution if worst <= LAST else None
        last = worst
    return None


# A backward stable solve leaves a residual near round-off; anything above this is a wrong solve.
LARGEST_RESIDUAL = 1e-9
# Supported structures keep their pivots within eight decades of each other; a rigid-body motion left
# free leaves one at round-off.
SMALLEST_PIVOT = 1e-13
SOLVERS = ("pardiso", "superlu")
# Smaller systems are solved by one thread: a second one takes more processor time (a tenth in
# factorizing, four fifths in solving) than it saves.
FOR_ONE_THREAD = 100_000
# Of so many unknowns on single precision saves more than refining takes.
SINGLE_FROM = 30_000
# Phases of Pardiso.
ANALYSIS, FACTORIZATION, SOLUTION = 11, 22, 33
# Where pip and conda put MKL. Left alone, pypardiso reads all folders of an environment, twice.
MKL_FILES, MKL_VARIABLE = ("lib/libmkl_rt.*", "Library/bin/mkl_rt*.dll"), "PYPARDISO_MKL_RT"


@dataclass(frozen=True)
class Factorization:
    """A factorized matrix, ready to solve with any number of right sides.

    Attributes
    ----------
    upper : (n, n) sparse array
        Upper triangle of the matrix.
    solver : str
        The solver used.
    size : float
        Largest sum of magnitudes in a row of `upper`, which residuals are compared with.
    apply : callable
        Solves without any check.
    """

    upper: sparse.csr_array
    solver: str
    size: float
    apply: Callable[[Array], Array]

    def solve(self, right_sides: Array) -> Array:
        """Solve A x = b and check the residual.

        Parameters
        ----------
        right_sides : (n, k) array

        Returns
        -------
        (n, k) array

        Raises
        ------
        SolveError
            If the residual is not near round-off.
        """
        solution = self.apply(right_sides)
        _, shares = residual_shares(self.upper, self.size, solution, right_sides)
        if not np.all(shares <= LARGEST_RESIDUAL):
            raise SolveError(
                f"{self.solver} left a relative residual of {np.max(shares):.1e} (allowed "
                f"{LARGEST_RESIDUAL:.0e}): the structure may be insufficiently supported."
            )
        return solution


class SharedSolver:
    """Factorizes matrices one after the other; matrices of one pattern are analyzed once.

    Half of the work of a factorization is to find the order of elimination, which depends on the
    pattern alone. Each factorization ends the one before.

    Parameters
    ----------
    solver : {"auto", "pardiso", "superlu"}
        MKL's Pardiso, or scipy's SuperLU, which needs no MKL and is several times slower. "auto" is
        Pardiso if it can be loaded.
    watch : Stopwatch, optional
        Measures the time.
    few_sides : bool
        Whether each matrix has only a few right sides. Pardiso then factorizes large ones in single
        precision, in little more than half the time, and solutions are refined until their residual is
        that of double precision; if this fails, double precision is used.

    Raises
    ------
    SolveError
        If the solver is missing.
    InputError
        If the solver is unknown.
    """

    def __init__(
        self, solver: str = "auto", watch: Stopwatch | None = None, *, few_sides: bool = True
    ) -> None:
        self._watch = Stopwatch() if watch is None else watch
        self.solver = _choose(solver, self._watch)
        self._pattern: _PardisoPattern | None = None
        self._few_sides = few_sides

    def factorize(self, upper: sparse.csr_array) -> Factorization:
        """Factorize a symmetric positive definite matrix.

        Parameters
        ----------
        upper : (n, n) sparse array
            Upper triangle of the matrix, explicit zeros included if they belong to the pattern.

        Raises
        ------
        SolveError
            If the matrix is singular.
        """
        with self._watch.lap("factorization"):
            size = float(abs(upper).sum(axis=1).max())
            if self.solver == "superlu":
                apply = _superlu(upper)
            elif self._few_sides and len(upper.indptr) > SINGLE_FROM:
                apply = self._in_single(upper, size)
            else:
                apply = self._with_pardiso(upper, single=False)
        return Factorization(upper, self.solver, size, apply)

    def _with_pardiso(self, upper: sparse.csr_array, *, single: bool) -> Callable[[Array], Array]:
        if self._pattern is None or not self._pattern.fits(upper, single):
            self.close()
            self._pattern = _PardisoPattern(upper, single)
        return self._pattern.factorize(upper)

    def _in_single(self, upper: sparse.csr_array, size: float) -> Callable[[Array], Array]:
        """Factorize in single precision; return the function that solves and refines, if needed in double."""
        try:
            rough = self._with_pardiso(upper, single=True)
        except SolveError:  # not positive definite but for round-off, perhaps
            self._few_sides = False
            return self._with_pardiso(upper, single=False)
        exact: Callable[[Array], Array] | None = None

        def apply(sides: Array) -> Array:
            nonlocal exact
            if exact is None:
                solution = refined_solution(upper, size, sides, rough)
                if solution is not None:
                    return solution
                self._few_sides = False  # nor will it do for the next matrices
                exact = self._with_pardiso(upper, single=False)
            return exact(sides)

        return apply

    def close(self) -> None:
        """Free the memory of the factors."""
        if self._pattern is not None:
            self._pattern.free()
            self._pattern = None


@contextmanager
def factorize(upper: sparse.csr_array, solver: str = "auto") -> Iterator[Factorization]:
    """Factorize a symmetric positive definite matrix; its memory is freed at the end of the block.

    Parameters
    ----------
    upper : (n, n) sparse array
        Upper triangle of the matrix.
    solver
        As for `SharedSolver`, which also says what is raised.

    Yields
    ------
    Factorization

    Raises
    ------
    SolveError
        If the matrix is singular.
    """
    shared = SharedSolver(solver, few_sides=False)
    try:
        yield shared.factorize(upper)
    finally:
        shared.close()


def _choose(solver: str, watch: Stopwatch) -> str:
    if solver not in ("auto", *SOLVERS):
        raise InputError(f"solver: given {solver!r}; allowed are auto, {', '.join(SOLVERS)}.")
    if solver == "superlu":
        return solver
    with watch.lap("loading the solver"):
        installed = _pardiso() is not None
    if not installed and solver == "pardiso":
        raise SolveError(
            "The solver pardiso is not installed; install it with: pip install pypardiso"
        )
    return "pardiso" if installed else "superlu"


@cache
def _pardiso() -> Any:
    """Load Pardiso once; None if it is not available."""
    for file in (path for pattern in MKL_FILES for path in Path(sys.prefix).glob(pattern)):
        os.environ.setdefault(MKL_VARIABLE, str(file))
    try:
        from pypardiso import PyPardisoSolver

        return PyPardisoSolver(mtype=2)
    except (ImportError, OSError):
        return None


class _PardisoPattern:
    """Pardiso's analysis of a pattern, and the factors of the last matrix that had it.

    In single precision, if wanted: right sides are then to be of size one.
    """

    def __init__(self, upper: sparse.csr_array, single: bool) -> None:
        self._solver = copy.copy(_pardiso())
        self._solver.pt = np.zeros_like(self._solver.pt)
        self._solver.iparm = np.zeros_like(self._solver.iparm)
        # With its own defaults it solves two to three times more slowly. Order 2 is nested dissection.
        self._solver.set_iparm(1, 1)
        self._solver.set_iparm(2, 2)
        self._single, self._kind = single, np.float32 if single else np.float64
        self._solver.set_iparm(28, int(single))
        self._count = 0
        self._indptr, self._indices = upper.indptr.copy(), upper.indices.copy()
        self._blocks = node_blocks(upper)
        if self._blocks is not None:
            self._solver.set_iparm(37, AXES)
        # Also when nobody closes it.
        self._finalizer = weakref.finalize(self, _free_pardiso, self._solver)
        self._run(ANALYSIS, self._stored(upper)[0], np.zeros((upper.shape[0], 1)))

    def fits(self, upper: sparse.csr_array, single: bool) -> bool:
        """Whether a matrix has this pattern, and the required precision."""
        return (
            single == self._single
            and np.array_equal(self._indptr, upper.indptr)
            and np.array_equal(self._indices, upper.indices)
        )

    def factorize(self, upper: sparse.csr_array) -> Callable[[Array], Array]:
        """Factorize a matrix of this pattern; give what solves with it."""
        matrix, size = self._stored(upper)
        self._run(FACTORIZATION, matrix, np.zeros((upper.shape[0], 1)))
        self._count += 1
        count = self._count

        def apply(sides: Array) -> Array:
            if count != self._count:
                raise SolveError("these factors were replaced by those of a later matrix.")
            return self._run(SOLUTION, matrix, sides) / size

        return apply

    def free(self) -> None:
        self._finalizer()

    def _stored(self, upper: sparse.csr_array) -> "tuple[sparse.csr_array | BlockMatrix, float]":
        """Return the matrix for Pardiso, divided by a number, and this number."""
        size = 1.0
        if self._single:
            # Single precision has a narrow range: the largest entry is made one.
            size = float(np.abs(upper.data).max(initial=0.0)) or 1.0
            entries = (upper.data / size).astype(self._kind)
            upper = sparse.csr_array((entries, upper.indices, upper.indptr), upper.shape)
        return upper if self._blocks is None else self._blocks.of(upper), size

    def _run(self, phase: int, matrix: "sparse.csr_array | BlockMatrix", sides: Array) -> Array:
        if not self._finalizer.alive:
            raise SolveError("the factors were freed before the last solve.")
        self._solver.set_phase(phase)
        small = len(sides) < FOR_ONE_THREAD
        try:
            with _one_thread(self._solver.libmkl) if small else nullcontext():
                sides = np.asfortranarray(sides, dtype=self._kind)
                return np.asarray(self._solver._call_pardiso(matrix, sides), dtype=np.float64)
        except Exception as error:  # pypardiso's own kinds; not positive definite is number -4
            raise SolveError(f"Pardiso could not solve the system: {error}") from error


@contextmanager
def _one_thread(mkl: Any) -> Iterator[None]:
    """Let MKL calculate with one thread where this thread calls it."""
    before = mkl.MKL_Set_Num_Threads_Local(1)
    try:
        yield
    finally:
        mkl.MKL_Set_Num_Threads_Local(before)


def _free_pardiso(solver: Any) -> None:
    solver.free_memory(everything=True)


def _superlu(upper: sparse.csr_array) -> Callable[[Array], Array]:
    """Factorize with SuperLU; give what solves with the factors."""
    full = upper + sparse.triu(upper, k=1).T
    try:
        factors = splu(
            sparse.csc_matrix(full),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise SolveError(f"SuperLU could not solve the system: {error}") from error
    pivots = np.abs(factors.U.diagonal())
    if pivots.min() <= SMALLEST_PIVOT * pivots.max():
        raise SolveError(
            "SuperLU met a vanishing pivot: the structure is insufficiently supported."
        )
    return lambda sides: np.asarray(factors.solve(sides))


# Every solution leaves at most 1e-9 of its right side; what is checked is made of a few solutions.
LARGEST_ROUND_OFF = 1e-8
# Energies against forces at the ends: throws of engines leave 1e-11, journals of 0.04 crank radii 1e-8.
LARGEST_DIFFERENCE = 1e-6
# The softest elastic motion of a throw has 1e-2 of the energy of the stiffest, of sections that bend 1e-4.
SMALLEST_ENERGY = 1e-7
RIGID_MOTIONS = 6


def rigid_body_motions(count: int = 12) -> Array:
    """Return the rigid-body motions (count, 6) of two end sections, rotations as length x angle.

    `count` is 12, or 12 + 2 b where sections bend; then these do not.
    """
    motions = np.zeros((count, RIGID_MOTIONS))
    motions[:6], motions[6:12] = np.eye(6), np.eye(6)
    # Turned about x or y through the left end section, the right one is carried along.
    motions[6, 4], motions[7, 3] = 1.0, -1.0
    return motions


def scaled_stiffness(stiffness: ArrayLike, length: float) -> Array:
    """Return a stiffness (n, n) in N/m alone, with rotations measured as length x angle."""
    matrix = np.asarray(stiffness, dtype=float)
    size = _sizes(len(matrix), length)
    return matrix * np.outer(size, size)


def rigid_body_residual(stiffness: ArrayLike, length: float) -> float:
    """Return the largest force caused by a rigid-body motion, relative to the largest stiffness.

    Parameters
    ----------
    stiffness : (12, 12) array
        ux uy uz rx ry rz of the left, then the right end section [SI]; more rows if sections bend.
    length : float
        Between the end sections [m].
    """
    scaled = scaled_stiffness(stiffness, length)
    return float(np.max(np.abs(scaled @ rigid_body_motions(len(scaled)))) / np.max(np.abs(scaled)))


def asymmetry(stiffness: ArrayLike, length: float) -> float:
    """Return the largest difference between K and its transpose, relative to the largest stiffness."""
    scaled = scaled_stiffness(stiffness, length)
    return float(np.max(np.abs(scaled - scaled.T)) / np.max(np.abs(scaled)))


def check_reciprocity(
    ends: Array, stiffness: tuple[Array, Array], pin_loads: tuple[Array, Array], length: float
) -> None:
    """Refuse a solved symmetry class with different results for stiffness and pin loads in two ways.

    Energies of fields and forces on the end sections come from different solutions, equal by reciprocity
    as far as these are in equilibrium.

    Parameters
    ----------
    ends : (2 n, k) array
        Motions of both end sections for unit amplitudes.
    stiffness : two (k, k) arrays
        By energies, and by the forces on the end sections.
    pin_loads : two (pins, k, 6) arrays
        By work on the pins, and by reactions at the end sections.
    length : float
        Of the throw [m].

    Raises
    ------
    SolveError
    """
    turns = np.abs(ends[[3, 4, 5, 9, 10, 11]]).any(axis=0)
    size = np.where(turns, 1.0 / length, 1.0)
    energies, forces = (pair * np.outer(size, size) for pair in stiffness)
    works, reactions = (pair * size[:, None] * _unit(length) for pair in pin_loads)
    apart = np.max(np.abs(forces - energies)) / np.max(np.abs(energies))
    off = np.max(np.abs(reactions - works), initial=0.0)
    _check(
        "Reciprocity of the throw's end forces is off by",
        float(np.maximum(apart, off)),
        LARGEST_DIFFERENCE,
    )


def check_superelement(
    stiffness: Array, pin_loads: Array, length: float, pin_centers: Sequence[Array]
) -> None:
    """Refuse a superelement that is not a free elastic body, or whose reactions do not balance a load.

    Parameters
    ----------
    stiffness, pin_loads
        As of a `fem.superelement.Superelement`.
    length : float
        Between the end sections [m].
    pin_centers : sequence of (3,) arrays
        About which moments on the pins are given [m].

    Raises
    ------
    SolveError
        If the stiffness is not finite and symmetric, resists a rigid motion or does not resist another, or
        if forces and moments on the ends do not balance a unit load on a pin.
    """
    _check("The throw's stiffness is unsymmetric by", asymmetry(stiffness, length))
    _check("Rigid motions of the throw meet forces of", rigid_body_residual(stiffness, length))
    energies = strain_energies(stiffness, length)
    softest = float(energies[RIGID_MOTIONS])
    if not softest >= SMALLEST_ENERGY:
        raise SolveError(
            f"The softest elastic motion of the throw has {softest:.1e} of the strain energy of the stiffest "
            f"(allowed {SMALLEST_ENERGY:.0e} or more): its stiffness is not positive definite."
        )
    _check(
        "Reactions of the throw leave an unbalanced share of a pin's load of",
        unbalanced_pin_loads(pin_loads, length, pin_centers),
    )


def strain_energies(stiffness: ArrayLike, length: float) -> Array:
    """Strain energies (n,) of unit motions along the principal axes of K, ascending, the largest 1.

    The first six are those of rigid motions.
    """
    scaled = scaled_stiffness(stiffness, length)
    energies = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    return np.asarray(energies / energies[-1])


def unbalanced_pin_loads(pin_loads: Array, length: float, pin_centers: Sequence[Array]) -> float:
    """Largest difference of the end loads of a unit load on a pin from its force or moment, as a share.

    In a rigid motion the end loads must do the work of the load itself.
    """
    count, unit = pin_loads.shape[1], _unit(length)
    motions = rigid_body_motions(count)
    left = [0.0]
    for loads, center in zip(pin_loads, pin_centers, strict=True):
        at_pin = np.zeros((6, 6))
        at_pin[:3] = rigid_motions(np.asarray(center)[None])[0] * unit
        at_pin[3:, 3:] = np.diag(unit[3:])
        work = (loads * _sizes(count, length)[:, None]).T @ motions
        left.append(float(np.max(np.abs((work - at_pin) / unit[:, None]))))
    return float(np.max(left))


def _sizes(count: int, length: float) -> Array:
    """Sizes (count,) of unit motions of both ends: rotations times length are 1."""
    return np.concatenate([np.tile(_unit(length), 2), np.ones(count - 12)])


def _unit(length: float) -> Array:
    return np.array([1.0, 1.0, 1.0, *[1.0 / length] * 3])


def _check(what: str, figure: float, allowed: float = LARGEST_ROUND_OFF) -> None:
    if not figure <= allowed:
        raise SolveError(
            f"{what} {figure:.1e} (allowed {allowed:.0e}): the equations are not solved accurately."
        )
