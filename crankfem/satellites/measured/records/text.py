"""Records in text (CSV): any separator, decimal mark, order of columns and header, or none."""

import math
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError, quoted, shortened
from crankbase.exported_table import (
    COMMENTS,
    PACKED,
    ExportedTable,
    number,
    read_exported_table,
    split_line,
)
from crankbase.input_file import UTF_16, InputFile, wrong_kind
from crankfem.satellites.measured.records.builder import RecordBuilder, RecordReading, Series
from crankfem.satellites.measured.records.record import Column, Record
from crankfem.satellites.measured.records.units import split_heading

# Bytes that tell how a file is written, and those of its end that tell digits.
HEAD, TAIL = 262_144, 65_536
# Larger files are left on the disk and read in pieces [bytes].
MOST_IN_MEMORY = 200_000_000
# Lines are turned into numbers so many at a time.
LINES = 200_000
# Rows at each end of a column of which digits are counted.
ROWS = 50
NO_NUMBER = ("nan", "-", "--", "n/a")


def read_text(path: Path, reading: RecordReading) -> Record:
    """Read a record in text.

    Raises
    ------
    InputError
        If a cell is no number, a column that is named is not there, or as `RecordBuilder`.
    """
    with path.open("rb") as file:
        head = file.read(HEAD)
    if head.startswith((PACKED, *UTF_16)):
        raise InputError(f"{path}: {wrong_kind(head)}; allowed is a record, such as CSV in UTF-8.")
    size = path.stat().st_size
    cut = head if size <= HEAD else head[: head.rfind(b"\n") + 1]
    table = read_exported_table(InputFile(path, cut), "record")
    tail = table.cells if size <= HEAD else _last_cells(path, table)
    if not table.cells:
        raise InputError(f"{path}: has no numbers; allowed is a record with columns of numbers.")
    lines = _Lines(path, table, missing_allowed=size <= MOST_IN_MEMORY)
    columns = _columns(lines, size)
    errors = [
        max(_digit(table.cells[:ROWS], place, table), _digit(tail[-ROWS:], place, table)) / 2.0
        for place in range(table.columns)
    ]
    gaps = [size <= MOST_IN_MEMORY and bool(np.any(np.isnan(each.whole))) for each in columns]
    headings = table.headings or tuple(f"column {place + 1}" for place in range(table.columns))
    units = table.units or ("",) * table.columns
    series = [Series(*each) for each in zip(headings, units, columns, errors, gaps, strict=True)]
    builder = RecordBuilder(path, "CSV", reading)
    if reading.columns:
        series = [
            replace(series[place], heading=name, unit="")
            for name, place in _named_places(path, table, reading).items()
        ]
    elif not table.headings:
        builder.notes.append(
            "There is no header, so that no column is taken as time or angle; say which is what, like "
            "columns = { time_s = 1, wheel_V = 2 }."
        )
    builder.add_columns("", series)
    return builder.record


def _named_places(path: Path, table: ExportedTable, reading: RecordReading) -> dict[str, int]:
    """Return the place of each column that is named.

    Raises
    ------
    InputError
        If one is not there.
    """
    places, headings = {}, table.headings or ("",) * table.columns
    for name, column in reading.columns.items():
        word = str(column).strip().casefold()
        fits = [
            place
            for place, heading in enumerate(headings)
            for names in [(str(place + 1), heading, split_heading(heading)[0])]
            if word in map(str.casefold, names)
        ]
        if len(fits) != 1:
            known = ", ".join(map(quoted, table.headings)) or f"1 to {table.columns}"
            raise InputError(
                f"{path}: columns: given {name} = {quoted(column)}, which is {len(fits) or 'none'} of the "
                f"columns; allowed are {known}."
            )
        places[name] = fits[0]
    return places


