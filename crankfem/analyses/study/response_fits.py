"""All forms fitted to one response of a study, and their values at designs and between them."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from typing import Annotated, Any, Literal

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import check_choice, check_not_given
from crankbase.diagrams import display_unit, draw_rows, math_symbol, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.frames import table as frame
from crankbase.results import Internal, Number, Quantity, Result, result
from crankbase.sentences import finished, kept
from fem.response_table import RESPONSES
from regression.fits.equation_text import term_effects
from regression.fits.fit import Fit
from regression.fits.fits import confirmed_doubts, contradicting_slopes, fit_form
from regression.fits.forms import (
    FORMS,
    GAUSSIAN_PROCESS,
    Encoding,
    Form,
    factor_encoding,
    form_named,
    group_encoding,
    group_named,
)
from regression.fits.run_slopes import RunSlopes
from regression.fits.selection import choose
from regression.fits.sensitivity import Sensitivities
from regression.plans.plan import PlannedStudy, StudyPlan
from regression.plots import draw_effects
from regression.records import MEASURED, RUN
from regression.response_kinds import SUPPORTS, response_scale
from regression.runs.study_table import StudyTable, throw_dimensions

# Of a slope's row of least squares, at least; that of a value has 1.
LEAST_WEIGHT = 0.1
# What a table of the forms says of each.
ERRORS = ("r_squared", "q_squared", "largest_error", "largest_heldout_error", "mean_heldout_error")


@result(
    "response",
    "unit",
    "support",
    "chosen.form",
    "chosen.largest_error",
    "chosen.largest_heldout_error",
    "fits",
    "reason",
)
class ResponseFits(Result):
    """All forms fitted to a response of a study, and how one was chosen by the held-out error.

    Attributes
    ----------
    column : str
        Its name in the study's table.
    support : str
        Empty for a response without one, such as the mass.
    reason : str
        Reason for the choice, in a sentence; empty if the study names the form.
    skipped : tuple of str
        Forms that could not be fitted, with the reason.
    twins : mapping
        Form that is not among the fits, because selection left the same terms as in another one, to
        that form.
    fe_error : float or None
        Largest estimate of the finite elements' own relative error; None if unknown.
    fe_scatter : float
        Standard deviation of that estimate over the designs: an error common to all designs is invisible
        to every form, a varying one looks like scatter.
    slopes : int
        Number of slopes fitted besides the values.
    left_out_slopes : tuple of str
        Slopes left out, because they contradict the values and the other slopes.
    chosen_form : str
    fits : tuple of Fit
    sensitivities : Sensitivities or None
        Effects of the factors by the chosen equation, where the study is described.
    response : str
        Its name in the model: the support of pinned responses is omitted.
    encodings : mapping
        Basis ("factors" or "groups") to the encoding of its columns.
    reasons : mapping
        Forms that could not be fitted, to the reason.
    doubted_slopes : tuple
        Run and factor, by their places, of the slopes left out.
    unfitted : mapping
        Other responses of the study that have no equation, by their name in the table, to the reason;
        the same for all responses.
    """

    column: str
    symbol: str
    unit: str
    support: str
    reason: str
    skipped: tuple[str, ...]
    twins: Mapping[str, str]
    fe_error: Annotated[float | None, Quantity("1")]
    fe_scatter: Number
    slopes: Annotated[int, Quantity("1")]
    left_out_slopes: tuple[str, ...]
    chosen_form: Annotated[str, Quantity(key="chosen")]
    fits: Annotated[tuple[Fit, ...], Quantity(key="forms")]
    response: Internal[str]
    encodings: Internal[Mapping[str, Encoding]]
    reasons: Internal[Mapping[str, str]]
    doubted_slopes: Internal[tuple[tuple[int, int], ...]] = ()
    unfitted: Internal[Mapping[str, str]] = field(default_factory=dict)
    sensitivities: Sensitivities | None = None

    @property
    def chosen(self) -> Fit:
        """The fit that was chosen."""
        return next(fit for fit in self.fits if fit.form == self.chosen_form)

    def selected(self, form: str | None = None) -> Fit:
        """Return the fit for the model: of the given form or its twin, else the chosen one."""
        wanted = self.chosen_form if form is None else self.twins.get(form, form)
        return next(fit for fit in self.fits if fit.form == wanted)

    def form_text(self, fit: Fit) -> str:
        """Return the name of a fit's form, marked if it is the chosen one."""
        return f"{fit.form} (chosen)" if fit is self.chosen else fit.form

    def fit_named(self, form: str) -> Fit:
        """Return the fit of a form, or of its twin of the same terms.

        Raises
        ------
        InputError
            If that form was not fitted.
        """
        wanted = self.twins.get(form, form)
        for fit in self.fits:
            if fit.form == wanted:
                return fit
        why = self.reasons.get(form, "")
        raise InputError(
            f"form: given {form!r}; allowed are "
            f"{', '.join((*(fit.form for fit in self.fits), *self.twins))}, the "
            f"forms that were fitted to {self.response}"
            + (f" ({form}: {why.rstrip('.')})." if why else ".")
        )

    def plot(
        self,
        axes: Axes | None = None,
        *,
        show: Literal["errors", "effects"] = "errors",
        form: str | None = None,
    ) -> Axes:
        """Draw the held-out error of every form, or the effects of one.

        Diagrams that need the designs too, such as parity, are in `StudyResult.plot`.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        show : {"errors", "effects"}
        form : str, optional
            Whose effects, the chosen one's by default; errors are those of all forms.

        Raises
        ------
        InputError
            If `show` is unknown, the form was not fitted, or one is given with "errors".
        """
        check_choice("show", show, ("errors", "effects"), "these need the fits alone")
        if show == "effects":
            fit = self.chosen if form is None else self.fit_named(form)
            axes = new_axes(axes)
            self._draw_effects(axes, fit)
            return axes
        check_not_given("form", form, show, "all forms are shown beside each other")
        judged = [fit for fit in self.fits if fit.largest_heldout_error is not None]
        axes = new_axes(axes)
        draw_rows(
            axes,
            [self.form_text(fit) for fit in judged],
            [100.0 * (fit.largest_heldout_error or 0.0) for fit in judged],
            "largest error at held-out designs [%]",
        )
        write_title(axes, f"Forms fitted to {self.response.replace('_', ' ')}")
        return axes

    def _draw_effects(self, axes: Axes, fit: Fit) -> None:
        """Draw the coded coefficients of a fit in the order of their size (Pareto)."""
        names, values = term_effects(fit.fitted)
        if fit.fitted.logarithmic:
            unit, size, of = "%", 0.01, "ln "
        elif fit.basis == "groups":
            unit, size, of = "1", 1.0, ""
        else:
            (unit, size), of = display_unit(self.unit), ""
        label = f"coded coefficient of {of}{math_symbol(self.symbol)} [{unit}]"
        draw_effects(axes, names, values / size, label, fit.form)

    def to_pandas(self) -> Any:
        """Return a table of the forms and their errors; unknown values are missing.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        columns: dict[str, tuple[Any, str]] = {
            "form": ([fit.form for fit in self.fits], ""),
            "chosen": ([fit is self.chosen for fit in self.fits], ""),
            "coefficients": ([fit.coefficient_count for fit in self.fits], "1"),
        }
        for name in ERRORS:
            columns[name] = ([getattr(fit, name) for fit in self.fits], "1")
        columns["equation"] = ([fit.equation for fit in self.fits], "")
        return frame(columns)


def predicted(table: StudyTable, response: ResponseFits, fit: Fit) -> Array:
    """Evaluate a fit at all designs of the table, (n,) in the response's unit."""
    return _values(table.plan, response, fit, table.values, table.dimensions)


