"""Solve symmetric positive definite systems; the one place that knows which library does it."""

import copy
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from fem.assembly import symmetric_product
from geometry.errors import InputError

# A backward stable solve leaves a residual near round-off; anything above this is a wrong solve.
LARGEST_RESIDUAL = 1e-9
# Supported structures keep their pivots within eight decades of each other; a rigid-body motion left
# free leaves one at round-off.
SMALLEST_PIVOT = 1e-13

Array = NDArray[np.float64]


class SolveError(RuntimeError):
    """A system of equations could not be solved, or its solution does not satisfy it."""


def solve_symmetric(
    upper: sparse.csr_array, right_sides: Array, solver: str = "auto"
) -> tuple[Array, str]:
    """Solve A x = b for a symmetric positive definite matrix and check the residual.

    Parameters
    ----------
    upper : (n, n) sparse array
        Upper triangle of A.
    right_sides : (n, k) array
        The right sides b.
    solver : {"auto", "pardiso", "superlu"}
        MKL's Pardiso, or scipy's SuperLU, which needs no MKL and is several times slower.

    Returns
    -------
    solution : (n, k) array
    solver : str
        The solver that was used.

    Raises
    ------
    SolveError
        If the matrix is singular or the residual is not near round-off.
    """
    chosen = _choose(solver)
    solve: Callable[[sparse.csr_array, Array], Array] = (
        _solve_pardiso if chosen == "pardiso" else _solve_superlu
    )
    solution = solve(upper, right_sides)
    residual = np.linalg.norm(symmetric_product(upper, solution) - right_sides, axis=0)
    size = abs(upper).sum(axis=1).max() * np.linalg.norm(solution, axis=0)
    scale = np.maximum(np.linalg.norm(right_sides, axis=0), 1e-3 * size)
    if not np.all(residual <= LARGEST_RESIDUAL * np.maximum(scale, np.finfo(float).tiny)):
        raise SolveError(
            f"{chosen} left a relative residual of {np.max(residual / scale):.1e} (allowed "
            f"{LARGEST_RESIDUAL:.0e}): the structure may be insufficiently supported."
        )
    return solution, chosen


def _choose(solver: str) -> str:
    if solver == "auto":
        return "superlu" if _pardiso() is None else "pardiso"
    if solver not in ("pardiso", "superlu"):
        raise InputError(f"solver: given {solver!r}; allowed are auto, pardiso, superlu.")
    if solver == "pardiso" and _pardiso() is None:
        raise SolveError(
            "The solver pardiso is not installed; install it with: pip install pypardiso"
        )
    return solver


@cache
def _pardiso() -> Any:
    """Load Pardiso once (finding MKL takes a while); None where it cannot be had."""
    try:
        from pypardiso import PyPardisoSolver

        return PyPardisoSolver(mtype=2)
    except (ImportError, OSError):
        return None


def _solve_pardiso(upper: sparse.csr_array, right_sides: Array) -> Array:
    solver = copy.copy(_pardiso())
    solver.pt, solver.iparm = np.zeros_like(solver.pt), np.zeros_like(solver.iparm)
    matrix = sparse.csr_matrix(upper)
    try:
        return np.asarray(solver.solve(matrix, np.asfortranarray(right_sides)))
    except Exception as error:  # pypardiso's own kinds; not positive definite is number -4
        raise SolveError(f"Pardiso could not solve the system: {error}") from error
    finally:
        solver.free_memory(everything=True)


def _solve_superlu(upper: sparse.csr_array, right_sides: Array) -> Array:
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
    return np.asarray(factors.solve(right_sides))
