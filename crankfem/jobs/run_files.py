"""The files of a run in its folder: all of them belong to one run, however the next one ends.

A run computes everything before it touches what the last one has left. Then it removes all of that
but the store of the study, which it continues, and writes its own results in one step; pictures
and report follow, and only what the new results name is ever shown. What runs have written is listed in
the folder, see `crankbase.outputs`; nothing else is replaced or removed.
"""

import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from crankbase.errors import InputError
from crankbase.outputs import (
    Kind,
    atomic_file,
    check_output,
    files_listed,
    protected,
    recording_run_files,
    write_text,
)
from crankbase.results import json_text
from crankfem.analyses.record import Record, with_units
from crankfem.analyses.run_results import RunResults
from crankfem.report.figures import PLOTS
from regression.records import Outcome
from regression.runs.store import Claims

RESULTS, REPORT, MODEL, STORE = "results.json", "report.html", "model.json", "study.sqlite"
MESH_FILE, PICTURES = "throw.vtu", "pictures"
RUNNING = ".crankfem-run"
# Kinds of pictures that results name, and how their files end.
ENDINGS: dict[str, tuple[Kind, tuple[str, ...]]] = {
    "pictures": ("picture", (".svg", ".png")),
    "interactive": ("plot", (".json",)),
}
# What files of pictures are called, but for their endings; a file so called stands in a run's way.
PICTURED = frozenset({*PLOTS, "throw_mesh", "throw_deformed", "stress-radial", "stress-torsion"})


def check_folder(folder: Path, *, study: bool, inputs: tuple[Path, ...] = ()) -> None:
    """Refuse a folder with files in the way that crankfem did not write.

    Parameters
    ----------
    folder : Path
        There or not.
    study : bool
        Whether the run has a study, and so writes a model.
    inputs : tuple of Path
        What the run reads.
    """
    if not folder.is_dir():
        return
    pictures = folder / PICTURES
    if pictures.is_symlink():
        raise InputError(
            f"{pictures}: is a link; allowed is a folder of the run's own, because files written there would "
            "go elsewhere."
        )
    files: list[tuple[Path, Kind]] = [
        (folder / RESULTS, "results"),
        (folder / REPORT, "report"),
        (folder / MESH_FILE, "mesh"),
    ]
    if study:
        files.append((folder / MODEL, "model"))
    for kind, endings in ENDINGS.values():
        for path in sorted(pictures.glob("*")):
            if path.stem in PICTURED and path.suffix in endings:
                files.append((path, kind))
    with recording_run_files(), protected(*inputs):
        for path, kind in files:
            check_output(path, kind)


def make_folders(folder: Path, *inside: str) -> Path:
    """Make the folder of a run and those inside it, and check that files can be written there."""
    try:
        for place in (folder, *(folder / name for name in inside)):
            place.mkdir(parents=True, exist_ok=True)
            # Rights alone do not tell what a file system takes.
            with tempfile.TemporaryFile(dir=place):
                pass
    except OSError as error:
        raise InputError(
            f"output: given {str(folder)!r}, which cannot be made or written to ({error.strerror}); "
            "allowed is a writable folder."
        ) from None
    return folder


@contextmanager
def the_only_run(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder until this one has ended: its files must be those of one run."""
    with Claims(folder / RUNNING) as claims:
        if not claims.take(RUNNING):
            raise InputError(
                f"output: given {str(folder)!r}, where another run is at work; give another folder, or wait "
                "until that run has ended."
            )
        yield


def write_results(folder: Path, results: RunResults | Record) -> Path:
    """Write results.json in one step; errors as of `crankbase.outputs.write_text`."""
    with recording_run_files():
        return write_text(folder / RESULTS, results_text(results), "results")


def replace_last_run(folder: Path, results: RunResults | Record) -> None:
    """Remove the files of the last run from a folder, and write the results of a new one.

    Where the results cannot be written, for want of space or rights, the last run stays as it is.

    Parameters
    ----------
    results : RunResults
        Its pictures are not named yet.

    Raises
    ------
    OSError
        If a file cannot be written or removed.
    """
    text = results_text(results)
    with recording_run_files(), atomic_file(folder / RESULTS, "results") as part:
        part.write_text(text, encoding="utf-8")
        # The report first: without it, nobody takes what is left for a whole run.
        left = sorted(files_listed(folder), key=lambda path: path.name != REPORT)
        for path in (*left, *files_listed(folder / PICTURES)):
            if path.name != RESULTS:
                path.unlink(missing_ok=True)


def results_text(results: RunResults | Record) -> str:
    """Return the text of results.json; a record is JSON content already."""
    return json_text(with_units(results) if isinstance(results, RunResults) else results, indent=1)


class Progress(Protocol):
    """Progress messages of a run."""

    def step(self, text: str) -> None:
        """A new step begins."""

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """A design of the study is finished."""

    def note(self, text: str) -> None:
        """A note for the user."""

    def warn(self, text: str) -> None:
        """Data are lost or damaged, or the input looks wrong, which nobody should miss."""


class SilentProgress:
    """Silent progress: nothing is reported."""

    def step(self, text: str) -> None:
        """Ignore a step."""

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """Ignore a design."""

    def note(self, text: str) -> None:
        """Ignore a note."""

    def warn(self, text: str) -> None:
        """Ignore a warning."""


class TimedProgress:
    """Timed progress: passes everything on and takes the time of the steps.

    Attributes
    ----------
    seconds : dict
        Step to the time it took [s].
    """

    def __init__(self, reporter: Progress) -> None:
        self._told = reporter
        self._began: tuple[str, float] | None = None
        self.seconds: dict[str, float] = {}

    def step(self, text: str) -> None:
        """End one step and begin the next."""
        self.stop()
        self._began = (text, time.perf_counter())
        self._told.step(text)

    def stop(self) -> None:
        """Take the time of the step that has ended."""
        if self._began is not None:
            text, began = self._began
            self.seconds[text] = self.seconds.get(text, 0.0) + time.perf_counter() - began
            self._began = None

    def design(self, finished: int, total: int, newest: Outcome | None) -> None:
        """Pass on that a design is finished."""
        self._told.design(finished, total, newest)

    def note(self, text: str) -> None:
        """Pass a note on."""
        self._told.note(text)

    def warn(self, text: str) -> None:
        """Pass a warning on."""
        self._told.warn(text)
