"""Least-squares fits of a response over a design, and their reliability.

Finite element runs repeat exactly, so there is no replication noise: the residuals are lack of
fit, and t and F values measure only that. Leave-one-out on a coarse grid does not detect the error
between its levels either. A fit is therefore assessed by held-out designs spread over the box.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array
from crankbase.errors import InputError
from regression.fits.fit import Fit, names_of_terms
from regression.fits.forms import (
    FORMS,
    GAUSSIAN_PROCESS,
    FittedForm,
    Form,
    Term,
    code,
    design_matrix,
    determined_terms,
    form_named,
    form_terms,
    group_named,
    is_indicator,
    polynomial_terms,
)
from regression.fits.gaussian_process import (
    NORMAL,
    Rows,
    correlations,
    likeliest,
    process_of,
)
from regression.fits.run_slopes import (
    DOUBT,
    LACK_OF_FIT,
    RunSlopes,
    doubtful_slopes,
    joint_rows,
    joint_target,
    left_out_values,
    rows_by_run,
)
from regression.fits.selection import (
    adjusted,
    backward,
    coefficient_of_determination,
    least_squares,
    left_out_predictions,
    tolerance_limit,
)

if TYPE_CHECKING:
    pass


def _check_responses(name: str, values: Array, form: Form) -> None:
    """Refuse responses of which a form can have no relative errors, or no logarithms (`InputError`)."""
    if np.any(values == 0.0):
        raise InputError(
            f"{name}: given a response of 0; allowed is any other number, because errors are "
            "relative to the response."
        )
    if form.logarithmic and not np.all(values > 0.0):
        raise InputError(
            f"{name}: given {float(np.min(values)):g}, which is not positive; allowed are "
            f"positive values, because the {form.name} form takes their logarithm."
        )


# Numbers that the selections without each run hold at a time; more take minutes for a study.
LARGEST_SELECTION = 3_000_000


def fit_form(
    form: str,
    factors: Sequence[str],
    x: ArrayLike,
    y: ArrayLike,
    heldout_x: ArrayLike | None = None,
    heldout_y: ArrayLike | None = None,
    *,
    scale: ArrayLike = 1.0,
    heldout_scale: ArrayLike = 1.0,
    logged: Sequence[bool] | None = None,
    drop_terms: bool = False,
    slopes: RunSlopes | None = None,
) -> Fit:
    """Fit one form to a response, and to its slopes, by least squares.

    Parameters
    ----------
    form : str
        One of `regression.fits.forms.FORMS`. A form in logarithms minimizes squares of ln y.
    factors : sequence of str
        Names of the k columns; one with "=" in it is the 0/1 column of a category.
    x, heldout_x : (n, k), (m, k) array_like
        Columns of the runs to fit, and of those to assess the fit.
    y, heldout_y : (n,), (m,) array_like
        The response; no value may be 0, as errors are relative.
    scale, heldout_scale : array_like, optional
        Factor from the equation's value to y, for an equation on dimensionless
        groups; a number, or one for each run.
    logged : sequence of bool, optional
        Columns that a form in logarithms may use as logarithms; by default the groups that allow it, and
        all factors. Only columns that are positive at the runs, and never 0/1 columns.
    drop_terms : bool
        Whether to remove terms without which PRESS does not grow (`regression.fits.selection`).
    slopes : RunSlopes, optional
        At the runs.

    Returns
    -------
    Fit
        Without terms that need more levels of a column than the runs have; a cubic form also
        without terms that follow from the others at the runs.

    Raises
    ------
    InputError
        If there are fewer runs and slopes than coefficients, the runs do not determine a coefficient, a
        response is 0, or a form in logarithms has one that is not positive.
    """
    kind = form_named(form)
    names = tuple(factors)
    points, values = (np.asarray(runs, dtype=np.float64) for runs in (x, y))
    if kind.process:
        known = values if heldout_y is None else np.append(values, heldout_y)
        kind = replace(kind, logarithmic=bool(np.all(known > 0.0)))
    _check_responses("y", values, kind)
    coding = center, half_range, log_factors = _coding(kind, names, points, logged)
    sizes = np.asarray(scale, dtype=np.float64)
    target = np.log(values / sizes) if kind.logarithmic else values / sizes
    target = joint_target(target, kind.logarithmic, slopes)
    terms, undetermined = determined_terms(
        kind,
        names,
        points,
        lambda terms: joint_rows(terms, points, coding, slopes),
        () if slopes is None else slopes.columns,
    )
    if kind.process:
        terms, undetermined = form_terms(kind, len(names)), ()
    if len(target) < len(terms):
        also = "" if slopes is None else f" and {len(target) - len(values)} slopes"
        raise InputError(
            f"runs: given {len(values)}{also}; at least {len(terms)} are needed, because the {form} form "
            f"of {len(names)} factors has {len(terms)} coefficients."
        )
    matrix = joint_rows(terms, points, coding, slopes)
    dropped: tuple[Term, ...] = ()
    # Solved in full first: that says which term the runs do not determine.
    solution = least_squares(matrix, target, names_of_terms(terms, names, log_factors))
    groups = rows_by_run(len(values), slopes)
    drop_terms = drop_terms and not kind.process
    small = len(target) ** 2 * len(terms) <= LARGEST_SELECTION
    left_out = left_out_predictions(matrix, target, terms, groups) if drop_terms and small else None
    if drop_terms:
        kept, gone = backward(matrix, target, terms)
        dropped, terms = tuple(terms[i] for i in gone), tuple(terms[i] for i in kept)
        matrix = matrix[:, kept]
        solution = least_squares(matrix, target, names_of_terms(terms, names, log_factors))
    coefficients, process, spread = solution.coefficients, None, [NORMAL]
    if kind.process:
        kriging = likeliest(_rows(points, coding, slopes), target, groups)
        process, coefficients = process_of(kriging, target), kriging.coefficients(target)
        if (unseen_runs := kriging.left_out(target, groups)) is not None:
            left_out, deviations = unseen_runs
            spread.append(tolerance_limit(np.abs(left_out - target[: len(values)]) / deviations))
    elif not (drop_terms and small) and slopes is None:
        left_out = solution.leave_one_out
    elif not (drop_terms and small):
        left_out = left_out_values(matrix, solution.residuals, target, groups)
    fitted = FittedForm(
        form=form,
        factors=names,
        logarithmic=kind.logarithmic,
        log_factors=log_factors,
        center=center,
        half_range=half_range,
        terms=terms,
        coefficients=tuple(coefficients.tolist()),
        process=process,
    )
    predicted = sizes * fitted.predict(points)
    errors = np.abs(predicted / values - 1.0)
    heldout: Array | None = None
    if heldout_x is not None and heldout_y is not None:
        unfitted = np.asarray(heldout_y, dtype=np.float64)
        _check_responses("heldout_y", unfitted, kind)
        factor = np.asarray(heldout_scale, dtype=np.float64)
        heldout = np.abs(factor * fitted.predict(heldout_x) / unfitted - 1.0)
        if process is not None:
            places = code(np.asarray(heldout_x, dtype=np.float64), *coding)
            ends = np.array([fitted.predict(heldout_x), unfitted])
            missed = np.abs(np.subtract(*(np.log(ends) if kind.logarithmic else ends)))
            spread.append(tolerance_limit(missed / process.deviations(places)))
    if process is not None:
        fitted = fitted.changed(process=replace(process, band=max(spread)))
    r_squared = coefficient_of_determination(values, predicted)
    unseen, q_squared = [] if heldout is None else [heldout], None
    if left_out is not None:
        left_out = sizes * (np.exp(left_out) if kind.logarithmic else left_out)
        q_squared = coefficient_of_determination(values, left_out)
        unseen.append(np.abs(left_out / values - 1.0))
    return Fit(
        form=form,
        basis=kind.basis,
        # A process keeps a number for every value and slope.
        coefficient_count=len(terms) if process is None else len(target),
        fitted=fitted,
        statistics=solution if process is None else None,
        r_squared=r_squared,
        adjusted_r_squared=adjusted(r_squared, len(target), len(terms)),
        q_squared=q_squared,
        largest_error=float(np.max(errors)),
        mean_error=float(np.mean(errors)),
        largest_heldout_error=float(np.max(heldout)) if heldout is not None else None,
        mean_heldout_error=float(np.mean(heldout)) if heldout is not None else None,
        runs=len(values),
        heldout_runs=len(heldout) if heldout is not None else 0,
        lowest=tuple(np.min(points, axis=0).tolist()),
        highest=tuple(np.max(points, axis=0).tolist()),
        undetermined=names_of_terms(undetermined, names, log_factors),
        dropped=names_of_terms(dropped, names, log_factors),
        band_error=max(map(tolerance_limit, unseen), default=None),
        band_designs=sum(map(len, unseen)),
    )


def _rows(
    points: Array,
    coding: tuple[Sequence[float], Sequence[float], Sequence[bool]],
    slopes: RunSlopes | None,
) -> Rows:
    """Return the rows of values and slopes, as `joint_rows`."""
    rows = Rows.at(code(points, *coding))
    if slopes is None:
        return rows
    _, half_range, logged = coding
    coded_slopes = 1.0 / (np.where(logged, points, 1.0) * np.asarray(half_range))
    return rows.with_slopes(slopes.known[:, 0], slopes.directions(coded_slopes))


def _coding(
    form: Form, factors: tuple[str, ...], points: Array, wished: Sequence[bool] | None
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[bool, ...]]:
    """Return centers, half ranges and logarithms of the columns, each of which must vary."""
    logged = np.zeros(len(factors), dtype=bool)
    if form.logarithmic or form.process:
        for number, name in enumerate(factors):
            if is_indicator(name) or not np.all(points[:, number] > 0.0):
                continue
            if wished is not None:
                logged[number] = wished[number]
            else:
                logged[number] = form.basis != "groups" or group_named(name).logged
    spread = points.copy()
    spread[:, logged] = np.log(points[:, logged])
    low, high = np.min(spread, axis=0), np.max(spread, axis=0)
    center, half_range = 0.5 * (low + high), 0.5 * (high - low)
    for number, name in enumerate(factors):
        if half_range[number] <= 1e-12 * max(abs(float(center[number])), 1e-300):
            raise InputError(
                f"{name}: given the same value {points[0, number]:g} in all runs; allowed are "
                "factors that vary, because only they can be fitted."
            )
    return tuple(center.tolist()), tuple(half_range.tolist()), tuple(logged.tolist())


def contradicting_slopes(
    factors: Sequence[str],
    x: ArrayLike,
    y: ArrayLike,
    slopes: RunSlopes,
    logged: Sequence[bool],
    precision: float,
) -> list[tuple[int, int]]:
    """Find the slopes that contradict the values and the others, by the form that fits best of all.

    Parameters as of `fit_form`, and `precision`, the estimated relative error of the response. Returns run
    and factor of each; none if the runs determine no such form.
    """
    points, values = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    form = FORMS["log-cubic" if np.all(values > 0.0) else "quadratic"]
    try:
        fit = fit_form(form.name, factors, points, values, logged=logged, slopes=slopes).fitted
    except InputError:
        return []
    matrix = joint_rows(fit.terms, points, (fit.center, fit.half_range, fit.log_factors), slopes)
    size = 1.0 if form.logarithmic else float(np.sqrt(np.mean(values**2)))
    target = np.log(values) if form.logarithmic else values
    joint = joint_target(target, form.logarithmic, slopes)
    return doubtful_slopes(matrix, joint, slopes.known, size * max(precision, LACK_OF_FIT))


def confirmed_doubts(
    factors: Sequence[str],
    x: ArrayLike,
    y: ArrayLike,
    slopes: RunSlopes,
    logged: Sequence[bool],
    precision: float,
    doubted: Sequence[tuple[int, int]],
) -> list[tuple[int, int]]:
    """Find the doubted slopes that a Gaussian process of the values and the other slopes contradicts as well.

    Where no polynomial fits, `contradicting_slopes`, whose other parameters these are, doubts good ones.
    """
    from scipy.special import chdtrc

    points, values = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    doubts = np.zeros(slopes.values.shape, dtype=bool)
    doubts[tuple(np.array(doubted).T)] = True
    others, those = (
        replace(slopes, values=np.where(kept, slopes.values, np.nan)) for kept in (~doubts, doubts)
    )
    name, known = GAUSSIAN_PROCESS.name, others if len(others.known) else None
    fit = fit_form(name, factors, points, values, logged=logged, slopes=known).fitted
    assert fit.process is not None
    kriging = fit.process.kriging
    rows = _rows(points, (fit.center, fit.half_range, fit.log_factors), those)
    at = Rows(rows.points[rows.values :], rows.directions[rows.values :], 0)
    expected = at.mean_terms @ fit.coefficients
    expected += correlations(at, kriging.rows, kriging.scales) @ fit.process.weights
    size = 1.0 if fit.logarithmic else float(np.sqrt(np.mean(values**2)))
    noise = max(fit.process.variance * fit.process.noises[1], (size * precision) ** 2)
    variances = fit.process.variance * np.diag(kriging.covariance(at)) + noise
    missed = those.targets(np.ones(len(values)) if fit.logarithmic else values) - expected
    contradicted = chdtrc(1, missed**2 / variances) < DOUBT / len(missed)
    return [(int(run), int(factor)) for run, factor in those.known[contradicted]]


# Ratios l that are tried: above, only the equation's own terms count; below, residuals are round-off.
RATIOS = 10.0 ** np.arange(-6.0, 3.1, 0.5)
# Equations of many columns are taken without the terms of one degree more: solving would take minutes.
MOST_TERMS = 1200


@dataclass(frozen=True, eq=False)
class JudgedEquation:
    """An equation, with its columns at runs and at points where its error is estimated.

    `runs` (n, k) are the columns at the runs to which it was fitted, `target` (n,) the values fitted
    there (the response over its scale, or its logarithm), `slopes` those fitted with them, `places` (m, k)
    the columns at the points, and `sizes` (m,) what makes an error of the polynomial relative.
    """

    fit: Fit
    runs: Array
    target: Array
    places: Array
    sizes: Array
    slopes: RunSlopes | None = None


@dataclass(frozen=True, eq=False)
class ExpectedErrors:
    """Covariance of relative errors at m points, ``left @ right.T`` (m, p).

    `noise` (m,) is what no run reduces.
    """

    left: Array
    right: Array
    noise: Array

    @property
    def squares(self) -> Array:
        """Expected squared errors (m,)."""
        squares: Array = np.sum(self.left * self.right, axis=1)
        return squares

    def after_run(self, place: int) -> "ExpectedErrors":
        """Return the expected errors after a run at one of the points, whatever its result."""
        shared = self.left @ self.right[place]
        total = shared[place] + self.noise[place]
        if not total > 0.0:
            return self
        return replace(self, left=self.left - np.outer(shared / total, self.left[place]))


def expected_errors(equation: JudgedEquation) -> ExpectedErrors:
    """Return the expected errors of an equation at its points."""
    form = equation.fit.fitted
    if form.process is not None:
        places = code(equation.places, form.center, form.half_range, form.log_factors)
        kriging, squares = form.process.kriging, form.process.variance / equation.sizes**2
        expected = kriging.covariance(Rows.at(places)) * np.sqrt(np.outer(squares, squares))
        return ExpectedErrors(expected, np.eye(len(places)), squares * kriging.noises[0])
    present, lacking = form.terms, lacking_terms(equation.fit)

    def columns(x: Array) -> tuple[Array, Array]:
        coded = code(x, form.center, form.half_range, form.log_factors)
        return design_matrix(present, coded), design_matrix(lacking, coded)

    coding = form.center, form.half_range, form.log_factors
    known, further = (
        joint_rows(terms, equation.runs, coding, equation.slopes) for terms in (present, lacking)
    )
    target = joint_target(equation.target, form.logarithmic, equation.slopes)
    ratio, variance = _likeliest(known, further, target)
    matrix = np.hstack([known, further])
    normal = matrix.T @ matrix
    normal[np.diag_indices_from(normal)] += ratio * (np.arange(len(normal)) >= len(present))
    noise = variance * ratio / equation.sizes**2
    rows = np.hstack(columns(equation.places)) / equation.sizes[:, None]
    return ExpectedErrors(rows @ np.linalg.inv(normal) * (variance * ratio), rows, noise)


def lacking_terms(fit: Fit) -> tuple[Term, ...]:
    """Return the terms that an equation lacks, up to one degree more than it has."""
    form = fit.fitted
    degree = max(map(len, form.terms))
    indicators = [place for place, name in enumerate(form.factors) if "=" in name]
    terms = polynomial_terms(len(form.factors), degree + 1, indicators=indicators)
    if len(terms) > MOST_TERMS:
        terms = polynomial_terms(len(form.factors), degree, indicators=indicators)
    present = set(form.terms)
    return tuple(term for term in terms if term not in present)


def _likeliest(known: Array, further: Array, target: Array) -> tuple[float, float]:
    """Return l and tau^2 by restricted likelihood from the residuals of the equation's own terms."""
    full, _ = np.linalg.qr(known, mode="complete")
    rest = full[:, known.shape[1] :]
    left = rest.T @ target
    if not left.size or not further.shape[1]:  # nothing is known of the error
        return float(RATIOS[len(RATIOS) // 2]), float(np.var(target))
    values, vectors = np.linalg.eigh(rest.T @ further @ (rest.T @ further).T)
    squares = (vectors.T @ left) ** 2
    spreads = np.clip(values, 0.0, None) + RATIOS[:, None]
    variances = np.mean(squares / spreads, axis=1)
    if not np.all(variances > 0.0):  # the equation is exact at the runs
        return float(RATIOS[0]), 0.0
    likelihood = -len(left) * np.log(variances) - np.sum(np.log(spreads), axis=1)
    best = int(np.argmax(likelihood))
    return float(RATIOS[best]), float(variances[best])


def worst_places(equations: Sequence[JudgedEquation], count: int) -> list[int]:
    """Indices of the points with the largest sum of expected squared relative errors of all equations.

    Each counts as a run before the next is chosen.
    """
    judged = [expected_errors(equation) for equation in equations]
    chosen: list[int] = []
    for _ in range(count):
        total = np.sum([errors.squares for errors in judged], axis=0)
        total[chosen] = -np.inf
        chosen.append(int(np.argmax(total)))
        judged = [errors.after_run(chosen[-1]) for errors in judged]
    return chosen
