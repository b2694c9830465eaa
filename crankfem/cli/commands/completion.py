"""Shell completion: names of shipped files, suitable files, sections, dimensions of a model.

Nothing slow is loaded here, since the shell waits.
"""

from collections.abc import Callable, Iterable
from pathlib import Path

import typer

from crankfem.files.reading.data_files import FOLDERS, InputKind, shipped_names, shipped_torques

# Typer tells these functions apart by the names of their arguments.
Completion = Callable[[str], list[str]]


def files(*endings: str, shipped: Iterable[InputKind] = ()) -> Completion:
    """Return the completion of files with these endings, folders on the way, and shipped files of kinds."""

    def fitting(incomplete: str) -> list[str]:
        names = [name for kind in shipped for name in shipped_names(kind)]
        return _fitting(incomplete, names, *endings)

    return fitting


engines = files(".toml", shipped=("engine",))
engines_and_parts = files(".toml", ".step", ".stp", shipped=("engine",))
engines_and_chains = files(".toml", ".txt", shipped=("engine", "chain"))
hinges = files(".toml", shipped=("hinge",))
any_input = files(".toml", ".txt", shipped=FOLDERS)
shipped = files(shipped=FOLDERS)


def engines_and_tables(incomplete: str) -> list[str]:
    """Shipped engines and torque tables, and files of both."""
    names = (*shipped_names("engine"), *shipped_torques())
    return _fitting(incomplete, names, ".toml", ".csv")


def sections(incomplete: str) -> list[str]:
    """Sections of engine files, and that of chain files."""
    from crankfem.files.engine.engine_file import SECTIONS
    from crankfem.files.engine.field_tables import CHAIN

    return [name for name in (*SECTIONS, CHAIN) if name.startswith(incomplete)]


def dimensions(ctx: typer.Context, incomplete: str) -> list[str]:
    """Dimensions that the model on the command line asks for, as the beginning of NAME=VALUE."""
    import json

    model = ctx.params.get("model")
    if model is None or "=" in incomplete:
        return []
    try:
        content = json.loads(Path(str(model)).read_text(encoding="utf-8"))
        factors = (
            name for response in content["responses"].values() for name in response["factors"]
        )
        names = list(dict.fromkeys([*content["ranges"], *factors]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return []
    return [f"{name}=" for name in names if name.startswith(incomplete)]


def _fitting(incomplete: str, names: Iterable[str], *endings: str) -> list[str]:
    """Return the names and files that begin so; folders end in a slash."""
    folder, _, start = incomplete.rpartition("/")
    place = f"{folder}/" if folder or incomplete.startswith("/") else ""
    fitting = [name for name in names if name.startswith(incomplete)]
    try:
        entries = sorted(Path(place or ".").iterdir()) if endings else []
    except OSError:
        entries = []
    for entry in entries:
        if not entry.name.startswith(start) or (entry.name.startswith(".") and not start):
            continue
        if entry.is_dir():
            fitting.append(f"{place}{entry.name}/")
        elif entry.suffix.lower() in endings:
            fitting.append(f"{place}{entry.name}")
    return fitting
