"""Tables as spreadsheets and measuring systems export them: cells, header, units, and numbers."""

import csv
import io
import math
import re
import zipfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError, MissingLibraryError, quoted, shortened
from crankbase.input_file import CSV, LARGEST_TABLE_FILE, LOOKED_AT, UTF_16, InputFile, wrong_kind
from crankbase.units import NoUnitError, OtherKindError, pressure_reference, size_in

SEPARATORS = (";", "\t", ",", None)  # None: spaces
COMMENTS = ("#", "%", "//", '"#')
# So many lines tell what stands between cells.
LINES_LOOKED_AT = 2000
# Of a kind of fault so many lines are told.
MOST_LINES = 3
# A packed spreadsheet may be so many times larger when it is unpacked.
LARGEST_UNPACKING = 20
PACKED = b"PK\x03\x04"
_POINT = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_COMMA = re.compile(r"[+-]?(?:\d+,?\d*|,\d+)(?:[eE][+-]?\d+)?", re.ASCII)
# Thousands apart, with the other mark before the decimals.
_THOUSANDS = {
    ".": re.compile(r"[+-]?\d{1,3}(?:,\d{3})+\.\d*", re.ASCII),
    ",": re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d*", re.ASCII),
}
# A unit in brackets behind a heading or alone; it may end in brackets itself, as bar(a) does.
BRACKETED = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*(?:\([^\[\]()]*\))?)[\])]\s*$")
# What else stands in a row of units: none, and degrees of the crank.
NO_UNIT = ("", "-", "--", "1")
DEGREES = ("deg", "°", "°ca", "°kw", "degca", "deg ca", "ca", "kw", "grad", "degree", "degrees")


@dataclass(frozen=True, eq=False)
class ExportedTable:
    """A table with numbers.

    Attributes
    ----------
    headings : tuple of str
        Of the columns, as they are in the file; empty without a header.
    units : tuple of str
        Of the columns, from a row of units or in brackets behind a heading; empty text where there is none.
    header_line : int
        Number of the line with the headings, 0 without.
    cells : list of list of str
        Of each row of numbers, as many as there are columns.
    lines : tuple of int
        Number of each row's line, from 1.
    comments : tuple of str
        Without the sign before them.
    places : tuple of int
        Of the columns among those of the file, from 0.
    separator : str or None
        What stands between cells; None for spaces, and of a spreadsheet.
    decimal : str
        Mark before decimals, "." or ",".
    faults : tuple of str
        What is wrong, a sentence each.
    """

    path: Path
    headings: tuple[str, ...]
    units: tuple[str, ...]
    header_line: int
    cells: list[list[str]]
    lines: tuple[int, ...]
    comments: tuple[str, ...]
    places: tuple[int, ...]
    separator: str | None
    decimal: str
    faults: tuple[str, ...]

    @property
    def columns(self) -> int:
        """Number of columns."""
        return len(self.cells[0]) if self.cells else len(self.headings)

    def numbers(self, column: int) -> Array:
        """Return the numbers of a column, NaN for what is none."""
        return np.array([number(row[column], self.decimal) for row in self.cells])

    def wrong_cells(self, column: int, name: str) -> list[str]:
        """Return a sentence for the first cells of a column that are no finite numbers, and the count."""
        wrong = np.flatnonzero(~np.isfinite(self.numbers(column)))
        sentences = [
            f'{self.path}, line {self.lines[row]}: {name}: given "{shortened(self.cells[row][column])}"; '
            "allowed are finite numbers, because every sample counts."
            for row in wrong[:MOST_LINES]
        ]
        if wrong.size > MOST_LINES:
            sentences.append(
                f"{self.path}: {name}: {wrong.size} cells in all are no finite numbers."
            )
        return sentences


