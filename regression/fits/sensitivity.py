"""Effect of each factor on a response: elasticities at a point, Sobol indices over the ranges."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array, Flags, Integers
from crankbase.errors import InputError
from crankbase.even_points import sobol_sequence
from crankbase.results import Quantity, Result, result
from regression.plans.factors import Factor

# Factor values (n, k) [SI] to the response (n,).
Model = Callable[[Array], Array]

# Relative step of the difference quotients: their error is of the order of its square.
ELASTICITY_STEP = 1e-4
SOBOL_POINTS = 4096
# Of which the response's size is taken.
SIZE_POINTS = 256
SOBOL_SEED = 1
# A response that varies over the ranges by less than this share has nothing to share out.
CONSTANT = 1e-9


Shares = Annotated[Mapping[str, float], Quantity("1")]


@result("first", "total", "shapley")
class SobolIndices(Result):
    """Shares of a response's variance by factor, over the ranges or the part within the constraints."""

    # What a factor causes alone, Var E(y | x_i) / Var y; the rest several cause together.
    first: Shares
    # Alone and together with others, E Var(y | all but x_i) / Var y. Under constraints a factor also
    # contains information on others, and this may be less than the first.
    total: Shares
    # Of each of the samples that they are estimated from.
    points: int
    # Under constraints, the shares that add up to 1: means, over all orders in which the factors may become
    # known, of the reduction of variance by each. Without, they lie between first and total: not calculated.
    shapley: Shares | None = None


@result("elasticity", "sobol.first", "sobol.total")
class Sensitivities(Result):
    """Effect of each factor on a response, by its chosen equation."""

    # At which the elasticities are valid; of a category its label.
    nominal: Annotated[Mapping[str, float | str], Quantity(".units")]
    # d ln y / d ln p.
    elasticity: Shares
    # None for a response that does not vary, and if the constraints leave too little.
    sobol: SobolIndices | None
    units: Mapping[str, str]


def elasticities(model: Model, factors: Sequence[Factor], nominal: Sequence[float]) -> list[float]:
    """Elasticities d ln y / d ln p of the factors that are numbers: change of y in % for 1 % of p.

    By central differences of y over p times and by exp(1e-4), so a power of p gives its exponent within
    about 1e-8; the difference is divided by y at the nominal values, which may be negative. 0 for a
    factor whose nominal value is 0; `InputError` if the response is 0 there.
    """
    middle = np.asarray(nominal, dtype=np.float64)
    numbers = [place for place, factor in enumerate(factors) if not factor.labels]
    points = np.tile(middle, (2 * len(numbers) + 1, 1))
    for row, place in enumerate(numbers):
        points[2 * row + 1, place] *= math.exp(ELASTICITY_STEP)
        points[2 * row + 2, place] *= math.exp(-ELASTICITY_STEP)
    values = model(points)
    if not values[0]:
        raise InputError(
            "nominal: given factors at which the response is 0; allowed are others, because an "
            "elasticity is relative to the response."
        )
    ends = values[1:].reshape(-1, 2)
    slopes = (ends[:, 0] - ends[:, 1]) / (2.0 * math.sinh(ELASTICITY_STEP))
    return [float(slope) for slope in slopes / values[0]]


def nominal_values(factors: Sequence[Factor], base: Sequence[float | None]) -> list[float]:
    """Point at which elasticities are evaluated.

    The base throw's value of a factor if it is within its range, else the middle of the range; of a
    category the given label's index, else that of the first.
    """
    return [
        float(value)
        if value is not None and factor.lowest <= value <= factor.highest
        else (0.0 if factor.labels else 0.5 * (factor.lowest + factor.highest))
        for factor, value in zip(factors, base, strict=True)
    ]


