"""From a study's table to fitted equations and the compliance model."""

import datetime
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

from geometry.errors import InputError
from regression.compliance_model import KNOWN_RESPONSES, ComplianceModel, ResponseModel
from regression.fits import Fit, choose, fit_form
from regression.forms import equation_text
from regression.study import FACTORS, StudyTable

FORMS = ("linear", "quadratic", "log-quadratic")
# Response of the model: its column in a study's table, symbol and unit.
RESPONSES = {
    name: (f"{name}_pinned", symbol, unit) for name, (symbol, unit) in KNOWN_RESPONSES.items()
}


@dataclass(frozen=True)
class ResponseFits:
    """All forms fitted to one response, and the one chosen by the held-out error.

    Attributes
    ----------
    response, symbol, unit : str
    fits : tuple of Fit
    chosen : Fit
    skipped : tuple of str
        Forms that could not be fitted, with the reason.
    """

    response: str
    symbol: str
    unit: str
    fits: tuple[Fit, ...]
    chosen: Fit
    skipped: tuple[str, ...]

    def equation(self, fit: Fit) -> str:
        """Equation of a fit in the units of the field."""
        return equation_text(fit.fitted, symbol=self.symbol, unit=self.unit)


def fit_study(table: StudyTable) -> dict[str, ResponseFits]:
    """Fit all forms to all responses of a study.

    Parameters
    ----------
    table : StudyTable

    Returns
    -------
    dict
        Response name to its fits.

    Raises
    ------
    InputError
        If too few designs have results for even the smallest form, or no held-out design has one.
    """
    if not table.held_out.any():
        reasons = "; ".join(sorted({reason for _, _, reason in table.failures})[:3])
        raise InputError(f"study: no held-out design has a result ({reasons}).")
    found = {}
    for response, (column, symbol, unit) in RESPONSES.items():
        values = table.responses[column]
        fits, skipped = [], []
        for form in FORMS:
            try:
                fits.append(
                    fit_form(
                        form,
                        table.plan.factors,
                        table.values[~table.held_out],
                        values[~table.held_out],
                        table.values[table.held_out],
                        values[table.held_out],
                    )
                )
            except InputError as error:
                skipped.append(f"{form}: {error}")
        if not fits:
            raise InputError(f"study: no form can be fitted ({'; '.join(skipped)})")
        found[response] = ResponseFits(
            response, symbol, unit, tuple(fits), choose(fits), tuple(skipped)
        )
    return found


def compliance_model(table: StudyTable, fits: dict[str, ResponseFits]) -> ComplianceModel:
    """Make the model that lookups use from the chosen fits."""
    plan = table.plan
    lowest = {name: min(levels) for name, levels in plan.levels.items()}
    highest = {name: max(levels) for name, levels in plan.levels.items()}
    return ComplianceModel(
        responses={
            name: ResponseModel.from_fit(
                found.chosen,
                symbol=found.symbol,
                unit=found.unit,
                lowest=lowest,
                highest=highest,
            )
            for name, found in fits.items()
        },
        fixed={
            name: float(value)
            for name in FACTORS
            if name not in plan.levels and (value := getattr(plan.throw, name)) is not None
        },
        material=plan.material.model_dump(),
        provenance={
            "study": plan.key,
            "crankfem": crankfem_version(),
            "date": datetime.date.today().isoformat(),
            "throw": plan.throw.model_dump_json(exclude_defaults=True),
            "largest_fe_error_estimate": float(table.responses["error_estimate"].max()),
        },
    )


def crankfem_version() -> str:
    """Return the installed version, or a mark that it runs uninstalled."""
    try:
        return version("crankfem")
    except PackageNotFoundError:
        return "not installed"
