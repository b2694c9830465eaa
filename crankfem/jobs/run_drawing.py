"""What a run draws once all its numbers stand in its results, so that no picture may take them away."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from crankfem.analyses.mechanism.plots.mechanism_pictures import mechanism_pictures
from crankfem.analyses.mechanism.plots.plots import plot_torque
from crankfem.analyses.study.studies import StudyResult
from crankfem.analyses.throw.export import write_vtu
from crankfem.analyses.throw.pictures.drawing import write_drawing
from crankfem.analyses.to_draw import ToDraw
from crankfem.analyses.vibration.vibration_pictures import vibration_pictures
from crankfem.jobs.run_computation import RunComputation
from crankfem.jobs.run_files import MESH_FILE, PICTURES
from crankfem.jobs.run_pictures import Pictures, Renderings
from crankfem.report.interactive.angles import interactive_angles
from crankfem.report.interactive.mechanism import interactive_mechanism
from crankfem.report.interactive.study import interactive_study
from crankfem.report.interactive.throw_view import throw_view
from crankfem.report.interactive.torque import interactive_torque
from crankfem.report.interactive.vibration import interactive_vibration
from crankfem.report.run_pictures import angle_pictures, study_pictures
from dynamics.harmonics import Harmonics
from dynamics.torque_table import TorqueTable
from geometry.throw import CrankThrow

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
        Told of what cannot be drawn.

    Returns
    -------
    Pictures
        What is there.
    """
    place = folder / PICTURES
    pictures = Pictures(place, note)
    _draw_throw(pictures, computed)
    run = computed.mechanism
    if run is not None:
        pictures.draw("the mechanism", lambda: mechanism_pictures(place, run))
        pictures.plot("the mechanism", lambda: interactive_mechanism(place, run))
    if computed.study is not None:
        _draw_study(pictures, computed.study)
    if computed.torque is not None and computed.harmonics is not None:
        _draw_torque(pictures, computed.torque, computed.harmonics)
    pictures.draw("the vibration", lambda: vibration_pictures(place, computed.vibration))
    pictures.plot("the vibration", lambda: interactive_vibration(place, computed.vibration))
    pictures.draw("the formulas", lambda: angle_pictures(place, found))
    pictures.plot("the formulas", lambda: interactive_angles(place, found))
    renderings.collect(pictures)
    pictures.tried(MESH_FILE, lambda: write_vtu(computed.throw.analysis, folder / MESH_FILE))
    return pictures


def _draw_throw(pictures: Pictures, computed: RunComputation) -> None:
    engine_file, place = computed.engine_file, pictures.folder
    name, first = engine_file.engine.name, computed.throw

    def drawing(file: str, throw: CrankThrow, title: str) -> ToDraw:
        return ToDraw(place / file, lambda path: write_drawing(throw, path, title))

    drawings = [drawing("drawing.svg", engine_file.throw, name)]
    for own in list(computed.throws)[1:]:
        throw = engine_file.named_throws[own]
        drawings.append(drawing(f"drawing-{own}.svg", throw, f"{name}, throw {own}"))
    pictures.draw("the throw", lambda: drawings)
    pictures.plot("the throw", lambda: [throw_view(place, first.analysis, first.stresses)])


def _draw_study(pictures: Pictures, study: StudyResult) -> None:
    place, table = pictures.folder, study.table
    pictures.draw("the study", lambda: study_pictures(place, table, study.fits[PICTURED]))
    pictures.plot("the study", lambda: interactive_study(place, table, study.fits[PICTURED]))


def _draw_torque(pictures: Pictures, torque: TorqueTable, harmonics: Harmonics) -> None:
    place, samples = pictures.folder, torque.torque
    drawing = ToDraw(place / "torque.svg", lambda path: plot_torque(path, samples, harmonics))
    pictures.draw("the torque", lambda: [drawing])
    pictures.plot("the torque", lambda: interactive_torque(place, samples, harmonics))
