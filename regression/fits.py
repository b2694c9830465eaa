"""Least-squares fits of a response over a design, and how far each fit can be trusted.

Finite element runs repeat exactly, so there is no replication noise: the residuals are lack of
fit, and t and F values would only measure that. Leave-one-out on a coarse grid does not see the
error between its levels either. A fit is therefore judged by held-out designs spread over the box.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.errors import InputError
from regression.forms import (
    FittedForm,
    code,
    design_matrix,
    form_named,
    form_terms,
    term_name,
)

# A column of the coded design matrix whose part outside the earlier columns is smaller than this
# share of it is no column of its own.
_DEPENDENT_COLUMN = 1e-10
# A run of this leverage alone determines a coefficient: it cannot be predicted from the others.
_FULL_LEVERAGE = 1.0 - 1e-9


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """The solution of an overdetermined linear system.

    Parameters
    ----------
    coefficients : (p,) ndarray
        Least-squares coefficients of the columns.
    fitted : (n,) ndarray
        The fitted values.
    leverage : (n,) ndarray
        Diagonal of the hat matrix.
    """

    coefficients: NDArray[np.float64]
    fitted: NDArray[np.float64]
    leverage: NDArray[np.float64]


def least_squares(
    matrix: NDArray[np.float64], y: NDArray[np.float64], column_names: Sequence[str]
) -> LeastSquares:
    """Solve ``matrix @ coefficients = y`` by ordinary least squares (orthogonal factorization).

    Parameters
    ----------
    matrix : (n, p) ndarray
        One column per coefficient.
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
    dependent = np.flatnonzero(own_part <= _DEPENDENT_COLUMN * length)
    if dependent.size:
        name = column_names[int(dependent[0])]
        raise InputError(
            f"runs: given {rows}, which do not determine the coefficient of {name}; more levels or "
            "combinations of its factors are needed, because the term follows from the others at "
            "these runs."
        )
    coefficients = np.linalg.solve(triangular, orthogonal.T @ y)
    return LeastSquares(coefficients, matrix @ coefficients, np.sum(orthogonal**2, axis=1))


