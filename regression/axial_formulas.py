r"""Published empirical formulas for the axial compliance e_n of one crank throw.

All of them are built from the beam compliances of the throw's parts, with E and G the moduli::

    pin     R^2 L_shm / (E I_shm)           crankpin in bending under the moment of a unit force
    web     R^3 / (E I_w)                   I_w = B h^3 / 12, the web bending out of its plane
    tension (L_km / F_km + L_shm / F_shm) / E
    shear   2 R / (G F_w)                   F_w = B h

A throw whose ends tilt freely (opposite neighbors, gamma = 180 deg) is statically determinate:
as a frame of slender beams its bending compliance is exactly ``pin + 2/3 web``. With the tilt
blocked (gamma = 0) and flexible webs it tends to ``1/2 pin + 1/6 web``. A sound formula tends to
the first, and this is how misprinted terms were recognized: variant "corrected" mends what cannot
have been meant, variant "printed" takes the survey of Yamanin and Zhukov by the letter.

The formulas know neither fillets nor the shape of the web beyond B and h.

References
----------
A. I. Yamanin, V. A. Zhukov: On problem of calculating longitudinal vibrations of piston engine
crankshaft. Vestnik of Astrakhan State Technical University, Series: Marine Engineering and
Technologies, 2021, no. 4, pp. 75-83, doi 10.24143/2073-1574-2021-4-75-83. The survey names the
original authors given in each formula's source.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from geometry.errors import InputError
from geometry.quantity import show_quantity
from geometry.throw import CrankThrow
from regression.formula_value import FormulaValue

# Constants that the survey leaves open, or whose print is doubtful, with the values taken if none
# is given. k_3: Dorey's factor for built and semi-built shafts. k_or: Skorchev's factor for the
# angle of the neighboring cranks. k_gorbunov: the number in Gorbunov's k_phi = 0.8 (1 - cos gamma);
# 0.5 would meet the limit of a slender frame at gamma = 180 deg.
DEFAULT_CONSTANTS: Mapping[str, float] = MappingProxyType(
    {"k_3": 1.0, "k_or": 1.0, "k_gorbunov": 0.8}
)

# Below this angle the web factor of Draminsky's second formula falls towards zero and, from
# 70.5 deg down, below it.
SMALLEST_ANGLE_DRAMINSKY_2_DEG = 75.0

_SURVEY = (
    "A. I. Yamanin, V. A. Zhukov, Vestnik AGTU, Ser. Marine Engineering and Technologies, 2021, "
    "no. 4, pp. 75-83, doi 10.24143/2073-1574-2021-4-75-83"
)


@dataclass(frozen=True)
class _Case:
    """One throw with its material, the angle of its neighbors (0 to 180 deg) and the constants."""

    throw: CrankThrow
    gamma_deg: float
    youngs_modulus: float
    shear_modulus: float
    constants: Mapping[str, float]
    given_constants: frozenset[str]

    @property
    def cosine(self) -> float:
        return math.cos(math.radians(self.gamma_deg))

    @property
    def pin(self) -> float:
        """Bending of the crankpin, R^2 L_shm / (E I_shm) [m/N]."""
        return self.pin_of_length(self.throw.pin_length)

    def pin_of_length(self, length: float) -> float:
        inertia = round_inertia(self.throw.pin_diameter, self.throw.pin_bore)
        return self.throw.crank_radius**2 * length / (self.youngs_modulus * inertia)

    @property
    def web(self) -> float:
        """Bending of the web, R^3 / (E I_w) [m/N]."""
        return self.web_of_thickness(self.throw.web_thickness)

    def web_of_thickness(self, thickness: float) -> float:
        inertia = self.throw.web_width * thickness**3 / 12.0
        return self.throw.crank_radius**3 / (self.youngs_modulus * inertia)

    def tension_of_lengths(self, journal_length: float, pin_length: float) -> float:
        """Stretch of journal and pin, (L_km / F_km + L_shm / F_shm) / E [m/N]."""
        throw = self.throw
        journal = journal_length / round_area(throw.main_journal_diameter, throw.main_journal_bore)
        pin = pin_length / round_area(throw.pin_diameter, throw.pin_bore)
        return (journal + pin) / self.youngs_modulus

    @property
    def tension(self) -> float:
        return self.tension_of_lengths(self.throw.main_journal_length, self.throw.pin_length)

    def shear_of_length(self, length: float) -> float:
        """Shear of a web of this length on the full section, length / (G B h) [m/N]."""
        return length / (self.shear_modulus * self.throw.web_width * self.throw.web_thickness)


@dataclass(frozen=True)
class _Remark:
    text: str
    invalidates: bool = False


def round_inertia(diameter: float, bore: float) -> float:
    """Second moment of area of a round section with a concentric bore [m^4]."""
    return math.pi / 64.0 * (diameter**4 - bore**4)


def round_area(diameter: float, bore: float) -> float:
    """Area of a round section with a bore [m^2]."""
    return math.pi / 4.0 * (diameter**2 - bore**2)


# ------------------------------------------------------------------------------- the formulas


def _draminsky_1(case: _Case) -> float:
    """Return ``pin + 2/3 web``: the slender frame at gamma = 180 deg [m/N]."""
    return case.pin + 2.0 / 3.0 * case.web


def _draminsky_1_printed(case: _Case) -> float:
    """Return (1) with length and inertia of the main journal, as its subscripts are printed."""
    throw = case.throw
    inertia = round_inertia(throw.main_journal_diameter, throw.main_journal_bore)
    journal = throw.crank_radius**2 * throw.main_journal_length / (case.youngs_modulus * inertia)
    return journal + 2.0 / 3.0 * case.web


def _draminsky_2_with(case: _Case, pin_divisor: float, web_divisor: float) -> float:
    k = 1.0 + case.cosine
    pin = case.pin_of_length(case.throw.pin_length + 0.33 * case.throw.web_thickness)
    shear = case.shear_of_length(2.0 * case.throw.crank_radius)
    return (
        pin * (1.0 - k / pin_divisor)
        + case.web * (2.0 / 3.0 - k / web_divisor)
        + case.tension
        + shear
    )


def _draminsky_2(case: _Case) -> float:
    """Return (2) with the web's area F_w, not its inertia, in the shear term [m/N]."""
    return _draminsky_2_with(case, 12.0, 2.0)


