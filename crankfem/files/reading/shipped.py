"""What is shipped: engines, hinges and chains, each with its kind and a line about it."""

from dataclasses import dataclass
from pathlib import Path

from crankfem.files.reading.data_files import (
    data_folder,
    shipped_chains,
    shipped_engines,
    shipped_hinges,
)
from crankfem.files.reading.file_kinds import describes_a_throw, describes_mechanism
from crankfem.files.reading.toml_file import read_toml


@dataclass(frozen=True)
class ShippedFile:
    """A shipped file: its name, its kind (engine, mechanism, throw, hinge, chain), a line about it."""

    name: str
    kind: str
    about: str
    path: Path


def shipped_files() -> tuple[ShippedFile, ...]:
    """Return all shipped files, engines first."""
    return tuple(
        ShippedFile(name, kind or _kind(path), _about(path), path)
        for names, folder, kind in (
            (shipped_engines(), "engines", ""),
            (shipped_hinges(), "hinges", "hinge"),
            (shipped_chains(), "chains", "chain"),
        )
        for name in names
        for path in [data_folder() / folder / f"{name}.toml"]
    )


def _kind(path: Path) -> str:
    content = read_toml(path)
    if describes_a_throw(content):
        return "throw"
    return "mechanism" if describes_mechanism(content) else "engine"


def _about(path: Path) -> str:
    """Return the first sentence of the comment at the head of a file."""
    words = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#") or line.startswith("#  "):
            break
        words.append(line.removeprefix("#").strip())
    return " ".join(words).partition(". ")[0].partition("; ")[0].rstrip(".")
