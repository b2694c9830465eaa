"""Rows of a result store: their format, and the check of their content.

Each row has a checksum of its content, like a model file. A row with a wrong checksum, or
impossible content, is damaged: a study skips it, reports it, and computes it again.
"""

import hashlib
import json
import math
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from crankbase.checks.choices import is_number
from regression.records import ExtraRow, Outcome

# What is recorded of a design, and of a row from elsewhere beside the study that it was imported into.
RECORDED = (
    "key",
    "inputs",
    "status",
    "responses",
    "reason",
    "seconds",
    "errors",
    "unknowns",
    "model_version",
    "worker",
    "attempts",
)
EXTRA = (
    "study",
    "key",
    "role",
    "source",
    "factors",
    "dimensions",
    "outlines",
    "responses",
    "errors",
)
CHECKSUM = "checksum"
LARGEST = sys.float_info.max


class DamagedRowError(ValueError):
    """A row is damaged; the message states how, in a few words."""


def damaged_rows_warning(damaged: Mapping[str, str], store: object) -> str:
    """Warn of skipped damaged rows of a store, with the fault of the first."""
    place, why = next(iter(damaged.items()))
    first = f"{place}: {why}" + ("; and others" if len(damaged) > 1 else "")
    number = "1 row is" if len(damaged) == 1 else f"{len(damaged)} rows are"
    return f"{number} damaged in {store} and left out ({first})"


def checksum(values: Sequence[object]) -> str:
    """Return the SHA-256 of a row's values in one fixed spelling."""
    return hashlib.sha256(json.dumps(list(values)).encode()).hexdigest()


def design_values(outcome: Outcome, model_version: int | None) -> tuple[object, ...]:
    """Return the recorded values of a design, in the order of `RECORDED`, and its checksum."""
    values = (
        outcome.key,
        json.dumps(outcome.inputs, sort_keys=True),
        outcome.status,
        None if outcome.responses is None else _json(outcome.responses),
        outcome.reason,
        float(outcome.seconds),
        _json(outcome.errors),
        outcome.unknowns,
        model_version,
        outcome.worker,
        outcome.attempts,
    )
    return (*values, checksum(values))


def extra_values(study: str, key: str, row: ExtraRow) -> tuple[object, ...]:
    """Return the recorded values of a row from elsewhere, in the order of `EXTRA`, and its checksum."""
    values = (
        study,
        key,
        row.role,
        row.source,
        None if row.values is None else json.dumps(row.values, allow_nan=False),
        _json(row.dimensions),
        json.dumps(dict(row.outlines)),
        _json(row.responses),
        _json(row.errors),
    )
    return (*values, checksum(values))


def _json(numbers: Mapping[str, float]) -> str:
    return json.dumps(dict(numbers), allow_nan=False)


def read_design(row: Mapping[str, Any]) -> Outcome:
    """Make an outcome of a design's row, a mapping of column to value.

    Raises
    ------
    DamagedRowError
        If the row is damaged.
    """
    responses = None if row["responses"] is None else _numbers(row["responses"], "responses")
    outcome = Outcome(
        key=row["key"],
        inputs=_content(row["inputs"], "inputs", dict),
        responses=responses,
        reason=row["reason"],
        seconds=row["seconds"],
        lost=row["status"] == "lost",
        errors=_numbers(row["errors"] or "{}", "errors"),
        unknowns=row["unknowns"],
        worker=row["worker"] or "",
        attempts=row["attempts"] or 1,
    )
    if row["status"] == "done" and not responses:
        raise DamagedRowError("it is done, but has no responses")
    if row["status"] != outcome.status:
        raise DamagedRowError(
            f"its status is {row['status']!r}, but {'it has' if responses else 'it has no'} responses"
        )
    if not isinstance(outcome.seconds, float) or not 0.0 <= outcome.seconds < math.inf:
        raise DamagedRowError(f"its seconds are {outcome.seconds!r}")
    _check_sum(row, RECORDED)
    return outcome


def read_extra(row: Mapping[str, Any]) -> ExtraRow:
    """Make a row from elsewhere from its stored values; otherwise as `read_design`."""
    values = None if row["factors"] is None else _content(row["factors"], "factors", list)
    if values is not None:
        _check_numbers(dict(enumerate(values)), "factors")
    found = ExtraRow(
        role=row["role"],
        dimensions=_numbers(row["dimensions"], "dimensions"),
        outlines=_content(row["outlines"], "outlines", dict),
        values=None if values is None else tuple(values),
        responses=_numbers(row["responses"], "responses"),
        errors=_numbers(row["errors"], "errors"),
        source=row["source"],
    )
    _check_sum(row, EXTRA)
    return found


def _check_sum(row: Mapping[str, Any], columns: Sequence[str]) -> None:
    try:
        expected = checksum([row[name] for name in columns])
    except TypeError:  # a blob
        expected = ""
    if row[CHECKSUM] != expected:
        raise DamagedRowError("its checksum does not fit its content")


def _content(text: object, column: str, kind: type) -> Any:
    """Read a column's JSON."""
    try:
        found = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, kind):
        raise DamagedRowError(f"its {column} cannot be read")
    return found


def _numbers(text: object, column: str) -> dict[str, float]:
    found: dict[str, float] = _content(text, column, dict)
    _check_numbers(found, column)
    return found


def _check_numbers(found: Mapping[Any, object], column: str) -> None:
    for name, value in found.items():
        if not is_number(value) or not -LARGEST <= value <= LARGEST:
            raise DamagedRowError(f"{name} among its {column} is {value!r}, no finite number")
