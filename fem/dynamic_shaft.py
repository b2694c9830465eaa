"""A row of throws as dynamic superelements, and natural modes of the whole shaft."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from crankbase.errors import InputError
from fem.class_modes import frequencies_of
from fem.craig_bampton import DynamicSuperelement

Array = NDArray[np.float64]


def assemble_dynamic_shaft(throws: Sequence[DynamicSuperelement]) -> tuple[Array, Array]:
    """Stiffness and mass of throws in a row, each already turned to its crank angle.

    Parameters
    ----------
    throws : sequence of n DynamicSuperelement

    Returns
    -------
    stiffness, mass : (u, u) array
        Motions of the n + 1 end sections from the left, as in `fem.shaft.assemble_shaft`, then the
        amplitudes of shapes, throw by throw.

    Raises
    ------
    InputError
        If there is no throw.
    """
    if not throws or not all(isinstance(throw, DynamicSuperelement) for throw in throws):
        raise InputError(
            "throws: given none, or what is no DynamicSuperelement; allowed is at least one of these, "
            "because a shaft has throws."
        )
    first = 6 * (len(throws) + 1)
    size = first + sum(len(throw.frequencies) for throw in throws)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for place, throw in enumerate(throws):
        last = first + len(throw.frequencies)
        own = np.r_[6 * place : 6 * place + 12, first:last]
        stiffness[np.ix_(own, own)] += throw.stiffness
        mass[np.ix_(own, own)] += throw.mass
        first = last
    return stiffness, mass


def natural_modes(
    stiffness: Array, mass: Array, held: Sequence[int] | NDArray[np.int64] = ()
) -> tuple[Array, Array]:
    """All natural modes of an assembled shaft.

    Parameters
    ----------
    stiffness, mass : (u, u) array
        Symmetric, the mass positive definite.
    held : sequence of int
        Unknowns that supports keep at zero.

    Returns
    -------
    frequencies : (k,) array
        Ascending [Hz]; those of rigid motions are zero, but for rounding.
    shapes : (u, k) array
        Of unit modal mass.

    Raises
    ------
    InputError
        If the matrices are not square, finite and of one size, the mass is not positive definite, or an
        unknown in `held` does not exist.
    """
    stiffness, mass = _checked_matrix("stiffness", stiffness), _checked_matrix("mass", mass)
    if stiffness.shape != mass.shape:
        raise InputError(
            f"mass: given shape {mass.shape}; allowed is that of the stiffness, {stiffness.shape}."
        )
    places = np.atleast_1d(np.asarray(held))
    if places.size and not (
        places.dtype.kind in "iu" and np.all((places >= 0) & (places < len(stiffness)))
    ):
        raise InputError(
            f"held: given {held!r}; allowed are numbers of unknowns, 0 to {len(stiffness) - 1}."
        )
    free = np.setdiff1d(np.arange(len(stiffness)), places)
    try:
        squares, vectors = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)])
    except np.linalg.LinAlgError:
        raise InputError(
            "mass: given a matrix that is not positive definite; allowed is one that is, because every "
            "motion has inertia."
        ) from None
    shapes = np.zeros((len(stiffness), len(free)))
    shapes[free] = vectors
    return frequencies_of(squares), shapes


def _checked_matrix(name: str, given: Array) -> Array:
    """Return a square matrix of finite numbers.

    Raises
    ------
    InputError
    """
    try:
        matrix = np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        matrix = np.empty(0)
    if matrix.ndim != 2 or len(matrix) != matrix.shape[1] or not np.all(np.isfinite(matrix)):
        raise InputError(
            f"{name}: given {type(given).__name__} of shape {np.shape(matrix)}; allowed is a square matrix "
            "of finite numbers."
        )
    return matrix
