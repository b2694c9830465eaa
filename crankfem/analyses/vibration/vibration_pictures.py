"""The diagrams of an engine's vibration: mode shapes, Campbell diagrams, amplitudes over speed."""

from pathlib import Path

from crankbase.drawing.diagram_style import figure
from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.vibration.modes import SourceResult, Vibration
from crankfem.analyses.vibration.plots.response_plots import plot_over_speed, plot_response_campbell
from crankfem.analyses.vibration.plots.transient_plots import plot_transient
from crankfem.analyses.vibration.plots.vibration_panels import free_end_title, stress_title
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.run_up import RunUp
from dynamics.critical import engine_orders, major_orders


def plot_campbell(path: Path, run: EngineVibration, vibration: Vibration) -> None:
    """Plot a Campbell diagram; its dots are resonances or, where nothing is forced, critical speeds."""
    engine, forced = run.engine_file.engine, run.forced(vibration.kind)
    orders = engine_orders(engine.strokes, run.engine_file.vibration.highest_order)
    majors = major_orders(orders, engine.firing_angles)
    plot_response_campbell(
        path,
        vibration.chosen.elastic_frequencies,
        orders,
        (engine.lowest_speed, engine.highest_speed),
        vibration.critical_dots(majors) if forced is None else forced.resonances,
        title=f"{engine.name}, {vibration.kind}",
    )


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
        result.plot(axes)


def plot_free_end(path: Path, run: EngineVibration, kind: str) -> None:
    """Plot the amplitude of the free end over the speed, with limit and barred ranges."""
    forced, assessment = run.forced(kind), run.assessment
    assert forced is not None
    assert assessment is not None
    plot_over_speed(
        path,
        forced.free_end,
        0,
        MOTION[kind].quantity,
        limits=assessment.limit_curve(f"{kind}_amplitude", forced.response.speeds),
        barred=assessment.verdict.ranges_to_bar,
        title=free_end_title(run.engine_file.engine.name, kind),
    )


def plot_stress(path: Path, run: EngineVibration) -> None:
    """Plot the stress of the crankshaft's element that is stressed most, with limit and barred ranges."""
    forced, assessment = run.forced_torsional, run.assessment
    assert forced is not None
    assert assessment is not None
    assert forced.stress is not None
    plot_over_speed(
        path,
        forced.stress,
        forced.stress.largest_place,
        "stress",
        limits=assessment.limit_curve("crankshaft_stress", forced.response.speeds),
        barred=assessment.verdict.ranges_to_bar,
        title=stress_title(run.engine_file.engine.name),
    )
