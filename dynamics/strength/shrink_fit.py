"""The shrink fit of a semi-built crankshaft by UR M53: bore, shrinkage and adjacent fillet."""

import math
from dataclasses import KW_ONLY
from functools import cached_property
from typing import Annotated

from crankbase.array_checks import nonnegative_number, positive_number
from crankbase.choices import number_within
from crankbase.errors import InputError
from crankbase.results import Number, Part, Quantity, Result
from crankbase.sentences import amount, in_si, with_sentences
from crankbase.summaries import frozen
from dynamics.strength.fatigue import Stress

Length = Annotated[float, Quantity("m")]
# That of the rule's finite elements.
STEEL_MODULUS = 2.05e11
LEAST_SAFETY, MOST_FRICTION = 2.0, 0.2
# Of the generatrices of pin and journal, over the shrink diameter.
LEAST_DISTANCE, SPECIAL_DISTANCE = 0.05, 0.1
LEAST_FILLET, FILLET_OF_STEP = 0.015, 0.5
# How much the web may yield, over the shrink diameter.
YIELDING = 0.8e-3
LENGTHS = ("shrink_diameter", "shrink_length", "web_diameter", "journal_diameter", "fillet_radius")


@with_sentences
@frozen("least_shrinkage [m]", "most_shrinkage [m]", "largest_bore [m]", "refusals", "remarks")
class ShrinkFit(Result):
    """A journal shrunk into a web.

    Parameters
    ----------
    shrink_diameter, shrink_length : float
        D_S, L_S [m].
    web_diameter : float
        D_A: the web's outer diameter, or twice the least distance from the journal's center to the web's
        contour [m].
    journal_diameter, fillet_radius : float
        D_G and R_G next to the web [m].
    distance : float
        Y, of the generatrices of pin and journal [m].
    web_yield, journal_yield : float
        Yield strengths s_SW, s_SP [Pa].
    torque : float
        M_max: the largest torque of the fit, mean and alternating [N m].
    journal_bore : float, optional
        D_BG [m].
    friction : float, optional
        mu; 0.2 at most unless tests show more.
    safety : float, optional
        S_R against slipping, 2 at least.
    youngs_modulus : float, optional
        [Pa]

    Raises
    ------
    InputError
        If a value is not above zero, the diameters are not each above the last, or friction and safety
        are beyond the rule's.
    """

    shrink_diameter: Length
    shrink_length: Length
    web_diameter: Length
    journal_diameter: Length
    fillet_radius: Length
    distance: Length
    web_yield: Stress
    journal_yield: Stress
    torque: Annotated[float, Quantity("N m")]
    _: KW_ONLY
    journal_bore: Length = 0.0
    friction: Number = MOST_FRICTION
    safety: Number = LEAST_SAFETY
    youngs_modulus: Stress = STEEL_MODULUS

    def __post_init__(self) -> None:
        for name in LENGTHS:
            positive_number(name, getattr(self, name), "m", "it is a length")
        for name in ("web_yield", "journal_yield", "youngs_modulus"):
            positive_number(name, getattr(self, name), "Pa", "it is that of a steel")
        positive_number("torque", self.torque, "N m", "the fit passes a torque on")
        positive_number("friction", self.friction, "", "friction holds the fit")
        for name in ("distance", "journal_bore"):
            nonnegative_number(name, getattr(self, name), "m", "it is a length")
        reason = "the rule takes more from tests alone"
        number_within("friction", self.friction, 0.0, MOST_FRICTION, "", reason)
        if self.safety < LEAST_SAFETY:
            raise InputError(
                f"safety: given {self.safety:g}; allowed is 2 or more, because the rule requires that "
                "against slipping."
            )
        if not self.journal_bore < self.shrink_diameter < self.web_diameter:
            raise InputError(
                f"shrink_diameter: given {in_si(self.shrink_diameter, 'm')}; allowed is above the "
                f"journal_bore of {in_si(self.journal_bore, 'm')} and below the web_diameter of "
                f"{in_si(self.web_diameter, 'm')}, because the fit lies between them."
            )

    @property
    def largest_bore(self) -> Length:
        """Largest permissible bore of the journal [m]; 0 where a solid one is too weak.

        D_S sqrt(1 - 4000 S_R M_max / (mu pi D_S^2 L_S s_SP)), there with N and mm.
        """
        rest = 1.0 - self._slip / (self.shrink_diameter * self.journal_yield)
        return self.shrink_diameter * math.sqrt(max(rest, 0.0))

    @property
    def least_shrinkage(self) -> Length:
        """Z_min, the larger of the shrinkages for yield of the web and for the torque [m]."""
        web, journal = self._ratios
        yields = self.web_yield * self.shrink_diameter / self.youngs_modulus
        thin = (1.0 - (web * journal) ** 2) / ((1.0 - web**2) * (1.0 - journal**2))
        return max(yields, self._slip / self.youngs_modulus * thin)

    @property
    def most_shrinkage(self) -> Length:
        """Z_max = D_S (s_SW / E_m + 0.8 / 1000) [m]."""
        return self.shrink_diameter * (self.web_yield / self.youngs_modulus + YIELDING)

    @cached_property
    def refusals(self) -> Part[tuple[str, ...]]:
        """Violations of the rule, a sentence each; empty if the fit complies."""
        refused = []
        size = self.shrink_diameter
        if self.distance < LEAST_DISTANCE * size:
            refused.append(
                f"pin and journal are {_mm(self.distance)} apart at the fit, 0.05 shrink diameters or "
                f"{_mm(LEAST_DISTANCE * size)} are needed"
            )
        radius = max(
            LEAST_FILLET * self.journal_diameter, FILLET_OF_STEP * (size - self.journal_diameter)
        )
        if self.fillet_radius < radius:
            refused.append(
                f"the journal's fillet has a radius of {_mm(self.fillet_radius)}, {_mm(radius)} are needed"
            )
        if self._slip >= size * self.journal_yield:
            refused.append(
                "no bore is small enough: a solid journal yields under the pressure that the torque needs; "
                "use finite elements"
            )
        elif self.journal_bore > self.largest_bore:
            refused.append(
                f"the journal's bore of {_mm(self.journal_bore)} is above {_mm(self.largest_bore)}; use "
                "finite elements"
            )
        if self.least_shrinkage > self.most_shrinkage:
            refused.append(
                f"the torque needs a shrinkage of {_mm(self.least_shrinkage)}, the web bears "
                f"{_mm(self.most_shrinkage)} at most"
            )
        return tuple(refused)

    @property
    def remarks(self) -> Part[tuple[str, ...]]:
        """Points that the rule requires to be considered, a sentence each."""
        low, high = (share * self.shrink_diameter for share in (LEAST_DISTANCE, SPECIAL_DISTANCE))
        if not low <= self.distance < high:
            return ()
        return (
            f"pin and journal are {_mm(self.distance)} apart at the fit: special consideration is required "
            f"below {_mm(high)}, 0.1 shrink diameters",
        )

    @property
    def passed(self) -> Part[bool]:
        """Whether the rule permits the fit, with a shrinkage between the least and the largest."""
        return not self.refusals

    @property
    def _slip(self) -> float:
        """4 S_R M_max / (mu pi D_S L_S), a pressure at the fit times 2 D_S [N/m]."""
        area = self.friction * math.pi * self.shrink_diameter * self.shrink_length
        return 4.0 * self.safety * self.torque / area

    @property
    def _ratios(self) -> tuple[float, float]:
        """Q_A = D_S / D_A and Q_S = D_BG / D_S."""
        return (self.shrink_diameter / self.web_diameter, self.journal_bore / self.shrink_diameter)


def _mm(length: float) -> str:
    return amount(length, "m", 4)
