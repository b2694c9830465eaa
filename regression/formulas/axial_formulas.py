r"""Published empirical formulas for the axial compliance e_n of one crank throw.

All are built from the beam compliances of the throw's parts, with E and G the moduli::

    pin     R^2 L_shm / (E I_shm)           crankpin in bending under the moment of a unit force
    web     R^3 / (E I_w)                   I_w = B h^3 / 12, the web bending out of its plane
    tension (L_km / F_km + L_shm / F_shm) / E
    shear   2 R / (G F_w)                   F_w = B h

A throw whose ends tilt freely (opposite neighbors, gamma = 180 deg) is statically determinate:
as a frame of slender beams its bending compliance is exactly ``pin + 2/3 web``. With the tilt
blocked (gamma = 0) and flexible webs it tends to ``1/2 pin + 1/6 web``. A correct formula tends to
the first, which reveals misprinted terms: variant "corrected" corrects what cannot
have been meant, variant "printed" follows the survey of Yamanin and Zhukov by the letter. The
corrections and their reasons are given with each formula in `regression.formulas`.

The formulas include neither fillets nor the shape of the web beyond B and h.

References
----------
A. I. Yamanin, V. A. Zhukov: On problem of calculating longitudinal vibrations of piston engine
crankshaft. Vestnik of Astrakhan State Technical University, Series: Marine Engineering and
Technologies, 2021, no. 4, pp. 75-83, doi 10.24143/2073-1574-2021-4-75-83. The survey names the
original authors given in each formula's source.
"""

from collections.abc import Mapping

from crankbase.errors import InputError
from fem.material import Material
from geometry.throw import CrankThrow
from regression.formulas.case import (
    AxialFormula,
    FormulaValue,
    OfThrow,
    ThrowCase,
    checked_angle_deg,
    checked_constants,
    reading_value,
    throw_and_material,
)
from regression.formulas.published import AXIAL_FORMULA_NAMES, AXIAL_FORMULAS, AXIAL_VARIANTS


def axial_formulas(
    throw: CrankThrow | OfThrow,
    gamma_deg: float = 180.0,
    *,
    material: Material | None = None,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> dict[str, FormulaValue]:
    """Axial compliance of a throw by every published formula that can be evaluated.

    Parameters
    ----------
    throw : CrankThrow or ThrowAnalysis
        The throw's dimensions [m], or an analysis of it, of which the material is used too. Fillets are
        not used.
    gamma_deg : float, optional
        Angle between neighboring cranks, gamma_k [deg]; folded to 0 ... 180, so 240 counts as 120.
    material : Material, optional
        Of the throw; `STEEL` by default.
    variant : {"corrected", "printed", "plain", "k/4"}, optional
        The reading. A formula that lacks the reading, or whose print cannot be evaluated,
        is left out. "plain" is an alternative of TsNIIMF alone (the web's thickness h without
        overlap), "k/4" one of Draminsky (2) alone.
    constants : mapping, optional
        Values for the formulas' open constants, described in `FORMULA_CONSTANTS`: "C"
        (Guglielmotti-Macchiotta, 1), "k_3" (Dorey, 1), "k_or" (Skorchev, 1), "k_n" (Stoyanov, 1)
        and "k_gorbunov" (Gorbunov, 0.8).

    Returns
    -------
    dict of str to FormulaValue
        Formula name to its value [m/N], with validity and remarks. Every formula has a finite
        corrected value for every throw; its `valid` states whether it applies.

    Raises
    ------
    InputError
        If the angle, the material, the variant or a constant cannot be used.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.285, web_thickness=0.068,
    ... )
    >>> round(axial_formulas(throw)["Draminsky (1)"].value * 1e9, 4)
    2.4598
    """
    case = _case(throw, gamma_deg, material, constants)
    _check_variant(variant)
    return {
        name: _evaluate(formula, variant, case)
        for name, formula in AXIAL_FORMULAS.items()
        if variant in formula.readings and not formula.readings[variant].fault(case)
    }


def axial_formula(
    name: str,
    throw: CrankThrow | OfThrow,
    gamma_deg: float = 180.0,
    *,
    material: Material | None = None,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> FormulaValue:
    """Axial compliance of a throw by one published formula.

    Parameters
    ----------
    name : str
        One of `AXIAL_FORMULA_NAMES`.
    throw, gamma_deg, material, variant, constants
        As in `axial_formulas`.

    Returns
    -------
    FormulaValue
        The value [m/N], with validity and remarks.

    Raises
    ------
    InputError
        As in `axial_formulas`; for an unknown name; for a reading that the formula lacks
        or that cannot be evaluated for this throw, including a print that is dimensionally
        inconsistent.
    """
    if name not in AXIAL_FORMULAS:
        raise InputError(
            f"formula: given {name!r}; allowed are {', '.join(AXIAL_FORMULA_NAMES)}, the "
            "published axial formulas that are known here."
        )
    case = _case(throw, gamma_deg, material, constants)
    _check_variant(variant)
    formula = AXIAL_FORMULAS[name]
    fault = _fault(name, formula, variant, case)
    if fault:
        others = " or ".join(
            repr(other)
            for other, reading in formula.readings.items()
            if other != variant and not reading.fault(case)
        )
        raise InputError(f"variant: given {variant!r}; allowed is {others}, because {fault}.")
    return _evaluate(formula, variant, case)


def axial_formula_faults(
    throw: CrankThrow, variant: str, gamma_deg: float = 180.0
) -> dict[str, str]:
    """Why `axial_formulas` leaves formulas out, by name in half a sentence each.

    Arguments and errors as there.
    """
    case = _case(throw, gamma_deg, None, None)
    _check_variant(variant)
    faults = {
        name: _fault(name, formula, variant, case) for name, formula in AXIAL_FORMULAS.items()
    }
    return {name: fault for name, fault in faults.items() if fault}


def _fault(name: str, formula: AxialFormula, variant: str, case: ThrowCase) -> str:
    """Return why a formula has no value in this reading; empty if it has one."""
    if variant in formula.readings:
        fault = formula.readings[variant].fault(case)
        return f"the {variant} formula {name} cannot be evaluated, {fault}" if fault else ""
    if variant == "printed":
        return f"the printed formula {name} cannot be evaluated, {formula.printed_fault}"
    return f"{name} has no such reading"


def _case(
    throw: CrankThrow | OfThrow,
    gamma_deg: float,
    material: Material | None,
    constants: Mapping[str, float] | None,
) -> ThrowCase:
    chosen = dict(constants or {})
    crank, used = throw_and_material(throw, material)
    return ThrowCase(
        crank,
        checked_angle_deg(gamma_deg),
        used.youngs_modulus,
        used.shear_modulus,
        checked_constants(chosen),
        frozenset(chosen),
    )


def _check_variant(variant: str) -> None:
    if variant not in AXIAL_VARIANTS:
        raise InputError(
            f"variant: given {variant!r}; allowed are {', '.join(AXIAL_VARIANTS)}, the readings "
            "of the published formulas."
        )


def _evaluate(formula: AxialFormula, variant: str, case: ThrowCase) -> FormulaValue:
    return reading_value(formula.readings[variant], case, formula.source, "m/N", variant)
