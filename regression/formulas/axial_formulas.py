r"""Published empirical formulas for the axial compliance e_n of one crank throw.

All are built from the beam compliances of the throw's parts, with E and G the moduli::

    pin     R^2 L_shm / (E I_shm)           crankpin in bending under the moment of a unit force
    web     R^3 / (E I_w)                   I_w = B h^3 / 12, the web bending out of its plane
    tension (L_km / F_km + L_shm / F_shm) / E
    shear   2 R / (G F_w)                   F_w = B h

A throw whose ends tilt freely (opposite neighbors, gamma = 180 deg) is statically determinate:
as a frame of slender beams its bending compliance is exactly ``pin + 2/3 web``. With the tilt
blocked (gamma = 0) and flexible webs it tends to ``1/2 pin + 1/6 web``. A correct formula tends to
the first, which reveals misprinted terms: variant "corrected" corrects what cannot
have been meant, variant "printed" follows the survey of Yamanin and Zhukov by the letter. The
corrections and their reasons are given with each formula in `regression.formulas`.

The formulas include neither fillets nor the shape of the web beyond B and h.

References
----------
A. I. Yamanin, V. A. Zhukov: On problem of calculating longitudinal vibrations of piston engine
crankshaft. Vestnik of Astrakhan State Technical University, Series: Marine Engineering and
Technologies, 2021, no. 4, pp. 75-83, doi 10.24143/2073-1574-2021-4-75-83. The survey names the
original authors given in each formula's source.
"""

import csv
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.quantity import percent
from crankbase.results import Internal, Quantity, Result, result
from crankbase.sentences import amount, angle
from fem.material import Material
from geometry.throw import CrankThrow
from regression.formulas.case import (
    AxialFormula,
    FormulaValue,
    OfThrow,
    Reading,
    Remark,
    Remarks,
    ThrowCase,
    checked_angle_deg,
    checked_constants,
    negative_shear_remarks,
    no_angle_remarks,
    open_angle_factor_remarks,
    plain_web_remarks,
    reading_value,
    throw_and_material,
    unused_bores_remarks,
)

# Anderson's formula.
#
# Printed: ``(R^2/E) [1.1 L_shm / I_shm k_phi + k_1^2 (k_phi - k_1/3) R / I_w]
# + (1/E) (L_km / F_km + L_shm / F_shm) + 2 [R - 0.5 (D_km + D_shm)] / (G I_w)`` with
# ``k_1 = 1 - (D_km + D_shm) / (0.125 R)`` and ``k_phi = 0.75 - 0.25 cos gamma``. The last term requires
# the web's area F_w = B h, as in Gorbunov's formula. The printed k_1 is about -17 for ordinary
# throws; ``1 - 0.125 (D_km + D_shm) / R`` is the share of the crank radius that bends. With k_1 = 1
# the web has 2/3 at gamma = 180 deg and 1/6 at 0, as a slender frame.


def _web_share(case: ThrowCase) -> float:
    """Return k_1, the share of the crank radius over which the web bends."""
    throw = case.throw
    diameters = throw.main_journal_diameter + throw.pin_diameter
    return 1.0 - 0.125 * diameters / throw.crank_radius


def _anderson_corrected(case: ThrowCase) -> float:
    k_phi = 0.75 - 0.25 * case.cosine
    k_1 = _web_share(case)
    bending = 1.1 * k_phi * case.pin + k_1**2 * (k_phi - k_1 / 3.0) * case.web
    return bending + case.tension + case.shear_of_length(-2.0 * case.throw.overlap)


def _anderson_remarks(case: ThrowCase) -> Remarks:
    yield from negative_shear_remarks(case)
    if _web_share(case) <= 0.0:
        yield Remark(
            f"The crank radius {amount(case.throw.crank_radius, 'm')} is at most an eighth of the "
            "sum of both journal diameters: nothing of the web is left to bend (k_1 <= 0).",
            invalidates=True,
        )


ANDERSON = AxialFormula(
    "Anderson",
    "And",
    "G. Anderson, in: Marine low-speed turbocharged engines, ed. N. N. Ivanchenko, Leningrad, 1967",
    {"corrected": Reading(_anderson_corrected, _anderson_remarks)},
    "its shear term 2 [R - 0.5 (D_km + D_shm)] / (G I_w) is in 1/(N m), not in m/N, because "
    "it divides by the web's inertia instead of its area B h",
)


