"""What a study found: its designs, and every fitted equation with its errors and the effects of factors."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated

from crankbase.quantity import format_quantity
from crankbase.results import InItsUnit, Quantity, Result, result
from crankbase.table import Column, Main, MainWarning, Table
from crankfem.analyses.study.response_fits import ResponseFits
from regression.fits.fit import Fit
from regression.models.response_query import FEWEST
from regression.plans.plan import ExcludedDesign
from regression.response_kinds import AXIAL, END_MOMENTS
from regression.runs.study_table import DesignTable

LACK_OF_FIT = (
    "Finite-element runs repeat exactly: R2, standard errors, t and F measure the lack of fit of the form, "
    "not random error."
)
# Relative errors below this are round-off.
LEAST_SHOWN = 1e-5

Figure = Annotated[float | None, Quantity("1")]
Parts = Iterator[Table | str]


@result("lowest", "highest", "levels", "labels")
class FactorRange(Result):
    """Range or levels of a factor; a choice has labels, and their indices are its levels."""

    unit: str
    lowest: InItsUnit
    highest: InItsUnit
    levels: Annotated[tuple[float, ...] | None, Quantity(".unit")]
    labels: tuple[str, ...]


def fit_parts(fit: Fit) -> Parts:
    """Tabulate the coefficients of an equation."""
    if "[" in fit.equation:
        yield "A condition in square brackets is 1 where it holds, 0 elsewhere."
    mean = "" if fit.condition_number is not None else "the mean of the "
    yield Table.of_records(
        f"Coefficients of {mean}{fit.form}: coded (-1 ... 1 over the runs), and natural in SI "
        "units",
        fit.coded,
        (Column("term", words=True), lambda c: c.symbols),
        (Column("coded", digits=5), lambda c: c.coefficient),
        (Column("std. error", digits=2), lambda c: c.standard_error),
        (Column("t", digits=3), lambda c: c.t),
        (Column("VIF", digits=3), lambda c: c.variance_inflation),
        (Column("natural", digits=6), lambda c: fit.coefficients[c.term]),
    )
    adjusted = fit.adjusted_r_squared
    if fit.condition_number is not None:
        yield (
            f"Adjusted R2 {'none' if adjusted is None else f'{adjusted:.5f}'}, "
            f"F {_or_none(fit.f_value)}, AIC {_or_none(fit.aic, 5)}, BIC {_or_none(fit.bic, 5)}, "
            f"condition number {fit.condition_number:.3g}, largest leverage "
            f"{fit.largest_leverage:.2f}."
        )
    for title, terms in (
        ("Dropped, because PRESS does not grow without them", fit.dropped),
        ("Left out, because the runs do not determine them", fit.undetermined),
    ):
        if terms:
            yield f"{title}: {', '.join(terms)}."
    for line in fit.warnings:
        yield MainWarning(line)


def response_parts(fits: ResponseFits, name: str, form: str | None = None) -> Parts:
    """Compare the forms of a response, and describe one of them with the effects of the factors."""
    words, shown = name.replace("_", " "), fits.selected(form)
    support = f", {fits.support}" if fits.support else ""
    yield Table.of_records(
        f"{words.capitalize()} {fits.symbol}{support}: largest (mean) errors in %",
        fits.fits,
        (Column("form", words=True), lambda f: f.form + (" *" if f is shown else "")),
        (Column("terms"), lambda f: f.coefficient_count),
        (Column("R2", decimals=5), lambda f: f.r_squared),
        (Column("Q2", decimals=5), lambda f: f.q_squared),
        (Column("at the runs"), lambda f: _both(f.largest_error, f.mean_error)),
        (Column("held out"), lambda f: _both(f.largest_heldout_error, f.mean_heldout_error)),
        weight=lambda f: 1.0 / (f.largest_heldout_error or 1.0) if f is not shown else 1e9,
        main=True,
    )
    if fits.slopes:
        yield f"Fitted to {fits.slopes} slopes besides the values at the runs."
    if fits.reason:
        yield Main(f"Chosen by its errors: {fits.reason}")
    else:
        yield Main(f"The study names the form: {fits.chosen_form}.")
    if form is not None:
        yield f"Used because of --form: {form}."
    elif fits.reason:
        yield "The form was chosen by this error, so it is slightly optimistic for other designs."
    for line in fits.skipped:
        yield f"Not fitted: {line}"
    yield from fit_parts(shown)
    yield LACK_OF_FIT
    effects = fits.sensitivities
    assert effects is not None
    first, total, shapley = (
        ({}, {}, None)
        if effects.sobol is None
        else (effects.sobol.first, effects.sobol.total, effects.sobol.shapley)
    )

    def nominal(factor: str) -> str:
        value = effects.nominal[factor]
        return value if isinstance(value, str) else format_quantity(value, effects.units[factor])

    def change(factor: str) -> str:
        slope = effects.elasticity.get(factor)
        return "" if slope is None else f"{round(slope, 3) + 0.0:+.3f}"

    yield Table.of_records(
        f"Sensitivity of the {words} by the chosen equation",
        effects.nominal,
        (Column("factor", words=True), str),
        (Column("nominal"), nominal),
        (Column("elasticity"), change),
        (Column("Sobol, first", decimals=3), first.get),
        (Column("total", decimals=3), total.get),
        *(() if shapley is None else ((Column("Shapley", decimals=3), shapley.get),)),
        main=True,
    )
    shares = (
        "shares of the variance over the ranges, alone and with others."
        if shapley is None
        else "shares of the variance over the ranges within the constraints: reduction if only this "
        "factor is known (first), remainder if only this factor is unknown (total), and its share of the "
        "whole (Shapley; these add up to 1)."
    )
    yield (
        "Elasticity: change in per cent for one per cent of the factor, at the nominal values. "
        f"Sobol indices: {shares}"
    )


@result("source", "response", "measured", "calculated", "ratio")
class Comparison(Result):
    """An imported measured value beside that of the model's equations, or the reason why it has none."""

    source: str
    response: str
    measured: InItsUnit
    unit: str
    reason: Annotated[str | None, Quantity(left_out=True)] = None
    calculated: Annotated[float | None, Quantity(".unit", left_out=True)] = None
    ratio: Annotated[float | None, Quantity("1", "calculated / measured", left_out=True)] = None
    # Of the lookup, on dimensions outside the range.
    remarks: Annotated[tuple[str, ...] | None, Quantity(left_out=True)] = None


