"""Files given in place of others by mistake: what each is, and what it is for."""

import re
import stat
from pathlib import Path

CSV = "is a table (CSV)"
JSON = "is a JSON file, such as the results of a run or a saved model"
# Beginnings of files to what they are.
BEGINNINGS = (
    (b"SQLite format 3\0", "is the store of a study (SQLite); use it with fit and doe --store"),
    (b"PK\x03\x04", "is a packed file, such as one of a spreadsheet or word processor"),
    (b"%PDF", "is a PDF file"),
    (b"ISO-10303-21", "is a STEP file; use it with throw"),
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
    for beginning, said in BEGINNINGS:
        if plain.startswith(beginning):
            return said
    return CSV if TABLE.match(plain) else None
