"""The files of a run in its folder: all of them belong to one run, however the next one ends.

A run computes everything before it touches what the last one has left. Then it takes all of that away
but the store of the study, which it continues, and puts its own results there in one step; pictures
and report follow, and only what the new results name is ever shown.
"""

import json
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from crankbase.errors import InputError

RESULTS, REPORT, MODEL, STORE = "results.json", "report.html", "model.json", "study.sqlite"
MESH_FILE, PICTURES = "throw.vtu", "pictures"
# Kinds of pictures that results name, and nothing else is taken away from the folder of pictures.
KINDS = ("pictures", "interactive")


def make_folder(folder: Path) -> Path:
    """Make the folder of a run and that of its pictures, and see that files can be written there.

    Raises
    ------
    InputError
        If they cannot be made or written to.
    """
    try:
        (folder / PICTURES).mkdir(parents=True, exist_ok=True)
        # Rights alone do not tell what a file system takes.
        for place in (folder, folder / PICTURES):
            with tempfile.TemporaryFile(dir=place):
                pass
    except OSError as error:
        raise InputError(
            f"output: given {str(folder)!r}, which cannot be made or written to ({error.strerror}); "
            "allowed is a folder one may write to."
        ) from None
    return folder


def write_whole(path: Path, text: str) -> Path:
    """Write a text file in one step: there is the old one, or the new one, but never a part of it.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    OSError
        If it cannot be written; it names `path`.
    """
    part = _write_beside(path, text)
    try:
        part.replace(path)
    except OSError as error:
        _forget(part)
        raise _named(error, path) from error
    return path


def write_results(folder: Path, results: Mapping[str, Any]) -> Path:
    """Write results.json in one step; errors as of `write_whole`."""
    return write_whole(folder / RESULTS, results_text(results))


def replace_last_run(folder: Path, results: Mapping[str, Any]) -> None:
    """Take away what the last run has left in a folder, and put the results of a new one there.

    Where the results cannot be written, for want of space or rights, the last run stays as it is.

    Parameters
    ----------
    folder : Path
    results : mapping
        All numbers of the new run; its pictures are not named yet.

    Raises
    ------
    OSError
        If a file cannot be written or taken away.
    """
    part = _write_beside(folder / RESULTS, results_text(results))
    try:
        # The report first: without it, nobody takes what is left for a whole run.
        (folder / REPORT).unlink(missing_ok=True)
        for picture in _pictures_of(folder):
            picture.unlink(missing_ok=True)
        for name in (MODEL, MESH_FILE):
            (folder / name).unlink(missing_ok=True)
        part.replace(folder / RESULTS)
    except OSError:
        _forget(part)
        raise


def results_text(results: Mapping[str, Any]) -> str:
    """Return the text of results.json."""
    return json.dumps(results, indent=1, allow_nan=False) + "\n"


def _pictures_of(folder: Path) -> list[Path]:
    """The pictures and plots that the results in a folder name, if they are those of a run."""
    try:
        results = json.loads((folder / RESULTS).read_text(encoding="utf-8"))
        names = [name for kind in KINDS for name in results.get(kind, {}).values()]
        # A name, and no way out of the folder.
        return [folder / PICTURES / name for name in names if Path(name).name == name]
    except (OSError, ValueError, TypeError, AttributeError):
        return []


def _write_beside(path: Path, text: str) -> Path:
    """Write a text beside the file that it is to replace."""
    part = path.with_name(f"{path.name}.part")
    try:
        part.write_text(text, encoding="utf-8")
    except OSError as error:
        _forget(part)
        raise _named(error, path) from error
    return part


def _forget(part: Path) -> None:
    with suppress(OSError):
        part.unlink(missing_ok=True)


def _named(error: OSError, path: Path) -> OSError:
    """The same error, of the file that the user knows."""
    return OSError(error.errno, error.strerror, str(path))
