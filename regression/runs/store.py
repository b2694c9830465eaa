"""The result store: one SQLite file, one row per finished design, safe against sudden death.

Only the coordinator writes. A design's key is a hash of everything its result depends on, so a
design that is finished is never computed again, in this study or another.
"""

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil

from crankbase.errors import InputError
from regression.records import MEASURED, ExtraRow, Outcome, StudyStoppedError, content_key
from regression.runs.store_schema import APPLICATION_ID, SCHEMA_VERSION, prepare, schema_version

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
    sqlite3.SQLITE_CANTOPEN: "it cannot be opened",
    sqlite3.SQLITE_CORRUPT: DAMAGED,
    sqlite3.SQLITE_NOTADB: DAMAGED,
}
# What is recorded of a design.
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
# What is kept of a row from elsewhere.
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
# Digits in which rows from elsewhere are compared: the same number in another unit differs in its last.
COMPARED = 9
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


class ResultStore:
    """Finished designs in an SQLite file.

    Parameters
    ----------
    path : path
        The file; made if missing, in a folder that there is. A file of an earlier release is brought
        up to date: its rows stay, and no study of this release uses results of another model version.
    readonly : bool
        Open an existing store and leave it as it is.

    Raises
    ------
    InputError
        If the file is no such store, or of a later release.
    StudyStoppedError
        If the file, here or in any later call, cannot be written: a full disk, a read-only or locked
        file. What was recorded before is kept.
    """

    def __init__(self, path: str | Path, *, readonly: bool = False) -> None:
        self.path = Path(path)
        _check_place(self.path, readonly)
        try:
            self._connection = _open(self.path, readonly)
        except (sqlite3.Error, OSError) as error:
            if self.path.is_file() and _cause(error) not in ("", DAMAGED):
                raise self._stopped(error) from None
            if readonly:
                raise InputError(
                    f"store: given {str(self.path)!r}, which is no result store ({error}); {MADE_BY}."
                ) from None
            raise InputError(
                f"store: given {str(self.path)!r}, which is no result store and cannot become one "
                f"({error}); give a new file name."
            ) from None
        self._connection.row_factory = sqlite3.Row

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def __enter__(self) -> "ResultStore":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _stopped(self, error: Exception) -> StudyStoppedError:
        return StudyStoppedError(
            f"store: {self.path} cannot be used now ({_cause(error) or error}); finished designs are "
            "kept, and the same command continues when that is mended."
        )

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        try:
            with _transaction(self._connection):
                yield self._connection
        except sqlite3.Error as error:
            if not _cause(error):
                raise
            raise self._stopped(error) from None

    def register_study(
        self,
        study: str,
        plan: Mapping[str, object],
        designs: Iterable[tuple[str, str, Mapping[str, float | str]]],
    ) -> None:
        """Record a study's plan and its designs as (role, key, factor values) in order.

        Designs that were recorded for it before and are not among these are no longer its own.
        """
        with self._writing() as connection:
            connection.execute(
                "INSERT OR IGNORE INTO studies (study, plan) VALUES (?, ?)",
                (study, json.dumps(plan, sort_keys=True)),
            )
            connection.execute("DELETE FROM study_designs WHERE study = ?", (study,))
            connection.executemany(
                "INSERT INTO study_designs (study, place, role, design, factors) "
                "VALUES (?, ?, ?, ?, ?)",
                [
                    (study, place, role, key, json.dumps(dict(factors), allow_nan=False))
                    for place, (role, key, factors) in enumerate(designs)
                ],
            )

    def record(self, outcome: Outcome, model_version: int | None = None) -> None:
        """Keep the outcome of one design; on disk when this returns.

        It takes the place of an earlier one, but no result gives way to a failure or a loss: another
        program that works on the same store may have finished the design meanwhile.

        Parameters
        ----------
        outcome : Outcome
        model_version : int, optional
            Version of the model behind it.
        """
        row = (
            outcome.key,
            json.dumps(outcome.inputs, sort_keys=True),
            outcome.status,
            None if outcome.responses is None else _json(outcome.responses),
            outcome.reason,
            outcome.seconds,
            _json(outcome.errors),
            outcome.unknowns,
            model_version,
            outcome.worker,
            outcome.attempts,
        )
        with self._writing() as connection:
            connection.execute(
                f"INSERT INTO designs ({', '.join(RECORDED)}) "
                f"VALUES ({', '.join('?' * len(RECORDED))}) "
                f"ON CONFLICT (key) DO UPDATE SET {_overwritten(RECORDED)}, "
                "finished_at = CURRENT_TIMESTAMP "
                "WHERE designs.status <> 'done' OR excluded.status = 'done'",
                row,
            )

    def outcomes(self, keys: Iterable[str]) -> dict[str, Outcome]:
        """Return the outcomes of those designs that have one, by key."""
        found = {}
        for key in keys:
            query = "SELECT * FROM designs WHERE key = ?"
            row = self._connection.execute(query, (key,)).fetchone()
            if row is not None:
                found[key] = _outcome(dict(row))
        return found

    def results(self) -> Iterator[tuple[str, Outcome, int | None]]:
        """List the finished designs of all studies: (role, outcome, model version), each once, as planned."""
        rows = self._connection.execute(
            "SELECT s.role, d.*, min(s.rowid) AS first FROM designs d "
            "JOIN study_designs s ON s.design = d.key "
            "WHERE d.status = 'done' GROUP BY d.key ORDER BY first"
        )
        for row in map(dict, rows):
            yield row["role"], _outcome(row), row.get("model_version")

    def studies(self) -> dict[str, dict[str, Any]]:
        """Return the plans of all studies in the store, by study key."""
        rows = self._connection.execute("SELECT study, plan FROM studies ORDER BY rowid")
        return {study: json.loads(plan) for study, plan in rows}

    def study_designs(self, study: str) -> tuple[tuple[str, str, dict[str, Any]], ...]:
        """Return a study's designs as `register_study` was given them, in order.

        Of a study of the first release, which did not keep factor values, there are none.
        """
        rows = self._connection.execute(
            "SELECT * FROM study_designs WHERE study = ? ORDER BY place", (study,)
        )
        return tuple(
            (row["role"], row["design"], json.loads(row["factors"]))
            for row in map(dict, rows)
            if row.get("factors")
        )

    def add_extra_rows(self, study: str, rows: Iterable[ExtraRow]) -> int:
        """Keep rows from elsewhere beside a study; return how many of them are new.

        A result at the same factor values as an earlier one takes its place: finite elements repeat
        exactly. Measured rows do not: one takes the place of another if throw and values are the same.
        """
        listed = [(study, _extra_key(row), row) for row in rows]
        with self._writing() as connection:
            (before,) = connection.execute("SELECT count(*) FROM extra_rows").fetchone()
            connection.executemany(
                f"INSERT INTO extra_rows ({', '.join(EXTRA)}) VALUES ({', '.join('?' * len(EXTRA))}) "
                f"ON CONFLICT (study, key) DO UPDATE SET {_overwritten(EXTRA)}",
                [
                    (
                        study,
                        key,
                        row.role,
                        row.source,
                        None if row.values is None else json.dumps(row.values),
                        _json(row.dimensions),
                        json.dumps(dict(row.outlines)),
                        _json(row.responses),
                        _json(row.errors),
                    )
                    for study, key, row in listed
                ],
            )
            (after,) = connection.execute("SELECT count(*) FROM extra_rows").fetchone()
        return int(after - before)

    def extra_rows(self, study: str) -> tuple[ExtraRow, ...]:
        """Return the rows from elsewhere that stand beside a study, in the order of import."""
        if schema_version(self._connection) < SCHEMA_VERSION:
            return ()
        rows = self._connection.execute(
            "SELECT role, dimensions, outlines, factors, responses, errors, source FROM extra_rows "
            "WHERE study = ? ORDER BY rowid",
            (study,),
        )
        return tuple(
            ExtraRow(
                role=row["role"],
                dimensions=json.loads(row["dimensions"]),
                outlines=json.loads(row["outlines"]),
                values=None if row["factors"] is None else tuple(json.loads(row["factors"])),
                responses=json.loads(row["responses"]),
                errors=json.loads(row["errors"]),
                source=row["source"],
            )
            for row in rows
        )


