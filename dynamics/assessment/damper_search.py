"""The search that sizes dampers: least peaks, and the smallest size that keeps a limit.

The search uses logarithms of all values and is deterministic.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize, minimize_scalar

from crankbase.checks.arrays import FloatArray

Ranges = Sequence[tuple[float, float]]
# Points of the first look at the range of a setting, of later ones about the last best setting, and
# the factor by which these go beyond it.
FIRST_SCAN, LATER_SCAN, WIDER = 11, 5, 2.0
# A search ends when the logarithms of its variables are known to this; the least peak is flat or has
# a kink there, so that it is known to about the same share.
CLOSE = 5e-4
# The share of a limit that the smallest size is made to use, so that it is not met from above.
AIM = 1.0 - CLOSE
MOST_TRIALS = 100
# Share of the logarithm of a range that counts as its end.
AT_END = 1e-2


@dataclass(frozen=True, eq=False)
class TrialSize:
    """A trial size of a damper.

    Parameters
    ----------
    size : float
    settings : ndarray of shape (d,)
        The best settings found for it.
    used : float
        Largest share of the permitted amplitude with them; inf if unbounded.
    """

    size: float
    settings: FloatArray
    used: float


def smallest_sufficient(tried: Sequence[TrialSize]) -> TrialSize:
    """Return the smallest size that keeps the limit; if none does, the one of least usage."""
    kept = [one for one in tried if one.used <= 1.0]
    if kept:
        return min(kept, key=lambda one: one.size)
    return min(tried, key=lambda one: (one.used, one.size))


def without_close_sizes(tried: Sequence[TrialSize]) -> tuple[TrialSize, ...]:
    """Drop sizes within a hundredth of the range of another, such as those at the end of a search.

    Parameters
    ----------
    tried : sequence of Tried
        Ascending.

    Returns
    -------
    tuple of Tried
        Includes the first, the last and the selected one.
    """
    places = np.log([one.size for one in tried])
    close = AT_END * float(places[-1] - places[0])
    kept = {0, len(tried) - 1, tried.index(smallest_sufficient(tried))}
    for place in range(len(tried)):
        if all(abs(places[place] - places[other]) > close for other in kept):
            kept.add(place)
    return tuple(tried[place] for place in sorted(kept))


def search_sizes(
    at: Callable[[float, TrialSize | None], TrialSize], low: float, high: float, points: int
) -> tuple[TrialSize, ...]:
    """Search for the smallest size that keeps a limit.

    Parameters
    ----------
    at : callable
        Maps a size, and the nearest size tried before (None at first), to the best result for it.
    low, high : float
        Range of the size.
    points : int
        Number of sizes of the initial scan. It is followed by a search for the least use if no size keeps
        the limit, or for the size at which the limit is met if one does.

    Returns
    -------
    tuple of Tried
        All sizes tried, ascending.
    """
    found: dict[float, TrialSize] = {}

    def used(logarithm: float) -> float:
        size = min(max(float(np.exp(logarithm)), low), high)
        if size not in found:
            nearest = min(
                found.values(), key=lambda one: abs(np.log(one.size / size)), default=None
            )
            found[size] = at(size, nearest)
        return found[size].used

    if low == high:
        return (at(low, None),)
    places = np.linspace(np.log(high), np.log(low), points)
    values = [used(float(place)) for place in places]
    best = int(np.argmin([finite(value) for value in values]))
    if values[best] > 1.0 and 0 < best < points - 1:
        _brent(used, float(places[best + 1]), float(places[best - 1]))
    kept = smallest_sufficient(list(found.values()))
    smaller = [one.size for one in found.values() if one.size < kept.size]
    if kept.used <= AIM and smaller:
        brentq(
            lambda place: finite(used(place)) - finite(AIM),
            np.log(max(smaller)),
            np.log(kept.size),
            xtol=0.1 * CLOSE,
        )
    return tuple(found[size] for size in sorted(found))


def minimize_usage(
    used: Callable[[FloatArray], float], ranges: Ranges, last: FloatArray | None
) -> tuple[FloatArray, float]:
    """Find the settings of least usage of a limit.

    Parameters
    ----------
    used : callable
        Maps settings (d,) to the use of the limit; at most two are free.
    ranges : sequence of d pairs of floats
        Equal ends fix a setting.
    last : ndarray of shape (d,) or None
        Best settings of a neighboring size: searched within a factor about them, and over the whole
        ranges only if the best ones are at an end of that interval.

    Returns
    -------
    settings : ndarray of shape (d,)
    used : float
    """
    whole = np.log(np.array(ranges, dtype=np.float64))
    if last is not None:
        near = np.log(np.clip(last, np.exp(whole[:, 0]), np.exp(whole[:, 1])))
        wide = np.log(WIDER)
        about = np.column_stack(
            (np.maximum(near - wide, whole[:, 0]), np.minimum(near + wide, whole[:, 1]))
        )
        best, value = _minimum_usage(used, about, LATER_SCAN)
        cut = np.any((np.abs(best[:, np.newaxis] - about) <= AT_END) & (about != whole))
        if not cut:
            return np.exp(best), value
    best, value = _minimum_usage(used, whole, FIRST_SCAN)
    return np.exp(best), value


def range_end_remark(name: str, value: float, low: float, high: float) -> str:
    """State that a best value is at an end of its range; empty if it is not."""
    if not low < high:
        return ""
    for end, word in ((low, "least"), (high, "largest")):
        if abs(np.log(value / end)) <= AT_END * np.log(high / low):
            return f"; the {name} is the {word} allowed"
    return ""


def finite(used: float) -> float:
    """Return an increasing function of the use that stays finite where the vibration is unbounded."""
    return 1.0 if np.isinf(used) else used / (1.0 + used)


def _minimum_usage(
    used: Callable[[FloatArray], float], ends: FloatArray, points: int
) -> tuple[FloatArray, float]:
    """Find the least usage within ranges of logarithms, and where it occurs."""
    free = np.flatnonzero(ends[:, 1] > ends[:, 0])

    def at(values: FloatArray) -> float:
        return used(np.exp(placed(values)))

    def placed(values: FloatArray) -> FloatArray:
        whole = ends[:, 0].copy()
        whole[free] = values
        return whole

    if free.size == 0:
        return ends[:, 0].copy(), at(np.empty(0))
    axes = [np.linspace(low, high, points) for low, high in ends[free].tolist()]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, free.size)
    values = [at(point) for point in grid]
    place = int(np.argmin([finite(value) for value in values]))
    first, least = grid[place], values[place]
    if free.size == 1:
        low, high = max(place - 1, 0), min(place + 1, points - 1)
        found = _brent(lambda x: at(np.array([x])), float(axes[0][low]), float(axes[0][high]))
        best = np.array([found])
    else:
        steps = 0.5 * np.diag([axis[1] - axis[0] for axis in axes])
        best = _nelder_mead(at, np.vstack((first, first + steps)), ends[free])
    value = at(best)
    return (placed(best), value) if value <= least else (placed(first), least)


def _brent(used: Callable[[float], float], low: float, high: float) -> float:
    found = minimize_scalar(
        lambda x: finite(used(float(x))),
        bounds=(low, high),
        method="bounded",
        options={"xatol": CLOSE},
    )
    return float(found.x)


def _nelder_mead(
    used: Callable[[FloatArray], float], simplex: FloatArray, ends: FloatArray
) -> FloatArray:
    def objective(x: FloatArray, /) -> float:
        return finite(used(x))

    start: FloatArray = np.array(simplex[0], dtype=np.float64)
    found = minimize(
        objective,
        start,
        method="Nelder-Mead",
        bounds=[(float(low), float(high)) for low, high in ends],
        options={
            "initial_simplex": np.clip(simplex, ends[:, 0], ends[:, 1]),
            "xatol": CLOSE,
            "fatol": 0.1 * CLOSE,
            "maxfev": MOST_TRIALS,
        },
    )
    return np.asarray(found.x, dtype=np.float64)
