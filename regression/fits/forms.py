"""The forms of a regression equation, and the equation itself as a function.

A form is a polynomial in coded variables z: the columns (factors of a study, or dimensionless
groups of the throw's dimensions), or their logarithms, shifted and scaled so that the runs span
-1 ... 1. Evaluated this way it loses no digits; the natural coefficients, which multiply the
columns themselves, follow by exact expansion.
"""

import itertools
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, FiniteFloat, model_validator

from crankbase.array_checks import Array
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra
from geometry.throw import CrankThrow
from regression.fits.gaussian_process import GaussianProcess
from regression.plans.factors import Factor

# A column of the coded design matrix whose part outside the earlier columns is smaller than this
# share of it is no column of its own.
DEPENDENT_COLUMN = 1e-10

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
    powers = []
    for number, power in sorted(Counter(term).items()):
        name = names[number]
        if power > 1:
            bracket = "/" in name and not name.startswith("ln(")
            name = f"({name})^{power}" if bracket else f"{name}^{power}"
        powers.append(name)
    return times.join(powers)


def code(
    points: Array,
    center: Sequence[float],
    half_range: Sequence[float],
    log_factors: Sequence[bool],
) -> Array:
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
    middle: Array = np.asarray(center, dtype=np.float64)
    span: Array = np.asarray(half_range, dtype=np.float64)
    coded: Array = (points - middle) / span
    return coded


def design_matrix(terms: Sequence[Term], coded: Array) -> Array:
    """Return the columns of the terms at the coded points, (n, number of terms)."""
    matrix = np.ones((coded.shape[0], len(terms)))
    for column, term in enumerate(terms):
        for number in term:
            matrix[:, column] *= coded[:, number]
    return matrix


@lru_cache(maxsize=64)
def _expanded(
    terms: tuple[Term, ...], shifts: tuple[Fraction, ...], spans: tuple[Fraction, ...]
) -> tuple[dict[Term, Fraction], ...]:
    """Insert z = (u - shift) / span into each term, exactly: its polynomial in u.

    Equations of one form share it; a study asks for it a thousand times.
    """
    polynomials = []
    for term in terms:
        polynomial = {term: Fraction(0)}
        scale = 1 / math.prod((spans[number] for number in term), start=Fraction(1))
        # Each factor (u - shift) of the product gives either its u or its shift.
        for kept in itertools.product((True, False), repeat=len(term)):
            share, rest = scale, []
            for number, keep in zip(term, kept, strict=True):
                if keep:
                    rest.append(number)
                else:
                    share *= -shifts[number]
            polynomial[tuple(rest)] = polynomial.get(tuple(rest), Fraction(0)) + share
        polynomials.append(polynomial)
    return tuple(polynomials)


def natural_shift(value: float, size: float, logged: bool) -> Fraction:
    """Return a center in units of `size`, as a fraction."""
    if logged:
        return Fraction(value) - Fraction(math.log(size))
    return Fraction(value) / Fraction(size)


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


Basis = Literal["factors", "groups"]


@dataclass(frozen=True)
class Form:
    """One form of equation: a polynomial of a degree, with or without squares.

    A logarithmic one is for the logarithm of the response, in the logarithms of the columns. With
    `basis` "groups" columns are dimensionless groups, and the response is divided by its scale. With
    `process` it is the mean of a Gaussian process, in logarithms of the response where that is positive.
    """

    name: str
    degree: int
    logarithmic: bool
    squares: bool = True
    basis: Basis = "factors"
    process: bool = False


# Not among the forms that are fitted to every study: it has no equation to write down.
GAUSSIAN_PROCESS = Form("Gaussian process", 1, True, process=True)
FORMS: Mapping[str, Form] = {
    form.name: form
    for form in (
        Form("linear", 1, False),
        Form("interactions", 2, False, squares=False),
        Form("quadratic", 2, False),
        Form("power law", 1, True),
        Form("log-interactions", 2, True, squares=False),
        Form("log-quadratic", 2, True),
        Form("log-cubic", 3, True),
        Form("group power law", 1, True, basis="groups"),
        Form("group quadratic", 2, True, basis="groups"),
        Form("group cubic", 3, True, basis="groups"),
    )
}


def form_named(name: str, field: str = "form") -> Form:
    """Form of this name; `InputError` if there is none."""
    known = {**FORMS, GAUSSIAN_PROCESS.name: GAUSSIAN_PROCESS}
    check_choice(field, name, known, "these are the forms of a regression equation")
    return known[name]