def number(cell: str, decimal: str = ".") -> float:
    """Return the number of a cell, NaN if it is none.

    Examples
    --------
    >>> number("1.234,5", ","), number("-0,5", ","), number("1,5", ".")
    (1234.5, -0.5, nan)
    """
    other = "." if decimal == "," else ","
    if _THOUSANDS[decimal].fullmatch(cell):
        cell = cell.replace(other, "")
    if not (_COMMA if decimal == "," else _POINT).fullmatch(cell):
        return math.nan
    return float(cell.replace(",", "."))


def _looks_like_number(cell: str) -> bool:
    return any(not math.isnan(number(cell, mark)) for mark in ".,")


def read_exported_table(file: InputFile, what: str, sheet: str = "") -> ExportedTable:
    """Read a table: text with cells apart by semicolons, tabs, commas or spaces, or a spreadsheet.

    Lines before the first row of numbers are headings if they have as many cells; a row of units may be below
    them. Columns without any cell are left out.

    Parameters
    ----------
    what : str
        Purpose of the file, for messages, such as "torque table".
    sheet : str, optional
        Of a spreadsheet, the one to read; needed if several have cells.

    Raises
    ------
    InputError
        If the file cannot be read, or is of another kind.
    MissingLibraryError
        If it is a spreadsheet and openpyxl is not installed.
    """
    content = file.content(LARGEST_TABLE_FILE, f"a {what}")
    if content.startswith(PACKED):
        comments: tuple[str, ...] = ()
        separator = None
        rows = _sheet_rows(file.path, content, what, sheet)
    elif sheet:
        raise InputError(
            f"{file.path}: given the sheet {quoted(sheet)} of text; allowed is a spreadsheet (.xlsx)."
        )
    else:
        comments, separator, rows = _text_rows(file.path, content, what)
    return _table_of(file.path, rows, comments, separator)


Row = tuple[int, list[str]]


def _text_rows(
    path: Path, content: bytes, what: str
) -> tuple[tuple[str, ...], str | None, list[Row]]:
    """Return comments, separator and rows of text, in UTF-8, UTF-16 with its mark, or else Windows-1252."""
    wrong = wrong_kind(content[:LOOKED_AT])
    unicode_text = content.startswith(UTF_16)
    if wrong is not None and wrong != CSV and not unicode_text:
        raise InputError(f"{path}: {wrong}; allowed is a {what} (CSV or .xlsx).")
    for encoding in ("utf-16",) if unicode_text else ("utf-8-sig", "cp1252"):
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if "\0" not in text:
                break
    else:
        raise InputError(f"{path}: is no text; allowed is a {what} (CSV or .xlsx).")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    comments, lines = [], []
    for place, line in enumerate(text.split("\n"), start=1):
        stripped = line.strip(" \ufeff")
        if stripped.startswith(COMMENTS):
            comments.append(stripped.strip('"').lstrip("#%/").strip())
        elif stripped.strip():
            lines.append((place, stripped))
    looked_at = [line for _, line in lines[:LINES_LOOKED_AT]]
    separator = max(SEPARATORS, key=lambda mark: _suits(looked_at, mark))
    if separator == ",":
        # The commas may be those before decimals, below the heading of a single column.
        numbers = [bool(_COMMA.fullmatch(line)) for line in looked_at]
        first = next((place for place, alone in enumerate(numbers) if alone), 0)
        if first > 0 and all(numbers[first:]) and "," not in looked_at[first - 1]:
            separator = ";"
    try:
        rows = [(place, split_line(line, separator)) for place, line in lines]
        return tuple(comments), separator, rows
    except csv.Error as error:
        raise InputError(f"{path}: is no table ({error}).") from None


def separator_of(header: str) -> str:
    """Return what stands between the names of a header: semicolons, tabs or commas.

    Examples
    --------
    >>> separator_of("web_width [mm];axial_compliance_pinned [m/N]")
    ';'
    """
    return max((",", ";", "\t"), key=header.count)


