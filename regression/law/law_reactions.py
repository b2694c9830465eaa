"""Reactions by the law: the end moments that a throw's compliances and tilts make.

With rigid sections and equal webs the couplings of pull, twist and pin forces with the tilts of the ends
follow from compliances, pinned and guided: guiding takes g^2 / f from a compliance, g being the tilt that
its load makes and f that of unit end moments.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError
from fem.end_reactions import Reactions
from geometry.throw import CrankThrow
from regression.end_reactions import NEEDED, ThrowLengths, end_reactions
from regression.law.networks import OUTPUTS
from regression.models.reaction_lookup import (
    ReactionLookup,
    both_ends,
    checked_force,
    checked_support,
    support_words,
)

if TYPE_CHECKING:
    from fem.supports import Support

Array = NDArray[np.float64]
# The networks that reactions are made of.
USED = OUTPUTS[:-1]


def law_reactions(
    throw: CrankThrow, values: Array, widths: Array, pin_force: ArrayLike, support: "Support"
) -> ReactionLookup:
    """Reactions of a throw by the law; `AxialLaw.reactions` says what is what.

    Parameters
    ----------
    throw : CrankThrow
    values, widths : (k,) array
        What the networks of `USED` say of it, and relative half widths of their bands.
    pin_force, support
        As there.

    Raises
    ------
    InputError
    """
    force = checked_force(pin_force)
    kind, gamma = checked_support(support)
    if kind != "pinned" and throw.symmetry != "quarter":
        raise InputError(
            f"support: given {support_words(kind, gamma)} with a throw that is not alike from both ends; "
            'allowed is "pinned", because the law knows end moments of equal webs only.'
        )
    pin = next(cylinder for cylinder in throw.parts.cylinders if cylinder.is_pin)
    lengths = ThrowLengths(throw.length, 0.5 * (pin.start + pin.end), throw.crank_radius)

    def loads(outputs: Array) -> Array:
        own = dict(zip(USED, outputs, strict=True))
        numbers = reaction_numbers(own, lengths, throw.main_journal_diameter)
        return end_reactions({name: numbers[name] for name in NEEDED[kind]}, lengths, force, gamma)

    middle, band = loads(values), np.zeros((*force.shape[:-1], 12))
    for place, width in enumerate(widths):
        step = np.zeros_like(values)
        step[place] = values[place] * width
        band += np.maximum(*(np.abs(loads(values + sign * step) - middle) for sign in (-1, 1)))
    return ReactionLookup(
        *both_ends(middle),
        band=Reactions(*both_ends(band)),
        support=support_words(kind, gamma),
        inside=np.ones(force.shape[:-1], dtype=bool),
        remarks=(),
    )


def reaction_numbers(
    answers: Mapping[str, Any], lengths: ThrowLengths, diameter: float
) -> dict[str, Any]:
    """Return what `end_reactions` needs, by all names of `NEEDED`.

    Parameters
    ----------
    answers : mapping
        Of the networks, which make E and the main journal's diameter 1.
    lengths : ThrowLengths
    diameter : float
        Of the main journal [m].
    """
    pinned, guided, rho, c_pinned, c_guided, twist, twist_guided, tilt, alike, across, by_force = (
        answers[name] for name in USED
    )
    whole, radius = lengths.whole / diameter, lengths.crank_radius / diameter
    coupling = np.sqrt((pinned - guided) * tilt)
    axial = coupling / (tilt * whole)
    radial = (c_pinned - c_guided) / (coupling * whole)
    torque = 0.5 * radius * np.sqrt((twist - twist_guided) * rho / tilt) / whole
    opposed = by_force / (across * whole)
    sides = {
        f"{name}_end_moment_{end}": value
        for name, value in (("radial", radial), ("axial", axial))
        for end in ("left_guided", "right_guided", "in_line")
    }
    return sides | {
        "axial_reaction": c_pinned / pinned,
        "axial_reaction_guided": c_guided / guided,
        "axial_compliance_in_line": guided,
        "axial_compliance_opposite": pinned,
        "influence_coefficient_in_line": c_guided,
        "influence_coefficient_opposite": c_pinned,
        "tilt_stiffness_ratio": rho,
        "tangential_end_moment_opposed_guided": opposed,
        "tangential_end_moment_in_line": opposed,
        "tangential_end_moment_alike_guided": torque,
        "tangential_end_moment_opposite": torque,
        "cross_tilt_stiffness_ratio": across / alike,
    }
