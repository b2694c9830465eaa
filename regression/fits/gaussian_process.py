"""Gaussian processes through values and slopes of a function: kriging with derivatives.

About a mean that is linear in the coded columns the function varies as a Gaussian process with a
squared-exponential covariance, one length scale for each column. A derivative of a Gaussian process is one
too, and its covariances are derivatives of that of the values, so slopes are further rows. Length scales and
noises are those of the largest restricted likelihood. Source: Rasmussen and Williams, Gaussian Processes for
Machine Learning (2006), 2.3 (prediction), 2.7 (a mean of unknown coefficients), 5.4.1 (gradient), 9.4
(derivatives); for rows left out together Dubrule, Mathematical Geology 15 (1983).

With d = (z - z') / l and the directions of slopes u and u', divided by l as well, the covariances are
exp(-|d|^2 / 2) times

    value, value': 1    value, slope': u' d    slope, value': -u d    slope, slope': u u' - (u d)(u' d)

which is (v - u d)(v' + u' d) + u u', where v is 1 for a value, whose u is 0, and 0 for a slope.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array
from crankbase.errors import InputError

# Every row is kept, and a standard deviation needs the square of their number.
MOST_ROWS = 1000
# The likelihood is that of so many rows at most, of runs spread over all.
ROWS_OF_LIKELIHOOD = 400
# Of length scales, in halves of a column's range, and of noises, as shares of the process's variance.
SCALE_BOUNDS, NOISE_BOUNDS = (0.2, 50.0), (1e-9, 1.0)
# Length scales and noises from which the search starts.
STARTS = ((1.0, 1e-3), (4.0, 1e-6))
# Points at which it is evaluated at a time.
PIECE = 1024
# Share of the squares fitted that is round-off.
ROUND_OFF = 1e-24
# A run without which less than this share is left determines the mean alone.
UNDETERMINED = 1e-12
# Standard deviations that hold 95 % of a normal distribution.
NORMAL = 1.96


@dataclass(frozen=True, eq=False)
class Rows:
    """So many values at coded points (n, k), and then slopes there in directions (n, k), 0 for values."""

    points: Array
    directions: Array
    values: int

    @classmethod
    def at(cls, points: Array) -> "Rows":
        """Return values alone."""
        return cls(points, np.zeros(points.shape), len(points))

    def with_slopes(self, runs: NDArray[np.intp], directions: Array) -> "Rows":
        """Return these values and slopes (r, k) at some of their points (r,)."""
        return Rows(
            np.vstack([self.points, self.points[runs]]),
            np.vstack([self.directions, directions]),
            self.values,
        )

    @property
    def is_value(self) -> Array:
        """1 for each value, 0 for each slope."""
        return np.array(np.arange(len(self.points)) < self.values, dtype=np.float64)

    @property
    def mean_terms(self) -> Array:
        """Terms of the mean (n, 1 + k): constant and columns."""
        return np.column_stack(
            [self.is_value, self.is_value[:, None] * self.points + self.directions]
        )

    def chosen(self, places: NDArray[np.intp]) -> "Rows":
        """Return the rows at some places, in rising order."""
        values = int(np.sum(places < self.values))
        return Rows(self.points[places], self.directions[places], values)


def _parts(first: Rows, second: Rows, scales: Array) -> tuple[Array, Array, Array, Array]:
    """Return exp(-|d|^2 / 2), v - u d, v' + u' d and u u', each (n, m)."""
    p, q = first.points / scales, second.points / scales
    u, w = first.directions / scales, second.directions / scales
    squares = np.sum(p * p, 1)[:, None] + np.sum(q * q, 1) - 2.0 * p @ q.T
    left = (first.is_value - np.sum(u * p, 1))[:, None] + u @ q.T
    return np.exp(-0.5 * squares), left, second.is_value - np.sum(w * q, 1) + p @ w.T, u @ w.T


def correlations(first: Rows, second: Rows, scales: Array) -> Array:
    """Return the covariances (n, m) of rows by a process of the variance 1; points may be complex."""
    bell, left, right, crossed = _parts(first, second, scales)
    product: Array = bell * (left * right + crossed)
    return product


