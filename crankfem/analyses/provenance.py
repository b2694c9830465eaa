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
from typing import Annotated

from crankbase.input_file import LARGEST_TABLE_FILE, InputFile
from crankbase.results import Quantity, Result, result
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


@result("version", "created")
class Provenance(Result):
    """Provenance of numbers: program, libraries by their versions, machine and time."""

    program: str
    version: str
    created: str
    units: str
    python: str
    platform: str
    processors: int
    packages: dict[str, str | None]


def provenance() -> Provenance:
    """Return the provenance of what is calculated now."""
    return Provenance(
        "crankfem",
        program_version(),
        datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        "SI: m, N, Pa, kg, s, rad; Hz for frequencies, 1/min where a name ends in _rpm, deg where "
        "it ends in _deg; the unit of each number is given under units",
        f"{platform.python_implementation()} {platform.python_version()}",
        platform.platform(),
        os.cpu_count() or 1,
        {name: installed_version(name) for name in PACKAGES},
    )


def program_version() -> str:
    """Version of crankfem; of a checkout that is not installed, that in its project file."""
    try:
        return version("crankfem")
    except PackageNotFoundError:
        project = Path(__file__).resolve().parents[2] / "pyproject.toml"
        try:
            number = tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"]
        except (OSError, KeyError, tomllib.TOMLDecodeError):
            return "development checkout"
        return f"{number}, development checkout"


@result("name", "sha256")
class UsedFile(Result):
    """A file that a run has read: its name relative to the engine file, its text unless very long."""

    name: str
    sha256: str
    text: str | None


@result("command")
class Repetition(Result):
    """What repeats a run: its command and its files, the engine file first."""

    command: str
    files: tuple[UsedFile, ...]
    seconds: Annotated[dict[str, float], Quantity("s", "of each step")]


def repetition(
    files: Sequence[UsedFile], seconds: Mapping[str, float], model: str | None = None
) -> Repetition:
    """Return what repeats a run, with the saved compliance model that an option gives."""
    option = "" if model is None else f" --model {shlex.quote(model)}"
    return Repetition(run_command(files[0].name) + option, tuple(files), dict(seconds))


def used_files(files: Sequence[InputFile]) -> tuple[UsedFile, ...]:
    """Read the files of a run, the engine file first, in their present state."""
    used = []
    folders = [folder.absolute() for folder in (files[0].path.parent, data_folder() / "tables")]
    for file in files:
        content = file.content(LARGEST_TABLE_FILE, "an input file")
        text = content.decode("utf-8", errors="replace")
        quoted = text if len(text) <= LONGEST_QUOTED else None
        # With its folders; a shipped table without.
        path = file.path.absolute()
        inside = [path.relative_to(folder) for folder in folders if path.is_relative_to(folder)]
        name = (inside[0] if inside else file.path).as_posix()
        used.append(UsedFile(name, hashlib.sha256(content).hexdigest(), quoted))
    return tuple(used)


def run_command(name: str) -> str:
    """Return the command that runs an engine file, as a shell reads it.

    Examples
    --------
    >>> run_command("my engine.toml")
    "crankfem run 'my engine.toml'"
    """
    # What begins with a dash would be taken for an option.
    return f"crankfem run {shlex.quote(f'./{name}' if name.startswith('-') else name)}"


def installed_version(name: str) -> str | None:
    """Version of a package; None if it is not installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None
