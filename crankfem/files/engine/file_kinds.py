"""The kind of a file of quantities, from its sections: a throw, a mechanism, an engine; its torques."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Literal

from crankbase.errors import InputError
from crankbase.input_file import LOOKED_AT, InputFile
from crankfem.files.reading.data_files import InputKind, input_path, shipped_names
from crankfem.files.reading.toml_file import TomlFile, read_toml
from crankfem.files.sections.engine_sections import TorqueTable

FileKind = Literal["engine", "mechanism", "throw", "hinge", "chain"]
# A file with none of these is not meant as a whole engine.
ENGINE_SECTIONS = {"rod", "piston", "flywheel", "thrust_bearing"}
# Sections that only hinge files have.
HINGE_SECTIONS = {"sliding", "hinge", "operation"}

# A section that files of input have, at the beginning of a line.
SECTION = re.compile(r"^\s*\[(?:engine|throw|throws\.\w+|chain|sliding|hinge)\]", re.MULTILINE)


def file_kind(content: TomlFile) -> FileKind:
    """Return the kind of a file, from its sections.

    A throw has no engine around it; a mechanism has cranks, rods and pistons, but no flywheel
    or thrust bearing for the chains.
    """
    sections = set(content.sections)
    if "chain" in sections:
        return "chain"
    if "throw" not in sections and sections & HINGE_SECTIONS:
        return "hinge"
    if sections & {"throw", "throws"} and not sections & ENGINE_SECTIONS:
        return "throw"
    if {"engine", "rod", "piston"} <= sections and not sections & {"flywheel", "thrust_bearing"}:
        return "mechanism"
    return "engine"


def engine_sections(source: str | Path | TomlFile) -> TomlFile:
    """Return the sections of an engine file, or of a shipped engine.

    Parameters
    ----------
    source : path or TomlFile
        Sections that have been read already are not read again, so that a command uses them in
        one state of the file. Their records start anew.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or describes an elastic hinge.
    """
    content = source if isinstance(source, TomlFile) else read_toml(input_path(source))
    if file_kind(content) == "hinge":
        raise InputError(f"{content.path.name}: describes an elastic hinge; use it with hinge.")
    return replace(content, records=[])


def any_sections(given: str) -> TomlFile | None:
    """Return the sections of any file of input, or of a shipped one; None if it is the text of a chain.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read, or has the ending of TOML but is not.
    """
    name = Path(given).name.removesuffix(".toml")
    others: tuple[InputKind, ...] = ("hinge", "chain")
    kinds = [kind for kind in others if name in shipped_names(kind)]
    path = input_path(given, *kinds[:1])
    return read_toml(path) if path.suffix.lower() == ".toml" or _has_sections(path) else None


def _has_sections(path: Path) -> bool:
    """Whether a file has sections of input, whatever its ending; False where it cannot be read."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            return SECTION.search(file.read(LOOKED_AT)) is not None
    except (OSError, UnicodeDecodeError):
        return False


def torque_table_file(content: TomlFile) -> InputFile | None:
    """Return the torque table that a file names, if it names one."""
    given = content.model("torque", TorqueTable)
    return None if given is None else content.files.named("torque.table", given.table, "tables")
