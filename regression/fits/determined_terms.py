"""Terms of a form that the runs determine, by the levels of their columns."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from regression.fits.forms import Form, form_terms
from regression.fits.statistics import DEPENDENT_COLUMN
from regression.fits.terms import Term, design_matrix, divisors, levels_needed

Array = NDArray[np.float64]

# Two values of a column are one level if they differ by less than this share of its range.
_SAME_LEVEL = 1e-9


def is_indicator(name: str) -> bool:
    """Whether a column of this name is the 0/1 column of a category, such as "web_outline=b"."""
    return "=" in name


def determined_terms(
    form: Form, factors: tuple[str, ...], points: Array, coded: Array
) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """Split the form's terms into those that the runs may determine, and the others."""
    indicators = [number for number, name in enumerate(factors) if is_indicator(name)]
    levels = [_level_count(points[:, number]) for number in range(len(factors))]
    candidates = [
        term
        for term in form_terms(form, len(factors), indicators)
        # The 0/1 columns of one category are never 1 together.
        if not _same_category(term, factors)
    ]
    kept = [
        term
        for term in candidates
        if all(levels[number] >= needed for number, needed in levels_needed(term).items())
    ]
    if form.degree > 2 and len(kept) <= len(points):
        kept = _independent(kept, coded)
    return tuple(kept), tuple(term for term in candidates if term not in kept)


def _level_count(column: Array) -> int:
    ordered = np.sort(column)
    steps = np.diff(ordered) > _SAME_LEVEL * (ordered[-1] - ordered[0])
    return 1 + int(np.count_nonzero(steps))


def _same_category(term: Term, factors: tuple[str, ...]) -> bool:
    categories = [factors[n].partition("=")[0] for n in term if is_indicator(factors[n])]
    return len(set(categories)) < len(categories)


def _independent(terms: Sequence[Term], coded: Array) -> list[Term]:
    """Leave out the terms that follow from earlier ones at the runs, and those that contain them."""
    columns = design_matrix(terms, coded)
    directions = np.empty((len(coded), 0))
    kept: list[Term] = []
    left_out: set[Term] = set()
    for place, term in enumerate(terms):
        column = columns[:, place]
        own = column.copy()
        for _ in range(2):  # twice, or round-off would pass for an own part
            own -= directions @ (directions.T @ own)
        length = float(np.linalg.norm(own))
        dependent = length <= 1e2 * DEPENDENT_COLUMN * float(np.linalg.norm(column))
        if dependent or not left_out.isdisjoint(divisors(term)):
            left_out.add(term)
            continue
        kept.append(term)
        directions = np.column_stack([directions, own / length])
    return kept
