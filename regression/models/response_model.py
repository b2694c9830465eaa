"""One response of a compliance model: its equation, the range it was fitted over, and its errors."""

import math
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field, FiniteFloat, model_validator

from crankbase.choices import check_one_each
from crankbase.errors import InputError
from crankbase.sentences import finished
from regression.fits.forms import FittedForm, code
from regression.throw_values import format_value

if TYPE_CHECKING:  # a lookup needs no fits
    from regression.fits.fit import Fit

# Between a category's name and its label in the name of a 0/1 column: "web_outline=rectangle".
IS = "="
# The runs span -1 to 1 in coded numbers; a study's range may be so many times as wide where only a
# part of it has results.
FARTHEST = 1e3
# The logarithm of a response stays within this at the runs, as every number that is calculated with
# stays within 1e60.
LARGEST_LOGARITHM = 138.0
# No form has terms of so many factors.
MOST_FACTORS = 12

# What a fit says of its errors, under the same names.
JUDGED = (
    "r_squared",
    "q_squared",
    "largest_error",
    "mean_error",
    "largest_heldout_error",
    "mean_heldout_error",
    "runs",
    "heldout_runs",
    "band_error",
    "band_designs",
)

Share = Annotated[FiniteFloat, Field(ge=0.0, description="a relative error")]
Determination = Annotated[FiniteFloat, Field(le=1.0, description="a coefficient of determination")]


