r"""Textbook formulas for the torsional compliance of one crank throw.

Each gives the twist between the middles of two main journals under a unit torque [rad/(N m)],
for a throw whose ends are free to tilt and shift. With shear modulus G and polar inertia
pi (D^4 - d^4) / 32 of a journal with a bore d, a length l twists by 32 l / (pi G (D^4 - d^4)).

The formulas are quoted from the general literature on torsional vibration, where many texts give
them in the same form; the first publications were not consulted.

References
----------
W. Ker Wilson: Practical Solution of Torsional Vibration Problems, London, Chapman and Hall.
S. Timoshenko: Vibration Problems in Engineering, New York, Van Nostrand.
"""

import math
from collections.abc import Mapping

from crankbase.sentences import amount
from fem.material import Material
from geometry.throw import CrankThrow
from regression.formulas.case import (
    FormulaValue,
    OfThrow,
    Reading,
    Remark,
    Remarks,
    ThrowCase,
    reading_value,
    round_inertia,
    throw_and_material,
)

_TEXTBOOK = (
    "textbook formula quoted from the general literature on torsional vibration, first "
    "publication not consulted"
)


def _journals(case: ThrowCase, journal_length: float, pin_length: float) -> float:
    """Return the twist of a journal and a pin of these lengths under a unit torque [rad/(N m)]."""
    throw = case.throw
    journal = round_inertia(throw.main_journal_diameter, throw.main_journal_bore)
    pin = round_inertia(throw.pin_diameter, throw.pin_bore)
    modulus = 2.0 * case.shear_modulus
    return journal_length / (modulus * journal) + pin_length / (modulus * pin)


def _web(case: ThrowCase, length: float) -> float:
    """Return the twist from a web of this effective length, 32 / (pi G) length / (h B^3)."""
    throw = case.throw
    bent = length / (throw.web_thickness * throw.web_width**3)
    return 32.0 / (math.pi * case.shear_modulus) * bent


def _carter(case: ThrowCase) -> float:
    """32 / (pi G) [(L_km + 0.8 h)/D_km^4 + 0.75 L_shm/D_shm^4 + 1.5 R/(h B^3)]."""
    throw = case.throw
    journal = throw.main_journal_length + 0.8 * throw.web_thickness
    return _journals(case, journal, 0.75 * throw.pin_length) + _web(case, 1.5 * throw.crank_radius)


def _ker_wilson_web_length(throw: CrankThrow) -> float:
    return throw.crank_radius - 0.2 * (throw.main_journal_diameter + throw.pin_diameter)


def _ker_wilson(case: ThrowCase) -> float:
    """Add 0.4 D to both journals and shorten the web to R - 0.2 (D_km + D_shm)."""
    throw = case.throw
    journal = throw.main_journal_length + 0.4 * throw.main_journal_diameter
    pin = throw.pin_length + 0.4 * throw.pin_diameter
    return _journals(case, journal, pin) + _web(case, _ker_wilson_web_length(throw))


def _ker_wilson_remarks(case: ThrowCase) -> Remarks:
    yield Remark("Meant for stiff webs between flexible journals and pin.")
    if _ker_wilson_web_length(case.throw) <= 0.0:
        yield Remark(
            f"The crank radius {amount(case.throw.crank_radius, 'm')} is at most a fifth "
            "of the sum of both journal diameters: nothing of the web is left to twist.",
            invalidates=True,
        )


def _with_web_beams(case: ThrowCase, share: float) -> float:
    """Add a share of h to both journals; the webs bend as beams of section h B."""
    throw, added = case.throw, share * case.throw.web_thickness
    inertia = throw.web_thickness * throw.web_width**3 / 12.0
    webs = 2.0 * throw.crank_radius / (case.youngs_modulus * inertia)
    return _journals(case, throw.main_journal_length + added, throw.pin_length + added) + webs


def _zimanenko_with(case: ThrowCase, diameter: float) -> float:
    """32 / (pi G) [(L_km + 0.6 h D_km/L_km)/D_km^4 + (0.8 L_shm + 0.2 B D/R)/D_shm^4 + web].

    The web's share is R sqrt(R / D_shm) / (h B^3); D is the diameter whose index is in doubt.
    """
    throw = case.throw
    R, h, B = throw.crank_radius, throw.web_thickness, throw.web_width
    journal = throw.main_journal_length + (
        0.6 * h * throw.main_journal_diameter / throw.main_journal_length
    )
    pin = 0.8 * throw.pin_length + 0.2 * B * diameter / R
    return _journals(case, journal, pin) + _web(case, R * math.sqrt(R / throw.pin_diameter))


def _zimanenko_remarks(case: ThrowCase) -> Remarks:
    yield Remark("Gives up to a quarter more than finite elements for ordinary throws.")
    if case.throw.pin_diameter != case.throw.main_journal_diameter:
        other = _zimanenko_with(case, case.throw.pin_diameter)
        yield Remark(
            "Reprints differ in the diameter of the term with 0.2 B/R: here it is the main "
            f"journal's; with the crankpin's the value is {amount(other, 'rad/(N m)', 4)}."
        )


# Each formula with who published it.
_FORMULAS: Mapping[str, tuple[Reading, str]] = {
    "Carter": (
        Reading(
            _carter, lambda _: [Remark("Meant for flexible webs between stiff journals and pin.")]
        ),
        "B. C. Carter",
    ),
    "Ker Wilson": (
        Reading(_ker_wilson, _ker_wilson_remarks),
        "W. Ker Wilson, Practical Solution of Torsional Vibration Problems",
    ),
    "Geiger": (
        Reading(
            lambda case: _with_web_beams(case, 0.4),
            lambda _: [Remark("The webs are treated as slender beams of length R.")],
        ),
        "J. Geiger",
    ),
    "Timoshenko (free)": (
        Reading(
            lambda case: _with_web_beams(case, 0.9),
            lambda _: [
                Remark(
                    "For journals free to shift in their bearings; the webs are treated as slender beams."
                )
            ],
        ),
        "S. Timoshenko, Vibration Problems in Engineering",
    ),
    "Zimanenko": (
        Reading(
            lambda case: _zimanenko_with(case, case.throw.main_journal_diameter), _zimanenko_remarks
        ),
        "Zimanenko",
    ),
}

TORSIONAL_FORMULA_NAMES: tuple[str, ...] = tuple(_FORMULAS)


def torsional_formulas(
    throw: CrankThrow | OfThrow, *, material: Material | None = None
) -> dict[str, FormulaValue]:
    """Torsional compliance of a throw by textbook formulas.

    Parameters
    ----------
    throw, material
        As in `axial_formulas`.

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
    crank, used = throw_and_material(throw, material)
    case = ThrowCase(crank, 180.0, used.youngs_modulus, used.shear_modulus, {}, frozenset())
    return {
        name: reading_value(reading, case, f"{source}; {_TEXTBOOK}", "rad/(N m)", "textbook")
        for name, (reading, source) in _FORMULAS.items()
    }
