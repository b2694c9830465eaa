"""Jobs in an SQLite file, found again after a restart; those who follow them."""

import asyncio
import contextlib
import errno
import json
import os
import secrets
import shutil
import sqlite3
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic_core import to_json

from crankbase.errors import InputError
from crankfem.satellites.service.answers import ENDED, Job, State
from crankfem.satellites.service.asking import ProblemError

_COLUMNS = {
    "id": "TEXT PRIMARY KEY",
    "kind": "TEXT NOT NULL",
    "title": "TEXT NOT NULL",
    "question": "TEXT NOT NULL",
    "state": "TEXT NOT NULL",
    "step": "TEXT NOT NULL DEFAULT ''",
    "finished": "INTEGER NOT NULL DEFAULT 0",
    "total": "INTEGER NOT NULL DEFAULT 0",
    "notes": "TEXT NOT NULL DEFAULT '[]'",
    "problem": "TEXT",
    "created": "REAL NOT NULL",
    "started": "REAL",
    "ended": "REAL",
    "attempts": "INTEGER NOT NULL DEFAULT 0",
}
VERSION = 1
FILE, FOLDERS = "jobs.sqlite", "jobs"
OWNER = 0o700  # of what users send and jobs write nobody else reads anything
# What a job keeps for itself: its store and the lists of its files.
OWN_ENDINGS = (".sqlite", ".sqlite-wal", ".sqlite-shm", ".sqlite-claims")
NO_SPACE = (errno.ENOSPC, errno.EDQUOT)
LITTLE = 65536  # bytes: SQLite names another reason where so little is left
FULL = "The disk of the service is full."
GONE = "The folder of the jobs is gone, or another one is in its place; start the service again."


class StoreError(ProblemError):
    """The store cannot be used now; the text says why."""


