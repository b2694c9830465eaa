"""Terms of a polynomial: their list, their columns, and their expansion in natural variables.

A term is the tuple of the columns' numbers that it multiplies: () is the constant, (0,) the first
column, (0, 0) its square, (0, 1) the product of the first two, (0, 0, 1) a square times a column.
"""

import itertools
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.model import field_extra
from geometry.throw import CrankThrow

Term = tuple[int, ...]


def polynomial_terms(
    columns: int, degree: int, *, indicators: Collection[int] = ()
) -> tuple[Term, ...]:
    """List the terms of a polynomial: constant, columns, squares, products, then cubic ones.

    Indicators have no powers.

    Shorter terms stand first, of equal ones those of fewer columns; with every term all that divide it.

    Examples
    --------
    >>> polynomial_terms(2, 2)
    ((), (0,), (1,), (0, 0), (1, 1), (0, 1))
    >>> polynomial_terms(2, 2, indicators=[1])
    ((), (0,), (1,), (0, 0), (0, 1))
    """
    terms: list[Term] = []
    for size in range(degree + 1):
        longer = [
            term
            for term in itertools.combinations_with_replacement(range(columns), size)
            if all(term.count(number) < 2 for number in indicators)
        ]
        terms += sorted(longer, key=lambda term: (len(set(term)), term))
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
    """Turn columns (..., k) into coded variables z = (u - center) / half_range, -1 to 1 over the runs.

    u is the column or, where `log_factors` says so, its natural logarithm; `InputError` if it has none.
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

    The given terms stand first and in their order; a missing term that divides one of them follows.
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


Array = NDArray[np.float64]
# Numbers or arrays of one shape, by name of the dimension [SI].
Dimensions = Mapping[str, Any]

# Two values of a group are the same if they differ by less than this share.
_SAME = 1e-9
# A group of which the others explain all but this share says nothing of its own.
_OWN_SHARE = 1e-3


@dataclass(frozen=True)
class Group:
    """A dimensionless group, in the papers' symbols; `logged`: not if it may be 0 or negative."""

    name: str
    dimensions: tuple[str, ...]
    value: Callable[[Dimensions], Any]
    logged: bool


def _ratio(name: str, above: str, below: str, *, logged: bool = True) -> Group:
    return Group(name, (above, below), lambda d: d[above] / d[below], logged)


def _overlap(d: Dimensions) -> Any:
    return 0.5 * (d["main_journal_diameter"] + d["pin_diameter"]) / d["crank_radius"] - 1.0


GROUPS: Mapping[str, Group] = {
    group.name: group
    for group in (
        Group(
            "s/R", ("main_journal_diameter", "pin_diameter", "crank_radius"), _overlap, logged=False
        ),
        _ratio("R/h", "crank_radius", "web_thickness"),
        _ratio("B/D_shm", "web_width", "pin_diameter"),
        _ratio("D_km/D_shm", "main_journal_diameter", "pin_diameter"),
        _ratio("L_shm/D_shm", "pin_length", "pin_diameter"),
        _ratio("L_km/D_shm", "main_journal_length", "pin_diameter"),
        _ratio("r/D_shm", "fillet_radius", "pin_diameter", logged=False),
        _ratio("d_km/D_km", "main_journal_bore", "main_journal_diameter", logged=False),
        _ratio("d_shm/D_shm", "pin_bore", "pin_diameter", logged=False),
    )
}
_COVERED = frozenset(name for group in GROUPS.values() for name in group.dimensions)
_OTHER = "/D_shm"


def group_named(name: str) -> Group:
    """Group of this name: from the catalogue, or any other length over the pin diameter; else `InputError`.

    Examples
    --------
    >>> group_named("web_journal_end/D_shm").dimensions
    ('web_journal_end', 'pin_diameter')
    """
    if name in GROUPS:
        return GROUPS[name]
    field = name.removesuffix(_OTHER)
    if field == name or not field:
        raise InputError(
            f"group: given {name!r}; allowed are {', '.join(GROUPS)} and FIELD{_OTHER} for another "
            "length, because equations that carry over to other sizes are written in these."
        )
    return _ratio(name, field, "pin_diameter", logged=False)


def group_names(dimensions: Iterable[str]) -> tuple[str, ...]:
    """Return the groups of these dimensions: those of the catalogue, then other lengths."""
    lengths = tuple(dimensions)
    known = [name for name, group in GROUPS.items() if set(group.dimensions) <= set(lengths)]
    if "pin_diameter" not in lengths:
        return tuple(known)
    return (*known, *(f"{name}{_OTHER}" for name in lengths if name not in _COVERED))


def group_values(dimensions: Dimensions) -> dict[str, Array]:
    """Calculate all groups that lengths make, name to (n,) array [m]."""
    return {
        name: np.asarray(group_named(name).value(dimensions), dtype=np.float64)
        for name in group_names(dimensions)
    }


def is_length(name: str) -> bool:
    """Whether a field of the throw is a length."""
    info = CrankThrow.model_fields.get(name)
    return info is not None and field_extra(info, "unit") == "m"


def independent_groups(values: Mapping[str, Array], limit: int) -> tuple[str, ...]:
    """Choose groups that vary independently, at most `limit`, in the order of `values` (n,).

    Starting with the first that varies, the group is added of which those already chosen explain the
    smallest share (by linear regression), as long as any has a share of its own.
    """
    varying = {
        name: (column - column.mean()) / np.linalg.norm(column - column.mean())
        for name, column in values.items()
        if np.ptp(column) > _SAME * float(np.max(np.abs(column)))
    }
    chosen: list[str] = []
    while varying and len(chosen) < limit:
        left = {name: float(np.linalg.norm(column)) for name, column in varying.items()}
        # Of equals the first: at the start all have the length 1.
        best = max(left, key=lambda name: round(left[name], 6))
        if left[best] < _OWN_SHARE:
            break
        chosen.append(best)
        direction = varying.pop(best) / left[best]
        varying = {name: c - direction * (direction @ c) for name, c in varying.items()}
    return tuple(name for name in values if name in chosen)
