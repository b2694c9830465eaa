"""Skorchev's formula, for the crankshafts of large low-speed engines.

Printed: ``k_or (R^2/E) [(0.175 R / D_shm + 0.285) R / I_w + L_shm / I_shm]``. No fault was found; the
web has the 2/3 of a slender frame at R / D_shm = 2.18. The factor k_or for the angle between
neighboring cranks is not published.
"""

from regression.formulas.case import ThrowCase
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import Remark, open_angle_factor_remarks, plain_web_remarks


def _as_printed(case: ThrowCase) -> float:
    factor = 0.175 * case.throw.crank_radius / case.throw.pin_diameter + 0.285
    return case.constants["k_or"] * (factor * case.web + case.pin)


def _remarks(case: ThrowCase) -> list[Remark]:
    return [*plain_web_remarks(case), *open_angle_factor_remarks(case, "k_or")]


_READING = Reading(_as_printed, _remarks)

SKORCHEV = AxialFormula(
    "Skorchev",
    "Sko",
    "N. S. Skorchev, thesis abstract, Leningrad, 1972",
    {"corrected": _READING, "printed": _READING},
)
