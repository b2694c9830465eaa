"""The largest amplitude of all orders together among many speeds and places, with few sums over cycles."""

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
        Of each speed, such as one over what is permitted; none below zero, zero where it does not count.

    Returns
    -------
    amplitude : float
        Without its weight, in the unit of the series; inf where unbounded.
    speed, place : int
        Their numbers.

    Notes
    -----
    No amplitude exceeds the plain sum of the orders' amplitudes: sums over the cycle are made in the
    order of these bounds, until no bound left exceeds the largest that was found. The result is that of
    all sums, of which most are never made.
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
    """Tell at which speeds the weighted amplitude of any place exceeds one, (S,).

    Parameters
    ----------
    series : OrderSeries
    weights : ndarray of shape (S,)
        As for `largest_amplitude`.
    known : ndarray of shape (S,), bool
        Speeds that are not looked at, for they count already.
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
