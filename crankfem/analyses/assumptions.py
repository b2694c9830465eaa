"""All assumptions of a calculation: defaults and assumed values of an engine file."""

from collections.abc import Iterable

from crankbase.model import field_extra
from crankbase.quantity import compact, format_quantity
from crankbase.sentences import amount
from crankfem.analyses.shaft.chains import flywheel_overhang
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.engine.full_load import by_gas
from crankfem.files.reading.toml_file import InputRecord
from crankfem.files.sections.engine_sections import Flywheel
from dynamics.assessment.limit_rules import (
    BASE_STRENGTH,
    BASE_YIELD,
    CRANKSHAFT_STRENGTHS,
    RULE_OF_DRIVEN,
    crankshaft_material_factors,
)
from dynamics.engine.forces import full_load_parameters
from dynamics.gas.gas_cycle import USUAL_PRESSURE_RISE, USUAL_VALUES, name_of_field
from dynamics.response.linear_system import DEFAULT_MAGNIFIER, MAGNIFIER_SOURCE
from fem.material import STEEL

# What the cycle model needs beside the fields of [gas].
FIXED_IN_CYCLE = tuple(
    name for name in USUAL_VALUES if name_of_field(name) not in SECTIONS["gas"].model.model_fields
)

AT_RESONANCE = "amplitudes at resonance increase with it, in proportion if nothing else damps"
AT_FLYWHEEL = "bending of the whole crankshaft at the flywheel; the chains do not include it"
# What moves with a value, where that is known without a calculation.
EFFECTS = {
    "material.youngs_modulus": "natural frequencies of the crankshaft are proportional to its square root",
    "material.density": "mass and inertia of the throws are proportional to it",
    "bearings.stiffness": "bending of the whole crankshaft, and the throws' compliance in the shaft",
    "flywheel.diametral_inertia": AT_FLYWHEEL,
    "flywheel.overhang": AT_FLYWHEEL,
    "free_end.diametral_inertia": "bending of the whole crankshaft at that end; the chains do not include it",
    "damping.torsional_magnifier": AT_RESONANCE,
    "damping.axial_magnifier": AT_RESONANCE,
    "damping.bending_magnifier": AT_RESONANCE,
    "limits.tensile_strength": "; ".join(
        f"{amount(strength, 'Pa')} permits "
        f"{crankshaft_material_factors(strength, BASE_YIELD, alloy=alloy)[0]:.3g} times as much"
        for alloy, strength in CRANKSHAFT_STRENGTHS.items()
    ),
    "limits.yield_strength": "the limit for passing quickly is proportional to it",
}


def input_values(file: EngineFile) -> tuple[InputRecord, ...]:
    """Return every value of a file, and every value that is assumed where the file gives none.

    Parameters
    ----------
    file : EngineFile
        For a mechanism alone, only the values that its forces depend on.

    Returns
    -------
    tuple of InputRecord
        Those of the file first. Each field is the one that can give the value.
    """
    stated = {record.field for record in file.records}
    records = [*_of_mechanism(file, stated)]
    if file.whole:
        records += [*_of_shaft(file, stated), *_of_damping(file), *_of_limits(file)]
    relevant = [record for record in file.records if _matters(record, file)]
    return (*relevant, *records)


def assumed_values(file: EngineFile) -> tuple[InputRecord, ...]:
    """Return the values that a file leaves open or marks as assumed, each with its reason.

    Returns
    -------
    tuple of InputRecord
        The fields that can give them, with value, unit and reason.

    Examples
    --------
    >>> from crankfem.files.engine.engine_file import load_engine
    >>> [one.field for one in assumed_values(load_engine("6chn25-34"))][-2:]
    ['limits.yield_strength', 'limits.crankshaft_rule']
    """
    return tuple(record for record in input_values(file) if record.assumed)