def form_terms(form: Form, columns: int, indicators: Sequence[int] = ()) -> tuple[Term, ...]:
    """The form's terms: constant, columns, squares, products, cubic ones.

    `indicators` are columns of 0 and 1.

    Examples
    --------
    >>> form_terms(FORMS["quadratic"], 2)
    ((), (0,), (1,), (0, 0), (1, 1), (0, 1))
    >>> form_terms(FORMS["interactions"], 2)
    ((), (0,), (1,), (0, 1))
    """
    # A column without powers of its own is what an indicator is.
    powerless = indicators if form.squares else range(columns)
    return polynomial_terms(columns, form.degree, indicators=powerless)


class FittedForm(InputModel):
    """A form with its coefficients: a function of its columns.

    Parameters
    ----------
    form : str
        Name of the form, for display; not used in calculations.
    factors : tuple of str
        Names of the k columns: factors such as "web_width", 0/1 columns of a category such as
        "web_outline=rectangle", or dimensionless groups such as "B/D_shm".
    logarithmic : bool
        Whether the polynomial gives the logarithm of the response.
    log_factors : tuple of bool
        Columns whose logarithm is used.
    center, half_range : tuple of float
        Of each column, or of its logarithm if used: z = (u - center) / half_range.
    terms : tuple of Term
        Products for the coefficients, each a tuple of columns' indices: () for the constant,
        (0,) for the first column, (0, 0) for its square, (0, 0, 1) for that times the second.
    coefficients : tuple of float
        Of the terms in z.
    process : GaussianProcess, optional
        What is added to the polynomial, its mean.

    Raises
    ------
    InputError
        If the numbers of entries differ, a term names a column that does not exist
        or occurs twice, a number is not finite, or a half range is not positive.
    """

    form: str
    factors: tuple[str, ...] = Field(min_length=1)
    logarithmic: bool
    log_factors: tuple[bool, ...]
    center: tuple[FiniteFloat, ...]
    half_range: tuple[FiniteFloat, ...]
    terms: tuple[Term, ...] = Field(min_length=1)
    coefficients: tuple[FiniteFloat, ...]
    process: GaussianProcess | None = None

    @model_validator(mode="after")
    def _equation_fits_together(self) -> Self:
        columns = len(self.factors)
        lengths = dict.fromkeys(("log_factors", "center", "half_range"), columns)
        for name, length in (lengths | {"coefficients": len(self.terms)}).items():
            number = len(getattr(self, name))
            if number != length:
                raise InputError(
                    f"{name}: given {number} values; allowed are {length}, because the "
                    f"equation has {columns} factors and {len(self.terms)} terms."
                )
        if not all(value > 0.0 for value in self.half_range):
            raise InputError(
                f"half_range: given {list(self.half_range)}; all must be positive, because every "
                "factor varies."
            )
        for term in self.terms:
            if list(term) != sorted(term) or not all(0 <= number < columns for number in term):
                raise InputError(
                    f"terms: given {list(term)}; allowed are numbers of columns, 0 to "
                    f"{columns - 1}, in rising order."
                )
        if len(set(self.terms)) != len(self.terms):
            raise InputError(
                f"terms: given {[list(term) for term in self.terms]}; each is allowed once."
            )
        return self

    def scaled(self, factor: float) -> Self:
        """Return the equation of a response `factor` times as large, a factor above zero."""
        if self.logarithmic:
            terms = dict(zip(self.terms, self.coefficients, strict=True))
            terms[()] = terms.get((), 0.0) + math.log(factor)
            return self.changed(terms=tuple(terms), coefficients=tuple(terms.values()))
        process = self.process
        if process is not None:
            process = replace(
                process,
                variance=process.variance * factor**2,
                weights=tuple(factor * weight for weight in process.weights),
            )
        coefficients = tuple(factor * coefficient for coefficient in self.coefficients)
        return self.changed(coefficients=coefficients, process=process)

    def predict(self, x: ArrayLike) -> Array:
        """Evaluate at points (..., k), the columns along the last axis: (...) array.

        Raises
        ------
        InputError
            If the last axis does not have k columns, or a logarithm is taken of a value that is not positive.
        """
        points = np.asarray(x, dtype=np.float64)
        if points.ndim == 0 or points.shape[-1] != len(self.factors):
            raise InputError(
                f"x: given an array of shape {points.shape}; its last axis must hold the "
                f"{len(self.factors)} factors {', '.join(self.factors)}."
            )
        coded = code(points, self.center, self.half_range, self.log_factors)
        total = self._polynomial(coded)
        if self.process is not None:
            total = total + self.process.predict(coded)
        return np.exp(total) if self.logarithmic else total

    def _polynomial(self, coded: Array) -> Array:
        total = np.zeros(coded.shape[:-1])
        for term, coefficient in zip(self.terms, self.coefficients, strict=True):
            product = np.full(coded.shape[:-1], coefficient)
            for number in term:
                product = product * coded[..., number]
            total = total + product
        return total

    def natural_coefficients(
        self, factor_sizes: Sequence[float] | None = None, response_size: float = 1.0
    ) -> dict[Term, float]:
        """Coefficients of the terms in columns (or their logarithms), not coded; rounded once.

        `factor_sizes` and `response_size` are the sizes of their units, 1e-3 for mm. The equation's own
        terms come first; a missing term that divides one of its own follows.
        """
        exact = {term: Fraction(0) for term in self.terms}
        polynomials = _expanded(self.terms, *self._natural_coding(factor_sizes))
        for polynomial, coefficient in zip(polynomials, self.coefficients, strict=True):
            scale = Fraction(coefficient)
            for term, value in polynomial.items():
                exact[term] = exact.get(term, Fraction(0)) + scale * value
        if self.logarithmic:
            exact[()] = exact.get((), Fraction(0)) - Fraction(math.log(response_size))
            return {term: float(value) for term, value in exact.items()}
        return {term: float(value / Fraction(response_size)) for term, value in exact.items()}

    def natural_transformation(self) -> tuple[tuple[Term, ...], Array]:
        """Terms in the order of `natural_coefficients`, and the matrix from coded coefficients to these."""
        columns = _expanded(self.terms, *self._natural_coding(None))
        terms = dict.fromkeys(itertools.chain(self.terms, *columns))
        rows = {term: row for row, term in enumerate(terms)}
        matrix = np.zeros((len(rows), len(columns)))
        for place, column in enumerate(columns):
            for term, value in column.items():
                matrix[rows[term], place] = float(value)
        return tuple(rows), matrix

    def _natural_coding(
        self, factor_sizes: Sequence[float] | None
    ) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
        """Return centers and half ranges in the columns' units, as fractions."""
        sizes = list(factor_sizes) if factor_sizes is not None else [1.0] * len(self.factors)
        logged = self.log_factors
        shifts = map(natural_shift, self.center, sizes, logged)
        spans = (
            Fraction(half) if log else Fraction(half) / Fraction(size)
            for half, size, log in zip(self.half_range, sizes, logged, strict=True)
        )
        return tuple(shifts), tuple(spans)


