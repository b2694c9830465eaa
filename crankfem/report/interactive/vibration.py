"""The plots of an engine's vibration: mode shapes, Campbell diagrams, amplitudes over speed."""

from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.shaft.plots.shaft_mode_plots import plot_axial_split, plot_shaft_modes
from crankfem.analyses.vibration.modes import Vibration
from crankfem.analyses.vibration.plots.vibration_panels import free_end_title, stress_title
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.vibration_pictures import (
    plot_campbell,
    plot_free_end,
    plot_mode_shapes,
    plot_stress,
)
from crankfem.report.interactive.campbell import campbell
from crankfem.report.interactive.over_speed import Curve, amplitudes_over_speed
from crankfem.report.interactive.plot import Plot, Plots
from crankfem.report.interactive.shaft import axial_split, shaft_modes
from crankfem.report.interactive.shapes import mode_shapes
from crankfem.report.interactive.style import Figure
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.critical import engine_orders


def _of_kind(kind: str) -> tuple[Plot[EngineVibration], ...]:
    def own(run: EngineVibration) -> Vibration:
        return run.axial if kind == "axial" else run.torsional

    return (
        Plot(
            f"{kind}_modes",
            f"First {kind} mode shapes",
            f"{kind.capitalize()}: first mode shapes; crosses mark the nodes.",
            lambda path, run: plot_mode_shapes(path, own(run).chosen),
            lambda run: mode_shapes(
                own(run).chosen, f"{run.engine_file.engine.name}, {kind} mode shapes"
            ),
        ),
        Plot(
            f"{kind}_campbell",
            f"Campbell diagram, {kind}",
            f"{kind.capitalize()}: running range shaded; dots mark resonances and, where gas pressure is "
            "known, grow with their amplitude.",
            lambda path, run: plot_campbell(path, run, own(run)),
            lambda run: _campbell(run, own(run)),
        ),
        Plot(
            f"{kind}_amplitude",
            f"Amplitude of the free end over the speed, {kind}",
            "Amplitude of the free end over the speed: main orders, all orders over the cycle, and the "
            "plain sum of amplitudes.",
            lambda path, run: plot_free_end(path, run, kind),
            lambda run: _free_end(run, kind),
            needs="forced",
        ),
    )


def _campbell(run: EngineVibration, vibration: Vibration) -> Figure:
    engine, forced = run.engine_file.engine, run.forced(vibration.kind)
    return campbell(
        vibration.kind,
        vibration.chosen.elastic_frequencies,
        engine_orders(engine.strokes, run.engine_file.vibration.highest_order),
        (engine.lowest_speed, engine.highest_speed),
        () if forced is None else forced.resonances,
        f"{engine.name}, {vibration.kind}",
    )


def _free_end(run: EngineVibration, kind: str) -> Figure:
    forced, assessment = run.forced(kind), run.assessment
    assert forced is not None
    assert assessment is not None
    limit = assessment.limits.get(f"{kind}_amplitude")
    return amplitudes_over_speed(
        Curve(forced.free_end, 0, MOTION[kind].quantity, limit),
        assessment.verdict.ranges_to_bar,
        free_end_title(run.engine_file.engine.name, kind),
    )


def _stress(run: EngineVibration) -> Figure:
    """Show the crankshaft's element that is stressed most."""
    forced, assessment = run.forced_torsional, run.assessment
    assert forced is not None
    assert assessment is not None
    assert forced.stress is not None
    worst = forced.stress.largest_place
    return amplitudes_over_speed(
        Curve(forced.stress, worst, "stress", assessment.limits.get("crankshaft_stress")),
        assessment.verdict.ranges_to_bar,
        f"{stress_title(run.engine_file.engine.name)}, {forced.stress.names[worst]}",
    )


def _modes(run: EngineVibration) -> tuple[ShaftModes, float]:
    """Modes of the whole crankshaft, and the crank radius."""
    assert run.whole is not None
    return run.whole.modes, run.engine_file.throw.crank_radius


def _coupled(run: EngineVibration) -> CoupledResponse:
    assert run.comparison is not None
    assert run.comparison.coupled is not None
    return run.comparison.coupled


def _has(run: EngineVibration) -> list[str]:
    comparison = run.comparison
    return [
        name
        for name, there in (
            ("forced", run.assessment is not None),
            ("whole", run.whole is not None),
            ("coupled", comparison is not None and comparison.coupled is not None),
        )
        if there
    ]


VIBRATION: Plots[EngineVibration] = Plots(
    (
        *_of_kind("axial"),
        *_of_kind("torsional"),
        Plot(
            "torsional_stress",
            "Nominal torsional stress over the speed",
            "Nominal torsional stress in the element that is stressed most, with its limit.",
            plot_stress,
            _stress,
            needs="forced",
        ),
        Plot(
            "shaft_modes",
            "Modes of the whole crankshaft along its length",
            "Axial, torsional and lateral motion along the shaft in the first modes.",
            lambda path, run: plot_shaft_modes(path, *_modes(run)),
            lambda run: shaft_modes(
                *_modes(run), f"{run.engine_file.engine.name}, modes of the whole crankshaft"
            ),
            needs="whole",
        ),
        Plot(
            "axial_split",
            "Axial amplitude of the free end by tangential and radial forces",
            "Axial vibration of the free end under tangential forces alone, which act through torsion, "
            "under radial forces alone, and under both.",
            lambda path, run: plot_axial_split(path, _coupled(run)),
            lambda run: axial_split(
                _coupled(run), f"{run.engine_file.engine.name}, whole crankshaft"
            ),
            needs="coupled",
        ),
    ),
    _has,
)
