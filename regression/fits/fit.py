"""A form fitted to a response: its equation in words and numbers, and how reliable its coefficients are."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array
from crankbase.diagrams import new_axes
from crankbase.frames import Axes, table
from crankbase.quantity import percent
from crankbase.results import Internal, Part, Quantity, Result, result
from regression.fits.equation_text import equation_text, term_effects, term_symbols
from regression.fits.forms import FittedForm, Term, term_name
from regression.fits.selection import Figure, FitErrors, LeastSquares
from regression.plots import draw_effects

# Above these a coefficient is poorly told from the others, a run decides nearly alone.
LARGEST_VIF = 10.0
LARGEST_LEVERAGE = 0.95


@result("symbols", "coefficient", "t")
class CodedTerm(Result):
    """A term in coded variables, -1 to 1 over the runs."""

    term: str
    symbols: str
    coefficient: Annotated[float, Quantity(".coded_unit")]
    standard_error: Annotated[float | None, Quantity(".coded_unit")]
    t: Figure
    variance_inflation: Figure


@result(
    "form",
    "coefficient_count",
    "largest_error",
    "largest_heldout_error",
    "q_squared",
    "runs",
    "heldout_runs",
)
class Fit(FitErrors):
    """A form fitted to a response: its equation, its coefficients and its errors.

    Attributes
    ----------
    fitted : FittedForm
        The equation.
    statistics : LeastSquares
        Of the polynomial in coded variables; in a form in logarithms of the response, of its
        logarithm. None of a Gaussian process.
    runs, heldout_runs : int
        Numbers of runs fitted and held out.
    lowest, highest : tuple of float
        Of each column at the runs.
    symbol, unit : str
        Of the response.
    column_units : tuple of str
        Unit of each column that is a factor.
    """

    fitted: Internal[FittedForm]
    statistics: Internal[LeastSquares | None]
    runs: Internal[int]
    heldout_runs: Internal[int]
    lowest: Internal[tuple[float, ...]]
    highest: Internal[tuple[float, ...]]
    symbol: Internal[str] = "y"
    unit: Internal[str] = ""
    column_units: Internal[tuple[str, ...]] = ()

    def __repr__(self) -> str:
        """Summarize the fit in a line; coefficients and statistics would fill screens."""
        heldout = self.largest_heldout_error
        judged = (
            "" if heldout is None else f", {percent(heldout, 3)} % at {self.heldout_runs} held out"
        )
        return (
            f"Fit({self.form} of {', '.join(self.factors)}: {self.coefficient_count} coefficients, largest "
            f"error {percent(self.largest_error, 3)} % at {self.runs} runs{judged})"
        )

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.fitted.factors

    @property
    def term_names(self) -> tuple[str, ...]:
        """Names of the terms, such as "web_width^2" or "ln(web_width)"."""
        return names_of_terms(self.fitted.terms, self.factors, self.fitted.log_factors)

    @property
    def coded_coefficients(self) -> dict[str, float]:
        """Coefficients in the coded variables, -1 ... 1 over the runs, by the name of their term."""
        return dict(zip(self.term_names, self.fitted.coefficients, strict=True))

    @property
    def variance_inflation(self) -> dict[str, float]:
        """Variance inflation of the coded terms after the constant, by name; none of a Gaussian process."""
        if self.statistics is None:
            return {}
        values = self.statistics.variance_inflation.tolist()
        return dict(zip(self.term_names[1:], values, strict=True))

    @cached_property
    def equation(self) -> Part[str]:
        """The equation in the units of the field."""
        return equation_text(self.fitted, symbol=self.symbol, unit=self.unit, basis=self.basis)

    @cached_property
    def coefficients(self) -> Annotated[Mapping[str, float], Quantity(".coefficient_units")]:
        """Natural coefficients (SI units) by the name of their term, such as "web_width^2"."""
        natural = self.fitted.natural_coefficients()
        names = names_of_terms(list(natural), self.factors, self.fitted.log_factors)
        return dict(zip(names, natural.values(), strict=True))

    @cached_property
    def natural_standard_errors(
        self,
    ) -> Annotated[
        Mapping[str, float] | None, Quantity(".coefficient_units", key="standard_errors")
    ]:
        """Standard errors of `coefficients`; None without degrees of freedom."""
        covariance = None if self.statistics is None else self.statistics.covariance
        if covariance is None:
            return None
        terms, change = self.fitted.natural_transformation()
        errors = np.sqrt(np.einsum("ij,jk,ik->i", change, covariance, change))
        names = names_of_terms(terms, self.factors, self.fitted.log_factors)
        return dict(zip(names, errors.tolist(), strict=True))

    @cached_property
    def coefficient_units(self) -> Part[str | Mapping[str, str]]:
        """Of the natural coefficients by term, or one for all."""
        form, unit = self.fitted, self.coded_unit
        columns = [
            "" if logarithm else column_unit
            for column_unit, logarithm in zip(
                self.column_units or ("",) * len(form.factors), form.log_factors, strict=True
            )
        ]
        if not any(columns):
            return unit
        terms = [
            " ".join(filter(None, (columns[place] for place in term)))
            for term in form.natural_transformation()[0]
        ]
        over = unit if unit == "1" else f"({unit})"
        by_term = [f"{over}/({term})" if term else unit for term in terms]
        return dict(zip(self.coefficients, by_term, strict=True))

    @cached_property
    def coded_unit(self) -> Part[str]:
        """Of the coded coefficients."""
        return "1" if self.fitted.logarithmic or self.basis == "groups" else self.unit or "1"

    @cached_property
    def coded(self) -> Part[tuple[CodedTerm, ...]]:
        """The terms in coded variables."""
        inflation, count = self.variance_inflation, len(self.fitted.terms)
        errors, t_values = (
            [None] * count if numbers is None else numbers.tolist()
            for numbers in map(self._statistic, ("standard_errors", "t_values"))
        )
        return tuple(
            CodedTerm(name, symbols, value, error, t, inflation.get(name))
            for (name, value), symbols, error, t in zip(
                self.coded_coefficients.items(),
                term_symbols(self.fitted),
                errors,
                t_values,
                strict=True,
            )
        )

    def _statistic(self, name: str) -> Any:
        """Return one of the least squares; None of a Gaussian process."""
        return getattr(self.statistics, name, None)

    @cached_property
    def f_value(self) -> Figure:
        """F of the fit."""
        number: float | None = self._statistic("f_value")
        return number

    @cached_property
    def aic(self) -> Figure:
        """Akaike's criterion."""
        number: float | None = self._statistic("aic")
        return number

    @cached_property
    def bic(self) -> Figure:
        """The Bayesian criterion."""
        number: float | None = self._statistic("bic")
        return number

    @cached_property
    def condition_number(self) -> Figure:
        """Of the matrix in coded variables; None of a Gaussian process."""
        number: float | None = self._statistic("condition_number")
        return number

    @cached_property
    def largest_variance_inflation(self) -> Figure:
        """Of the terms after the constant."""
        return max(self.variance_inflation.values(), default=None)

    @cached_property
    def largest_leverage(self) -> Figure:
        """Of the runs."""
        return None if self.statistics is None else float(np.max(self.statistics.leverage))

    @cached_property
    def warnings(self) -> Part[tuple[str, ...]]:
        """Remarks on the coefficients, one sentence each."""
        warnings = []
        inflated = [name for name, value in self.variance_inflation.items() if value > LARGEST_VIF]
        if inflated:
            more = len(inflated) - 6
            listed = ", ".join(inflated[:6]) + (f" and {more} more" if more > 0 else "")
            warnings.append(
                f"Variance inflation above {LARGEST_VIF:g} of {listed}: "
                "these coefficients are correlated, and only their combined effect is meaningful."
            )
        leverage = np.array([]) if self.statistics is None else self.statistics.leverage
        high = np.flatnonzero(leverage > LARGEST_LEVERAGE)
        if high.size:
            warnings.append(
                f"Leverage above {LARGEST_LEVERAGE:g} of {high.size} of {self.runs} runs: each of them "
                "nearly determines a coefficient alone, so its error at the runs is not meaningful."
            )
        return tuple(warnings)

    def predict(self, x: ArrayLike) -> Array:
        """Evaluate at points (..., k); see `FittedForm.predict`."""
        return self.fitted.predict(x)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the coded coefficients in the order of their size (Pareto); the constant is left out.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        """
        names, values = term_effects(self.fitted)
        logarithmic = self.fitted.logarithmic
        label = "coded coefficient of ln y [%]" if logarithmic else "coded coefficient [unit of y]"
        axes = new_axes(axes)
        draw_effects(axes, names, values / (0.01 if logarithmic else 1.0), label, self.form)
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the terms: natural coefficients, in SI units, and coded ones.

        Returns
        -------
        pandas.DataFrame
            ``term``, ``coefficient``, ``coded_coefficient`` (0 for a term that only the natural
            equation has) and, with degrees of freedom, ``standard_error`` of the natural one.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        natural, coded = self.coefficients, self.coded_coefficients
        mixed = "SI, by term"
        columns: dict[str, tuple[Any, str]] = {
            "term": (list(natural), ""),
            "coefficient": (list(natural.values()), mixed),
            "coded_coefficient": ([coded.get(name, 0.0) for name in natural], "unit of y"),
        }
        errors = self.natural_standard_errors
        if errors is not None:
            columns["standard_error"] = ([errors[name] for name in natural], mixed)
        return table(columns)


def names_of_terms(
    terms: Sequence[Term], factors: Sequence[str], log_factors: Sequence[bool]
) -> tuple[str, ...]:
    """Name terms of columns, those in logarithms "ln(web_width)"."""
    names = [f"ln({name})" if log else name for name, log in zip(factors, log_factors, strict=True)]
    return tuple(term_name(term, names) for term in terms)
