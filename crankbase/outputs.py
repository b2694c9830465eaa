"""Output files: each written in one step, without replacing files of others.

A hidden file in each folder lists the files written there, with kind and checksum; only files
that identify themselves, like models, need no list. A file is replaced by a new one of its kind if
it is unchanged since it was written, or empty; any other belongs to the user. An output gets its
name when it is complete, and is listed before that, so that an interrupt at any moment leaves a file that
the next run recognizes.
"""

import hashlib
import json
import os
import secrets
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from crankbase.errors import InputError

LISTED = ".crankfem-outputs.json"
FORMAT = "crankfem outputs"
DATABASE = b"SQLite format 3\0"
# A file that crankfem wrote, or the one before it: which one is there, an interrupt decides.
REMEMBERED = 2

Recognized = Callable[[Path], bool]
Kind = Literal[
    "picture", "plot", "table", "mesh", "solid", "deck", "model", "results", "report", "input file"
]


@dataclass(frozen=True)
class _Rules:
    """The rules for writing files at present."""

    force: bool = False
    run: bool = False
    # None outside of any context, where nobody could take them out again.
    inputs: list[Path] | None = None


_USUAL = _Rules()
# Private files that are being written: who ends the process without raising anything takes them away.
_UNFINISHED: set[Path] = set()
_RULES = ContextVar("_RULES", default=_USUAL)


@contextmanager
def replacing_files(force: bool = True) -> Iterator[None]:
    """Allow outputs inside this context to replace files that crankfem has not made.

    Input files and stores of studies are protected nevertheless.

    Parameters
    ----------
    force : bool
        Whether to allow it.

    Examples
    --------
    >>> with replacing_files():
    ...     pass
    """
    with _rules(replace(_RULES.get(), force=force)):
        yield


def protect(*inputs: Path) -> None:
    """Protect these files from outputs until the end of the context."""
    known = _RULES.get().inputs
    if known is not None:
        known.extend(inputs)


@contextmanager
def protected(*inputs: Path) -> Iterator[None]:
    """Protect these files from outputs inside this context."""
    with _rules(_RULES.get()):
        protect(*inputs)
        yield


@contextmanager
def recording_run_files() -> Iterator[None]:
    """Record outputs inside this context as a run's files, and let them replace only such."""
    with _rules(replace(_RULES.get(), run=True)):
        yield


@contextmanager
def _rules(rules: _Rules) -> Iterator[None]:
    token = _RULES.set(replace(rules, inputs=list(rules.inputs or ())))
    try:
        yield
    finally:
        _RULES.reset(token)


# ------------------------------------------------------------------------------------------- check


def check_output(
    path: Path, kind: Kind, *, recognized: Recognized | None = None, name: str = ""
) -> None:
    """Refuse to overwrite a file of the user, or an input file.

    Parameters
    ----------
    path : Path
        The file; a new one is always allowed.
    kind : str
        Kind of the output.
    recognized : callable, optional
        Recognizes from the content that crankfem wrote a file of this kind; with it only the files
        of runs are listed.
    name : str, optional
        Name of the file in the message; its path by default.

    Raises
    ------
    InputError
        Naming the file and the reason.
    """
    shown, rules = name or str(path), _RULES.get()
    if path.is_dir():
        raise InputError(f"{shown}: cannot be written, because it is a folder; name a file in it.")
    if not os.path.lexists(path):
        return
    if any(_same(path, other) for other in rules.inputs or ()):
        raise InputError(
            f"{shown}: cannot be written, because this command reads that file; name another."
        )
    if path.exists() and not os.access(path, os.W_OK):
        raise InputError(f"{shown}: cannot be written, because the file may not be changed.")
    if path.exists() and not path.is_file():  # a device or a pipe, which holds nothing
        return
    begin = b""
    with suppress(OSError), path.open("rb") as file:
        begin = file.read(len(DATABASE))
    if begin == DATABASE:
        raise InputError(
            f"{shown}: cannot be written, because it is a database, such as the store of a study; name "
            "another."
        )
    reason = None if rules.force else _replacement_refusal(path, kind, recognized, rules.run)
    if reason is not None:
        raise InputError(
            f"{shown}: is not replaced, because {reason}; name another {'folder' if rules.run else 'file'}, "
            "or allow it with --force (in Python: with crankfem.replacing_files())."
        )


def _replacement_refusal(
    path: Path, kind: Kind, recognized: Recognized | None, run: bool
) -> str | None:
    """State why a file may not be replaced by one of a kind; None if it may."""
    if path.is_symlink():
        return "it is a link that crankfem has not made"
    if path.stat().st_size == 0:
        return None
    if recognized is not None and not run:
        return None if recognized(path) else f"it is not an unchanged {kind} made by crankfem"
    entry = _read_list(path.parent).get(path.name)
    if entry is None or (run and not entry["run"]):
        return "no run of crankfem has made it" if run else "crankfem has not made it"
    if _checksum(path) not in entry["sha256"]:
        return "it was changed since crankfem wrote it"
    if entry["kind"] != kind:
        return f"it is a {entry['kind']} and no {kind}"
    return None


