"""Selection of the terms of a form, and of the form.

Terms are dropped backward: as long as the fit without some term has a leave-one-out sum of squares
(PRESS) that is no greater than the fit with it, the term is dropped that leaves the smallest PRESS.
Hierarchy is kept: a term stays while another contains it, h^2 while there is B h^2. Terms of the
first degree always stay: lack of fit elsewhere may hide the effect of a factor, and an equation
without the factor would be wrong about it.

The form is chosen by designs held out of all fits: of the forms whose largest held-out error is
within a tenth of the smallest, or no more above it than the finite elements scatter from design to
design, the one with the fewest coefficients. Since this error selected the form, it is slightly
optimistic: with ten forms and the few held-out designs of a study the true error is, over
new designs, somewhat larger.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.results import Number, Quantity, Result, result
from regression.fits.forms import DEPENDENT_COLUMN, Basis, Term, divisors

# A run of this leverage alone determines a coefficient: it cannot be predicted from the others.
FULL_LEVERAGE = 1.0 - 1e-9
# Share of new designs whose error a band holds, and how sure that is where there are enough designs.
COVERAGE, CONFIDENCE = 0.95, 0.90


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """The solution of an overdetermined linear system (n, p), whose first column is that of the constant.

    Attributes
    ----------
    leverage : (n,) ndarray
        Diagonal of the hat matrix; 1 if a run alone determines a coefficient.
    covariance_factor : (p, p) ndarray
        Inverse of ``matrix.T @ matrix``.
    total_squares, residual_squares : float
        Sums of squares about the constant alone, and about the fit.
    variance_inflation : (p - 1,) ndarray
        Of the columns after the constant: 1 / (1 - R2 of the column by the others).
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

    The first of the matrix's (n, p) columns is that of the constant, 1 for values and 0 for slopes; the
    names are for messages.

    Raises
    ------
    InputError
        If a column is a combination of earlier ones.
    """
    rows, columns = matrix.shape
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
    # About the constant alone, which is the mean if there are no slopes.
    constant = matrix[:, :1]
    columns_and_y = np.column_stack([matrix[:, 1:], y])
    shares = np.sum(constant * columns_and_y, axis=0) / np.sum(constant)
    centered = columns_and_y - constant * shares
    return LeastSquares(
        coefficients=coefficients,
        fitted=fitted,
        residuals=y - fitted,
        leverage=np.sum(orthogonal**2, axis=1),
        covariance_factor=covariance_factor,
        total_squares=float(np.sum(centered[:, -1] ** 2)),
        residual_squares=float(np.sum((y - fitted) ** 2)),
        variance_inflation=np.sum(centered[:, :-1] ** 2, axis=0) * np.diag(covariance_factor)[1:],
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
    """Error (of n) not exceeded by `COVERAGE` of new designs, with `CONFIDENCE`.

    The distribution-free limit (Wilks, Annals of Mathematical Statistics 12, 1941): the share of new
    errors below the r-th of n sorted ones has the distribution Beta(r, n - r + 1). It takes 45 errors;
    the largest of fewer is less certain, n / (n + 1) on average.

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


# Forms whose largest held-out error is within this share of the smallest count as equally good.
PARSIMONY = 0.10


def backward(matrix: Array, y: Array, terms: Sequence[Term]) -> tuple[list[int], list[int]]:
    """Drop the terms without which PRESS does not grow: of a matrix (n, p) of full rank, for y (n,).

    Returns the indices of the terms that stay, in order, and of those dropped, in the order of their
    removal. Nothing is dropped if no fit with one term less has a finite PRESS.
    """
    dropped: list[int] = []
    whole = np.asarray(np.linalg.pinv(matrix), dtype=np.float64)
    _drop(whole[None], matrix, y, terms, np.zeros((1, 0), dtype=int), dropped)
    return [place for place in range(len(terms)) if place not in dropped], dropped


