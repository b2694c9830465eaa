"""Uploaded files: all that a check or a job reads, and kept in a folder of their own."""

import re
from pathlib import Path

from crankbase.errors import InputError
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.reading.toml_file import TomlFile, read_toml
from crankfem.service.asking import FileQuestion

_PLAIN = re.compile(r"[A-Za-z0-9][\w .()+-]{0,79}", re.ASCII)
TABLE_ENDINGS = (".csv", ".json", ".toml")
MOST_TABLES = 200
# The folder of a job in which its uploaded files are kept, apart from all that the job writes.
KEPT = "sent"


def read_upload(asked: FileQuestion) -> TomlFile:
    """Read an uploaded file; whatever reads the files that it names gets those sent with it, and no other.

    Raises
    ------
    InputError
        Also if a name is none of a plain file, because the files are kept in a folder.
    """
    _check_name("name", asked.name, (".toml",))
    if len(asked.tables) > MOST_TABLES:
        raise InputError(
            f"tables: given {len(asked.tables)}; allowed are {MOST_TABLES} at most, because each list of "
            "jobs names the files of all."
        )
    contents = {asked.name: _encoded(asked.name, asked.text)}
    for name, text in asked.tables.items():
        _check_name("tables", name, TABLE_ENDINGS)
        if name in contents:
            raise InputError(
                f"tables: given {name!r}, the name of the file itself; allowed is another."
            )
        contents[name] = _encoded(name, text)
    return read_toml(InputFiles(Path(asked.name), contents))


def keep_upload(content: TomlFile, folder: Path) -> None:
    """Write an uploaded file, and those sent with it, where nothing that a job writes is."""
    (folder / KEPT).mkdir(exist_ok=True)
    for name, sent in (content.files.sent or {}).items():
        (folder / KEPT / name).write_bytes(sent)


def _encoded(name: str, text: str) -> bytes:
    try:
        return text.encode()
    except UnicodeEncodeError:
        raise InputError(f"{name}: given text with half a character; allowed is Unicode.") from None


def _check_name(field: str, name: str, endings: tuple[str, ...]) -> None:
    if _PLAIN.fullmatch(name) is None or not name.endswith(endings):
        raise InputError(
            f"{field}: given {name!r}; allowed is the plain name of a file that ends in "
            f"{' or '.join(endings)}, of up to 80 letters, digits, spaces and . ( ) + - _, because uploaded "
            "files share a folder."
        )
