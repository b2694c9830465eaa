"""The speeds at which most of a limit is used, refined between the calculated ones."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray

# Maxima that reach this share of a curve's largest value are refined: on a grid that refines resonances
# another may read 0.2 % less than it is, and turn out to be the largest.
NEARLY_LARGEST = 0.99
# A maximum's neighbors come this many times closer in each round, and so often.
CLOSER, ROUNDS = 4, 3

Uses = Callable[[FloatArray], FloatArray]


def refined_maxima(uses_at: Uses, speeds: FloatArray, least: float = np.inf) -> FloatArray:
    """Find the speeds of the largest values of curves, more closely than the calculated speeds.

    Parameters
    ----------
    uses_at : callable
        Speeds (S,) [rad/s] to the values (C, S) of the curves, such as the used share of limits; not
        negative, inf where unbounded.
    speeds : ndarray of shape (S,)
        Ascending [rad/s].
    least : float, optional
        In each range in which a curve exceeds this, its first and last maximum are refined too.

    Returns
    -------
    ndarray of shape (m,)
        Ascending speeds between those given at which a curve has a maximum [rad/s].

    Notes
    -----
    Each maximum is between the neighbors of the largest calculated value. Values are calculated at
    even steps between them, and the neighbors of the new largest value are the next bounds: after three
    rounds they are 64 times closer. On a grid that steps by an eighth of the half bandwidth near
    resonances, this gives the speed to 1/512 of it and the value, as a peak is round, to 1e-6.
    """
    values = uses_at(speeds)
    curves, tops = _maxima(values, least)
    if not curves.size:
        return np.empty(0)
    none = np.full(curves.size, -1.0)
    best = speeds[tops]
    left = speeds[np.maximum(tops - 1, 0)]
    right = speeds[np.minimum(tops + 1, speeds.size - 1)]
    reached = values[curves, tops]
    steps = np.arange(1, 2 * CLOSER) / (2.0 * CLOSER)
    for _ in range(ROUNDS):
        # The best place known stays among those tried, for the bracket need not be even about it.
        tried = left[:, np.newaxis] + (right - left)[:, np.newaxis] * steps
        asked = np.unique(tried)
        found = uses_at(asked)[curves[:, np.newaxis], np.searchsorted(asked, tried)]
        every = np.column_stack((left, best, tried, right))
        known = np.column_stack((none, reached, found, none))
        row, top = np.arange(best.size), np.argmax(known, axis=1)
        best, reached = every[row, top], known[row, top]
        below, above = every < best[:, np.newaxis], every > best[:, np.newaxis]
        # At the first and last speed calculated there is none beyond.
        left = np.max(np.where(below, every, -np.inf), axis=1)
        left = np.where(np.isfinite(left), left, best)
        right = np.min(np.where(above, every, np.inf), axis=1)
        right = np.where(np.isfinite(right), right, best)
    return np.asarray(np.unique(best))


def _maxima(values: FloatArray, least: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return curve and index of each maximum to be refined; an unbounded one needs no refinement."""
    chosen = set()
    for curve, own in enumerate(values):
        beside = np.concatenate(([-1.0], own, [-1.0]))
        tops = np.flatnonzero((own > beside[:-2]) & (own >= beside[2:]) & (own > 0.0))
        largest = np.max(own, initial=0.0)
        chosen |= {(curve, top) for top in tops.tolist() if own[top] >= NEARLY_LARGEST * largest}
        # Ranges without a gap above the least value, numbered by the steps up to it.
        runs = np.cumsum(np.diff(own > least, prepend=False))
        exceeding = tops[own[tops] > least]
        for run in np.unique(runs[exceeding]):
            inside = exceeding[runs[exceeding] == run]
            chosen |= {(curve, int(inside[0])), (curve, int(inside[-1]))}
    found = sorted(pair for pair in chosen if np.isfinite(values[pair]))
    pairs = np.array(found, dtype=np.intp).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1]
