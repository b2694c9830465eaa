"""Locations of the shipped engines and tables, in the wheel and in a checkout."""

import os
from pathlib import Path
from typing import Literal

from crankbase.checks.choices import did_you_mean
from crankbase.errors import InputError, quoted
from crankbase.wrong_files import not_a_file

InputKind = Literal["engine", "hinge", "chain"]
# Of each kind of input the folder of those that are shipped, and how a message calls a file.
FOLDERS: dict[InputKind, str] = {"engine": "engines", "hinge": "hinges", "chain": "chains"}
WORDS = {"engine": "an engine file", "hinge": "a hinge file", "chain": "a chain file"}


def data_folder() -> Path:
    """Return the folder of shipped data."""
    here = Path(__file__).resolve().parents[2]
    inside = here / "data"
    return inside if inside.is_dir() else here.parent / "data"


def shipped_names(*kinds: InputKind) -> tuple[str, ...]:
    """Return the names of the shipped files of some kinds, or of all."""
    return tuple(
        name
        for kind in kinds or FOLDERS
        for name in sorted(path.stem for path in (data_folder() / FOLDERS[kind]).glob("*.toml"))
    )


def shipped_torques() -> tuple[str, ...]:
    """Return the names of the shipped torque tables."""
    return tuple(sorted(path.name for path in (data_folder() / "tables").glob("*torque*.csv")))


def input_path(given: str | Path, kind: InputKind = "engine") -> Path:
    """Find a file of input by path, or a shipped one by name.

    Raises
    ------
    InputError
        If there is neither.
    """
    if not isinstance(given, (str, os.PathLike)):
        raise InputError(
            f"file: given {quoted(given)}; allowed is the path of {WORDS[kind]}, or the name of a shipped "
            "one."
        )
    path = Path(given)
    try:
        if path.is_file():
            return path
        shipped = data_folder() / FOLDERS[kind] / f"{path.name.removesuffix('.toml')}.toml"
        if path.parent == Path() and shipped.is_file():
            return shipped
        fault = f"{given}: {not_a_file(path) or 'does not exist'}"
    except OSError as error:
        fault = f"{given}: cannot be searched for; the system reports: {error.strerror}"
    others = [one for one in FOLDERS if one != kind and path.name in shipped_names(one)]
    if others:
        fault = f"{given}: is {WORDS[others[0]].replace(' file', '')}, not {WORDS[kind]}"
    if not str(given).strip():
        fault = '"": names no file'
    meant = did_you_mean(path.name.removesuffix(".toml"), shipped_names(kind), cutoff=0.7)
    raise InputError(
        f"{fault}; {meant}give the path of {WORDS[kind]}, or the name of a shipped one "
        f"({', '.join(shipped_names(kind))})."
    )


def torque_path(given: str | Path) -> Path:
    """Find a torque table by path, or a shipped one by the name of its file.

    Raises
    ------
    InputError
        If there is neither.
    """
    path = Path(given)
    shipped = data_folder() / "tables" / path.name
    if path.is_file() or path.parent != Path() or path.name not in shipped_torques():
        return path
    return shipped


def find_table(field: str, beside: Path, name: str) -> Path:
    """Find a table in the folder of the file that names it, or a shipped one.

    Parameters
    ----------
    field : str
        The field that names it, for the message.
    beside : Path
        The file that names it.
    name : str
        Of the table's file.

    Raises
    ------
    InputError
        If there is neither.
    """
    for path in (beside.parent / name, data_folder() / "tables" / name):
        if path.is_file():
            return path
        if (entry := not_a_file(path)) is not None:
            raise InputError(f"{field}: given {name!r}, which {entry}.")
    raise InputError(
        f"{field}: given {name!r}, which is neither in the folder of {beside.name} nor a shipped table."
    )
