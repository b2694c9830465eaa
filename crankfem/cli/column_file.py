"""Write columns of numbers as CSV."""

import csv
from collections.abc import Mapping
from pathlib import Path

from crankbase.checks.arrays import FloatArray

from crankbase.outputs import written


def write_columns(path: Path, columns: Mapping[str, FloatArray], heading: str = "") -> None:
    """Write columns of equal length, units in their names.

    Parameters
    ----------
    path : Path
    columns : mapping of str to (m,) arrays
    heading : str, optional
        What the first line says after a number sign; no such line if empty.
    """
    with written(path, "table") as part, part.open("w", encoding="utf-8", newline="") as file:
        if heading:
            file.write(f"# {heading}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        writer.writerows([f"{value:.12g}" for value in row] for row in rows)
