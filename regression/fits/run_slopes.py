"""Slopes of a response at runs, as rows of least squares beside its values.

Values and slopes fit one equation: a run of k slopes counts as 1 + k. Rows are weighed by the estimated
errors, a slope never more than a value, because an equation that lacks terms fits slopes less well.
Slopes that contradict values and other slopes are found by what the sum of squares loses without them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array
from regression.fits.forms import Term, code, design_matrix
from regression.fits.selection import FULL_LEVERAGE

# An equation's own lack of fit, as a share of the response: slopes within some of it are not doubted.
LACK_OF_FIT = 0.003
# Chance of such a contradiction, among all that are looked at, by errors and lack of fit alone.
DOUBT = 1e-4


@dataclass(frozen=True, eq=False)
class RunSlopes:
    """Slopes of a response y at n runs over k factors, each counted in halves of its range.

    Attributes
    ----------
    values : (n, k) array
        d ln(y / scale) / d(factor); NaN where there is none.
    weights : (n, k) array
        Estimated relative error of y over the slope's, at most 1.
    turned : (n, k, m) array
        Derivatives of the equation's m columns over the factors.
    """

    values: Array
    weights: Array
    turned: Array

    @property
    def known(self) -> NDArray[np.intp]:
        """Run and factor (r, 2) of each slope."""
        return np.argwhere(np.isfinite(self.values))

    @property
    def columns(self) -> list[int]:
        """Columns over which there are slopes."""
        runs, factors = self.known.T
        return np.flatnonzero(np.any(self.turned[runs, factors], axis=0)).tolist()

    def directions(self, coded_slopes: Array) -> Array:
        """Return the directions (r, m) of the slopes in coded columns, weighed as `rows`."""
        runs, factors = self.known.T
        turned = self.turned[runs, factors] * coded_slopes[runs]
        weighed: Array = turned * self.weights[runs, factors][:, None]
        return weighed

    def rows(self, terms: Sequence[Term], coded: Array, coded_slopes: Array) -> Array:
        """Return the rows (r, terms) of the slopes, from coded columns (n, m) and their own derivatives."""
        runs, factors = self.known.T
        rows = np.zeros((len(runs), len(terms)))
        for column in range(coded.shape[1]):
            change = (self.turned[:, :, column] * coded_slopes[:, column, None])[runs, factors]
            rows += derivatives(terms, coded, column)[runs] * change[:, None]
        weighed: Array = rows * self.weights[runs, factors][:, None]
        return weighed

    def targets(self, sizes: Array) -> Array:
        """Return what the rows are to give (r,); the fitted y / scale has the sizes (n,), its logarithm 1."""
        runs, factors = self.known.T
        values: Array = (self.values * self.weights)[runs, factors] * sizes[runs]
        return values


def joint_rows(
    terms: Sequence[Term],
    points: Array,
    coding: tuple[Sequence[float], Sequence[float], Sequence[bool]],
    slopes: RunSlopes | None,
) -> Array:
    """Return the rows of least squares: of the values at runs (n, m), then of their slopes.

    `coding` has center, half range and logarithm of each column, as of `regression.fits.forms.code`.
    """
    center, half_range, logged = coding
    coded = code(points, center, half_range, logged)
    rows = design_matrix(terms, coded)
    if slopes is None:
        return rows
    own = 1.0 / (np.where(logged, points, 1.0) * np.asarray(half_range))
    return np.vstack([rows, slopes.rows(terms, coded, own)])


def joint_target(target: Array, logarithmic: bool, slopes: RunSlopes | None) -> Array:
    """Return what the rows are to give: the values' target (n,), then that of the slopes."""
    if slopes is None:
        return target
    return np.concatenate([target, slopes.targets(np.ones(len(target)) if logarithmic else target)])