def comparison_parts(compared: Sequence[Comparison]) -> Parts:
    """Tabulate imported measured values and those of the equations; nothing if there are none."""
    if not compared:
        return
    yield Table.of_records(
        "Measured values compared with the equations",
        compared,
        (Column("source", words=True), lambda c: c.source),
        (Column("response", words=True), lambda c: c.response.replace("_", " ")),
        (Column("measured"), lambda c: c.measured),
        (Column("calculated"), lambda c: c.calculated),
        (Column("calculated / measured", decimals=3, missing=""), lambda c: c.ratio),
        main=True,
    )
    for reason in dict.fromkeys(f"{c.source}: {c.reason}" for c in compared if c.reason):
        yield f"Not compared: {reason}"
    for remark in dict.fromkeys(
        f"{c.source}: {text}" for c in compared for text in c.remarks or ()
    ):
        yield f"Note: {remark}"


@result("key", "runs", "held_out", "fits")
class FittedStudy(Result):
    """A study's designs, failures, and every fitted equation with its errors.

    Attributes
    ----------
    computed_now, added : int
        Designs not read from the store; runs added to the plan's.
    failures, excluded : tuple of ExcludedDesign
        Designs without a result; those that the plan excluded.
    value_units : tuple of str
        Of the factors, in the order of all lists of values.
    unfitted : mapping
        Responses without an equation to the reason.
    compared : tuple of Comparison
        Imported measured values.
    """

    key: str
    design: str
    factors: Mapping[str, FactorRange]
    relations: Mapping[str, str]
    constraints: tuple[str, ...]
    runs: int
    held_out: int
    computed_now: int
    added: int
    failures: tuple[ExcludedDesign, ...]
    excluded: tuple[ExcludedDesign, ...]
    largest_fe_error_estimate: Figure
    table: DesignTable
    value_units: tuple[str, ...]
    statement: str
    fits: Mapping[str, ResponseFits]
    unfitted: Mapping[str, str]
    compared: tuple[Comparison, ...]

    @property
    def main_response(self) -> str:
        """The axial compliance, or the first response."""
        return AXIAL if AXIAL in self.fits else next(iter(self.fits))

    def main_parts(self) -> Parts:
        """Tabulate all responses, and write the equation chosen for the axial compliance."""
        yield from self._overview()
        if AXIAL in self.fits:
            yield from self.answer(AXIAL)

    def answer(self, response: str | None = None, form: str | None = None) -> Iterator[str]:
        """Write the equation of a response, by default the main one, and its held-out error."""
        name = response or self.main_response
        shown = self.fits[name].selected(form)
        yield f"{shown.form}: {shown.equation}"
        errors = (shown.largest_heldout_error, shown.mean_heldout_error)
        largest, mean = map(_percent, errors)
        yield f"Held-out error of the {name.replace('_', ' ')} by it: at most {largest}, mean {mean}."

    def lookup_line(self, model: str) -> str:
        """Return the command that looks the study's nominal throw up in a model."""
        effects = self.fits[self.main_response].sensitivities
        assert effects is not None
        dimensions = (
            f"{name}={value if isinstance(value, str) else format_quantity(value, effects.units[name])}"
            for name, value in effects.nominal.items()
        )
        return f"crankfem lookup {model} {' '.join(text.replace(' ', '') for text in dimensions)}"

    def parts(self, response: str | None = None, form: str | None = None) -> Parts:
        """Tabulate all responses, and one of them with all its forms.

        Parameters
        ----------
        response : str, optional
            Response in detail; by default the main one.
        form : str, optional
            Form whose equation and coefficients are written, or its twin; by default the chosen one.
        """
        detailed = response or self.main_response
        yield from self._overview(form)
        yield from response_parts(self.fits[detailed], detailed, form)

    def _overview(self, form: str | None = None) -> Parts:
        every = {name: response.selected(form) for name, response in self.fits.items()}
        moments = {name: fit for name, fit in every.items() if name in END_MOMENTS}
        equations = "their chosen equations" if form is None else f"the form {form}, as given"
        judged = min(fit.band_designs for fit in every.values())
        enough = judged >= FEWEST
        new = (
            "error not exceeded by 95 % of new throws"
            if enough
            else f"largest error at designs not fitted (too few for 95 % of new throws: {judged})"
        )
        yield Table.of_records(
            f"All responses by {equations}: largest and mean held-out error, {new}, estimated error of FE",
            [name for name in every if name not in moments],
            (Column("response", words=True), lambda name: name.replace("_", " ")),
            (Column("form", words=True), lambda name: every[name].form),
            (Column("Q2", decimals=5), lambda name: every[name].q_squared),
            (Column("held out"), lambda name: _percent(every[name].largest_heldout_error)),
            (Column("mean"), lambda name: _percent(every[name].mean_heldout_error)),
            (
                Column("95 %" if enough else "new"),
                lambda name: _percent(every[name].band_error),
            ),
            (Column("FE"), lambda name: _percent(self.fits[name].fe_error)),
            main=True,
        )
        doubted: dict[tuple[str, ...], list[str]] = {}
        for name, response in self.fits.items():
            doubted.setdefault(response.left_out_slopes, []).append(name)
        for slopes, names in doubted.items():
            if slopes:
                yield (
                    f"Slopes left out, because they contradict the values and the other slopes, of "
                    f"{', '.join(names)}: {'; '.join(slopes)}."
                )
        errors = [fit.largest_heldout_error for fit in moments.values()]
        known = [error for error in errors if error is not None]
        if known:
            yield (
                f"Besides, {len(moments)} responses from which reactions follow: largest held-out error "
                f"{_percent(max(known))}; --response NAME and --json report each ({', '.join(moments)})."
            )


def _percent(value: float | None) -> str:
    if value is None:
        return "none"
    return f"{100.0 * value:.3g} %" if value >= LEAST_SHOWN else f"< {100.0 * LEAST_SHOWN:g} %"


def _both(largest: float, mean: float) -> str:
    if largest < LEAST_SHOWN:
        return f"< {100.0 * LEAST_SHOWN:g}"
    return f"{100.0 * largest:.3g} ({100.0 * mean:.2g})"


def _or_none(value: float | None, digits: int = 4) -> str:
    return "none" if value is None else f"{value:.{digits}g}"
