"""Factors of stress concentration from finite elements, in place of the formulas of UR M53."""

import math
from dataclasses import dataclass

from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.strength.concentration import FACTORS, ConcentrationFactors
from dynamics.strength.crank_web import CrankWeb

SYMBOLS = dict(
    zip(
        FACTORS,
        ("alpha_B", "alpha_T", "beta_B", "beta_Q", "beta_T", "gamma_B", "gamma_T"),
        strict=True,
    )
)


@summarized("alpha_bending", "alpha_torsion", "beta_bending", "beta_shear", "beta_torsion")
@dataclass(frozen=True)
class ElementFactors:
    """Factors on the nominal stresses of a web's pin and journal by finite elements (Appendix III, VI).

    Parameters
    ----------
    web : CrankWeb
    alpha_bending, alpha_torsion : float or None
        At the pin's fillet: largest equivalent stress by von Mises under a bending moment, largest shear
        stress under a torque. None without a fillet.
    beta_bending, beta_torsion : float or None
        At the journal's fillet.
    beta_shear : float or None
        Method 1: (s_3P - s_N3P beta_B) / s_Q3P of a throw in three-point bending.
    beta_combined : float or None
        Method 2: s_3P / s_N3P, on the bending stress alone.
    gamma_bending, gamma_torsion : float or None
        Largest principal stress at the pin's oil hole, the moment about the axis across the hole. None
        without a hole.
    error : float
        Estimated relative error of the largest stresses.
    as_ruled : bool
        Whether mesh and stresses meet the criteria of Appendix III.
    """

    web: CrankWeb
    alpha_bending: float | None
    alpha_torsion: float | None
    beta_bending: float | None
    beta_shear: float | None
    beta_torsion: float | None
    beta_combined: float | None
    gamma_bending: float | None
    gamma_torsion: float | None
    error: float
    as_ruled: bool

    @property
    def shear_error(self) -> float | None:
        """Estimated relative error of `beta_shear`: `error`, magnified by the difference of stresses."""
        if self.beta_combined is None or self.beta_bending is None:
            return None
        left = abs(self.beta_combined - self.beta_bending)
        return self.error * self.beta_combined / left if left > 0.0 else math.inf

    def at(self, place: str) -> tuple[float, float, float]:
        """Return the factors on bending, shear and torsion at a location; 0 where shear does not count.

        Raises
        ------
        InputError
            If the throw is modeled without that location.
        """
        bending, shear, torsion = {
            "pin fillet": (self.alpha_bending, 0.0, self.alpha_torsion),
            "journal fillet": (self.beta_bending, self.beta_shear, self.beta_torsion),
            "oil hole": (self.gamma_bending, 0.0, self.gamma_torsion),
        }[place]
        if bending is None or shear is None or torsion is None:
            part = "oil_holes" if place == "oil hole" else "fillet_radius"
            raise InputError(
                f"{part}: given none there; allowed is a throw with this {place}, because finite elements "
                "have no factor for what is not meshed."
            )
        return bending, shear, torsion


def unsafe_formulas(
    formulas: ConcentrationFactors | None, elements: ElementFactors | None
) -> dict[str, tuple[float, float]]:
    """Return the factors that are smaller by the rule's formulas than by finite elements: symbol to both."""
    found: dict[str, tuple[float, float]] = {}
    if formulas is None or elements is None:
        return found
    for name, symbol in SYMBOLS.items():
        by_elements = getattr(elements, name)
        if by_elements is None:
            continue
        try:
            by_formula = getattr(formulas, name)
        except InputError:
            continue
        if by_formula < by_elements:
            found[symbol] = by_formula, by_elements
    return found