def _draminsky_2_quarter(case: _Case) -> float:
    """Return (2) with k/4 in both factors, which meets the limit of a frame at gamma = 0."""
    return _draminsky_2_with(case, 4.0, 4.0)


def _dorey(case: _Case) -> float:
    """Return Dorey's formula, linear in the angle [m/N]."""
    share = case.gamma_deg / 360.0
    return case.constants["k_3"] * case.pin * (0.5 + share) + (0.167 + share) * case.web


def _skorchev(case: _Case) -> float:
    """Return Skorchev's formula for the crankshafts of large low-speed engines [m/N]."""
    factor = 0.175 * case.throw.crank_radius / case.throw.pin_diameter + 0.285
    return case.constants["k_or"] * (factor * case.web + case.pin)


def _anderson_web_share(throw: CrankThrow) -> float:
    """Return k_1, the share of the crank radius over which the web bends."""
    diameters = throw.main_journal_diameter + throw.pin_diameter
    return 1.0 - 0.125 * diameters / throw.crank_radius


def _anderson(case: _Case) -> float:
    """Return Anderson's formula with k_1 = 1 - 0.125 (D_km + D_shm) / R and F_w in shear."""
    throw = case.throw
    k_phi = 0.75 - 0.25 * case.cosine
    k_1 = _anderson_web_share(throw)
    bending = 1.1 * k_phi * case.pin + k_1**2 * (k_phi - k_1 / 3.0) * case.web
    return bending + case.tension + case.shear_of_length(-2.0 * throw.overlap)


def _gorbunov_angle_factor(case: _Case) -> float:
    return case.constants["k_gorbunov"] * (1.0 - case.cosine)


def _gorbunov(case: _Case) -> float:
    """Return Gorbunov's formula with k_2^3 in the web term and 16 R^2 L / D^4 in the pin term."""
    throw = case.throw
    k_2 = math.hypot(max(throw.overlap, 0.0), throw.web_thickness)
    pin_length = throw.pin_length + 0.2 * throw.web_thickness
    journal_length = throw.main_journal_length + 0.2 * throw.web_thickness
    return (
        2.0 / 3.0 * case.web_of_thickness(k_2) * _gorbunov_angle_factor(case)
        + case.pin_of_length(pin_length)
        + case.tension_of_lengths(journal_length, pin_length)
        + case.shear_of_length(-2.0 * throw.overlap)
    )


# ---------------------------------------------------------------------------- when they hold


def _plain_web_remark(case: _Case) -> list[_Remark]:
    overlap = case.throw.overlap
    if overlap <= 0.0:
        return []
    return [
        _Remark(
            f"Main journal and crankpin overlap by {show_quantity(overlap, 'm')}: a formula with "
            "the plain web section overestimates the compliance, up to about threefold beside "
            "finite elements."
        )
    ]


