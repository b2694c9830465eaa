"""The file of a result store: opened if it is one, created if possible, refused otherwise."""

import hashlib
import json
import math
import os
import sqlite3
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import psutil

from crankbase.choices import is_number
from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from fem.responses import RESPONSES
from regression.records import ExtraRow, Outcome

# Marks our files in SQLite's header: "crfm".
APPLICATION_ID = 0x6372666D
# In the header's user version, raised whenever a table changes: stores of other layouts are refused.
SCHEMA_VERSION = 4

# What the view shows as columns of its own; everything else is in its JSON columns.
DIMENSIONS = (
    "crank_radius",
    "main_journal_diameter",
    "pin_diameter",
    "main_journal_length",
    "pin_length",
    "web_width",
    "web_thickness",
    "fillet_radius",
    "main_journal_bore",
    "pin_bore",
    "web_outline",
)
TABLES = (
    """
    CREATE TABLE IF NOT EXISTS designs (
        key TEXT PRIMARY KEY,          -- hash of inputs and model version
        inputs TEXT NOT NULL,          -- JSON, SI units: throw, material, accuracy, stresses
        status TEXT NOT NULL,          -- 'done', 'failed', or 'lost' with its worker: tried again
        responses TEXT,                -- JSON, SI units; null unless done
        reason TEXT,                   -- why it has no responses
        seconds REAL NOT NULL,
        finished_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP,
        errors TEXT,                   -- JSON: estimated relative error of each response
        unknowns INTEGER,              -- of the mesh
        model_version INTEGER,         -- of the finite element model behind the responses
        worker TEXT,                   -- machine and process
        attempts INTEGER,              -- in the run that recorded it
        checksum TEXT                  -- of all of the above but finished_at
    )
    """,
    """
    CREATE TABLE IF NOT EXISTS study_designs (
        study TEXT NOT NULL,           -- hash of the study's plan
        place INTEGER NOT NULL,        -- order in the plan
        role TEXT NOT NULL,            -- 'run' (fitted) or 'held out' (judged by)
        design TEXT NOT NULL,          -- key in designs
        factors TEXT,                  -- JSON: factor to its value, SI units
        added INTEGER,                 -- 1 of a run added to the plan's, null of others
        PRIMARY KEY (study, place)
    )
    """,
    """
    CREATE TABLE IF NOT EXISTS studies (
        study TEXT PRIMARY KEY,
        plan TEXT NOT NULL             -- JSON, SI units
    )
    """,
    """
    CREATE TABLE IF NOT EXISTS extra_rows (
        study TEXT NOT NULL,           -- the study that the row was imported into
        key TEXT NOT NULL,             -- hash of its place, or of what was measured: it stands once
        role TEXT NOT NULL,            -- 'run', 'held out' or 'measured'
        source TEXT NOT NULL,          -- where it comes from
        factors TEXT,                  -- JSON list in the plan's order; null for a measured throw
        dimensions TEXT NOT NULL,      -- JSON, SI units
        outlines TEXT NOT NULL,        -- JSON: fields that hold words
        responses TEXT NOT NULL,       -- JSON, SI units
        errors TEXT NOT NULL,          -- JSON: estimated relative errors, where known
        imported_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP,
        checksum TEXT,                 -- of all of the above but imported_at
        PRIMARY KEY (study, key)
    )
    """,
)


def results_view() -> str:
    """Statement that makes the view `results`, one row for each design of each study."""
    dimensions = (f"{_extract('inputs', f'throw.{name}')} AS {name}" for name in DIMENSIONS)
    responses = (f"{_extract('responses', name)} AS {name}" for name in RESPONSES)
    columns = ", ".join((*dimensions, *responses))
    return (
        "CREATE VIEW results AS SELECT s.study, s.place, s.role, s.design AS key, d.status, d.reason, "
        f"s.factors, s.added, {columns}, d.seconds, d.unknowns, d.model_version, d.worker, d.attempts, "
        "d.finished_at, d.inputs, d.responses, d.errors "
        "FROM study_designs s LEFT JOIN designs d ON d.key = s.design ORDER BY s.study, s.place"
    )


