"""The diagrams of an engine's vibration: mode shapes, Campbell diagrams, amplitudes over speed."""

from pathlib import Path

from crankfem.pictures.response_plots import plot_over_speed, plot_response_campbell
from crankfem.pictures.shaft_mode_plots import plot_axial_split, plot_mode_shares, plot_shaft_modes
from crankfem.pictures.transient_plots import plot_transient
from crankfem.pictures.vibration_panels import (
    barred_ranges,
    draw_modes,
    limit_curve,
    most_stressed,
)
from crankfem.vibration.assessment import Assessment
from crankfem.vibration.forced import ForcedVibration
from crankfem.vibration.modes import SourceResult
from crankfem.vibration.run import EngineVibration
from crankfem.vibration.run_up import RunUp
from dynamics.critical import engine_orders
from geometry.diagram_style import figure, make_folder


def picture_vibration(folder: Path, run: EngineVibration) -> list[Path]:
    """Write the diagrams of an engine's vibration into a folder, which is made if it is not there.

    Returns
    -------
    list of Path
        The SVG files.

    Raises
    ------
    InputError
        If the folder cannot be made.
    """
    make_folder(folder)
    engine = run.engine_file.engine
    orders = engine_orders(engine.strokes, run.engine_file.vibration.highest_order)
    made = []
    for vibration, forced in ((run.axial, run.forced_axial), (run.torsional, run.forced_torsional)):
        kind = vibration.kind
        made += [folder / f"{kind}_modes.svg", folder / f"{kind}_campbell.svg"]
        plot_mode_shapes(made[-2], vibration.chosen)
        plot_response_campbell(
            made[-1],
            vibration.chosen.elastic_frequencies,
            orders,
            (engine.lowest_speed, engine.highest_speed),
            () if forced is None else forced.resonances,
            title=f"{engine.name}, {kind}",
        )
        if forced is not None and run.assessment is not None:
            made.append(folder / f"{kind}_amplitude.svg")
            _plot_free_end(made[-1], forced, run.assessment, engine.name)
    if run.forced_torsional is not None and run.assessment is not None:
        made.append(folder / "torsional_stress.svg")
        _plot_stress(made[-1], run.forced_torsional, run.assessment, engine.name)
    if run.whole is not None:
        made += [folder / "shaft_modes.svg", folder / "shaft_shares.svg"]
        plot_shaft_modes(made[-2], run.whole.modes, run.engine_file.throw.crank_radius)
        plot_mode_shares(made[-1], run.whole.modes)
    if run.comparison is not None and run.comparison.coupled is not None:
        made.append(folder / "axial_split.svg")
        plot_axial_split(made[-1], run.comparison.coupled)
    return made


def picture_run_up(path: Path, run: EngineVibration, found: RunUp) -> None:
    """Plot the torque of a run-up in the spring where it is largest, as SVG."""
    forced = run.forced_torsional
    assert forced is not None
    worst = found.worst
    elastic = forced.loads.elastic
    plot_transient(
        path,
        found.motion,
        worst,
        steady=(elastic.speeds, elastic.synthesis.amplitude[:, worst]),
        title=f"{run.engine_file.engine.name}, run-up in {found.duration:g} s",
    )


def plot_mode_shapes(path: Path, result: SourceResult) -> None:
    """Plot the first elastic mode shapes of a chain over its nodes."""
    with figure(path, height=3.4) as axes:
        draw_modes(axes, result)


def _plot_free_end(
    path: Path, forced: ForcedVibration, assessment: Assessment, engine: str
) -> None:
    torsional = forced.kind == "torsional"
    plot_over_speed(
        path,
        forced.free_end,
        0,
        "twist" if torsional else "displacement",
        limits=limit_curve(assessment, forced, f"{forced.kind}_amplitude"),
        barred=barred_ranges(assessment),
        title=f"{engine}, {forced.kind} vibration of the free end",
    )


def _plot_stress(path: Path, forced: ForcedVibration, assessment: Assessment, engine: str) -> None:
    """Plot the stress of the crankshaft's element that is stressed most, with limit and barred ranges."""
    assert forced.stress is not None
    plot_over_speed(
        path,
        forced.stress,
        most_stressed(forced),
        "stress",
        limits=limit_curve(assessment, forced, "crankshaft_stress"),
        barred=barred_ranges(assessment),
        title=f"{engine}, nominal torsional stress",
    )
