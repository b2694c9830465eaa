"""Sensitivity under constraints: factors that are uniform over a part of their box depend on each other.

With c(u) = E Var(y | all but x_u), the mean variance that is left while only the factors u are unknown,
the first index is 1 - c(all but i) / c(all), the total one c(i) / c(all), and the Shapley effect the mean of
(c(u and i) - c(u)) / c(all) over all positions of a factor in an order of all factors (Song, Nelson and
Staum, SIAM/ASA J. Uncertainty Quantification 4, 2016, pp. 1060-1083). Uniform over a region means uniform
over each of its sections, so c(u) = E (y(x) - y(x'))^2 / 2, where x' is x with the factors u drawn again
until it is in the region: valid for any constraints, with statistical error only.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from regression.fits.sensitivity import CONSTANT, Array, Model, SobolIndices
from regression.plans.factors import Factor

# Points of each sample: an index is then uncertain by about 0.01.
POINTS, SEED = 32_768, 1
# Draws for a point at most; where a region is so small a part of its section, the point stays itself.
TRIES = 300

Inside = Callable[[Array], NDArray[np.bool_]]


@dataclass(frozen=True, eq=False)
class RegionSample:
    """Points that are uniform over a region, and others that share some factors with each of them.

    Attributes
    ----------
    names : tuple of k str
    points : (n, k) array
    one_anew, others_anew : list of k (n, k) array
        With the factor at that index drawn again, and with all others.
    orders : (n, k) array of int
        For each point an order of the factors.
    first_anew : list of k (n, k) array
        With the first factor of the order drawn again, the first two, ..., all.
    """

    names: tuple[str, ...]
    points: Array
    one_anew: list[Array]
    others_anew: list[Array]
    orders: NDArray[np.int64]
    first_anew: list[Array]


def region_sample(
    factors: Sequence[Factor], inside: Inside, count: int = POINTS, seed: int = SEED
) -> RegionSample | None:
    """Draw a sample of a part of the factors' box.

    Parameters
    ----------
    factors : sequence of k Factor
    inside : callable
        Function that returns which of points (n, k) are in the region.
    count, seed : int

    Returns
    -------
    RegionSample or None
        None if the region is too small a part of the box to be found.
    """
    rng = np.random.default_rng(seed)
    width = len(factors)

    def anew(points: Array, free: NDArray[np.bool_]) -> tuple[Array, NDArray[np.int64]]:
        """Draw the free factors of each point again; also return which were not found."""
        found, left = points.copy(), np.arange(len(points))
        for _ in range(TRIES):
            if not len(left):
                break
            drawn = np.where(
                free[left], _in_box(factors, rng.random((len(left), width))), points[left]
            )
            kept = inside(drawn)
            found[left[kept]] = drawn[kept]
            left = left[~kept]
        return found, left

    points, lost = anew(np.empty((count, width)), np.ones((count, width), dtype=bool))
    if 2 * len(lost) > count:
        return None
    points = np.delete(points, lost, axis=0)
    each = np.eye(width, dtype=bool)
    orders = rng.permuted(np.tile(np.arange(width), (len(points), 1)), axis=1)
    ranks = np.argsort(orders, axis=1)

    def section(free: NDArray[np.bool_]) -> Array:
        return anew(points, np.broadcast_to(free, points.shape))[0]

    return RegionSample(
        names=tuple(factor.name for factor in factors),
        points=points,
        one_anew=[section(row) for row in each],
        others_anew=[section(~row) for row in each],
        orders=orders,
        first_anew=[section(ranks <= place) for place in range(width)],
    )


def constrained_indices(model: Model, sample: RegionSample) -> SobolIndices | None:
    """Estimate Sobol indices and Shapley effects over a region.

    Parameters
    ----------
    model : callable
    sample : RegionSample

    Returns
    -------
    SobolIndices or None
        None for a response that does not vary. Estimates are uncertain by about 0.01.
    """
    values = model(sample.points)
    size = float(np.max(np.abs(values)))
    if float(np.ptp(values)) <= CONSTANT * size:
        return None
    values = values / size

    def halves(other: Array) -> Array:
        squares: Array = 0.5 * (values - model(other) / size) ** 2
        return squares

    variance = float(np.var(values))
    steps = np.diff([np.zeros(len(values)), *map(halves, sample.first_anew)], axis=0)
    credit = np.zeros(len(sample.names))
    for place, step in enumerate(steps):
        credit += np.bincount(sample.orders[:, place], step, len(credit))
    return SobolIndices(
        sample.names,
        tuple(1.0 - float(np.mean(halves(other))) / variance for other in sample.others_anew),
        tuple(float(np.mean(halves(other))) / variance for other in sample.one_anew),
        len(values),
        tuple((credit / np.sum(credit)).tolist()),
    )


def _in_box(factors: Sequence[Factor], places: Array) -> Array:
    """Values at positions 0 to 1 of each range; of a choice the corresponding label."""
    columns = [
        np.floor(column * len(factor.labels))
        if factor.labels
        else factor.lowest + column * (factor.highest - factor.lowest)
        for factor, column in zip(factors, places.T, strict=True)
    ]
    return np.column_stack(columns)
