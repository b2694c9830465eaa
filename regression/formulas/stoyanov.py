"""Stoyanov's formula, recommended for medium-speed engines.

Printed: ``(1/E) [(L_shm + 0.48 h) R^2 / I_shm + (L_shm + 0.7 h) / F_shm + (L_km + 0.7 h) / F_km
+ 4.72 R k_n / (B c h) (1 + 1.7 R^2 / h^2)]`` with ``c = 3.97 - 3.64 b + 1.13 b^2`` and
``b = 2 B / (D_km + D_shm)``. No fault was found: 4.72 x 1.7 = 8.02, so that for c = 1 the web bends
as that of a slender frame, 8 R^3 / (E B h^3); the rest of the last term is the web's shear. B c is
the effective width. The factor k_n for the overlap is not published; the angle is not included.
"""

from crankbase.units.quantity import format_quantity
from regression.formulas.case import ThrowCase
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import Remark, no_angle_remarks

# The parabola c(b) has its minimum, 1.04, at b = 1.61; a slender frame has c = 1. Between these widths
# c is at most 1.15. The survey gives no range, but farther out the parabola makes any web stiff, a
# narrow one too: by 1.46 at b = 1, by 3.2 at b = 3.
SMALLEST_WIDTH, LARGEST_WIDTH = 1.30, 1.92


def relative_width(case: ThrowCase) -> float:
    """Return b, the web's width over the mean diameter of main journal and crankpin."""
    throw = case.throw
    return 2.0 * throw.web_width / (throw.main_journal_diameter + throw.pin_diameter)


def width_factor(b: float) -> float:
    """Return c, the effective width of the web over its width B."""
    return 3.97 - 3.64 * b + 1.13 * b**2


def _as_printed(case: ThrowCase) -> float:
    throw = case.throw
    h, R = throw.web_thickness, throw.crank_radius
    section = throw.web_width * width_factor(relative_width(case)) * h
    webs = 4.72 * R * case.constants["k_n"] / section * (1.0 + 1.7 * R**2 / h**2)
    return (
        case.pin_of_length(throw.pin_length + 0.48 * h)
        + case.tension_of_lengths(throw.main_journal_length + 0.7 * h, throw.pin_length + 0.7 * h)
        + webs / case.youngs_modulus
    )


def _remarks(case: ThrowCase) -> list[Remark]:
    remarks = no_angle_remarks(case)
    overlap = case.throw.overlap
    if overlap > 0.0 and "k_n" not in case.given_constants:
        remarks.append(
            Remark(
                f"Main journal and crankpin overlap by {format_quantity(overlap, 'm')}, for which the "
                "factor k_n is not published: the value applies without overlap (k_n = 1), unless "
                "the constant k_n is given.",
                invalidates=True,
            )
        )
    b = relative_width(case)
    if not SMALLEST_WIDTH <= b <= LARGEST_WIDTH:
        remarks.append(
            Remark(
                f"The web's width is {b:.3g} of the mean journal diameter, outside "
                f"{SMALLEST_WIDTH:g} to {LARGEST_WIDTH:g}: the factor c = {width_factor(b):.3g} of "
                "the effective width is then far from the 1 of a slender frame.",
                invalidates=True,
            )
        )
    return remarks


_READING = Reading(_as_printed, _remarks)

STOYANOV = AxialFormula(
    "Stoyanov",
    "Sto",
    "V. S. Stoyanov, thesis abstract, Leningrad, 1970",
    {"corrected": _READING, "printed": _READING},
)