# Dorey's formula, linear in the angle.
#
# Printed: ``(R^2/E) [k_3 L_shm / I_shm (0.5 + gamma/360) + (0.167 + gamma/360) R / I_w]``, gamma in
# deg from 0 to 180. No fault was found: both limits, gamma = 180 and 0 deg, are those of a slender
# frame with flexible webs, with 0.167 for 1/6. The factor k_3 for built shafts is not published.


_DOREY = Reading(
    lambda case: (
        case.constants["k_3"] * (0.5 + case.gamma_deg / 360.0) * case.pin
        + (0.167 + case.gamma_deg / 360.0) * case.web
    ),
    plain_web_remarks,
)

DOREY = AxialFormula(
    "Dorey",
    "Dor",
    "S. F. Dorey, I.S.P. Journal, 1939, no. 55, pp. 69-78",
    {"corrected": _DOREY, "printed": _DOREY},
)


# Draminsky's two formulas.
#
# (1), printed ``(1/E) (R^2 L_km / I_km + 2 R^3 / (3 I_w))``, is the bending of a slender frame at
# gamma = 180 deg, exactly, once its first term is the crankpin's.
#
# (2), printed ``(R^2/E) [(L_shm + 0.33 h) / I_shm (1 - k/12) + (R / I_w) (2/3 - k/2)]
# + (1/E) (L_km / F_km + L_shm / F_shm) + 2 R / (G I_w)`` with k = 1 + cos gamma. The last term is in
# 1/(N m): it requires the web's area F_w = B h. The denominators 12 and 2 are inconsistent: at
# gamma = 0 the web's factor would be -1/3, which is impossible, and with the tilt blocked a frame
# with flexible webs has 1/2 pin + 1/6 web, that is k/4 in both places ("k/4").

# Below this angle the web factor of the second formula falls towards zero and, from 70.5 deg down,
# below it.
SMALLEST_ANGLE_DEG = 75.0

_AUTHORS = "P. Draminsky, E. Warming, MTZ, 1942, no. 2, pp. 292-301"


def _draminsky_second_with(case: ThrowCase, pin_divisor: float, web_divisor: float) -> float:
    k = 1.0 + case.cosine
    pin = case.pin_of_length(case.throw.pin_length + 0.33 * case.throw.web_thickness)
    shear = case.shear_of_length(2.0 * case.throw.crank_radius)
    return (
        pin * (1.0 - k / pin_divisor)
        + case.web * (2.0 / 3.0 - k / web_divisor)
        + case.tension
        + shear
    )


def _draminsky_first_remarks(case: ThrowCase) -> Remarks:
    yield from plain_web_remarks(case)
    yield from no_angle_remarks(case)


def _draminsky_second_remarks(case: ThrowCase) -> Remarks:
    yield from plain_web_remarks(case)
    if case.gamma_deg < SMALLEST_ANGLE_DEG:
        yield Remark(
            f"gamma = {angle(case.gamma_deg)} is below {angle(SMALLEST_ANGLE_DEG)}: the factor 2/3 - (1 + "
            "cos gamma)/2 of the web falls to zero and below, which no throw does.",
            invalidates=True,
        )


DRAMINSKY_1 = AxialFormula(
    "Draminsky (1)",
    "D1",
    _AUTHORS,
    {
        "corrected": Reading(
            lambda case: case.pin + 2.0 / 3.0 * case.web, _draminsky_first_remarks
        ),
        # With length and inertia of the main journal, as its subscripts are printed.
        "printed": Reading(
            lambda case: case.bent_journal(case.throw.main_journal_bore) + 2.0 / 3.0 * case.web,
            lambda case: [
                *_draminsky_first_remarks(case),
                Remark(
                    "The print names the main journal in the first term, where the bent crankpin belongs."
                ),
            ],
        ),
    },
)
DRAMINSKY_2 = AxialFormula(
    "Draminsky (2)",
    "D2",
    _AUTHORS,
    {
        "corrected": Reading(
            lambda case: _draminsky_second_with(case, 12.0, 2.0), _draminsky_second_remarks
        ),
        "k/4": Reading(lambda case: _draminsky_second_with(case, 4.0, 4.0), plain_web_remarks),
    },
    "its shear term 2 R / (G I_w) is in 1/(N m), not in m/N, because it divides by the web's "
    "inertia instead of its area B h",
)


