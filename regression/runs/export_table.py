"""Write a study's rows to a table that other programs read: CSV or Parquet."""

import csv
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crankbase.errors import InputError, MissingLibraryError
from crankbase.outputs import atomic_file
from fem.responses import RESPONSES
from geometry.throw import CrankThrow
from regression.plans.plan import MODEL_VERSION
from regression.runs.study_table import StudyRow, StudyTable
from regression.throw_values import field_unit

Cell = str | float | int | None
FORMATS = (".csv", ".parquet")
ERROR = " error"


@dataclass(frozen=True)
class Column:
    """A column of a table: its name, SI unit ("" for none), and what it shows of a row."""

    name: str
    unit: str
    cell: Callable[[StudyRow], Cell]

    @property
    def header(self) -> str:
        """Name and unit, as in "web_width [m]"."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def columns(table: StudyTable) -> tuple[Column, ...]:
    """List what a table says of each row: role, factors, dimensions, responses, errors, reason."""
    rows = table.rows
    factors = [f for f in table.plan.factors if f.name not in CrankThrow.model_fields]
    shown = {factor.name for factor in factors}
    found = [
        Column("role", "", lambda row: row.role),
        Column("status", "", lambda row: row.status),
        Column("source", "", lambda row: row.source or None),
    ]
    found += [
        Column(factor.name, factor.unit, _factor(place, factor.name, factor.labels))
        for place, factor in enumerate(table.plan.factors)
        if factor in factors
    ]
    found += [
        Column(name, field_unit(name) or "", _entry("dimensions", name))
        for name in _names(row.dimensions for row in rows)
        if name not in shown
    ]
    found += [
        Column(name, "", _entry("outlines", name))
        for name in _names(row.outlines for row in rows)
        if name not in shown
    ]
    responses = _names(row.responses for row in rows)
    found += [Column(name, RESPONSES[name].unit, _entry("responses", name)) for name in responses]
    found += [
        Column(name + ERROR, "", _entry("errors", name))
        for name in _names(row.errors for row in rows)
    ]
    found += [
        Column("seconds", "s", lambda row: row.seconds if not row.source else None),
        Column("unknowns", "", lambda row: row.unknowns),
        Column("model_version", "", lambda row: None if row.source else MODEL_VERSION),
        Column("reason", "", lambda row: row.reason or None),
    ]
    return tuple(found)


def _names(entries: Iterable[Any]) -> list[str]:
    return list(dict.fromkeys(name for entry in entries for name in entry))


def _entry(part: str, name: str) -> Callable[[StudyRow], Cell]:
    def cell(row: StudyRow) -> Cell:
        found: Cell = getattr(row, part).get(name)
        return found

    return cell


def _factor(place: int, name: str, labels: tuple[str, ...]) -> Callable[[StudyRow], Cell]:
    def cell(row: StudyRow) -> Cell:
        if row.values is None:
            return row.dimensions.get(name, row.outlines.get(name))
        value = row.values[place]
        return labels[round(value)] if labels else value

    return cell


def check_export(path: Path) -> None:
    """Refuse a file that could not be written, before anything is computed for it.

    Raises
    ------
    InputError
    MissingLibraryError
        If Parquet is asked for without the package for it.
    """
    if path.suffix not in FORMATS:
        raise InputError(f"export: given {str(path)!r}; allowed are {' and '.join(FORMATS)} files.")
    if not path.absolute().parent.is_dir():
        raise InputError(f"export: given {str(path)!r}; there is no folder {path.parent}.")
    if path.suffix == ".parquet":
        _parquet()


def export_table(table: StudyTable, path: str | Path) -> int:
    """Write all rows of a study, those without a result too, and return their number.

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
        (_write_csv if path.suffix == ".csv" else _write_parquet)(part, table)
    return len(table.rows)


def _write_csv(path: Path, table: StudyTable) -> None:
    listed = columns(table)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([column.header for column in listed])
        # Python writes a float with all digits that tell it from its neighbors.
        writer.writerows([column.cell(row) for column in listed] for row in table.rows)


def _write_parquet(path: Path, table: StudyTable) -> None:
    pyarrow, parquet = _parquet()
    listed = columns(table)
    arrays = [pyarrow.array([column.cell(row) for row in table.rows]) for column in listed]
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
