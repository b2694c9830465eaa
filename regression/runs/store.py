"""The result store: one SQLite file, one row per finished design, safe against crashes.

Only the coordinator writes. A design's key is a hash of everything its result depends on, so a
design that is finished is never computed again, in this study or another.
"""

import contextlib
import errno
import hashlib
import json
import os
import sqlite3
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from crankbase.errors import InputError
from regression.records import MEASURED, ExtraRow, Outcome, StudyStoppedError, content_key
from regression.runs.store_file import (
    CHECKSUM,
    DAMAGED,
    EXTRA,
    MADE_BY,
    RECORDED,
    DamagedRowError,
    check_place,
    damaged_store,
    design_values,
    error_cause,
    extra_values,
    is_ours,
    open_store,
    read_design,
    read_extra,
    transaction,
)

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
        columns = (*RECORDED, CHECKSUM)
        with self._writing() as connection:
            if self._read(outcome.key) is None:  # a damaged row says nothing worth keeping
                connection.execute("DELETE FROM designs WHERE key = ?", (outcome.key,))
            connection.execute(
                f"INSERT INTO designs ({', '.join(columns)}) "
                f"VALUES ({', '.join('?' * len(columns))}) "
                f"ON CONFLICT (key) DO UPDATE SET {_overwritten(columns)}, "
                "finished_at = CURRENT_TIMESTAMP "
                "WHERE designs.status <> 'done' OR excluded.status = 'done'",
                row,
            )
            self.damaged.pop(outcome.key, None)

    def outcomes(self, keys: Iterable[str]) -> dict[str, Outcome]:
        """Return the available outcomes of designs, by key."""
        with self._reading():
            outcomes = {key: self._read(key) for key in keys}
        return {key: outcome for key, outcome in outcomes.items() if outcome is not None}

    def _read(self, key: str) -> Outcome | None:
        """Read a design's row; None if there is none, or a damaged one."""
        query = "SELECT * FROM designs WHERE key = ?"
        row = self._connection.execute(query, (key,)).fetchone()
        return None if row is None else self._read_or_skip(key, read_design, dict(row))

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
                outcome = self._read_or_skip(row["key"], read_design, row)
                if outcome is not None and outcome.responses is not None:
                    yield row["role"], outcome, row["model_version"]

    def every_outcome(self) -> Iterator[Outcome]:
        """List the sound rows of all designs, whether a study has them or not."""
        with self._reading():
            for row in map(dict, self._connection.execute("SELECT * FROM designs")):
                outcome = self._read_or_skip(str(row["key"]), read_design, row)
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
        listed = [(_extra_key(row), row) for row in rows]
        columns = (*EXTRA, CHECKSUM)
        with self._writing() as connection:
            (before,) = connection.execute("SELECT count(*) FROM extra_rows").fetchone()
            connection.executemany(
                f"INSERT INTO extra_rows ({', '.join(columns)}) "
                f"VALUES ({', '.join('?' * len(columns))}) "
                f"ON CONFLICT (study, key) DO UPDATE SET {_overwritten(columns)}",
                [extra_values(study, key, row) for key, row in listed],
            )
            (after,) = connection.execute("SELECT count(*) FROM extra_rows").fetchone()
        return int(after - before)

    def extra_rows(self, study: str | None = None) -> tuple[ExtraRow, ...]:
        """Return the rows from elsewhere of a study, or of all, in the order of import."""
        with self._reading():
            rows = self._connection.execute(
                "SELECT * FROM extra_rows WHERE ?1 IS NULL OR study = ?1 ORDER BY rowid", (study,)
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


def _overwritten(columns: Iterable[str]) -> str:
    return ", ".join(f"{name} = excluded.{name}" for name in columns)


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
