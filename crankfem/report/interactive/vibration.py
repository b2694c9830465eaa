"""An engine's vibration: mode shapes, Campbell diagrams, amplitudes over speed, the whole crankshaft."""

from pathlib import Path

from crankbase.drawing.diagram_style import make_folder
from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.vibration.assessment import Assessment
from crankfem.analyses.vibration.forced import ForcedVibration
from crankfem.analyses.vibration.plots.vibration_panels import free_end_title, stress_title
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.report.interactive.campbell import campbell
from crankfem.report.interactive.over_speed import Curve, amplitudes_over_speed
from crankfem.report.interactive.shaft import axial_split, shaft_modes
from crankfem.report.interactive.shapes import mode_shapes
from crankfem.report.interactive.style import Figure
from crankfem.report.interactive.writing import write_figure
from dynamics.critical import engine_orders


def interactive_vibration(folder: Path, run: EngineVibration) -> list[Path]:
    """Write the interactive diagrams of an engine's vibration into a folder, made if not there.

    Parameters
    ----------
    folder : Path
    run : EngineVibration

    Returns
    -------
    list of Path
        JSON files called like the pictures of `picture_vibration`.

    Raises
    ------
    InputError
        If the folder or a file cannot be written.
    """
    make_folder(folder)
    engine = run.engine_file.engine
    orders = engine_orders(engine.strokes, run.engine_file.vibration.highest_order)
    made = []
    for vibration, forced in ((run.axial, run.forced_axial), (run.torsional, run.forced_torsional)):
        kind = vibration.kind
        figures = {
            "modes": mode_shapes(vibration.chosen, f"{engine.name}, {kind} mode shapes"),
            "campbell": campbell(
                kind,
                vibration.chosen.elastic_frequencies,
                orders,
                (engine.lowest_speed, engine.highest_speed),
                () if forced is None else forced.resonances,
                f"{engine.name}, {kind}",
            ),
        }
        if forced is not None and run.assessment is not None:
            figures["amplitude"] = _free_end(forced, run.assessment, engine.name)
            if forced.stress is not None:
                figures["stress"] = _stress(forced, run.assessment, engine.name)
        made += [
            write_figure(folder / f"{kind}_{name}.json", *figure)
            for name, figure in figures.items()
        ]
    if run.whole is not None:
        radius = run.engine_file.throw.crank_radius
        modes = shaft_modes(
            run.whole.modes, radius, f"{engine.name}, modes of the whole crankshaft"
        )
        made.append(write_figure(folder / "shaft_modes.json", *modes))
    if run.comparison is not None and run.comparison.coupled is not None:
        split = axial_split(run.comparison.coupled, f"{engine.name}, whole crankshaft")
        made.append(write_figure(folder / "axial_split.json", *split))
    return made


def _free_end(forced: ForcedVibration, assessment: Assessment, engine: str) -> Figure:
    return amplitudes_over_speed(
        Curve(
            forced.free_end,
            0,
            MOTION[forced.kind].quantity,
            assessment.limits.get(f"{forced.kind}_amplitude"),
        ),
        assessment.verdict.ranges_to_bar,
        free_end_title(engine, forced.kind),
    )


def _stress(forced: ForcedVibration, assessment: Assessment, engine: str) -> Figure:
    """Show the crankshaft's element that is stressed most."""
    assert forced.stress is not None
    worst = forced.stress.largest_place
    return amplitudes_over_speed(
        Curve(forced.stress, worst, "stress", assessment.limits.get("crankshaft_stress")),
        assessment.verdict.ranges_to_bar,
        f"{stress_title(engine)}, {forced.stress.names[worst]}",
    )
