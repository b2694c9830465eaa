"""The shipped files: engines, hinges and chains, each with its kind and a line about it."""

from dataclasses import dataclass
from pathlib import Path

from crankfem.files.engine.file_kinds import FileKind, file_kind
from crankfem.files.reading.data_files import FOLDERS, input_path, shipped_names
from crankfem.files.reading.toml_file import read_toml


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
