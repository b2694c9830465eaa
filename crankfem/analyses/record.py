"""What all records for JSON and tables share."""

from collections.abc import Iterable
from typing import Any

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
