"""Pictures of a run, drawn after all numbers are in its results: a failed picture does not lose them."""

import os
import traceback
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from crankbase.errors import MissingLibraryError, RenderError
from crankbase.outputs import copy_picture
from crankbase.processes import scratch_folder
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.throw.pictures.drawing import write_drawing
from crankfem.analyses.throw.pictures.stress_picture import write_vtu
from crankfem.jobs.exit_codes import TRACEBACK, describe_error
from crankfem.jobs.run_computation import RunComputation
from crankfem.jobs.run_files import MESH_FILE, PICTURES
from crankfem.report.figures import ANGLES, STUDY, TORQUE
from crankfem.report.interactive.mechanism import MECHANISM
from crankfem.report.interactive.plot import Plots, Run
from crankfem.report.interactive.throw_view import shaft_view, throw_view
from crankfem.report.interactive.vibration import VIBRATION
from geometry.any_throw import dimensioned


class Pictures:
    """The pictures of a run, drawn one by one.

    Parameters
    ----------
    folder : Path
        Where they go.
    note : callable
        Receives messages about pictures that cannot be drawn.

    Attributes
    ----------
    static, interactive : dict
        Name of each picture or plot that is there to its file name.
    notes : list of str
        Messages, each sentence once.
    """

    def __init__(self, folder: Path, note: Callable[[str], None]) -> None:
        self.folder = folder
        self._note = note
        self.static: dict[str, str] = {}
        self.interactive: dict[str, str] = {}
        self.notes: list[str] = []

    def attempt(self, what: str, make: Callable[[], object]) -> bool:
        """Attempt something and return whether it succeeded; if not, report the reason."""
        try:
            make()
        except Exception as error:
            if os.environ.get(TRACEBACK):
                traceback.print_exc()
            sentence = f"There is no {what}: {describe_error(error)[0]}"
            if isinstance(error, (MissingLibraryError, RenderError)):
                sentence = str(error)
            if sentence not in self.notes:
                self.notes.append(sentence)
                self._note(sentence)
            return False
        return True

    def draw(self, plots: Plots[Run], run: Run) -> None:
        """Draw the plots of one thing, each once: for a screen, else on paper.

        A page makes what is printed of an interactive plot from the same data.
        """
        for plot in plots.of(run):
            if plot.interactive is not None and self.plot_one(
                plot.name, partial(plot.write, run=run)
            ):
                continue
            if plot.static is not None and self.attempt(
                f"picture {plot.name}", partial(plot.draw, self.folder, run)
            ):
                self.static[plot.name] = f"{plot.name}.svg"

    def draw_one(self, name: str, draw: Callable[[Path], object]) -> None:
        """Draw one static picture."""
        path = self.folder / f"{name}.svg"
        if self.attempt(f"picture {name}", partial(draw, path)):
            self.static[name] = path.name

    def plot_one(self, name: str, write: Callable[[Path], object]) -> bool:
        """Make one interactive plot, written into the folder it is given; return whether it is there."""
        drawn = self.attempt(f"interactive plot {name}", partial(write, self.folder))
        if drawn:
            self.interactive[name] = f"{name}.json"
        return drawn


class Renderer(Protocol):
    """A process that renders pictures in the background."""

    def wait(self) -> None:
        """Wait for the pictures."""

    def stop(self) -> None:
        """End it."""


@dataclass(frozen=True)
class _Job:
    what: str
    folder: Path
    renderer: Renderer
    files: Mapping[str, str]


class Renderings:
    """Pictures rendered in the background while a run computes.

    They are made in folders of their own, for until a run has all its numbers, the folder of its
    pictures holds those of the last one.
    """

    def __init__(self) -> None:
        self._open = ExitStack()
        self._jobs: list[_Job] = []
        self._failed: list[tuple[str, Exception]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.close()

    def start(
        self, what: str, files: Mapping[str, str], render: Callable[[Path], Renderer]
    ) -> None:
        """Begin to render.

        Parameters
        ----------
        what : str
            For messages.
        files : mapping
            Picture name to file name, of what will be there.
        render : callable
            Starts a process that renders into a folder.
        """
        try:
            folder = self._open.enter_context(scratch_folder())
            renderer = render(folder)
        except Exception as error:
            self._failed.append((what, error))
            return
        self._open.callback(renderer.stop)
        self._jobs.append(_Job(what, folder, renderer, files))

    def collect(self, pictures: Pictures) -> None:
        """Wait for what is rendered and move it to the other pictures."""
        for what, error in self._failed:
            pictures.attempt(what, partial(_throw, error))
        for job in self._jobs:
            if pictures.attempt(job.what, partial(_move, job, pictures.folder)):
                pictures.static |= job.files


def _move(job: _Job, folder: Path) -> None:
    job.renderer.wait()
    for name in job.files.values():
        copy_picture(job.folder / name, folder / name)


def _throw(error: Exception) -> None:
    raise error


# Of the responses of a study, the one that is pictured.
PICTURED = "axial_compliance"


def draw_run(
    folder: Path,
    computed: RunComputation,
    results: RunResults,
    renderings: Renderings,
    note: Callable[[str], None],
) -> Pictures:
    """Draw everything that a run shows, and write its mesh.

    Parameters
    ----------
    folder : Path
        Of the run.
    renderings : Renderings
        What is rendered in the background.
    note : callable
        Receives messages about pictures that cannot be drawn.

    Returns
    -------
    Pictures
        What is there.
    """
    pictures = Pictures(folder / PICTURES, note)
    engine_file, first = computed.engine_file, computed.throw
    name = engine_file.engine.name
    known = dimensioned(engine_file.named_throws)
    for place, throw_name in enumerate(computed.throws):
        if throw_name in known:
            ending, of_throw = (f"-{throw_name}", f", throw {throw_name}") if place else ("", "")
            draw = partial(write_drawing, known[throw_name], title=name + of_throw)
            pictures.draw_one(f"drawing{ending}", draw)
    pictures.plot_one("throw_view", lambda place: throw_view(place, first.analysis, first.stresses))
    if len(known) < len(engine_file.named_throws):
        shaft = engine_file.crankshaft
        pictures.plot_one(
            "shaft_view", lambda place: shaft_view(place, shaft, computed.crank_analyses)
        )
    if computed.mechanism is not None:
        pictures.draw(MECHANISM, computed.mechanism)
    if computed.study is not None:
        pictures.draw(STUDY, (computed.study.table, computed.study.fits[PICTURED]))
    if computed.torque is not None and computed.harmonics is not None:
        pictures.draw(TORQUE, (computed.torque.torque, computed.harmonics))
    pictures.draw(VIBRATION, computed.vibration)
    pictures.draw(ANGLES, results)
    renderings.collect(pictures)
    pictures.attempt(MESH_FILE, lambda: write_vtu(computed.throw.analysis, folder / MESH_FILE))
    return pictures
