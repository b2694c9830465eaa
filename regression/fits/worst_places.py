"""Designs at which equations are worst: the most informative further runs.

An equation has two errors: the runs determine its coefficients badly, or it lacks a term. At three
levels of every factor the second is the only one, and no run shows it. So the equation is extended by the
missing terms, those of one degree more, as normal variables about zero: y = F b + G g + e, Var g =
tau^2, Var e = tau^2 l; l and tau^2 are those that make the residuals at the runs most likely (restricted
likelihood). The expected squared error at a point is then tau^2 l h (H^T H + l K)^-1 h^T, with H = [F G]
at the runs, h that row at the point, and K 1 for missing terms, 0 for others (the Bayesian design of
DuMouchel and Jones, Technometrics 36, 1994, pp. 37-47). It falls with each further run by an amount that
is independent of the run's result, so that several can be chosen before any is computed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from regression.fits.fits import Fit
from regression.fits.terms import Term, code, design_matrix, polynomial_terms

Array = NDArray[np.float64]

# Ratios l that are tried: above, only the equation's own terms count; below, residuals are round-off.
RATIOS = 10.0 ** np.arange(-6.0, 3.1, 0.5)
# Equations of many columns are taken without the terms of one degree more: solving would take minutes.
MOST_TERMS = 1200


@dataclass(frozen=True, eq=False)
class JudgedEquation:
    """An equation, with its columns at runs and at points where its error is estimated.

    Attributes
    ----------
    fit : Fit
    runs : (n, k) array
        Columns at the runs to which it was fitted.
    target : (n,) array
        Values fitted there: the response over its scale, or the logarithm of that.
    places : (m, k) array
        Columns at the places.
    sizes : (m,) array
        Divisor that makes an error of the polynomial relative.
    """

    fit: Fit
    runs: Array
    target: Array
    places: Array
    sizes: Array


@dataclass(frozen=True, eq=False)
class ExpectedErrors:
    """Covariance of an equation's relative errors at points, ``left @ right.T``.

    Attributes
    ----------
    left, right : (m, p) array
    noise : (m,) array
        Part of the squared error that no run reduces.
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
    own, lacking = form.terms, lacking_terms(equation.fit)

    def columns(x: Array) -> tuple[Array, Array]:
        coded = code(x, form.center, form.half_range, form.log_factors)
        return design_matrix(own, coded), design_matrix(lacking, coded)

    known, further = columns(equation.runs)
    ratio, variance = _likeliest(known, further, equation.target)
    matrix = np.hstack([known, further])
    normal = matrix.T @ matrix
    normal[np.diag_indices_from(normal)] += ratio * (np.arange(len(normal)) >= len(own))
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
    own = set(form.terms)
    return tuple(term for term in terms if term not in own)


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
    """Choose the points with the largest sum of expected squared relative errors of all equations.

    Each counts as a run before the next is chosen.

    Parameters
    ----------
    equations : sequence of JudgedEquation
        All at the same m points.
    count : int
        At most m.

    Returns
    -------
    list of int
    """
    found = [expected_errors(equation) for equation in equations]
    chosen: list[int] = []
    for _ in range(count):
        total = np.sum([one.squares for one in found], axis=0)
        total[chosen] = -np.inf
        chosen.append(int(np.argmax(total)))
        found = [one.after_run(chosen[-1]) for one in found]
    return chosen
