"""A sound result store in place of a damaged one: every row that is still valid, byte for byte."""

import itertools
import os
import shutil
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crankbase.errors import InputError
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.records import StudyStoppedError, content_key
from regression.runs.store import Claims, ResultStore, read_plan
from regression.runs.store_file import (
    CHECKSUMS_SINCE,
    SCHEMA_VERSION,
    connect_readonly,
    schema_version,
    transaction,
    wanted_columns,
)
from regression.runs.store_rows import DamagedRowError, read_design, read_extra
from regression.runs.study import is_design

# No row takes less of the file than so many bytes.
SMALLEST_ROW = 32
# What SQLite keeps beside the file: a log, which may hold the newest rows, and its index.
LOG, INDEX = "-wal", "-shm"
# What SQLite raises where a file is damaged; its messages may quote text that is none.
UNREADABLE = (sqlite3.DatabaseError, UnicodeDecodeError)


@dataclass(frozen=True)
class RebuiltStore:
    """Result of a repair.

    Attributes
    ----------
    original : Path
        Path of the damaged file.
    designs, extra_rows, studies : int
        Rows that were kept.
    """

    original: Path
    designs: int
    extra_rows: int
    studies: int


def rebuild_store(path: str | Path) -> RebuiltStore:
    """Replace a damaged store by one with only its sound rows; the damaged file is kept under a new name.

    Parameters
    ----------
    path : path
        A store that `check_store` has found damaged.

    Raises
    ------
    InputError
        If its rows have no checksums, so that none can be verified.
    StudyStoppedError
        If another program works on it, or a file cannot be written.
    """
    file = Path(path)
    with Claims(file) as claims:
        if not claims.alone():
            raise StudyStoppedError(
                f"store: {file} cannot be repaired now, because another program works on it; repair it when "
                "that has ended."
            )
        new = Path(f"{file}.repaired")
        try:
            original = _copy_aside(file)
            new.unlink(missing_ok=True)
            kept = _copy_sound_rows(file, new)
            for ending in (LOG, INDEX):  # they belong to the damaged file
                Path(f"{file}{ending}").unlink(missing_ok=True)
            os.replace(new, file)
        except (OSError, sqlite3.Error) as error:
            raise StudyStoppedError(
                f"store: {file} cannot be repaired now ({getattr(error, 'strerror', error)}); it is as "
                "it was."
            ) from None
        finally:
            new.unlink(missing_ok=True)
    return RebuiltStore(original, kept["designs"], kept["extra_rows"], kept["studies"])


def _copy_aside(file: Path) -> Path:
    """Copy a store and its log to an unused name."""
    names = (Path(f"{file}.damaged{number or ''}") for number in itertools.count())
    free = next(name for name in names if not name.exists())
    try:
        shutil.copy2(file, free)
        with suppress(FileNotFoundError):
            shutil.copy2(f"{file}{LOG}", f"{free}{LOG}")
    except OSError:
        free.unlink(missing_ok=True)
        raise
    return free


def _copy_sound_rows(old: Path, new: Path) -> dict[str, int]:
    """Copy the valid rows of one store into another, table by table; return numbers of rows."""
    plans: dict[str, StudyPlan | None] = {}

    def is_study(row: Mapping[str, Any]) -> bool:
        plan = read_plan(row["plan"])
        if plan is None or content_key(plan) != row["study"]:
            return False
        own = plan.get("model_version") == MODEL_VERSION
        plans[row["study"]] = StudyPlan.from_record(plan) if own else None
        return True

    def is_listed(row: Mapping[str, Any]) -> bool:
        factors = read_plan(row["factors"])
        if factors is None or row["study"] not in plans:
            return False
        plan = plans[row["study"]]
        # Those of the plan are listed again by its next run.
        return plan is None or not row["added"] or is_design(plan, row["design"], factors)

    sound: dict[str, Callable[[Mapping[str, Any]], object]] = {
        "designs": read_design,
        "studies": is_study,
        "study_designs": is_listed,
        "extra_rows": read_extra,
    }
    wanted = wanted_columns()
    with closing(connect_readonly(old)) as source:
        source.text_factory = lambda raw: raw.decode(
            "utf-8", "replace"
        )  # what is written must be text
        # Also where the file is shorter than its header says.
        source.execute("PRAGMA writable_schema=ON")
        with suppress(*UNREADABLE):
            if schema_version(source) < CHECKSUMS_SINCE:
                raise InputError(
                    f"store: given {str(old)!r}, which is damaged and of layout "
                    f"{schema_version(source)}; allowed is layout {CHECKSUMS_SINCE} to {SCHEMA_VERSION}, "
                    "because rows of others have no checksums, and nothing shows which of them are sound."
                )
        rows = {
            table: [
                row
                for row in _readable_rows(source, table, tuple(wanted[table]), old)
                if _is_sound(test, dict.fromkeys(wanted[table]) | row)
            ]
            for table, test in sound.items()
        }
    ResultStore(new).close()
    with closing(sqlite3.connect(new, isolation_level=None)) as made, transaction(made):
        for table, listed in rows.items():
            for row in listed:
                made.execute(
                    f"INSERT OR IGNORE INTO {table} ({', '.join(row)}) VALUES ({', '.join('?' * len(row))})",
                    tuple(row.values()),
                )
    return {table: len(listed) for table, listed in rows.items()}


def _is_sound(test: Callable[[Mapping[str, Any]], object], row: Mapping[str, Any]) -> bool:
    try:
        return bool(test(row))
    except DamagedRowError:
        return False


def _readable_rows(
    connection: sqlite3.Connection, table: str, wanted: tuple[str, ...], file: Path
) -> Iterator[dict[str, Any]]:
    """Read a table row by row, past what cannot be read; columns whose names are damaged by their order."""
    try:
        present = [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]
    except UNREADABLE:  # what tables there are cannot be read
        return
    lacking = (name for name in wanted if name not in present)
    columns = [name if name in wanted else next(lacking, "") for name in present]
    log = Path(f"{file}{LOG}")
    size = file.stat().st_size + (log.stat().st_size if log.is_file() else 0)
    named = ", ".join(f"c{number}" for number in range(len(columns)))
    query = (
        f"WITH named(number, {named}) AS (SELECT rowid, * FROM {table}) "
        f"SELECT {named} FROM named WHERE number = ?"
    )
    for number in range(1, size // SMALLEST_ROW if columns else 0):
        with suppress(*UNREADABLE):
            row = connection.execute(query, (number,)).fetchone()
            if row is not None:
                found = dict(zip(columns, row, strict=True))
                yield {name: found[name] for name in wanted if name in found}
