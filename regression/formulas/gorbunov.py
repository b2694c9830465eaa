"""Gorbunov's formula.

Printed: ``(4 / (pi E)) [2 pi R^3 k_phi / (B k_2) + 2 R L_1shm / D_shm^4 + L_1shm / D_shm^2
+ L_1km / D_km^2] + (2 R - D_km - D_shm) / (G B h)`` with ``k_2 = sqrt(s^2 + h^2)``,
``k_phi = 0.8 (1 - cos gamma)`` and ``L_1 = L + 0.2 h``. All terms in the bracket must be in 1/m:
k_2^3 makes the first the web of a frame, 8 R^3 / (E B k_2^3), which confirms the coefficient 2 pi, and
16 R^2 L_1 / D^4 makes the second the pin's R^2 L_1 / (E I); exponents were lost in both. The number
0.8 would have to be 0.5 for the web of a frame at 180 deg; it is left as printed (`k_gorbunov`).
"""

from regression.formulas.case import ThrowCase
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import Remark, negative_shear_remarks
from regression.formulas.tsniimf import FRAME_WEB, overlapped_thickness


def _angle_factor(case: ThrowCase) -> float:
    return case.constants["k_gorbunov"] * (1.0 - case.cosine)


def _corrected(case: ThrowCase) -> float:
    throw = case.throw
    pin_length = throw.pin_length + 0.2 * throw.web_thickness
    journal_length = throw.main_journal_length + 0.2 * throw.web_thickness
    return (
        FRAME_WEB * case.web_of_thickness(overlapped_thickness(case)) * _angle_factor(case)
        + case.pin_of_length(pin_length)
        + case.tension_of_lengths(journal_length, pin_length)
        + case.shear_of_length(-2.0 * throw.overlap)
    )


def _remarks(case: ThrowCase) -> list[Remark]:
    remarks = negative_shear_remarks(case)
    number = case.constants["k_gorbunov"]
    factor = _angle_factor(case)
    # A frame with blocked tilt has 1/6 of R^3 / (E I_w), a quarter of the web's term at k_phi = 1.
    if factor < 0.25:
        remarks.append(
            Remark(
                f"At gamma = {case.gamma_deg:g} deg the angle factor of the web is {factor:.3g}: "
                "the web is then stiffer than even a frame with blocked tilt has it.",
                invalidates=True,
            )
        )
    elif 2.0 * number > 1.0 + 1e-12:
        remarks.append(
            Remark(
                f"The angle factor k_phi = {number:g} (1 - cos gamma) gives the web "
                f"{2.0 * number:g} times the compliance of a slender frame at 180 deg; "
                "the constant k_gorbunov = 0.5 matches the frame."
            )
        )
    return remarks


GORBUNOV = AxialFormula(
    "Gorbunov",
    "Gor",
    "Yu. S. Barshai, E. Ya. Gorbunov, Trudy TsNII morskogo flota, 1975, no. 192, pp. 70-79",
    {"corrected": Reading(_corrected, _remarks)},
    "its web term 2 pi R^3 / (B k_2) is in m, its pin term 2 R L_1 / D^4 in 1/m^2 and the "
    "others in 1/m, which cannot be added (k_2^3 and 16 R^2 L_1 / D^4 would fit)",
)
