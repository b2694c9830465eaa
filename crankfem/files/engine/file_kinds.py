"""The kind of a file of quantities, from its sections; the shipped files and the template for new ones."""

import math
import re
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Literal

from crankbase.errors import InputError
from crankbase.input_file import LOOKED_AT, InputFile
from crankfem.files.reading.data_files import FOLDERS, InputKind, input_path, shipped_names
from crankfem.files.reading.toml_file import TomlFile, read_toml
from crankfem.files.sections.engine_sections import TorqueTable
from dynamics.engine.layout import firing_order_from_text

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
    """
    content = source if isinstance(source, TomlFile) else read_toml(input_path(source))
    if file_kind(content) == "hinge":
        raise InputError(f"{content.path.name}: describes an elastic hinge; use it with hinge.")
    return replace(content, records=[])


def any_sections(file: str) -> TomlFile | None:
    """Return the sections of any file of input, or of a shipped one; None if it is the text of a chain."""
    name = Path(file).name.removesuffix(".toml")
    others: tuple[InputKind, ...] = ("hinge", "chain")
    kinds = [kind for kind in others if name in shipped_names(kind)]
    path = input_path(file, *kinds[:1])
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
    section = content.model("torque", TorqueTable)
    return None if section is None else content.files.named("torque.table", section.table, "tables")


# Orders in which cylinders in line usually fire, by strokes per cycle; the cranks follow from them, for
# firing is even.
FIRING_ORDERS: dict[int, dict[int, tuple[int, ...]]] = {
    strokes: {len(order): order for order in map(firing_order_from_text, orders.split())}
    for strokes, orders in (
        (4, "1 1-2 1-3-2 1-3-4-2 1-2-4-5-3 1-5-3-6-2-4 1-3-5-7-6-4-2 1-6-2-5-8-3-7-4"),
        (2, "1 1-2 1-3-2 1-3-2-4 1-4-3-2-5 1-5-3-4-2-6 1-7-2-5-4-3-6 1-8-3-4-7-2-5-6"),
    )
}


def engine_template(file: str = "mine.toml", cylinders: int = 6, strokes: int = 4) -> str:
    """Return the text of an engine file that can be run unchanged.

    Parameters
    ----------
    file : str
        Its name, for the commands in it.
    cylinders : int
        In line.
    strokes : int
        Per cycle, 2 or 4.
    """
    if strokes not in FIRING_ORDERS:
        raise InputError(
            f"--strokes: given {strokes}; allowed are 2 and 4, because cycles have as many strokes."
        )
    known = FIRING_ORDERS[strokes]
    if cylinders not in known:
        raise InputError(
            f"--cylinders: given {cylinders}; allowed is 1 to {max(known)}, because for these in line the "
            "firing order is usual; write any other into the file."
        )
    order = known[cylinders]
    angles = crank_angles_deg(order, strokes)
    counted = "cylinder" if cylinders == 1 else "cylinders"
    return Template(_text()).substitute(
        title=f"{cylinders} {counted} in line, {strokes}-stroke",
        file=file,
        name=f"Example, {cylinders} {counted}",
        cylinders=cylinders,
        strokes=strokes,
        thrust=cylinders + 1,
        crank_angles=", ".join(f'"{angle:.10g} deg"' for angle in angles),
        firing_order=", ".join(map(str, order)),
    )


def crank_angles_deg(firing_order: tuple[int, ...], strokes: int) -> list[float]:
    """Return the angle of each crank from the first in the sense of rotation [deg].

    With these the firing intervals are even.

    Examples
    --------
    >>> crank_angles_deg((1, 5, 3, 6, 2, 4), 4)
    [0.0, 240.0, 120.0, 120.0, 240.0, 0.0]
    """
    cycle = 180.0 * strokes
    angles = [math.nan] * len(firing_order)
    for place, cylinder in enumerate(firing_order):
        # A cylinder that fires later has its crank so much behind the first.
        angles[cylinder - 1] = round(-place * cycle / len(firing_order) % 360.0, 9) % 360.0
    return angles


def _text() -> str:
    return files("crankfem.files.engine").joinpath("template.toml").read_text(encoding="utf-8")


@dataclass(frozen=True)
class ShippedFile:
    """A shipped file: its name, what it describes, a line about it."""

    name: str
    kind: FileKind
    about: str
    path: Path


def shipped_files() -> tuple[ShippedFile, ...]:
    """Return all shipped files, engines first."""
    paths = [input_path(name, kind) for kind in FOLDERS for name in shipped_names(kind)]
    return tuple(
        ShippedFile(path.stem, file_kind(read_toml(path)), _about(path), path) for path in paths
    )


def _about(path: Path) -> str:
    """Return the first sentence of the comment at the head of a file."""
    words = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#") or line.startswith("#  "):
            break
        words.append(line.removeprefix("#").strip())
    return " ".join(words).partition(". ")[0].partition("; ")[0].rstrip(".")
