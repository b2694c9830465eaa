"""The formula of the Central Research Institute of the Merchant Fleet (TsNIIMF): the web alone.

Printed: ``8 R^3 / (E B h_e^3)`` with ``h_e = h sqrt((D_km + D_shm) / (2 h) - R / h)``, that is
h_e = sqrt(s h) for an overlap s. The dimensions are right, but without overlap the root is
undefined, and an overlap smaller than the web's thickness makes the web softer than none.
"1 +" and a square were lost: ``h_e = sqrt(h^2 + s^2)``, which is the k_2 of Gorbunov's formula from
the same institute, is the reading "corrected", with s = 0 where journal and pin do not overlap.
The plain thickness, h_e = h, with which the survey's own table may have been calculated, is the reading
"plain".
"""

import math

from crankbase.units.quantity import format_quantity
from regression.formulas.case import ThrowCase
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import (
    Remark,
    no_angle_remarks,
    plain_web_remarks,
    unused_bores_remarks,
)

# 8 R^3 / (E B h^3) in terms of R^3 / (E I_w).
FRAME_WEB = 8.0 / 12.0


def overlapped_thickness(case: ThrowCase) -> float:
    """Return sqrt(h^2 + s^2), the web's thickness h where journal and pin do not overlap [m]."""
    return math.hypot(max(case.throw.overlap, 0.0), case.throw.web_thickness)


def _corrected(case: ThrowCase) -> float:
    return FRAME_WEB * case.web_of_thickness(overlapped_thickness(case))


def _plain(case: ThrowCase) -> float:
    return FRAME_WEB * case.web


def _printed(case: ThrowCase) -> float:
    return FRAME_WEB * case.web_of_thickness(
        math.sqrt(case.throw.overlap * case.throw.web_thickness)
    )


def _printed_fault(case: ThrowCase) -> str:
    throw = case.throw
    if throw.overlap > 0.0:
        return ""
    root = throw.overlap / throw.web_thickness
    return (
        "its root of (D_km + D_shm)/(2 h) - R/h is the root of "
        f"{root:.3g} where main journal and crankpin do not overlap"
    )


def _remarks(case: ThrowCase) -> list[Remark]:
    share = case.pin / (case.pin + FRAME_WEB * case.web)
    web_only = Remark(
        "The formula includes only the webs: the crankpin, "
        f"{100.0 * share:.2g} % of a slender frame of these dimensions, is left out."
    )
    return [web_only, *no_angle_remarks(case), *unused_bores_remarks(case)]


def _plain_remarks(case: ThrowCase) -> list[Remark]:
    return [*_remarks(case), *plain_web_remarks(case)]


def _printed_remarks(case: ThrowCase) -> list[Remark]:
    remarks = _remarks(case)
    throw = case.throw
    if throw.overlap < throw.web_thickness:
        remarks.append(
            Remark(
                f"The overlap {format_quantity(throw.overlap, 'm')} is smaller than the web's "
                f"thickness {format_quantity(throw.web_thickness, 'm')}: the print makes the web "
                f"{(throw.web_thickness / throw.overlap) ** 1.5:.3g} times softer than one "
                "without overlap.",
                invalidates=True,
            )
        )
    return remarks


TSNIIMF = AxialFormula(
    "TsNIIMF",
    "TsN",
    "TsNIIMF: V. I. Zinchenko, Trudy TsNII morskogo flota, 1970, no. 125, pp. 80-103",
    {
        "corrected": Reading(_corrected, _remarks),
        "printed": Reading(_printed, _printed_remarks, _printed_fault),
        "plain": Reading(_plain, _plain_remarks),
    },
)
