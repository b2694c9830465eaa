"""Solutions of an approximate solver refined until only round-off is left of their residual.

The residual of a solution is solved for again and added (iterative refinement: N. J. Higham,
Accuracy and Stability of Numerical Algorithms, SIAM 2002, chapter 12). With factors in single precision each
step gains three to five digits.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.assembly import symmetric_product

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
