"""Write a study's rows as a table for other programs: CSV or Parquet."""

import csv
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crankbase.errors import InputError, MissingLibraryError
from crankbase.outputs import atomic_file
from crankbase.text_limits import LARGEST_TABLE_FILE, check_file_size
from crankbase.units.quantity import parse_quantity
from fem.responses import RESPONSES
from geometry.throw import CrankThrow
from regression.plans.factors import Factor
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.response_kinds import is_positive_response
from regression.runs.study_table import StudyRow, StudyTable
from regression.throw_values import field_unit

# Columns that say something of a row as a whole.
ABOUT = ("role", "source", "status", "model_version")
# Columns of exported tables that an import has no use for.
IGNORED = ("seconds", "unknowns", "reason", "design", "file")
HEADER = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\]\s*)?")


@dataclass(frozen=True)
class ImportedColumn:
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


def read_columns(file: str, headers: list[str], plan: StudyPlan) -> list[ImportedColumn]:
    """Return the columns of a table, by their headers.

    Raises
    ------
    InputError
    """
    found: list[ImportedColumn] = []
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


def _column(header: str, where: str, plan: StudyPlan) -> ImportedColumn:
    matched = HEADER.fullmatch(header)
    if matched is None or not matched[1]:
        raise InputError(f"{where}: allowed is a name with its unit, like web_width [mm].")
    name, unit = matched[1], matched[2]
    header = header.strip()
    if name in IGNORED:
        return ImportedColumn(header, "ignored", name, _text)
    if name in ABOUT:
        return ImportedColumn(header, "about", name, _text)
    if name.endswith(" error") and name.removesuffix(" error") in RESPONSES:
        return ImportedColumn(
            header, "error", name.removesuffix(" error"), _reader(where, "", unit)
        )
    if name in RESPONSES:
        return ImportedColumn(header, "response", name, _response_reader(where, name, unit))
    factor = next((factor for factor in plan.factors if factor.name == name), None)
    field = plan.variants().fields.get(name)
    if factor is not None and field is None:
        return ImportedColumn(header, "factor", name, _reader(where, factor.unit, unit))
    if field is None:
        raise InputError(
            f"{where}: unknown; allowed are {', '.join(ABOUT)}, fields of the throw, the study's factors "
            f"({', '.join(plan.names)}) and responses ({', '.join(RESPONSES)})."
        )
    if field.choices:
        return ImportedColumn(header, "field", name, _choice(field.choices))
    return ImportedColumn(header, "field", name, _reader(where, field.unit, unit))


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


Cell = str | float | int | None
FORMATS = (".csv", ".parquet")
ERROR = " error"


@dataclass(frozen=True)
class Column:
    """A column of a table: its name, SI unit ("" for none), and its cells."""

    name: str
    unit: str
    cells: list[Cell]

    @property
    def header(self) -> str:
        """Name and unit, as in "web_width [m]"."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def columns(table: StudyTable) -> tuple[Column, ...]:
    """List the columns of each row: role, factors, dimensions, responses, errors, reason."""
    rows = table.rows
    factors = [
        (place, factor)
        for place, factor in enumerate(table.plan.factors)
        if factor.name not in CrankThrow.model_fields
    ]
    found = [
        Column("role", "", [row.role for row in rows]),
        Column("status", "", [row.status for row in rows]),
        Column("source", "", [row.source or None for row in rows]),
    ]
    found += [
        Column(factor.name, factor.unit, [_factor_cell(row, place, factor) for row in rows])
        for place, factor in factors
    ]
    shown = {factor.name for _, factor in factors}
    parts: tuple[tuple[str, Callable[[str], str | None], str], ...] = (
        ("dimensions", field_unit, ""),
        ("outlines", field_unit, ""),
        ("responses", lambda name: RESPONSES[name].unit, ""),
        ("errors", lambda _: "", ERROR),
    )
    for part, unit, ending in parts:
        entries = [getattr(row, part) for row in rows]
        names = dict.fromkeys(name for entry in entries for name in entry if name not in shown)
        found += [
            Column(name + ending, unit(name) or "", [entry.get(name) for entry in entries])
            for name in names
        ]
    found += [
        Column("seconds", "s", [None if row.source else row.seconds for row in rows]),
        Column("unknowns", "", [row.unknowns for row in rows]),
        Column("model_version", "", [None if row.source else MODEL_VERSION for row in rows]),
        Column("reason", "", [row.reason or None for row in rows]),
    ]
    return tuple(found)


def _factor_cell(row: StudyRow, place: int, factor: Factor) -> Cell:
    if row.values is None:
        return row.dimensions.get(factor.name, row.outlines.get(factor.name))
    value = row.values[place]
    return factor.labels[round(value)] if factor.labels else value


def check_export(path: Path) -> None:
    """Refuse a file that could not be written, before anything is computed for it.

    Raises
    ------
    InputError
    MissingLibraryError
        If Parquet is requested without the required package.
    """
    if path.suffix not in FORMATS:
        raise InputError(f"export: given {str(path)!r}; allowed are {' and '.join(FORMATS)} files.")
    if not path.absolute().parent.is_dir():
        raise InputError(f"export: given {str(path)!r}; there is no folder {path.parent}.")
    if path.suffix == ".parquet":
        _parquet()


def export_table(table: StudyTable, path: str | Path) -> int:
    """Write all rows of a study, including those without a result, and return their number.

    Parameters
    ----------
    table : StudyTable
    path : path
        ``.csv`` or ``.parquet``. SI units, named in the columns' headers; in Parquet also as metadata
        of each column, the study's key as metadata of the file. Replaced when complete.

    Raises
    ------
    InputError, MissingLibraryError
        As `check_export`.
    """
    path = Path(path)
    check_export(path)
    with atomic_file(path, "table") as part:
        if path.suffix == ".csv":
            write_csv(part, columns(table))
        else:
            _write_parquet(part, table)
    return len(table.rows)


def write_csv(path: Path, listed: Sequence[Column]) -> None:
    """Write columns of one length as CSV, with a line of headers."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([column.header for column in listed])
        # Python writes a float with all digits that tell it from its neighbors.
        writer.writerows(zip(*(column.cells for column in listed), strict=True))


def _write_parquet(path: Path, table: StudyTable) -> None:
    pyarrow, parquet = _parquet()
    listed = columns(table)
    arrays = [pyarrow.array(column.cells) for column in listed]
    fields = [
        pyarrow.field(column.header, array.type, metadata={"unit": column.unit})
        for column, array in zip(listed, arrays, strict=True)
    ]
    about = {"study": table.plan.key, "model_version": str(MODEL_VERSION)}
    schema = pyarrow.schema(fields, metadata=about)
    parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=schema), path)


def _parquet() -> tuple[Any, Any]:
    try:
        import pyarrow
        import pyarrow.parquet as parquet
    except ImportError:
        raise MissingLibraryError(
            "export: given a Parquet file, but the package pyarrow is not installed; install it with: "
            "pip install 'crankfem[tables]', or write a .csv file."
        ) from None
    return pyarrow, parquet