def surface(plan: StudyPlan, response: ResponseFits, fit: Fit) -> Callable[[Array], Array]:
    """Return a fit as a function of factor values (n, k), also between the designs.

    On groups, the dimensions follow from the factors by the study's relations; constraints are
    ignored.
    """
    return lambda values: _values(
        plan, response, fit, values, needed_dimensions(plan, response, fit, values)
    )


def needed_dimensions(
    plan: StudyPlan, response: ResponseFits, fit: Fit, values: Array
) -> dict[str, Array]:
    """Return the dimensions at factor values (n, k) that a fit on groups needs; none for others."""
    if fit.basis != "groups":
        return {}
    names = [name for name in response.encodings["groups"].names if "=" not in name]
    groups = [group_named(name) for name in names]
    needed = ["pin_diameter", *(name for group in groups for name in group.dimensions)]
    return dimensions_at(plan, values, needed)


def _values(
    plan: StudyPlan,
    response: ResponseFits,
    fit: Fit,
    values: Array,
    dimensions: Mapping[str, Array],
) -> Array:
    x = response.encodings[fit.basis].columns(plan.factors, values, dimensions)
    scaled: Array = fit_scale(plan, response.column, fit.basis, dimensions) * fit.predict(x)
    return scaled


def fit_scale(
    plan: StudyPlan, column: str, basis: str, dimensions: Mapping[str, Array]
) -> float | Array:
    """Return the factor from a fit's value to the response of a table's column."""
    if basis == "factors":
        return 1.0
    scale: float | Array = response_scale(RESPONSES[column].unit, dimensions, plan.material)
    return scale


