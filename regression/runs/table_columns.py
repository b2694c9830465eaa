"""Columns of a table of results: their content, and the reading of their cells."""

import csv
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crankbase.errors import InputError
from crankbase.text_limits import LARGEST_TABLE_FILE, check_file_size
from crankbase.units.quantity import parse_quantity
from fem.responses import RESPONSES
from regression.plans.plan import StudyPlan
from regression.response_kinds import is_positive_response

# Columns that say something of a row as a whole.
ABOUT = ("role", "source", "status", "model_version")
# Columns of exported tables that an import has no use for.
IGNORED = ("seconds", "unknowns", "reason", "design", "file")
HEADER = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\]\s*)?")


@dataclass(frozen=True)
class Column:
    """One column of the table: its header, what it holds, and how its cells are read."""

    header: str
    kind: str
    name: str
    read: Callable[[str, str], Any]


def read_lines(path: Path) -> list[list[str]]:
    """Return the cells of a CSV table, line by line.

    Raises
    ------
    InputError
    """
    if path.suffix == ".parquet":
        raise InputError(
            f"{path.name}: is a Parquet table; allowed are a CSV table or another store, because Parquet "
            "is written for other programs only."
        )
    check_file_size(path, LARGEST_TABLE_FILE, "a table of results")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            text = file.read()
    except UnicodeDecodeError:
        text = "\0"
    except OSError as error:
        raise InputError(f"{path.name}: cannot be read ({error.strerror}).") from None
    if "\0" in text:
        raise InputError(
            f"{path.name}: is no text in UTF-8; allowed is a CSV table, saved as UTF-8 text, or another "
            "store."
        )
    try:
        lines = list(csv.reader(text.splitlines(keepends=True), strict=True))
    except csv.Error as error:
        raise InputError(
            f"{path.name}: is no CSV table ({error}); allowed are a header and lines of cells separated "
            "by commas."
        ) from None
    for mark, name in ((";", "semicolons"), ("\t", "tabs")):
        if lines and any(mark in cell for cell in lines[0]):
            raise InputError(
                f"{path.name}, line 1: given cells separated by {name}; allowed are commas between "
                "columns, and points in decimal numbers."
            )
    return lines


def read_columns(file: str, headers: list[str], plan: StudyPlan) -> list[Column]:
    """Return the columns of a table, by their headers.

    Raises
    ------
    InputError
    """
    found: list[Column] = []
    for number, header in enumerate(headers, start=1):
        where = f"{file}, line 1, column {number} ({header.strip()!r})"
        column = _column(header, where, plan)
        if column.kind != "ignored" and any(
            (one.kind, one.name) == (column.kind, column.name) for one in found
        ):
            raise InputError(f"{where}: given twice; allowed is each column once.")
        found.append(column)
    if not any(column.kind == "response" for column in found):
        raise InputError(
            f"{file}, line 1: given no response; allowed are {', '.join(RESPONSES)}, each with its "
            "unit, like axial_compliance_pinned [m/N]."
        )
    return found


def _column(header: str, where: str, plan: StudyPlan) -> Column:
    matched = HEADER.fullmatch(header)
    if matched is None or not matched[1]:
        raise InputError(f"{where}: allowed is a name with its unit, like web_width [mm].")
    name, unit = matched[1], matched[2]
    header = header.strip()
    if name in IGNORED:
        return Column(header, "ignored", name, _text)
    if name in ABOUT:
        return Column(header, "about", name, _text)
    if name.endswith(" error") and name.removesuffix(" error") in RESPONSES:
        return Column(header, "error", name.removesuffix(" error"), _reader(where, "", unit))
    if name in RESPONSES:
        return Column(header, "response", name, _response_reader(where, name, unit))
    factor = next((factor for factor in plan.factors if factor.name == name), None)
    field = plan.variants().fields.get(name)
    if factor is not None and field is None:
        return Column(header, "factor", name, _reader(where, factor.unit, unit))
    if field is None:
        raise InputError(
            f"{where}: unknown; allowed are {', '.join(ABOUT)}, fields of the throw, the study's factors "
            f"({', '.join(plan.names)}) and responses ({', '.join(RESPONSES)})."
        )
    if field.choices:
        return Column(header, "field", name, _choice(field.choices))
    return Column(header, "field", name, _reader(where, field.unit, unit))


def _text(cell: str, _: str) -> str:
    return cell


def _choice(choices: tuple[str, ...]) -> Callable[[str, str], str]:
    def read(cell: str, where: str) -> str:
        if cell not in choices:
            raise InputError(f"{where}: given {cell!r}; allowed are {', '.join(choices)}.")
        return cell

    return read


def _reader(where: str, unit: str, given: str | None) -> Callable[[str, str], float]:
    """Make the function that reads the numbers of a column in a given unit."""
    if (given or "") == unit:
        return _number
    if given is None:
        raise InputError(f"{where}: given without a unit; write it in brackets, like [{unit}].")
    if not unit:
        raise InputError(f"{where}: given in {given}; allowed is a plain number without a unit.")
    parse_quantity(f"1 {given}", unit, where)  # refuses a unit of another kind

    def read(cell: str, place: str) -> float:
        _number(cell, place)
        return parse_quantity(f"{cell} {given}", unit, place)

    return read


def _response_reader(where: str, name: str, given: str | None) -> Callable[[str, str], float]:
    """Make the function that reads a response; most are above zero by nature."""
    read = _reader(where, RESPONSES[name].unit, given)

    def read_positive(cell: str, place: str) -> float:
        value = read(cell, place)
        if value <= 0.0:
            raise InputError(
                f"{place}: given {cell!r}; allowed is a number above zero, as every throw has it."
            )
        return value

    return read_positive if is_positive_response(name) else read


def _number(cell: str, where: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"{where}: given {cell!r}; allowed is a finite number, like 68 or 1.5e-9, with a point for "
            "decimals, because the header gives its unit."
        )
    return value
