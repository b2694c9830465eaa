"""The result store: one SQLite file, one row per finished design, safe against crashes.

Only the coordinator writes. A design's key is a hash of everything its result depends on, so a
design that is finished is never computed again, in this study or another.
"""

import contextlib
import errno
import hashlib
import json
import math
import os
import sqlite3
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import psutil

from crankbase.choices import is_number
from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from fem.response_table import RESPONSES
from regression.records import (
    MEASURED,
    MOVED,
    SLOPES,
    ExtraRow,
    Outcome,
    StudyStoppedError,
    content_key,
)

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

# Made with the first slopes that are recorded: stores without any lack it.
SLOPES_TABLE = """
    CREATE TABLE IF NOT EXISTS slopes (
        design TEXT PRIMARY KEY,       -- key in designs
        shares TEXT NOT NULL,          -- JSON: d ln(response) / d ln(dimension), by response and dimension
        errors TEXT NOT NULL,          -- JSON: estimated error of the shares of each response
        checksum TEXT                  -- of all of the above
    )
    """


# As that of slopes, for designs whose mesh was moved.
MESHES_TABLE = """
    CREATE TABLE IF NOT EXISTS meshes (
        design TEXT PRIMARY KEY,       -- key in designs
        mesh TEXT NOT NULL,            -- JSON, as of an outcome's mesh (regression.records)
        checksum TEXT                  -- of all of the above
    )
    """

# Made with the view of results: of designs that ask for a moved mesh, what they are in a whole study.
SCALED_TABLE = """
    CREATE TABLE IF NOT EXISTS scaled (
        study TEXT NOT NULL,
        design TEXT NOT NULL,          -- key in designs
        responses TEXT NOT NULL,       -- JSON, SI units
        errors TEXT NOT NULL,          -- JSON: estimated relative error of each response
        PRIMARY KEY (study, design)
    )
    """