def _negative_shear_remark(case: _Case) -> list[_Remark]:
    overlap = case.throw.overlap
    if overlap <= 0.0:
        return []
    return [
        _Remark(
            f"Main journal and crankpin overlap by {show_quantity(overlap, 'm')}: the formula's "
            "shear term is negative there."
        )
    ]


def _check_draminsky_1(case: _Case) -> list[_Remark]:
    remarks = _plain_web_remark(case)
    if case.gamma_deg < 180.0:
        remarks.append(
            _Remark(
                "The formula has no angle: it holds for opposite neighbors, gamma = 180 deg, and "
                f"not for {case.gamma_deg:g} deg, where the throw is stiffer.",
                invalidates=True,
            )
        )
    return remarks


def _check_draminsky_1_printed(case: _Case) -> list[_Remark]:
    misprint = _Remark(
        "The print names the main journal in the first term, where the bent crankpin belongs."
    )
    return [*_check_draminsky_1(case), misprint]


def _check_draminsky_2(case: _Case) -> list[_Remark]:
    remarks = _plain_web_remark(case)
    if case.gamma_deg < SMALLEST_ANGLE_DRAMINSKY_2_DEG:
        remarks.append(
            _Remark(
                f"gamma = {case.gamma_deg:g} deg lies below "
                f"{SMALLEST_ANGLE_DRAMINSKY_2_DEG:g} deg: the factor 2/3 - (1 + cos gamma)/2 of "
                "the web falls to zero and below, which no throw does.",
                invalidates=True,
            )
        )
    return remarks


def _check_skorchev(case: _Case) -> list[_Remark]:
    remarks = _plain_web_remark(case)
    if case.gamma_deg < 180.0 and "k_or" not in case.given_constants:
        remarks.append(
            _Remark(
                f"The factor k_or for gamma = {case.gamma_deg:g} deg is not published: the value "
                "stands for opposite neighbors, gamma = 180 deg (k_or = 1), unless "
                "constants={'k_or': ...} gives it.",
                invalidates=True,
            )
        )
    return remarks


def _check_anderson(case: _Case) -> list[_Remark]:
    remarks = _negative_shear_remark(case)
    if _anderson_web_share(case.throw) <= 0.0:
        remarks.append(
            _Remark(
                "The crank radius "
                f"{show_quantity(case.throw.crank_radius, 'm')} is at most an eighth of the sum of "
                "both journal diameters: nothing of the web is left to bend (k_1 <= 0).",
                invalidates=True,
            )
        )
    return remarks


def _check_gorbunov(case: _Case) -> list[_Remark]:
    remarks = _negative_shear_remark(case)
    factor = _gorbunov_angle_factor(case)
    if factor < 1.0 / 6.0:
        remarks.append(
            _Remark(
                f"At gamma = {case.gamma_deg:g} deg the angle factor of the web is {factor:.3g}: "
                "the web is then stiffer than even a frame with blocked tilt has it.",
                invalidates=True,
            )
        )
    elif 2.0 * case.constants["k_gorbunov"] > 1.0 + 1e-12:
        remarks.append(
            _Remark(
                f"The angle factor k_phi = {case.constants['k_gorbunov']:g} (1 - cos gamma) gives "
                f"the web {2.0 * case.constants['k_gorbunov']:g} times the compliance of a slender "
                "frame at 180 deg; constants={'k_gorbunov': 0.5} meets the frame."
            )
        )
    return remarks


_Evaluate = Callable[[_Case], float]
_Check = Callable[[_Case], list[_Remark]]


@dataclass(frozen=True)
class _AxialFormula:
    """One formula: where it comes from, its readings, and why a print cannot be evaluated."""

    authors: str
    readings: Mapping[str, tuple[_Evaluate, _Check]]
    printed_fault: str = ""

    @property
    def source(self) -> str:
        return f"{self.authors}; quoted in {_SURVEY}"


