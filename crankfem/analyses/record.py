"""Common parts of all records for JSON and tables."""

from collections.abc import Iterable
from typing import Any

from crankbase.results import Result, by_names, plain, result, units
from crankfem.files.reading.toml_file import InputRecord

# Plain JSON content.
Record = dict[str, Any]


@result("field", "given")
class AssumedInput(Result):
    """An input that nobody gave, why it was taken, and its effect on results, if known."""

    field: str
    given: str
    reason: str
    effect: str


def assumed_values(records: Iterable[InputRecord]) -> tuple[AssumedInput, ...]:
    """Return the assumed ones of the inputs."""
    return tuple(
        AssumedInput(record.field, record.given, record.source, record.effect)
        for record in records
        if record.assumed
    )


def attributes(source: object, *names: str) -> Record:
    """Return attributes of an object by their names, as plain JSON content.

    Examples
    --------
    >>> attributes(2.0 + 1.0j, "real", "imag")
    {'real': 2.0, 'imag': 1.0}
    """
    return {name: plain(getattr(source, name)) for name in names}


def with_units(content: Record | Result) -> Record:
    """Return a record with the units of its numbers under "units"; unchanged if it has no numbers."""
    whole: Record = plain(content)
    if isinstance(content, dict) and "units" in content:
        return whole
    known = units(content)
    return whole | {"units": by_names(known)} if known else whole
