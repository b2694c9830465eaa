"""Draminsky's two formulas.

(1), printed ``(1/E) (R^2 L_km / I_km + 2 R^3 / (3 I_w))``, is the bending of a slender frame at
gamma = 180 deg, exactly, once its first term is the crankpin's.

(2), printed ``(R^2/E) [(L_shm + 0.33 h) / I_shm (1 - k/12) + (R / I_w) (2/3 - k/2)]
+ (1/E) (L_km / F_km + L_shm / F_shm) + 2 R / (G I_w)`` with k = 1 + cos gamma. The last term is in
1/(N m): it requires the web's area F_w = B h. The denominators 12 and 2 are inconsistent: at
gamma = 0 the web's factor would be -1/3, which is impossible, and with the tilt blocked a frame
with flexible webs has 1/2 pin + 1/6 web, that is k/4 in both places ("k/4").
"""

from regression.formulas.case import ThrowCase, round_inertia
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import Remark, no_angle_remarks, plain_web_remarks

# Below this angle the web factor of the second formula falls towards zero and, from 70.5 deg down,
# below it.
SMALLEST_ANGLE_DEG = 75.0

_AUTHORS = "P. Draminsky, E. Warming, MTZ, 1942, no. 2, pp. 292-301"


def _first(case: ThrowCase) -> float:
    return case.pin + 2.0 / 3.0 * case.web


def _first_printed(case: ThrowCase) -> float:
    """Return (1) with length and inertia of the main journal, as its subscripts are printed."""
    throw = case.throw
    inertia = round_inertia(throw.main_journal_diameter, throw.main_journal_bore)
    journal = throw.crank_radius**2 * throw.main_journal_length / (case.youngs_modulus * inertia)
    return journal + 2.0 / 3.0 * case.web


def _second_with(case: ThrowCase, pin_divisor: float, web_divisor: float) -> float:
    k = 1.0 + case.cosine
    pin = case.pin_of_length(case.throw.pin_length + 0.33 * case.throw.web_thickness)
    shear = case.shear_of_length(2.0 * case.throw.crank_radius)
    return (
        pin * (1.0 - k / pin_divisor)
        + case.web * (2.0 / 3.0 - k / web_divisor)
        + case.tension
        + shear
    )


def _second(case: ThrowCase) -> float:
    return _second_with(case, 12.0, 2.0)


def _second_quarter(case: ThrowCase) -> float:
    return _second_with(case, 4.0, 4.0)


def _first_remarks(case: ThrowCase) -> list[Remark]:
    return [*plain_web_remarks(case), *no_angle_remarks(case)]


def _first_printed_remarks(case: ThrowCase) -> list[Remark]:
    misprint = Remark(
        "The print names the main journal in the first term, where the bent crankpin belongs."
    )
    return [*_first_remarks(case), misprint]


def _second_remarks(case: ThrowCase) -> list[Remark]:
    remarks = plain_web_remarks(case)
    if case.gamma_deg < SMALLEST_ANGLE_DEG:
        remarks.append(
            Remark(
                f"gamma = {case.gamma_deg:g} deg is below {SMALLEST_ANGLE_DEG:g} deg: the "
                "factor 2/3 - (1 + cos gamma)/2 of the web falls to zero and below, which no "
                "throw does.",
                invalidates=True,
            )
        )
    return remarks


DRAMINSKY_1 = AxialFormula(
    "Draminsky (1)",
    "D1",
    _AUTHORS,
    {
        "corrected": Reading(_first, _first_remarks),
        "printed": Reading(_first_printed, _first_printed_remarks),
    },
)
DRAMINSKY_2 = AxialFormula(
    "Draminsky (2)",
    "D2",
    _AUTHORS,
    {
        "corrected": Reading(_second, _second_remarks),
        "k/4": Reading(_second_quarter, plain_web_remarks),
    },
    "its shear term 2 R / (G I_w) is in 1/(N m), not in m/N, because it divides by the web's "
    "inertia instead of its area B h",
)
