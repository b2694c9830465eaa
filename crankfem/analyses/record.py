"""What all records for JSON and tables share."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import numpy as np

from crankfem.files.reading.toml_file import InputRecord

# Plain JSON content.
Record = dict[str, Any]
# How a remark begins that tells of a value nobody gave.
ASSUMED = "Assumed: "


def assumed_values(records: Iterable[InputRecord]) -> list[Record]:
    """Return field, value and reason of the inputs that nobody gave."""
    return [
        {"field": record.field, "given": record.given, "reason": record.source}
        for record in records
        if record.assumed
    ]


def input_records(records: Iterable[InputRecord]) -> list[Record]:
    """Every input with its source."""
    return [asdict(record) for record in records]


def attributes(of: object, *names: str) -> Record:
    """Return some attributes of an object as a record."""
    return {name: getattr(of, name) for name in names}


def finite_or_none(value: float) -> float | None:
    """Return a number that JSON can hold; None stands for an unbounded one."""
    return value if np.isfinite(value) else None
