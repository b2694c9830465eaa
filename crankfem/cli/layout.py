"""Tables and paragraphs as lines of a width: no word is broken, and no cell is cut."""

import re
import textwrap
from collections.abc import Sequence

from crankbase.table import SI, Column, OutputUnits, Table

# Stands for a space at which no line ends.
TIED = "\u00a0"
BREAK = re.compile("[\t-\r]")
WITH_UNIT = re.compile(
    r"(?<=\d) (?=%|1/min|[munkMG\N{MICRO SIGN}]?(?:m|g|N|Pa|W|Hz|deg|rad)\b)|(?<=\d N) (?=m\b)"
)
# A line and its style.
Line = tuple[str, str]
HEAD = "bold"
GAPS = ("  ", " ")
# Columns are given up for a list where they take so many times its lines.
TOO_TALL = 1.5
INDENT = "    "

PLACE = re.compile(r"\b(cylinder|main bearing) (\d+)(?: - \1 (\d+))?")
WAY = re.compile(r"\b(cylinder|main bearing) \d+ - \1 \d+")
BETWEEN = re.compile(r"\b(?:cyl|brg) (\d+)-(\d+)")
SHORT = {"cylinder": "cyl", "main bearing": "brg"}
LISTED = re.compile(r" *(?:- |\d+\. )?")
NUMBER = re.compile(r"-?\d+(\.\d+)?")
ZEROS = re.compile(r"(\.\d*?)0+(?!\d)")
UNIT = re.compile(r"\[[^]]*\]")


def short_ways(text: str) -> str:
    """Shorten the names of ways between two places alone, in a sentence."""
    return WAY.sub(lambda way: short_places(way[0]), text)


def wrapped(text: str, width: int, hanging: bool = True) -> list[str]:
    """Break a text at spaces alone, none before a unit; what follows "- " or "1. " may be indented."""
    if len(text) <= width and text == text.strip() and not BREAK.search(text):
        return [text.replace(TIED, " ")]  # most are short, and breaking takes its time
    listed = LISTED.match(text) if hanging else None
    lines = textwrap.wrap(
        WITH_UNIT.sub(TIED, text),
        width,
        subsequent_indent=" " * len(listed[0]) if listed else "",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(TIED, " ") for line in lines] or [""]


def short_places(text: str) -> str:
    """Shorten the names of places.

    Examples
    --------
    >>> short_places("main bearing 6 - main bearing 7, flywheel"), short_places("cylinder 6 - flywheel")
    ('brg 6-7, flywheel', 'cyl 6 - flywheel')
    """
    return PLACE.sub(
        lambda place: f"{SHORT[place[1]]} {'-'.join(filter(None, place.groups()[1:]))}", text
    )


def legend(text: str) -> str:
    """Explain the short names of places in a text; empty if there are none."""
    names = [f"{short}: {name}" for name, short in SHORT.items() if f"{short} " in text]
    between = BETWEEN.search(text)
    names += [f"{between[0]}: from {between[1]} to {between[2]}"] if between else []
    return f"{'; '.join(names)}." if between or names else ""


def table_lines(table: Table, units: OutputUnits = SI, width: int = 80) -> list[Line]:
    """Return the lines of a table: in columns, or where these do not fit, a list with a row each.

    Of a table without rows only what it would hold is said.
    """
    if table.title and not table.rows:
        paragraphs = (f"{table.title}: none", table.note)
        return [(line, "") for text in paragraphs if text for line in wrapped(text, width)]
    heads = [short_places(column.head(units)) for column in table.columns]
    rows = [[short_places(cell) for cell in row] for row in table.texts(units)]
    columns = [
        _aligned(column, cells) if column.decimals is not None else cells
        for column, cells in zip(table.columns, map(list, zip(*rows, strict=True)), strict=False)
    ]
    rows = [list(row) for row in zip(*columns, strict=True)]
    listed = [line for row in rows for line in _listed(table.columns, row, units, width)]
    lines = _in_columns(table.columns, heads, rows, width)
    if lines is None or len(lines) > max(TOO_TALL * len(listed), len(rows) + 4):
        lines = [(line, "") for line in listed]
    title = [(line, HEAD) for line in wrapped(table.title, width)] if table.title else []
    note = [(line, "") for line in wrapped(table.note, width)] if table.note else []
    return [*title, *lines, *note]


