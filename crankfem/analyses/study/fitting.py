"""From a study's table to fitted equations, their sensitivities and the compliance model."""

import datetime
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.choices import check_choice, check_not_given
from crankbase.drawing.bars import draw_rows
from crankbase.drawing.diagram_style import math_symbol, new_axes
from crankbase.drawing.legends import display_unit, write_title
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table as frame
from crankfem.analyses.provenance import program_version
from fem.responses import RESPONSES
from regression.fits.columns import Encoding, constant_groups, factor_encoding, group_encoding
from regression.fits.equation_text import equation_text, term_effects
from regression.fits.fits import Fit, fit_form
from regression.fits.forms import FORMS, Form
from regression.fits.groups import group_named
from regression.fits.selection import choose
from regression.fits.sensitivity import SobolIndices, elasticities, nominal_values, sobol_indices
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.plans.factors import Factor, field_value
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.plans.relations import evaluate_expression
from regression.plots.equations import draw_effects
from regression.records import MEASURED
from regression.response_kinds import response_scale
from regression.runs.study_table import StudyTable
from regression.throw_values import throw_values

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Supports, as they stand at the end of a response's name, and what they are called.
SUPPORTS = {
    "pinned": "pinned",
    "guided": "guided",
    "opposite": "neighbors opposite, 180 deg",
    "in_line": "neighbors in line, 0 deg",
}
MAIN_SUPPORT = "_pinned"


@summarized(
    "response",
    "unit",
    "support",
    "chosen.form",
    "chosen.largest_error",
    "chosen.largest_heldout_error",
    "fits",
    "reason",
)
@dataclass(frozen=True, eq=False)
class ResponseFits:
    """All forms fitted to one response, and the one chosen by the held-out error.

    Attributes
    ----------
    response : str
        Its name in the model: pinned responses are called without their support.
    column : str
        Its name in the study's table.
    symbol, unit, support : str
        The support is empty for a response without one, such as the mass.
    fits : tuple of Fit
    chosen : Fit
    reason : str
        Why that one, in a sentence.
    skipped : tuple of str
        Forms that could not be fitted, with the reason.
    twins : mapping
        Form that is not among the fits, because selection left it the terms of another one, to that
        one.
    fe_error : float or None
        Largest estimate of the finite elements' own relative error; None if not known.
    fe_scatter : float
        Standard deviation of that estimate over the designs: what is common to all designs no form
        can see, what differs from design to design looks like scatter.
    encodings : mapping
        Basis ("factors" or "groups") to what the columns of its equations are.
    unfitted : mapping
        Other responses of the study that have no equation, by their name in the table, to the reason;
        the same for all responses.
    """

    response: str
    column: str
    symbol: str
    unit: str
    support: str
    fits: tuple[Fit, ...]
    chosen: Fit
    reason: str
    skipped: tuple[str, ...]
    twins: Mapping[str, str]
    fe_error: float | None
    fe_scatter: float
    encodings: Mapping[str, Encoding]
    unfitted: Mapping[str, str] = field(default_factory=dict)

    def form_text(self, fit: Fit) -> str:
        """Return the name of a fit's form, and whether it is the chosen one."""
        return f"{fit.form} (chosen)" if fit is self.chosen else fit.form

    def equation(self, fit: Fit) -> str:
        """Equation of a fit in the units of the field."""
        return equation_text(fit.fitted, symbol=self.symbol, unit=self.unit, basis=fit.basis)

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
        why = next((text for text in self.skipped if text.startswith(f"{form}: ")), "")
        raise InputError(
            f"form: given {form!r}; allowed are "
            f"{', '.join((*(fit.form for fit in self.fits), *self.twins))}, the "
            f"forms that were fitted to {self.response}"
            + (f" ({why.rstrip('.')})." if why else ".")
        )

    def plot(
        self,
        axes: "Axes | None" = None,
        *,
        show: Literal["errors", "effects"] = "errors",
        form: str | None = None,
    ) -> "Axes":
        """Draw the held-out error of every form, or the effects of one.

        What needs the designs too, such as parity, `StudyResult.plot` draws.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        show : {"errors", "effects"}
        form : str, optional
            Whose effects, the chosen one's by default; errors are those of all forms.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If `show` is neither, the form was not fitted, or one is given with "errors".
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

    def _draw_effects(self, axes: "Axes", fit: Fit) -> None:
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
        """Return a table of the forms and their errors; what is not known is missing.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        fits = self.fits
        return frame(
            {
                "form": ([fit.form for fit in fits], ""),
                "chosen": ([fit is self.chosen for fit in fits], ""),
                "coefficients": ([fit.coefficient_count for fit in fits], "1"),
                "r_squared": ([fit.r_squared for fit in fits], "1"),
                "q_squared": ([fit.q_squared for fit in fits], "1"),
                "largest_error": ([fit.largest_error for fit in fits], "1"),
                "largest_heldout_error": ([fit.largest_heldout_error for fit in fits], "1"),
                "mean_heldout_error": ([fit.mean_heldout_error for fit in fits], "1"),
                "equation": ([self.equation(fit) for fit in fits], ""),
            }
        )


