"""Results of the law for a throw as plain JSON content: values and reactions, all with bands."""

from collections.abc import Sequence

from crankfem.analyses.record import Record, attributes
from crankfem.analyses.throw.law_record import LAW_BANDS, end_answers, neighbor_answers
from fem.material import Material
from fem.supports import Support
from geometry.throw import CrankThrow
from regression.law.superelement import law_reactions
from regression.law.throw_law import throw_laws
from regression.models.lookup import ReactionLookup


def law_answer(
    throw: CrankThrow,
    material: Material,
    gamma_deg: float | None = None,
    pin_force: Sequence[float] | None = None,
    support: Support = "pinned",
) -> Record:
    """Return compliances, influence coefficients and reactions of a throw by the law.

    Parameters
    ----------
    throw : CrankThrow
    material : Material
    gamma_deg : float, optional
        Angle to equal neighbors, one more support [deg].
    pin_force : (3,) sequence of float, optional
        Across the shaft, in the throw frame [N]; without it no reactions are returned.
    support : "pinned", "guided" or Neighbors
        For the reactions.

    Raises
    ------
    InputError
        If the throw or the material is outside the law's range, or the force has a part along the shaft.
    """
    axial, torsional = throw_laws(
        throw, youngs_modulus=material.youngs_modulus, poisson_ratio=material.poisson_ratio
    )
    values = {}
    for name, own in end_answers(axial, torsional).items():
        if own["support"]:
            values[f"{name.removesuffix('_guided')}_{own['support']}"] = own
    if gamma_deg is not None:
        for name, own in neighbor_answers(axial, gamma_deg).items():
            values[f"{name}_neighbors"] = own
    remarks = [f"{LAW_BANDS} The ratio closest to a limit of the law: {axial.nearest_limit}."]
    reactions = None
    if pin_force is not None and not throw.parts.mirrored:
        remarks.append("No reactions: the law has those of throws with equal webs only.")
    elif pin_force is not None:
        found = law_reactions(throw, pin_force, support, poisson_ratio=material.poisson_ratio)
        reactions = reactions_record(found)
    return {
        "values": values,
        "ratio": axial.ratio,
        "reactions": reactions,
        "tier": axial.tier,
        "nearest_limit": axial.nearest_limit,
        "remarks": remarks,
    }


def reactions_record(found: ReactionLookup) -> Record:
    """Return reactions by a law or a model: of each end force and moment, and how far they may be off."""
    return {
        "support": found.support,
        **{
            side: {
                **attributes(getattr(found, side), "force", "moment"),
                "force_band": attributes(getattr(found.band, side), "force")["force"],
                "moment_band": attributes(getattr(found.band, side), "moment")["moment"],
            }
            for side in ("left", "right")
        },
    }
