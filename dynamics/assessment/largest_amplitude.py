"""Largest synthesized amplitude over many speeds and points, with few sums over the cycle."""

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from dynamics.response.series import OrderSeries
from dynamics.response.synthesis import synthesis

# Sums made at once.
TOGETHER = 32


def largest_amplitude(series: OrderSeries, weights: FloatArray) -> tuple[float, int, int]:
    """Find the largest weighted amplitude of a series.

    Parameters
    ----------
    series : OrderSeries
    weights : ndarray of shape (S,)
        Of each speed, such as the reciprocal of the limit; not negative, zero where the speed is ignored.

    Returns
    -------
    amplitude : float
        Without its weight, in the unit of the series; inf where unbounded.
    speed, place : int
        Their indices.

    Notes
    -----
    No amplitude exceeds the plain sum of the orders' amplitudes. Sums over the cycle are formed in the
    order of these bounds, until no remaining bound exceeds the largest sum found. The result equals that
    of all sums, most of which are never formed.
    """
    endless = np.any(series.unbounded, axis=0) & (weights > 0.0)
    if np.any(endless):
        return np.inf, int(np.argmax(endless)), 0
    values = series.values
    bounds = weights[:, np.newaxis] * np.sum(np.abs(values), axis=0)
    ranked = np.argsort(-bounds, axis=None, kind="stable")
    best, amplitude, winner = -1.0, 0.0, int(ranked[0])
    flat = values.reshape(len(series.orders), -1)
    for start in range(0, ranked.size, TOGETHER):
        some = ranked[start : start + TOGETHER]
        if bounds.flat[some[0]] <= best:
            break
        speeds, _ = np.unravel_index(some, bounds.shape)
        found = synthesis(series.orders, series.speeds[speeds], flat[:, some]).amplitude
        used = weights[speeds] * found
        top = int(np.argmax(used))
        if used[top] > best:
            best, amplitude, winner = float(used[top]), float(found[top]), int(some[top])
    speed, place = np.unravel_index(winner, bounds.shape)
    return amplitude, int(speed), int(place)


def speeds_above(
    series: OrderSeries, weights: FloatArray, known: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return at which speeds the weighted amplitude of any point exceeds one, (S,).

    Parameters
    ----------
    series : OrderSeries
    weights : ndarray of shape (S,)
        As for `largest_amplitude`.
    known : ndarray of shape (S,), bool
        Speeds that are skipped, because they exceed it already.
    """
    above = known | (np.any(series.unbounded, axis=0) & (weights > 0.0))
    bounds = weights[:, np.newaxis] * np.sum(np.abs(series.values), axis=0)
    ranked = np.argsort(-bounds, axis=1)
    for place in ranked.T:
        rows = np.flatnonzero(~above)
        rows = rows[bounds[rows, place[rows]] > 1.0]
        if not rows.size:
            break
        own = series.values[:, rows, place[rows]]
        found = synthesis(series.orders, series.speeds[rows], own).amplitude
        above[rows] = weights[rows] * found > 1.0
    return np.asarray(above)
