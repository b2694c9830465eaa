"""Which values of a file a command uses; the others are named, so that none is dropped unsaid.

`tests/campaigns/doors.py` changes every value of every file for each command, and holds it against `USES`.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from crankbase.errors import InputError
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.engine.file_kinds import any_sections, file_kind
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.satellites import called

ALL = "*"
THROW = ("throw", "throws", "shaft.throws")
ELASTIC = ("material.youngs_modulus", "material.poisson_ratio")
SHAFT = (*THROW, "shaft", "shaft_ends", "engine.crank_angles")
MECHANISM = ("engine", "throws", "shaft", "rod", "piston", "hinged_rods", "gas", "load")
RUNNING = ("engine.lowest_speed", "engine.highest_speed")
POLES = "engine.generator_poles"
STUDY = (*THROW, "material", "study")
# Only the run has results of these.
RUN_ALONE = ("study", "torque", "two_mass_check", "strength")
# Only the class document has results of these.
CLASS_ALONE = (
    *(f"limits.{name}" for name in ("coupling_heat", "damper_torque", "damper_heat")),
    *("limits.generator_angle", "limits.elements.heat", POLES),
)
# Only a check of the mechanism, whether the skirt meets a counterweight, has this.
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
)
FREE = ("damping", "loss_factor", "relative_damping", "magnifier", "ground_damping")
# What natural frequencies of the crankshaft do not depend on, and what those of one kind do not.
UNFORCED = (
    *(*RUN_ALONE, *WHOLE, *RUNNING),
    *("gas", "gas_map", "load", "misfire", "propeller_forces", "limits", "ranges", "damping"),
    *("engine.bore", "engine.rated_speed", "engine.rated_power", "engine.firing_order"),
    *(
        "engine.drives",
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
# What the class document, which is on torsion, takes only to judge a limit of the axial vibration.
AXIAL_LIMITS = {"axial_amplitude", "axial_force"}
TO_JUDGE_AXIAL = (
    *(*AXIAL_ALONE, "damping.axial_magnifier", "vibration.axial_source", "shaft_line.axial"),
    *("ranges.axial_compliance", "ranges.mass", "ranges.thrust_stiffness"),
    *("propeller_forces.rated_thrust", "propeller_forces.thrust_shares"),
    "propeller_forces.thrust_phases",
)
# By command, perhaps with an option that changes it: sections and fields that it uses, and that it does not.
# The longer name decides; a name may begin with any section, "*.".
USES: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "throw": ((*THROW, "material"), ()),
    "stress": (THROW + ELASTIC[1:], ()),
    "formulas": ((*THROW, *ELASTIC), ()),
    "lookup": ((*THROW, "material"), ()),
    "lookup law": ((*THROW, *ELASTIC), ()),
    "draw": ((*THROW, "engine.name"), ()),
    "draw --shaft": ((*SHAFT, "engine.name"), ()),
    "export": (THROW, ()),
    "export --calculix": ((*THROW, "material"), ()),
    "export --shaft": (SHAFT, ()),
    "plan": (STUDY, ()),
    "doe": (STUDY, ()),
    "designs": (STUDY, ()),
    "mechanism": ((*MECHANISM, "throw", "material.density"), (*RUNNING, POLES)),
    "harmonics": ((*MECHANISM, "throw.crank_radius"), (*RUNNING, "engine.rated_power", POLES)),
    "two-mass": (
        ("two_mass_check", "torque", "vibration.highest_order", "engine"),
        ("engine.bore", "engine.stroke", "engine.rated_power", POLES),
    ),
    "vibration": ((ALL, "strength.tensile_strength"), (*RUN_ALONE, *WHOLE, *CLASS_ALONE, SKIRT)),
    "vibration --coupled": ((ALL, "strength.tensile_strength"), (*RUN_ALONE, *CLASS_ALONE, SKIRT)),
    "vibration of a chain": ((ALL,), ("chain.dashpots", *(f"*.{name}" for name in FREE))),
    "class": ((ALL, "strength.tensile_strength"), (*RUN_ALONE, *WHOLE, SKIRT)),
    "run": ((ALL,), CLASS_ALONE),
    "optimum": ((*THROW, "material"), ()),
    "optimum of frequencies": ((ALL, "vibration.reciprocating"), UNFORCED),
    "optimum --first_axial_frequency": ((ALL,), (*UNFORCED, *TORSIONAL_ALONE)),
    "optimum --first_torsional_frequency": (
        (ALL, "vibration.reciprocating"),
        (*UNFORCED, *AXIAL_ALONE),
    ),
}


# Of commands that take a saved model in place of sources.
WITH_MODEL = " --model"


def command_use(name: str, arguments: Mapping[str, Any]) -> str:
    """Return what a command is called in `not_used`, by the name of its function, with these arguments."""
    command = called(name)
    if command == "lookup":
        return "lookup law" if str(arguments["model"]) == "law" else command
    if command == "optimum":
        return _optimum_use(**arguments)
    with_option = (f"{command} --{option}" for option, value in arguments.items() if value)
    key = next((key for key in with_option if key in USES), command)
    return key + WITH_MODEL if command in ("run", "vibration") and arguments["model"] else key


def _optimum_use(
    vary: object, minimize: str, limits: Iterable[str] | None, **others: object
) -> str:
    """Return the key of a search by the frequencies that it calculates: with `vary` both or none."""
    texts = " ".join([minimize, *(limits or ())])
    names = ("first_axial_frequency", "first_torsional_frequency")
    asked = [name for name in names if others[name] or (vary and name in texts)]
    if not asked:
        return "optimum"
    return f"optimum --{asked[0]}" if len(asked) == 1 and not vary else "optimum of frequencies"


def not_used(content: TomlFile, command: str) -> tuple[str, ...]:
    """Name what a file has that a command does not use: sections as a whole, else single fields.

    Parameters
    ----------
    command : str
        Its name, perhaps with an option that changes what it uses, as "draw --shaft", and with " --model".
    """
    command, with_model, _ = command.partition(WITH_MODEL)
    key = f"{command} of a chain" if file_kind(content) == "chain" else command
    if key not in USES:  # the command refuses the file
        return ()
    used, without = USES[key]
    if WHOLE[0] in without and "plant" in content.sections.get("shaft_line", {}):
        without += ROTATING  # which the plant's chain has; only the whole crankshaft takes them
    if with_model:
        without += ("vibration.model",)
    if command == "run" and (with_model or "model" in content.sections.get("vibration", {})):
        without += ("study",)  # for which the saved model stands
    limits = content.sections.get("limits", {}).keys()
    if "crankshaft_stress" in limits:
        without += STEEL
    if {"crankshaft_stress", "tensile_strength"} & limits and not command.startswith("run"):
        without += ("strength.tensile_strength",)
    if command == "class" and not AXIAL_LIMITS & limits:
        without += TO_JUDGE_AXIAL
    if content.sections.get("vibration", {}).get("reciprocating", "half") == "half":
        without += ("rod.length",) if "vibration.reciprocating" in used else ()
    names: list[str] = []
    for section, values in content.sections.items():
        fields = list(_fields(section, values))
        unused = [name for name in fields if _longest(name, without) >= _longest(name, used)]
        names += [section] if unused and len(unused) == len(fields) else unused
    return tuple(dict.fromkeys(names))


def not_used_of(source: str, command: str) -> tuple[str, ...] | None:
    """Name what is not used of a file or a shipped one, as a file with sections has it; None if unread."""
    try:
        content = any_sections(source)
        if content is not None:
            return not_used(content, command)
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
    return max((len(place) for place in places if _is_under(name, place)), default=0)


def _is_under(name: str, place: str) -> bool:
    if place.startswith("*."):
        return name.endswith(place[1:])
    return place == ALL or name == place or name.startswith(f"{place}.")