def _aligned(column: Column, cells: list[str]) -> list[str]:
    """Return numbers without zeros at their ends, their decimals below each other."""
    cells = [ZEROS.sub(lambda decimals: decimals[1].rstrip("."), cell) for cell in cells]
    if column.words:
        return cells
    numbers = [NUMBER.fullmatch(cell) for cell in cells]
    fractions = [len(number[1] or "") if number else 0 for number in numbers]
    most = max(fractions, default=0)
    return [
        cell + " " * (most - fraction) if number else cell
        for cell, fraction, number in zip(cells, fractions, numbers, strict=True)
    ]


def _in_columns(
    columns: Sequence[Column], heads: list[str], rows: list[list[str]], width: int
) -> list[Line] | None:
    left = [place == 0 or column.words for place, column in enumerate(columns)]
    heads = [UNIT.sub(lambda unit: unit[0].replace(" ", TIED), head) for head in heads]
    cells = [
        [row[place] if left[place] else row[place].replace(" ", TIED) for row in rows]
        for place in range(len(columns))
    ]
    for gap in GAPS:
        widths = _widths(heads, cells, width - len(gap) * (len(columns) - 1))
        if widths is not None:
            break
    else:
        return None

    def written(row: Sequence[str], bottom: bool = False) -> list[str]:
        parts = [wrapped(cell, room, False) for cell, room in zip(row, widths, strict=True)]
        most = max(map(len, parts))
        filled = [
            [""] * (most - len(part)) + part if bottom else part + [""] * (most - len(part))
            for part in parts
        ]
        lines = []
        for line in zip(*filled, strict=True):
            aligned = (
                cell.ljust(room) if is_left else cell.rjust(room)
                for cell, room, is_left in zip(line, widths, left, strict=True)
            )
            lines.append(gap.join(aligned).rstrip().replace(TIED, " "))
        return lines

    rule = "-" * (sum(widths) + len(gap) * (len(widths) - 1))
    body = [(line, "") for row in zip(*cells, strict=True) for line in written(row)]
    return [*((line, HEAD) for line in written(heads, bottom=True)), (rule, ""), *body]


def _widths(heads: list[str], cells: list[list[str]], room: int) -> list[int] | None:
    """Return widths of columns that take at most the room; None if their longest words take more."""
    columns = [[head, *column] for head, column in zip(heads, cells, strict=True)]
    least = [
        max((len(word) for text in column for word in text.split(" ")), default=0)
        for column in columns
    ]
    widths = [max(map(len, column)) for column in columns]
    if sum(least) > room:
        return None
    while sum(widths) > room:
        widest = max(
            range(len(widths)), key=lambda place: (widths[place] > least[place], widths[place])
        )
        widths[widest] -= 1
    return widths


def _listed(columns: Sequence[Column], row: list[str], units: OutputUnits, width: int) -> list[str]:
    """Write a row as a list of its cells, each with its name and unit."""
    items = []
    for column, cell in zip(columns[1:], map(str.strip, row[1:]), strict=True):
        unit = column.display_unit(units).name if NUMBER.match(cell) else ""
        if cell:
            items.append(" ".join(filter(None, (short_places(column.name), cell, unit))))
    first = row[0].strip()
    text = "; ".join(item.replace(" ", TIED) if len(item) < width // 2 else item for item in items)
    lines = textwrap.wrap(
        f"{first}: {text}" if first and text else first or text,
        width,
        subsequent_indent=INDENT,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(TIED, " ") for line in lines]
