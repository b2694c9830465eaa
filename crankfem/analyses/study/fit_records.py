"""A study's compliance model, and its results as the report shows and ``--json`` prints them."""

import datetime
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from crankbase.errors import InputError
from crankbase.results import made_from
from crankfem.analyses.provenance import installed_version, program_version
from crankfem.analyses.study.nominal_throw import sensitivities
from crankfem.analyses.study.response_fits import ResponseFits
from crankfem.analyses.study.study_results import (
    LACK_OF_FIT,
    Comparison,
    FactorRange,
    FittedStudy,
)
from fem.response_table import RESPONSES
from fem.symmetry import SHARED
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record
from regression.fits.forms import constant_groups
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.records import MEASURED, ExtraRow
from regression.runs.study_table import StudyTable
from regression.throw_values import throw_values

# Packages that a study's results depend on most.
MESHING = ("gmsh", "scikit-fem")


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
    responses = {}
    for name, response in fits.items():
        fit = chosen[name]
        # The ranges of the study, where the runs of a space-filling design stay a little inside.
        inside = [factor for factor in plan.factors if factor.name in fit.factors]
        responses[name] = ResponseModel.from_fit(
            fit,
            symbol=response.symbol,
            unit=response.unit,
            support=response.support,
            ranges={factor.name: (factor.lowest, factor.highest) for factor in inside},
            fe_error=response.fe_error,
        )
    return ComplianceModel(
        responses=responses,
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
            **{name: installed_version(name) or "not installed" for name in MESHING},
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


def fitted_study(
    table: StudyTable, fits: Mapping[str, ResponseFits], model: ComplianceModel | None = None
) -> FittedStudy:
    """Describe a study's designs, failures, and every fitted equation with its errors.

    Parameters
    ----------
    model : ComplianceModel, optional
        With it, imported measured values are compared with the equations.
    """
    plan = table.plan
    units = {factor.name: factor.unit for factor in plan.factors}
    errors = [response.fe_error for response in fits.values() if response.fe_error is not None]
    return FittedStudy(
        key=plan.key,
        design=plan.design.kind,
        factors={factor.name: made_from(factor, FactorRange) for factor in plan.factors},
        relations=plan.relations,
        constraints=plan.constraints,
        runs=int(np.sum(~table.held_out)),
        held_out=int(np.sum(table.held_out)),
        computed_now=table.computed,
        added=table.added,
        failures=table.failures,
        excluded=table.excluded,
        largest_fe_error_estimate=max(errors, default=None),
        table=table,
        value_units=tuple(unit or "1" for unit in units.values()),
        statement=LACK_OF_FIT,
        fits={
            name: replace(response, sensitivities=sensitivities(table, response))
            for name, response in fits.items()
        },
        unfitted={
            name: reason for response in fits.values() for name, reason in response.unfitted.items()
        },
        compared=() if model is None else comparisons(table, model),
    )


def comparisons(table: StudyTable, model: ComplianceModel) -> tuple[Comparison, ...]:
    """Compare imported measured values with the model's equations."""
    return tuple(
        _comparison(row, column, measured, model, table.plan)
        for row in table.extra
        if row.role == MEASURED
        for column, measured in row.responses.items()
    )


def _comparison(
    row: ExtraRow, column: str, measured: float, model: ComplianceModel, plan: StudyPlan
) -> Comparison:
    about = (row.source, column, measured, RESPONSES[column].unit)
    name = column.removesuffix("_pinned")
    if name not in model.responses:
        return Comparison(*about, "the model has no such response")
    # The study's throw with the row's dimensions; its parts follow from the factor values.
    base: Mapping[str, Any] = plan.throw.model_dump(mode="json")
    if row.values is not None:
        base = plan.variants().at(np.array([row.values]))[0].throw or base
    try:
        throw = CrankThrow(**changed_record(base, {**row.dimensions, **row.outlines}))
        calculated = model.lookup(name, **model.dimensions_of(throw))
    except InputError as error:
        return Comparison(*about, str(error))
    ratio = calculated.value / measured if measured else None
    return Comparison(*about, None, calculated.value, ratio, calculated.remarks)