# The formula of the Central Research Institute of the Merchant Fleet (TsNIIMF): the web alone.
#
# Printed: ``8 R^3 / (E B h_e^3)`` with ``h_e = h sqrt((D_km + D_shm) / (2 h) - R / h)``, that is
# h_e = sqrt(s h) for an overlap s. The dimensions are right, but without overlap the root is
# undefined, and an overlap smaller than the web's thickness makes the web softer than none.
# "1 +" and a square were lost: ``h_e = sqrt(h^2 + s^2)``, which is the k_2 of Gorbunov's formula from
# the same institute, is the reading "corrected", with s = 0 where journal and pin do not overlap.
# The plain thickness, h_e = h, with which the survey's own table may have been calculated, is the reading
# "plain".

# 8 R^3 / (E B h^3) in terms of R^3 / (E I_w).
FRAME_WEB = 8.0 / 12.0


def overlapped_thickness(case: ThrowCase) -> float:
    """Return sqrt(h^2 + s^2), the web's thickness h where journal and pin do not overlap [m]."""
    return math.hypot(max(case.throw.overlap, 0.0), case.throw.web_thickness)


def _tsniimf_printed_fault(case: ThrowCase) -> str:
    throw = case.throw
    if throw.overlap > 0.0:
        return ""
    root = throw.overlap / throw.web_thickness
    return (
        "its root of (D_km + D_shm)/(2 h) - R/h is the root of "
        f"{root:.3g} where main journal and crankpin do not overlap"
    )


def _tsniimf_remarks(case: ThrowCase) -> Remarks:
    share = case.pin / (case.pin + FRAME_WEB * case.web)
    yield Remark(
        "The formula includes only the webs: the crankpin, "
        f"{percent(share, 2)} % of a slender frame of these dimensions, is left out."
    )
    yield from no_angle_remarks(case)
    yield from unused_bores_remarks(case)


def _tsniimf_printed_remarks(case: ThrowCase) -> Remarks:
    yield from _tsniimf_remarks(case)
    throw = case.throw
    if throw.overlap < throw.web_thickness:
        yield Remark(
            f"The overlap {case.overlap_text} is smaller than the web's "
            f"thickness {amount(throw.web_thickness, 'm')}: the print makes the web "
            f"{(throw.web_thickness / throw.overlap) ** 1.5:.3g} times softer than one without overlap.",
            invalidates=True,
        )


TSNIIMF = AxialFormula(
    "TsNIIMF",
    "TsN",
    "TsNIIMF: V. I. Zinchenko, Trudy TsNII morskogo flota, 1970, no. 125, pp. 80-103",
    {
        "corrected": Reading(
            lambda case: FRAME_WEB * case.web_of_thickness(overlapped_thickness(case)),
            _tsniimf_remarks,
        ),
        "printed": Reading(
            lambda case: (
                FRAME_WEB
                * case.web_of_thickness(math.sqrt(case.throw.overlap * case.throw.web_thickness))
            ),
            _tsniimf_printed_remarks,
            _tsniimf_printed_fault,
        ),
        "plain": Reading(
            lambda case: FRAME_WEB * case.web,
            lambda case: [*_tsniimf_remarks(case), *plain_web_remarks(case)],
        ),
    },
)


# The formula of Guglielmotti and Macchiotta, for slow-speed shafts with little or no overlap.
#
# Printed: ``C [64 R^2 L_km / (pi E D_km^4) + 42 R (R - 0.44 D_km)^2 / (E B h^3)]``. The dimensions
# are right, but for thin journals (D -> 0) the web's term must tend to that of a frame,
# 8 R^3 / (E B h^3), of which 42 is 5.25 times too much: it was probably "4 . 2 R" = 8 R. The first
# term is R^2 L / (E I) of the part loaded by the moment R of a unit force, which is the crankpin,
# not the main journal. The print does not show whose diameter shortens the web; the main
# journal's is used.