_FORMULAS: Mapping[str, _AxialFormula] = {
    "Draminsky (1)": _AxialFormula(
        "P. Draminsky, E. Warming, MTZ, 1942, no. 2, pp. 292-301",
        {
            "corrected": (_draminsky_1, _check_draminsky_1),
            "printed": (_draminsky_1_printed, _check_draminsky_1_printed),
        },
    ),
    "Draminsky (2)": _AxialFormula(
        "P. Draminsky, E. Warming, MTZ, 1942, no. 2, pp. 292-301",
        {
            "corrected": (_draminsky_2, _check_draminsky_2),
            "k/4": (_draminsky_2_quarter, _plain_web_remark),
        },
        "its shear term 2 R / (G I_w) is in 1/(N m), not in m/N, because it divides by the web's "
        "inertia instead of its area B h",
    ),
    "Dorey": _AxialFormula(
        "S. F. Dorey, I.S.P. Journal, 1939, no. 55, pp. 69-78",
        {
            "corrected": (_dorey, _plain_web_remark),
            "printed": (_dorey, _plain_web_remark),
        },
    ),
    "Skorchev": _AxialFormula(
        "N. S. Skorchev, thesis abstract, Leningrad, 1972",
        {
            "corrected": (_skorchev, _check_skorchev),
            "printed": (_skorchev, _check_skorchev),
        },
    ),
    "Anderson": _AxialFormula(
        "G. Anderson, in: Marine low-speed turbocharged engines, ed. N. N. Ivanchenko, "
        "Leningrad, 1967",
        {"corrected": (_anderson, _check_anderson)},
        "its shear term 2 [R - 0.5 (D_km + D_shm)] / (G I_w) is in 1/(N m), not in m/N, because "
        "it divides by the web's inertia instead of its area B h",
    ),
    "Gorbunov": _AxialFormula(
        "Yu. S. Barshai, E. Ya. Gorbunov, Trudy TsNII morskogo flota, 1975, no. 192, pp. 70-79",
        {"corrected": (_gorbunov, _check_gorbunov)},
        "its web term 2 pi R^3 / (B k_2) is in m, its pin term 2 R L_1 / D^4 in 1/m^2 and the "
        "others in 1/m, which cannot be added (k_2^3 and 16 R^2 L_1 / D^4 would fit)",
    ),
}

AXIAL_FORMULA_NAMES: tuple[str, ...] = tuple(_FORMULAS)
AXIAL_VARIANTS: tuple[str, ...] = ("corrected", "printed", "k/4")


# --------------------------------------------------------------------------------- the face