@dataclass(frozen=True)
class Sensitivities:
    """How much each factor moves a response, by its chosen equation.

    Attributes
    ----------
    nominal : dict
        Factor to the value [SI] at which the elasticities hold; of a category its label.
    elasticity : dict
        Factor that is a number to d ln y / d ln p.
    sobol : SobolIndices or None
        Over the ranges; None for a response that does not vary.
    """

    nominal: dict[str, float | str]
    elasticity: dict[str, float]
    sobol: SobolIndices | None


def fit_study(table: StudyTable) -> dict[str, ResponseFits]:
    """Fit all forms to all responses of a study.

    Parameters
    ----------
    table : StudyTable

    Returns
    -------
    dict
        Response name, as in the model, to its fits. A response to which no form can be fitted is
        left out; `ResponseFits.unfitted` of the others tells why.

    Raises
    ------
    InputError
        If too few designs have results for even the smallest form, or no held-out design has one.
    """
    if not table.held_out.any():
        why = "; ".join(sorted({reason for _, _, reason in table.failures})[:3])
        raise InputError(f"study: no held-out design has a result ({why}).")
    encodings, missing = _encodings(table)
    found: dict[str, ResponseFits] = {}
    reasons: dict[str, str] = {}
    for column in RESPONSES:
        if column not in table.responses:
            continue
        try:
            fits = _fit_response(table, column, encodings, missing)
        except InputError as error:
            reasons[column] = str(error)
        else:
            found[fits.response] = fits
    if not found:
        raise InputError(next(iter(reasons.values()), "study: given no response; one is needed."))
    return {name: replace(fits, unfitted=reasons) for name, fits in found.items()}


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
    found = {"factors": factor_encoding(table.plan.factors, values)}
    try:
        _check_similar(table)
        found["groups"] = group_encoding(table.plan.factors, values, dimensions)
    except InputError as error:
        return found, {"groups": str(error)}
    return found, {}


def _check_similar(table: StudyTable) -> None:
    """Refuse groups where throws of different size carry a part of one size."""
    throw = table.plan.throw
    parts = [
        name
        for name in ("counterweight", "left_web", "right_web", "further_pins")
        if getattr(throw, name)
    ]
    if parts and float(np.ptp(table.dimensions["pin_diameter"])) > 0.0:
        raise InputError(
            f"groups: given throws of different sizes with {parts[0]}; allowed are throws without, "
            "because the part does not grow with the throw."
        )


def _fit_response(
    table: StudyTable, column: str, encodings: Mapping[str, Encoding], missing: Mapping[str, str]
) -> ResponseFits:
    kind = RESPONSES[column]
    name, support = response_name(column)
    fits: list[Fit] = []
    skipped: list[str] = []
    twins: dict[str, str] = {}
    for form in FORMS.values():
        if form.basis in missing:
            skipped.append(f"{form.name}: {missing[form.basis]}")
            continue
        try:
            fit = _fit(table, column, form, encodings[form.basis])
        except InputError as error:
            skipped.append(f"{form.name}: {error}")
            continue
        twin = next((other.form for other in fits if _same_terms(fit, other)), None)
        if twin is None:
            fits.append(fit)
        else:
            twins[form.name] = twin
            skipped.append(f"{form.name}: has the same terms as {twin} in this study.")
    if not fits:
        raise InputError(f"study: no form can be fitted to {name} ({'; '.join(skipped)})")
    errors = _fe_errors(table, column)
    scatter = float(np.std(errors)) if errors else 0.0
    choice = choose(fits, scatter)
    return ResponseFits(
        response=name,
        column=column,
        symbol=kind.symbol,
        unit=kind.unit,
        support=support,
        fits=tuple(fits),
        chosen=fits[choice.place],
        reason=choice.reason,
        skipped=tuple(skipped),
        twins=twins,
        fe_error=max(errors, default=None),
        fe_scatter=scatter,
        encodings=dict(encodings),
    )