def left_out_predictions(
    matrix: Array, y: Array, terms: Sequence[Term], groups: NDArray[np.intp] | None = None
) -> Array | None:
    """Predict every run (n,) by the fit to all others, whose terms are selected without it, as by `backward`.

    None if some run alone determines a coefficient of the form before the selection. A run may have several
    rows, its group (n, r), the first of which is predicted; by default it is a row.
    """
    runs = len(y)
    if groups is not None and groups.shape[1] > 1:
        staying = np.ones((len(groups), runs, 1))
        staying[np.arange(len(groups))[:, None], groups] = 0.0
        others = matrix * staying
        if np.linalg.matrix_rank(others).min() < len(terms):
            return None
        inverses = np.asarray(np.linalg.pinv(others), dtype=np.float64)
        inverses = _drop(inverses, matrix, y, terms, groups)
        first: Array = np.einsum("ip,ipn,n->i", matrix[groups[:, 0]], inverses, y, optimize=True)
        return first
    whole = np.asarray(np.linalg.pinv(matrix), dtype=np.float64)
    leverage = np.sum(matrix * whole.T, axis=1)
    if runs <= len(terms) or float(np.max(leverage)) >= FULL_LEVERAGE:
        return None
    # Without run i, by the formula of Sherman and Morrison: (A'A - a a')^-1 and with it the pseudoinverse.
    influence = (whole @ whole.T @ matrix.T).T  # (n, p): (A'A)^-1 a of every run
    mixed = (matrix @ whole) / (1.0 - leverage)[:, None]
    inverses = whole[None] + influence[:, :, None] * mixed[:, None, :]
    inverses[np.arange(runs), :, np.arange(runs)] = 0.0
    inverses = _drop(inverses, matrix, y, terms, np.arange(runs)[:, None])
    predicted: Array = np.einsum("ip,ipn,n->i", matrix, inverses, y, optimize=True)
    return predicted


# Without column j the hat matrix loses v v^T, where v is the unit vector along row j of the pseudoinverse: it
# is in the space of all columns and orthogonal to the others. So residuals, leverages and the pseudoinverse
# follow from those before.
def _drop(
    inverses: Array,
    matrix: Array,
    y: Array,
    terms: Sequence[Term],
    left_out: NDArray[np.intp],
    dropped: list[int] | None = None,
) -> Array:
    """Drop terms of m fits of one form simultaneously, each to other runs: their pseudoinverses (m, p, n)."""
    fits = len(inverses)
    taking_part = np.ones((fits, len(y)))
    np.put_along_axis(taking_part, left_out, 0.0, axis=1)
    residuals = taking_part * (y - (inverses @ y) @ matrix.T)
    leverage = np.einsum("np,mpn->mn", matrix, inverses)
    proper = [divisors(term) for term in terms]
    divides = np.array([[divisor in known for known in proper] for divisor in terms])
    high = np.array([len(term) > 1 for term in terms])
    kept = np.ones((fits, len(terms)), dtype=bool)
    press = _press(residuals, 1.0 - leverage)
    active = np.arange(fits)
    while active.size:
        # Hierarchy: what divides another kept term stays.
        may_go = kept[active] & high & ~(kept[active] @ divides.T)
        places = np.flatnonzero(may_go.any(axis=0))
        if not places.size:
            break
        rows = inverses[np.ix_(active, places)]
        length = np.linalg.norm(rows, axis=2, keepdims=True)
        unit = rows / np.where(length > 0.0, length, 1.0)
        without = residuals[active, None] + unit * (unit @ y)[..., None]
        errors = _press(without, 1.0 - leverage[active, None] + unit**2)
        errors[~may_go[:, places]] = np.inf
        best = np.argmin(errors, axis=1)
        smallest = errors[np.arange(len(active)), best]
        going = np.flatnonzero(np.isfinite(smallest) & (smallest <= press[active]))
        active, best = active[going], best[going]
        press[active] = smallest[going]
        gone, direction = places[best], unit[going, best]
        kept[active, gone] = False
        residuals[active] = without[going, best]
        leverage[active] -= direction**2
        shares = np.einsum("mpn,mn->mp", inverses[active], direction)
        inverses[active] -= shares[:, :, None] * direction[:, None, :]
        inverses[active, gone] = 0.0
        if dropped is not None and active.size:
            dropped.append(int(gone[0]))
    return inverses


def _press(residuals: Array, left: Array) -> Array:
    """PRESS along the last axis, infinite where a run cannot be left out."""
    possible = np.all(left > 1.0 - FULL_LEVERAGE, axis=-1)
    squares = np.sum((residuals / np.where(possible[..., None], left, 1.0)) ** 2, axis=-1)
    return np.where(possible, squares, np.inf)