def results_view() -> str:
    """Statement that makes the view `results`, one row for each design of each study."""
    dimensions = (f"{_extract('inputs', f'throw.{name}')} AS {name}" for name in DIMENSIONS)
    responses = (f"{_extract('responses', name)} AS {name}" for name in RESPONSES)
    columns = ", ".join((*dimensions, *responses))
    unmoved = f"{_extract('inputs', MOVED)} IS NULL"
    answers = ", ".join(
        f"coalesce(k.{name}, CASE WHEN {unmoved} THEN d.{name} END) AS {name}"
        for name in ("responses", "errors")
    )
    kept = "d.seconds, d.unknowns, d.model_version, d.worker, d.attempts, d.finished_at, d.inputs"
    return (
        "CREATE VIEW results AS WITH known AS (SELECT s.study, s.place, s.role, s.design AS key, d.status, "
        f"d.reason, s.factors, s.added, {kept}, {answers} FROM study_designs s "
        "LEFT JOIN designs d ON d.key = s.design "
        "LEFT JOIN scaled k ON k.study = s.study AND k.design = s.design) "
        "SELECT d.study, d.place, d.role, d.key, d.status, d.reason, d.factors, d.added, "
        f"{columns}, {kept}, d.responses, d.errors FROM known d ORDER BY d.study, d.place"
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


@cache
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
    for statement in (*TABLES, SCALED_TABLE):
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


CHECKSUM = "checksum"
# The checksum is of all other columns, in their order in the table.
UNCHECKED = (CHECKSUM, "finished_at", "imported_at")
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


def design_values(outcome: Outcome, model_version: int | None) -> dict[str, object]:
    """Return the recorded values of a design by column, in the order of its checksum, the last of them."""
    return _with_checksum(
        {
            "key": outcome.key,
            "inputs": json.dumps(outcome.inputs, sort_keys=True),
            "status": outcome.status,
            "responses": None if outcome.responses is None else _json(outcome.responses),
            "reason": outcome.reason,
            "seconds": float(outcome.seconds),
            "errors": _json(outcome.errors),
            "unknowns": outcome.unknowns,
            "model_version": model_version,
            "worker": outcome.worker,
            "attempts": outcome.attempts,
        }
    )


def slope_values(outcome: Outcome) -> dict[str, object]:
    """Return the recorded slopes of a design; otherwise as `design_values`."""
    shares = {name: dict(over) for name, over in outcome.slopes.items()}
    return _with_checksum(
        {
            "design": outcome.key,
            "shares": json.dumps(shares, allow_nan=False),
            "errors": _json(outcome.slope_errors),
        }
    )


def mesh_values(outcome: Outcome) -> dict[str, object]:
    """Return what is recorded of a design's moved mesh; otherwise as `design_values`."""
    mesh = json.dumps(dict(outcome.mesh), allow_nan=False)
    return _with_checksum({"design": outcome.key, "mesh": mesh})


def extra_values(study: str, key: str, row: ExtraRow) -> dict[str, object]:
    """Return the recorded values of a row from elsewhere; otherwise as `design_values`."""
    return _with_checksum(
        {
            "study": study,
            "key": key,
            "role": row.role,
            "source": row.source,
            "factors": None if row.values is None else json.dumps(row.values, allow_nan=False),
            "dimensions": _json(row.dimensions),
            "outlines": json.dumps(dict(row.outlines)),
            "responses": _json(row.responses),
            "errors": _json(row.errors),
        }
    )


def _with_checksum(values: dict[str, object]) -> dict[str, object]:
    return values | {CHECKSUM: checksum([*values.values()])}


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
    _check_sum(row, "designs")
    return outcome


def read_extra(row: Mapping[str, Any]) -> ExtraRow:
    """Make a row from elsewhere from its stored values; otherwise as `read_design`."""
    values = None if row["factors"] is None else _content(row["factors"], "factors", list)
    if values is not None:
        _check_numbers(dict(enumerate(values)), "factors")
    extra = ExtraRow(
        role=row["role"],
        dimensions=_numbers(row["dimensions"], "dimensions"),
        outlines=_content(row["outlines"], "outlines", dict),
        values=None if values is None else tuple(values),
        responses=_numbers(row["responses"], "responses"),
        errors=_numbers(row["errors"], "errors"),
        source=row["source"],
    )
    _check_sum(row, "extra_rows")
    return extra


def _check_sum(row: Mapping[str, Any], table: str) -> None:
    try:
        recorded = [name for name in _wanted_columns()[table] if name not in UNCHECKED]
        expected = checksum([row[name] for name in recorded])
    except TypeError:  # a blob
        expected = ""
    if row[CHECKSUM] != expected:
        raise DamagedRowError("its checksum does not fit its content")


def _check_beside(row: Mapping[str, Any], what: str) -> None:
    if row[CHECKSUM] != checksum([cell for name, cell in row.items() if name != CHECKSUM]):
        raise DamagedRowError(f"the checksum of its {what} does not fit its content")


def _content(text: object, column: str, kind: type) -> Any:
    """Read a column's JSON."""
    try:
        content = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, kind):
        raise DamagedRowError(f"its {column} cannot be read")
    return content


def _numbers(text: object, column: str) -> dict[str, float]:
    numbers: dict[str, float] = _content(text, column, dict)
    _check_numbers(numbers, column)
    return numbers


def _check_numbers(numbers: Mapping[Any, object], column: str) -> None:
    for name, value in numbers.items():
        if not is_number(value) or not -LARGEST <= value <= LARGEST:
            raise DamagedRowError(f"{name} among its {column} is {value!r}, no finite number")


Row = TypeVar("Row", Outcome, ExtraRow)
# Digits in which rows from elsewhere are compared: the same number in another unit differs in its last.
COMPARED = 9