@dataclass(frozen=True)
class Encoding:
    """Description of the columns of an equation.

    A category of the labels a, b, c has the columns "name=b" and "name=c", which are 1 for that label
    and 0 for others; the first label has none. `logged`: which columns a form in logarithms may use as
    logarithms.
    """

    basis: Basis
    names: tuple[str, ...]
    logged: tuple[bool, ...]

    def columns(self, factors: Sequence[Factor], values: Array, dimensions: Dimensions) -> Array:
        """Columns of n designs: `values` (n, k) of the factors [SI], of a category the label's index.

        `dimensions` of the throws, name to (n,) values [m], are for groups only.
        """
        places = {factor.name: place for place, factor in enumerate(factors)}
        made = []
        for name in self.names:
            field, category, label = name.partition("=")
            if category:
                place = places[field]
                index = factors[place].labels.index(label)
                made.append((np.rint(values[:, place]) == index).astype(np.float64))
            elif self.basis == "groups":
                made.append(np.broadcast_to(group_named(name).value(dimensions), len(values)))
            else:
                made.append(values[:, places[name]])
        return np.column_stack(made)


def factor_encoding(factors: Sequence[Factor], values: Array) -> Encoding:
    """Use the factors themselves as columns; `values` (n, k) at the runs.

    Labels that no run has get no column.

    The logarithm of a factor whose range includes zero, such as an optional fillet, is not used.
    """
    names: list[str] = []
    logged: list[bool] = []
    for place, factor in enumerate(factors):
        if factor.labels:
            names += _category_columns(factor, values[:, place])
            logged += [False] * (len(names) - len(logged))
        else:
            names.append(factor.name)
            logged.append(factor.lowest > 0.0)
    return Encoding("factors", tuple(names), tuple(logged))


