"""Shell completion: names of shipped files, suitable files, sections, dimensions of a model.

Nothing slow is loaded here, since the shell waits.
"""

from collections.abc import Callable, Iterable
from pathlib import Path

import typer

from crankbase.input_file import STEP_ENDINGS
from crankfem.files.reading.data_files import shipped_names, shipped_torques

# Typer tells these functions apart by the names of their arguments.
Completion = Callable[[str], list[str]]


def files(
    *endings: str, shipped: Iterable[str] = (), further: Callable[[], tuple[str, ...]] = tuple
) -> Completion:
    """Return the completion of files with these endings, folders on the way, and shipped files of kinds.

    Parameters
    ----------
    further : callable, optional
        Gives the names of other shipped files.
    """

    def fitting(incomplete: str) -> list[str]:
        folder, _, start = incomplete.rpartition("/")
        place = f"{folder}/" if folder or incomplete.startswith("/") else ""
        names = [*(name for kind in shipped for name in shipped_names(kind)), *further()]
        fit = [name for name in names if name.startswith(incomplete)]
        try:
            entries = sorted(Path(place or ".").iterdir()) if endings else []
        except OSError:
            entries = []
        for entry in entries:
            if not entry.name.startswith(start) or (entry.name.startswith(".") and not start):
                continue
            if entry.is_dir():
                fit.append(f"{place}{entry.name}/")  # folders end in a slash
            elif entry.suffix.lower() in endings:
                fit.append(f"{place}{entry.name}")
        return fit

    return fitting


engines = files(".toml", shipped=("engine",))
engines_and_parts = files(".toml", *STEP_ENDINGS, shipped=("engine",))
engines_and_chains = files(".toml", ".txt", shipped=("engine", "chain"))
engines_and_tables = files(".toml", ".csv", shipped=("engine",), further=shipped_torques)
any_input = files(".toml", ".txt", further=shipped_names)
shipped = files(further=shipped_names)


def sections(incomplete: str) -> list[str]:
    """Sections of engine files, and that of chain files."""
    from crankfem.files.engine.field_tables import CHAIN
    from crankfem.files.engine.file_kinds import SECTIONS

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