class JobStore:
    """Jobs and their folders.

    Parameters
    ----------
    folder : Path
        Made if it is not there.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        # Why the last change could not be recorded.
        self.trouble: str | None = None
        self._lock = threading.RLock()
        try:
            self.folder = folder = folder.absolute()
            if not folder.is_dir():
                folder.mkdir(OWNER, parents=True)
            (folder / FOLDERS).mkdir(OWNER, exist_ok=True)
            (folder / FOLDERS).chmod(OWNER)  # made by an earlier release, perhaps
            self._base = sqlite3.connect(
                folder / FILE, check_same_thread=False, isolation_level=None
            )
            self._base.row_factory = sqlite3.Row
            self._base.execute("PRAGMA journal_mode = WAL")
            # Other services are kept out as long as this one lives.
            self._held = sqlite3.connect(
                folder / "service.sqlite", timeout=0.5, check_same_thread=False
            )
            self._held.execute("PRAGMA locking_mode = EXCLUSIVE")
            self._held.execute("BEGIN EXCLUSIVE")
            (folder / FILE).chmod(0o600)
            (version,) = self._base.execute("PRAGMA user_version").fetchone()
            if version > VERSION:
                raise InputError(
                    f"{folder / FILE}: was written by a newer release; allowed is version {VERSION}."
                )
            spelled = ", ".join(f"{name} {kind}" for name, kind in _COLUMNS.items())
            self._base.execute(f"CREATE TABLE IF NOT EXISTS jobs ({spelled})")
            if version < VERSION:
                self._base.execute(f"PRAGMA user_version = {VERSION}")
            self._file = self._identity()
        except (OSError, sqlite3.Error) as error:
            raise InputError(
                f"--folder: given {folder}, which cannot be used ({getattr(error, 'strerror', error)}); "
                "allowed is a folder to write to, which no other service uses."
            ) from None

    def close(self) -> None:
        """Let the files go."""
        self._base.close()
        self._held.close()

    def add(self, kind: str, title: str, question: Mapping[str, Any], waiting: int) -> str | None:
        """Add a job and return its name; None if so many wait already."""
        name = secrets.token_hex(8)
        place = self.place(name)
        with self._changing():
            if self.count("queued") >= waiting:
                return None
            place.mkdir(OWNER)
            try:
                self._base.execute(
                    "INSERT INTO jobs (id, kind, title, question, state, created) "
                    "VALUES (?, ?, ?, ?, 'queued', ?)",
                    (name, kind, title, json.dumps(question), time.time()),
                )
            except sqlite3.Error:
                place.rmdir()
                raise
        return name

    def count(self, state: State) -> int:
        """Count the jobs in a state."""
        return int(self._rows("SELECT COUNT(*) FROM jobs WHERE state = ?", state)[0][0])

    def start_next(self) -> tuple[str, str, dict[str, Any], int] | None:
        """Take the job that waits longest: return its name, kind, request and how often it was taken."""
        with self._lock:
            rows = self._rows("SELECT * FROM jobs WHERE state = 'queued' ORDER BY created LIMIT 1")
            if not rows:
                return None
            job, attempts = rows[0], rows[0]["attempts"] + 1
            taken = job["id"], job["kind"], json.loads(job["question"]), attempts
            self.change(job["id"], state="running", started=time.time(), attempts=attempts, step="")
            return taken

    def change(self, name: str, **values: Any) -> None:
        """Change the record of a job."""
        spelled = ", ".join(f"{column} = ?" for column in values)
        with self._changing():
            self._base.execute(f"UPDATE jobs SET {spelled} WHERE id = ?", (*values.values(), name))

    def settle(
        self,
        name: str,
        state: State,
        problem: Mapping[str, Any] | None = None,
        notes: Sequence[str] = (),
        **values: Any,
    ) -> None:
        """End a job, or let it wait again, with more notes."""
        values |= {"state": state, "step": "", "ended": time.time() if state in ENDED else None}
        values["problem"] = None if problem is None else json.dumps(problem)
        with self._lock:
            (row,) = self._rows("SELECT notes FROM jobs WHERE id = ?", name)
            self.change(name, **values, notes=json.dumps([*json.loads(row["notes"]), *notes]))

    def note(self, name: str, text: str) -> None:
        """Add a note to a job."""
        with self._lock:
            (row,) = self._rows("SELECT notes FROM jobs WHERE id = ?", name)
            self.change(name, notes=json.dumps([*json.loads(row["notes"]), text]))

    def queue_again(self, most: int, problem: Mapping[str, Any]) -> None:
        """Let jobs wait again that ran when the service ended; those that were tried so often have failed."""
        for row in self._rows("SELECT id, attempts FROM jobs WHERE state = 'running'"):
            if row["attempts"] < most:
                self.settle(row["id"], "queued")
            else:
                self.settle(row["id"], "failed", problem)

    def remove(self, name: str) -> None:
        """Forget a job and its files; those first, which makes room for the record of it."""
        shutil.rmtree(self.place(name), ignore_errors=True)
        with self._changing():
            self._base.execute("DELETE FROM jobs WHERE id = ?", (name,))

    def check(self) -> None:
        """Find out whether changes can be recorded.

        Raises
        ------
        StoreError
            If the folder is gone, or the last change could not be recorded and the next one neither.
        """
        with self._changing():
            if self.trouble is not None:
                self._base.execute(f"PRAGMA user_version = {VERSION}")

    def job(self, name: str) -> Job | None:
        """Return a job, None if there is none of that name."""
        rows = self._rows("SELECT * FROM jobs WHERE id = ?", name)
        return self._job(rows[0]) if rows else None

    def jobs(self, most: int) -> list[Job]:
        """Return the newest jobs."""
        rows = self._rows("SELECT * FROM jobs ORDER BY created DESC LIMIT ?", most)
        return [self._job(row) for row in rows]

    def place(self, name: str) -> Path:
        """Return the folder of a job's files."""
        return self.folder / FOLDERS / name

    def file(self, name: str, path: str) -> Path | None:
        """Return a file of a job by the name that the job lists; None if there is none."""
        return self.place(name) / path if path in self.files(name) else None

    def files(self, name: str) -> list[str]:
        """Return the names of a job's files."""
        place = self.place(name)
        # Of a folder that goes meanwhile, `os.walk` has no files; `rglob` fails.
        paths = (Path(folder, file) for folder, _, files in os.walk(place) for file in files)
        return sorted(
            path.relative_to(place).as_posix()
            for path in paths
            if path.is_file()
            and not path.is_symlink()
            and not any(part.startswith(".") for part in path.relative_to(place).parts)
            and path.suffix not in OWN_ENDINGS
        )

    def _job(self, row: sqlite3.Row) -> Job:
        values = dict(row)
        problem = values.pop("problem")
        return Job(
            **{name: value for name, value in values.items() if name not in ("question", "notes")},
            notes=json.loads(values["notes"]),
            problem=None if problem is None else json.loads(problem),
            files=self.files(values["id"]),
        )

    def _rows(self, text: str, *values: object) -> list[sqlite3.Row]:
        with self._lock:
            try:
                return self._base.execute(text, values).fetchall()
            except sqlite3.Error as error:
                raise self._refusal(error) from None

    @contextlib.contextmanager
    def _changing(self) -> Iterator[None]:
        """Hold the store for a change, and keep why it fails."""
        with self._lock:
            try:
                if self._identity() != self._file:
                    raise FileNotFoundError
                yield
            except (OSError, sqlite3.Error) as error:
                refusal = self._refusal(error)
                self.trouble = refusal.detail
                raise refusal from None
            self.trouble = None

    def _identity(self) -> tuple[int, int] | None:
        """Tell the file of the jobs from any other in its place; None without one."""
        try:
            entry = (self.folder / FILE).stat()
        except OSError:
            return None
        return entry.st_dev, entry.st_ino

    def _refusal(self, error: OSError | sqlite3.Error) -> StoreError:
        if self._identity() != self._file:
            return StoreError(503, GONE)
        if (
            getattr(error, "errno", None) in NO_SPACE
            or getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_FULL
            or shutil.disk_usage(self.folder).free < LITTLE
        ):
            return StoreError(507, FULL)
        return StoreError(
            503, f"The jobs cannot be recorded ({getattr(error, 'strerror', error)})."
        )


