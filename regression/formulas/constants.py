"""Constants that the survey leaves open, or whose print is doubtful, with documented defaults."""

from collections.abc import Mapping
from dataclasses import dataclass

from crankbase.checks.scalars import is_number
from crankbase.errors import InputError


@dataclass(frozen=True)
class FormulaConstant:
    """One open constant of a published formula.

    Attributes
    ----------
    name : str
        Its name in `constants`.
    formula : str
        The formula that contains it.
    default : float
        The default.
    meaning : str
        Its meaning.
    reason : str
        Reason for the default.
    """

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


def checked_constants(given: Mapping[str, float]) -> dict[str, float]:
    """Return all constants, the given ones replacing their defaults.

    Raises
    ------
    InputError
        If a name is unknown, or a value is not a positive number.
    """
    for key, value in given.items():
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
    return {**DEFAULT_CONSTANTS, **given}
