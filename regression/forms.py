"""The forms of a regression equation, their evaluation, and their text in natural units.

A form is a polynomial in coded variables z: the factors (or their logarithms) shifted and scaled
so that the runs span -1 ... 1. Evaluated this way it loses no digits; the natural coefficients,
which multiply the factors themselves, follow by exact expansion.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.errors import InputError
from geometry.model import field_extra
from geometry.quantity import DISPLAY_UNITS
from geometry.throw import CrankThrow

# A term is the tuple of the factors' numbers that it multiplies: () is the constant, (0,) the
# first factor, (0, 0) its square, (0, 1) the product of the first two.
Term = tuple[int, ...]

# Evaluating a printed equation must give the prediction within this share (a tenth of what is
# promised to the reader).
PRINTED_EQUATION_ERROR = 1e-5
SMALLEST_DIGITS = 6
LARGEST_DIGITS = 17
# Up to this many factors a printed equation is tried at every corner and middle of the box.
_FACTORS_TRIED_FULLY = 6


@dataclass(frozen=True)
class Form:
    """One form: its polynomial degree, and whether it is one in logarithms."""

    name: str
    degree: int
    logarithmic: bool


FORMS: Mapping[str, Form] = {
    form.name: form
    for form in (
        Form("linear", 1, False),
        Form("quadratic", 2, False),
        Form("log-quadratic", 2, True),
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


def form_terms(form: Form, factors: int) -> tuple[Term, ...]:
    """Return the form's terms: constant, factors, squares, products.

    Examples
    --------
    >>> form_terms(FORMS["quadratic"], 2)
    ((), (0,), (1,), (0, 0), (1, 1), (0, 1))
    """
    terms: list[Term] = [(), *((number,) for number in range(factors))]
    if form.degree == 2:
        terms += [(number, number) for number in range(factors)]
        terms += list(itertools.combinations(range(factors), 2))
    return tuple(terms)


def term_name(term: Term, factors: Sequence[str], logarithmic: bool) -> str:
    """Name a term in words of the factors, such as "web_width^2"; "1" is the constant."""
    names = [f"ln({factors[number]})" if logarithmic else factors[number] for number in term]
    if not names:
        return "1"
    if len(names) == 2 and names[0] == names[1]:
        return f"{names[0]}^2"
    return " * ".join(names)


@dataclass(frozen=True)
class FittedForm:
    """A form with its coefficients: a function of the factors.

    Parameters
    ----------
    form : str
        "linear", "quadratic" or "log-quadratic".
    factors : tuple of str
        Names of the k factors.
    center, half_range : tuple of float
        Of each factor's runs (of their natural logarithms in the log form): z = (x - center) /
        half_range.
    coefficients : tuple of float
        Of the terms in z, in the order of `form_terms`.

    Raises
    ------
    InputError
        If the numbers of entries do not fit each other, or a half range is not positive.
    """

    form: str
    factors: tuple[str, ...]
    center: tuple[float, ...]
    half_range: tuple[float, ...]
    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        factors = len(self.factors)
        needed = len(form_terms(form_named(self.form), factors))
        for name, values, length in (
            ("center", self.center, factors),
            ("half_range", self.half_range, factors),
            ("coefficients", self.coefficients, needed),
        ):
            if len(values) != length:
                raise InputError(
                    f"{name}: given {len(values)} numbers; allowed are {length}, because the "
                    f"{self.form} form has {factors} factors."
                )
            if not all(math.isfinite(value) for value in values):
                raise InputError(f"{name}: given {list(values)}; all numbers must be finite.")
        if not all(value > 0.0 for value in self.half_range):
            raise InputError(
                f"half_range: given {list(self.half_range)}; all must be positive, because every "
                "factor varies."
            )

    @property
    def logarithmic(self) -> bool:
        """Whether the form is a polynomial in logarithms."""
        return form_named(self.form).logarithmic

    @property
    def terms(self) -> tuple[Term, ...]:
        """The terms that the coefficients belong to."""
        return form_terms(form_named(self.form), len(self.factors))

    def predict(self, x: ArrayLike) -> NDArray[np.float64]:
        """Evaluate at points.

        Parameters
        ----------
        x : (..., k) array_like
            The factors along the last axis.

        Returns
        -------
        (...) ndarray

        Raises
        ------
        InputError
            If the last axis does not hold the k factors, or the log form meets a value that is
            not positive.
        """
        points = np.asarray(x, dtype=np.float64)
        if points.ndim == 0 or points.shape[-1] != len(self.factors):
            raise InputError(
                f"x: given an array of shape {points.shape}; its last axis must hold the "
                f"{len(self.factors)} factors {', '.join(self.factors)}."
            )
        total = self._polynomial(code(points, self.center, self.half_range, self.logarithmic))
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
        """Coefficients of the same terms in the factors themselves, not coded.

        Parameters
        ----------
        factor_sizes : sequence of float, optional
            Size of each factor's unit, 1e-3 for mm; 1 otherwise.
        response_size : float, optional
            Size of the response's unit.

        Returns
        -------
        dict of term to float
            Rounded once from the exact expansion.
        """
        sizes = list(factor_sizes) if factor_sizes is not None else [1.0] * len(self.factors)
        if self.logarithmic:
            shifts = [
                Fraction(center) - Fraction(math.log(size))
                for center, size in zip(self.center, sizes, strict=True)
            ]
            spans = [Fraction(half) for half in self.half_range]
        else:
            shifts = [
                Fraction(c) / Fraction(size) for c, size in zip(self.center, sizes, strict=True)
            ]
            spans = [
                Fraction(half) / Fraction(size)
                for half, size in zip(self.half_range, sizes, strict=True)
            ]
        exact = _expand(self.terms, self.coefficients, shifts, spans)
        if self.logarithmic:
            exact[()] -= Fraction(math.log(response_size))
            return {term: float(value) for term, value in exact.items()}
        return {term: float(value / Fraction(response_size)) for term, value in exact.items()}


def code(
    points: NDArray[np.float64],
    center: Sequence[float],
    half_range: Sequence[float],
    logarithmic: bool,
) -> NDArray[np.float64]:
    """Turn factors (..., k) into coded variables, -1 ... 1 over the runs.

    Raises
    ------
    InputError
        If a logarithm is asked of a value that is not positive.
    """
    if logarithmic:
        if not np.all(points > 0.0):
            raise InputError(
                f"x: given {float(np.min(points)):g}; allowed are positive values, because the "
                "log-quadratic form takes their logarithm."
            )
        points = np.log(points)
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


def _expand(
    terms: Sequence[Term],
    coefficients: Sequence[float],
    shifts: Sequence[Fraction],
    spans: Sequence[Fraction],
) -> dict[Term, Fraction]:
    """Insert z = (u - shift) / span into a polynomial of degree 2 at most."""
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
            result[tuple(rest)] += share
    return result


# ---------------------------------------------------------------------------- text for people


@dataclass(frozen=True)
class FactorLabel:
    """How a factor stands in a printed equation: its symbol, its unit and that unit's size."""

    symbol: str
    unit: str
    size: float