def _fe_errors(table: StudyTable, column: str) -> list[float]:
    """Relative errors of a response as far as they are known; imported rows may have none."""
    return [
        row.errors[column] for row in table.rows if row.role != MEASURED and column in row.errors
    ]


def _fit(table: StudyTable, column: str, form: Form, encoding: Encoding) -> Fit:
    y, held = table.responses[column], table.held_out
    x = encoding.columns(table.plan.factors, table.values, table.dimensions)
    scale = _scale(table.plan, column, form.basis, table.dimensions, len(y))
    return fit_form(
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
    )


def _scale(
    plan: StudyPlan, column: str, basis: str, dimensions: Mapping[str, Array], count: int
) -> Array:
    if basis == "factors":
        return np.ones(count)
    scale = response_scale(RESPONSES[column].unit, dimensions, plan.material)
    return np.array(np.broadcast_to(scale, (count,)), dtype=np.float64)


def _same_terms(fit: Fit, other: Fit) -> bool:
    one, two = fit.fitted, other.fitted
    return (
        fit.basis == other.basis
        and one.logarithmic == two.logarithmic
        and set(one.terms) == set(two.terms)
    )


# ------------------------------------------------------------------------------- evaluation


def predicted(table: StudyTable, found: ResponseFits, fit: Fit) -> Array:
    """Evaluate a fit at all designs of the table, (n,) in the response's unit."""
    x = found.encodings[fit.basis].columns(table.plan.factors, table.values, table.dimensions)
    scale = _scale(table.plan, found.column, fit.basis, table.dimensions, len(x))
    values: Array = scale * fit.predict(x)
    return values


def surface(plan: StudyPlan, found: ResponseFits, fit: Fit) -> Callable[[Array], Array]:
    """Return a fit as a function of factor values (n, k), also between the designs.

    On groups, the dimensions follow from the factors by the study's relations; constraints are not
    regarded.
    """
    encoding = found.encodings[fit.basis]
    needed: list[str] = []
    if fit.basis == "groups":
        groups = [group_named(name) for name in encoding.names if "=" not in name]
        needed = ["pin_diameter", *(name for group in groups for name in group.dimensions)]

    def value(values: Array) -> Array:
        dimensions = dimensions_at(plan, values, needed)
        scale = _scale(plan, found.column, fit.basis, dimensions, len(values))
        found_values: Array = scale * fit.predict(
            encoding.columns(plan.factors, values, dimensions)
        )
        return found_values

    return value


def dimensions_at(plan: StudyPlan, values: Array, names: list[str]) -> dict[str, Array]:
    """Return dimensions of the throws that factor values (n, k) make, whether they can be built or not."""
    if not names:
        return {}
    variants = plan.variants()
    known = {
        path: np.full(len(values), float(base))
        for path in variants.units
        if isinstance(base := field_value(variants.record, path), int | float)
    } | {
        factor.name: values[:, place]
        for place, factor in enumerate(plan.factors)
        if not factor.labels
    }
    for path, expression in variants.relations.items():
        found = evaluate_expression(expression, known, variants.units, variants.units[path])
        known[path] = np.array(np.broadcast_to(found, (len(values),)))
    return {name: known[name] for name in names}


def sensitivities(table: StudyTable, found: ResponseFits) -> Sensitivities:
    """Elasticities at the nominal throw and Sobol indices over the ranges, by the chosen equation."""
    plan = table.plan
    model = surface(plan, found, found.chosen)
    nominal = nominal_points(plan)
    numbers = [factor.name for factor in plan.factors if not factor.labels]
    slopes = elasticities(model, plan.factors, nominal)
    return Sensitivities(
        nominal={
            factor.name: factor.labels[round(value)] if factor.labels else value
            for factor, value in zip(plan.factors, nominal, strict=True)
        },
        elasticity=dict(zip(numbers, slopes, strict=True)),
        sobol=sobol_indices(model, plan.factors),
    )