def correlation_slopes(rows: Rows, scales: Array, weights: Array) -> list[float]:
    """Sum symmetric weights (n, n) times the derivatives of `correlations` over ln of each length scale."""
    bell, left, right, crossed = _parts(rows, rows, scales)
    bell = weights * bell
    product = bell * (left * right + crossed)
    sums = []
    for p, u in zip((rows.points / scales).T, (rows.directions / scales).T, strict=True):
        d, along = p[:, None] - p, u[:, None]
        change = along * d * right - left * u * d - along * u
        sums.append(float(np.sum(product * d * d) + 2.0 * np.sum(bell * change)))
    return sums


@dataclass(frozen=True, eq=False)
class Kriging:
    """A process conditioned on rows y (n,): scales (k,) and noises, of values and of slopes.

    Covariances are those of a process of the variance 1.
    """

    rows: Rows
    scales: Array
    noises: Sequence[float]

    @cached_property
    def _root(self) -> Array:
        """Inverse of the lower root of the rows' covariance."""
        noise = np.where(self.rows.is_value, *self.noises)
        whole = correlations(self.rows, self.rows, self.scales) + np.diag(noise)
        return np.linalg.inv(np.linalg.cholesky(whole))

    @cached_property
    def _mean(self) -> tuple[Array, Array]:
        """Terms of the mean by the root (n, p), and covariance of their coefficients (p, p)."""
        turned = self._root @ self.rows.mean_terms
        return turned, np.asarray(np.linalg.inv(turned.T @ turned), dtype=np.float64)

    @cached_property
    def projected(self) -> Array:
        """Inverse of the rows' covariance as far as the mean explains nothing (n, n); times y the weights."""
        turned, covariance = self._mean
        return self._root.T @ (np.eye(len(turned)) - turned @ covariance @ turned.T) @ self._root

    def coefficients(self, y: Array) -> Array:
        """Return the coefficients of the mean (1 + k,)."""
        turned, covariance = self._mean
        found: Array = covariance @ turned.T @ self._root @ y
        return found

    def variance(self, y: Array) -> float:
        """Return the variance of the process by the restricted likelihood."""
        freedom = len(y) - self.rows.points.shape[1] - 1
        squares = max(float(y @ self.projected @ y), ROUND_OFF * float(y @ y), np.finfo(float).tiny)
        return float(squares / max(freedom, 1))

    def misfit(self, y: Array) -> tuple[float, Array]:
        """Return -2 ln(restricted likelihood), and its derivatives over ln of length scales and noises."""
        variance, weights, is_value = self.variance(y), self.projected @ y, self.rows.is_value
        value = (len(y) - len(self._mean[1])) * math.log(variance)
        value -= 2.0 * float(np.sum(np.log(np.diag(self._root))))
        value -= float(np.linalg.slogdet(self._mean[1])[1])
        change = self.projected - np.outer(weights, weights) / variance
        noises = np.array([is_value, 1.0 - is_value]) @ np.diag(change) * self.noises
        return value, np.array([*correlation_slopes(self.rows, self.scales, change), *noises])

    def covariance(self, at: Rows) -> Array:
        """Return the covariance (m, m) of other values and slopes."""
        known = correlations(at, self.rows, self.scales) @ self._root.T
        turned, covariance = self._mean
        rest = at.mean_terms - known @ turned
        prior = correlations(at, at, self.scales)
        return prior - known @ known.T + rest @ covariance @ rest.T

    def variances(self, points: Array) -> Array:
        """Return the variances (m,) of new values, with their noise, at coded points (m, k)."""
        own = np.diag(self.covariance(Rows.at(points)))
        return np.asarray(np.maximum(own, 0.0) + self.noises[0])

    def left_out(self, y: Array, groups: NDArray[np.intp]) -> tuple[Array, Array] | None:
        """Predict the first row of each group (n, r) by all others; also return its standard deviation.

        None if the mean is not determined without some group.
        """
        weights, predicted, variances = self.projected @ y, [], []
        for group in groups:
            own = np.r_[group[0], np.setdiff1d(group, group[0])]
            block = self.projected[np.ix_(own, own)]
            if np.linalg.eigvalsh(block)[0] <= UNDETERMINED * np.sum(self._root[:, own] ** 2):
                return None
            inverse = np.linalg.inv(block)
            predicted.append(y[group[0]] - inverse[0] @ weights[own])
            variances.append(inverse[0, 0])
        return np.array(predicted), np.sqrt(self.variance(y) * np.array(variances))


