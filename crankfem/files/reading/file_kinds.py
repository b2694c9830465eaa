"""What a file of quantities describes, from its sections: a throw, a mechanism, a whole engine."""

from collections.abc import Collection

from crankbase.errors import InputError
from crankfem.files.reading.toml_file import TomlFile

# Every section of engine files, and whether a whole engine needs it.
REQUIRED = {
    "engine": True,
    "throw": True,
    "throws": False,
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


def check_sections(content: TomlFile, needed: Collection[str] | None = None) -> None:
    """Refuse unknown and missing sections; [throws.NAME] may stand in place of [throw].

    Parameters
    ----------
    content : TomlFile
    needed : collection of str, optional
        Sections that must be there; those of a whole engine by default.

    Raises
    ------
    InputError
    """
    allowed = {
        name: required if needed is None else name in needed for name, required in REQUIRED.items()
    }
    named = "throws" in content.sections
    content.check_sections(allowed | {"throw": allowed["throw"] and not named})
    if named and "throw" in content.sections:
        raise InputError(
            "throws: given beside the section [throw]; allowed is one of the two, because every crank is "
            "the one throw or a named one."
        )


def describes_a_throw(content: TomlFile) -> bool:
    """Tell whether a file describes throws, and nothing of an engine around them."""
    sections = content.sections
    given = "throw" in sections or "throws" in sections
    return given and not any(name in sections for name in ENGINE_SECTIONS)


def describes_mechanism(content: TomlFile) -> bool:
    """Tell whether a file describes cranks, rods and pistons, but no engine for the chains."""
    sections = content.sections
    return {"engine", "rod", "piston"} <= set(sections) and not any(
        name in sections for name in ("flywheel", "thrust_bearing")
    )
