"""Pictures of a run, drawn after all numbers are in its results: a failed picture does not lose them."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from crankfem.analyses.throw.pictures.drawing import write_drawing
from crankfem.analyses.throw.pictures.surface import write_vtu
from crankfem.jobs.run_computation import RunComputation
from crankfem.jobs.run_files import MESH_FILE, PICTURES
from crankfem.jobs.run_pictures import Pictures, Renderings
from crankfem.report.figures import ANGLES, STUDY, TORQUE
from crankfem.report.interactive.mechanism import MECHANISM
from crankfem.report.interactive.throw_view import throw_view
from crankfem.report.interactive.vibration import VIBRATION

# Of the responses of a study, the one that is pictured.
PICTURED = "axial_compliance"


def draw_run(
    folder: Path,
    computed: RunComputation,
    found: Mapping[str, Any],
    renderings: Renderings,
    note: Callable[[str], None],
) -> Pictures:
    """Draw everything that a run shows, and write its mesh.

    Parameters
    ----------
    folder : Path
        Of the run.
    computed : RunComputation
    found : mapping
        All numbers of the run, as results.json holds them.
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
    _draw_throw(pictures, computed)
    if computed.mechanism is not None:
        pictures.draw(MECHANISM, computed.mechanism)
    if computed.study is not None:
        pictures.draw(STUDY, (computed.study.table, computed.study.fits[PICTURED]))
    if computed.torque is not None and computed.harmonics is not None:
        pictures.draw(TORQUE, (computed.torque.torque, computed.harmonics))
    pictures.draw(VIBRATION, computed.vibration)
    pictures.draw(ANGLES, found)
    renderings.collect(pictures)
    pictures.attempt(MESH_FILE, lambda: write_vtu(computed.throw.analysis, folder / MESH_FILE))
    return pictures


def _draw_throw(pictures: Pictures, computed: RunComputation) -> None:
    engine_file, first = computed.engine_file, computed.throw
    name = engine_file.engine.name
    pictures.draw_one("drawing", lambda path: write_drawing(engine_file.throw, path, name))
    for own in list(computed.throws)[1:]:
        throw, title = engine_file.named_throws[own], f"{name}, throw {own}"
        pictures.draw_one(f"drawing-{own}", partial(write_drawing, throw, title=title))
    pictures.plot_one(
        "throw_view", lambda folder: throw_view(folder, first.analysis, first.stresses)
    )