# The web's coefficient in terms of R^3 / (E I_w) = 12 R^3 / (E B h^3): that of a frame, 8, and 42.
CORRECTED_WEB, PRINTED_WEB = 8.0 / 12.0, 42.0 / 12.0


def _free_share(case: ThrowCase) -> float:
    """Return (R - 0.44 D_km) / R, the share of the crank radius over which the web bends."""
    throw = case.throw
    return 1.0 - 0.44 * throw.main_journal_diameter / throw.crank_radius


def _guglielmotti_remarks(case: ThrowCase) -> Remarks:
    yield from open_angle_factor_remarks(case, "C")
    share = _free_share(case)
    if share <= 0.0:
        yield Remark(
            f"The crank radius {amount(case.throw.crank_radius, 'm')} is at most 0.44 of the main "
            "journal's diameter: nothing of the web is left to bend (R - 0.44 D_km <= 0).",
            invalidates=True,
        )
    elif case.throw.overlap > 0.0:
        yield Remark(
            f"Main journal and crankpin overlap by {case.overlap_text}, and the formula is for slow-speed "
            f"shafts: it includes {percent(share**2, 2)} % of the plain web's bending."
        )


GUGLIELMOTTI_MACCHIOTTA = AxialFormula(
    "Guglielmotti-Macchiotta",
    "GM",
    "L. Guglielmotti, R. Macchiotta, in: Marine low-speed turbocharged engines, "
    "ed. N. N. Ivanchenko, Leningrad, 1967",
    {
        "corrected": Reading(
            lambda case: (
                case.constants["C"] * (case.pin + CORRECTED_WEB * _free_share(case) ** 2 * case.web)
            ),
            _guglielmotti_remarks,
        ),
        "printed": Reading(
            lambda case: (
                case.constants["C"]
                * (case.bent_journal(0.0) + PRINTED_WEB * _free_share(case) ** 2 * case.web)
            ),
            lambda case: [
                *_guglielmotti_remarks(case),
                *unused_bores_remarks(case),
                Remark(
                    "The print gives the web 42/8 of the compliance of a slender frame, and names the main "
                    "journal in the first term, where the bent crankpin belongs."
                ),
            ],
        ),
    },
)


# Skorchev's formula, for the crankshafts of large low-speed engines.
#
# Printed: ``k_or (R^2/E) [(0.175 R / D_shm + 0.285) R / I_w + L_shm / I_shm]``. No fault was found; the
# web has the 2/3 of a slender frame at R / D_shm = 2.18. The factor k_or for the angle between
# neighboring cranks is not published.


_SKORCHEV = Reading(
    lambda case: (
        case.constants["k_or"]
        * (
            (0.175 * case.throw.crank_radius / case.throw.pin_diameter + 0.285) * case.web
            + case.pin
        )
    ),
    lambda case: [*plain_web_remarks(case), *open_angle_factor_remarks(case, "k_or")],
)

SKORCHEV = AxialFormula(
    "Skorchev",
    "Sko",
    "N. S. Skorchev, thesis abstract, Leningrad, 1972",
    {"corrected": _SKORCHEV, "printed": _SKORCHEV},
)


# Stoyanov's formula, recommended for medium-speed engines.
#
# Printed: ``(1/E) [(L_shm + 0.48 h) R^2 / I_shm + (L_shm + 0.7 h) / F_shm + (L_km + 0.7 h) / F_km
# + 4.72 R k_n / (B c h) (1 + 1.7 R^2 / h^2)]`` with ``c = 3.97 - 3.64 b + 1.13 b^2`` and
# ``b = 2 B / (D_km + D_shm)``. No fault was found: 4.72 x 1.7 = 8.02, so that for c = 1 the web bends
# as that of a slender frame, 8 R^3 / (E B h^3); the rest of the last term is the web's shear. B c is
# the effective width. The factor k_n for the overlap is not published; the angle is not included.

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


def _stoyanov_as_printed(case: ThrowCase) -> float:
    throw = case.throw
    h, R = throw.web_thickness, throw.crank_radius
    section = throw.web_width * width_factor(relative_width(case)) * h
    webs = 4.72 * R * case.constants["k_n"] / section * (1.0 + 1.7 * R**2 / h**2)
    return (
        case.pin_of_length(throw.pin_length + 0.48 * h)
        + case.tension_of_lengths(throw.main_journal_length + 0.7 * h, throw.pin_length + 0.7 * h)
        + webs / case.youngs_modulus
    )


