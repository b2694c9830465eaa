"""Write a study's rows as a table for other programs: CSV or Parquet."""

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crankbase.errors import InputError, MissingLibraryError
from crankbase.outputs import atomic_file
from fem.responses import RESPONSES
from geometry.throw import CrankThrow
from regression.plans.factors import Factor
from regression.plans.plan import MODEL_VERSION
from regression.runs.study_table import StudyRow, StudyTable
from regression.throw_values import field_unit

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