def _columns(lines: "_Lines", size: int) -> list[Column]:
    """Return the columns of a text: in memory, or for reading in pieces if it is large."""
    width = lines.table.columns
    if size <= MOST_IN_MEMORY:
        rows = np.concatenate([*lines.blocks(), np.empty((0, width))])
        return [Column.of(rows[:, place]) for place in range(width)]
    count = lines.count()

    def column(place: int) -> Column:
        return Column.of_blocks(count, lambda: (block[:, place] for block in lines.blocks()))

    return [column(place) for place in range(width)]


class _Lines:
    """The lines of numbers of a text."""

    def __init__(self, path: Path, table: ExportedTable, *, missing_allowed: bool) -> None:
        self.path, self.table, self.missing_allowed = path, table, missing_allowed

    def count(self) -> int:
        """Count the lines of numbers, of which none is empty."""
        ends, last = 0, b""
        with self.path.open("rb") as file:
            while piece := file.read(1 << 24):
                ends, last = ends + piece.count(b"\n"), piece[-1:]
        return ends + (last != b"\n") - (self.table.lines[0] - 1)

    def blocks(self) -> Iterator[Array]:
        """Read the numbers, shape (lines, columns), of some lines at a time."""
        first = self.table.lines[0]
        with self.path.open(encoding="utf-8-sig", errors="replace") as file:  # numbers are ASCII
            for _ in islice(file, first - 1):
                pass
            while lines := list(islice(file, LINES)):
                yield self._numbers(lines, first)
                first += len(lines)

    def _numbers(self, lines: list[str], first: int) -> Array:
        separator, decimal = self.table.separator, self.table.decimal
        if decimal != "," or separator != ",":
            plain = [line.replace(",", ".") for line in lines] if decimal == "," else lines
            with suppress(ValueError):
                rows = np.loadtxt(
                    plain, delimiter=separator, usecols=self.table.places, ndmin=2, comments=None,
                    quotechar='"',
                )  # fmt: skip
                if np.all(np.isfinite(rows)):
                    return rows
        return np.array(
            [row for place, line in enumerate(lines, start=first) for row in self._row(line, place)]
        ).reshape(-1, self.table.columns)

    def _row(self, line: str, place: int) -> list[list[float]]:
        """Return the numbers of a line, NaN where none is; no row of an empty line or a comment."""
        stripped = line.strip(" \ufeff\n\r")
        if not stripped.strip() or stripped.startswith(COMMENTS):
            return []
        cells = split_line(stripped, self.table.separator)
        row = []
        for column, at in enumerate(self.table.places):
            cell = cells[at] if at < len(cells) else ""
            value = number(cell, self.table.decimal)
            missing = not cell or cell.casefold() in NO_NUMBER
            if not math.isfinite(value) and not (missing and self.missing_allowed):
                heading = self.table.headings[column] if self.table.headings else f"{column + 1}"
                raise InputError(
                    f'{self.path}, line {place}: {heading}: given "{shortened(cell)}"; allowed are finite '
                    "numbers, because every sample counts."
                )
            row.append(value)
        return [row]


def _last_cells(path: Path, table: ExportedTable) -> list[list[str]]:
    """Return the cells of the last lines."""
    with path.open("rb") as file:
        file.seek(-TAIL, os.SEEK_END)
        lines = file.read().decode(errors="replace").splitlines()[1:]
    rows = (split_line(line.strip(), table.separator) for line in lines if line.strip())
    return [[row[place] for place in table.places] for row in rows if len(row) > max(table.places)]


def _digit(cells: Sequence[Sequence[str]], column: int, table: ExportedTable) -> float:
    """Return the size of the last digit of a column's numbers; zeros at an end may be left out."""
    sizes = []
    for row in cells:
        mantissa, _, power = row[column].casefold().replace(table.decimal, ".").partition("e")
        with suppress(ValueError):
            sizes.append(10.0 ** (int(power or 0) - len(mantissa.partition(".")[2])))
    return min(sizes, default=0.0)
