"""Write tables of plain numbers as CSV."""

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from crankbase.checks.arrays import FloatArray
from crankbase.outputs import atomic_file


def write_columns(path: Path, columns: Mapping[str, FloatArray], heading: str = "") -> None:
    """Write columns of equal length to 12 digits, units in their names; see `write_rows`."""
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    write_rows(path, list(columns), ([f"{value:.12g}" for value in row] for row in rows), heading)


def write_rows(
    path: Path, names: Sequence[str], rows: Iterable[Sequence[object]], heading: str = ""
) -> None:
    """Write rows below the names of their columns.

    Parameters
    ----------
    path : Path
    names : sequence of n str
    rows : iterable of sequences of n cells
    heading : str, optional
        Content of the first line after a number sign; no such line if empty.
    """
    with atomic_file(path, "table") as part, part.open("w", encoding="utf-8", newline="") as file:
        if heading:
            file.write(f"# {heading}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(rows)
