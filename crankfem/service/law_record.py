"""What the law says of a throw as plain JSON content: values with bands, and reactions to a radial force."""

from crankfem.analyses.record import Record
from fem.material import Material
from geometry.throw import CrankThrow
from regression.law.throw_law import throw_laws


def law_record(
    throw: CrankThrow, material: Material, radial_force: float, gamma_deg: float | None = None
) -> Record:
    """Return compliances, influence coefficients and reactions of a throw by the law.

    Parameters
    ----------
    throw : CrankThrow
    material : Material
    radial_force : float
        Z on the middle of the pin, towards the shaft [N].
    gamma_deg : float, optional
        Angle to equal neighbors, one more support [deg].

    Raises
    ------
    InputError
        If the throw or the material is outside the law's range.
    """
    axial, torsional = throw_laws(
        throw, youngs_modulus=material.youngs_modulus, poisson_ratio=material.poisson_ratio
    )
    values = {
        "axial_compliance_pinned": _banded(axial.pinned, axial.errors["pinned"], "m/N"),
        "axial_compliance_guided": _banded(axial.guided, axial.errors["guided"], "m/N"),
        "influence_coefficient_pinned": _banded(
            axial.influence_pinned, axial.errors["influence_pinned"], "m/N"
        ),
        "influence_coefficient_guided": _banded(
            axial.influence_guided, axial.errors["influence_guided"], "m/N"
        ),
        "torsional_compliance_pinned": _banded(
            torsional.pinned, torsional.errors["pinned"], "rad/(N m)"
        ),
        "torsional_compliance_guided": _banded(
            torsional.guided, torsional.errors["guided"], "rad/(N m)"
        ),
    }
    if gamma_deg is not None:
        for name, value in (
            ("axial_compliance", axial.axial(gamma_deg)),
            ("influence_coefficient", axial.influence(gamma_deg)),
        ):
            values[f"{name}_neighbors"] = {
                "value": float(value), "lower": None, "upper": None, "unit": "m/N"
            }  # fmt: skip
    return {
        "values": values,
        "ratio": axial.ratio,
        "radial_force": radial_force,
        "reactions": _pinned_reactions(throw, radial_force, axial.influence_pinned / axial.pinned),
        "tier": axial.tier,
        "nearest_limit": axial.nearest_limit,
        "remarks": [
            f"Bands hold the true value in 95 of 100 throws. The law's nearest limit: {axial.nearest_limit}."
        ],
    }


def _banded(value: float, error: float, unit: str) -> Record:
    low, high = sorted((value * (1.0 - error), value * (1.0 + error)))
    return {"value": value, "lower": low, "upper": high, "unit": unit}


def _pinned_reactions(throw: CrankThrow, force: float, axial_per_radial: float) -> Record:
    """Reactions of pinned ends: across the shaft by levers, along it P = c Z / e_n."""
    pin = throw.parts.pins[0]
    right = 0.5 * (pin.start + pin.end) / throw.length
    axial = axial_per_radial * force
    return {
        "left": {"force": [0.0, force * (1.0 - right), axial], "moment": [0.0, 0.0, 0.0]},
        "right": {"force": [0.0, force * right, -axial], "moment": [0.0, 0.0, 0.0]},
    }
