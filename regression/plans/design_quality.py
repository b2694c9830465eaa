"""How well the runs of a plan fill the box of its factors."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from regression.plans.designs_space import smallest_distance
from regression.plans.factors import Factor

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
        Largest absolute correlation of two factors, choices of two labels among them; None without two
        that vary.
    correlated : tuple of str
        The two factors; empty where none are.
    """

    distance: float | None
    discrepancy: float
    random_discrepancy: float
    correlation: float | None
    correlated: tuple[str, ...]


def design_quality(factors: Sequence[Factor], values: NDArray[np.float64]) -> DesignQuality:
    """Assess runs by distance, discrepancy and correlation.

    Parameters
    ----------
    factors : sequence of Factor
    values : (n, k) ndarray
        Of the runs [SI]; of a choice the label's index.
    """
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