def _extract(column: str, name: str) -> str:
    """A number from a JSON column; null if it is damaged, so that other rows can be read."""
    return f"json_extract(CASE WHEN json_valid(d.{column}) THEN d.{column} END, '$.{name}')"


def missing_parts(connection: sqlite3.Connection) -> list[str]:
    """Name the missing tables and columns of one of our files."""
    missing = []
    for table, columns in _wanted_columns().items():
        present = _columns(connection, table)
        if not present:
            missing.append(f"table {table}")
        else:
            lacking = [name for name in columns if name not in present]
            missing += [f"column {name} in the table {table}" for name in lacking]
    return missing


def _wanted_columns() -> dict[str, list[str]]:
    """Columns that each table has."""
    with closing(sqlite3.connect(":memory:")) as made:
        for statement in TABLES:
            made.execute(statement)
        tables = made.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
        return {table: _columns(made, table) for (table,) in tables}


def _columns(connection: sqlite3.Connection, table: str) -> list[str]:
    return [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]


def prepare(connection: sqlite3.Connection) -> None:
    """Make the tables of an empty file, and the view of the responses that there are now.

    To be called within a transaction.
    """
    view = connection.execute("SELECT sql FROM sqlite_master WHERE name = 'results'").fetchone()
    if view == (results_view(),):
        return
    for statement in TABLES:
        connection.execute(statement)
    connection.execute("DROP VIEW IF EXISTS results")
    connection.execute(results_view())
    connection.execute(f"PRAGMA application_id={APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version={SCHEMA_VERSION}")


def schema_version(connection: sqlite3.Connection) -> int:
    """Return the schema version of a file."""
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    return int(version)


# Seconds to wait for another program that holds the file.
PATIENCE = 30.0
DAMAGED = "it is damaged"
MADE_BY = "allowed is the file in which a study was run"
# What stops a study though the file is a good store; low bytes of SQLite's result codes.
CAUSES = {
    sqlite3.SQLITE_FULL: "the disk is full",
    sqlite3.SQLITE_IOERR: "the disk reports an error, as it also does when it is full",
    sqlite3.SQLITE_READONLY: "it is read-only",
    sqlite3.SQLITE_BUSY: "another program holds it locked",
    sqlite3.SQLITE_LOCKED: "another program holds it locked",
    sqlite3.SQLITE_CANTOPEN: "it cannot be opened, or its folder can only be read",
    sqlite3.SQLITE_CORRUPT: DAMAGED,
    sqlite3.SQLITE_NOTADB: DAMAGED,
}
# Folders of other machines, where a write-ahead log is not safe.
NETWORK_FOLDERS = (
    "nfs",
    "nfs4",
    "cifs",
    "smb3",
    "smbfs",
    "fuse.sshfs",
    "afs",
    "lustre",
    "beegfs",
    "ceph",
    "gpfs",
)


def damaged_store(path: Path, why: str) -> InputError:
    """Return the error that describes the fault of a store."""
    return InputError(
        f"store: given {str(path)!r}, which is damaged ({why}); allowed is a store as a study leaves it, "
        "so use a copy of it, or give a new file name."
    )


