"""Records in Parquet, by pyarrow: units in the headings, or in the metadata of columns."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankfem.satellites.measured.records.builder import RecordBuilder, RecordReading, Series
from crankfem.satellites.measured.records.record import Column, Record

UNIT_KEYS = (b"unit", b"units", b"Unit", b"Units")
# Time stamps count these parts of a second.
PARTS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def read_parquet(path: Path, reading: RecordReading) -> Record:
    """Read a table: its columns of numbers and time stamps, which become seconds after the first."""
    from pyarrow import parquet, types

    builder, series = RecordBuilder(path, "Parquet", reading), []
    with parquet.ParquetFile(path) as file:
        schema, count = file.schema_arrow, file.metadata.num_rows
        for place, field in enumerate(schema):
            stamp = types.is_timestamp(field.type) or types.is_duration(field.type)
            if not (stamp or types.is_integer(field.type) or types.is_floating(field.type)
                    or types.is_boolean(field.type)):  # fmt: skip
                builder.notes.append(f"{field.name}: holds no numbers.")
                continue
            about = field.metadata or {}
            unit = next((about[key].decode() for key in UNIT_KEYS if key in about), "")
            part = PARTS[field.type.unit] if stamp else None
            series.append(
                Series(
                    field.name,
                    "s" if stamp else unit,
                    _column(path, field.name, count, part),
                    gaps=_may_have_gaps(file.metadata, place),
                )
            )
    builder.add_columns("", series)
    return builder.record


def _may_have_gaps(metadata: Any, place: int) -> bool:
    """Whether a column has rows without a value, as far as the file counts them."""
    for group in range(metadata.num_row_groups):
        statistics = metadata.row_group(group).column(place).statistics
        if statistics is None or not statistics.has_null_count or statistics.null_count:
            return True
    return False


def _column(path: Path, name: str, count: int, part: float | None) -> Column:
    """Return a column, of time stamps that count a part of a second those after the first [s]."""
    from pyarrow import int64, parquet

    def blocks() -> Iterator[Array]:
        first = None
        with parquet.ParquetFile(path) as file:
            for batch in file.iter_batches(columns=[name]):
                column = batch.column(0)
                if part is None:
                    yield np.asarray(column.to_numpy(zero_copy_only=False), dtype=np.float64)
                    continue
                counted = column.cast(int64()).to_numpy(zero_copy_only=False)
                first = counted[0] if first is None and len(counted) else first
                yield np.asarray((counted - first) * part, dtype=np.float64)

    return Column.of_blocks(count, blocks)