def is_assumed(engine_file: EngineFile, field: str) -> bool:
    """Whether the file does not give a field, or marks its value as assumed."""
    return all(record.assumed for record in engine_file.records if record.field == field)


def _matters(record: InputRecord, file: EngineFile) -> bool:
    """Whether a default affects a result; values of the file are always listed."""
    if record.source != "default":
        return True
    if record.field in ("engine.drives", "gas.compression_ratio"):
        # A cylinder compresses by the ratio while it misfires, with a pressure table too.
        return file.power is None or not file.power.driven
    if record.field == "gas_map.rated_load":
        return file.gas_map is None or file.gas_map.law is not None
    return True


def _assumed(field: str, value: str, reason: str) -> InputRecord:
    section, _, name = field.partition(".")
    info = SECTIONS[section].model.model_fields[name]
    meaning, symbol = info.description or "", field_extra(info, "symbol") or ""
    effect = EFFECTS.get(field, "")
    return InputRecord(field, value, meaning, symbol, reason, assumed=True, effect=effect)


def _of_mechanism(file: EngineFile, stated: set[str]) -> Iterable[InputRecord]:
    """Basis of motion, masses and gas pressure."""
    layout, material = file.layout, file.material
    if "material.density" not in stated and material == STEEL:
        for name, value, unit in (
            ("youngs_modulus", material.youngs_modulus, "Pa"),
            ("poisson_ratio", material.poisson_ratio, ""),
            ("density", material.density, "kg/m^3"),
        ):
            yield _assumed(f"material.{name}", format_quantity(value, unit), "steel")
    hinged = [cylinder for cylinder in layout.cylinders if cylinder.slave_pin is not None]
    plain = [cylinder for cylinder in layout.cylinders if cylinder.slave_pin is None]
    for section, cylinders in (("rod", plain), ("hinged_rods", hinged)):
        if cylinders and stated.isdisjoint({f"{section}.inertia", f"{section}.swing_period"}):
            inertia = format_quantity(cylinders[0].rod.inertia, "kg m^2", 4)
            yield _assumed(f"{section}.inertia", inertia, "that of two masses at its pins")
    if hinged and "hinged_rods.pin_angle" not in stated:
        yield _assumed(
            "hinged_rods.pin_angle", "angle between the banks", "the usual place of the pin"
        )
    if "engine.bank_angles" in stated and "engine.throws" not in stated:
        throws = ", ".join(str(number + 1) for number in file.throws)
        yield _assumed(
            "engine.throws",
            throws,
            "the first cylinder of each bank is on throw 1, the second on throw 2",
        )
    gas = file.gas
    if gas is None or gas.pressure_table is not None:
        return
    if gas.compressor is not None:
        why = "usual of ideal valves; a measured pressure replaces the whole cycle"
        yield _assumed("gas.pressure_table", "cycle with valves that open without loss", why)
        return
    cycle = by_gas(gas, layout, full_load_parameters)[0]
    records = {*FIXED_IN_CYCLE}
    if gas.peak_pressure is not None and gas.mean_effective_pressure is not None:
        records.add("combustion_start_deg")  # it is solved for
    for name in USUAL_VALUES:
        field = f"gas.{name_of_field(name)}"
        if name in records or field in stated:
            continue
        reason = USUAL_VALUES[name].reason
        if name == "intake_pressure" and gas.peak_pressure is not None:
            reason = (
                f"combustion then raises the pressure {USUAL_PRESSURE_RISE:g} times, as is usual for "
                "diesel engines at rated load"
            )
        yield _assumed(field, _shown_of_cycle(name, getattr(cycle, name)), reason)
    shape = ", ".join(
        f"{name_of_field(name).replace('_', ' ')} {_shown_of_cycle(name, getattr(cycle, name))}"
        for name in FIXED_IN_CYCLE
    )
    yield _assumed(
        "gas.pressure_table",
        f"cycle model: {shape}",
        "usual for diesel engines; a measured pressure replaces the whole cycle",
    )


