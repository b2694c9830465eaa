"""Which values of a file a command uses; the others are named, so that none is dropped unsaid.

`tests/campaigns/doors.py` changes every value of every file for each command, and holds it against `USES`.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from crankbase.errors import InputError
from crankfem.files.engine.file_kinds import any_sections, engine_sections, file_kind
from crankfem.files.engine.throw_file import tables_of_throws, unused_throws
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.satellites import at_place, called, uses_of_satellites
from crankfem.files.sections.crank_throws import PLAIN, read_throws
from geometry.any_throw import dimensioned

# Sections and fields that a command uses, and those that it does not.
Use = tuple[tuple[str, ...], tuple[str, ...]]
ALL = "*"
THROW = ("throw", "throws", "shaft.throws")
ELASTIC = ("material.youngs_modulus", "material.poisson_ratio")
SHAFT = (*THROW, "shaft", "shaft_ends", "engine.crank_angles")
MECHANISM = ("engine", "shaft", "rod", "piston", "hinged_rods", "gas", "load")
FORCES = (*MECHANISM, "throw", "throws", "material.density")
TORQUE = (*MECHANISM, "throw.crank_radius", "throws.*.crank_radius")
RUNNING = ("engine.lowest_speed", "engine.highest_speed")
POLES, DRIVES = "engine.generator_poles", "engine.drives"
NO_FORCES = (*RUNNING, POLES)
# They hardly stiffen a throw: the law neglects them.
COUNTERWEIGHTS = (
    *(f"throw.{part}counterweight" for part in ("", "left_web.", "right_web.")),
    "throws.*.counterweight",
)
# At rated speed each law has full load.
AT_SPEED = "load.law"
STUDY = (*THROW, "material", "study")
# Only the run has results of these.
RUN_ALONE = ("study", "torque", "two_mass_check", "strength")
# Only the class document has results of these.
CLASS_ALONE = (
    *(f"limits.{name}" for name in ("coupling_heat", "damper_torque", "damper_heat")),
    *("limits.generator_angle", "limits.elements.heat", POLES),
)
# Only a warning, that the skirt meets a counterweight, has this.
SKIRT = "piston.skirt_length"
# Of the crankshaft's steel, for a limit by a rule; where the maker's limit replaces it nothing is.
STEEL = ("limits.tensile_strength", "limits.yield_strength", "limits.alloy")
# Only the whole crankshaft has these.
WHOLE = (
    "shaft_ends",
    "damping.bending_magnifier",
    "flywheel.diametral_inertia",
    "flywheel.overhang",
    "free_end.diametral_inertia",
    "bearings.damping",
    "bearings.variation",
    "shaft_line.bearings",
    "shaft_line.bearing_stiffness",
)
# Through so many points a cubic spline is a straight line.
STRAIGHT = 2
FREE = ("damping", "loss_factor", "relative_damping", "magnifier", "ground_damping")
# What natural frequencies of the crankshaft do not depend on, and what those of one kind do not.
UNFORCED = (
    *(*RUN_ALONE, *WHOLE, *RUNNING),
    *("gas", "gas_map", "load", "misfire", "propeller_forces", "limits", "ranges", "damping"),
    *("engine.bore", "engine.rated_speed", "engine.rated_power", "engine.firing_order"),
    *(
        DRIVES,
        SKIRT,
        POLES,
        "vibration",
        "bearings.lowest_stiffness",
        "bearings.highest_stiffness",
    ),
    *(f"*.{name}" for name in FREE),
)
ROTATING = ("flywheel.inertia", "free_end.inertia")
TORSIONAL_ALONE = (*ROTATING, "torsional_damper", "driven", "rod", "piston")
AXIAL_ALONE = ("flywheel.mass", "free_end.mass", "axial_damper", "thrust_bearing")
# By command, perhaps with an option that changes it: sections and fields that it uses, and that it does not.
# The longer name decides; "*." stands for any section, also within one.
USES: Mapping[str, Use] = {
    "throw": ((*THROW, "material"), ()),
    "stress": (THROW + ELASTIC[1:], ()),
    "formulas": ((*THROW, *ELASTIC), ()),
    "lookup": ((*THROW, "material"), ()),
    "lookup law": ((*THROW, *ELASTIC), COUNTERWEIGHTS),
    "draw": ((*THROW, "engine.name"), ()),
    "draw --shaft": ((*SHAFT, "engine.name"), ()),
    "export": (THROW, ()),
    "export --calculix": ((*THROW, "material"), ()),
    "export --shaft": (SHAFT, ()),
    "plan": (STUDY, ()),
    "doe": (STUDY, ()),
    "designs": (STUDY, ()),
    "mechanism --motored": (FORCES, (*NO_FORCES, SKIRT)),
    "mechanism": (FORCES, (*NO_FORCES, SKIRT)),
    "harmonics --speed": (TORQUE, (*NO_FORCES, SKIRT, "engine.rated_power")),
    "harmonics": (TORQUE, (*NO_FORCES, SKIRT, "engine.rated_power", AT_SPEED)),
    "two-mass": (
        ("two_mass_check", "torque", "vibration.highest_order", "engine"),
        # Times of the torque shift phases alone.
        (
            *(f"engine.{name}" for name in ("bore", "stroke", "rated_power", "throws")),
            *(POLES, "torque.reading.top"),
        ),
    ),
    "vibration": ((ALL, "strength.tensile_strength"), (*RUN_ALONE, *WHOLE, *CLASS_ALONE, SKIRT)),
    "vibration --coupled": (
        (ALL, "strength.tensile_strength"),
        # Solids alone have a flange; its thickness tells where the flywheel is.
        (*RUN_ALONE, *CLASS_ALONE, SKIRT, "shaft_ends.flange_diameter"),
    ),
    "vibration of a chain": ((ALL,), ("chain.dashpots", *(f"*.{name}" for name in FREE))),
    "run": ((ALL,), (*CLASS_ALONE, SKIRT)),
}


# Of commands that take a saved model in place of sources.
WITH_MODEL = " --model"


def command_use(name: str, arguments: Mapping[str, Any]) -> str:
    """Return what a command is called in `not_used`, by the name of its function, with these arguments."""
    command = called(name)
    if command == "lookup":
        return "lookup law" if str(arguments["model"]) == "law" else command
    if (use := uses_of_satellites().get(command)) is not None and use.case:
        return f"{command} {at_place(use.case)(**arguments)}".rstrip()
    with_option = {f"{command} --{option}" for option, value in arguments.items() if value}
    key = next((key for key in USES if key in with_option), command)
    return key + WITH_MODEL if command in ("run", "vibration") and arguments["model"] else key


def not_used(content: TomlFile, command: str) -> tuple[str, ...]:
    """Name what a file has that a command does not use: sections as a whole, else single fields.

    Parameters
    ----------
    command : str
        Its name, perhaps with an option that changes what it uses, as "draw --shaft", and with " --model".
    """
    command, with_model, _ = command.partition(WITH_MODEL)
    key = f"{command} of a chain" if file_kind(content) == "chain" else command
    name, _, case = key.partition(" ")
    if key in USES:
        used, always = USES[key]
    elif name in uses_of_satellites() and file_kind(content) != "chain":
        used, always = at_place(uses_of_satellites()[name].used)(content, case)
    else:  # the command refuses the file
        return ()
    without = (*always, *_without_effect(content, command, used, always))
    if with_model:
        without += ("vibration.model",)
    if command == "run" and (with_model or "model" in content.sections.get("vibration", {})):
        without += ("study",)  # for which the saved model stands
    if used == STUDY:
        without += tuple(unused_throws(content, content.sections.get("study", {}).get("throw")))
    elif "study" not in content.sections or _is_unused("study", used, without):
        without += tuple(_replaced(content))  # which a study has in its key all the same
    names: list[str] = []
    for section, values in content.sections.items():
        fields = list(_fields(section, values))
        unused = [name for name in fields if _is_unused(name, used, without)]
        names += [section] if unused and len(unused) == len(fields) else unused
    return tuple(dict.fromkeys(names))


def not_used_of(source: str, command: str) -> tuple[str, ...] | None:
    """Name what is not used of a file or a shipped one, as a file with sections has it; None if unread."""
    try:
        content = any_sections(source)
        if content is not None:
            return not_used(content, command)
        from crankfem.files.chain.chain_file import load_chain  # here: engine files do without

        chain = load_chain(source).chain
    except InputError:  # which the command itself tells
        return None
    damps = {
        "chain.elements.damping": any(chain.damping),
        "chain.elements.loss_factor": any(chain.loss_factor),
        "chain.nodes.ground_damping": any(chain.ground_damping),
        "chain.dashpots": bool(chain.dashpots),
    }
    return tuple(name for name, there in damps.items() if there)


def _without_effect(
    content: TomlFile, command: str, used: tuple[str, ...], without: tuple[str, ...]
) -> Iterator[str]:
    """Sections and fields that others of the file leave without effect."""
    sections, fields = (
        content.sections,
        {name: set(section) for name, section in content.sections.items()},
    )
    limits, line = fields.get("limits", set()), fields.get("shaft_line", set())
    if WHOLE[0] in without and "plant" in line:
        yield from ROTATING  # which the plant's chain has; only the whole crankshaft takes them
    if command == "vibration --coupled" and "overhang" in fields.get("flywheel", ()):
        yield "shaft_ends.flange_thickness"
    if "crankshaft_stress" in limits:
        yield from STEEL
    if {"crankshaft_stress", "tensile_strength"} & limits and not command.startswith("run"):
        yield "strength.tensile_strength"
    plant = {"driven", "shaft_line"} & fields.keys()
    if plant and {"crankshaft_stress", "crankshaft_rule"} & limits and DRIVES not in used:
        yield DRIVES  # which selects a rule, and tells what else a plant has
    if sections.get("vibration", {}).get("reciprocating", "half") == "half":
        yield from ("rod.length",) if "vibration.reciprocating" in used else ()
    for kind in ("thrust", "torque"):
        if f"{kind}_shares" not in fields.get("propeller_forces", ()):
            yield f"propeller_forces.rated_{kind}"
    gas = fields.get("gas", set())
    if "pressure_table" in gas and command != "mechanism --motored":
        yield from ("gas.intake_pressure", "gas.exhaust_pressure")
        if command.startswith(("mechanism", "harmonics")):  # else of a cylinder that misfires
            yield "gas.compression_ratio"
    points = sections.get("load", {}).get("points")
    at_points = isinstance(points, list) and all(
        isinstance(point, Mapping) and "peak_pressure" in point for point in points
    )
    if at_points and {"mean_effective_pressure", "intake_pressure"} <= gas:
        yield from ("gas.peak_pressure", "gas.combustion_start")  # which these points have instead
    yield from _of_map(sections.get("gas_map"))
    if command.endswith("--shaft") and "throw_angles" in fields.get("shaft", ()):
        yield "engine.crank_angles"
    if command.startswith("mechanism"):
        # What is round about the shaft has no unbalance; a bore that reaches the pin ends there.
        for name, throw in dimensioned(read_throws(engine_sections(content))).items():
            section = name if name == PLAIN else f"throws.{name}"
            yield f"{section}.main_journal_fillet_radius"
            nearest = min(math.hypot(*pin.axis) - pin.radius for pin in throw.parts.pins)
            if throw.main_journal_bore_offset == 0.0 and 0.5 * throw.main_journal_bore < nearest:
                yield f"{section}.main_journal_bore"


def _of_map(values: Mapping[str, Any] | None) -> Iterator[str]:
    """Fields of a map that its points, or the lack of a law, leave without effect."""
    if values is None:
        return
    from crankfem.files.sections.excitation_sections import GasMap  # here: loading it takes long

    section = GasMap.from_text(values)
    if section.law != "propeller":
        yield "gas_map.measure"
    if section.law is None:
        yield "gas_map.rated_load"
    points = section.points
    speeds, loads = ({getattr(point, name) for point in points} for name in ("speed", "load"))
    if len(speeds) <= STRAIGHT and (len(loads) <= STRAIGHT or len(points) == len(speeds)):
        yield "gas_map.method"


def _replaced(content: TomlFile) -> Iterator[str]:
    """Fields of throws in whose place others of the same throw stand, or which say where nothing is."""
    throws = tables_of_throws(content.sections)
    for name, throw in throws.items():
        section = name if name == PLAIN else f"throws.{name}"
        whole = _with_missing(throw, throws.get(str(throw.get("like")), {}))
        pins = whole.get("further_pins")
        pins = pins if isinstance(pins, list) else []
        left, right = (whole.get(f"{side}_web") for side in ("left", "right"))
        of_both = (
            left.keys() & right.keys() if isinstance(left, dict) and isinstance(right, dict) else ()
        )
        for kind in of_both:
            if all(f"web_{kind}" in pin for pin in pins) or kind not in ("thickness", "width"):
                yield f"{section}.{kind if kind == 'counterweight' else f'web_{kind}'}"
        if {"main_journal_fillet_radius", "pin_fillet_radius"} <= whole.keys():
            yield f"{section}.fillet_radius"
        for bore, pins_too in (("main_journal_bore", ()), ("pin_bore", pins)):
            if bore not in whole and not any("bore" in pin for pin in pins_too):
                yield f"{section}.{bore}_offset"


def _with_missing(values: Mapping[str, Any], others: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a table with those of another that it lacks, also in tables within."""
    inner = {
        name: _with_missing(value, others[name])
        for name, value in values.items()
        if isinstance(value, Mapping) and isinstance(others.get(name), Mapping)
    }
    return {**others, **values, **inner}


def _fields(path: str, values: Mapping[str, Any]) -> Iterator[str]:
    """Paths of the fields of a table and of those in it, without places in lists."""
    for name, value in values.items():
        tables = value if isinstance(value, list) else [value]
        if tables and all(isinstance(table, dict) for table in tables):
            for table in tables:
                yield from _fields(f"{path}.{name}", table)
        else:
            yield f"{path}.{name}"


def _longest(name: str, places: tuple[str, ...]) -> int:
    """Length of the longest place that a field is, or is in; 0 if there is none."""
    longest = 0
    for place in places:
        if "*." in place:
            section, _, field = place.partition("*")
            inside = name.startswith(section) and f"{field}." in f"{name}."
        else:
            inside = place == ALL or name == place or name.startswith(f"{place}.")
        if inside:
            longest = max(longest, len(place))
    return longest


def _is_unused(name: str, used: tuple[str, ...], without: tuple[str, ...]) -> bool:
    return _longest(name, without) >= _longest(name, used)
