"""Ordinary least squares and its statistics.

Finite element runs repeat exactly: there is no replication noise. The residuals of a fit are its
lack of fit, so standard errors, t and F values measure only that: how well the form follows
the code, not the certainty that a coefficient differs from zero. No significance is derived from them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError

Array = NDArray[np.float64]

# A column of the coded design matrix whose part outside the earlier columns is smaller than this
# share of it is no column of its own.
DEPENDENT_COLUMN = 1e-10
# A run of this leverage alone determines a coefficient: it cannot be predicted from the others.
FULL_LEVERAGE = 1.0 - 1e-9
# Share of new designs whose error a band holds, and how sure that is where there are enough designs.
COVERAGE, CONFIDENCE = 0.95, 0.90


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """The solution of an overdetermined linear system, whose first column is the constant 1.

    Attributes
    ----------
    coefficients : (p,) ndarray
        Least-squares coefficients of the columns.
    fitted, residuals : (n,) ndarray
        The fitted values, and the residuals.
    leverage : (n,) ndarray
        Diagonal of the hat matrix; 1 if a run alone determines a coefficient.
    covariance_factor : (p, p) ndarray
        Inverse of ``matrix.T @ matrix``.
    total_squares, residual_squares : float
        Sums of squares about the mean, and about the fit.
    variance_inflation : (p - 1,) ndarray
        Of the columns after the constant: 1 if a column is independent of the others, 1 / (1 -
        R2 of the column by the others) otherwise.
    condition_number : float
        Ratio of the matrix's largest and smallest singular value.
    """

    coefficients: Array
    fitted: Array
    residuals: Array
    leverage: Array
    covariance_factor: Array
    total_squares: float
    residual_squares: float
    variance_inflation: Array
    condition_number: float

    @property
    def runs(self) -> int:
        """Number n of rows."""
        return len(self.fitted)

    @property
    def degrees_of_freedom(self) -> int:
        """Rows minus number of coefficients, n - p."""
        return len(self.fitted) - len(self.coefficients)

    @property
    def residual_variance(self) -> float | None:
        """Residual sum of squares per degree of freedom; None if there is none left."""
        if self.degrees_of_freedom == 0:
            return None
        return self.residual_squares / self.degrees_of_freedom

    @property
    def covariance(self) -> Array | None:
        """Covariance of the coefficients (p, p); None without a degree of freedom."""
        variance = self.residual_variance
        return None if variance is None else variance * self.covariance_factor

    @property
    def standard_errors(self) -> Array | None:
        """Of the coefficients (p,); None without a degree of freedom."""
        covariance = self.covariance
        return None if covariance is None else np.sqrt(np.diag(covariance))

    @property
    def t_values(self) -> Array | None:
        """Coefficients over their standard errors (p,); None where these are None, or are 0."""
        errors = self.standard_errors
        return None if errors is None or not np.all(errors > 0.0) else self.coefficients / errors

    @property
    def f_value(self) -> float | None:
        """Explained over residual variance; None if nothing is left or nothing explains."""
        variance, explaining = self.residual_variance, len(self.coefficients) - 1
        if not variance or not explaining:
            return None
        return (self.total_squares - self.residual_squares) / explaining / variance

    @property
    def r_squared(self) -> float | None:
        """Explained share of the sum of squares; None for a constant y."""
        return (
            None if self.total_squares == 0.0 else 1.0 - self.residual_squares / self.total_squares
        )

    @property
    def adjusted_r_squared(self) -> float | None:
        """R2 adjusted for degrees of freedom; None without any left."""
        return adjusted(self.r_squared, self.runs, len(self.coefficients))

    @property
    def leave_one_out(self) -> Array | None:
        """Leave-one-out predictions (n,), by the fits to all others; None if a row cannot be left out."""
        if float(np.max(self.leverage)) >= FULL_LEVERAGE:
            return None
        return self.fitted + self.residuals - self.residuals / (1.0 - self.leverage)

    @property
    def press(self) -> float | None:
        """Sum of squares of the errors of `leave_one_out`."""
        if self.leave_one_out is None:
            return None
        return float(np.sum((self.residuals / (1.0 - self.leverage)) ** 2))

    @property
    def q_squared(self) -> float | None:
        """Share of the sum of squares that `leave_one_out` explains: 1 - PRESS / total."""
        press = self.press
        return (
            None if press is None or self.total_squares == 0.0 else 1.0 - press / self.total_squares
        )

    @property
    def aic(self) -> float | None:
        """Akaike's information criterion with normal residuals; None if the fit is exact."""
        likelihood = self._log_likelihood
        return None if likelihood is None else 2.0 * (len(self.coefficients) - likelihood)

    @property
    def bic(self) -> float | None:
        """Schwarz's information criterion; None if the fit is exact."""
        likelihood = self._log_likelihood
        if likelihood is None:
            return None
        return math.log(self.runs) * len(self.coefficients) - 2.0 * likelihood

    @property
    def _log_likelihood(self) -> float | None:
        if self.residual_squares == 0.0:
            return None
        per_run = self.residual_squares / self.runs
        return -0.5 * self.runs * (math.log(2.0 * math.pi * per_run) + 1.0)


