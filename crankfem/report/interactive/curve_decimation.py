"""Fewer points for a curve: those that one sees."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def visible_points(x: Array, y: Array, tolerance: float, step: float = np.inf) -> NDArray[np.int64]:
    """Choose the visible points of a curve: those without which it would look different.

    Parameters
    ----------
    x, y : (n,) arrays
        x ascending; y may have gaps (nan).
    tolerance : float
        By how much the curve through the chosen points may miss a point in y.
    step : float
        Largest distance in x between chosen points, so that there is always one to hover on.

    Returns
    -------
    (m,) array of int
        Ascending. Ends of the curve and of gaps stay, and of each gap its first point.

    Notes
    -----
    A piece is split at the point that is missed most, until none is missed by more than the tolerance
    (D. Douglas, T. Peucker, The Canadian Cartographer 10, 1973, 112-122, with distances in y).
    """
    known = np.isfinite(y)
    # Each point without a value next to one with a value keeps the gap.
    kept = ~known & np.append(True, known[:-1])
    edges = np.flatnonzero(np.diff(np.concatenate(([False], known, [False])).astype(np.int8)))
    pieces = [
        (int(first), int(last) - 1) for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]
    while pieces:
        first, last = pieces.pop()
        kept[[first, last]] = True
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        slope = (y[last] - y[first]) / (x[last] - x[first])
        missed = np.abs(y[inner] - y[first] - slope * (x[inner] - x[first]))
        if missed.max() > tolerance:
            middle = first + 1 + int(np.argmax(missed))
        elif x[last] - x[first] > step:
            middle = first + 1 + int(np.argmin(np.abs(x[inner] - 0.5 * (x[first] + x[last]))))
        else:
            continue
        pieces += [(first, middle), (middle, last)]
    return np.flatnonzero(kept)