def dimensions_at(plan: StudyPlan, values: Array, names: list[str]) -> dict[str, Array]:
    """Return dimensions of the throws of factor values (n, k), whether they can be built or not."""
    if not names:
        return {}
    known = plan.variants().fields_at(values)
    return {name: known[name] for name in names}


MAIN_SUPPORT = "_pinned"


def fit_study(table: StudyTable, form: str | None = None) -> dict[str, ResponseFits]:
    """Fit all forms to all responses of a study; a Gaussian process only if it is one of the two named.

    Parameters
    ----------
    form : str, optional
        Named besides that of the study, which is the chosen one.

    Returns
    -------
    dict
        Response name, as in the model, to its fits. A response to which no form can be fitted is
        left out; `ResponseFits.unfitted` gives the reason for the others.
    """
    if form is not None:
        _ = form_named(form)
    if not table.held_out.any():
        why = "; ".join(sorted({design.reason for design in table.failures})[:3])
        raise InputError(f"study: no held-out design has a result ({why}).")
    encodings, missing = _encodings(table)
    fitted: dict[str, ResponseFits] = {}
    reasons: dict[str, str] = {}
    for column in RESPONSES:
        if column not in table.responses:
            continue
        try:
            fits = _fit_response(table, column, encodings, missing, {form, table.plan.form})
        except InputError as error:
            reasons[column] = str(error)
        else:
            fitted[fits.response] = fits
    if not fitted:
        raise InputError(next(iter(reasons.values()), "study: given no response; one is needed."))
    return {name: replace(fits, unfitted=reasons) for name, fits in fitted.items()}


def check_study_can_be_fitted(planned: PlannedStudy) -> None:
    """Refuse a study whose designs that can be built are too few for any equation."""
    factors = planned.plan.factors
    runs = [design for design in planned.designs if design.role == RUN]
    values = np.array([design.values for design in runs])
    throws = [throw_dimensions(design.inputs["throw"]) for design in runs]
    same = set(throws[0]).intersection(*throws)
    dimensions = {name: np.array([throw[name] for throw in throws]) for name in same}
    encodings = {"factors": factor_encoding(factors, values)}
    with suppress(InputError):
        encodings["groups"] = group_encoding(factors, values, dimensions)
    reason = ""
    for form in FORMS.values():
        encoding = encodings.get(form.basis)
        if encoding is None:
            continue
        x = encoding.columns(factors, values, dimensions)
        try:
            _ = fit_form(form.name, encoding.names, x, np.ones(len(x)), logged=encoding.logged)
        except InputError as error:
            reason = reason or str(error)
        else:
            return
    excluded = [design for design in planned.excluded if design.role == RUN]
    first = f"; reason for the first excluded design: {excluded[0].reason}" if excluded else ""
    raise InputError(
        f"study.factors: given {len(runs) + len(excluded)} designs of which {len(runs)} can be built, to "
        f"which no equation can be fitted ({reason.rstrip('.')}); allowed are ranges in which throws can be "
        f"built{first.rstrip('.')}."
    )


def response_name(column: str) -> tuple[str, str]:
    """Split a column of the table into the model's name of the response and its support.

    Examples
    --------
    >>> response_name("axial_compliance_pinned")
    ('axial_compliance', 'pinned')
    >>> response_name("axial_compliance_in_line")
    ('axial_compliance_in_line', 'neighbors in line, 0 deg')
    """
    support = next((text for end, text in SUPPORTS.items() if column.endswith(f"_{end}")), "")
    return column.removesuffix(MAIN_SUPPORT), support


