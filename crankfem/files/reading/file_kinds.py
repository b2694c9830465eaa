"""What a file of quantities describes, from its sections: a throw, a mechanism, a whole engine."""

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from crankbase.errors import InputError
from crankfem.files.reading.data_files import (
    chain_path,
    engine_path,
    hinge_path,
    shipped_chains,
    shipped_hinges,
)
from crankfem.files.reading.toml_file import TomlFile, read_toml

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
# Sections that only hinge files have.
HINGE_SECTIONS = frozenset(("sliding", "hinge", "operation"))


def engine_sections(source: str | Path | TomlFile) -> TomlFile:
    """Return the sections of an engine file, or of a shipped engine.

    Parameters
    ----------
    source : path or TomlFile
        Sections that have been read already are not read again: what a command takes from them is then of
        one state of the file. Their records begin anew.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or describes an elastic hinge.
    """
    content = source if isinstance(source, TomlFile) else read_toml(engine_path(source))
    if describes_a_hinge(content):
        raise InputError(f"{content.path.name}: describes an elastic hinge; use it with hinge.")
    return replace(content, records=[])


def any_sections(given: str) -> TomlFile | None:
    """Return the sections of any file of input, or of a shipped one; None if it is not TOML.

    Only chains are written in anything but TOML.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, or is not TOML though it is called so.
    """
    path = Path(given)
    if path.is_file():
        return read_toml(path) if path.suffix.lower() == ".toml" else None
    name = path.name.removesuffix(".toml") if path.parent == Path() else ""
    for shipped, find in ((shipped_hinges, hinge_path), (shipped_chains, chain_path)):
        if name in shipped():
            return read_toml(find(given))
    return engine_sections(given)


def describes_a_chain(content: TomlFile) -> bool:
    """Tell whether a file describes a chain."""
    return "chain" in content.sections


def describes_a_hinge(content: TomlFile) -> bool:
    """Tell whether a file describes an elastic hinge."""
    sections = content.sections
    return "throw" not in sections and not HINGE_SECTIONS.isdisjoint(sections)


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