class ResponseModel(FittedForm):
    """One response of a compliance model: its equation, range and errors.

    Parameters
    ----------
    form : str
        Name of the form, such as "log-quadratic".
    basis : {"factors", "groups"}
        What its columns are: factors of the study, or dimensionless groups of the throw's dimensions;
        then the equation gives the response divided by its scale.
    factors : tuple of str
        Names of the k columns.
    logarithmic, log_factors, terms, center, half_range, coefficients
        The equation in coded variables, as in `regression.fits.forms.FittedForm`; this is
        evaluated.
    lowest, highest : tuple of float
        Range of each column in the runs [SI].
    symbol, unit, support : str
        Symbol, SI unit and support of the response.
    r_squared, q_squared : float
        At the runs; the second leaves each run out of its own prediction and may be None.
    largest_error, mean_error, largest_heldout_error, mean_heldout_error : float or None
        Relative to the finite element value, at the runs and at held-out designs.
    runs, heldout_runs : int
        Numbers of finite element runs fitted and held out.
    band_error : float or None
        The error not exceeded by 95 % of new designs, by designs not used for its equation; None
        without such designs.
    band_designs : int
        Number of these designs.
    largest_fe_error : float or None
        Largest estimate of the relative error of the finite element values themselves.
    too_small : bool
        Whether this error makes them too small only; corrected ones err either way.
    process : GaussianProcess, optional
        What is added to the equation's polynomial.
    dropped_terms : tuple of str
        Terms of the form that the selection left out.
    equation : str
        The equation in natural units, for people.

    Raises
    ------
    InputError
        If a field is missing, unknown or contradicts another one; if an error is negative; if the
        equation's coding does not match its range, or its coefficients are impossible for the response.
    """

    section: ClassVar[str] = "response"
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    basis: Literal["factors", "groups"] = "factors"
    lowest: tuple[FiniteFloat, ...]
    highest: tuple[FiniteFloat, ...]
    symbol: str
    unit: str
    support: str
    r_squared: Determination
    q_squared: Determination | None
    largest_error: Share
    mean_error: Share | None = None
    largest_heldout_error: Share | None
    mean_heldout_error: Share | None = None
    runs: int = Field(ge=1, description="a number of runs")
    heldout_runs: int = Field(ge=0, description="a number of runs")
    band_error: Share | None = None
    band_designs: int = Field(default=0, ge=0, description="a number of designs")
    largest_fe_error: Share | None = None
    too_small: Literal[False] = False
    dropped_terms: tuple[str, ...] = ()
    equation: str

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        longest = max(map(len, self.terms))
        if longest > MOST_FACTORS:
            raise InputError(
                f"terms: given one of {longest} factors; allowed are up to {MOST_FACTORS}, because no form "
                "has longer ones."
            )
        if len(set(self.factors)) != len(self.factors):
            raise InputError(f"factors: given {list(self.factors)}; each is allowed once.")
        for name, values in (("lowest", self.lowest), ("highest", self.highest)):
            check_one_each(name, len(values), len(self.factors), "factors")
        for factor, low, high in zip(self.factors, self.lowest, self.highest, strict=True):
            if not low < high:
                raise InputError(
                    f"lowest, highest: given {low:g} and {high:g} for {factor}; allowed is a range "
                    "from lower to higher."
                )
            self._check_coding(factor)
        self._check_size()
        return self

    def _check_coding(self, factor: str) -> None:
        """Refuse a center and half range that cannot be those of runs in the factor's range."""
        place = self.factors.index(factor)
        low, high, half = self.lowest[place], self.highest[place], self.half_range[place]
        if self.log_factors[place]:
            if low <= 0.0:
                raise InputError(
                    f"lowest: given {low:g} for {factor}; allowed is a number above zero, because "
                    "the equation takes its logarithm."
                )
            low, high = math.log(low), math.log(high)
        coded = [(end - self.center[place]) / half for end in (low, high)]
        if max(map(abs, coded)) > FARTHEST or coded[1] - coded[0] < 1.0 / FARTHEST:
            raise InputError(
                f"center, half_range: given {self.center[place]:g} and {half:g} for {factor}, by which "
                f"its range lies at {coded[0]:g} to {coded[1]:g} in coded numbers; allowed are those of "
                "the runs, which span about -1 to 1 there."
            )

    def _check_size(self) -> None:
        """Refuse coefficients that give impossible values even at the runs."""
        size = self.largest_value
        if self.logarithmic or self.process is not None:
            size = sum(map(abs, self.coefficients))
        if not size <= (LARGEST_LOGARITHM if self.logarithmic else sys.float_info.max):
            of = "the response's logarithm" if self.logarithmic else "the response"
            raise InputError(
                f"coefficients: given ones of up to {max(map(abs, self.coefficients)):g} for {of}; "
                "allowed are those of a fit, because with these the response is too large or too "
                "small for any number."
            )

    @property
    def largest_value(self) -> float:
        """An upper bound of the equation's values in its range; inf for a logarithmic one or a process."""
        if self.logarithmic or self.process is not None:
            return math.inf
        reach = np.max(
            [
                np.abs(code(np.array(ends), self.center, self.half_range, self.log_factors))
                for ends in (self.lowest, self.highest)
            ],
            axis=0,
        )
        return sum(
            abs(c) * math.prod(reach[list(term)].tolist()) if term else c
            for term, c in zip(self.terms, self.coefficients, strict=True)
        )

    def __repr__(self) -> str:
        """Summarize the response, its form and the ranges of its columns; the numbers are in its fields."""
        ranges = (
            f"{name} {format_value(name, low)} to {format_value(name, high)}"
            for name, low, high in zip(self.factors, self.lowest, self.highest, strict=True)
        )
        unit = f" [{self.unit}]" if self.unit else ""
        return finished(f"<ResponseModel {self.symbol}{unit}: {self.form} of {', '.join(ranges)}>")

    __str__ = __repr__

    def scaled(self, factor: float) -> Self:
        """Return the response `factor` times as large, a factor above zero; errors are relative and stay."""
        from regression.fits.equation_text import equation_text

        scaled = super().scaled(factor)
        equation = equation_text(scaled, symbol=self.symbol, unit=self.unit, basis=self.basis)
        return scaled.changed(equation=equation)

    @classmethod
    def from_fit(
        cls,
        fit: "Fit",
        *,
        symbol: str,
        unit: str,
        support: str = "pinned",
        basis: Literal["factors", "groups"] | None = None,
        ranges: Mapping[str, tuple[float, float]] | None = None,
        fe_error: float | None = None,
    ) -> Self:
        """Make the response from a fit.

        Parameters
        ----------
        fit : Fit
            The fit; columns and response in SI units.
        symbol, unit, support : str
            Symbol, unit and support of the response, such as "e_n", "m/N" and "pinned".
        basis : {"factors", "groups"}, optional
            That of the fit by default.
        ranges : mapping, optional
            Lowest and highest value of columns if they are not those of the runs.
        fe_error : float, optional
            Largest relative error estimate of the finite element values.
        """
        from regression.fits.equation_text import equation_text

        fitted, basis = fit.fitted, basis or fit.basis
        ends = dict(zip(fit.factors, zip(fit.lowest, fit.highest, strict=True), strict=True))
        ends |= ranges or {}
        return cls(
            **dict(fitted),
            **{name: getattr(fit, name) for name in JUDGED},
            basis=basis,
            lowest=tuple(low for low, _ in ends.values()),
            highest=tuple(high for _, high in ends.values()),
            symbol=symbol,
            unit=unit,
            support=support,
            largest_fe_error=fe_error,
            dropped_terms=fit.dropped,
            equation=equation_text(fitted, symbol=symbol, unit=unit, basis=basis),
        )