def _stoyanov_remarks(case: ThrowCase) -> Remarks:
    yield from no_angle_remarks(case)
    if case.throw.overlap > 0.0 and "k_n" not in case.given_constants:
        yield Remark(
            f"Main journal and crankpin overlap by {case.overlap_text}, for which the factor k_n is not "
            "published: the value applies without overlap (k_n = 1), unless the constant k_n is given.",
            invalidates=True,
        )
    b = relative_width(case)
    if not SMALLEST_WIDTH <= b <= LARGEST_WIDTH:
        yield Remark(
            f"The web's width is {b:.3g} of the mean journal diameter, outside {SMALLEST_WIDTH:g} to "
            f"{LARGEST_WIDTH:g}: the factor c = {width_factor(b):.3g} of the effective width is then far "
            "from the 1 of a slender frame.",
            invalidates=True,
        )


_STOYANOV = Reading(_stoyanov_as_printed, _stoyanov_remarks)

STOYANOV = AxialFormula(
    "Stoyanov",
    "Sto",
    "V. S. Stoyanov, thesis abstract, Leningrad, 1970",
    {"corrected": _STOYANOV, "printed": _STOYANOV},
)


# Gorbunov's formula.
#
# Printed: ``(4 / (pi E)) [2 pi R^3 k_phi / (B k_2) + 2 R L_1shm / D_shm^4 + L_1shm / D_shm^2
# + L_1km / D_km^2] + (2 R - D_km - D_shm) / (G B h)`` with ``k_2 = sqrt(s^2 + h^2)``,
# ``k_phi = 0.8 (1 - cos gamma)`` and ``L_1 = L + 0.2 h``. All terms in the bracket must be in 1/m:
# k_2^3 makes the first the web of a frame, 8 R^3 / (E B k_2^3), which confirms the coefficient 2 pi, and
# 16 R^2 L_1 / D^4 makes the second the pin's R^2 L_1 / (E I); exponents were lost in both. The number
# 0.8 would have to be 0.5 for the web of a frame at 180 deg; it is left as printed (`k_gorbunov`).


def _gorbunov_angle_factor(case: ThrowCase) -> float:
    return case.constants["k_gorbunov"] * (1.0 - case.cosine)


def _gorbunov_corrected(case: ThrowCase) -> float:
    throw = case.throw
    pin_length = throw.pin_length + 0.2 * throw.web_thickness
    journal_length = throw.main_journal_length + 0.2 * throw.web_thickness
    return (
        FRAME_WEB * case.web_of_thickness(overlapped_thickness(case)) * _gorbunov_angle_factor(case)
        + case.pin_of_length(pin_length)
        + case.tension_of_lengths(journal_length, pin_length)
        + case.shear_of_length(-2.0 * throw.overlap)
    )


def _gorbunov_remarks(case: ThrowCase) -> Remarks:
    yield from negative_shear_remarks(case)
    number = case.constants["k_gorbunov"]
    factor = _gorbunov_angle_factor(case)
    # A frame with blocked tilt has 1/6 of R^3 / (E I_w), a quarter of the web's term at k_phi = 1.
    if factor < 0.25:
        yield Remark(
            f"At gamma = {angle(case.gamma_deg)} the angle factor of the web is {factor:.3g}: "
            "the web is then stiffer than even a frame with blocked tilt has it.",
            invalidates=True,
        )
    elif 2.0 * number > 1.0 + 1e-12:
        yield Remark(
            f"The angle factor k_phi = {number:g} (1 - cos gamma) gives the web {2.0 * number:g} times the "
            "compliance of a slender frame at 180 deg; the constant k_gorbunov = 0.5 matches the frame."
        )


GORBUNOV = AxialFormula(
    "Gorbunov",
    "Gor",
    "Yu. S. Barshai, E. Ya. Gorbunov, Trudy TsNII morskogo flota, 1975, no. 192, pp. 70-79",
    {"corrected": Reading(_gorbunov_corrected, _gorbunov_remarks)},
    "its web term 2 pi R^3 / (B k_2) is in m, its pin term 2 R L_1 / D^4 in 1/m^2 and the "
    "others in 1/m, which cannot be added (k_2^3 and 16 R^2 L_1 / D^4 would fit)",
)