def with_points(rows: list[list[str]]) -> list[list[str]]:
    """Return rows with decimal points in their numbers, of rows with decimal commas alone.

    Examples
    --------
    >>> with_points([["width", "note"], ["270,5", "a,b"]])
    [['width', 'note'], ['270.5', 'a,b']]
    """
    numbers = [cell.strip() for row in rows for cell in row if _looks_like_number(cell.strip())]
    if any("." in cell for cell in numbers):
        return rows
    return [
        [cell.replace(",", ".") if _COMMA.fullmatch(cell.strip()) else cell for cell in row]
        for row in rows
    ]


def split_line(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line, None for spaces between them."""
    if separator is None:
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _suits(lines: Sequence[str], separator: str | None) -> tuple[int, int, int]:
    """Return how many lines a separator makes numbers alone of, without such those with two, and cells of."""
    alone = some = cells_of = 0
    for line in lines:
        try:
            cells = [cell for cell in split_line(line, separator) if cell]
        except csv.Error:
            continue
        numbers = sum(map(_looks_like_number, cells))
        several = len(cells) > 1
        alone += several and numbers == len(cells)
        some += numbers > 1
        cells_of += several
    return alone, 0 if alone else some, cells_of


def _sheet_rows(path: Path, content: bytes, what: str, sheet: str) -> list[Row]:
    """Return the rows of a spreadsheet's one sheet, numbers as Python writes them."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:
            size = sum(part.file_size for part in packed.infolist())
            is_sheet = "xl/workbook.xml" in packed.namelist()
    except (zipfile.BadZipFile, ValueError):
        is_sheet, size = False, 0
    if not is_sheet:
        raise InputError(
            f"{path}: is a packed file, but no spreadsheet (.xlsx); allowed is a {what} (CSV or .xlsx)."
        )
    if size > LARGEST_UNPACKING * LARGEST_TABLE_FILE:
        raise InputError(f"{path}: is too large when unpacked; a {what} has far less.")
    try:
        import openpyxl
    except ImportError:
        raise MissingLibraryError(
            f"{path}: is a spreadsheet, which needs the package openpyxl: pip install "
            "'crankfem[spreadsheets]'; or save it as CSV."
        ) from None
    try:
        # Formulas as the values that the spreadsheet saved of them.
        book = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
        sheets = {
            page.title: [
                ["" if cell is None else str(cell).strip() for cell in row]
                for row in page.iter_rows(values_only=True)
            ]
            for page in book.worksheets
        }
    except Exception as error:  # openpyxl tells of damage by errors of many kinds
        raise InputError(
            f"{path}: cannot be read as a spreadsheet ({shortened(str(error))})."
        ) from None
    filled = {name: rows for name, rows in sheets.items() if any(map(any, rows))}
    if sheet and sheet not in filled:
        raise InputError(
            f"{path}: given the sheet {quoted(sheet)}; allowed are {', '.join(filled) or 'none'}, which "
            "have cells."
        )
    if not sheet and len(filled) > 1:
        raise InputError(
            f"{path}: has several sheets with cells: {', '.join(filled)}; name the one that is meant as "
            "sheet."
        )
    rows = filled[sheet] if sheet else next(iter(filled.values()), [])
    return [(place, row) for place, row in enumerate(rows, start=1) if any(row)]


def _table_of(
    path: Path, rows: list[Row], comments: tuple[str, ...], separator: str | None
) -> ExportedTable:
    counts = [sum(map(_looks_like_number, cells)) for _, cells in rows]
    # Without any numbers the first line is a header all the same.
    fewest = min(2, max(counts, default=2)) or 2
    first = next((place for place, count in enumerate(counts) if count >= fewest), 1)
    preamble, data = rows[:first], rows[first:]
    # Separators at the ends of lines make no columns.
    width = max((_filled(cells) for _, cells in data or preamble[-1:]), default=0)
    usual = sorted(_filled(cells) for _, cells in data)[len(data) // 2] if data else width
    short = [(line, cells) for line, cells in data if _filled(cells) < usual]
    count = "two" if usual == 2 else f"{usual}"
    faults = [
        f'{path}, line {line}: given "{shortened(", ".join(cells))}"; allowed are {count} numbers, '
        "as in the other lines."
        for line, cells in short[:MOST_LINES]
    ]
    if len(short) > MOST_LINES:
        faults.append(f"{path}: {len(short)} lines in all have too few cells.")
    data = [(line, cells) for line, cells in data if _filled(cells) >= usual]
    headings, units, header_line = _heads(preamble, width)
    cells = [(row + [""] * width)[:width] for _, row in data]
    kept = [
        place
        for place in range(width)
        if any(row[place] for row in cells) or (headings and headings[place])
    ]
    decimal, mixed = _decimal_mark(path, cells, [line for line, _ in data])
    return ExportedTable(
        path,
        tuple(headings[place] for place in kept) if headings else (),
        tuple(units[place] for place in kept) if headings else ("",) * len(kept),
        header_line,
        [[row[place] for place in kept] for row in cells],
        tuple(line for line, _ in data),
        comments,
        tuple(kept),
        separator,
        decimal,
        (*faults, *mixed),
    )


def _filled(cells: Sequence[str]) -> int:
    """Return how many cells there are up to the last one with content."""
    return max((place + 1 for place, cell in enumerate(cells) if cell), default=0)


def _heads(preamble: Sequence[Row], width: int) -> tuple[list[str], list[str], int]:
    """Return headings, units and the headings' line, from the lines before the numbers."""
    few, most = (1, 1) if width == 1 else (2, width + 1)
    likely = [(line, cells) for line, cells in preamble if few <= _filled(cells) <= most]
    if preamble and not likely and width == 1:
        likely = [preamble[-1]]
    if not likely:
        return [], [""] * width, 0
    (line, names), below = likely[-1], [""] * width
    if len(likely) > 1 and all(_is_unit(cell) for cell in names):
        below, (line, names) = (names + [""] * width)[:width], likely[-2]
    names = (names + [""] * width)[:width]
    units = []
    for name, unit in zip(names, below, strict=True):
        bracketed = BRACKETED.match(name)
        units.append(_bare(unit) or (bracketed[2].strip() if bracketed else ""))
    return names, units, line


def _bare(cell: str) -> str:
    """Return a unit without brackets around all of it."""
    bracketed = BRACKETED.match(cell)
    return (bracketed[2] if bracketed and not bracketed[1] else cell).strip()


def _is_unit(cell: str) -> bool:
    bare = _bare(cell)
    return bare.casefold() in (*NO_UNIT, *DEGREES) or any(
        unit_size(bare, unit) is not None
        for unit in ("Pa", "N m", "N", "m", "s", "rad", "rad/s", "K", "W", "kg/s")
    )


def unit_size(text: str, unit: str) -> float | None:
    """Return the size of a unit in one of SI; None if it is none of its kind.

    Of a pressure its size alone, whether it is absolute or above the atmosphere.
    """
    if unit == "rad" and text.casefold() in DEGREES:
        return math.radians(1.0)
    try:
        return size_in(pressure_reference(text)[0], unit)[0]
    except (NoUnitError, OtherKindError):
        return None


def _decimal_mark(
    path: Path, cells: Sequence[Sequence[str]], lines: Sequence[int]
) -> tuple[str, list[str]]:
    """Return the mark before decimals of all cells, and what speaks against it."""
    first: dict[str, tuple[int, str]] = {}
    apart = set()
    for line, row in zip(lines, cells, strict=True):
        for cell in row:
            for mark, thousands in _THOUSANDS.items():
                if thousands.fullmatch(cell):
                    apart.add(mark)
                    break
                if mark in cell and _looks_like_number(cell):
                    first.setdefault(mark, (line, cell))
    if len(apart | first.keys()) < 2:
        return next(iter(apart | first.keys()), "."), []
    if len(apart) == 1:
        mark = apart.pop()
        if set(first) <= {mark}:
            return mark, []
    shown = " and ".join(f'"{cell}" in line {line}' for line, cell in first.values())
    return ".", [
        f"{path}: given {shown}, with points and commas before decimals; allowed is one of the two in the "
        "whole table, because 1,234 may be a thousand times 1.234."
    ]
