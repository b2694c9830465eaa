"""Linear elastic, isotropic material."""

from typing import ClassVar

from crankbase.model import InputModel, quantity_field


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


STEEL = Material(youngs_modulus=2.1e11, poisson_ratio=0.3, density=7850.0)
"""Steel: E = 210 GPa, Poisson's ratio 0.3, 7850 kg/m^3."""