AXIAL_FORMULAS: Mapping[str, AxialFormula] = {
    formula.name: formula
    for formula in (
        GUGLIELMOTTI_MACCHIOTTA,
        DRAMINSKY_1,
        DRAMINSKY_2,
        TSNIIMF,
        ANDERSON,
        GORBUNOV,
        DOREY,
        SKORCHEV,
        STOYANOV,
    )
}
AXIAL_FORMULA_NAMES: tuple[str, ...] = tuple(AXIAL_FORMULAS)
AXIAL_VARIANTS: tuple[str, ...] = ("corrected", "printed", "plain", "k/4")


FINITE_ELEMENTS = "finite elements"
# The value by finite elements that the paper gives for one engine is doubted in words of its own.
FINITE_ELEMENTS_DOUBT = (
    "The survey's value by finite elements for ChN 26/26, 3.3220e-9 m/N, is unexplained: it is at least "
    "twice what any formula gives in its row, and four to eight times what finite elements give for throws "
    "of that size between opposite neighbors. A tenth of it, were a power of ten lost, would be 0.4 to 0.8 "
    "times these. The survey gives neither dimensions nor supports of the throw. It is no validation target."
)


@result("engine", "formula", "printed", "repaired", eq=True)
class PublishedValue(Result):
    """One value of the survey's table.

    Attributes
    ----------
    engine : str
        Designation: cylinder bore / stroke [cm]; from it bore and stroke [m].
    formula : str
        As in `AXIAL_FORMULA_NAMES`, or "finite elements".
    digits : str
        Of the print.
    exponent_factor : float or None
        Power of ten to apply to the print, a hypothesis; 1 where none seems necessary, None if unknown.
    group : str
        "A" or "B": formulas whose values agree with one web thickness; empty for neither.
    """

    engine: str
    strokes: Internal[int]
    bore: Internal[float]
    stroke: Internal[float]
    formula: str
    digits: Internal[str]
    exponent_factor: Annotated[float | None, Quantity("1")]
    group: str
    doubt: str

    @property
    def printed(self) -> Annotated[float, Quantity(".unit")]:
        """The value as printed [m/N]."""
        return float(self.digits) * 1e-9

    @property
    def repaired(self) -> Annotated[float | None, Quantity(".unit")]:
        """The printed value times its hypothetical power of ten [m/N]; None where there is none."""
        return None if self.exponent_factor is None else self.printed * self.exponent_factor

    @property
    def mark(self) -> str:
        """Return "*" if the power of ten was repaired, "?" if it is doubted only, or ""."""
        if self.exponent_factor not in (None, 1.0):
            return "*"
        return "?" if self.doubt else ""


