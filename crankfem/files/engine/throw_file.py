"""Read only the throws of a file: one throw, a whole crankshaft, the plan of a study."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from crankbase.errors import InputError
from crankfem.files.engine.file_kinds import check_sections, engine_sections
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.reading.toml_file import InputRecord, TomlFile, sections_of
from crankfem.files.sections.crank_throws import (
    PLAIN,
    ShaftLayout,
    Throws,
    free_end_throw_name,
    read_throws,
    throw_names,
    throw_of_name,
    throws_along_shaft,
)
from fem.material import STEEL, Material
from geometry.any_throw import Throw

if TYPE_CHECKING:
    from geometry.crankshaft import Crankshaft
    from regression.plans.plan import StudyPlan


def load_throw(path: str | Path | TomlFile, name: str | None = None) -> tuple[Throw, Material]:
    """Read only a throw and its material from an engine or study file.

    Parameters
    ----------
    path : path
        The file, or the name of a shipped engine.
    name : str, optional
        Of a throw in a file with sections [throws.NAME]; that at the free end by default.

    Raises
    ------
    InputError
    """
    content, throws = _throws(path)
    throw = throw_of_name(throws, name, "throw", _first(content, throws))
    return throw, content.model("material", Material) or STEEL


def names_of_throws(path: str | Path | TomlFile) -> tuple[str, ...]:
    """Return the names of the throws in a file, first that at the free end; "throw" for a plain file."""
    content, throws = _throws(path)
    first = _first(content, throws)
    return (first, *(name for name in throws if name != first))


def unused_throws(path: str | Path | TomlFile, name: str | None) -> list[str]:
    """Name the sections of throws, or their fields, that a throw is not made of; it may be like another one.

    Parameters
    ----------
    name : str or None
        Of the throw; that at the free end by default.
    """
    sections = engine_sections(path).sections
    throws = tables_of_throws(sections)
    if name is None:
        along = sections.get("shaft", {}).get("throws")
        names = map(str, along) if isinstance(along, list) else iter(throws)
        name = next((each for each in names if each in throws), PLAIN)
    throw = throws.get(str(name), {})
    base = str(throw.get("like"))
    unused = [f"throws.{other}" for other in throws if other not in (name, base, PLAIN)]
    return [*unused, *_replaced(f"throws.{base}", throws.get(base, {}), throw)]


def tables_of_throws(sections: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return the tables of the throws by name, that of the section [throw] as "throw"."""
    plain = {PLAIN: sections[PLAIN]} if PLAIN in sections else {}
    named = {name: table for name, table in sections.get("throws", {}).items() if name != PLAIN}
    return {name: table for name, table in (named | plain).items() if isinstance(table, Mapping)}


def _replaced(section: str, base: Mapping[str, Any], throw: Mapping[str, Any]) -> Iterator[str]:
    """Name the fields of a throw in whose place those of one that is like it stand."""
    for field, value in throw.items():
        if isinstance(value, Mapping) and isinstance(base.get(field), Mapping):
            yield from _replaced(f"{section}.{field}", base[field], value)
        elif field in base:
            yield f"{section}.{field}"


@dataclass(frozen=True)
class ThrowFile:
    """A file that describes a throw alone, read and checked.

    Attributes
    ----------
    throws : dict
        Its throws by name; "throw" is that of a plain file.
    throw : CrankThrow or ImportedThrow
        The first of them along the shaft.
    records : tuple of InputRecord
        Every value with its source.
    """

    path: Path
    throws: dict[str, Throw]
    throw: Throw
    material: Material
    records: tuple[InputRecord, ...]


def load_throw_file(path: str | Path | TomlFile) -> ThrowFile:
    """Read and check a file that describes a throw alone."""
    from crankfem.files.sections.engine_sections import Engine
    from crankfem.files.study_file import study_plan
    from geometry.crankshaft import ShaftEnds

    read = engine_sections(path)
    with read.all_errors({"engine": Engine}):
        content, throws = _throws(read)
        material = content.model("material", Material) or STEEL
        content.model("engine", Engine)
        first = free_end_throw_name(throws, content.model("shaft", ShaftLayout))
        content.model("shaft_ends", ShaftEnds)
        study_plan(content, throws, first, material)
        return ThrowFile(content.path, throws, throws[first], material, tuple(content.records))


def load_crankshaft(path: str | Path | TomlFile) -> "Crankshaft":
    """Read the whole crankshaft of an engine file: its throws at their angles, and the ends.

    The angles are ``throw_angles`` of the section [shaft], or the crank angles of [engine].

    Raises
    ------
    InputError
        Also if the file has neither.
    """
    from crankfem.files.sections.engine_sections import Engine
    from geometry.crankshaft import Crankshaft, ShaftEnds

    content, throws = _throws(path)
    layout = content.model("shaft", ShaftLayout)
    if layout is not None and layout.throw_angles is not None:
        angles = layout.throw_angles
    else:
        engine = content.model("engine", Engine)
        if engine is None:
            raise InputError(
                f"{content.path.name}: the angles of the throws are missing; allowed is throw_angles in a "
                "section [shaft], or crank_angles in [engine]."
            )
        pins = max(len(throw.pin_axes) for throw in throws.values())
        if pins > 1:
            raise InputError(
                f"{content.path.name}: a throw has {pins} pins, so the crank angles "
                "of [engine] are not those of the throws; give throw_angles in a section [shaft]."
            )
        angles = engine.crank_angles
    ends = content.model("shaft_ends", ShaftEnds) or ShaftEnds()
    names = throw_names(throws, layout, len(angles))
    return Crankshaft(
        throws_along_shaft(throws, names, np.degrees(angles)),
        crank_angles_deg=np.degrees(angles).tolist(),
        ends=ends,
    )


def load_study(path: str | Path | TomlFile | Mapping[str, Any]) -> "StudyPlan":
    """Read the plan of a study from a file with the sections [throw] and [study], or from these."""
    from crankfem.files.study_file import study_plan

    if isinstance(path, Mapping):
        path = sections_of(InputFiles(Path("study")), dict(path))
    content, throws = _throws(path, "study")
    first = _first(content, throws)
    plan = study_plan(content, throws, first, content.model("material", Material) or STEEL)
    assert plan is not None  # the section has been made sure of
    return plan


def _throws(path: str | Path | TomlFile, *needed: str) -> tuple[TomlFile, dict[str, Throw]]:
    """Sections of a file with a throw and other required sections, and its throws by name."""
    content = engine_sections(path)
    readers = {"throw": read_throws, "throws": read_throws}
    with content.all_errors({"material": Material}, readers):
        check_sections(content, ["throw", *needed])
        return content, read_throws(content)


def _first(content: TomlFile, throws: Throws) -> str:
    """Name of the throw at the free end; the section [shaft] of a plain file is ignored."""
    layout = None if PLAIN in throws else content.model("shaft", ShaftLayout)
    return free_end_throw_name(throws, layout)
