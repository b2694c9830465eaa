"""Which terms of a form stay, and which form is taken.

Terms are dropped backward: as long as the fit without some term has a leave-one-out sum of squares
(PRESS) that is no greater than the fit with it, the term goes whose loss makes PRESS smallest.
Hierarchy is kept: a term stays while another contains it, h^2 while there is B h^2. Terms of the
first degree always stay, for lack of fit elsewhere may hide what a factor does, and an equation that
does not know a factor answers wrongly about it.

The form is chosen by designs held out of all fits: of the forms whose largest held-out error is
within a tenth of the smallest, or no more above it than the finite elements scatter from design to
design, the one with the fewest coefficients. An error by which one of several was chosen flatters
the chosen one a little: with ten forms and the few held-out designs of a study the truth is, over
new designs, somewhat larger.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from crankbase.errors import InputError
from regression.fits.statistics import Array, press_without_each
from regression.fits.terms import Term, removable

# Forms whose largest held-out error is within this share of the smallest count as equally good.
PARSIMONY = 0.10


def backward(matrix: Array, y: Array, terms: Sequence[Term]) -> tuple[list[int], list[int]]:
    """Drop the terms without which PRESS does not grow.

    Parameters
    ----------
    matrix : (n, p) ndarray
        Columns of the terms at the runs, of full rank.
    y : (n,) ndarray
        What is fitted (the logarithm of the response in a form in logarithms).
    terms : sequence of Term

    Returns
    -------
    kept, dropped : list of int
        Places of the terms that stay, in order, and of those that go, in the order of their going.
        Nothing goes where no fit with one term less has a finite PRESS.
    """
    kept, dropped = list(range(len(terms))), list[int]()
    press = _press(matrix, y)
    while True:
        places = removable([terms[number] for number in kept])
        if not places:
            return kept, dropped
        without = press_without_each(matrix[:, kept], y, places)
        best = int(np.argmin(without))
        if not np.isfinite(without[best]) or without[best] > press:
            return kept, dropped
        press = float(without[best])
        dropped.append(kept.pop(places[best]))


def _press(matrix: Array, y: Array) -> float:
    orthogonal = np.linalg.qr(matrix)[0]
    left = 1.0 - np.sum(orthogonal**2, axis=1)
    if float(np.min(left)) <= 1e-9:
        return float(np.inf)
    return float(np.sum(((y - orthogonal @ (orthogonal.T @ y)) / left) ** 2))


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
    """The place of the fit taken, and why in one sentence."""

    place: int
    reason: str


def choose(fits: Sequence[AnyFit], scatter: float = 0.0) -> Choice:
    """Choose a fit by its held-out error, with parsimony.

    Parameters
    ----------
    fits : sequence
    scatter : float
        Relative scatter of the finite element values from design to design: errors that differ by
        less are the same.

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
                "because errors at the fitted runs say nothing about the space between."
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