def _overwritten(columns: Iterable[str]) -> str:
    return ", ".join(f"{name} = excluded.{name}" for name in columns)


def _extra_key(row: ExtraRow) -> str:
    """Hash what makes a row from elsewhere another one; of a computed row its place in the study."""
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


def _json(numbers: Mapping[str, float]) -> str:
    return json.dumps(dict(numbers), allow_nan=False)


def _outcome(row: Mapping[str, Any]) -> Outcome:
    """Make an outcome of a row, which lacks columns in a file of an earlier release."""
    return Outcome(
        key=row["key"],
        inputs=json.loads(row["inputs"]),
        responses=None if row["responses"] is None else json.loads(row["responses"]),
        reason=row["reason"],
        seconds=row["seconds"],
        lost=row["status"] == "lost",
        errors=json.loads(row.get("errors") or "{}"),
        unknowns=row.get("unknowns"),
        worker=row.get("worker") or "",
        attempts=row.get("attempts") or 1,
    )


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        # On a full disk SQLite has rolled back by itself.
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _cause(error: Exception) -> str:
    """Say what keeps a good store from being written; empty if the error is of another kind."""
    code = getattr(error, "sqlite_errorcode", None)
    return "" if code is None else CAUSES.get(code & 0xFF, "")


def _open(path: Path, readonly: bool) -> sqlite3.Connection:
    if readonly or (path.exists() and path.stat().st_size > 0):
        connection = sqlite3.connect(
            f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=PATIENCE
        )
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
        connection.execute(f"PRAGMA journal_mode={'DELETE' if _on_network(path) else 'WAL'}")
        with _transaction(connection):
            prepare(connection)
    except BaseException:
        connection.close()
        raise
    return connection