def nominal_points(plan: StudyPlan) -> list[float]:
    """Return the base throw's values of the factors, the middle of the range where it has none."""
    record = plan.throw.model_dump(mode="json")
    return nominal_values(plan.factors, [_base_value(record, factor) for factor in plan.factors])


def _base_value(record: Mapping[str, object], factor: Factor) -> float | None:
    try:
        value = field_value(record, factor.name)
    except (AttributeError, IndexError, KeyError, ValueError):
        return None  # a free name, or a field of a part that the base throw does not have
    if factor.labels:
        return float(factor.labels.index(value)) if value in factor.labels else None
    return float(value) if isinstance(value, int | float) else None


# ------------------------------------------------------------------------------- the model


def compliance_model(
    table: StudyTable, fits: Mapping[str, ResponseFits], form: str | None = None
) -> ComplianceModel:
    """Make the model that lookups use.

    Parameters
    ----------
    table : StudyTable
    fits : mapping
        As `fit_study` returns them.
    form : str, optional
        Form to take for every response, instead of the chosen ones.

    Raises
    ------
    InputError
        If the form was not fitted to a response.
    """
    plan = table.plan
    fixed, labels = _fixed(plan)
    chosen = {
        name: found.chosen if form is None else found.fit_named(form)
        for name, found in fits.items()
    }
    numbers = [factor for factor in plan.factors if not factor.labels]
    ranges = {factor.name: (factor.lowest, factor.highest) for factor in numbers}
    return ComplianceModel(
        responses={
            name: _response_model(found, chosen[name], plan) for name, found in fits.items()
        },
        fixed=fixed,
        ranges=ranges,
        categories={factor.name: factor.labels for factor in plan.factors if factor.labels},
        labels=labels,
        units={factor.name: factor.unit for factor in numbers},
        relations=dict(plan.relations),
        constraints=plan.constraints,
        constant_groups=(
            constant_groups(table.dimensions)
            if any(fit.basis == "groups" for fit in chosen.values())
            else {}
        ),
        throw=plan.throw.model_dump(mode="json", exclude_defaults=True),
        material=plan.material.model_dump(),
        provenance={
            "study": plan.key,
            "accuracy": plan.accuracy,
            "model_version": MODEL_VERSION,
            "crankfem": program_version(),
            **{name: package_version(name) for name in ("gmsh", "scikit-fem")},
            "date": datetime.date.today().isoformat(),
            "design": plan.design.kind,
            "runs": int(np.sum(~table.held_out)),
            "held_out": int(np.sum(table.held_out)),
            "largest_fe_error_estimate": max(
                (found.fe_error for found in fits.values() if found.fe_error is not None),
                default=None,
            ),
        },
    )


def _response_model(found: ResponseFits, fit: Fit, plan: StudyPlan) -> ResponseModel:
    inside = {factor.name: factor for factor in plan.factors if factor.name in fit.factors}
    lowest = dict(zip(fit.factors, fit.lowest, strict=True))
    highest = dict(zip(fit.factors, fit.highest, strict=True))
    if fit.basis == "factors":
        # The ranges of the study, where the runs of a space-filling design stay a little inside.
        lowest |= {name: factor.lowest for name, factor in inside.items()}
        highest |= {name: factor.highest for name, factor in inside.items()}
    return ResponseModel.from_fit(
        fit,
        symbol=found.symbol,
        unit=found.unit,
        support=found.support,
        basis=fit.basis,
        lowest=lowest,
        highest=highest,
        fe_error=found.fe_error,
        dropped=fit.dropped,
        equation=found.equation(fit),
    )


def _fixed(plan: StudyPlan) -> tuple[dict[str, float], dict[str, str]]:
    """Return what does not vary: numbers by field, and labels by field.

    A dimension that equals its default in the base throw stays fixed where that varies.
    """
    varying = {*plan.names, *plan.relations}
    described = throw_values(plan.throw, spelled_out=True)
    values = {name: value for name, value in described.items() if name not in varying}
    return (
        {name: value for name, value in values.items() if isinstance(value, float)},
        {name: value for name, value in values.items() if isinstance(value, str)},
    )


def package_version(name: str) -> str:
    """Return the installed version of a package, or a mark that it runs uninstalled."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