def _in_pieces(
    function: Callable[[NDArray[Any]], NDArray[Any]], coded: NDArray[Any]
) -> NDArray[Any]:
    """Return a function of points (m, k) at coded columns (..., k): (...) array."""
    flat = coded.reshape(-1, coded.shape[-1])
    pieces = [function(flat[start : start + PIECE]) for start in range(0, max(len(flat), 1), PIECE)]
    return np.concatenate(pieces).reshape(coded.shape[:-1])


@dataclass(frozen=True)
class GaussianProcess:
    """What a Gaussian process adds to the linear mean of an equation in k coded columns.

    Attributes
    ----------
    points, directions : tuple of k-tuples
        Of each of the n rows: coded columns of the run, and the slope's direction, as weighed in the fit;
        zeros for a value.
    values : int
        So many rows are values; slopes follow.
    scales : k-tuple
        Length scales in coded columns, that is in halves of the runs' ranges.
    variance : float
        Of the process, in squares of the response or of its logarithm.
    noises : tuple
        Variances of the errors of values, and of weighed slopes, as shares of `variance`.
    weights : n-tuple
        Of the covariances with the rows in a prediction.
    band : float
        So many of its standard deviations hold 95 % of designs that were not fitted.
    """

    points: tuple[tuple[float, ...], ...]
    directions: tuple[tuple[float, ...], ...]
    values: int
    scales: tuple[float, ...]
    variance: float
    noises: tuple[float, float]
    weights: tuple[float, ...]
    band: float = NORMAL

    @cached_property
    def kriging(self) -> Kriging:
        """The process conditioned on its rows."""
        rows = Rows(np.array(self.points), np.array(self.directions), self.values)
        return Kriging(rows, np.array(self.scales), self.noises)

    def predict(self, coded: NDArray[Any]) -> NDArray[Any]:
        """Return what it adds to the mean at coded columns (..., k), which may be complex: (...) array."""

        def added(points: NDArray[Any]) -> NDArray[Any]:
            shared = correlations(Rows.at(points), self.kriging.rows, self.kriging.scales)
            return np.asarray(shared @ self.weights)

        return _in_pieces(added, coded)

    def deviations(self, coded: Array) -> Array:
        """Return the standard deviations (...) of new values at coded columns (..., k)."""
        return np.sqrt(self.variance * _in_pieces(self.kriging.variances, coded))


def likeliest(rows: Rows, y: Array, groups: NDArray[np.intp]) -> Kriging:
    """Find length scales and noises of the largest likelihood; `groups` (n, r) has the rows of each run.

    `InputError` for more than `MOST_ROWS`.
    """
    from scipy.optimize import Bounds, minimize

    if len(y) > MOST_ROWS:
        raise InputError(
            f"runs: given {len(y)} values and slopes; allowed are up to {MOST_ROWS} for a Gaussian process, "
            "because it keeps each and the squares of their number take minutes: use another form."
        )
    used = np.unique(groups[:: math.ceil(len(y) / ROWS_OF_LIKELIHOOD)])
    seen, columns = rows.chosen(used), rows.points.shape[1]

    def misfit(place: Array) -> tuple[float, Array]:
        sizes = np.exp(place)
        return Kriging(seen, sizes[:columns], sizes[columns:].tolist()).misfit(y[used])

    searches = [
        minimize(
            misfit,
            np.log([scale] * columns + [noise] * 2),
            jac=True,
            method="L-BFGS-B",
            bounds=Bounds(*np.log([SCALE_BOUNDS] * columns + [NOISE_BOUNDS] * 2).T),
        )
        for scale, noise in STARTS
    ]
    sizes = np.exp(min(searches, key=lambda search: float(search.fun)).x)
    return Kriging(rows, sizes[:columns], tuple(sizes[columns:].tolist()))


def process_of(kriging: Kriging, y: Array) -> GaussianProcess:
    """Return the process that rows (n,) of values and slopes leave."""
    rows = kriging.rows
    return GaussianProcess(
        points=tuple(map(tuple, rows.points.tolist())),
        directions=tuple(map(tuple, rows.directions.tolist())),
        values=rows.values,
        scales=tuple(kriging.scales.tolist()),
        variance=kriging.variance(y),
        noises=(kriging.noises[0], kriging.noises[1]),
        weights=tuple((kriging.projected @ y).tolist()),
    )
