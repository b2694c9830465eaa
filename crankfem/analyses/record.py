"""Common parts of all records for JSON and tables."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from crankbase.errors import SolveError
from crankfem.files.reading.toml_file import InputRecord

# Plain JSON content.
Record = dict[str, Any]
# How a remark begins that tells of a value nobody gave.
ASSUMED = "Assumed: "


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


def input_records(records: Iterable[InputRecord]) -> list[Record]:
    """Every input with its source."""
    return [asdict(record) for record in records]


def json_text(content: Mapping[str, Any], indent: int | None = None) -> str:
    """Return content as JSON, in which every number is finite.

    Raises
    ------
    SolveError
        Naming the first number that is not.
    """
    try:
        return json.dumps(content, indent=indent, allow_nan=False) + "\n"
    except ValueError:
        wrong = next(_not_finite(content, ""), None)
        if wrong is None:
            raise
        raise SolveError(
            f"The result {wrong[0]} is {wrong[1]}: allowed are finite numbers."
        ) from None


def _not_finite(value: Any, path: str) -> Iterator[tuple[str, float]]:
    """Yield path and value of every number that is not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        yield path, value
    inside = (
        value.items()
        if isinstance(value, Mapping)
        else enumerate(value, start=1)
        if isinstance(value, list | tuple)
        else ()
    )
    for name, one in inside:
        yield from _not_finite(one, f"{path}.{name}" if path else str(name))


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
    >>> plain({"orders": np.array([0.5, 1.0]), "peak": np.inf})
    {'orders': [0.5, 1.0], 'peak': None}
    """
    return {name: _plain(value) for name, value in content.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return plain(value)
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float) and math.isinf(value):
        return None
    return value