def factor_label(name: str) -> FactorLabel:
    """Label of a throw's dimension from its declaration; of another factor its plain name.

    Examples
    --------
    >>> factor_label("web_width")
    FactorLabel(symbol='B', unit='mm', size=0.001)
    """
    declared = CrankThrow.model_fields.get(name)
    if declared is None:
        return FactorLabel(name, "", 1.0)
    unit = str(field_extra(declared, "unit") or "")
    shown, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    return FactorLabel(str(field_extra(declared, "symbol") or name), shown, size)


def equation_text(
    fitted: FittedForm,
    *,
    symbol: str,
    unit: str,
    labels: Mapping[str, FactorLabel] | None = None,
    scale: float | None = None,
) -> str:
    """Write the equation in natural units, with digits enough to calculate with it.

    Evaluated by hand it gives the prediction within 1e-4 of its value all over the box of the
    runs: numbers carry 6 digits, or as many more as that takes.

    Parameters
    ----------
    fitted : FittedForm
        The equation; its factors and response in SI units.
    symbol, unit : str
        Symbol and SI unit of the response, such as "e_n" and "m/N".
    labels : mapping, optional
        Factor name to its label, where `factor_label` does not do.
    scale : float, optional
        Power of ten that is taken out of the response; chosen from its size otherwise.

    Returns
    -------
    str
        ``e_n = 1e-9 * (6.1 - 0.0583 B + ...) m/N, lengths in mm`` or, for the log form,
        ``ln(e_n / (1e-9 m/N)) = 7.2 - 1.1 ln(B/mm) + ...``
    """
    shown = [(labels or {}).get(name) or factor_label(name) for name in fitted.factors]
    size = _response_scale(fitted) if scale is None else scale
    natural = fitted.natural_coefficients([label.size for label in shown], size)
    digits = _digits_needed(fitted, natural, [label.size for label in shown])
    names = [_symbol_text(label, fitted.logarithmic) for label in shown]
    total = _sum_text(natural, names, digits)
    power = "" if size == 1.0 else f"{size:g}".replace("e-0", "e-").replace("e+0", "e")
    if fitted.logarithmic:
        reference = " ".join(part for part in (power, unit) if part)
        left = f"ln({symbol} / ({reference}))" if reference else f"ln({symbol})"
        return f"{left} = {total}"
    bracket = f"{power} * ({total})" if power else f"({total})"
    return f"{symbol} = {bracket} {unit}".rstrip() + _units_text(shown)


