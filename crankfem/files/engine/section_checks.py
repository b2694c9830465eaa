"""Whether a section of an engine file fits the others."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from crankbase.errors import InputError
from crankbase.sentences import amount
from crankfem.files.sections.engine_sections import Engine, ThrustBearing, VibrationSettings
from crankfem.files.sections.excitation_sections import GasMap, Misfire
from crankfem.files.sections.mechanism_sections import Gas, LoadSection
from crankfem.files.sections.strength_section import StrengthSection
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import AXIAL_FORMULA_NAMES
from regression.formulas.torsional_formulas import TORSIONAL_FORMULA_NAMES

if TYPE_CHECKING:
    from regression.plans.plan import StudyPlan


def check_misfire(misfire: Misfire | None, gas: Gas | None, engine: Engine) -> None:
    """Refuse cylinders that do not exist, and failing ones without a pressure."""
    if misfire is None:
        return
    wrong = [number for number in misfire.cylinders or () if not 1 <= number <= engine.cylinders]
    if wrong:
        raise InputError(
            f"misfire.cylinders: given {wrong[0]}; allowed is 1 to {engine.cylinders}, because the engine "
            "has these cylinders."
        )
    if gas is None and misfire.compression:
        raise InputError(
            "misfire: given without the section [gas]; allowed are both, or compression = false, because "
            "the pressure without combustion follows from it."
        )


def check_gas_map(gas_map: GasMap | None, engine: Engine) -> None:
    """Refuse a pressure map that does not cover the running range."""
    if gas_map is None:
        return
    _check_covers("gas_map.points", [point.speed for point in gas_map.points], engine)


def check_load(
    load: LoadSection | None, gas: Gas | None, gas_map: GasMap | None, engine: Engine
) -> None:
    """Refuse a load without a known pressure, and one that does not cover the running range."""
    if load is None:
        return
    if gas_map is not None:
        raise InputError(
            "load: given together with the section [gas_map]; allowed is one of the two, because the map "
            "defines the load by its own law."
        )
    if gas is None:
        raise InputError(
            "load: given without the section [gas]; allowed are both, because the load is a share of what "
            "[gas] gives at rated speed."
        )
    if gas.pressure_table is not None and load.law != "constant":
        raise InputError(
            "load: given together with gas.pressure_table; allowed are peak_pressure or "
            "mean_effective_pressure in [gas], or a section [gas_map] with diagrams of several loads, "
            "because one diagram does not define those at other loads."
        )
    if load.points:
        _check_covers("load.points", [point.speed for point in load.points], engine)


def _check_covers(field: str, speeds: Sequence[float], engine: Engine) -> None:
    if min(speeds) > engine.lowest_speed or max(speeds) < engine.highest_speed:
        listed, allowed = (
            f"{amount(low, 'rad/s', 5)} to {amount(high, 'rad/s', 5)}"
            for low, high in (
                (min(speeds), max(speeds)),
                (engine.lowest_speed, engine.highest_speed),
            )
        )
        raise InputError(
            f"{field}: given speeds from {listed}; allowed are ones that cover the running range of "
            f"{allowed}, because nothing is extrapolated beyond them."
        )


def check_sources(vibration: VibrationSettings, study: "StudyPlan | None") -> None:
    """Refuse an unknown source of compliances before anything is computed."""
    for kind, source, formulas in (
        ("axial", vibration.axial_source, AXIAL_FORMULA_NAMES),
        ("torsional", vibration.torsional_source, TORSIONAL_FORMULA_NAMES),
    ):
        fitted = study is not None or vibration.model is not None
        allowed = ["fe", "fe pinned", "law", *(["regression"] if fitted else []), *formulas]
        if source.casefold() not in [name.casefold() for name in allowed]:
            reason = (
                ", because the file has neither a section [study] to fit nor a vibration.model"
                if source.casefold() == "regression"
                else ""
            )
            raise InputError(
                f"vibration.{kind}_source: given {source!r}; allowed are {', '.join(allowed)}{reason}."
            )


def check_highest_order(vibration: VibrationSettings, engine: Engine) -> None:
    """Refuse a highest order that the engine's cycle does not have."""
    lowest = 2.0 / engine.strokes
    if vibration.highest_order < lowest or vibration.highest_order % lowest:
        raise InputError(
            f"vibration.highest_order: given {vibration.highest_order:g}; allowed are multiples of "
            f"{lowest:g}, because these are the orders of a {engine.strokes}-stroke engine."
        )


def check_thrust_bearing(thrust: ThrustBearing, throws: int) -> None:
    """Refuse a thrust bearing at a main bearing that does not exist."""
    if thrust.main_bearing > throws + 1:
        raise InputError(
            f"thrust_bearing.main_bearing: given {thrust.main_bearing}; allowed is 1 (at the free end) to "
            f"{throws + 1} (at the flywheel), because {throws} throws have {throws + 1} main bearings."
        )


def check_strength(
    strength: StrengthSection | None, throws: Sequence[CrankThrow], gas: Gas | GasMap | None
) -> None:
    """Refuse strength without forces, or for throws that the rule does not cover."""
    if strength is None:
        return
    if gas is None:
        raise InputError(
            "strength: given without gas pressure; allowed are both, because stresses need what loads the "
            "throws: a section [gas] or [gas_map]."
        )
    for number, throw in enumerate(throws, start=1):
        if throw.further_pins:
            raise InputError(
                f"strength: given for throw {number} with several pins; allowed are throws with one pin "
                "between main bearings, because UR M53 holds for these."
            )
        if strength.pin_recess >= throw.web_thickness:
            raise InputError(
                f"strength.pin_recess: given {amount(strength.pin_recess, 'm')}; allowed is less "
                f"than the web_thickness of throw {number}, {amount(throw.web_thickness, 'm')}, "
                "because the recess is cut into the web."
            )
        fit = strength.shrink_fit
        if fit is not None and fit.shrink_diameter <= throw.main_journal_bore:
            raise InputError(
                f"strength.shrink_fit.shrink_diameter: given {amount(fit.shrink_diameter, 'm')}; "
                f"allowed is more than the main_journal_bore of throw {number}, "
                f"{amount(throw.main_journal_bore, 'm')}, because the journal has a wall."
            )
