"""Arguments common to all formulas: the angle between neighboring cranks, and the moduli."""

import math
from typing import Protocol, runtime_checkable

from crankbase.checks.choices import check_kind
from crankbase.checks.scalars import is_number
from crankbase.errors import InputError, quoted
from fem.material import STEEL, Material
from geometry.throw import CrankThrow


@runtime_checkable
class OfThrow(Protocol):
    """What has a throw and its material: an analysis of a throw, or an engine."""

    @property
    def throw(self) -> CrankThrow:
        """Its throw."""

    @property
    def material(self) -> Material:
        """Of the throw."""


def throw_and_material(
    given: CrankThrow | OfThrow, material: Material | None
) -> tuple[CrankThrow, Material]:
    """Return the throw and the material of what is given; steel by default.

    Raises
    ------
    InputError
        If what has a material is given with another one, or the material is none.
    """
    if isinstance(given, OfThrow):
        if material not in (None, given.material):
            raise InputError(
                "material: given another one than the analysis has; allowed is the throw with a material, "
                "or the analysis without one."
            )
        return given.throw, given.material
    steel = STEEL if material is None else material
    check_kind("material", steel, Material, "a Material")
    return given, steel


def fold_angle_deg(gamma_deg: float) -> float:
    """Fold an angle between neighboring cranks to 0 ... 180 deg (240 and -120 become 120)."""
    rest = math.fmod(abs(gamma_deg), 360.0)
    return 360.0 - rest if rest > 180.0 else rest


def checked_angle_deg(gamma_deg: float) -> float:
    """Return the folded angle [deg] after checking it.

    Raises
    ------
    InputError
        If the angle is not a finite number.
    """
    if isinstance(gamma_deg, Material):
        raise InputError(
            "gamma_deg: given a Material; write it as material=..., because the second argument is the angle "
            "between neighboring cranks."
        )
    if not is_number(gamma_deg):
        raise InputError(
            f"gamma_deg: given {quoted(gamma_deg)}; allowed is a finite angle in deg between "
            "neighboring cranks, because it is folded to 0 to 180 deg."
        )
    return fold_angle_deg(gamma_deg)


def shear_modulus(youngs_modulus: float, poisson_ratio: float) -> float:
    """Return G = E / (2 (1 + nu)) [Pa] after checking both.

    Raises
    ------
    InputError
        If E is not a positive number, or nu not one within -1 < nu <= 0.5.
    """
    if not (is_number(youngs_modulus) and youngs_modulus > 0.0):
        raise InputError(
            f"youngs_modulus: given {quoted(youngs_modulus)}; allowed is a positive number of Pa, "
            "because a throw without stiffness has no compliance."
        )
    if not (is_number(poisson_ratio) and -1.0 < poisson_ratio <= 0.5):
        raise InputError(
            f"poisson_ratio: given {quoted(poisson_ratio)}; allowed is above -1 up to 0.5, the range of "
            "an isotropic material."
        )
    return youngs_modulus / (2.0 * (1.0 + poisson_ratio))