@dataclass(frozen=True)
class Fit:
    """A fitted form and its errors. Errors are relative to the true response, 0.01 for 1 %.

    Parameters
    ----------
    fitted : FittedForm
        The equation.
    r_squared : float
        R2 of the response itself at the runs, for the log form too; 1 for a constant response.
    q_squared : float or None
        Leave-one-out Q2 = 1 - PRESS / total sum of squares, of the response itself; None if some
        run alone determines a coefficient (as with as many runs as coefficients).
    largest_error, mean_error : float
        At the runs.
    largest_heldout_error, mean_heldout_error : float or None
        At the held-out designs; None if there were none.
    runs, heldout_runs : int
        Numbers of runs fitted and held out.
    """

    fitted: FittedForm
    r_squared: float
    q_squared: float | None
    largest_error: float
    mean_error: float
    largest_heldout_error: float | None
    mean_heldout_error: float | None
    runs: int
    heldout_runs: int

    @property
    def form(self) -> str:
        """Name of the form."""
        return self.fitted.form

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of the factors."""
        return self.fitted.factors

    @property
    def coefficients(self) -> dict[str, float]:
        """Natural coefficients (SI units) by the name of their term, such as "web_width^2"."""
        return {
            term_name(term, self.factors, self.fitted.logarithmic): value
            for term, value in self.fitted.natural_coefficients().items()
        }

    def predict(self, x: ArrayLike) -> NDArray[np.float64]:
        """Evaluate at points (..., k); see `FittedForm.predict`."""
        return self.fitted.predict(x)


def fit_form(
    form: str,
    factors: Sequence[str],
    x: ArrayLike,
    y: ArrayLike,
    heldout_x: ArrayLike | None = None,
    heldout_y: ArrayLike | None = None,
) -> Fit:
    """Fit one form to a response by ordinary least squares.

    Parameters
    ----------
    form : {"linear", "quadratic", "log-quadratic"}
        Constant and factors; these with all squares and products; the same in logarithms (of the
        factors and of the response, whose squares of ln y are then the smallest).
    factors : sequence of str
        Names of the k factors.
    x, heldout_x : (n, k), (m, k) array_like
        Runs to fit, and runs to judge by.
    y, heldout_y : (n,), (m,) array_like
        The response; no value 0, for errors are relative.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        If the shapes do not fit, a number is not finite, there are fewer runs than coefficients,
        the runs do not determine a coefficient, or the log form meets a value that is not
        positive.
    """
    kind = form_named(form)
    names = tuple(factors)
    points, values = _checked_runs("x", "y", names, x, y, kind.logarithmic)
    terms = form_terms(kind, len(names))
    if len(values) < len(terms):
        raise InputError(
            f"runs: given {len(values)}; at least {len(terms)} are needed, because the {form} form "
            f"of {len(names)} factors has {len(terms)} coefficients."
        )
    center, half_range = _coding(names, points, kind.logarithmic)
    matrix = design_matrix(terms, code(points, center, half_range, kind.logarithmic))
    target = np.log(values) if kind.logarithmic else values
    solution = least_squares(
        matrix, target, [term_name(term, names, kind.logarithmic) for term in terms]
    )
    fitted = FittedForm(
        form, names, center, half_range, tuple(float(value) for value in solution.coefficients)
    )
    errors = _relative_errors(fitted.predict(points), values)
    heldout = _heldout_errors(fitted, heldout_x, heldout_y)
    return Fit(
        fitted=fitted,
        r_squared=_explained(values, fitted.predict(points)),
        q_squared=_leave_one_out(solution, target, values, kind.logarithmic),
        largest_error=float(np.max(errors)),
        mean_error=float(np.mean(errors)),
        largest_heldout_error=float(np.max(heldout)) if heldout is not None else None,
        mean_heldout_error=float(np.mean(heldout)) if heldout is not None else None,
        runs=len(values),
        heldout_runs=len(heldout) if heldout is not None else 0,
    )


def choose(fits: Sequence[Fit]) -> Fit:
    """Return the fit with the smallest largest error at held-out designs.

    Of equals the one with the fewest coefficients is taken.

    Raises
    ------
    InputError
        If there is no fit, or one was not judged by held-out designs.
    """
    if not fits:
        raise InputError("fits: given none; at least one is needed to choose from.")
    rated: list[tuple[float, int, int]] = []
    for number, fit in enumerate(fits):
        if fit.largest_heldout_error is None:
            raise InputError(
                f"fits: given a {fit.form} fit without held-out designs; all must have them, "
                "because errors at the fitted runs say nothing about the space between."
            )
        rated.append((fit.largest_heldout_error, len(fit.fitted.coefficients), number))
    return fits[min(rated)[2]]


def _checked_runs(
    x_name: str,
    y_name: str,
    factors: tuple[str, ...],
    x: ArrayLike,
    y: ArrayLike,
    logarithmic: bool,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if not factors or len(set(factors)) != len(factors):
        raise InputError(
            f"factors: given {list(factors)}; allowed is each varied dimension once, at least one."
        )
    points = np.asarray(x, dtype=np.float64)
    values = np.asarray(y, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != len(factors) or points.shape[0] == 0:
        raise InputError(
            f"{x_name}: given an array of shape {points.shape}; allowed is (runs, {len(factors)}), "
            f"one column for each of {', '.join(factors)}."
        )
    if values.shape != points.shape[:1]:
        raise InputError(
            f"{y_name}: given an array of shape {values.shape}; allowed is ({points.shape[0]},), "
            f"one response for each row of {x_name}."
        )
    for name, array in ((x_name, points), (y_name, values)):
        if not np.all(np.isfinite(array)):
            raise InputError(
                f"{name}: given a number that is not finite; leave failed runs out of a fit."
            )
    if np.any(values == 0.0):
        raise InputError(
            f"{y_name}: given a response of 0; allowed is any other number, because errors are "
            "relative to the response."
        )
    if logarithmic and not (np.all(points > 0.0) and np.all(values > 0.0)):
        raise InputError(
            f"{x_name}, {y_name}: given a value that is not positive; allowed are positive values, "
            "because the log-quadratic form takes their logarithm."
        )
    return points, values


def _coding(
    factors: tuple[str, ...], points: NDArray[np.float64], logarithmic: bool
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return centers and half ranges of the runs; each factor must vary."""
    spread = np.log(points) if logarithmic else points
    low, high = np.min(spread, axis=0), np.max(spread, axis=0)
    center, half_range = 0.5 * (low + high), 0.5 * (high - low)
    for number, name in enumerate(factors):
        if half_range[number] <= 1e-12 * max(abs(float(center[number])), 1e-300):
            raise InputError(
                f"{name}: given the same value {points[0, number]:g} in all runs; allowed are "
                "factors that vary, because only they can be fitted."
            )
    return tuple(center.tolist()), tuple(half_range.tolist())


def _relative_errors(
    predicted: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.abs(predicted - values) / np.abs(values)


def _heldout_errors(
    fitted: FittedForm, heldout_x: ArrayLike | None, heldout_y: ArrayLike | None
) -> NDArray[np.float64] | None:
    if heldout_x is None and heldout_y is None:
        return None
    if heldout_x is None or heldout_y is None:
        raise InputError(
            "heldout_x, heldout_y: given only one of the two; give the held-out designs with their "
            "responses, or neither."
        )
    points, values = _checked_runs(
        "heldout_x", "heldout_y", fitted.factors, heldout_x, heldout_y, fitted.logarithmic
    )
    return _relative_errors(fitted.predict(points), values)


def _explained(values: NDArray[np.float64], predicted: NDArray[np.float64]) -> float:
    """Return 1 - residual / total sum of squares; 1 where there is nothing to explain."""
    # Divided by the largest value first, because squares of a compliance would be denormal.
    size = float(np.max(np.abs(values)))
    centered = (values - np.mean(values)) / size
    total = float(np.sum(centered**2))
    if total <= len(values) * (4.0 * np.finfo(float).eps) ** 2:
        return 1.0
    residual = (values - predicted) / size
    return 1.0 - float(np.sum(residual**2)) / total


def _leave_one_out(
    solution: LeastSquares,
    target: NDArray[np.float64],
    values: NDArray[np.float64],
    logarithmic: bool,
) -> float | None:
    """Return Q2 from each run's prediction by the fit to all others, by the hat matrix."""
    if float(np.max(solution.leverage)) >= _FULL_LEVERAGE:
        return None
    left_out = target - (target - solution.fitted) / (1.0 - solution.leverage)
    return _explained(values, np.exp(left_out) if logarithmic else left_out)