def _encodings(table: StudyTable) -> tuple[dict[str, Encoding], dict[str, str]]:
    """Return the encodings by basis, and the reasons why there are no others."""
    runs = ~table.held_out
    values = table.values[runs]
    dimensions = {name: column[runs] for name, column in table.dimensions.items()}
    encodings = {"factors": factor_encoding(table.plan.factors, values)}
    try:
        # Groups fit no throws of different size that carry a part of one size.
        throw = table.plan.throw
        parts = [
            name
            for name in ("counterweight", "left_web", "right_web", "further_pins", "oil_holes")
            if getattr(throw, name)
        ]
        if parts and float(np.ptp(table.dimensions["pin_diameter"])) > 0.0:
            raise InputError(
                f"groups: given throws of different sizes with {parts[0]}; allowed are throws without, "
                "because the part does not grow with the throw."
            )
        encodings["groups"] = group_encoding(table.plan.factors, values, dimensions)
    except InputError as error:
        return encodings, {"groups": str(error)}
    return encodings, {}


def _fit_response(
    table: StudyTable,
    column: str,
    encodings: Mapping[str, Encoding],
    missing: Mapping[str, str],
    wanted: set[str | None],
) -> ResponseFits:
    kind = RESPONSES[column]
    name, support = response_name(column)
    doubted = _doubted(table, column, encodings["factors"])
    slopes = {
        basis: run_slopes(table, column, encoding, doubted) for basis, encoding in encodings.items()
    }
    if GAUSSIAN_PROCESS.name in wanted:  # it fits where a polynomial would doubt good slopes
        doubted = _doubted(table, column, encodings["factors"], doubted)
    smooth = run_slopes(table, column, encodings["factors"], doubted)
    fits: list[Fit] = []
    skipped: dict[str, str] = {}
    twins: dict[str, str] = {}
    for form in (*FORMS.values(), GAUSSIAN_PROCESS):
        if form.process and form.name not in wanted:
            continue
        if form.basis in missing:
            skipped[form.name] = missing[form.basis]
            continue
        try:
            taken = smooth if form.process else slopes[form.basis]
            fit = _fit(table, column, form, encodings[form.basis], taken)
        except InputError as error:
            skipped[form.name] = str(error)
            continue
        twin = next((other.form for other in fits if _same_terms(fit, other)), None)
        if twin is None:
            fits.append(fit)
        else:
            twins[form.name] = twin
            skipped[form.name] = f"has the same terms as {twin} in this study."
    sentences = tuple(f"{form}: {why}" for form, why in skipped.items())
    if not fits:
        raise InputError(f"study: no form can be fitted to {name} ({'; '.join(sentences)})")
    # Imported rows may have none.
    errors = [
        row.errors[column] for row in table.rows if row.role != MEASURED and column in row.errors
    ]
    scatter = float(np.std(errors)) if errors else 0.0
    choice = choose(fits, scatter)
    fitted = ResponseFits(
        response=name,
        column=column,
        symbol=kind.symbol,
        unit=kind.unit,
        support=support,
        fits=tuple(fits),
        chosen_form=fits[choice.place].form,
        reason=choice.reason,
        skipped=sentences,
        reasons=skipped,
        doubted_slopes=tuple(doubted),
        twins=twins,
        fe_error=max(errors, default=None),
        fe_scatter=scatter,
        slopes=0 if smooth is None else len(smooth.known),
        left_out_slopes=_named_slopes(table, doubted),
        encodings=dict(encodings),
    )
    named = table.plan.form
    if named is None:
        return fitted
    return replace(fitted, chosen_form=fitted.fit_named(named).form, reason="")


