"""Values of the published formulas for one throw as plain JSON content, with those of finite elements."""

from collections.abc import Mapping, Sequence

from crankfem.analyses.record import Record, attributes
from crankfem.analyses.throw.law_record import LAW, law_record
from fem.angle_law import is_symmetric
from fem.material import Material
from fem.supports import Neighbors
from fem.throw_analysis import ThrowAnalysis
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formula_faults, axial_formulas
from regression.formulas.formula_value import FormulaValue
from regression.formulas.torsional_formulas import torsional_formulas


def formula_records(
    throw: CrankThrow,
    material: Material,
    gamma_deg: float = 180.0,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> Record:
    """Values of all published formulas for a throw.

    Parameters
    ----------
    throw : CrankThrow
    material : Material
    gamma_deg, variant, constants
        As in `axial_formulas`.

    Returns
    -------
    dict
        "axial" [m/N] and "torsional" [rad/(N m)]: a record for each formula; "law": `law_answers`
        at that angle, None if it does not cover the throw; "left_out": axial formulas without a value in
        a printed reading, and the law without results, with the reason.

    Raises
    ------
    InputError
        As `axial_formulas`.
    """
    axial = axial_formulas(
        throw, gamma_deg, material=material, variant=variant, constants=constants
    )
    torsional = torsional_formulas(throw, material=material)
    faults = axial_formula_faults(throw, variant) if variant in ("printed", "corrected") else {}
    law = law_record(throw, material, gamma_deg)
    if law["answers"] is None:
        faults |= {LAW: f"the law, {law['reason'].rstrip('.')}"}
    return {
        "axial": _records(axial),
        "torsional": _records(torsional),
        "law": law["answers"],
        "left_out": [{"name": name, "reason": reason} for name, reason in faults.items()],
    }


def _records(values: Mapping[str, FormulaValue]) -> list[Record]:
    names = ("value", "unit", "valid", "variant", "remarks", "source")
    return [{"name": name, **attributes(own, *names)} for name, own in values.items()]


def fe_axial(analysis: ThrowAnalysis, gamma_deg: float) -> float:
    """Axial compliance by finite elements in a helix of throws with one angle between them [m/N].

    Parameters
    ----------
    analysis : ThrowAnalysis
    gamma_deg : float
        Angle between neighboring cranks [deg].

    Raises
    ------
    InputError
        If the angle is not finite.
    """
    return fe_axial_curve(analysis, [gamma_deg])[0]


def fe_axial_curve(analysis: ThrowAnalysis, gammas_deg: Sequence[float]) -> list[float]:
    """Return `fe_axial` at several angles; the law of equal webs is found once for all of them."""
    if is_symmetric(analysis.superelement):
        law = analysis.angle_law
        return [float(law.axial(gamma)) for gamma in gammas_deg]
    return [analysis.axial_compliance(Neighbors(gamma, gamma)) for gamma in gammas_deg]


def fe_record(analysis: ThrowAnalysis, gamma_deg: float) -> Record:
    """Values by finite elements to compare with the formulas.

    Parameters
    ----------
    analysis : ThrowAnalysis
    gamma_deg : float
        Angle between neighboring cranks [deg].

    Returns
    -------
    dict
        "axial" at that angle [m/N], and with rigid sections "axial_rigid_sections"; "torsional" (pinned)
        [rad/(N m)], "error_estimate"; and "angle_law", the law's e_0, e_180 [m/N] and rho, None where
        the webs differ.
    """
    law = analysis.angle_law if is_symmetric(analysis.superelement) else None
    return {
        "axial": fe_axial(analysis, gamma_deg),
        "axial_rigid_sections": fe_axial(analysis.with_sections("rigid"), gamma_deg),
        "torsional": analysis.torsional_compliance("pinned"),
        "error_estimate": analysis.error_estimate,
        "angle_law": None
        if law is None
        else {"e_0": law.in_line, "e_180": law.opposite, "rho": law.ratio},
    }
