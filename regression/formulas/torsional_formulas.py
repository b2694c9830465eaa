r"""Textbook formulas for the torsional compliance of one crank throw.

Each gives the twist between the middles of two main journals under a unit torque [rad/(N m)],
for a throw whose ends are free to tilt and shift. With shear modulus G and polar inertia
pi (D^4 - d^4) / 32 of a journal with a bore d, a length l twists by 32 l / (pi G (D^4 - d^4)).

The formulas are quoted from the general literature on torsional vibration, where they stand in
many places in the same form; the first publications were not consulted.

References
----------
W. Ker Wilson: Practical Solution of Torsional Vibration Problems, London, Chapman and Hall.
S. Timoshenko: Vibration Problems in Engineering, New York, Van Nostrand.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from crankbase.units.quantity import format_quantity
from geometry.throw import CrankThrow
from regression.formulas.arguments import shear_modulus
from regression.formulas.case import round_inertia
from regression.formulas.formula_value import FormulaValue
from regression.formulas.remarks import shape_remarks

_TEXTBOOK = (
    "textbook formula quoted from the general literature on torsional vibration, first "
    "publication not consulted"
)


def _round(length: float, diameter: float, bore: float, modulus: float) -> float:
    """Return the twist of a round length with a bore under a unit torque [rad/(N m)]."""
    return length / (modulus * 2.0 * round_inertia(diameter, bore))


def _webs_as_beams(throw: CrankThrow, youngs_modulus: float) -> float:
    """Return the twist from both webs bending in their plane, 2 R / (E h B^3 / 12)."""
    inertia = throw.web_thickness * throw.web_width**3 / 12.0
    return 2.0 * throw.crank_radius / (youngs_modulus * inertia)


def _carter(throw: CrankThrow, youngs_modulus: float, modulus: float) -> float:
    """32 / (pi G) [(L_km + 0.8 h)/D_km^4 + 0.75 L_shm/D_shm^4 + 1.5 R/(h B^3)]."""
    del youngs_modulus
    web = 1.5 * throw.crank_radius / (throw.web_thickness * throw.web_width**3)
    return (
        _round(
            throw.main_journal_length + 0.8 * throw.web_thickness,
            throw.main_journal_diameter,
            throw.main_journal_bore,
            modulus,
        )
        + _round(0.75 * throw.pin_length, throw.pin_diameter, throw.pin_bore, modulus)
        + 32.0 / (math.pi * modulus) * web
    )


def _ker_wilson_web_length(throw: CrankThrow) -> float:
    return throw.crank_radius - 0.2 * (throw.main_journal_diameter + throw.pin_diameter)


def _ker_wilson(throw: CrankThrow, youngs_modulus: float, modulus: float) -> float:
    """Add 0.4 D to both journals and shorten the web to R - 0.2 (D_km + D_shm)."""
    del youngs_modulus
    web = _ker_wilson_web_length(throw) / (throw.web_thickness * throw.web_width**3)
    return (
        _round(
            throw.main_journal_length + 0.4 * throw.main_journal_diameter,
            throw.main_journal_diameter,
            throw.main_journal_bore,
            modulus,
        )
        + _round(
            throw.pin_length + 0.4 * throw.pin_diameter, throw.pin_diameter, throw.pin_bore, modulus
        )
        + 32.0 / (math.pi * modulus) * web
    )


def _geiger(throw: CrankThrow, youngs_modulus: float, modulus: float) -> float:
    """Add 0.4 h to both journals; the webs bend as beams of section h B."""
    return _with_web_beams(throw, youngs_modulus, modulus, 0.4)


def _timoshenko_free(throw: CrankThrow, youngs_modulus: float, modulus: float) -> float:
    """Add 0.9 h to both journals; the webs bend as beams of section h B."""
    return _with_web_beams(throw, youngs_modulus, modulus, 0.9)


def _zimanenko(throw: CrankThrow, youngs_modulus: float, modulus: float) -> float:
    """Zimanenko's formula with the main journal's diameter beside 0.2 B / R."""
    return _zimanenko_with(throw, youngs_modulus, modulus, throw.main_journal_diameter)


def _zimanenko_with(
    throw: CrankThrow, youngs_modulus: float, modulus: float, diameter: float
) -> float:
    """32 / (pi G) [(L_km + 0.6 h D_km/L_km)/D_km^4 + (0.8 L_shm + 0.2 B D/R)/D_shm^4 + web].

    The web's share is R sqrt(R / D_shm) / (h B^3); D is the diameter whose index is in doubt.
    """
    del youngs_modulus
    R, h, B = throw.crank_radius, throw.web_thickness, throw.web_width
    journal = throw.main_journal_length + (
        0.6 * h * throw.main_journal_diameter / throw.main_journal_length
    )
    web = R * math.sqrt(R / throw.pin_diameter) / (h * B**3)
    return (
        _round(journal, throw.main_journal_diameter, throw.main_journal_bore, modulus)
        + _round(
            0.8 * throw.pin_length + 0.2 * B * diameter / R,
            throw.pin_diameter,
            throw.pin_bore,
            modulus,
        )
        + 32.0 / (math.pi * modulus) * web
    )


def _with_web_beams(
    throw: CrankThrow, youngs_modulus: float, modulus: float, share: float
) -> float:
    added = share * throw.web_thickness
    return (
        _round(
            throw.main_journal_length + added,
            throw.main_journal_diameter,
            throw.main_journal_bore,
            modulus,
        )
        + _round(throw.pin_length + added, throw.pin_diameter, throw.pin_bore, modulus)
        + _webs_as_beams(throw, youngs_modulus)
    )


@dataclass(frozen=True)
class _TorsionalFormula:
    source: str
    evaluate: Callable[[CrankThrow, float, float], float]
    remark: str


_FORMULAS: Mapping[str, _TorsionalFormula] = {
    "Carter": _TorsionalFormula(
        f"B. C. Carter; {_TEXTBOOK}",
        _carter,
        "Meant for flexible webs between stiff journals and pin.",
    ),
    "Ker Wilson": _TorsionalFormula(
        f"W. Ker Wilson, Practical Solution of Torsional Vibration Problems; {_TEXTBOOK}",
        _ker_wilson,
        "Meant for stiff webs between flexible journals and pin.",
    ),
    "Geiger": _TorsionalFormula(
        f"J. Geiger; {_TEXTBOOK}", _geiger, "The webs count as slender beams of length R."
    ),
    "Timoshenko (free)": _TorsionalFormula(
        f"S. Timoshenko, Vibration Problems in Engineering; {_TEXTBOOK}",
        _timoshenko_free,
        "For journals free to shift in their bearings; the webs count as slender beams.",
    ),
    "Zimanenko": _TorsionalFormula(
        f"Zimanenko; {_TEXTBOOK}",
        _zimanenko,
        "Gives up to a quarter more than finite elements for ordinary throws.",
    ),
}

TORSIONAL_FORMULA_NAMES: tuple[str, ...] = tuple(_FORMULAS)


def torsional_formulas(
    throw: CrankThrow,
    *,
    youngs_modulus: float = 2.1e11,
    poisson_ratio: float = 0.3,
) -> dict[str, FormulaValue]:
    """Torsional compliance of a throw by textbook formulas.

    Parameters
    ----------
    throw : CrankThrow
        The throw's dimensions [m]. Fillets do not enter.
    youngs_modulus : float, optional
        E [Pa].
    poisson_ratio : float, optional
        For the shear modulus G = E / (2 (1 + nu)).

    Returns
    -------
    dict of str to FormulaValue
        Formula name to its value [rad/(N m)], with validity and remarks.

    Raises
    ------
    InputError
        If the material cannot be used.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.285, web_thickness=0.068,
    ... )
    >>> round(torsional_formulas(throw)["Carter"].value * 1e8, 3)
    4.234
    """
    modulus = shear_modulus(youngs_modulus, poisson_ratio)
    return {
        name: _value(name, formula, throw, youngs_modulus, modulus)
        for name, formula in _FORMULAS.items()
    }


def _value(
    name: str,
    formula: _TorsionalFormula,
    throw: CrankThrow,
    youngs_modulus: float,
    modulus: float,
) -> FormulaValue:
    remarks = [formula.remark]
    valid = True
    if name == "Ker Wilson" and _ker_wilson_web_length(throw) <= 0.0:
        valid = False
        remarks.append(
            f"The crank radius {format_quantity(throw.crank_radius, 'm')} is at most a fifth of the "
            "sum of both journal diameters: nothing of the web is left to twist."
        )
    if name == "Zimanenko" and throw.pin_diameter != throw.main_journal_diameter:
        other = _zimanenko_with(throw, youngs_modulus, modulus, throw.pin_diameter)
        remarks.append(
            "Reprints differ in the diameter that stands beside 0.2 B/R: here it is the main "
            f"journal's; with the crankpin's the value is {other * 1e9:.4g}e-9 rad/(N m)."
        )
    for text, invalidates in shape_remarks(throw):
        remarks.append(text)
        valid = valid and not invalidates
    return FormulaValue(
        value=formula.evaluate(throw, youngs_modulus, modulus),
        valid=valid,
        remarks=tuple(remarks),
        source=formula.source,
        unit="rad/(N m)",
        variant="textbook",
    )
