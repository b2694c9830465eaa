"""What a file of quantities describes, from its sections: a throw, a mechanism, a whole engine."""

from crankfem.files.reading.toml_file import TomlFile

# Every section of engine files, and whether a whole engine needs it.
REQUIRED = {
    "engine": True,
    "throw": True,
    "shaft": False,
    "shaft_ends": False,
    "material": False,
    "rod": True,
    "piston": True,
    "hinged_rods": False,
    "flywheel": True,
    "free_end": False,
    "thrust_bearing": True,
    "damping": False,
    "torsional_damper": False,
    "axial_damper": False,
    "driven": False,
    "bearings": False,
    "shaft_line": False,
    "gas": False,
    "gas_map": False,
    "misfire": False,
    "propeller_forces": False,
    "limits": False,
    "ranges": False,
    "vibration": False,
    "torque": False,
    "two_mass_check": False,
    "study": False,
}

# A file with none of these is not meant as a whole engine.
ENGINE_SECTIONS = ("rod", "piston", "flywheel", "thrust_bearing")


def describes_a_throw(content: TomlFile) -> bool:
    """Tell whether a file describes a throw, and nothing of an engine around it."""
    sections = content.sections
    return "throw" in sections and not any(name in sections for name in ENGINE_SECTIONS)


def describes_mechanism(content: TomlFile) -> bool:
    """Tell whether a file describes cranks, rods and pistons, but no engine for the chains."""
    sections = content.sections
    return {"engine", "rod", "piston"} <= set(sections) and not any(
        name in sections for name in ("flywheel", "thrust_bearing")
    )
