"""Dorey's formula, linear in the angle.

Printed: ``(R^2/E) [k_3 L_shm / I_shm (0.5 + gamma/360) + (0.167 + gamma/360) R / I_w]``, gamma in
deg from 0 to 180. No fault was found: both limits, gamma = 180 and 0 deg, are those of a slender
frame with flexible webs, with 0.167 for 1/6. The factor k_3 for built shafts is not published.
"""

from regression.formulas.case import ThrowCase
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import plain_web_remarks


def _as_printed(case: ThrowCase) -> float:
    pin, web = 0.5 + case.gamma_deg / 360.0, 0.167 + case.gamma_deg / 360.0
    return case.constants["k_3"] * pin * case.pin + web * case.web


_READING = Reading(_as_printed, plain_web_remarks)

DOREY = AxialFormula(
    "Dorey",
    "Dor",
    "S. F. Dorey, I.S.P. Journal, 1939, no. 55, pp. 69-78",
    {"corrected": _READING, "printed": _READING},
)
