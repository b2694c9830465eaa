"""The arguments of a formula, and the beam compliances from which all formulas are built."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from crankbase.array_checks import positive_number
from crankbase.choices import check_choice, check_kind, is_number
from crankbase.errors import InputError, quoted
from crankbase.frames import table
from crankbase.results import InItsUnit, Result, result
from crankbase.sentences import amount, angle
from crankbase.table import text_rows
from fem.material import STEEL, Material
from geometry.throw import CrankThrow
from regression.response_kinds import fold_angle_deg


@dataclass(frozen=True)
class ThrowCase:
    """One throw with its moduli [Pa], the formulas' constants, and its neighbors' angle, 0 to 180 [deg].

    `constants` has a value for every name in `DEFAULT_CONSTANTS`; `given_constants` are those given.
    """

    throw: CrankThrow
    gamma_deg: float
    youngs_modulus: float
    shear_modulus: float
    constants: Mapping[str, float]
    given_constants: frozenset[str]

    def __post_init__(self) -> None:
        check_kind("throw", self.throw, CrankThrow, "a CrankThrow")

    @property
    def cosine(self) -> float:
        """Cosine of gamma."""
        return math.cos(math.radians(self.gamma_deg))

    @property
    def overlap_text(self) -> str:
        """Overlap of main journal and crankpin, as remarks tell it."""
        return amount(self.throw.overlap, "m")

    @property
    def pin(self) -> float:
        """Bending of the crankpin, R^2 L_shm / (E I_shm) [m/N]."""
        return self.pin_of_length(self.throw.pin_length)

    def pin_of_length(self, length: float) -> float:
        """Bending of a crankpin of this length under the moment R of a unit force [m/N]."""
        inertia = round_inertia(self.throw.pin_diameter, self.throw.pin_bore)
        return self.throw.crank_radius**2 * length / (self.youngs_modulus * inertia)

    def bent_journal(self, bore: float) -> float:
        """Bending of the main journal in place of the crankpin, R^2 L_km / (E I_km) [m/N]."""
        inertia = round_inertia(self.throw.main_journal_diameter, bore)
        length = self.throw.main_journal_length
        return self.throw.crank_radius**2 * length / (self.youngs_modulus * inertia)

    @property
    def web(self) -> float:
        """Bending of the web out of its plane, R^3 / (E B h^3 / 12) [m/N]."""
        return self.web_of_thickness(self.throw.web_thickness)

    def web_of_thickness(self, thickness: float) -> float:
        """Bending of a web of this thickness [m/N]."""
        inertia = self.throw.web_width * thickness**3 / 12.0
        return self.throw.crank_radius**3 / (self.youngs_modulus * inertia)

    @property
    def tension(self) -> float:
        """Stretch of journal and pin, (L_km / F_km + L_shm / F_shm) / E [m/N]."""
        return self.tension_of_lengths(self.throw.main_journal_length, self.throw.pin_length)

    def tension_of_lengths(self, journal_length: float, pin_length: float) -> float:
        """Stretch of a journal and a pin of these lengths [m/N]."""
        throw = self.throw
        journal = journal_length / round_area(throw.main_journal_diameter, throw.main_journal_bore)
        pin = pin_length / round_area(throw.pin_diameter, throw.pin_bore)
        return (journal + pin) / self.youngs_modulus

    def shear_of_length(self, length: float) -> float:
        """Shear of a web of this length on the full section, length / (G B h) [m/N]."""
        return length / (self.shear_modulus * self.throw.web_width * self.throw.web_thickness)


def round_inertia(diameter: float, bore: float) -> float:
    """Second moment of area of a round section with a concentric bore [m^4]."""
    return math.pi / 64.0 * (diameter**4 - bore**4)


def round_area(diameter: float, bore: float) -> float:
    """Area of a round section with a bore [m^2]."""
    return math.pi / 4.0 * (diameter**2 - bore**2)


@result("value", "unit", "valid", "remarks", "source", "variant", eq=True)
class FormulaValue(Result):
    """The result of one published formula for one crank throw; `variant` is the reading.

    Outside the formula's range of validity the value is for comparison only.
    """

    value: InItsUnit
    valid: bool
    remarks: tuple[str, ...]
    source: str
    unit: str
    variant: str
    name: str = ""


def formulas_to_pandas(formulas: Mapping[str, FormulaValue]) -> Any:
    """Return a table of the results of the published formulas.

    Parameters
    ----------
    found : mapping of str to FormulaValue
        From `axial_formulas` or `torsional_formulas`.

    Returns
    -------
    pandas.DataFrame
        ``formula``, ``value``, ``valid``, ``variant``, ``remarks``, ``source``; the unit of the
        values is in ``frame.attrs["units"]``.

    Raises
    ------
    MissingLibraryError
        If pandas is not installed.
    """
    values = list(formulas.values())
    units = " or ".join(dict.fromkeys(value.unit for value in values))
    return table(
        {
            "formula": (list(formulas), ""),
            "value": ([value.value for value in values], units),
            "valid": ([value.valid for value in values], ""),
            "variant": ([value.variant for value in values], ""),
            "remarks": (["; ".join(value.remarks) for value in values], ""),
            "source": ([value.source for value in values], ""),
        }
    )


@dataclass(frozen=True)
class Remark:
    """One sentence, and whether it makes the formula inapplicable."""

    text: str
    invalidates: bool = False


Remarks = Iterator[Remark]


def shape_remarks(throw: CrankThrow) -> Remarks:
    """Features of a throw that the published formulas do not include, and whether that makes them invalid."""
    if throw.further_pins:
        text = "The throw has several pins between its bearings; the formula assumes one."
        yield Remark(text, invalidates=True)
    if any(
        web.thickness not in (None, throw.web_thickness) or web.width not in (None, throw.web_width)
        for web in (throw.left_web, throw.right_web)
        if web is not None
    ):
        yield Remark("The webs differ; the formula uses web_width and web_thickness for both.")
    if throw.web_tip_thickness is not None or throw.web_foot_thickness is not None:
        yield Remark("The formula uses the full web thickness; this web is tapered.")
    if throw.main_journal_bore_offset or throw.pin_bore_offset:
        yield Remark("The formula treats eccentric bores as concentric.")
    if throw.oil_holes:
        yield Remark("The formula ignores oil holes.")


def plain_web_remarks(case: ThrowCase) -> Remarks:
    """For a formula whose web has its plain section B h, whatever the overlap."""
    if case.throw.overlap > 0.0:
        yield Remark(
            f"Main journal and crankpin overlap by {case.overlap_text}: a formula with the plain web "
            "section overestimates the compliance."
        )


def negative_shear_remarks(case: ThrowCase) -> Remarks:
    """For a formula whose web shears over 2 R - D_km - D_shm only."""
    if case.throw.overlap > 0.0:
        yield Remark(
            f"Main journal and crankpin overlap by {case.overlap_text}: the formula's shear term is "
            "negative there."
        )


def no_angle_remarks(case: ThrowCase) -> Remarks:
    """For a formula that has no angle between neighboring cranks."""
    if case.gamma_deg != 180.0:
        yield Remark(
            "The formula has no angle: it holds for opposite neighbors, gamma = 180 deg, and "
            f"not for {angle(case.gamma_deg)}, where the throw is stiffer.",
            invalidates=True,
        )


def open_angle_factor_remarks(case: ThrowCase, constant: str) -> Remarks:
    """For a formula whose factor for the angle is not published, unless the factor is given."""
    if case.gamma_deg != 180.0 and constant not in case.given_constants:
        yield Remark(
            f"The factor {constant} for gamma = {angle(case.gamma_deg)} is not published: the value applies "
            f"to opposite neighbors, gamma = 180 deg ({constant} = 1), unless the constant {constant} is "
            "given.",
            invalidates=True,
        )


def unused_bores_remarks(case: ThrowCase) -> Remarks:
    """For a formula that does not include the bores."""
    if case.throw.main_journal_bore or case.throw.pin_bore:
        yield Remark("The formula ignores the bores.")


SURVEY = (
    "A. I. Yamanin, V. A. Zhukov, Vestnik AGTU, Ser. Marine Engineering and Technologies, 2021, "
    "no. 4, pp. 75-83, doi 10.24143/2073-1574-2021-4-75-83"
)


@dataclass(frozen=True)
class Reading:
    """One reading of a formula: its value of a case [SI], remarks, and why it has none ("" if it has)."""

    evaluate: Callable[[ThrowCase], float]
    remarks: Callable[[ThrowCase], Iterable[Remark]] = lambda _: ()
    fault: Callable[[ThrowCase], str] = lambda _: ""


@dataclass(frozen=True)
class AxialFormula:
    """A published formula for the axial compliance, its readings by name ("corrected", "printed", ...).

    `short` heads columns; `printed_fault` is why the print cannot be evaluated, if it is not among the
    readings.
    """

    name: str
    short: str
    authors: str
    readings: Mapping[str, Reading]
    printed_fault: str = ""

    @property
    def source(self) -> str:
        """The first publication, and the survey that quotes it."""
        return f"{self.authors}; quoted in {SURVEY}"


def reading_value(
    reading: Reading, case: ThrowCase, source: str, unit: str, variant: str
) -> FormulaValue:
    """Evaluate a reading for a case, with all remarks."""
    remarks = [*reading.remarks(case), *shape_remarks(case.throw)]
    value = reading.evaluate(case)
    if value <= 0.0:
        remarks.append(
            Remark("The value is not positive, which no compliance can be.", invalidates=True)
        )
    return FormulaValue(
        value=value,
        valid=not any(remark.invalidates for remark in remarks),
        remarks=tuple(remark.text for remark in remarks),
        source=source,
        unit=unit,
        variant=variant,
    )


@runtime_checkable
class OfThrow(Protocol):
    """What has a throw and its material: an analysis of a throw, or an engine."""

    @property
    def throw(self) -> CrankThrow:
        """Its throw."""

    @property
    def material(self) -> Material:
        """Of the throw."""


def throw_and_material(
    throw: CrankThrow | OfThrow, material: Material | None
) -> tuple[CrankThrow, Material]:
    """Throw and material, steel by default; `InputError` if what has a material is given with another one."""
    if isinstance(throw, OfThrow):
        if material not in (None, throw.material):
            raise InputError(
                "material: given another one than the analysis has; allowed is the throw with a material, "
                "or the analysis without one."
            )
        return throw.throw, throw.material
    steel = STEEL if material is None else material
    check_kind("material", steel, Material, "a Material")
    return throw, steel


def checked_angle_deg(gamma_deg: float) -> float:
    """Folded angle [deg]; `InputError` if it is not a finite number."""
    if isinstance(gamma_deg, Material):
        raise InputError(
            "gamma_deg: given a Material; write it as material=..., because the second argument is the angle "
            "between neighboring cranks."
        )
    if not is_number(gamma_deg):
        raise InputError(
            f"gamma_deg: given {quoted(gamma_deg)}; allowed is a finite angle in deg between "
            "neighboring cranks, because it is folded to 0 to 180 deg."
        )
    return fold_angle_deg(gamma_deg)


def check_youngs_modulus(youngs_modulus: float) -> None:
    """Refuse what is not a positive number of Pa (`InputError`)."""
    reason = "a throw without stiffness has no compliance"
    positive_number("youngs_modulus", youngs_modulus, "Pa", reason)


@dataclass(frozen=True)
class FormulaConstant:
    """One open constant of a published formula, its default, and the reason for it."""

    name: str
    formula: str
    default: float
    meaning: str
    reason: str


# Name | formula | default | meaning | reason of the default.
_CONSTANTS = """
C | Guglielmotti-Macchiotta | 1 | correction for the angle between neighboring cranks | no values are \
published; 1 is for opposite neighbors, gamma = 180 deg, where the formula's terms are those of a frame
k_3 | Dorey | 1 | factor of the crankpin's term for built and semi-built shafts | no values are published; \
with 1 the formula is the exact frame at 180 deg
k_or | Skorchev | 1 | factor for the angle between neighboring cranks | no values are published; 1 is for \
opposite neighbors, gamma = 180 deg
k_n | Stoyanov | 1 | factor of the webs' term for the overlap of main journal and crankpin | no values are \
published; with 1 the term is the exact web without overlap
k_gorbunov | Gorbunov | 0.8 | number in the angle factor k_phi = 0.8 (1 - cos gamma) of the web's term | as \
printed; 0.5 would match the limit of a slender frame at 180 deg
"""
FORMULA_CONSTANTS: Mapping[str, FormulaConstant] = {
    name: FormulaConstant(name, formula, float(default), *words)
    for name, formula, default, *words in text_rows(_CONSTANTS)
}
DEFAULT_CONSTANTS: Mapping[str, float] = {
    name: constant.default for name, constant in FORMULA_CONSTANTS.items()
}


def checked_constants(constants: Mapping[str, float]) -> dict[str, float]:
    """All constants, the given ones replacing their defaults.

    `InputError` if one is unknown or not positive.
    """
    for key, value in constants.items():
        check_choice("constants", key, DEFAULT_CONSTANTS, "these are the formulas' open constants")
        positive_number(f"constant {key}", value, "", "it multiplies a compliance")
    return {**DEFAULT_CONSTANTS, **constants}
