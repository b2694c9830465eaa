"""Linear elastic, isotropic material."""

from typing import ClassVar

from crankbase.model import InputModel, quantity_field
from crankbase.sentences import amount

# Young's modulus over density of metals of crankshafts, gray iron to steel, with a margin [m^2/s^2].
SPECIFIC_MODULUS = (1.0e7, 4.0e7)


class Material(InputModel):
    """Constants of a linear elastic, isotropic material.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa].
    poisson_ratio : float
        nu.
    density : float
        rho [kg/m^3].

    Raises
    ------
    InputError
        If a constant is missing or outside its range.
    """

    section: ClassVar[str] = "material"

    youngs_modulus: float = quantity_field(
        "Young's modulus", "Pa", symbol="E", minimum=1e9, maximum=1e12
    )
    poisson_ratio: float = quantity_field(
        "Poisson's ratio", "", symbol="nu", minimum=0.0, maximum=0.49
    )
    density: float = quantity_field(
        "density", "kg/m^3", symbol="rho", minimum=500.0, maximum=25000.0
    )

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_constant(self) -> float:
        """Lame's first constant lambda [Pa]."""
        return self.shear_modulus * 2.0 * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio)

    @property
    def remark(self) -> str | None:
        """Remark on an unusual combination of constants; None for a usual metal.

        Modulus over density is much the same for steel, iron, aluminum, titanium and magnesium, 20 to 30
        MN m/kg, so it reveals a modulus or a density that is wrong by a power of ten.
        """
        specific = self.youngs_modulus / self.density
        if SPECIFIC_MODULUS[0] <= specific <= SPECIFIC_MODULUS[1]:
            return None
        modulus, steel = (
            amount(value, "Pa", shown="GPa") for value in (self.youngs_modulus, 2.1e11)
        )
        density, of_steel = (amount(value, "kg/m^3") for value in (self.density, 7850.0))
        odd = "low" if specific < SPECIFIC_MODULUS[0] else "high"
        return (
            f"{modulus} is {odd} for {density}; steel has {steel} at {of_steel}, "
            "and other metals of crankshafts a like ratio: check both"
        )


STEEL = Material(youngs_modulus=2.1e11, poisson_ratio=0.3, density=7850.0)
"""Steel: E = 210 GPa, Poisson's ratio 0.3, 7850 kg/m^3."""
