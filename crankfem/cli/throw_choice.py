"""The throw of a file that a command uses."""

from collections.abc import Sequence
from pathlib import Path

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.files.engine.throw_file import load_throw, names_of_throws
from crankfem.files.reading.toml_file import TomlFile
from fem.material import STEEL, Material
from geometry.imported import import_throw
from geometry.mesher import Throw
from geometry.solid_files import STEP_ENDINGS
from geometry.throw import CrankThrow


def select_throw(
    engine: str | TomlFile, name: str | None = None, quiet: bool = False
) -> tuple[CrankThrow, Material]:
    """Select the throw of a name; by default that at the free end, with a note if there are others.

    Parameters
    ----------
    engine : str or TomlFile
        File, or the name of a shipped engine; or its sections, if already read.
    name : str, optional
        From `--throw`.
    quiet : bool
        Whether to omit notes.

    Raises
    ------
    InputError
    """
    if name is None:
        first, *others = names_of_throws(engine)
        if others:
            console.print_note(
                f"Note: throw {first} is used; the file has {', '.join(others)} too.", quiet
            )
    return load_throw(engine, name)


def select_part(
    engine: str, name: str | None, pins: Sequence[str] | None, quiet: bool = False
) -> tuple[Throw, Material]:
    """Select a throw of a file, or read a CAD part of steel from a STEP file.

    Parameters
    ----------
    engine : str
        File, or the name of a shipped engine.
    name : str, optional
        From `--throw`, for files of dimensions.
    pins : sequence of str, optional
        Names of the pins' faces, for STEP files.
    quiet : bool
        Whether to omit notes.

    Raises
    ------
    InputError
    """
    if Path(engine).suffix.lower() not in STEP_ENDINGS:
        if pins:
            raise InputError(
                f"--pin: given {pins[0]!r}; allowed only with a STEP file, whose faces have names."
            )
        return select_throw(engine, name, quiet)
    if name is not None:
        raise InputError(
            f"--throw: given {name!r} with a STEP file; allowed only with a TOML file, because a part is one "
            "throw."
        )
    part = import_throw(engine, pins=pins or ("pin",))
    for remark in part.remarks:
        console.print_note(remark, quiet)
    return part, STEEL
