"""The forms of a regression equation, and the equation itself as a function.

A form is a polynomial in coded variables z: the columns (factors of a study, or dimensionless
groups of the throw's dimensions), or their logarithms, shifted and scaled so that the runs span
-1 ... 1. Evaluated this way it loses no digits; the natural coefficients, which multiply the
columns themselves, follow by exact expansion.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.scalars import is_number
from crankbase.errors import InputError
from regression.fits.terms import Term, code, expand, natural_shift, polynomial_terms

Basis = Literal["factors", "groups"]


@dataclass(frozen=True)
class Form:
    """One form of equation.

    Parameters
    ----------
    name : str
    degree : int
        Of its polynomial.
    logarithmic : bool
        Whether it is a form for the logarithm of the response, in the logarithms of the columns.
    squares : bool
        Whether columns are multiplied with themselves, not only with each other.
    basis : {"factors", "groups"}
        Whether its columns are the study's factors or dimensionless groups; with groups the response is
        divided by its scale.
    """

    name: str
    degree: int
    logarithmic: bool
    squares: bool = True
    basis: Basis = "factors"


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


def form_named(name: str) -> Form:
    """Return the form of this name.

    Raises
    ------
    InputError
        If there is none.
    """
    if name not in FORMS:
        raise InputError(
            f"form: given {name!r}; allowed are {', '.join(FORMS)}, the forms of a regression "
            "equation."
        )
    return FORMS[name]


def form_terms(form: Form, columns: int, indicators: Sequence[int] = ()) -> tuple[Term, ...]:
    """Return the form's terms: constant, columns, squares, products, cubic ones.

    Parameters
    ----------
    form : Form
    columns : int
    indicators : sequence of int
        Columns of 0 and 1, which have no powers.

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


@dataclass(frozen=True)
class FittedForm:
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

    Raises
    ------
    InputError
        If the numbers of entries differ, a term names a column that does not exist
        or occurs twice, a number is not finite, or a half range is not positive.
    """

    form: str
    factors: tuple[str, ...]
    logarithmic: bool
    log_factors: tuple[bool, ...]
    center: tuple[float, ...]
    half_range: tuple[float, ...]
    terms: tuple[Term, ...]
    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        columns = len(self.factors)
        lengths = dict.fromkeys(("log_factors", "center", "half_range"), columns)
        for name, length in (lengths | {"coefficients": len(self.terms)}).items():
            number = len(getattr(self, name))
            if number != length:
                raise InputError(
                    f"{name}: given {number} values; allowed are {length}, because the "
                    f"equation has {columns} factors and {len(self.terms)} terms."
                )
        for name in ("center", "half_range", "coefficients"):
            numbers = getattr(self, name)
            if not all(map(is_number, numbers)):
                raise InputError(f"{name}: given {list(numbers)}; all numbers must be finite.")
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

    def predict(self, x: ArrayLike) -> NDArray[np.float64]:
        """Evaluate at points.

        Parameters
        ----------
        x : (..., k) array_like
            The columns along the last axis.

        Returns
        -------
        (...) ndarray

        Raises
        ------
        InputError
            If the last axis does not have k columns, or a logarithm is taken of a value that
            is not positive.
        """
        points = np.asarray(x, dtype=np.float64)
        if points.ndim == 0 or points.shape[-1] != len(self.factors):
            raise InputError(
                f"x: given an array of shape {points.shape}; its last axis must hold the "
                f"{len(self.factors)} factors {', '.join(self.factors)}."
            )
        total = self._polynomial(code(points, self.center, self.half_range, self.log_factors))
        return np.exp(total) if self.logarithmic else total

    def _polynomial(self, coded: NDArray[np.float64]) -> NDArray[np.float64]:
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
        """Coefficients of the terms in the columns (or their logarithms), not coded.

        Parameters
        ----------
        factor_sizes : sequence of float, optional
            Size of each column's unit, 1e-3 for mm; 1 otherwise.
        response_size : float, optional
            Size of the response's unit.

        Returns
        -------
        dict of Term to float
            Rounded once from the exact expansion. The equation's own terms come first; a missing term
            that divides one of its own follows.
        """
        shifts, spans = self._natural_coding(factor_sizes)
        exact = expand(self.terms, self.coefficients, shifts, spans)
        if self.logarithmic:
            exact[()] = exact.get((), Fraction(0)) - Fraction(math.log(response_size))
            return {term: float(value) for term, value in exact.items()}
        return {term: float(value / Fraction(response_size)) for term, value in exact.items()}

    def natural_transformation(self) -> tuple[tuple[Term, ...], NDArray[np.float64]]:
        """Return the matrix from coded to natural coefficients.

        Returns
        -------
        terms : tuple of Term
            In the order of `natural_coefficients`.
        matrix : (len(terms), number of coefficients) ndarray
            Natural coefficients are matrix @ coded coefficients.
        """
        shifts, spans = self._natural_coding(None)
        columns = [expand([term], [1.0], shifts, spans) for term in self.terms]
        rows = {term: row for row, term in enumerate(self.natural_coefficients())}
        matrix = np.zeros((len(rows), len(columns)))
        for place, column in enumerate(columns):
            for term, value in column.items():
                matrix[rows[term], place] = float(value)
        return tuple(rows), matrix

    def _natural_coding(
        self, factor_sizes: Sequence[float] | None
    ) -> tuple[list[Fraction], list[Fraction]]:
        """Return centers and half ranges in the columns' units, as fractions."""
        sizes = list(factor_sizes) if factor_sizes is not None else [1.0] * len(self.factors)
        logged = self.log_factors
        shifts = [natural_shift(*given) for given in zip(self.center, sizes, logged, strict=True)]
        spans = [
            Fraction(half) if log else Fraction(half) / Fraction(size)
            for half, size, log in zip(self.half_range, sizes, logged, strict=True)
        ]
        return shifts, spans