def read_published_table(path: Path) -> tuple[PublishedValue, ...]:
    """Read the survey's table, ``axial_compliance_published.csv``, in the order of the print."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return tuple(
        PublishedValue(
            engine=row["engine"],
            strokes=int(row["strokes"]),
            bore=float(row["bore_mm"]) / 1e3,
            stroke=float(row["stroke_mm"]) / 1e3,
            formula=row["formula"],
            digits=row["printed_1e-9_m_per_N"],
            exponent_factor=float(row["exponent_factor"]) if row["exponent_factor"] else None,
            group=row["group"],
            doubt=row["doubt"],
        )
        for row in csv.DictReader(line for line in lines if line and not line.startswith("#"))
    )


def axial_formulas(
    throw: CrankThrow | OfThrow,
    gamma_deg: float = 180.0,
    *,
    material: Material | None = None,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> dict[str, FormulaValue]:
    """Axial compliance of a throw by every published formula that can be evaluated.

    Parameters
    ----------
    throw : CrankThrow or ThrowAnalysis
        The throw's dimensions [m], or an analysis of it, of which the material is used too. Fillets are
        not used.
    gamma_deg : float, optional
        Angle between neighboring cranks, gamma_k [deg]; folded to 0 ... 180, so 240 counts as 120.
    material : Material, optional
        Of the throw; `STEEL` by default.
    variant : {"corrected", "printed", "plain", "k/4"}, optional
        The reading. A formula that lacks the reading, or whose print cannot be evaluated,
        is left out. "plain" is an alternative of TsNIIMF alone (the web's thickness h without
        overlap), "k/4" one of Draminsky (2) alone.
    constants : mapping, optional
        Values for the formulas' open constants, described in `FORMULA_CONSTANTS`: "C"
        (Guglielmotti-Macchiotta, 1), "k_3" (Dorey, 1), "k_or" (Skorchev, 1), "k_n" (Stoyanov, 1)
        and "k_gorbunov" (Gorbunov, 0.8).

    Returns
    -------
    dict of str to FormulaValue
        Formula name to its value [m/N], with validity and remarks. Every formula has a finite
        corrected value for every throw; its `valid` states whether it applies.

    Raises
    ------
    InputError
        If the angle, the material, the variant or a constant cannot be used.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.285, web_thickness=0.068,
    ... )
    >>> round(axial_formulas(throw)["Draminsky (1)"].value * 1e9, 4)
    2.4598
    """
    case = _case(throw, gamma_deg, material, constants, variant)
    return {
        name: _evaluate(formula, variant, case)
        for name, formula in AXIAL_FORMULAS.items()
        if variant in formula.readings and not formula.readings[variant].fault(case)
    }


def axial_formula(
    name: str,
    throw: CrankThrow | OfThrow,
    gamma_deg: float = 180.0,
    *,
    material: Material | None = None,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> FormulaValue:
    """Axial compliance of a throw by one published formula.

    Parameters
    ----------
    name : str
        One of `AXIAL_FORMULA_NAMES`.
    throw, gamma_deg, material, variant, constants
        As in `axial_formulas`.

    Returns
    -------
    FormulaValue
        The value [m/N], with validity and remarks.

    Raises
    ------
    InputError
        As in `axial_formulas`; for an unknown name; for a reading that the formula lacks
        or that cannot be evaluated for this throw, including a print that is dimensionally
        inconsistent.
    """
    check_choice("formula", name, AXIAL_FORMULAS, "these are the published axial formulas")
    case = _case(throw, gamma_deg, material, constants, variant)
    formula = AXIAL_FORMULAS[name]
    fault = _fault(name, formula, variant, case)
    if fault:
        others = " or ".join(
            repr(other)
            for other, reading in formula.readings.items()
            if other != variant and not reading.fault(case)
        )
        raise InputError(f"variant: given {variant!r}; allowed is {others}, because {fault}.")
    return _evaluate(formula, variant, case)


def axial_formula_faults(throw: CrankThrow, variant: str) -> dict[str, str]:
    """Why `axial_formulas` leaves formulas out, at any angle, by name in half a sentence each.

    Arguments and errors as there.
    """
    case = _case(throw, 180.0, None, None, variant)
    faults = {
        name: _fault(name, formula, variant, case) for name, formula in AXIAL_FORMULAS.items()
    }
    return {name: fault for name, fault in faults.items() if fault}


def _fault(name: str, formula: AxialFormula, variant: str, case: ThrowCase) -> str:
    """Return why a formula has no value in this reading; empty if it has one."""
    if variant in formula.readings:
        fault = formula.readings[variant].fault(case)
        return f"the {variant} formula {name} cannot be evaluated, {fault}" if fault else ""
    if variant == "printed":
        return f"the printed formula {name} cannot be evaluated, {formula.printed_fault}"
    return f"{name} has no such reading"


def _case(
    throw: CrankThrow | OfThrow,
    gamma_deg: float,
    material: Material | None,
    constants: Mapping[str, float] | None,
    variant: str,
) -> ThrowCase:
    """Return what all formulas take, checked with the reading that is asked for."""
    check_choice("variant", variant, AXIAL_VARIANTS, "these are the readings of the formulas")
    chosen = dict(constants or {})
    crank, used = throw_and_material(throw, material)
    return ThrowCase(
        crank,
        checked_angle_deg(gamma_deg),
        used.youngs_modulus,
        used.shear_modulus,
        checked_constants(chosen),
        frozenset(chosen),
    )


def _evaluate(formula: AxialFormula, variant: str, case: ThrowCase) -> FormulaValue:
    return reading_value(formula.readings[variant], case, formula.source, "m/N", variant)
