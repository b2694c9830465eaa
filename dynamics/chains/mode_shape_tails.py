"""The far ends of a mode shape, where the vibration has nearly decayed."""

import numpy as np

from crankbase.checks.arrays import FloatArray

# Below this share of the largest mass-normalized displacement, an end of the shape is recomputed.
TAIL_SHARE = 1e-5


def with_accurate_tails(
    normalized: FloatArray, diagonal: FloatArray, off_diagonal: FloatArray, eigenvalue: float
) -> FloatArray:
    """Return a mode whose displacements at the far ends have the right sign and full accuracy.

    A mode of a long chain may be confined to a few inertias and decay by a factor at each further one;
    there an eigenvalue routine leaves round-off of the largest displacement. The equation of
    motion of the end node gives the ratio of its displacement to that of its neighbor, the next
    equation the next ratio, and so on; from the end inwards this is stable in the tail.

    Parameters
    ----------
    normalized : ndarray of shape (n,)
        Mass-normalized mode of the symmetric tridiagonal matrix A.
    diagonal, off_diagonal : ndarray of shape (n,) and (n - 1,)
        A [rad^2/s^2], all off-diagonal entries negative.
    eigenvalue : float
        The mode's eigenvalue of A [rad^2/s^2].

    Returns
    -------
    ndarray of shape (n,)
        The mode, its well-determined part unchanged.
    """
    shape = normalized.copy()
    large = np.flatnonzero(np.abs(shape) >= TAIL_SHARE * np.max(np.abs(shape)))
    first, last = int(large[0]), int(large[-1])
    _replace_left_tail(shape, diagonal, off_diagonal, eigenvalue, first)
    from_right = shape[::-1]
    _replace_left_tail(
        from_right, diagonal[::-1], off_diagonal[::-1], eigenvalue, shape.size - 1 - last
    )
    return shape


def _replace_left_tail(
    shape: FloatArray,
    diagonal: FloatArray,
    off_diagonal: FloatArray,
    eigenvalue: float,
    length: int,
) -> None:
    """Set shape[:length], in place, from shape[length] and the equations of the nodes there."""
    ratios = np.zeros(length)
    carried = 0.0
    for node in range(length):
        pivot = diagonal[node] - eigenvalue + carried
        if pivot == 0.0:
            pivot = np.finfo(np.float64).eps * diagonal[node]
        ratios[node] = -off_diagonal[node] / pivot
        carried = off_diagonal[node] * ratios[node]
    for node in range(length - 1, -1, -1):
        shape[node] = ratios[node] * shape[node + 1]
