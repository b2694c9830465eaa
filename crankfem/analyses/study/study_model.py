"""The compliance model of a study's fitted equations."""

import datetime
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from crankfem.analyses.provenance import program_version
from crankfem.analyses.study.response_fits import ResponseFits
from fem.section_motions import SHARED
from regression.fits.columns import constant_groups
from regression.fits.fits import Fit
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.runs.study_table import StudyTable
from regression.throw_values import throw_values


def compliance_model(
    table: StudyTable, fits: Mapping[str, ResponseFits], form: str | None = None
) -> ComplianceModel:
    """Make the model for lookups.

    Parameters
    ----------
    table : StudyTable
    fits : mapping
        From `fit_study`.
    form : str, optional
        Form for every response; by default the chosen ones.

    Raises
    ------
    InputError
        If the form was not fitted to a response.
    """
    plan = table.plan
    varying = {*plan.names, *plan.relations}
    described = throw_values(plan.throw, spelled_out=True)
    unvaried = {name: value for name, value in described.items() if name not in varying}
    chosen = {
        name: found.chosen if form is None else found.fit_named(form)
        for name, found in fits.items()
    }
    numbers = [factor for factor in plan.factors if not factor.labels]
    return ComplianceModel(
        responses={
            name: _response_model(found, chosen[name], plan) for name, found in fits.items()
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
                (found.fe_error for found in fits.values() if found.fe_error is not None),
                default=None,
            ),
        },
    )


def _response_model(found: ResponseFits, fit: Fit, plan: StudyPlan) -> ResponseModel:
    inside = [factor for factor in plan.factors if factor.name in fit.factors]
    # The ranges of the study, where the runs of a space-filling design stay a little inside.
    return ResponseModel.from_fit(
        fit,
        symbol=found.symbol,
        unit=found.unit,
        support=found.support,
        lowest={factor.name: factor.lowest for factor in inside},
        highest={factor.name: factor.highest for factor in inside},
        fe_error=found.fe_error,
        equation=found.equation(fit),
    )


def package_version(name: str) -> str:
    """Return the installed version of a package, or a mark that it runs uninstalled."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