class ResultStore:
    """Finished designs in an SQLite file.

    Parameters
    ----------
    path : path
        The file; created if missing, in an existing folder.
    readonly : bool
        Open an existing store without changing it.

    Attributes
    ----------
    damaged : dict of str to str
        Rows skipped while reading, by design key or position, and their faults.

    Raises
    ------
    InputError
        If the file is not such a store, of another layout, or lacks a table.
    StudyStoppedError
        If the file, here or in any later call, cannot be written: a full disk, a read-only or locked
        file. What was recorded before is kept.
    """

    def __init__(self, path: str | Path, *, readonly: bool = False) -> None:
        self.path = Path(path)
        check_place(self.path, readonly)
        try:
            self._connection = open_store(self.path, readonly)
        except (sqlite3.Error, OSError, UnicodeDecodeError) as error:
            if self.path.is_file() and error_cause(error) not in ("", DAMAGED):
                raise self._stopped(error) from None
            if self.path.is_file() and is_ours(self.path):
                raise damaged_store(self.path, str(error)) from None
            if readonly:
                raise InputError(
                    f"store: given {str(self.path)!r}, which is no result store ({error}); {MADE_BY}."
                ) from None
            if not self.path.is_file():
                raise InputError(
                    f"store: given {str(self.path)!r}, which cannot be made ({error}); allowed is a file in "
                    "a folder that can be written."
                ) from None
            raise InputError(
                f"store: given {str(self.path)!r}, which is no result store and cannot become one "
                f"({error}); give a new file name."
            ) from None
        self._connection.row_factory = sqlite3.Row
        self.damaged: dict[str, str] = {}

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def __enter__(self) -> "ResultStore":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _stopped(self, error: Exception) -> StudyStoppedError:
        return StudyStoppedError(
            f"store: {self.path} cannot be used now ({error_cause(error) or error}); finished designs are "
            "kept, and the same command continues when that is corrected."
        )

    @contextmanager
    def _reading(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            if error_cause(error) not in ("", DAMAGED):
                raise self._stopped(error) from None
            raise damaged_store(self.path, str(error)) from None

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        try:
            with transaction(self._connection):
                yield self._connection
        except sqlite3.Error as error:
            if not error_cause(error):
                raise
            raise self._stopped(error) from None

    def register_study(
        self,
        study: str,
        plan: Mapping[str, object],
        designs: Iterable[tuple[str, str, Mapping[str, float | str]]],
    ) -> None:
        """Record a study's plan and its designs as (role, key, factor values) in order.

        Designs recorded for it before and not among these no longer belong to it, except
        those added to it, which follow these.
        """
        with self._writing() as connection:
            added = connection.execute(
                "SELECT role, design, factors FROM study_designs WHERE study = ? AND added "
                "ORDER BY place",
                (study,),
            ).fetchall()
            rows = [(*row, None) for row in _design_rows(designs)]
            rows += [(*row, 1) for row in added]
            connection.execute(
                "INSERT INTO studies (study, plan) VALUES (?, ?) "
                "ON CONFLICT (study) DO UPDATE SET plan = excluded.plan",
                (study, json.dumps(plan, sort_keys=True)),
            )
            connection.execute("DELETE FROM study_designs WHERE study = ?", (study,))
            connection.executemany(
                "INSERT INTO study_designs (study, place, role, design, factors, added) "
                "VALUES (?, ?, ?, ?, ?, ?)",
                [(study, place, *row) for place, row in enumerate(rows)],
            )

    def add_designs(
        self, study: str, designs: Iterable[tuple[str, str, Mapping[str, float | str]]]
    ) -> None:
        """Add designs to those of a registered study, as (role, key, factor values) in order."""
        with self._writing() as connection:
            (first,) = connection.execute(
                "SELECT coalesce(max(place) + 1, 0) FROM study_designs WHERE study = ?", (study,)
            ).fetchone()
            connection.executemany(
                "INSERT INTO study_designs (study, place, role, design, factors, added) "
                "VALUES (?, ?, ?, ?, ?, 1)",
                [(study, place, *row) for place, row in enumerate(_design_rows(designs), first)],
            )

    def record(self, outcome: Outcome, model_version: int | None = None) -> None:
        """Store the outcome of one design and the version of the model behind it; on disk on return.

        It replaces an earlier one, but a failure or loss never replaces a result: another program that
        uses the same store may have finished the design meanwhile.
        """
        row = design_values(outcome, model_version)
        with self._writing() as connection:
            if self._read(outcome.key) is None:  # a damaged row says nothing worth keeping
                connection.execute("DELETE FROM designs WHERE key = ?", (outcome.key,))
            connection.execute(
                f"{_insertion('designs', 'key', row)}, finished_at = CURRENT_TIMESTAMP "
                "WHERE designs.status <> 'done' OR excluded.status = 'done'",
                row,
            )
            if outcome.status == "done" and SLOPES in outcome.inputs:
                slopes = slope_values(outcome)
                connection.execute(SLOPES_TABLE)
                connection.execute(_insertion("slopes", "design", slopes), slopes)
            if outcome.status == "done" and MOVED in outcome.inputs:
                mesh = mesh_values(outcome)
                connection.execute(MESHES_TABLE)
                connection.execute(_insertion("meshes", "design", mesh), mesh)
            self.damaged.pop(outcome.key, None)

    def keep_scaled(
        self, study: str, answers: Mapping[str, tuple[Mapping[str, float], Mapping[str, float]]]
    ) -> None:
        """Store answers and their errors on moved meshes, by design, as they are in a whole study."""
        with self._writing() as connection:
            connection.execute("DELETE FROM scaled WHERE study = ?", (study,))
            connection.executemany(
                "INSERT INTO scaled (study, design, responses, errors) VALUES (?, ?, ?, ?)",
                [(study, design, *map(_json, both)) for design, both in answers.items()],
            )

    def outcomes(self, keys: Iterable[str]) -> dict[str, Outcome]:
        """Return the available outcomes of designs, by key."""
        with self._reading():
            outcomes = {key: self._read(key) for key in keys}
        return {key: outcome for key, outcome in outcomes.items() if outcome is not None}

    def _read(self, key: str) -> Outcome | None:
        """Read a design's row; None if there is none, or a damaged one."""
        query = "SELECT * FROM designs WHERE key = ?"
        row = self._connection.execute(query, (key,)).fetchone()
        return None if row is None else self._read_or_skip(key, self._whole_design, dict(row))

    def _whole_design(self, row: Mapping[str, Any]) -> Outcome:
        """Make an outcome of a design's row and those of its slopes and its mesh; as `read_design`."""
        outcome = read_design(row)
        if outcome.responses is None:
            return outcome
        if MOVED in outcome.inputs:
            mesh_row = self._beside("meshes", outcome.key, "mesh")
            outcome = replace(outcome, mesh=_content(mesh_row["mesh"], "mesh", dict))
            _check_beside(mesh_row, "mesh")
        if SLOPES not in outcome.inputs:
            return outcome
        slopes_row = self._beside("slopes", outcome.key, "slopes")
        shares = _content(slopes_row["shares"], "slopes", dict)
        for name, over in shares.items():
            if not isinstance(over, dict):
                raise DamagedRowError(f"its slopes of {name} cannot be read")
            _check_numbers(over, f"slopes of {name}")
        errors = _numbers(slopes_row["errors"], "errors of slopes")
        _check_beside(slopes_row, "slopes")
        return replace(outcome, slopes=shares, slope_errors=errors)

    def _beside(self, table: str, key: str, what: str) -> dict[str, Any]:
        """Read the row of a design in a table that has one of some designs alone."""
        found = None
        if _columns(self._connection, table):
            query = f"SELECT * FROM {table} WHERE design = ?"
            found = self._connection.execute(query, (key,)).fetchone()
        if found is None:
            raise DamagedRowError(f"its {what} {'are' if what == 'slopes' else 'is'} missing")
        return dict(found)

    def _read_or_skip(
        self, place: str, read: Callable[..., Row], row: Mapping[str, Any]
    ) -> Row | None:
        """Read a row, or skip a damaged one and record the reason."""
        try:
            return read(row)
        except DamagedRowError as error:
            self.damaged[place] = str(error)
            return None

    def results(self) -> Iterator[tuple[str, Outcome, int | None]]:
        """List the finished designs of all studies: (role, outcome, model version), each once, in order."""
        with self._reading():
            rows = self._connection.execute(
                "SELECT s.role, d.*, min(s.rowid) AS first FROM designs d "
                "JOIN study_designs s ON s.design = d.key GROUP BY d.key ORDER BY first"
            )
            for row in map(dict, rows):
                outcome = self._read_or_skip(row["key"], self._whole_design, row)
                if outcome is not None and outcome.responses is not None:
                    yield row["role"], outcome, row["model_version"]

    def every_outcome(self) -> Iterator[Outcome]:
        """List the sound rows of all designs, whether a study has them or not."""
        with self._reading():
            for row in map(dict, self._connection.execute("SELECT * FROM designs")):
                outcome = self._read_or_skip(str(row["key"]), self._whole_design, row)
                if outcome is not None:
                    yield outcome

    def older_results(self, model_version: int) -> dict[int, int]:
        """Number of results of each earlier version of the finite element model."""
        with self._reading():
            return dict(
                self._connection.execute(
                    "SELECT model_version, count(*) FROM designs WHERE status = 'done' "
                    "AND model_version < ? GROUP BY model_version",
                    (model_version,),
                )
            )

    def studies(self) -> dict[str, dict[str, Any] | None]:
        """Return the plans of all studies in the store, by study key; None of one that is damaged."""
        with self._reading():
            rows = self._connection.execute("SELECT study, plan FROM studies ORDER BY rowid")
            return {study: read_plan(text) for study, text in rows}

    def added_designs(self, study: str) -> tuple[dict[str, Any], ...]:
        """Return the factor values of the runs added to a study, in order, except damaged ones."""
        with self._reading():
            rows = self._connection.execute(
                "SELECT * FROM study_designs WHERE study = ? ORDER BY place", (study,)
            ).fetchall()
        read = [read_plan(row["factors"]) for row in map(dict, rows) if row["added"]]
        return tuple(factors for factors in read if factors is not None)

    def study_designs(self, study: str) -> tuple[tuple[str, str, dict[str, Any]], ...]:
        """Return a study's designs as `register_study` was given them, in order.

        A study in which a row of them is damaged or missing has none.
        """
        with self._reading():
            rows = self._connection.execute(
                "SELECT * FROM study_designs WHERE study = ? ORDER BY place", (study,)
            ).fetchall()
        listed = tuple(
            (row["role"], row["design"], read_plan(row["factors"]))
            for place, row in enumerate(map(dict, rows))
            if row["factors"] and row["place"] == place
        )
        sound = tuple((role, key, factors) for role, key, factors in listed if factors is not None)
        return sound if len(sound) == len(rows) else ()

    def add_extra_rows(self, study: str, rows: Iterable[ExtraRow]) -> int:
        """Store rows from elsewhere for a study; return how many of them are new.

        A result at the same factor values replaces an earlier one: finite elements repeat
        exactly. Measured rows do not: one replaces another if throw and values are the same.
        """
        listed = [extra_values(study, _extra_key(row), row) for row in rows]
        with self._writing() as connection:
            (before,) = connection.execute("SELECT count(*) FROM extra_rows").fetchone()
            for values in listed:
                connection.execute(_insertion("extra_rows", "study, key", values), values)
            (after,) = connection.execute("SELECT count(*) FROM extra_rows").fetchone()
        return int(after - before)

    def extra_rows(self, study: str | None = None) -> tuple[ExtraRow, ...]:
        """Return the rows from elsewhere of a study, or of all, in the order of import."""
        with self._reading():
            rows = self._connection.execute(
                "SELECT * FROM extra_rows WHERE :study IS NULL OR study = :study ORDER BY rowid",
                {"study": study},
            ).fetchall()
        read = (
            self._read_or_skip(f"row {place} from elsewhere", read_extra, dict(row))
            for place, row in enumerate(rows, start=1)
        )
        return tuple(row for row in read if row is not None)


def read_plan(text: object) -> dict[str, Any] | None:
    """Read the JSON of a plan, or of a design's factors; None if it is damaged."""
    try:
        record = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        return None
    return record if isinstance(record, dict) else None


def _design_rows(
    designs: Iterable[tuple[str, str, Mapping[str, float | str]]],
) -> list[tuple[str, str, str]]:
    return [
        (role, key, json.dumps(dict(factors), allow_nan=False)) for role, key, factors in designs
    ]


def _insertion(table: str, key: str, values: Iterable[str]) -> str:
    """Statement that inserts values by column, or overwrites those of the same key."""
    columns = list(values)
    overwritten = ", ".join(f"{name} = excluded.{name}" for name in columns)
    return (
        f"INSERT INTO {table} ({', '.join(columns)}) VALUES (:{', :'.join(columns)}) "
        f"ON CONFLICT ({key}) DO UPDATE SET {overwritten}"
    )


def _extra_key(row: ExtraRow) -> str:
    """Hash the identity of a row from elsewhere; for a computed row its factor values."""
    values = None if row.values is None else [_rounded(value) for value in row.values]
    if row.role != MEASURED:
        return content_key(["computed", values])
    numbers = [
        {name: _rounded(value) for name, value in part.items()}
        for part in (row.dimensions, row.responses)
    ]
    return content_key([MEASURED, values, dict(row.outlines), *numbers])


def _rounded(value: float) -> str:
    # Adding zero makes a negative zero positive.
    return f"{value + 0.0:.{COMPARED - 1}e}"


if sys.platform != "win32":
    import fcntl

# The byte that everyone who has the file open shares, and the number of the other bytes.
IN_USE, BYTES = 0, 2**60


class Claims:
    """Claims of this program on the designs of a store, until they are released or the program ends."""

    def __init__(self, store: Path) -> None:
        self._path = Path(f"{store}-claims")
        self._file: int | None = None
        with contextlib.suppress(OSError):  # the store's own errors say what is wrong with the disk
            self._file = self._opened()

    def __enter__(self) -> "Claims":
        return self

    def __exit__(self, *_: object) -> None:
        """Release all claims; the last program removes the file."""
        if self._file is None:
            return
        if self.alone():
            self._path.unlink(missing_ok=True)
        os.close(self._file)
        self._file = None

    def take(self, key: str) -> bool:
        """Claim a design; False if another program has it."""
        return self._locked(_place(key))

    def release(self, key: str) -> None:
        """Release a design."""
        if self._file is not None:
            fcntl.lockf(self._file, fcntl.LOCK_UN, 1, _place(key))

    def alone(self) -> bool:
        """Keep other programs away from the store; False if there is one."""
        return self._locked(IN_USE)

    def _locked(self, place: int) -> bool:
        if self._file is None:
            return True
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, place)
        except OSError as error:
            # A file system without locks grants every claim.
            return error.errno not in (errno.EACCES, errno.EAGAIN)
        return True

    def _opened(self) -> int | None:
        while sys.platform != "win32":
            file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            with contextlib.suppress(OSError):
                fcntl.lockf(file, fcntl.LOCK_SH, 1, IN_USE)
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(file), self._path.stat()):
                    return file
            os.close(file)  # another program has just removed it
        return None


def _place(key: str) -> int:
    return 1 + int.from_bytes(hashlib.sha256(key.encode()).digest()[:8]) % BYTES
