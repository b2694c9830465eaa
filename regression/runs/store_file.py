"""The file of a result store: opened if it is one, created if possible, refused otherwise."""

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from crankbase.errors import InputError
from crankbase.wrong_files import not_a_file
from regression.runs.store_schema import (
    APPLICATION_ID,
    SCHEMA_VERSION,
    missing_parts,
    prepare,
    schema_version,
)

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
        f"so run crankfem doe --repair {path}, use a copy of it, or give a new file name."
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
        If the file is that of another program, of a later release, or lacks a part.
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
    """Refuse a database of another program, or of a later release, before anything is written."""
    (mark,) = connection.execute("PRAGMA application_id").fetchone()
    (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    version = schema_version(connection)
    if mark == APPLICATION_ID and version <= SCHEMA_VERSION:
        missing = missing_parts(connection)
        if missing:
            raise damaged_store(path, f"it has no {missing[0]}")
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
    """Whether a file's header is that of a store of this release, even if the rest is damaged."""
    with path.open("rb") as file:
        header = file.read(100)
    version, mark = int.from_bytes(header[60:64]), int.from_bytes(header[68:72])
    return is_database(path) and mark == APPLICATION_ID and version <= SCHEMA_VERSION


def _on_network(path: Path) -> bool:
    """Whether a file is in a network folder."""
    folder = path.absolute().resolve().parent
    mounts = {place.mountpoint: place.fstype for place in psutil.disk_partitions(all=True)}
    for place in (folder, *folder.parents):
        if str(place) in mounts:
            return mounts[str(place)] in NETWORK_FOLDERS
    return False
