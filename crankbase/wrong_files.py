"""Files given in place of others by mistake: what each is, and what it is for."""

import re

CSV = "is a table (CSV)"
JSON = "is a JSON file, such as the results of a run or a saved model"
# Beginnings of files to what they are.
BEGINNINGS = (
    (
        b"SQLite format 3\0",
        "is the store of a study (SQLite); use it with fit, compare and doe --store",
    ),
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