def _shown_of_cycle(name: str, value: float) -> str:
    if name.endswith("_pressure"):
        return format_quantity(value, "Pa", 4)
    if name.startswith(("heat_", "wiebe_")):
        return f"{value:g}"
    return f"{value:.6g} deg"


def _of_shaft(engine: EngineFile, stated: set[str]) -> Iterable[InputRecord]:
    """Surroundings of the crankshaft."""
    held = engine.main_bearings
    if engine.bearings is None:
        yield _assumed(
            "bearings.stiffness",
            f"{compact(held.stiffness)} N/m ({compact(held.lowest)} to {compact(held.highest)})",
            "1e10 N/m per m of journal diameter, an order of magnitude",
        )
        yield _assumed("bearings.damping", "0 N s/m", "oil films are left out")
    flywheel = engine.required(Flywheel)
    if flywheel.diametral_inertia is None:
        value = format_quantity(0.5 * flywheel.inertia, "kg m^2")
        yield _assumed(
            "flywheel.diametral_inertia", value, "half the polar one, that of a thin disc"
        )
    overhang, known = flywheel_overhang(engine)
    if not known:
        where = (
            "at the end of the last main journal, because no flange is given"
            if engine.shaft_ends.flange_thickness is None
            else "at the far side of the flange"
        )
        yield _assumed("flywheel.overhang", format_quantity(overhang, "m"), where)
    end = engine.free_end
    if end is not None and end.diametral_inertia is None:
        value = format_quantity(0.5 * end.inertia, "kg m^2")
        yield _assumed(
            "free_end.diametral_inertia", value, "half the polar one, that of a thin disc"
        )
    propeller = engine.propeller_forces
    for name in ("thrust", "torque"):
        field = f"propeller_forces.{name}_phases"
        if propeller is not None and getattr(propeller, f"{name}_shares") and field not in stated:
            shown = ", ".join(["0 deg"] * len(getattr(propeller, f"{name}_shares")))
            yield _assumed(field, shown, "all harmonics are sines from the propeller's zero angle")


def _of_damping(engine: EngineFile) -> Iterable[InputRecord]:
    """The magnifiers, if vibration is forced."""
    if engine.gas is None and engine.gas_map is None:
        return
    damping = engine.damping
    # Cylinders damp the torsional chain, but not the whole crankshaft.
    damped = damping is not None and damping.loss_factor
    for name in ("torsional", "axial", "bending"):
        field = f"{name}_magnifier"
        if (damping is not None and getattr(damping, field) is not None) or (
            name == "torsional" and damped
        ):
            continue
        of_chain = name == "axial" or (
            name == "torsional" and not (damping is not None and damping.damps_torsion)
        )
        where = "" if of_chain else " (whole crankshaft only)"
        yield _assumed(f"damping.{field}", f"{DEFAULT_MAGNIFIER:g}", f"{MAGNIFIER_SOURCE}{where}")


def _of_limits(engine: EngineFile) -> Iterable[InputRecord]:
    """The rule for the crankshaft's stress if the file gives no limit, and its steel."""
    limits = engine.limits
    if engine.gas is None and engine.gas_map is None:
        return
    if limits is not None and (limits.crankshaft_stress is not None or limits.crankshaft_rule):
        return
    steel = "the lowest strength in the rule; a stronger steel raises the limit"
    for name, value in (("tensile_strength", BASE_STRENGTH), ("yield_strength", BASE_YIELD)):
        by_strength = name == "tensile_strength" and engine.strength is not None
        if not by_strength and (limits is None or getattr(limits, name) is None):
            yield _assumed(f"limits.{name}", format_quantity(value, "Pa"), steel)
    yield _assumed(
        "limits.crankshaft_rule",
        RULE_OF_DRIVEN[engine.engine.drives or "propeller"],
        "no limit is given; the maker's limits.crankshaft_stress replaces it",
    )