def derivatives(terms: Sequence[Term], coded: Array, column: int) -> Array:
    """Return the derivatives (n, terms) of the terms over one of the coded columns (n, m)."""
    powers = np.array([term.count(column) for term in terms], dtype=float)
    lower = [
        tuple(n for place, n in enumerate(term) if place != term.index(column))
        if column in term
        else ()
        for term in terms
    ]
    return powers * design_matrix(lower, coded)


def rows_by_run(runs: int, slopes: RunSlopes | None) -> NDArray[np.intp]:
    """Return the rows (n, r) of each run: its value's, then its slopes'; the first fills the rest."""
    known = np.empty((0, 2), dtype=np.intp) if slopes is None else slopes.known
    most = 1 + int(np.bincount(known[:, 0], minlength=runs).max(initial=0))
    places = np.repeat(np.arange(runs)[:, None], most, axis=1)
    for run in range(runs):
        own = runs + np.flatnonzero(known[:, 0] == run)
        places[run, 1 : 1 + len(own)] = own
    return places


def left_out_values(
    matrix: Array, residuals: Array, y: Array, groups: NDArray[np.intp]
) -> Array | None:
    """Predict the first row of each group (n, r) by the fit to all other groups; None if some cannot be."""
    orthogonal, _ = np.linalg.qr(matrix)
    predicted = np.empty(len(groups))
    for place, group in enumerate(groups):
        rows = np.unique(group)
        left = np.eye(len(rows)) - orthogonal[rows] @ orthogonal[rows].T
        if np.linalg.eigvalsh(left)[0] <= 1.0 - FULL_LEVERAGE:
            return None
        predicted[place] = y[group[0]] - np.linalg.solve(left, residuals[rows])[rows == group[0]][0]
    return predicted


def doubtful_slopes(
    matrix: Array, y: Array, known: NDArray[np.intp], precision: float
) -> list[tuple[int, int]]:
    """Find slopes that contradict the values and the other slopes.

    Single slopes, all of a run and all over a factor are left out in turn; those without which the sum of
    squares falls by more than errors and lack of fit explain are left out for good, the worst first.

    Parameters
    ----------
    matrix : (n + r, p) array
        Rows of the values, then of the slopes, whose run and factor are `known` (r, 2).
    precision : float
        Size of an error of y that is not doubted.
    """
    values, doubted = len(y) - len(known), []
    staying = np.arange(len(known))
    while len(staying):
        worst = _worst(matrix, y, np.r_[:values, values + staying], known[staying], precision)
        if worst is None:
            break
        doubted += [(int(run), int(factor)) for run, factor in known[staying[worst]]]
        staying = np.delete(staying, worst)
    return sorted(doubted)


def _worst(
    matrix: Array, y: Array, rows: NDArray[np.intp], known: NDArray[np.intp], precision: float
) -> NDArray[np.intp] | None:
    """Return the places of the slopes that contradict the others most; None if none do."""
    from scipy.special import chdtrc

    values = len(rows) - len(known)
    orthogonal, _ = np.linalg.qr(matrix[rows])
    residuals = y[rows] - orthogonal @ (orthogonal.T @ y[rows])
    total, freedom = float(residuals @ residuals), len(rows) - matrix.shape[1]
    # Single slopes, all of a run, all over a factor.
    groups = list(np.arange(len(known))[:, None])
    for column in (0, 1):
        for which in np.unique(known[:, column]):
            group = np.flatnonzero(known[:, column] == which)
            if len(group) > 1:
                groups.append(group)
    least, found = np.log(DOUBT / len(groups)), None
    for group in groups:
        own = orthogonal[values + group]
        left = np.eye(len(group)) - own @ own.T
        rest = freedom - len(group)
        if rest < 1 or np.linalg.eigvalsh(left)[0] <= 1.0 - FULL_LEVERAGE:
            continue
        part = residuals[values + group]
        fall = float(part @ np.linalg.solve(left, part))
        variance = max((total - fall) / rest, precision**2)
        with np.errstate(divide="ignore"):
            chance = float(np.log(chdtrc(len(group), fall / variance)))
        if chance < least:
            least, found = chance, group
    return found