def sobol_indices(
    model: Model, factors: Sequence[Factor], points: int = SOBOL_POINTS, seed: int = SOBOL_SEED
) -> SobolIndices | None:
    """Estimate Sobol indices of first and total order (Saltelli et al. 2010).

    None if y does not vary.

    Factors are uniform over their ranges, categories over their labels, independent of each other;
    under constraints use `constrained_indices`. Estimates are uncertain by about 0.01: a first index may
    be slightly below 0.
    """
    some = model(_in_box(factors, sobol_sequence(SIZE_POINTS, len(factors), seed)))
    size = float(np.max(np.abs(some)))
    if float(np.ptp(some)) <= CONSTANT * size:
        return None
    names = tuple(factor.name for factor in factors)
    if len(factors) == 1:  # all of the variance is its own
        return SobolIndices(dict.fromkeys(names, 1.0), dict.fromkeys(names, 1.0), points)
    start = np.random.default_rng(seed)
    halves = np.hsplit(sobol_sequence(points, 2 * len(factors), start, bits=64), 2)
    left, right = (_in_box(factors, half) for half in halves)
    # Compliances are so small that squares of them lose digits: divided by their size.
    at_left, at_right = model(left) / size, model(right) / size
    variance = float(np.var([at_left, at_right]))
    off_mean = at_right - np.mean([at_left, at_right])
    first, total = {}, {}
    for place, name in enumerate(names):
        mixed = left.copy()
        mixed[:, place] = right[:, place]
        change = model(mixed) / size - at_left
        first[name] = float(np.mean(off_mean * change)) / variance
        total[name] = 0.5 * float(np.mean(change**2)) / variance
    return SobolIndices(first, total, points)


# Points of each sample: an index is then uncertain by about 0.01.
POINTS, SEED = 32_768, 1
# Draws for a point at most; where a region is so small a part of its section, the point stays itself.
TRIES = 300

Inside = Callable[[Array], Flags]


@dataclass(frozen=True, eq=False)
class RegionSample:
    """Points (n, k) that are uniform over a region, and others that share some factors with each of them.

    `one_anew` and `others_anew` have the factor at each index drawn again, or all others; `orders` (n,
    k) an order of the factors for each point, and `first_anew` its first factor drawn again, the first
    two, ..., all.
    """

    names: tuple[str, ...]
    points: Array
    one_anew: list[Array]
    others_anew: list[Array]
    orders: Integers
    first_anew: list[Array]


def region_sample(
    factors: Sequence[Factor], inside: Inside, count: int = POINTS, seed: int = SEED
) -> RegionSample | None:
    """Draw a sample of the points (n, k) of the factors' box that are `inside`.

    None if they are too few to be found.
    """
    rng = np.random.default_rng(seed)
    width = len(factors)

    def anew(points: Array, free: Flags) -> tuple[Array, Integers]:
        """Draw the free factors of each point again; also return which were not found."""
        moved, left = points.copy(), np.arange(len(points))
        for _ in range(TRIES):
            if not len(left):
                break
            drawn = np.where(
                free[left], _in_box(factors, rng.random((len(left), width))), points[left]
            )
            kept = inside(drawn)
            moved[left[kept]] = drawn[kept]
            left = left[~kept]
        return moved, left

    points, lost = anew(np.empty((count, width)), np.ones((count, width), dtype=bool))
    if 2 * len(lost) > count:
        return None
    points = np.delete(points, lost, axis=0)
    each = np.eye(width, dtype=bool)
    orders = rng.permuted(np.tile(np.arange(width), (len(points), 1)), axis=1)
    ranks = np.argsort(orders, axis=1)

    def section(free: Flags) -> Array:
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
    """Estimate Sobol indices and Shapley effects over a region, as `sobol_indices`."""
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
        {
            name: 1.0 - float(np.mean(halves(other))) / variance
            for name, other in zip(sample.names, sample.others_anew, strict=True)
        },
        {
            name: float(np.mean(halves(other))) / variance
            for name, other in zip(sample.names, sample.one_anew, strict=True)
        },
        len(values),
        dict(zip(sample.names, (credit / np.sum(credit)).tolist(), strict=True)),
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
