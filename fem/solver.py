"""Solve symmetric positive definite systems; the one place that knows which library does it."""

import copy
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from fem.assembly import symmetric_product
from geometry.errors import InputError
from geometry.stopwatch import Stopwatch

# A backward stable solve leaves a residual near round-off; anything above this is a wrong solve.
LARGEST_RESIDUAL = 1e-9
# Supported structures keep their pivots within eight decades of each other; a rigid-body motion left
# free leaves one at round-off.
SMALLEST_PIVOT = 1e-13
SOLVERS = ("pardiso", "superlu")

Array = NDArray[np.float64]


class SolveError(RuntimeError):
    """A system of equations could not be solved, or its solution does not satisfy it."""


@dataclass(frozen=True)
class Factorization:
    """A factorized matrix, ready to solve with any number of right sides.

    Attributes
    ----------
    upper : (n, n) sparse array
        Upper triangle of the matrix.
    solver : str
        The solver that was used.
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
        residual = np.linalg.norm(symmetric_product(self.upper, solution) - right_sides, axis=0)
        size = self.size * np.linalg.norm(solution, axis=0)
        scale = np.maximum(np.linalg.norm(right_sides, axis=0), 1e-3 * size)
        scale = np.maximum(scale, np.finfo(float).tiny)
        if not np.all(residual <= LARGEST_RESIDUAL * scale):
            raise SolveError(
                f"{self.solver} left a relative residual of {np.max(residual / scale):.1e} (allowed "
                f"{LARGEST_RESIDUAL:.0e}): the structure may be insufficiently supported."
            )
        return solution


@contextmanager
def factorize(
    upper: sparse.csr_array, solver: str = "auto", watch: Stopwatch | None = None
) -> Iterator[Factorization]:
    """Factorize a symmetric positive definite matrix; its memory is freed at the end of the block.

    Parameters
    ----------
    upper : (n, n) sparse array
        Upper triangle of the matrix.
    solver : {"auto", "pardiso", "superlu"}
        MKL's Pardiso, or scipy's SuperLU, which needs no MKL and is several times slower. "auto" is
        Pardiso where it can be loaded.
    watch : Stopwatch, optional
        Takes the time.

    Yields
    ------
    Factorization

    Raises
    ------
    SolveError
        If the matrix is singular, or the solver is missing.
    InputError
        If the solver is unknown.
    """
    watch = Stopwatch() if watch is None else watch
    chosen = _choose(solver, watch)
    factors = _pardiso_factors if chosen == "pardiso" else _superlu_factors
    with watch.lap("factorization"):
        apply, free = factors(upper)
    try:
        size = float(abs(upper).sum(axis=1).max())
        yield Factorization(upper, chosen, size, apply)
    finally:
        free()


def solve_symmetric(
    upper: sparse.csr_array,
    right_sides: Array,
    solver: str = "auto",
    watch: Stopwatch | None = None,
) -> tuple[Array, str]:
    """Solve A x = b for a symmetric positive definite matrix and check the residual.

    Parameters
    ----------
    upper, solver, watch
        As for `factorize`, which also says what is raised.
    right_sides : (n, k) array
        The right sides b.

    Returns
    -------
    solution : (n, k) array
    solver : str
        The solver that was used.

    Raises
    ------
    SolveError
        If the residual is not near round-off.
    """
    watch = Stopwatch() if watch is None else watch
    with factorize(upper, solver, watch) as factors, watch.lap("solves"):
        return factors.solve(right_sides), factors.solver


def _choose(solver: str, watch: Stopwatch) -> str:
    if solver not in ("auto", *SOLVERS):
        raise InputError(f"solver: given {solver!r}; allowed are auto, {', '.join(SOLVERS)}.")
    if solver == "superlu":
        return solver
    with watch.lap("loading the solver"):
        found = _pardiso() is not None
    if not found and solver == "pardiso":
        raise SolveError(
            "The solver pardiso is not installed; install it with: pip install pypardiso"
        )
    return "pardiso" if found else "superlu"


@cache
def _pardiso() -> Any:
    """Load Pardiso once (finding MKL takes a while); None where it cannot be had."""
    try:
        from pypardiso import PyPardisoSolver

        return PyPardisoSolver(mtype=2)
    except (ImportError, OSError):
        return None


Factors = tuple[Callable[[Array], Array], Callable[[], None]]


def _pardiso_factors(upper: sparse.csr_array) -> Factors:
    """Factorize with Pardiso: how to solve, and how to free the memory."""
    solver = copy.copy(_pardiso())
    solver.pt, solver.iparm = np.zeros_like(solver.pt), np.zeros_like(solver.iparm)
    matrix = sparse.csr_matrix(upper)

    def call(work: Callable[[], Any]) -> Any:
        try:
            return work()
        except Exception as error:  # pypardiso's own kinds; not positive definite is number -4
            raise SolveError(f"Pardiso could not solve the system: {error}") from error

    def free() -> None:
        solver.free_memory(everything=True)

    try:
        call(lambda: solver.factorize(matrix))
    except BaseException:
        free()
        raise
    return lambda sides: np.asarray(call(lambda: solver.solve(matrix, sides))), free


def _superlu_factors(upper: sparse.csr_array) -> Factors:
    """Factorize with SuperLU: how to solve, and nothing to free."""
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
    return lambda sides: np.asarray(factors.solve(sides)), lambda: None