LOOK, PING = 0.1, 15.0  # seconds between two looks at the jobs, between two signs of life


class _Followed:
    """A job that is followed: its record as JSON, and whom to wake at its next change."""

    def __init__(self) -> None:
        self.followers = 0
        self.text, self.over = b"", False
        self.changed = asyncio.Event()

    def change(self, text: bytes, over: bool) -> None:
        if (text, over) != (self.text, self.over):
            self.text, self.over = text, over
            self.wake()

    def wake(self) -> None:
        self.changed.set()
        self.changed = asyncio.Event()


class Followers:
    """All streams of progress.

    Parameters
    ----------
    stopping : callable
        Whether the service ends, and all streams with it.
    """

    def __init__(self, store: JobStore, stopping: Callable[[], bool]) -> None:
        self._store, self._stopping = store, stopping
        self._jobs: dict[str, _Followed] = {}
        self._watch: asyncio.Task[None] | None = None

    async def follow(self, name: str) -> AsyncIterator[bytes]:
        """Yield the record of a job at each change and from time to time, until it has ended."""
        job = self._jobs.setdefault(name, _Followed())
        job.followers += 1
        if self._watch is None or self._watch.done():
            self._watch = asyncio.create_task(self._watching())
        last, when = b"", time.monotonic()
        try:
            while True:
                changed = job.changed
                if job.text and (job.text != last or time.monotonic() - when > PING / 2):
                    last, when = job.text, time.monotonic()
                    yield last
                elif job.over:
                    return
                else:
                    await changed.wait()
        finally:
            job.followers -= 1
            if not job.followers:
                del self._jobs[name]

    async def _watching(self) -> None:
        """Look at all jobs that are followed, beside the other requests, as long as there are some."""
        pinged = time.monotonic()
        while self._jobs:
            over = self._stopping()
            looks = await asyncio.to_thread(self._look, list(self._jobs))
            ping = time.monotonic() - pinged >= PING
            for name, job in self._jobs.items():
                text, ended = looks.get(name, (job.text, False))
                job.change(text, ended or over)
                if ping:
                    job.wake()
            pinged = time.monotonic() if ping else pinged
            await asyncio.sleep(LOOK)

    def _look(self, names: list[str]) -> dict[str, tuple[bytes, bool]]:
        """Return the records of jobs, and which of them have ended or are gone."""
        looks = {}
        for name in names:
            try:
                job = self._store.job(name)
            except (OSError, ProblemError):
                continue  # the next look may find it
            looks[name] = (b"", True) if job is None else (to_json(job), job.state in ENDED)
        return looks
