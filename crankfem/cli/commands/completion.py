"""What a shell completes: names of shipped files, files that fit, sections, dimensions of a model.

Nothing slow is loaded here, for the shell waits.
"""

from collections.abc import Callable, Iterable
from pathlib import Path

import typer

from crankfem.files.reading.data_files import (
    data_folder,
    shipped_chains,
    shipped_engines,
    shipped_hinges,
)

# Typer tells these functions apart by the names of their arguments.
Completion = Callable[[str], list[str]]


def engines(incomplete: str) -> list[str]:
    """Shipped engines, and TOML files."""
    return _fitting(incomplete, shipped_engines(), ".toml")


def engines_and_parts(incomplete: str) -> list[str]:
    """Shipped engines, TOML files and STEP files."""
    return _fitting(incomplete, shipped_engines(), ".toml", ".step", ".stp")


def engines_and_chains(incomplete: str) -> list[str]:
    """Shipped engines and chains, and files of both."""
    return _fitting(incomplete, (*shipped_engines(), *shipped_chains()), ".toml", ".txt")


def engines_and_tables(incomplete: str) -> list[str]:
    """Shipped engines and torque tables, and files of both."""
    tables = [path.name for path in (data_folder() / "tables").glob("*torque*.csv")]
    return _fitting(incomplete, (*shipped_engines(), *tables), ".toml", ".csv")


def hinges(incomplete: str) -> list[str]:
    """Shipped hinges, and TOML files."""
    return _fitting(incomplete, shipped_hinges(), ".toml")


def shipped(incomplete: str) -> list[str]:
    """Everything shipped that can be copied."""
    return _fitting(incomplete, (*shipped_engines(), *shipped_hinges(), *shipped_chains()))


def any_input(incomplete: str) -> list[str]:
    """Everything shipped, and files like it."""
    names = (*shipped_engines(), *shipped_hinges(), *shipped_chains())
    return _fitting(incomplete, names, ".toml", ".txt")


def files(*endings: str) -> Completion:
    """Return the completion of files with these endings, and of folders on the way to them."""

    def found(incomplete: str) -> list[str]:
        return _fitting(incomplete, (), *endings)

    return found


def sections(incomplete: str) -> list[str]:
    """Sections of engine files."""
    from crankfem.files.reading.file_kinds import REQUIRED

    return [name for name in REQUIRED if name.startswith(incomplete)]


def dimensions(ctx: typer.Context, incomplete: str) -> list[str]:
    """Dimensions that the model on the command line asks for, as the beginning of NAME=VALUE."""
    import json

    given = ctx.params.get("model")
    if given is None or "=" in incomplete:
        return []
    try:
        content = json.loads(Path(str(given)).read_text(encoding="utf-8"))
        factors = (name for one in content["responses"].values() for name in one["factors"])
        names = list(dict.fromkeys([*content["ranges"], *factors]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return []
    return [f"{name}=" for name in names if name.startswith(incomplete)]


def _fitting(incomplete: str, names: Iterable[str], *endings: str) -> list[str]:
    """Return the names and files that begin so; folders end in a slash."""
    folder, _, start = incomplete.rpartition("/")
    place = f"{folder}/" if folder or incomplete.startswith("/") else ""
    found = [name for name in names if name.startswith(incomplete)]
    try:
        entries = sorted(Path(place or ".").iterdir()) if endings else []
    except OSError:
        entries = []
    for entry in entries:
        if not entry.name.startswith(start) or (entry.name.startswith(".") and not start):
            continue
        if entry.is_dir():
            found.append(f"{place}{entry.name}/")
        elif entry.suffix.lower() in endings:
            found.append(f"{place}{entry.name}")
    return found
