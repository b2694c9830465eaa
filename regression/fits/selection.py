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

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from regression.fits.statistics import FULL_LEVERAGE, Array
from regression.fits.terms import Term, divisors

# Forms whose largest held-out error is within this share of the smallest count as equally good.
PARSIMONY = 0.10


def backward(matrix: Array, y: Array, terms: Sequence[Term]) -> tuple[list[int], list[int]]:
    """Drop the terms without which PRESS does not grow.

    Parameters
    ----------
    matrix : (n, p) ndarray
        Columns of the terms at the runs, of full rank.
    y : (n,) ndarray
        Fitted values (the logarithm of the response in a form in logarithms).
    terms : sequence of Term

    Returns
    -------
    kept, dropped : list of int
        Indices of the terms that stay, in order, and of those dropped, in the order of their removal.
        Nothing is dropped if no fit with one term less has a finite PRESS.
    """
    dropped: list[int] = []
    whole = np.asarray(np.linalg.pinv(matrix), dtype=np.float64)
    _drop(whole[None], matrix, y, terms, np.zeros((1, 0), dtype=int), dropped)
    return [place for place in range(len(terms)) if place not in dropped], dropped


def left_out_predictions(matrix: Array, y: Array, terms: Sequence[Term]) -> Array | None:
    """Predict every run by the fit to all others, whose terms are selected without it too.

    Parameters
    ----------
    matrix, y, terms
        As in `backward`.

    Returns
    -------
    (n,) ndarray or None
        None if some run alone determines a coefficient of the form before the selection.
    """
    runs = len(y)
    whole = np.asarray(np.linalg.pinv(matrix), dtype=np.float64)
    leverage = np.sum(matrix * whole.T, axis=1)
    if runs <= len(terms) or float(np.max(leverage)) >= FULL_LEVERAGE:
        return None
    # Without run i, by the formula of Sherman and Morrison: (A'A - a a')^-1 and with it the pseudoinverse.
    own = (whole @ whole.T @ matrix.T).T  # (n, p): (A'A)^-1 a of every run
    mixed = (matrix @ whole) / (1.0 - leverage)[:, None]
    inverses = whole[None] + own[:, :, None] * mixed[:, None, :]
    inverses[np.arange(runs), :, np.arange(runs)] = 0.0
    inverses = _drop(inverses, matrix, y, terms, np.arange(runs)[:, None])
    predicted: Array = np.einsum("ip,ipn,n->i", matrix, inverses, y, optimize=True)
    return predicted


def _drop(
    inverses: Array,
    matrix: Array,
    y: Array,
    terms: Sequence[Term],
    left_out: NDArray[np.intp],
    dropped: list[int] | None = None,
) -> Array:
    """Drop terms of several fits of one form simultaneously, each to other runs.

    Without column j the hat matrix loses v v^T, where v is the unit vector along row j of the pseudoinverse:
    v is in the space of all columns and orthogonal to the others. So residuals, leverages and the
    pseudoinverse follow from those before.

    Parameters
    ----------
    inverses : (m, p, n) ndarray
        Pseudoinverse of the matrix of each fit, 0 at the runs that it leaves out.
    matrix, y, terms
        As in `backward`.
    left_out : (m, number) ndarray
        Which runs each fit leaves out.
    dropped : list, optional
        Called with the indices of the dropped terms of the first fit, in order.

    Returns
    -------
    (m, p, n) ndarray
        Pseudoinverses of the remaining terms; 0 for dropped ones.
    """
    fits = len(inverses)
    taking_part = np.ones((fits, len(y)))
    np.put_along_axis(taking_part, left_out, 0.0, axis=1)
    residuals = taking_part * (y - (inverses @ y) @ matrix.T)
    leverage = np.einsum("np,mpn->mn", matrix, inverses)
    divides = np.array([[one in divisors(term) for term in terms] for one in terms])
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


class CrossValidatedForm(Protocol):
    """A form whose fit was cross-validated by held-out designs."""

    @property
    def form(self) -> str:
        """Name of the form."""

    @property
    def coefficient_count(self) -> int:
        """Number of its coefficients."""

    @property
    def largest_heldout_error(self) -> float | None:
        """Largest relative error at the held-out designs."""


AnyFit = TypeVar("AnyFit", bound=CrossValidatedForm)


@dataclass(frozen=True)
class Choice:
    """The index of the selected fit, and the reason in one sentence."""

    place: int
    reason: str


def choose(fits: Sequence[AnyFit], scatter: float = 0.0) -> Choice:
    """Choose a fit by its held-out error, with parsimony.

    Parameters
    ----------
    fits : sequence
    scatter : float
        Relative scatter of the finite element values from design to design: errors that differ by
        less count as equal.

    Returns
    -------
    Choice
        Of the fits with equally small errors and equally few coefficients that of the smallest
        error, and of those whose errors are the same to three digits the first.

    Raises
    ------
    InputError
        If there is no fit, or one was not judged by held-out designs.
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
    fits: Sequence[AnyFit], errors: Sequence[float], taken: int, equal: int, scatter: float
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
