"""Hardened fillets and oil holes by Appendix V of UR M53: stress and strength below the surface."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_array, nonnegative_number, positive_number
from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.strength.concentration import ConcentrationFactors
from dynamics.strength.element_factors import ElementFactors
from dynamics.strength.fatigue import MPA

Process = Literal["induction", "nitriding"]
TREATED = ("pin fillet", "oil hole")
# The softer steel below an induction hardened layer has so much of the strength of untreated steel.
BELOW_HARDENED = 0.8
# The transition below a nitrided layer, over its depth.
NITRIDED_TRANSITION = 1.2
NITRIDED_STRENGTH, NITRIDED_HARDNESS = 450e6, 600.0
# Hardening depths from the end of the hardened zone, and what the strength is there.
END_OF_HARDENING = ((1.0, 0.80), (2.0, 0.88), (3.0, 0.94))


@summarized("process", "depth [m]", "surface_hardness", "surface_strength [Pa]")
@dataclass(frozen=True)
class SurfaceTreatment:
    """A hardened surface.

    Parameters
    ----------
    process : {"induction", "nitriding"}
        Stroke peening and cold rolling raise the strength by tests alone, and are not included.
    depth : float
        Depth at which 80 % of the least surface hardness is left (induction), t_N (nitriding) [m].
    surface_hardness : float
        Vickers: 400 or more of induction, 600 or more of nitriding.

    Raises
    ------
    InputError
        If the process is neither, the depth not above zero, or the surface too soft for the rule's values.
    """

    process: Process
    depth: float
    surface_hardness: float

    def __post_init__(self) -> None:
        check_choice(
            "process", self.process, ("induction", "nitriding"), "the rule has values for these"
        )
        positive_number("depth", self.depth, "m", "a layer is hardened")
        least = NITRIDED_HARDNESS if self.process == "nitriding" else 400.0
        hard = positive_number(
            "surface_hardness", self.surface_hardness, "HV", "a layer is hardened"
        )
        if hard < least:
            raise InputError(
                f"surface_hardness: given {hard:g} HV; allowed is {least:g} HV or more for {self.process}, "
                "because the rule's strength of the surface begins there."
            )

    @property
    def surface_strength(self) -> float:
        """Fatigue strength of the surface [Pa]: 400 + 0.5 (HV - 400) N/mm2, or 450 when nitrided."""
        if self.process == "nitriding":
            return NITRIDED_STRENGTH
        return MPA * (400.0 + 0.5 * (self.surface_hardness - 400.0))

    @property
    def transition(self) -> float:
        """Depth below which the untreated steel must have the strength [m]."""
        return self.depth * (NITRIDED_TRANSITION if self.process == "nitriding" else 1.0)

    def transition_strength(self, untreated: float) -> float:
        """Return the fatigue strength at the transition, from that of the untreated surface [Pa].

        Raises
        ------
        InputError
            If the strength is not positive.
        """
        strength = positive_number("untreated", untreated, "Pa", "a strength is positive")
        return strength * (BELOW_HARDENED if self.process == "induction" else 1.0)

    def hardness(self, depths: ArrayLike, core_hardness: float) -> FloatArray:
        """Return the Vickers hardness below a nitrided surface.

        Parameters
        ----------
        depths : (m,) array_like
            [m]
        core_hardness : float
            HV_c, more than 50 below the surface's.

        Raises
        ------
        InputError
            If the surface is not nitrided, or too little harder than the core.

        Notes
        -----
        HV_c + (HV_s - HV_c) (50 / (HV_s - HV_c))^((t / t_N)^2).
        """
        if self.process != "nitriding":
            raise InputError(
                "process: given induction; allowed is nitriding, because the rule gives only its hardness."
            )
        core = positive_number("core_hardness", core_hardness, "HV", "it is a hardness")
        above = self.surface_hardness - core
        if above <= 50.0:
            raise InputError(
                f"core_hardness: given {core:g} HV; allowed is below {self.surface_hardness - 50.0:g} HV, "
                "because the layer ends where it is 50 HV above the core."
            )
        share = finite_array("depths", depths) / self.depth
        return np.asarray(core + above * (50.0 / above) ** (share**2))


def strength_near_end(distance: float, depth: float) -> float:
    """Return the factor on the strength near the end of induction hardening at the surface.

    Parameters
    ----------
    distance, depth : float
        From the end of the hardened zone, and its depth [m]: 0.8, 0.88 and 0.94 up to one, two and three
        depths, 1 beyond.

    Raises
    ------
    InputError
        If either is not above zero.
    """
    ratio = positive_number("distance", distance, "m", "it is a length") / positive_number(
        "depth", depth, "m", "it is a length"
    )
    return next((share for end, share in END_OF_HARDENING if ratio <= end), 1.0)


def factors_below(
    factors: ConcentrationFactors | ElementFactors, place: str, depth: float
) -> tuple[float, float]:
    """Return the factors on bending and torsion at a depth below the surface.

    Parameters
    ----------
    factors : ConcentrationFactors or ElementFactors
    place : {"pin fillet", "oil hole"}
        The available text has no formula for the journal's fillet.
    depth : float
        t [m].

    Raises
    ------
    InputError
        If the location is unknown, it has no such part, or the depth is negative.

    Notes
    -----
    Pin fillet: (alpha_B - 1) exp(-2 t / R_H) + 1 - (2 t / sqrt(W^2 + S^2))^(0.6 / sqrt(alpha_B)) and
    (alpha_T - 1) exp(-t / R_H) + 1 - (2 t / D)^(1 / sqrt(alpha_T)); oil hole:
    (gamma_B - 1) exp(-4 t / D_O) + 1 and (gamma_T - 1) exp(-2 t / D_O) + 1.
    """
    check_choice("place", place, TREATED, "the rule has formulas for these")
    nonnegative_number("depth", depth, "m", "it lies below the surface")
    bending, _, torsion = factors.at(place)
    web = factors.web
    if place == "oil hole":
        over = depth / web.oil_hole_diameter
        return (
            (bending - 1.0) * math.exp(-4.0 * over) + 1.0,
            (torsion - 1.0) * math.exp(-2.0 * over) + 1.0,
        )
    over = depth / web.pin_fillet_radius
    across = 2.0 * depth / math.hypot(web.section_thickness, web.overlap)
    through = 2.0 * depth / web.pin_diameter
    if max(across, through) >= 1.0:
        raise InputError(
            f"depth: given {depth:g} m; allowed is less than half of web and pin, because stresses fall to "
            "zero in their middle."
        )
    return (
        (bending - 1.0) * math.exp(-2.0 * over) + 1.0 - across ** (0.6 / math.sqrt(bending)),
        (torsion - 1.0) * math.exp(-over) + 1.0 - through ** (1.0 / math.sqrt(torsion)),
    )
