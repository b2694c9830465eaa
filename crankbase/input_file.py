"""Files of input: what they are, how large they may be, and reading each in one step."""

import os
import re
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crankbase.errors import InputError

CSV = "is a table (CSV)"
JSON = "is a JSON file, such as the results of a run or a saved model"
STEP_ENDINGS = (".step", ".stp")
# Beginnings of files to what they are.
BEGINNINGS = (
    (b"SQLite format 3\0", "is the store of a study (SQLite); use it with fit and doe --store"),
    (b"PK\x03\x04", "is a packed file, such as one of a spreadsheet or word processor"),
    (b"%PDF", "is a PDF file"),
    (b"ISO-10303-21", "is a STEP file; use it with cad (a whole crankshaft) or throw"),
    (b"<", "is a web page or a picture (HTML, XML, SVG), such as a report"),
    (b"{", JSON),
)
UTF_16 = (b"\xff\xfe", b"\xfe\xff")
# Two lines of numbers or names between commas, of which the second begins with a number.
TABLE = re.compile(
    rb"(?:\s*#[^\n]*\n)*[^\n=\[\]]+,[^\n=\[\]]*\n\s*[+-]?[\d.]+\s*,[^\n=\[\]]*(?:\n|\Z)"
)
LOOKED_AT = 4000
# What a path may lead to that is no file.
ENTRIES = {
    stat.S_IFDIR: "is a folder, not a file",
    stat.S_IFIFO: "is a pipe, not a file (save what comes through it in one)",
    stat.S_IFSOCK: "is a socket, not a file",
    stat.S_IFCHR: "is a device, not a file",
    stat.S_IFBLK: "is a device, not a file",
}
STANDARD_INPUT = ("-", "/dev/stdin", "/dev/fd/0", "/proc/self/fd/0")


def not_a_file(path: Path) -> str | None:
    """Say what a path leads to that is no file; None if it is one, or leads nowhere.

    What it says follows the path in a message. Nothing is opened, since a pipe without a writer would wait.

    Examples
    --------
    >>> not_a_file(Path("/"))
    'is a folder, not a file'
    """
    try:
        entry = ENTRIES.get(stat.S_IFMT(path.stat().st_mode))
    except (OSError, ValueError):  # nothing is there, or it cannot be examined
        entry = "" if str(path) == "-" else None
    if entry is not None and str(path) in STANDARD_INPUT:
        return "is standard input, which is not read (save it in a file)"
    return entry


def wrong_kind(begin: bytes) -> str | None:
    r"""Say what a file is that cannot be one of input; None where it may be one.

    Parameters
    ----------
    begin : bytes
        The first `LOOKED_AT` bytes of the file.

    Examples
    --------
    >>> wrong_kind(b"time,speed\n0,1\n")
    'is a table (CSV)'
    """
    if begin.startswith(UTF_16):
        return "is text in UTF-16; save it as UTF-8"
    plain = begin.removeprefix(b"\xef\xbb\xbf").lstrip()
    for beginning, kind in BEGINNINGS:
        if plain.startswith(beginning):
            return kind
    return CSV if TABLE.match(plain) else None


# Characters of a quantity such as "7850 kg/m^3", and of an expression of a study.
LONGEST_QUANTITY = 200
LONGEST_EXPRESSION = 1000
# Of all exponents in a unit or an expression, multiplied: m^4 kg^2 s^2 has 16.
LARGEST_POWER = 1000.0
# Bytes of an input file in TOML or of the text of a chain, and of a table or a model.
LARGEST_TEXT_FILE = 1_000_000
LARGEST_TABLE_FILE = 50_000_000
# Values in a TOML file, names in a dotted key or tables in tables, and characters of one name or text.
MOST_VALUES = 10_000
DEEPEST_TABLE = 30
LONGEST_TEXT = 10_000
# TOML guarantees integers of 64 bits, one of them the sign.
MOST_BITS = 63


def check_file_size(path: Path, most: int, what: str) -> None:
    """Refuse what is no file, or too large for its purpose, before it is read.

    Parameters
    ----------
    path : Path
        A file that cannot be examined is left to the reader.
    most : int
        Bytes.
    what : str
        Purpose of the file, for the message.
    """
    if (entry := not_a_file(path)) is not None:
        raise InputError(f"{path}: {entry}.")
    try:
        check_size(path, path.stat().st_size, most, what)
    except OSError:
        return


def check_size(path: Path, size: int, most: int, what: str) -> None:
    """Refuse a size [bytes] of a file's content; the rest as `check_file_size`."""
    if size > most:
        raise InputError(
            f"{path}: given a file of {size / 1e6:.3g} MB; allowed is {most / 1e6:g} MB at most, because "
            f"{what} has far less."
        )


@dataclass(frozen=True)
class InputFile:
    """A file of input.

    Attributes
    ----------
    path : Path
        What messages call it, and where it is unless it was sent.
    sent : bytes, optional
        Its content, if it was sent: nothing is opened then.
    reading : optional
        How a table in it is to be read, where the table does not say so.
    """

    path: Path
    sent: bytes | None = None
    reading: Any = None

    @classmethod
    def of(cls, file: "GivenFile") -> "InputFile":
        """Return a file that is given by its path."""
        return file if isinstance(file, InputFile) else cls(Path(file))

    def content(self, most: int, what: str) -> bytes:
        """Read the file, of so many bytes at most; `what` is for the message.

        Raises
        ------
        InputError
            If it is larger, or cannot be read.
        """
        if self.sent is not None:
            check_size(self.path, len(self.sent), most, what)
            return self.sent
        check_file_size(self.path, most, what)
        try:
            return self.path.read_bytes()
        except OSError as error:
            why = error.strerror or error
            raise InputError(f"{self.path}: cannot be read as {what} ({why}).") from None

    def text(self, most: int, what: str, allowed: str, fits: str = "") -> str:
        r"""Read the file as text in UTF-8, its lines ended by ``\n``.

        Parameters
        ----------
        most : int
            Bytes.
        what, allowed : str
            Purpose of the file and the allowed content, for messages.
        fits : str
            What `wrong_kind` says of files of this kind.

        Raises
        ------
        InputError
            If it is larger, of another kind, no text, or cannot be read.
        """
        content = self.content(most, what)
        wrong = wrong_kind(content[:LOOKED_AT])
        if wrong is not None and wrong != fits:
            raise InputError(f"{self.path}: {wrong}; allowed is {allowed}.")
        try:
            return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            raise InputError(
                f"{self.path}: cannot be read as text, because line {line} is not UTF-8; allowed is "
                f"{allowed} in UTF-8."
            ) from None


GivenFile = str | os.PathLike[str] | InputFile
