"""Anderson's formula.

Printed: ``(R^2/E) [1.1 L_shm / I_shm k_phi + k_1^2 (k_phi - k_1/3) R / I_w]
+ (1/E) (L_km / F_km + L_shm / F_shm) + 2 [R - 0.5 (D_km + D_shm)] / (G I_w)`` with
``k_1 = 1 - (D_km + D_shm) / (0.125 R)`` and ``k_phi = 0.75 - 0.25 cos gamma``. The last term requires
the web's area F_w = B h, as in Gorbunov's formula. The printed k_1 is about -17 for ordinary
throws; ``1 - 0.125 (D_km + D_shm) / R`` is the share of the crank radius that bends. With k_1 = 1
the web has 2/3 at gamma = 180 deg and 1/6 at 0, as a slender frame.
"""

from crankbase.units.quantity import format_quantity
from regression.formulas.case import ThrowCase
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import Remark, negative_shear_remarks


def _web_share(case: ThrowCase) -> float:
    """Return k_1, the share of the crank radius over which the web bends."""
    throw = case.throw
    diameters = throw.main_journal_diameter + throw.pin_diameter
    return 1.0 - 0.125 * diameters / throw.crank_radius


def _corrected(case: ThrowCase) -> float:
    k_phi = 0.75 - 0.25 * case.cosine
    k_1 = _web_share(case)
    bending = 1.1 * k_phi * case.pin + k_1**2 * (k_phi - k_1 / 3.0) * case.web
    return bending + case.tension + case.shear_of_length(-2.0 * case.throw.overlap)


def _remarks(case: ThrowCase) -> list[Remark]:
    remarks = negative_shear_remarks(case)
    if _web_share(case) <= 0.0:
        remarks.append(
            Remark(
                "The crank radius "
                f"{format_quantity(case.throw.crank_radius, 'm')} is at most an eighth of the sum of "
                "both journal diameters: nothing of the web is left to bend (k_1 <= 0).",
                invalidates=True,
            )
        )
    return remarks


ANDERSON = AxialFormula(
    "Anderson",
    "And",
    "G. Anderson, in: Marine low-speed turbocharged engines, ed. N. N. Ivanchenko, Leningrad, 1967",
    {"corrected": Reading(_corrected, _remarks)},
    "its shear term 2 [R - 0.5 (D_km + D_shm)] / (G I_w) is in 1/(N m), not in m/N, because "
    "it divides by the web's inertia instead of its area B h",
)
