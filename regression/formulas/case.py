"""The arguments of a formula, and the beam compliances from which all formulas are built."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from crankbase.checks.choices import check_kind
from geometry.throw import CrankThrow


@dataclass(frozen=True)
class ThrowCase:
    """One throw with its material, the angle of its neighbors and the formulas' constants.

    Attributes
    ----------
    throw : CrankThrow
    gamma_deg : float
        Angle between neighboring cranks, folded to 0 ... 180 [deg].
    youngs_modulus, shear_modulus : float
        E, G [Pa].
    constants : mapping
        A value for every name in `DEFAULT_CONSTANTS`.
    given_constants : frozenset of str
        Those that were given.
    """

    throw: CrankThrow
    gamma_deg: float
    youngs_modulus: float
    shear_modulus: float
    constants: Mapping[str, float]
    given_constants: frozenset[str]

    def __post_init__(self) -> None:
        check_kind("throw", self.throw, CrankThrow, "a CrankThrow")

    @property
    def cosine(self) -> float:
        """Cosine of gamma."""
        return math.cos(math.radians(self.gamma_deg))

    @property
    def pin(self) -> float:
        """Bending of the crankpin, R^2 L_shm / (E I_shm) [m/N]."""
        return self.pin_of_length(self.throw.pin_length)

    def pin_of_length(self, length: float) -> float:
        """Bending of a crankpin of this length under the moment R of a unit force [m/N]."""
        inertia = round_inertia(self.throw.pin_diameter, self.throw.pin_bore)
        return self.throw.crank_radius**2 * length / (self.youngs_modulus * inertia)

    @property
    def web(self) -> float:
        """Bending of the web out of its plane, R^3 / (E B h^3 / 12) [m/N]."""
        return self.web_of_thickness(self.throw.web_thickness)

    def web_of_thickness(self, thickness: float) -> float:
        """Bending of a web of this thickness [m/N]."""
        inertia = self.throw.web_width * thickness**3 / 12.0
        return self.throw.crank_radius**3 / (self.youngs_modulus * inertia)

    @property
    def tension(self) -> float:
        """Stretch of journal and pin, (L_km / F_km + L_shm / F_shm) / E [m/N]."""
        return self.tension_of_lengths(self.throw.main_journal_length, self.throw.pin_length)

    def tension_of_lengths(self, journal_length: float, pin_length: float) -> float:
        """Stretch of a journal and a pin of these lengths [m/N]."""
        throw = self.throw
        journal = journal_length / round_area(throw.main_journal_diameter, throw.main_journal_bore)
        pin = pin_length / round_area(throw.pin_diameter, throw.pin_bore)
        return (journal + pin) / self.youngs_modulus

    def shear_of_length(self, length: float) -> float:
        """Shear of a web of this length on the full section, length / (G B h) [m/N]."""
        return length / (self.shear_modulus * self.throw.web_width * self.throw.web_thickness)


def round_inertia(diameter: float, bore: float) -> float:
    """Second moment of area of a round section with a concentric bore [m^4]."""
    return math.pi / 64.0 * (diameter**4 - bore**4)


def round_area(diameter: float, bore: float) -> float:
    """Area of a round section with a bore [m^2]."""
    return math.pi / 4.0 * (diameter**2 - bore**2)
