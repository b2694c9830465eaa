"""What a run was made with: versions, machine, times, and how to repeat it."""

import datetime
import hashlib
import os
import platform
import tomllib
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from crankfem.record import Record

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


def about_record() -> Record:
    """Which program made the numbers, with what, and when."""
    return {
        "program": "crankfem",
        "version": program_version(),
        "created": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        "units": "SI: m, N, Pa, kg, s, rad; Hz for frequencies, 1/min where a name ends in _rpm",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "platform": platform.platform(),
        "processors": os.cpu_count() or 1,
        "packages": {name: _installed(name) for name in PACKAGES},
    }


def program_version() -> str:
    """Version of crankfem; of a checkout that is not installed, what its project file says."""
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
    engine_file: Path, others: Iterable[Path], seconds: Mapping[str, float]
) -> Record:
    """What is needed to repeat a run.

    Parameters
    ----------
    engine_file : Path
    others : iterable of Path
        Further files that were read.
    seconds : mapping
        Step of the run to the time it took [s].

    Returns
    -------
    dict
        "command", "files" (name, sha256, and the text unless it is very long), "seconds".
    """
    return {
        "command": f"crankfem run {_quoted(engine_file.name)}",
        "files": [_file_record(path) for path in dict.fromkeys((engine_file, *others))],
        "seconds": dict(seconds),
    }


def _file_record(path: Path) -> Record:
    content = path.read_bytes()
    text = content.decode("utf-8", errors="replace")
    return {
        "name": path.name,
        "sha256": hashlib.sha256(content).hexdigest(),
        "text": text if len(text) <= LONGEST_QUOTED else None,
    }


def _quoted(name: str) -> str:
    return f'"{name}"' if " " in name else name


def _installed(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