def group_encoding(
    factors: Sequence[Factor], values: Array, dimensions: Mapping[str, Array]
) -> Encoding:
    """Use varying dimensionless groups as columns, and categories.

    Arguments as of `Encoding.columns`, at the runs.

    Raises
    ------
    InputError
        If a factor is not a length, so that groups of lengths do not follow it; or if more groups vary than
        can be separated, so that an equation in some of them would not apply to other sizes.
    """
    numbers = [factor for factor in factors if not factor.labels]
    odd = [f.name for f in numbers if f.unit and f.name not in dimensions]
    if odd:
        raise InputError(
            f"groups: given the factor {odd[0]}; allowed are the main dimensions of the throw and "
            "ratios, because groups are made of these."
        )
    groups = group_values({name: column for name, column in dimensions.items() if is_length(name)})
    chosen = independent_groups(groups, len(numbers))
    others = [name for name, column in groups.items() if name not in chosen and _varies(column)]
    if others or not chosen:
        raise InputError(
            f"groups: given {len(numbers)} factors that make {len(chosen) + len(others)} groups vary, "
            f"{', '.join((*chosen, *others))}; allowed are as many factors as groups, because an "
            "equation in some of them does not carry over to other sizes."
        )
    categories = [
        name
        for place, factor in enumerate(factors)
        if factor.labels
        for name in _category_columns(factor, values[:, place])
    ]
    logged = [group_named(name).logged for name in chosen] + [False] * len(categories)
    return Encoding("groups", (*chosen, *categories), tuple(logged))


def _category_columns(factor: Factor, column: Array) -> list[str]:
    present = set(np.rint(column).astype(int).tolist())
    return [
        f"{factor.name}={label}"
        for index, label in enumerate(factor.labels)
        if index and index in present and len(present) > 1
    ]


def constant_groups(dimensions: Mapping[str, Array]) -> dict[str, float]:
    """Return the groups that are constant over all designs, with their value; absent features have none."""
    groups = group_values({name: column for name, column in dimensions.items() if is_length(name)})
    return {
        name: float(column[0])
        for name, column in groups.items()
        if column[0] and not _varies(column)
    }


def _varies(column: Array) -> bool:
    return bool(np.ptp(column) > 1e-9 * float(np.max(np.abs(column))))


# Two values of a column are one level if they differ by less than this share of its range.
_SAME_LEVEL = 1e-9


def is_indicator(name: str) -> bool:
    """Whether a column of this name is the 0/1 column of a category, such as "web_outline=b"."""
    return "=" in name


def determined_terms(
    form: Form,
    factors: tuple[str, ...],
    points: Array,
    rows: Callable[[Sequence[Term]], Array],
    sloped: Collection[int] = (),
) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """Split the form's terms into those that the runs may determine, and the others.

    `rows` gives the rows of least squares; the columns `sloped` have slopes, so that a level counts twice.
    """
    indicators = [number for number, name in enumerate(factors) if is_indicator(name)]
    ordered = np.sort(points, axis=0)
    steps = np.diff(ordered, axis=0) > _SAME_LEVEL * (ordered[-1] - ordered[0])
    levels = 1 + np.count_nonzero(steps, axis=0)
    levels[list(sloped)] *= 2
    candidates = []
    for term in form_terms(form, len(factors), indicators):
        # The 0/1 columns of one category are never 1 together.
        categories = [factors[n].partition("=")[0] for n in term if is_indicator(factors[n])]
        if len(set(categories)) == len(categories):
            candidates.append(term)
    kept = [
        term
        for term in candidates
        if all(levels[number] >= needed for number, needed in levels_needed(term).items())
    ]
    matrix = rows(kept)
    if (form.degree > 2 or sloped) and len(kept) <= len(matrix):
        kept = _independent(kept, matrix)
    return tuple(kept), tuple(term for term in candidates if term not in kept)


def _independent(terms: Sequence[Term], columns: Array) -> list[Term]:
    """Leave out the terms that follow from earlier ones at the runs, and those that contain them."""
    directions = np.empty((len(columns), 0))
    kept: list[Term] = []
    left_out: set[Term] = set()
    for place, term in enumerate(terms):
        column = columns[:, place]
        rest = column.copy()
        for _ in range(2):  # twice, or round-off would pass for an own part
            rest -= directions @ (directions.T @ rest)
        length = float(np.linalg.norm(rest))
        dependent = length <= 1e2 * DEPENDENT_COLUMN * float(np.linalg.norm(column))
        if dependent or not left_out.isdisjoint(divisors(term)):
            left_out.add(term)
            continue
        kept.append(term)
        directions = np.column_stack([directions, rest / length])
    return kept
