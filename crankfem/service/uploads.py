"""Uploaded files: written into a job's folder, naming nothing outside of it."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from crankbase.errors import InputError
from crankfem.service.asking import FileQuestion

_PLAIN = re.compile(r"[A-Za-z0-9][\w .()+-]{0,79}", re.ASCII)
# Fields that name files; those of shipped tables and chains are plain, too.
FILE_FIELDS = frozenset(
    {"pressure_table", "table", "gas_force_table", "model", "torsional", "axial"}
)
TABLE_ENDINGS = (".csv", ".json", ".toml")


def write_upload(asked: FileQuestion, folder: Path) -> Path:
    """Write an uploaded file and its tables into a folder.

    Raises
    ------
    InputError
        If a name leads, or could lead, out of the folder.
    """
    _check_name("name", asked.name, (".toml",))
    for name in asked.tables:
        _check_name("tables", name, TABLE_ENDINGS)
        if name == asked.name:
            raise InputError(
                f"tables: given {name!r}, the name of the file itself; allowed is another."
            )
    try:
        content = tomllib.loads(asked.text)
    except (ValueError, RecursionError):
        content = {}  # what reads it says what is wrong
    for field, name in _named_files(content, ""):
        _check_name(field, name, ())
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in {**asked.tables, asked.name: asked.text}.items():
        try:
            (folder / name).write_text(text, encoding="utf-8")
        except UnicodeEncodeError:
            raise InputError(
                f"{name}: given text with half a character; allowed is Unicode."
            ) from None
    return folder / asked.name


def _named_files(values: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        field = f"{prefix}.{name}".lstrip(".")
        if isinstance(value, Mapping):
            inner = value.get("value")
            if name in FILE_FIELDS and isinstance(inner, str):
                yield field, inner
            yield from _named_files(value, field)
        elif isinstance(value, list):
            for place, one in enumerate(value):
                if isinstance(one, Mapping):
                    yield from _named_files(one, f"{field}[{place}]")
        elif name in FILE_FIELDS and isinstance(value, str):
            yield field, value


def _check_name(field: str, name: str, endings: tuple[str, ...]) -> None:
    if _PLAIN.fullmatch(name) is None or (endings and not name.endswith(endings)):
        ends = f" that ends in {' or '.join(endings)}" if endings else ""
        raise InputError(
            f"{field}: given {name!r}; allowed is the plain name of a file{ends}, of letters, digits, spaces "
            "and . ( ) + - _, because uploaded files share a folder."
        )