def _response_scale(fitted: FittedForm) -> float:
    """Return the power of 1000 near the response in the middle of the box."""
    middle = np.asarray(fitted.center)
    value = abs(float(fitted.predict(np.exp(middle) if fitted.logarithmic else middle)))
    if value == 0.0:
        return 1.0
    return float(f"1e{3 * math.floor((math.log10(value) + 0.5) / 3.0)}")


def _symbol_text(label: FactorLabel, logarithmic: bool) -> str:
    if not logarithmic:
        return label.symbol
    return f"ln({label.symbol}/{label.unit})" if label.unit else f"ln({label.symbol})"


def _sum_text(natural: Mapping[Term, float], names: Sequence[str], digits: int) -> str:
    parts: list[str] = []
    for term, value in natural.items():
        if value == 0.0 and term:
            continue
        sign = "-" if value < 0.0 else "+"
        lead = ("-" if value < 0.0 else "") if not parts else f" {sign} "
        parts.append(f"{lead}{abs(value):.{digits}g}{_product_text(term, names)}")
    return "".join(parts)


def _product_text(term: Term, names: Sequence[str]) -> str:
    if not term:
        return ""
    if len(term) == 2 and term[0] == term[1]:
        name = names[term[0]]
        return f" ({name})^2" if "(" in name else f" {name}^2"
    return "".join(f" {names[number]}" for number in term)


def _units_text(labels: Sequence[FactorLabel]) -> str:
    units = {label.unit for label in labels}
    if units == {"mm"}:
        return ", lengths in mm"
    stated = [f"{label.symbol} in {label.unit}" for label in labels if label.unit]
    return ", " + ", ".join(stated) if stated else ""


def _digits_needed(
    fitted: FittedForm, natural: Mapping[Term, float], sizes: Sequence[float]
) -> int:
    """Return the fewest digits, 6 or more, with which the printed equation predicts the same."""
    coded = _trial_points(len(fitted.factors))
    raw = np.asarray(fitted.center) + coded * np.asarray(fitted.half_range)
    units = raw - np.log(sizes) if fitted.logarithmic else raw / np.asarray(sizes)
    matrix = design_matrix(list(natural), units)
    exact = matrix @ np.array(list(natural.values()))
    for digits in range(SMALLEST_DIGITS, LARGEST_DIGITS):
        rounded = np.array([float(f"{value:.{digits}g}") for value in natural.values()])
        printed = matrix @ rounded
        if fitted.logarithmic:
            # A difference of logarithms is the relative difference of the response.
            error = float(np.max(np.abs(printed - exact)))
        else:
            # Where the response passes through zero no relative error can be small.
            floor = 1e-3 * float(np.max(np.abs(exact)))
            error = float(np.max(np.abs(printed - exact) / np.maximum(np.abs(exact), floor)))
        if error <= PRINTED_EQUATION_ERROR:
            return digits
    return LARGEST_DIGITS


def _trial_points(factors: int) -> NDArray[np.float64]:
    if factors <= _FACTORS_TRIED_FULLY:
        return np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=factors)))
    generator = np.random.default_rng(0)
    return generator.integers(-1, 2, size=(2000, factors)).astype(np.float64)
