"""Arguments common to all formulas: the angle between neighboring cranks, and the moduli."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from crankbase.checks.choices import check_kind, is_number
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
    throw: CrankThrow | OfThrow, material: Material | None
) -> tuple[CrankThrow, Material]:
    """Throw and material, steel by default; `InputError` if what has a material is given with another one."""
    if isinstance(throw, OfThrow):
        if material not in (None, throw.material):
            raise InputError(
                "material: given another one than the analysis has; allowed is the throw with a material, "
                "or the analysis without one."
            )
        return throw.throw, throw.material
    steel = STEEL if material is None else material
    check_kind("material", steel, Material, "a Material")
    return throw, steel


def fold_angle_deg(gamma_deg: float) -> float:
    """Fold an angle between neighboring cranks to 0 ... 180 deg (240 and -120 become 120)."""
    rest = math.fmod(abs(gamma_deg), 360.0)
    return 360.0 - rest if rest > 180.0 else rest


def checked_angle_deg(gamma_deg: float) -> float:
    """Folded angle [deg]; `InputError` if it is not a finite number."""
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
    """G = E / (2 (1 + nu)) [Pa]; `InputError` if E is not positive, or nu not within -1 < nu <= 0.5."""
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


@dataclass(frozen=True)
class FormulaConstant:
    """One open constant of a published formula, its default, and the reason for it."""

    name: str
    formula: str
    default: float
    meaning: str
    reason: str


FORMULA_CONSTANTS: Mapping[str, FormulaConstant] = {
    constant.name: constant
    for constant in (
        FormulaConstant(
            "C",
            "Guglielmotti-Macchiotta",
            1.0,
            "correction for the angle between neighboring cranks",
            "no values are published; 1 is for opposite neighbors, gamma = 180 deg, where "
            "the formula's terms are those of a frame",
        ),
        FormulaConstant(
            "k_3",
            "Dorey",
            1.0,
            "factor of the crankpin's term for built and semi-built shafts",
            "no values are published; with 1 the formula is the exact frame at 180 deg",
        ),
        FormulaConstant(
            "k_or",
            "Skorchev",
            1.0,
            "factor for the angle between neighboring cranks",
            "no values are published; 1 is for opposite neighbors, gamma = 180 deg",
        ),
        FormulaConstant(
            "k_n",
            "Stoyanov",
            1.0,
            "factor of the webs' term for the overlap of main journal and crankpin",
            "no values are published; with 1 the term is the exact web without overlap",
        ),
        FormulaConstant(
            "k_gorbunov",
            "Gorbunov",
            0.8,
            "number in the angle factor k_phi = 0.8 (1 - cos gamma) of the web's term",
            "as printed; 0.5 would match the limit of a slender frame at 180 deg",
        ),
    )
}
DEFAULT_CONSTANTS: Mapping[str, float] = {
    name: constant.default for name, constant in FORMULA_CONSTANTS.items()
}


def checked_constants(constants: Mapping[str, float]) -> dict[str, float]:
    """All constants, the given ones replacing their defaults.

    `InputError` if one is unknown or not positive.
    """
    for key, value in constants.items():
        if key not in DEFAULT_CONSTANTS:
            raise InputError(
                f"constants: given {key!r}; allowed are {', '.join(DEFAULT_CONSTANTS)}, the open "
                "constants of the formulas."
            )
        if not (is_number(value) and value > 0.0):
            raise InputError(
                f"constant {key}: given {value!r}; allowed is a positive number, because the "
                "constant multiplies a compliance."
            )
    return {**DEFAULT_CONSTANTS, **constants}
