"""Provenance of a run: versions, machine, times, and how to repeat it."""

import datetime
import hashlib
import os
import platform
import shlex
import tomllib
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from crankbase.input_file import LARGEST_TABLE_FILE, InputFile
from crankfem.analyses.record import Record
from crankfem.files.reading.data_files import data_folder

# Packages whose versions a result may depend on.
PACKAGES = (
    "scikit-fem",
    "gmsh",
    "meshio",
    "numpy",
    "scipy",
    "pypardiso",
    "pyvista",
    "matplotlib",
    "plotly",
    "pint",
    "pydantic",
)
# Longer tables are named with their digest, but not quoted.
LONGEST_QUOTED = 200_000


def provenance_record() -> Record:
    """Provenance of the numbers: program, libraries and time."""
    return {
        "program": "crankfem",
        "version": program_version(),
        "created": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        "units": "SI: m, N, Pa, kg, s, rad; Hz for frequencies, 1/min where a name ends in _rpm, deg where "
        "it ends in _deg; the unit of each number is given under units",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "platform": platform.platform(),
        "processors": os.cpu_count() or 1,
        "packages": {name: _installed(name) for name in PACKAGES},
    }


def program_version() -> str:
    """Version of crankfem; of a checkout that is not installed, that in its project file."""
    try:
        return version("crankfem")
    except PackageNotFoundError:
        project = Path(__file__).resolve().parents[2] / "pyproject.toml"
        try:
            found = tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"]
        except (OSError, KeyError, tomllib.TOMLDecodeError):
            return "development checkout"
        return f"{found}, development checkout"


def repeat_record(
    files: Sequence[Record], seconds: Mapping[str, float], model: str | None = None
) -> Record:
    """Return the data needed to repeat a run.

    Parameters
    ----------
    files : sequence of dict
        The files that were read, the engine file first; see `file_records`.
    seconds : mapping
        Step of the run to the time it took [s].
    model : str, optional
        Saved compliance model given by an option.

    Returns
    -------
    dict
        "command", "files", "seconds".
    """
    return {
        "command": run_command(files[0]["name"])
        + ("" if model is None else f" --model {shlex.quote(model)}"),
        "files": list(files),
        "seconds": dict(seconds),
    }


def file_records(files: Sequence[InputFile]) -> list[Record]:
    """Read the files of a run in their present state.

    Parameters
    ----------
    files : sequence of InputFile
        Those that were read, the engine file first.

    Returns
    -------
    list of dict
        "name", relative to the engine file; "sha256"; "text", None if it is very long.
    """
    return [_file_record(file, _relative_name(files[0].path, file.path)) for file in files]


def run_command(name: str) -> str:
    """Return the command that runs an engine file, as a shell reads it.

    Examples
    --------
    >>> run_command("my engine.toml")
    "crankfem run 'my engine.toml'"
    """
    # What begins with a dash would be taken for an option.
    return f"crankfem run {shlex.quote(f'./{name}' if name.startswith('-') else name)}"


def _relative_name(engine_file: Path, path: Path) -> str:
    """Name of a file for use in the engine file: with its folders, a shipped table without."""
    for folder in (engine_file.parent, data_folder() / "tables"):
        if path.absolute().is_relative_to(folder.absolute()):
            return path.absolute().relative_to(folder.absolute()).as_posix()
    return path.as_posix()


def _file_record(file: InputFile, name: str) -> Record:
    content = file.content(LARGEST_TABLE_FILE, "an input file")
    text = content.decode("utf-8", errors="replace")
    return {
        "name": name,
        "sha256": hashlib.sha256(content).hexdigest(),
        "text": text if len(text) <= LONGEST_QUOTED else None,
    }


def _installed(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