def axial_formulas(
    throw: CrankThrow,
    gamma_deg: float = 180.0,
    *,
    youngs_modulus: float = 2.1e11,
    poisson_ratio: float = 0.3,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> dict[str, FormulaValue]:
    """Axial compliance of a throw by every published formula that can be evaluated.

    Parameters
    ----------
    throw : CrankThrow
        The throw's dimensions [m]. Fillets do not enter.
    gamma_deg : float, optional
        Angle between neighboring cranks, gamma_k [deg]; folded to 0 ... 180, so 240 counts as 120.
    youngs_modulus : float, optional
        E [Pa].
    poisson_ratio : float, optional
        For the shear modulus G = E / (2 (1 + nu)).
    variant : {"corrected", "printed", "k/4"}, optional
        The reading. A formula that does not have the reading, or whose print is dimensionally
        unsound, is left out; "k/4" is an alternative of Draminsky (2) alone.
    constants : mapping, optional
        Values for `DEFAULT_CONSTANTS`: "k_3" (Dorey, 1), "k_or" (Skorchev, 1) and "k_gorbunov"
        (Gorbunov, 0.8).

    Returns
    -------
    dict of str to FormulaValue
        Formula name to its value [m/N], with validity and remarks.

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
    case = _case(throw, gamma_deg, youngs_modulus, poisson_ratio, constants)
    _check_variant(variant)
    return {
        name: _evaluate(formula, variant, case)
        for name, formula in _FORMULAS.items()
        if variant in formula.readings
    }


def axial_formula(
    name: str,
    throw: CrankThrow,
    gamma_deg: float = 180.0,
    *,
    youngs_modulus: float = 2.1e11,
    poisson_ratio: float = 0.3,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
) -> FormulaValue:
    """Axial compliance of a throw by one published formula.

    Parameters
    ----------
    name : str
        One of `AXIAL_FORMULA_NAMES`.
    throw, gamma_deg, youngs_modulus, poisson_ratio, variant, constants
        As in `axial_formulas`.

    Returns
    -------
    FormulaValue
        The value [m/N], with validity and remarks.

    Raises
    ------
    InputError
        As in `axial_formulas`; for an unknown name; for a reading that the formula does not have,
        among them a print that is dimensionally unsound.
    """
    if name not in _FORMULAS:
        raise InputError(
            f"formula: given {name!r}; allowed are {', '.join(AXIAL_FORMULA_NAMES)}, the "
            "published axial formulas that are known here."
        )
    case = _case(throw, gamma_deg, youngs_modulus, poisson_ratio, constants)
    _check_variant(variant)
    formula = _FORMULAS[name]
    if variant not in formula.readings:
        readings = " or ".join(repr(reading) for reading in formula.readings)
        reason = (
            f"the printed formula {name} cannot be evaluated, {formula.printed_fault}"
            if variant == "printed"
            else f"{name} has no other reading"
        )
        raise InputError(f"variant: given {variant!r}; allowed is {readings}, because {reason}.")
    return _evaluate(formula, variant, case)


def shape_remarks(throw: CrankThrow) -> list[tuple[str, bool]]:
    """What of a throw the published formulas do not know, and whether that makes them void."""
    remarks = []
    if throw.further_pins:
        remarks.append(
            ("The throw has several pins between its bearings; the formula knows one.", True)
        )
    for table in (throw.left_web, throw.right_web):
        if table is not None and (
            table.thickness not in (None, throw.web_thickness)
            or table.width not in (None, throw.web_width)
        ):
            remarks.append(
                ("The webs differ; the formula takes web_width and web_thickness for both.", False)
            )
            break
    if throw.web_tip_thickness is not None or throw.web_foot_thickness is not None:
        remarks.append(("The formula takes the web's full thickness; it is thinned.", False))
    if throw.main_journal_bore_offset or throw.pin_bore_offset:
        remarks.append(("The formula takes eccentric bores for concentric ones.", False))
    return remarks


def fold_angle_deg(gamma_deg: float) -> float:
    """Fold an angle between neighboring cranks to 0 ... 180 deg (240 and -120 become 120)."""
    rest = math.fmod(abs(gamma_deg), 360.0)
    return 360.0 - rest if rest > 180.0 else rest


def shear_modulus(youngs_modulus: float, poisson_ratio: float) -> float:
    """Return G = E / (2 (1 + nu)) [Pa] after checking both.

    Raises
    ------
    InputError
        If E is not positive, or nu lies outside -1 < nu <= 0.5.
    """
    if not (math.isfinite(youngs_modulus) and youngs_modulus > 0.0):
        raise InputError(
            f"youngs_modulus: given {youngs_modulus!r}; allowed is a positive number of Pa, "
            "because a throw without stiffness has no compliance."
        )
    if not -1.0 < poisson_ratio <= 0.5:
        raise InputError(
            f"poisson_ratio: given {poisson_ratio!r}; allowed is above -1 up to 0.5, the range of "
            "an isotropic material."
        )
    return youngs_modulus / (2.0 * (1.0 + poisson_ratio))


def _case(
    throw: CrankThrow,
    gamma_deg: float,
    youngs_modulus: float,
    poisson_ratio: float,
    constants: Mapping[str, float] | None,
) -> _Case:
    if not math.isfinite(gamma_deg):
        raise InputError(
            f"gamma_deg: given {gamma_deg!r}; allowed is a finite angle in deg between "
            "neighboring cranks."
        )
    modulus = shear_modulus(youngs_modulus, poisson_ratio)
    given = dict(constants or {})
    for key, value in given.items():
        if key not in DEFAULT_CONSTANTS:
            raise InputError(
                f"constants: given {key!r}; allowed are {', '.join(DEFAULT_CONSTANTS)}, the open "
                "constants of the formulas."
            )
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(
                f"constants[{key!r}]: given {value!r}; allowed is a positive number, because the "
                "constant multiplies a compliance."
            )
    return _Case(
        throw,
        fold_angle_deg(gamma_deg),
        youngs_modulus,
        modulus,
        {**DEFAULT_CONSTANTS, **given},
        frozenset(given),
    )


def _check_variant(variant: str) -> None:
    if variant not in AXIAL_VARIANTS:
        raise InputError(
            f"variant: given {variant!r}; allowed are {', '.join(AXIAL_VARIANTS)}, the readings "
            "of the published formulas."
        )


def _evaluate(formula: _AxialFormula, variant: str, case: _Case) -> FormulaValue:
    evaluate, check = formula.readings[variant]
    remarks = check(case) + [
        _Remark(text, invalidates) for text, invalidates in shape_remarks(case.throw)
    ]
    value = evaluate(case)
    if value <= 0.0:
        remarks.append(
            _Remark("The value is not positive, which no compliance can be.", invalidates=True)
        )
    return FormulaValue(
        value=value,
        valid=not any(remark.invalidates for remark in remarks),
        remarks=tuple(remark.text for remark in remarks),
        source=formula.source,
        unit="m/N",
        variant=variant,
    )
