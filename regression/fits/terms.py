"""Terms of a polynomial: their list, their columns, and their expansion in natural variables.

A term is the tuple of the columns' numbers that it multiplies: () is the constant, (0,) the first
column, (0, 0) its square, (0, 1) the product of the first two, (0, 0, 1) a square times a column.
"""

import itertools
import math
from collections import Counter
from collections.abc import Collection, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError

Term = tuple[int, ...]


def polynomial_terms(
    columns: int, degree: int, *, indicators: Collection[int] = ()
) -> tuple[Term, ...]:
    """List the terms of a polynomial: constant, columns, squares, products, then cubic ones.

    Parameters
    ----------
    columns : int
        Number of columns.
    degree : int
        Highest degree of a term.
    indicators : collection of int
        Columns that have no powers of their own, such as those of 0 and 1.

    Returns
    -------
    tuple of Term
        Shorter terms first, and of equal ones those of fewer columns; with every term all terms
        that divide it.

    Examples
    --------
    >>> polynomial_terms(2, 2)
    ((), (0,), (1,), (0, 0), (1, 1), (0, 1))
    >>> polynomial_terms(2, 2, indicators=[1])
    ((), (0,), (1,), (0, 0), (0, 1))
    """
    terms: list[Term] = []
    for size in range(degree + 1):
        found = [
            term
            for term in itertools.combinations_with_replacement(range(columns), size)
            if all(term.count(number) < 2 for number in indicators)
        ]
        terms += sorted(found, key=lambda term: (len(set(term)), term))
    return tuple(terms)


def levels_needed(term: Term) -> dict[int, int]:
    """Return the number of different values of each of its columns that a term requires.

    Examples
    --------
    >>> levels_needed((0, 0, 1))
    {0: 3, 1: 2}
    """
    return {number: power + 1 for number, power in Counter(term).items()}


def divisors(term: Term) -> set[Term]:
    """Return the proper divisors of a term.

    Examples
    --------
    >>> sorted(divisors((0, 0, 1)))
    [(), (0,), (0, 0), (0, 1), (1,)]
    """
    return {divisor for size in range(len(term)) for divisor in itertools.combinations(term, size)}


def term_name(term: Term, names: Sequence[str], times: str = " * ") -> str:
    """Name a term in words of its columns, such as "web_width^2"; "1" is the constant.

    Examples
    --------
    >>> term_name((0, 0, 1), ("s/R", "ln(B)"))
    '(s/R)^2 * ln(B)'
    """
    if not term:
        return "1"
    return times.join(
        names[number] if power == 1 else f"{_base(names[number])}^{power}"
        for number, power in sorted(Counter(term).items())
    )


def _base(name: str) -> str:
    return f"({name})" if "/" in name and not name.startswith("ln(") else name


def code(
    points: NDArray[np.float64],
    center: Sequence[float],
    half_range: Sequence[float],
    log_factors: Sequence[bool],
) -> NDArray[np.float64]:
    """Turn columns (..., k) into coded variables z = (u - center) / half_range.

    Parameters
    ----------
    points : (..., k) ndarray
    center, half_range : sequence of float
        Of u, which is the column or, where `log_factors` says so, its natural logarithm.
    log_factors : sequence of bool

    Returns
    -------
    (..., k) ndarray
        -1 ... 1 over the runs.

    Raises
    ------
    InputError
        If a logarithm is taken of a value that is not positive.
    """
    logged = np.asarray(log_factors, dtype=bool)
    if logged.any():
        chosen = points[..., logged]
        if not np.all(chosen > 0.0):
            raise InputError(
                f"x: given {float(np.min(chosen)):g}; allowed are positive values, because the "
                "equation takes their logarithm."
            )
        points = points.copy()
        points[..., logged] = np.log(chosen)
    middle: NDArray[np.float64] = np.asarray(center, dtype=np.float64)
    span: NDArray[np.float64] = np.asarray(half_range, dtype=np.float64)
    coded: NDArray[np.float64] = (points - middle) / span
    return coded


def design_matrix(terms: Sequence[Term], coded: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the columns of the terms at the coded points, (n, number of terms)."""
    matrix = np.ones((coded.shape[0], len(terms)))
    for column, term in enumerate(terms):
        for number in term:
            matrix[:, column] *= coded[:, number]
    return matrix


def expand(
    terms: Sequence[Term],
    coefficients: Sequence[float],
    shifts: Sequence[Fraction],
    spans: Sequence[Fraction],
) -> dict[Term, Fraction]:
    """Insert z = (u - shift) / span into a polynomial, exactly.

    Returns
    -------
    dict of Term to Fraction
        Coefficients of the terms in u, the given ones first and in their order; a missing term
        that divides one of the polynomial's own follows.
    """
    result: dict[Term, Fraction] = {term: Fraction(0) for term in terms}
    for term, coefficient in zip(terms, coefficients, strict=True):
        scaled = Fraction(coefficient)
        for number in term:
            scaled /= spans[number]
        # Each factor (u - shift) of the product gives either its u or its shift.
        for kept in itertools.product((True, False), repeat=len(term)):
            share = scaled
            rest: list[int] = []
            for number, keep in zip(term, kept, strict=True):
                if keep:
                    rest.append(number)
                else:
                    share *= -shifts[number]
            result[tuple(rest)] = result.get(tuple(rest), Fraction(0)) + share
    return result


def natural_shift(value: float, size: float, logged: bool) -> Fraction:
    """Return a center in units of `size`, as a fraction."""
    if logged:
        return Fraction(value) - Fraction(math.log(size))
    return Fraction(value) / Fraction(size)