def _check_ours(connection: sqlite3.Connection, path: Path, readonly: bool) -> None:
    """Refuse a database of another program, or of a later release, before anything is written."""
    (mark,) = connection.execute("PRAGMA application_id").fetchone()
    (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    version = schema_version(connection)
    if mark == APPLICATION_ID and version <= SCHEMA_VERSION:
        return
    if not tables and not readonly:  # its maker died before it became a store
        return
    if mark == APPLICATION_ID:
        raise InputError(
            f"store: given {str(path)!r}, whose layout {version} is of a later release; allowed is "
            f"layout {SCHEMA_VERSION} or earlier, so "
            f"{'use that release' if readonly else 'give a new file name'}."
        )
    raise InputError(
        f"store: given {str(path)!r}, which is no result store but the file of another program; "
        f"{MADE_BY if readonly else 'give a new file name'}."
    )


def _check_place(path: Path, readonly: bool) -> None:
    """Refuse what is no file, or cannot become one."""
    if path.is_dir():
        raise InputError(
            f"store: given {str(path)!r}, which is a folder; allowed is a file, like "
            f"{path / 'runs.sqlite'}."
        )
    if readonly and not path.is_file():
        raise InputError(f"store: given {str(path)!r}; there is no such file.")
    if not path.absolute().parent.is_dir():
        raise InputError(f"store: given {str(path)!r}; there is no folder {path.parent}.")


def is_database(path: Path) -> bool:
    """Whether a file is an SQLite database, of whatever program."""
    with path.open("rb") as file:
        return file.read(16) == b"SQLite format 3\0"


def _on_network(path: Path) -> bool:
    """Whether a file lies on a folder of another machine."""
    folder = path.absolute().resolve().parent
    mounts = {place.mountpoint: place.fstype for place in psutil.disk_partitions(all=True)}
    for place in (folder, *folder.parents):
        if str(place) in mounts:
            return mounts[str(place)] in NETWORK_FOLDERS
    return False