def least_squares(matrix: Array, y: Array, column_names: Sequence[str]) -> LeastSquares:
    """Solve ``matrix @ coefficients = y`` by ordinary least squares (orthogonal factorization).

    Parameters
    ----------
    matrix : (n, p) ndarray
        One column per coefficient, the first of them 1 throughout.
    y : (n,) ndarray
    column_names : sequence of str
        For the message.

    Raises
    ------
    InputError
        If there are fewer rows than columns, or a column is a combination of earlier ones.
    """
    rows, columns = matrix.shape
    if rows < columns:
        raise InputError(
            f"runs: given {rows}; at least {columns} are needed, because the form has {columns} "
            "coefficients."
        )
    orthogonal, triangular = np.linalg.qr(matrix)
    own_part = np.abs(np.diag(triangular))
    length = np.linalg.norm(matrix, axis=0)
    dependent = np.flatnonzero(own_part <= DEPENDENT_COLUMN * length)
    if dependent.size:
        name = column_names[int(dependent[0])]
        raise InputError(
            f"runs: given {rows}, which do not determine the coefficient of {name}; more levels or "
            "combinations of its factors are needed, because the term follows from the others at "
            "these runs."
        )
    coefficients = np.linalg.solve(triangular, orthogonal.T @ y)
    inverse = np.linalg.solve(triangular, np.eye(columns))
    covariance_factor = inverse @ inverse.T
    fitted = matrix @ coefficients
    singular = np.linalg.svd(triangular, compute_uv=False)
    centered = matrix[:, 1:] - np.mean(matrix[:, 1:], axis=0)
    return LeastSquares(
        coefficients=coefficients,
        fitted=fitted,
        residuals=y - fitted,
        leverage=np.sum(orthogonal**2, axis=1),
        covariance_factor=covariance_factor,
        total_squares=float(np.sum((y - np.mean(y)) ** 2)),
        residual_squares=float(np.sum((y - fitted) ** 2)),
        variance_inflation=np.sum(centered**2, axis=0) * np.diag(covariance_factor)[1:],
        condition_number=float(singular[0] / singular[-1]),
    )


def adjusted(r_squared: float | None, runs: int, coefficients: int) -> float | None:
    """Return R2 adjusted for degrees of freedom; None without any left."""
    if r_squared is None or runs <= coefficients:
        return None
    return 1.0 - (1.0 - r_squared) * (runs - 1) / (runs - coefficients)


def coefficient_of_determination(values: Array, predicted: Array) -> float:
    """Return R squared, 1 - residual / total sum of squares; 1 if there is nothing to explain."""
    # Divided by the largest value first, because squares of a compliance may be denormal.
    size = float(np.max(np.abs(values)))
    centered = (values - np.mean(values)) / size
    total = float(np.sum(centered**2))
    if total <= len(values) * (4.0 * np.finfo(float).eps) ** 2:
        return 1.0
    residual = (values - predicted) / size
    return 1.0 - float(np.sum(residual**2)) / total


def tolerance_limit(errors: Array) -> float:
    """Return the error not exceeded by `COVERAGE` of new designs, with `CONFIDENCE`.

    The distribution-free limit (Wilks, Annals of Mathematical Statistics 12, 1941): the share of
    new errors below the r-th of n sorted ones has the distribution Beta(r, n - r + 1). It takes 45 errors;
    the largest of fewer is less certain, n / (n + 1) on average.

    Parameters
    ----------
    errors : (n,) ndarray
        Of designs similar to the new ones, at least one.

    Examples
    --------
    >>> [float(tolerance_limit(np.arange(n) + 1.0)) for n in (8, 45, 76, 77, 129, 500)]
    [8.0, 45.0, 76.0, 76.0, 127.0, 482.0]
    """
    number = len(errors)
    # Chance that so many of new errors, or fewer, are larger than the limit, one after the other.
    larger, chance, left = 0, 0.0, 1.0 - CONFIDENCE
    while larger < number:
        chance += math.exp(
            math.lgamma(number + 1)
            - math.lgamma(larger + 1)
            - math.lgamma(number - larger + 1)
            + larger * math.log(1.0 - COVERAGE)
            + (number - larger) * math.log(COVERAGE)
        )
        if chance > left:
            break
        larger += 1
    return float(np.sort(errors)[::-1][max(0, larger - 1)])