def _doubted(
    table: StudyTable,
    column: str,
    encoding: Encoding,
    doubted: Sequence[tuple[int, int]] | None = None,
) -> list[tuple[int, int]]:
    """Find the runs and factors of slopes that contradict the rest; of doubted ones by a Gaussian process."""
    slopes, runs = run_slopes(table, column, encoding), ~table.held_out
    if slopes is None or doubted == []:
        return []
    x = encoding.columns(table.plan.factors, table.values[runs], {})
    precision = float(np.mean(table.errors[column][runs])) if column in table.errors else 0.0
    y = table.responses[column][runs]
    arguments = encoding.names, x, y, slopes, encoding.logged, precision
    return (
        contradicting_slopes(*arguments)
        if doubted is None
        else confirmed_doubts(*arguments, doubted)
    )


def _named_slopes(table: StudyTable, doubted: Sequence[tuple[int, int]]) -> tuple[str, ...]:
    """Name slopes by factor and run, or by the factor alone if they are all over it."""
    factors, values = table.plan.factors, table.values[~table.held_out]
    texts = []
    for place, factor in enumerate(factors):
        runs = [run for run, over in doubted if over == place]
        if len(runs) == len(values):
            texts.append(f"all over {factor.name}")
            continue
        for run in runs:
            settings = (
                f"{varied.name} {kept(varied.format_value(value))}"
                for varied, value in zip(factors, values[run].tolist(), strict=True)
            )
            texts.append(finished(f"over {factor.name} at {', '.join(settings)}"))
    return tuple(texts)


def run_slopes(
    table: StudyTable, column: str, encoding: Encoding, left_out: Sequence[tuple[int, int]] = ()
) -> RunSlopes | None:
    """Return a response's slopes at the runs, for equations in some columns; None if there are none.

    `left_out` has run and factor of those not to be used.
    """
    plan, factors, runs = table.plan, table.plan.factors, ~table.held_out
    if column not in table.slopes or not np.isfinite(table.slopes[column][runs]).any():
        return None
    values, y = table.values[runs], table.responses[column][runs]
    known = table.slopes[column][runs] / y[:, None]
    errors = np.zeros_like(known)
    turned = np.zeros((*known.shape, len(encoding.names)))
    variants = plan.variants()
    for place, factor in enumerate(factors):
        if factor.labels:
            continue
        less, more, step = variants.beside(values, place)
        half = 0.5 * (factor.highest - factor.lowest)
        known_at = [(moved, variants.fields_at(moved)) for moved in (less, more)]
        columns = [encoding.columns(factors, *moved) for moved in known_at]
        turned[:, place] = (columns[1] - columns[0]) * (half / (2.0 * step))
        scales = [fit_scale(plan, column, encoding.basis, fields) for _, fields in known_at]
        known[:, place] -= np.log(scales[1] / scales[0]) / (2.0 * step)
        known[:, place] *= half
        errors[:, place] = (
            table.slope_errors[column][runs] * half / np.maximum(np.abs(values[:, place]), half)
        )
    precise = table.errors[column][runs] if column in table.errors else errors.min(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = np.clip(precise[:, None] / errors, LEAST_WEIGHT, 1.0)
    known[tuple(np.array(left_out, dtype=int).reshape(-1, 2).T)] = np.nan
    if not np.isfinite(known).any():
        return None
    return RunSlopes(known, np.where(errors > 0.0, weights, 1.0), turned)


def _fit(
    table: StudyTable, column: str, form: Form, encoding: Encoding, slopes: RunSlopes | None
) -> Fit:
    y, held = table.responses[column], table.held_out
    x = encoding.columns(table.plan.factors, table.values, table.dimensions)
    scale = np.broadcast_to(fit_scale(table.plan, column, form.basis, table.dimensions), y.shape)
    fit = fit_form(
        form.name,
        encoding.names,
        x[~held],
        y[~held],
        x[held],
        y[held],
        scale=scale[~held],
        heldout_scale=scale[held],
        logged=encoding.logged,
        drop_terms=True,
        slopes=slopes,
    )
    factor_units = {factor.name: factor.unit for factor in table.plan.factors}
    return replace(
        fit,
        symbol=RESPONSES[column].symbol,
        unit=RESPONSES[column].unit,
        column_units=tuple(factor_units.get(name, "") for name in fit.factors),
    )


def _same_terms(fit: Fit, other: Fit) -> bool:
    form, other_form = fit.fitted, other.fitted
    return (
        fit.basis == other.basis
        and form.process is other_form.process is None
        and form.logarithmic == other_form.logarithmic
        and set(form.terms) == set(other_form.terms)
    )
