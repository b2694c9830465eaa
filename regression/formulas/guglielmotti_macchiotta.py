"""The formula of Guglielmotti and Macchiotta, for slow-speed shafts with little or no overlap.

Printed: ``C [64 R^2 L_km / (pi E D_km^4) + 42 R (R - 0.44 D_km)^2 / (E B h^3)]``. The dimensions
are right, but for thin journals (D -> 0) the web's term must tend to that of a frame,
8 R^3 / (E B h^3), of which 42 is 5.25 times too much: it was probably "4 . 2 R" = 8 R. The first
term is R^2 L / (E I) of the part loaded by the moment R of a unit force, which is the crankpin,
not the main journal. The print does not show whose diameter shortens the web; the main
journal's is used.
"""

from crankbase.units.quantity import format_quantity
from regression.formulas.case import ThrowCase, round_inertia
from regression.formulas.reading import AxialFormula, Reading
from regression.formulas.remarks import Remark, open_angle_factor_remarks, unused_bores_remarks

# The web's coefficient in terms of R^3 / (E I_w) = 12 R^3 / (E B h^3): that of a frame, 8, and 42.
CORRECTED_WEB, PRINTED_WEB = 8.0 / 12.0, 42.0 / 12.0


def _free_share(case: ThrowCase) -> float:
    """Return (R - 0.44 D_km) / R, the share of the crank radius over which the web bends."""
    throw = case.throw
    return 1.0 - 0.44 * throw.main_journal_diameter / throw.crank_radius


def _corrected(case: ThrowCase) -> float:
    web = CORRECTED_WEB * _free_share(case) ** 2 * case.web
    return case.constants["C"] * (case.pin + web)


def _printed(case: ThrowCase) -> float:
    throw = case.throw
    inertia = round_inertia(throw.main_journal_diameter, 0.0)
    journal = throw.crank_radius**2 * throw.main_journal_length / (case.youngs_modulus * inertia)
    web = PRINTED_WEB * _free_share(case) ** 2 * case.web
    return case.constants["C"] * (journal + web)


def _remarks(case: ThrowCase) -> list[Remark]:
    remarks = open_angle_factor_remarks(case, "C")
    share = _free_share(case)
    if share <= 0.0:
        remarks.append(
            Remark(
                f"The crank radius {format_quantity(case.throw.crank_radius, 'm')} is at most 0.44 "
                "of the main journal's diameter: nothing of the web is left to bend "
                "(R - 0.44 D_km <= 0).",
                invalidates=True,
            )
        )
    elif case.throw.overlap > 0.0:
        remarks.append(
            Remark(
                f"Main journal and crankpin overlap by {format_quantity(case.throw.overlap, 'm')}, and the "
                f"formula is for slow-speed shafts: it includes {100.0 * share**2:.2g} % of the plain web's "
                "bending."
            )
        )
    return remarks


def _printed_remarks(case: ThrowCase) -> list[Remark]:
    return [
        *_remarks(case),
        *unused_bores_remarks(case),
        Remark(
            "The print gives the web 42/8 of the compliance of a slender frame, and names the main "
            "journal in the first term, where the bent crankpin belongs."
        ),
    ]


GUGLIELMOTTI_MACCHIOTTA = AxialFormula(
    "Guglielmotti-Macchiotta",
    "GM",
    "L. Guglielmotti, R. Macchiotta, in: Marine low-speed turbocharged engines, "
    "ed. N. N. Ivanchenko, Leningrad, 1967",
    {"corrected": Reading(_corrected, _remarks), "printed": Reading(_printed, _printed_remarks)},
)
