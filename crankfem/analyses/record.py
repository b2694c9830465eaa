"""Common parts of all records for JSON and tables."""

from collections.abc import Iterable, Mapping
from typing import Any

from crankbase.results import Result, units
from crankbase.results import plain as _plain
from crankfem.files.reading.toml_file import InputRecord

# Plain JSON content.
Record = dict[str, Any]


def assumed_values(records: Iterable[InputRecord]) -> list[Record]:
    """Return field, value, reason and effect of the assumed inputs."""
    return [
        {
            "field": record.field,
            "given": record.given,
            "reason": record.source,
            "effect": record.effect,
        }
        for record in records
        if record.assumed
    ]


def attributes(source: object, *names: str) -> Record:
    """Return attributes of an object by their names, as plain JSON content.

    Examples
    --------
    >>> attributes(2.0 + 1.0j, "real", "imag")
    {'real': 2.0, 'imag': 1.0}
    """
    return {name: _plain(getattr(source, name)) for name in names}


def plain(content: Mapping[str, Any]) -> Record:
    """Return content for JSON: arrays and tuples as lists, unbounded values as None.

    NaN stays, for `json_text` to refuse.

    Examples
    --------
    >>> plain({"orders": (0.5, 1.0), "peak": float("inf")})
    {'orders': [0.5, 1.0], 'peak': None}
    """
    return {name: _plain(value) for name, value in content.items()}


def with_units(content: Record | Result) -> Record:
    """Return a record with the units of its numbers under "units"; unchanged if it has no numbers."""
    whole: Record = _plain(content)
    if isinstance(content, dict) and "units" in content:
        return whole
    known = units(content)
    return whole | {"units": known} if known else whole