Figure = Annotated[float | None, Quantity("1")]


@result("form", "coefficient_count", "largest_error", "largest_heldout_error", "q_squared")
class FitErrors(Result):
    """A fitted form and its errors, relative to the true response: 0.01 for 1 %."""

    form: str
    # Whether the columns are a study's factors or dimensionless groups.
    basis: Basis
    coefficient_count: int
    # Of the response itself at the runs, also for a form in logarithms; 1 for a constant response.
    r_squared: Number
    # None without degrees of freedom.
    adjusted_r_squared: Figure
    # Leave-one-out Q2 = 1 - PRESS / total sum of squares, of the response itself. Each run is left out of
    # the selection of the terms too, except in large studies, where one run of hundreds hardly changes it.
    # None if a single run determines a coefficient before the selection.
    q_squared: Figure
    largest_error: Annotated[float, Quantity("1", "at the runs", key="largest_error_at_runs")]
    mean_error: Annotated[float, Quantity("1", "at the runs", key="mean_error_at_runs")]
    # None without held-out designs.
    largest_heldout_error: Annotated[float | None, Quantity("1", key="largest_error_held_out")]
    mean_heldout_error: Annotated[float | None, Quantity("1", key="mean_error_held_out")]
    # Not exceeded by 95 % of new designs (`tolerance_limit`), by so many: of the
    # runs, each left out in turn, and of the held-out designs, the larger; None without either.
    band_error: Figure
    band_designs: int
    # Terms that the runs' levels do not determine, and those without which PRESS did not grow.
    undetermined: tuple[str, ...]
    dropped: tuple[str, ...]


@dataclass(frozen=True)
class Choice:
    """The index of the selected fit, and the reason in one sentence."""

    place: int
    reason: str


def choose(fits: Sequence[FitErrors], scatter: float = 0.0) -> Choice:
    """Choose a fit by its held-out error, with parsimony.

    Errors that differ by less than `scatter`, that of the finite element values from design to design,
    count as equal. Of fits with equally small errors and equally few coefficients that of the smallest
    error is taken, of those whose errors are the same to three digits the first. `InputError` without
    fits judged by held-out designs.
    """
    if not fits:
        raise InputError("fits: given none; at least one is needed to choose from.")
    errors: list[float] = []
    for fit in fits:
        if fit.largest_heldout_error is None:
            raise InputError(
                f"fits: given a {fit.form} fit without held-out designs; all must have them, "
                "because errors at the fitted runs do not show the error between them."
            )
        errors.append(fit.largest_heldout_error)
    smallest = min(errors)
    limit = max((1.0 + PARSIMONY) * smallest, smallest + scatter)
    equal = [place for place, error in enumerate(errors) if error <= limit]
    # Three digits of the error: forms that are the same in other words differ by rounding alone.
    taken = min(
        equal,
        key=lambda place: (fits[place].coefficient_count, float(f"{errors[place]:.2e}"), place),
    )
    return Choice(taken, _reason(fits, errors, taken, len(equal), scatter))


def _reason(
    fits: Sequence[FitErrors], errors: Sequence[float], taken: int, equal: int, scatter: float
) -> str:
    best = int(np.argmin(errors))
    name, count = fits[taken].form, fits[taken].coefficient_count
    share = f"{100.0 * PARSIMONY:.0f} %"
    if equal == 1:
        return (
            f"{name} has the smallest largest error at the held-out designs, "
            f"{_percent(errors[taken])}, and no other form comes within {share} of it."
        )
    margin = f"within {share} of the smallest"
    if scatter:
        margin += f", or no more above it than the finite elements' scatter of {_percent(scatter)}"
    smallest = (
        "the smallest"
        if _percent(errors[taken]) == _percent(errors[best])
        else f"the smallest is {_percent(errors[best])} of {fits[best].form} with "
        f"{fits[best].coefficient_count} coefficients"
    )
    return (
        f"{name} has the fewest coefficients, {count}, of the {equal} forms whose largest error at "
        f"the held-out designs is {margin}; its own is {_percent(errors[taken])}, {smallest}."
    )


def _percent(value: float) -> str:
    return f"{100.0 * value:.3g} %"
