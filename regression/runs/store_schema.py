"""The tables of a result store, and the update of files of earlier releases."""

import sqlite3
from contextlib import closing

from fem.responses import RESPONSES
from regression.runs.store_rows import (
    CHECKSUM,
    EXTRA,
    RECORDED,
    DamagedRowError,
    checksum,
    read_design,
    read_extra,
)

# Marks our files in SQLite's header: "crfm".
APPLICATION_ID = 0x6372666D
# In the header's user version: 0 is the first release's, raised whenever a table changes.
SCHEMA_VERSION = 4
# The versions that brought rows from elsewhere, and checksums of rows.
EXTRA_ROWS_SINCE, CHECKSUMS_SINCE = 2, 3

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
# Those of the first release.
FIRST_TABLES = ("designs", "study_designs", "studies")
# Its designs do not tell their model version; the studies that hold them do.
FILL_MODEL_VERSION = """
    UPDATE designs SET model_version = (
        SELECT CASE WHEN json_valid(s.plan) THEN json_extract(s.plan, '$.model_version') END
        FROM study_designs d JOIN studies s ON s.study = d.study WHERE d.design = designs.key
    ) WHERE model_version IS NULL
"""


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
    version, wanted = schema_version(connection), wanted_columns()
    missing = []
    for table in FIRST_TABLES if version < CHECKSUMS_SINCE else wanted:
        columns = _columns(connection, table)
        if not columns:
            missing.append(f"table {table}")
        elif version == SCHEMA_VERSION:
            lacking = [name for name in wanted[table] if name not in columns]
            missing += [f"column {name} in the table {table}" for name in lacking]
    return missing


def wanted_columns() -> dict[str, dict[str, str]]:
    """Columns that each table has in this release, with their types."""
    with closing(sqlite3.connect(":memory:")) as made:
        for statement in TABLES:
            made.execute(statement)
        return {table: _columns(made, table) for table in _tables(made)}


def _tables(connection: sqlite3.Connection) -> list[str]:
    return [n for (n,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]


def _columns(connection: sqlite3.Connection, table: str) -> dict[str, str]:
    return {row[1]: row[2] for row in connection.execute(f"PRAGMA table_info({table})")}


def _add_checksums(connection: sqlite3.Connection) -> None:
    """Give a checksum to each row that an earlier release wrote and that can be read."""
    for table, columns, read in (
        ("designs", RECORDED, read_design),
        ("extra_rows", EXTRA, read_extra),
    ):
        for number, *values in connection.execute(
            f"SELECT rowid, {', '.join(columns)} FROM {table}"
        ).fetchall():
            try:
                read(dict(zip(columns, values, strict=True)), checked=False)
            except DamagedRowError:
                continue  # without a checksum it counts as damaged from now on
            connection.execute(
                f"UPDATE {table} SET {CHECKSUM} = ? WHERE rowid = ?", (checksum(values), number)
            )


def prepare(connection: sqlite3.Connection) -> None:
    """Make the tables of an empty file, or bring those of an earlier release up to date.

    To be called within a transaction.
    """
    version, tables = schema_version(connection), _tables(connection)
    view = connection.execute("SELECT sql FROM sqlite_master WHERE name = 'results'").fetchone()
    if version == SCHEMA_VERSION and view == (results_view(),):
        return
    for statement in TABLES:
        connection.execute(statement)
    for table, columns in wanted_columns().items():
        present = _columns(connection, table)
        for name, kind in columns.items():
            if name not in present:
                connection.execute(f"ALTER TABLE {table} ADD COLUMN {name} {kind}")
    if "designs" in tables and version < SCHEMA_VERSION:
        connection.execute(FILL_MODEL_VERSION)
        if version < CHECKSUMS_SINCE:
            _add_checksums(connection)
    connection.execute("DROP VIEW IF EXISTS results")
    connection.execute(results_view())
    connection.execute(f"PRAGMA application_id={APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version={SCHEMA_VERSION}")


def schema_version(connection: sqlite3.Connection) -> int:
    """Return the schema version of a file."""
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    return int(version)
