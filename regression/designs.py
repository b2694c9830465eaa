"""Designs of experiments: which combinations of dimensions a study runs."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geometry.errors import InputError

# A study of more finite element runs than this is a slip of the pen.
LARGEST_DESIGN = 1_000_000
# Latin hypercubes tried, of which the one with the largest smallest distance is taken.
TRIES = 400


@dataclass(frozen=True, eq=False)
class Design:
    """A table of runs.

    Parameters
    ----------
    factors : tuple of str
        Names of the k varied dimensions.
    runs : (n, k) ndarray
        One run a row, in the factors' units; read-only.
    kind : str
        "full factorial" or "latin hypercube".
    seed : int or None
        What the design was drawn with; None where nothing is random.
    """

    factors: tuple[str, ...]
    runs: NDArray[np.float64]
    kind: str
    seed: int | None

    def __post_init__(self) -> None:
        runs = np.array(self.runs, dtype=np.float64)
        runs.flags.writeable = False
        object.__setattr__(self, "runs", runs)

    def __len__(self) -> int:
        return int(self.runs.shape[0])

    def as_dicts(self) -> list[dict[str, float]]:
        """Return each run as a mapping of factor to value."""
        return [dict(zip(self.factors, row, strict=True)) for row in self.runs.tolist()]


def full_factorial(levels: Mapping[str, Sequence[float]]) -> Design:
    """Every combination of the given levels, the last factor varying fastest.

    Parameters
    ----------
    levels : mapping
        Factor name to its levels, each level once.

    Returns
    -------
    Design
        With the product of the numbers of levels as number of runs.

    Raises
    ------
    InputError
        If there is no factor, a factor has no level, a level is not finite or stands twice, or
        the design would be larger than `LARGEST_DESIGN`.

    Examples
    --------
    >>> full_factorial({"web_width": [0.27, 0.33], "pin_length": [0.12, 0.14]}).runs.tolist()
    [[0.27, 0.12], [0.27, 0.14], [0.33, 0.12], [0.33, 0.14]]
    """
    _check_factors(levels)
    for name, values in levels.items():
        if len(values) == 0:
            raise InputError(f"{name}: given no level; at least one value is needed.")
        for value in values:
            _check_finite(name, value)
        if len(set(values)) != len(values):
            raise InputError(
                f"{name}: given {list(values)}; each level may stand once, because repeated finite "
                "element runs give the same result."
            )
    number = math.prod(len(values) for values in levels.values())
    _check_size(number)
    runs = np.array(list(itertools.product(*levels.values())), dtype=np.float64)
    return Design(tuple(levels), runs, "full factorial", None)


def latin_hypercube(ranges: Mapping[str, tuple[float, float]], runs: int, seed: int) -> Design:
    """Spread runs over a box: each range cut into equal strata, one run in each stratum.

    Of `TRIES` random hypercubes the one is taken whose nearest two runs are farthest apart
    (maximin distance in the box scaled to the unit cube).

    Parameters
    ----------
    ranges : mapping
        Factor name to its lowest and highest value.
    runs : int
        Number of runs n, 1 or more.
    seed : int
        Seed of the random numbers, 0 or more; the same seed gives the same design.

    Returns
    -------
    Design
        All runs lie inside the ranges.

    Raises
    ------
    InputError
        If there is no factor, a range is empty or not finite, or `runs` or `seed` cannot be used.
    """
    _check_factors(ranges)
    for name, bounds in ranges.items():
        low, high = bounds
        _check_finite(name, low)
        _check_finite(name, high)
        if not low < high:
            raise InputError(
                f"{name}: given the range {low:g} to {high:g}; the lowest value must lie below the "
                "highest, or the factor does not vary."
            )
    if isinstance(runs, bool) or not isinstance(runs, int) or runs < 1:
        raise InputError(f"runs: given {runs!r}; allowed is a whole number from 1, one per run.")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(
            f"seed: given {seed!r}; allowed is a whole number from 0, which makes the design "
            "repeatable."
        )
    _check_size(runs)
    unit = _maximin_unit_cube(runs, len(ranges), seed)
    bounds_array = np.array(list(ranges.values()), dtype=np.float64)
    low_row, high_row = bounds_array[:, 0], bounds_array[:, 1]
    return Design(tuple(ranges), low_row + unit * (high_row - low_row), "latin hypercube", seed)


def _maximin_unit_cube(runs: int, factors: int, seed: int) -> NDArray[np.float64]:
    generator = np.random.default_rng(seed)
    best = _random_hypercube(generator, runs, factors)
    if runs == 1 or factors == 1:
        return best
    best_distance = _smallest_distance(best)
    for _ in range(TRIES - 1):
        candidate = _random_hypercube(generator, runs, factors)
        distance = _smallest_distance(candidate)
        if distance > best_distance:
            best, best_distance = candidate, distance
    return best


def _random_hypercube(
    generator: np.random.Generator, runs: int, factors: int
) -> NDArray[np.float64]:
    strata = np.column_stack([generator.permutation(runs) for _ in range(factors)])
    return (strata + generator.random((runs, factors))) / runs


def _smallest_distance(points: NDArray[np.float64]) -> float:
    distances, _ = cKDTree(points).query(points, k=[2])
    return float(np.min(distances))


def _check_factors(factors: Mapping[str, object]) -> None:
    if not factors:
        raise InputError("factors: given none; at least one dimension must vary in a study.")


def _check_finite(name: str, value: float) -> None:
    if not math.isfinite(value):
        raise InputError(f"{name}: given {value!r}; allowed is a finite number.")


def _check_size(number: int) -> None:
    if number > LARGEST_DESIGN:
        raise InputError(
            f"runs: given {number}; allowed are at most {LARGEST_DESIGN}, because each is a finite "
            "element run."
        )
