"""The result store: one SQLite file, one row per finished design, safe against sudden death.

Only the coordinator writes. A design's key is a hash of everything its result depends on, so a
design that is finished is never computed again, in this study or another.
"""

import hashlib
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from geometry.errors import InputError

# Marks our files in SQLite's header: "crfm".
APPLICATION_ID = 0x6372666D
SCHEMA = """
CREATE TABLE IF NOT EXISTS designs (
    key TEXT PRIMARY KEY,          -- hash of inputs: throw, material, accuracy, model version
    inputs TEXT NOT NULL,          -- JSON, SI units
    status TEXT NOT NULL,          -- 'done', 'failed', or 'lost' with its worker: tried again
    responses TEXT,                -- JSON, SI units; null when failed
    reason TEXT,                   -- why it failed
    seconds REAL NOT NULL,
    finished_at TEXT NOT NULL DEFAULT CURRENT_TIMESTAMP
);
CREATE TABLE IF NOT EXISTS study_designs (
    study TEXT NOT NULL,           -- hash of the study's plan
    place INTEGER NOT NULL,        -- order in the plan
    role TEXT NOT NULL,            -- 'run' (fitted) or 'held out' (judged by)
    design TEXT NOT NULL,          -- key in designs
    PRIMARY KEY (study, place)
);
CREATE TABLE IF NOT EXISTS studies (
    study TEXT PRIMARY KEY,
    plan TEXT NOT NULL             -- JSON, SI units
);
CREATE VIEW IF NOT EXISTS results AS
    SELECT s.study, s.place, s.role, d.status, d.reason, d.inputs, d.responses, d.seconds,
           json_extract(d.responses, '$.axial_compliance_pinned') AS axial_compliance_pinned,
           json_extract(d.responses, '$.torsional_compliance_pinned') AS torsional_compliance_pinned
    FROM study_designs s LEFT JOIN designs d ON d.key = s.design ORDER BY s.study, s.place;
"""


@dataclass(frozen=True)
class Outcome:
    """What became of one design: its responses, or the reason why it has none.

    `lost` marks designs whose worker died or was ended, which says nothing about the design.
    """

    key: str
    inputs: Mapping[str, object]
    responses: Mapping[str, float] | None
    reason: str | None
    seconds: float
    lost: bool = False


def content_key(content: object) -> str:
    """Hash any JSON content, independent of the order of its keys."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def _open_readonly(path: Path) -> sqlite3.Connection:
    try:
        connection = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)
        (found,) = connection.execute("PRAGMA application_id").fetchone()
    except sqlite3.Error as error:
        raise InputError(
            f"store: given {str(path)!r}, which is no result store ({error})."
        ) from None
    if found != APPLICATION_ID:
        connection.close()
        raise InputError(
            f"store: given {str(path)!r}, which is no result store but the file of another program."
        )
    return connection


def _refuse_foreign(path: Path) -> None:
    """Refuse a database of another program before anything is written to it."""
    if not path.exists() or path.stat().st_size == 0:
        return
    connection = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)
    try:
        (found,) = connection.execute("PRAGMA application_id").fetchone()
        (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    finally:
        connection.close()
    if found != APPLICATION_ID and tables:
        raise sqlite3.DatabaseError("it is the database of another program")


class ResultStore:
    """Finished designs in an SQLite file.

    Parameters
    ----------
    path : path
        The file; made if missing. Not on a network folder: SQLite's write-ahead log needs a local one.
    readonly : bool
        Open an existing store and leave it as it is.

    Raises
    ------
    InputError
        If the file is not such a store or cannot be written.
    """

    def __init__(self, path: str | Path, *, readonly: bool = False) -> None:
        self.path = Path(path)
        if readonly:
            self._connection = _open_readonly(self.path)
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            _refuse_foreign(self.path)
            self._connection = sqlite3.connect(self.path, timeout=30.0, isolation_level=None)
            self._connection.execute("PRAGMA journal_mode=WAL")
            self._connection.execute(f"PRAGMA application_id={APPLICATION_ID}")
            self._connection.executescript(SCHEMA)
        except (sqlite3.Error, OSError) as error:
            raise InputError(
                f"store: given {str(self.path)!r}, which is no result store and cannot become one "
                f"({error}); give a new file name."
            ) from None

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def __enter__(self) -> "ResultStore":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield self._connection
        except BaseException:
            self._connection.execute("ROLLBACK")
            raise
        self._connection.execute("COMMIT")

    def register_study(
        self, study: str, plan: Mapping[str, object], designs: Iterable[tuple[str, str]]
    ) -> None:
        """Record a study's plan and its designs as (role, key) in order."""
        with self._transaction() as connection:
            connection.execute(
                "INSERT OR IGNORE INTO studies (study, plan) VALUES (?, ?)",
                (study, json.dumps(plan, sort_keys=True)),
            )
            connection.executemany(
                "INSERT OR IGNORE INTO study_designs (study, place, role, design) VALUES (?, ?, ?, ?)",
                [(study, place, role, key) for place, (role, key) in enumerate(designs)],
            )

    def record(self, outcome: Outcome) -> None:
        """Keep the outcome of one design; it is on disk when this returns."""
        responses = None
        if outcome.responses is not None:
            responses = json.dumps(dict(outcome.responses), allow_nan=False)
        status = "lost" if outcome.lost else "failed" if responses is None else "done"
        with self._transaction() as connection:
            connection.execute(
                "INSERT OR REPLACE INTO designs (key, inputs, status, responses, reason, seconds) "
                "VALUES (?, ?, ?, ?, ?, ?)",
                (
                    outcome.key,
                    json.dumps(outcome.inputs, sort_keys=True),
                    status,
                    responses,
                    outcome.reason,
                    outcome.seconds,
                ),
            )

    def outcomes(self, keys: Iterable[str]) -> dict[str, Outcome]:
        """Return the outcomes of those designs that have one, by key."""
        found = {}
        for key in keys:
            row = self._connection.execute(
                "SELECT inputs, responses, reason, seconds, status FROM designs WHERE key = ?",
                (key,),
            ).fetchone()
            if row is not None:
                responses = None if row[1] is None else json.loads(row[1])
                found[key] = Outcome(
                    key, json.loads(row[0]), responses, row[2], row[3], row[4] == "lost"
                )
        return found

    def studies(self) -> dict[str, dict[str, object]]:
        """Return the plans of all studies in the store, by study key."""
        rows = self._connection.execute("SELECT study, plan FROM studies ORDER BY rowid")
        return {study: json.loads(plan) for study, plan in rows}