def _same(path: Path, other: Path) -> bool:
    try:
        return path.samefile(other)
    except OSError:
        return False


# ------------------------------------------------------------------------------------------- write


@contextmanager
def atomic_file(path: Path, kind: Kind, *, recognized: Recognized | None = None) -> Iterator[Path]:
    """Write a file atomically: yield a private file to write, which gets its final name when complete.

    It is in the same folder and has the same ending. If writing fails, the former file stays.

    Parameters
    ----------
    path, kind, recognized
        As for `check_output`.

    Yields
    ------
    Path
        An empty file; of a device or a pipe itself.

    Raises
    ------
    InputError
        As `check_output`.
    OSError
        If the file cannot be written; it names `path`.
    """
    check_output(path, kind, recognized=recognized)

    def enter(part: Path) -> None:
        check_output(path, kind, recognized=recognized)
        if recognized is None or _RULES.get().run:
            _list_file(path, kind, _checksum(part))

    with _atomic_replacement(path, enter) as part:
        yield part


@contextmanager
def _atomic_replacement(path: Path, enter: Callable[[Path], None]) -> Iterator[Path]:
    """Yield a private file that replaces `path` in the end, once `enter` permits it."""
    if path.exists() and not path.is_file():
        yield path
        return
    part = path.with_name(f".crankfem-{secrets.token_hex(8)}{path.suffix}")
    try:
        # It is made here and never followed, and its rights are those of any new file.
        _UNFINISHED.add(part)
        part.open("x").close()
        yield part
        with _folder_lock(path.parent):
            enter(part)
            os.replace(part, path)
    except BaseException as error:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.filename in (None, str(part), part):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise
    finally:
        _UNFINISHED.discard(part)


def remove_unfinished() -> None:
    """Remove the private files being written; for a process that ends at once."""
    for part in list(_UNFINISHED):
        with suppress(OSError):
            part.unlink(missing_ok=True)


def write_text(path: Path, text: str, kind: Kind, *, recognized: Recognized | None = None) -> Path:
    """Write a text in UTF-8 as `atomic_file` does, and return its path."""
    with atomic_file(path, kind, recognized=recognized) as part:
        part.write_text(text, encoding="utf-8")
    return path


def copy_picture(source: Path, path: Path) -> Path:
    """Copy a picture as `atomic_file` does, and return the path of the copy."""
    with atomic_file(path, "picture") as part:
        part.write_bytes(source.read_bytes())
    return path


@contextmanager
def write_errors(path: Path) -> Iterator[None]:
    """Turn the system's error on writing a file into an InputError that names `path`."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error}).") from None


def write_user_file(path: Path, content: bytes) -> None:
    """Write an input file of the user: it is not listed, and so never replaced again."""
    with _atomic_replacement(path, lambda _: check_output(path, "input file")) as part:
        part.write_bytes(content)


# -------------------------------------------------------------------------------------------- list


def is_listed(path: Path) -> bool:
    """Whether a file is listed as one that crankfem wrote, changed since then or not."""
    return path.name in _read_list(path.parent)


def files_listed(folder: Path) -> list[Path]:
    """Return the files of a run in a folder that are listed there and still what the run wrote."""
    return [
        folder / name
        for name, entry in _read_list(folder).items()
        if entry["run"]
        and is_regular_file(folder / name)
        and _checksum(folder / name) in entry["sha256"]
    ]


def is_regular_file(path: Path) -> bool:
    """Whether a path is that of a regular file, neither a link nor anything else."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _read_list(folder: Path) -> dict[str, dict[str, Any]]:
    """Read the list of a folder; an invalid list counts as empty."""
    path = folder / LISTED
    if not is_regular_file(path):
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] != FORMAT:
            return {}
        return {
            name: {
                "kind": str(entry["kind"]),
                "run": entry["run"] is True,
                "sha256": [str(digest) for digest in entry["sha256"]],
            }
            for name, entry in content["files"].items()
            # A name, and no way out of the folder.
            if name not in ("", ".", "..") and Path(name).name == name
        }
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return {}


def _list_file(path: Path, kind: Kind, checksum: str) -> None:
    """List a file before it gets its name; files that no longer exist are removed from the list."""
    listed = {
        name: entry
        for name, entry in _read_list(path.parent).items()
        if os.path.lexists(path.parent / name)
    }
    before = listed.get(path.name, {"sha256": []})["sha256"]
    entry = {
        "kind": kind,
        "run": _RULES.get().run,
        "sha256": list(dict.fromkeys([checksum, *before]))[:REMEMBERED],
    }
    content = {"format": FORMAT, "files": listed | {path.name: entry}}
    part = path.with_name(f".crankfem-{secrets.token_hex(8)}.json")
    try:
        with part.open("x", encoding="utf-8") as file:
            file.write(json.dumps(content, indent=1) + "\n")
        os.replace(part, path.parent / LISTED)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


@contextmanager
def _folder_lock(folder: Path) -> Iterator[None]:
    """Lock the list of a folder, so that no other process of crankfem changes it meanwhile."""
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):  # no such locks here
        yield
        return
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)
