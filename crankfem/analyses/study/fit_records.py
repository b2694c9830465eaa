"""A study and its equations as plain JSON content: what the report shows and ``--json`` prints."""

import datetime
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from crankbase.errors import InputError
from crankfem.analyses.provenance import program_version
from crankfem.analyses.record import Record
from crankfem.analyses.study.nominal_throw import Sensitivities, sensitivities
from crankfem.analyses.study.response_fits import ResponseFits
from fem.responses import RESPONSES
from fem.symmetry import SHARED
from geometry.throw import CrankThrow
from regression.fits.equation_text import term_symbols
from regression.fits.fits import Fit
from regression.fits.forms import constant_groups
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.plans.factors import changed_record
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.records import MEASURED, ExtraRow
from regression.runs.study_table import StudyTable
from regression.throw_values import throw_values


def compliance_model(
    table: StudyTable, fits: Mapping[str, ResponseFits], form: str | None = None
) -> ComplianceModel:
    """Make the model for lookups.

    Parameters
    ----------
    fits : mapping
        From `fit_study`.
    form : str, optional
        Form for every response; by default the chosen ones.
    """
    plan = table.plan
    varying = {*plan.names, *plan.relations}
    described = throw_values(plan.throw, spelled_out=True)
    unvaried = {name: value for name, value in described.items() if name not in varying}
    chosen = {
        name: response.chosen if form is None else response.fit_named(form)
        for name, response in fits.items()
    }
    numbers = [factor for factor in plan.factors if not factor.labels]
    return ComplianceModel(
        responses={
            name: _response_model(response, chosen[name], plan) for name, response in fits.items()
        },
        fixed={name: value for name, value in unvaried.items() if isinstance(value, float)},
        ranges={factor.name: (factor.lowest, factor.highest) for factor in numbers},
        categories={factor.name: factor.labels for factor in plan.factors if factor.labels},
        labels={name: value for name, value in unvaried.items() if isinstance(value, str)},
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
            "end_sections": f"rigid; between neighbors polynomials of degree {SHARED}",
            "runs": int(np.sum(~table.held_out)),
            "held_out": int(np.sum(table.held_out)),
            "largest_fe_error_estimate": max(
                (response.fe_error for response in fits.values() if response.fe_error is not None),
                default=None,
            ),
        },
    )


def _response_model(fits: ResponseFits, fit: Fit, plan: StudyPlan) -> ResponseModel:
    inside = [factor for factor in plan.factors if factor.name in fit.factors]
    # The ranges of the study, where the runs of a space-filling design stay a little inside.
    return ResponseModel.from_fit(
        fit,
        symbol=fits.symbol,
        unit=fits.unit,
        support=fits.support,
        lowest={factor.name: factor.lowest for factor in inside},
        highest={factor.name: factor.highest for factor in inside},
        fe_error=fits.fe_error,
        equation=fits.equation(fit),
    )


def package_version(name: str) -> str:
    """Return the installed version of a package, or a mark that it runs uninstalled."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


LACK_OF_FIT = (
    "Finite-element runs repeat exactly: R2, standard errors, t and F measure the lack of fit of the form, "
    "not random error."
)
# What records say of a factor, of a form and of its statistics, under the names that they have there.
FACTOR = ("unit", "lowest", "highest", "levels", "labels")
FORM = (
    "form",
    "basis",
    "coefficient_count",
    "r_squared",
    "adjusted_r_squared",
    "q_squared",
    "band_error",
    "band_designs",
    "coefficients",
    "undetermined",
    "dropped",
)
STATISTICS = ("f_value", "aic", "bic", "condition_number")
# Above these a coefficient is poorly told from the others, a run decides nearly alone.
LARGEST_VIF = 10.0
LARGEST_LEVERAGE = 0.95


def study_record(
    table: StudyTable, fits: Mapping[str, ResponseFits], model: ComplianceModel | None = None
) -> Record:
    """A study's designs, failures, and every fitted equation with its errors.

    Parameters
    ----------
    model : ComplianceModel, optional
        With it, imported measured values are compared with the equations.
    """
    plan = table.plan
    errors = [response.fe_error for response in fits.values() if response.fe_error is not None]
    return {
        "key": plan.key,
        "design": plan.design.kind,
        "factors": {
            factor.name: {name: getattr(factor, name) for name in FACTOR} for factor in plan.factors
        },
        "relations": dict(plan.relations),
        "constraints": list(plan.constraints),
        "runs": int(np.sum(~table.held_out)),
        "held_out": int(np.sum(table.held_out)),
        "computed_now": table.computed,
        "added": table.added,
        "failures": [
            {"role": role, "values": list(values), "reason": reason}
            for role, values, reason in table.failures
        ],
        "excluded": [
            {"role": design.role, "values": list(design.values), "reason": design.reason}
            for design in table.excluded
        ],
        "largest_fe_error_estimate": max(errors, default=None),
        "table": {
            "values": table.values.tolist(),
            "held_out": table.held_out.tolist(),
            "responses": {name: column.tolist() for name, column in table.responses.items()},
            "errors": {name: column.tolist() for name, column in table.errors.items()},
        },
        "value_units": [factor.unit or "1" for factor in plan.factors],
        "statement": LACK_OF_FIT,
        "fits": {name: fits_record(table, response) for name, response in fits.items()},
        "unfitted": {
            name: reason for response in fits.values() for name, reason in response.unfitted.items()
        },
        "compared": [] if model is None else comparisons(table, model),
    }


def fits_record(table: StudyTable, response: ResponseFits) -> Record:
    """All forms fitted to one response, and the effects of the factors by its chosen equation."""
    units = {factor.name: factor.unit for factor in table.plan.factors}
    return {
        "column": response.column,
        "symbol": response.symbol,
        "unit": response.unit,
        "support": response.support,
        "chosen": response.chosen.form,
        "reason": response.reason,
        "fe_error": response.fe_error,
        "fe_scatter": response.fe_scatter,
        "skipped": list(response.skipped),
        "twins": dict(response.twins),
        "forms": [
            form_record(response, fit) | coefficient_units(response, fit, units)
            for fit in response.fits
        ],
        "sensitivities": _sensitivity_record(sensitivities(table, response)) | {"units": units},
    }


def form_record(response: ResponseFits, fit: Fit) -> Record:
    """One fitted form: its equation, its coefficients and its errors."""
    statistics = fit.statistics
    errors, t_values = statistics.standard_errors, statistics.t_values
    inflation = fit.variance_inflation
    return {
        **{name: getattr(fit, name) for name in FORM},
        **{name: getattr(statistics, name) for name in STATISTICS},
        "equation": response.equation(fit),
        "largest_error_at_runs": fit.largest_error,
        "mean_error_at_runs": fit.mean_error,
        "largest_error_held_out": fit.largest_heldout_error,
        "mean_error_held_out": fit.mean_heldout_error,
        "largest_variance_inflation": max(inflation.values(), default=None),
        "largest_leverage": float(np.max(statistics.leverage)),
        "standard_errors": fit.natural_standard_errors,
        "coded": [
            {
                "term": name,
                "symbols": symbols,
                "coefficient": value,
                "standard_error": None if errors is None else float(errors[place]),
                "t": None if t_values is None else float(t_values[place]),
                "variance_inflation": inflation.get(name),
            }
            for place, ((name, value), symbols) in enumerate(
                zip(fit.coded_coefficients.items(), term_symbols(fit.fitted), strict=True)
            )
        ],
        "warnings": warnings_of(fit),
    }


def coefficient_units(response: ResponseFits, fit: Fit, factor_units: Mapping[str, str]) -> Record:
    """Units of a form's coefficients: of the natural ones by term, or one for all, and of the coded ones."""
    form = fit.fitted
    unit = "1" if form.logarithmic or fit.basis == "groups" else response.unit or "1"
    columns = [
        "" if logarithm else factor_units.get(name, "")
        for name, logarithm in zip(form.factors, form.log_factors, strict=True)
    ]
    if not any(columns):
        return {"coefficient_units": unit, "coded_unit": unit}
    terms = [[columns[place] for place in term] for term in form.natural_coefficients()]
    units = [f"({unit})/({' '.join(filter(None, term))})" if any(term) else unit for term in terms]
    return {
        "coefficient_units": dict(zip(fit.coefficients, units, strict=True)),
        "coded_unit": unit,
    }