@contextmanager
def transaction(connection: sqlite3.Connection) -> Iterator[None]:
    """Write all of a block, or nothing."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        # On a full disk SQLite has rolled back by itself.
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def error_cause(error: Exception) -> str:
    """State why a good store cannot be written; empty if the error is of another kind."""
    code = getattr(error, "sqlite_errorcode", None)
    return "" if code is None else CAUSES.get(code & 0xFF, "")


def open_store(path: Path, readonly: bool) -> sqlite3.Connection:
    """Open a store, created or updated if it is to be written.

    Raises
    ------
    InputError
        If the file is that of another program, of another layout, or lacks a part.
    """
    if readonly or (path.exists() and path.stat().st_size > 0):
        connection = connect_readonly(path)
        try:
            _check_ours(connection, path, readonly)
        except BaseException:
            connection.close()
            raise
        if readonly:
            return connection
        connection.close()
    connection = sqlite3.connect(path, timeout=PATIENCE, isolation_level=None)
    try:
        connection.text_factory = _text
        connection.execute(f"PRAGMA journal_mode={'DELETE' if _on_network(path) else 'WAL'}")
        # Each design goes on from the log to the file at once: a copy of the file alone has all of them.
        connection.execute("PRAGMA wal_autocheckpoint=1")
        with transaction(connection):
            prepare(connection)
    except BaseException:
        connection.close()
        raise
    return connection


def connect_readonly(path: Path) -> sqlite3.Connection:
    """Connect to a file that stays as it is."""
    uri = f"{path.absolute().as_uri()}?mode=ro"
    if not os.access(path.absolute().parent, os.W_OK) and not Path(f"{path}-wal").exists():
        uri += (
            "&immutable=1"  # where SQLite can make no files beside it, nobody can write it either
        )
    connection = sqlite3.connect(uri, uri=True, timeout=PATIENCE)
    connection.text_factory = _text
    return connection


def _text(raw: bytes) -> str:
    """Read a text; one that is none is damaged, and must not keep other rows from being read."""
    return raw.decode("utf-8", "surrogateescape")


def _check_ours(connection: sqlite3.Connection, path: Path, readonly: bool) -> None:
    """Refuse a database of another program, or of another layout, before anything is written."""
    (mark,) = connection.execute("PRAGMA application_id").fetchone()
    (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    version = schema_version(connection)
    if mark == APPLICATION_ID and version == SCHEMA_VERSION:
        missing = missing_parts(connection)
        if missing:
            raise damaged_store(path, f"it has no {missing[0]}")
        return
    if not tables and not readonly:  # its maker died before it became a store
        return
    if mark == APPLICATION_ID:
        raise InputError(
            f"store: given {str(path)!r}, whose layout {version} is of another release; allowed is "
            f"layout {SCHEMA_VERSION}, so {'use that release' if readonly else 'give a new file name'}."
        )
    raise InputError(
        f"store: given {str(path)!r}, which is no result store but the file of another program; "
        f"{MADE_BY if readonly else 'give a new file name'}."
    )


def check_place(path: Path, readonly: bool) -> None:
    """Refuse a path that is not a file, or cannot become one.

    Raises
    ------
    InputError
    """
    if (entry := not_a_file(path)) is not None:
        raise InputError(f"store: given {str(path)!r}, which {entry}.")
    if readonly and not path.is_file():
        raise InputError(f"store: given {str(path)!r}; there is no such file.")
    if not path.absolute().parent.is_dir():
        raise InputError(f"store: given {str(path)!r}; there is no folder {path.parent}.")


def is_database(path: Path) -> bool:
    """Whether a file is an SQLite database, of any program."""
    with path.open("rb") as file:
        return file.read(16) == b"SQLite format 3\0"


def is_ours(path: Path) -> bool:
    """Whether a file's header is that of a store of this layout, even if the rest is damaged."""
    with path.open("rb") as file:
        header = file.read(100)
    version, mark = int.from_bytes(header[60:64]), int.from_bytes(header[68:72])
    return is_database(path) and mark == APPLICATION_ID and version == SCHEMA_VERSION


def _on_network(path: Path) -> bool:
    """Whether a file is in a network folder."""
    folder = path.absolute().resolve().parent
    mounts = {place.mountpoint: place.fstype for place in psutil.disk_partitions(all=True)}
    for place in (folder, *folder.parents):
        if str(place) in mounts:
            return mounts[str(place)] in NETWORK_FOLDERS
    return False


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
