"""Designs that fill a box: Latin hypercubes and Sobol sequences, reproducible by a seed.

All points are in the unit cube. A column of a factor with q choices has the middle of the q-th part
that contains the point, so the choices are equally frequent.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from regression.plans.factors import Factor

# Latin hypercubes tried, of which the one with the largest smallest distance is taken; fewer of large
# ones, which take long and gain little: so many points in all.
TRIES, POINTS_TRIED = 400, 100_000
# From here on, near points are found by a tree: the table of distances grows large.
FEW_POINTS = 1500
# More points than this are not thinned by distance: the table of distances would not fit.
LARGEST_THINNED = 4000

# Part of a range at each end from which points are moved to it.
OUTER = 0.25

# The search for points that can be used ends at so many for each one wanted, or at this many in all if
# that is less; it never ends before the smallest number.
SEARCHED_EACH, SEARCHED, SEARCHED_AT_LEAST = 50, 100_000, 2000

Points = NDArray[np.float64]


def hypercube_trials(count: int) -> int:
    """Return how many Latin hypercubes of a number of points are tried."""
    return max(1, min(TRIES, POINTS_TRIED // count))


def latin_hypercube_points(
    count: int, choices: Sequence[int], seed: Sequence[int], tries: int | None = None
) -> Points:
    """Draw a Latin hypercube (n, k) within [0, 1): each column in n strata, one point in each.

    Of `tries` hypercubes of `scipy.stats.qmc` (`hypercube_trials` by default) the one is used whose
    nearest two points are farthest apart (maximin). `choices` has the number of choices of each column,
    0 for a continuous one.
    """
    from scipy.stats import qmc

    sampler = qmc.LatinHypercube(len(choices), rng=np.random.default_rng(list(seed)))
    best = _at_choices(sampler.random(count), choices)
    if count == 1 or len(choices) == 1:
        return best
    best_distance = smallest_distance(best)
    for _ in range((tries or hypercube_trials(count)) - 1):
        candidate = _at_choices(sampler.random(count), choices)
        distance = smallest_distance(candidate)
        if distance > best_distance:
            best, best_distance = candidate, distance
    return best


def with_points_at_ends(points: Points, choices: Sequence[int]) -> Points:
    """Move every second point (n, k) to the ends of those ranges in whose outer quarters it is; choices stay.

    There polynomials have their largest errors, and a space-filling design has no points.
    """
    moved = points.copy()
    outer = points[1::2]
    ends = np.where(outer < OUTER, 0.0, np.where(outer > 1.0 - OUTER, 1.0, outer))
    moved[1::2] = np.where(np.array(choices) > 0, outer, ends)
    return moved


def sobol_points(count: int, choices: Sequence[int], seed: Sequence[int]) -> Points:
    """First points (n, k) of a scrambled Sobol sequence; arguments as of `latin_hypercube_points`."""
    from scipy.stats import qmc

    sampler = qmc.Sobol(len(choices), rng=np.random.default_rng(list(seed)))
    power = max(0, math.ceil(math.log2(count)))
    return _at_choices(sampler.random_base2(power)[:count], choices)


def _at_choices(points: Points, choices: Sequence[int]) -> Points:
    placed = points.copy()
    for column, number in enumerate(choices):
        if number:
            placed[:, column] = (np.floor(points[:, column] * number) + 0.5) / number
    return placed


def smallest_distance(points: Points) -> float:
    """Return the distance of the two nearest points."""
    from scipy.spatial import cKDTree
    from scipy.spatial.distance import pdist

    if len(points) <= FEW_POINTS:
        return math.sqrt(pdist(points, "sqeuclidean").min())
    distances, _ = cKDTree(points).query(points, k=[2])
    return float(np.min(distances))


def well_spaced_subset(points: Points, count: int) -> NDArray[np.int64]:
    """Indices, ascending, of `count` points (n, k) far apart: the nearest ones are dropped one by one."""
    number = len(points)
    if number > LARGEST_THINNED:
        return np.arange(count)
    from scipy.spatial.distance import cdist

    distances = cdist(points, points)
    np.fill_diagonal(distances, np.inf)
    staying = np.ones(number, dtype=bool)
    for _ in range(number - count):
        nearest = distances.min(axis=1)
        first = int(np.argmin(nearest))
        second = int(np.argmin(distances[first]))
        # Of the two, the one whose next neighbor is nearer goes.
        others = np.sort(distances[[first, second]], axis=1)[:, 1]
        gone = first if others[0] <= others[1] else second
        distances[gone, :] = distances[:, gone] = np.inf
        staying[gone] = False
    return np.flatnonzero(staying)


def draw_feasible_points(
    draw: Callable[[int], Points],
    possible: Callable[[Points], NDArray[np.bool_]],
    count: int,
    *,
    in_order: bool,
) -> tuple[Points, NDArray[np.bool_], NDArray[np.bool_]] | None:
    """Draw points (n, k) until `count` of them are possible; None if so few are that the search is abandoned.

    Returns all points drawn, which of them are used, and which are impossible. With `in_order` the
    first possible ones are used (a sequence), not those farthest apart.
    """
    number = count
    most = max(SEARCHED_AT_LEAST, min(SEARCHED, SEARCHED_EACH * count))
    while True:
        points = draw(number)
        usable = possible(points)
        feasible = int(np.count_nonzero(usable))
        if feasible >= count:
            taken = np.zeros(number, dtype=bool)
            indices = np.flatnonzero(usable)
            chosen = np.arange(count) if in_order else well_spaced_subset(points[indices], count)
            taken[indices[chosen]] = True
            return points, taken, ~usable
        if number >= most:
            return None
        share = max(feasible, 0.5) / number
        number = min(most, max(number + 1, math.ceil(1.1 * count / share)))


# Correlations below this are round-off.
NONE = 1e-12


@dataclass(frozen=True)
class DesignQuality:
    """Quality of runs before any has a result, in coordinates 0 to 1 over each range.

    Attributes
    ----------
    distance : float or None
        Distance of the two nearest runs; labels of a choice of q are 1/q apart. None for a single run.
    discrepancy : float
        Centered L2 discrepancy, squared, as scipy has it (Hickernell 1998), of the factors that are numbers;
        0 would be perfectly even.
    random_discrepancy : float
        Its mean for the same number of random points: ((5/4)^k - (13/12)^k) / n.
    correlation : float or None
        Largest absolute correlation of two factors, `correlated`, choices of two labels among them;
        None without two that vary.
    """

    distance: float | None
    discrepancy: float
    random_discrepancy: float
    correlation: float | None
    correlated: tuple[str, ...]


def design_quality(factors: Sequence[Factor], values: NDArray[np.float64]) -> DesignQuality:
    """Assess runs (n, k) [SI], of a choice the label's index, by distance, discrepancy and correlation."""
    from scipy.stats import qmc

    lowest = np.array([factor.lowest for factor in factors])
    spans = np.array([factor.highest for factor in factors]) - lowest
    points = (values - lowest) / spans
    numbers = [place for place, factor in enumerate(factors) if not factor.labels]
    apart = points.copy()
    for place, factor in enumerate(factors):
        if factor.labels:
            apart[:, place] = values[:, place] / len(factor.labels)
    discrepancy = qmc.discrepancy(np.clip(points[:, numbers], 0.0, 1.0))
    count, width = len(values), len(numbers)
    largest, pair = _largest_correlation(factors, points)
    return DesignQuality(
        distance=smallest_distance(apart) if count > 1 else None,
        discrepancy=float(discrepancy),
        random_discrepancy=((5.0 / 4.0) ** width - (13.0 / 12.0) ** width) / count,
        correlation=largest,
        correlated=pair,
    )


def _largest_correlation(
    factors: Sequence[Factor], points: NDArray[np.float64]
) -> tuple[float | None, tuple[str, ...]]:
    ordered = [
        place
        for place, factor in enumerate(factors)
        if len(factor.labels) <= 2 and np.ptp(points[:, place]) > 0.0
    ]
    if len(ordered) < 2:
        return None, ()
    table = np.abs(np.corrcoef(points[:, ordered].T))
    largest, first, second = max(
        (float(table[i, j]), -i, -j) for i, j in itertools.combinations(range(len(ordered)), 2)
    )
    if largest < NONE:
        return 0.0, ()
    return largest, (factors[ordered[-first]].name, factors[ordered[-second]].name)