def warnings_of(fit: Fit) -> list[str]:
    """Remarks on the coefficients of a fit, one sentence each."""
    warnings = []
    inflated = [name for name, value in fit.variance_inflation.items() if value > LARGEST_VIF]
    if inflated:
        warnings.append(
            f"Variance inflation above {LARGEST_VIF:g} of {_listed(inflated)}: "
            "these coefficients are correlated, and only their combined effect is meaningful."
        )
    high = np.flatnonzero(fit.statistics.leverage > LARGEST_LEVERAGE)
    if high.size:
        warnings.append(
            f"Leverage above {LARGEST_LEVERAGE:g} of {high.size} of {fit.runs} runs: each of them nearly "
            "determines a coefficient alone, so its error at the runs is not meaningful."
        )
    return warnings


def _listed(names: list[str], shown: int = 6) -> str:
    more = len(names) - shown
    return ", ".join(names[:shown]) + (f" and {more} more" if more > 0 else "")


def _sensitivity_record(sensitivities: Sensitivities) -> Record:
    sobol = sensitivities.sobol
    return {
        "nominal": sensitivities.nominal,
        "elasticity": sensitivities.elasticity,
        "sobol": None
        if sobol is None
        else {
            "first": dict(zip(sobol.names, sobol.first, strict=True)),
            "total": dict(zip(sobol.names, sobol.total, strict=True)),
            "points": sobol.points,
            "shapley": None
            if sobol.shapley is None
            else dict(zip(sobol.names, sobol.shapley, strict=True)),
        },
    }


def comparisons(table: StudyTable, model: ComplianceModel) -> list[Record]:
    """Compare imported measured values with the model's equations.

    Returns
    -------
    list of dict
        Source, response, measured and calculated value, their ratio and the remarks of the lookup
        (those outside the range), or the reason why the model has no value.
    """
    return [
        _comparison(row, column, measured, model, table.plan)
        for row in table.extra
        if row.role == MEASURED
        for column, measured in row.responses.items()
    ]


def _comparison(
    row: ExtraRow, column: str, measured: float, model: ComplianceModel, plan: StudyPlan
) -> Record:
    record: Record = {"source": row.source, "response": column, "measured": measured}
    record["unit"] = RESPONSES[column].unit
    name = column.removesuffix("_pinned")
    if name not in model.responses:
        return record | {"reason": "the model has no such response"}
    try:
        calculated = model.lookup(name, **model.dimensions_of(_measured_throw(row, plan)))
    except InputError as error:
        return record | {"reason": str(error)}
    return record | {
        "calculated": calculated.value,
        "ratio": calculated.value / measured if measured else None,
        "remarks": list(calculated.remarks),
    }


def _measured_throw(row: ExtraRow, plan: StudyPlan) -> CrankThrow:
    """The study's throw with a row's dimensions; its parts follow from the factor values."""
    base: Mapping[str, Any] = plan.throw.model_dump(mode="json")
    if row.values is not None:
        base = plan.variants().at(np.array([row.values]))[0].throw or base
    return CrankThrow(**changed_record(base, {**row.dimensions, **row.outlines}))
