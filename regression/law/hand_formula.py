r"""A formula for the axial compliance by hand: the beams of a throw, and 12 numbers.

With all lengths in main journal diameters D, overlap s = (1 + D_p) / 2 - R, fillets r::

    e E D = R^2 (L_p + 0.45 h - 1.36 r) 64 / (pi D_p^4)                                      pin, bent
          + 39.3 R e^(-1.74 r) / (h^2.16 B^0.5 D_p^0.45) (1 + e^(1.5 s / (h^0.57 B^0.14)))^-2.4    webs
          + 1.16 (L_m + L_p / D_p^2) 4 / pi                                                   tension

The pin is a beam, 0.45 h longer for the bending in the webs, and shorter for its fillets. As
beams two webs would give 8 R^3 / (B h^3): without overlap, s well below 0, the middle term grows less
steeply with R and h, since webs are short and wide; with overlap, force passes directly from main journal to
pin, and the term falls exponentially with s over a length between h and D. The last term is the
tension of journals and pin, 16 % more for the webs between them.
"""

from typing import Any

import numpy as np

from geometry.throw import CrankThrow
from regression.formulas.case import FormulaValue, check_youngs_modulus
from regression.law.ratios import FILLETS, REAL, Ratios, is_plain, ratios, throw_dimensions

SOURCE = "crankfem: beams fitted to finite-element answers of plain filleted throws (docs/law.md)"


def hand_parts(shape: Ratios) -> tuple[Any, Any, Any]:
    """Parts of e E D for ratios of one or more throws: the pin's bending, the webs, and tension."""
    radius, pin, journal_length, pin_length, width, thickness = (shape[name] for name in REAL)
    fillet = 0.5 * (shape[FILLETS[0]] + shape[FILLETS[1]])
    overlap = 0.5 * (1.0 + pin) - radius
    bent = radius**2 * (pin_length + 0.45 * thickness - 1.36 * fillet) * 64.0 / (np.pi * pin**4)
    webs = 39.3 * radius * np.exp(-1.74 * fillet) / (thickness**2.16 * width**0.5 * pin**0.45)
    webs = webs * (1.0 + np.exp(1.5 * overlap / (thickness**0.57 * width**0.14))) ** -2.4
    return bent, webs, 1.16 * (journal_length + pin_length / pin**2) * 4.0 / np.pi


def hand_value(shape: Ratios) -> Any:
    """Value e E D of the formula for ratios of one or more throws."""
    bent, webs, tension = hand_parts(shape)
    return bent + webs + tension


def hand_formula(throw: CrankThrow, *, youngs_modulus: float = 2.1e11) -> FormulaValue:
    """Axial compliance of a plain throw, ends pinned, by a formula for hand calculation.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa].

    Returns
    -------
    FormulaValue
        The value [m/N]; valid for plain throws within the law's range.

    Raises
    ------
    InputError
        If the throw has features outside any single-web formula, or E is not a positive number.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> round(hand_formula(throw).value * 1e9, 2)
    1.27
    """
    check_youngs_modulus(youngs_modulus)
    shape = ratios(throw_dimensions(throw))
    valid = bool(is_plain(shape))
    remarks = () if valid else (
        "The throw is not a plain one within the range that the formula was fitted to (docs/law.md).",
    )  # fmt: skip
    value = float(hand_value(shape)) / (youngs_modulus * throw.main_journal_diameter)
    return FormulaValue(value, valid, remarks, SOURCE, "m/N", "corrected")
