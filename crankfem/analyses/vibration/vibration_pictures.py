"""The diagrams of an engine's vibration: mode shapes, Campbell diagrams, amplitudes over speed."""

from pathlib import Path

from crankbase.drawing.diagram_style import figure, make_folder
from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.shaft.plots.shaft_mode_plots import (
    plot_axial_split,
    plot_shaft_modes,
)
from crankfem.analyses.to_draw import ToDraw, draw_all
from crankfem.analyses.vibration.assessment import Assessment
from crankfem.analyses.vibration.forced import ForcedVibration
from crankfem.analyses.vibration.modes import SourceResult, Vibration
from crankfem.analyses.vibration.plots.response_plots import plot_over_speed, plot_response_campbell
from crankfem.analyses.vibration.plots.transient_plots import plot_transient
from crankfem.analyses.vibration.plots.vibration_panels import free_end_title, stress_title
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.run_up import RunUp
from dynamics.critical import engine_orders, major_orders


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
    return draw_all(vibration_pictures(folder, run))


def vibration_pictures(folder: Path, run: EngineVibration) -> list[ToDraw]:
    """Return the diagrams of an engine's vibration, still to be drawn into a folder."""
    made = [
        *_kind_pictures(folder, run, run.axial, run.forced_axial),
        *_kind_pictures(folder, run, run.torsional, run.forced_torsional),
    ]
    name, torsional, assessment = run.engine_file.engine.name, run.forced_torsional, run.assessment
    if torsional is not None and assessment is not None:
        made.append(
            ToDraw(
                folder / "torsional_stress.svg",
                lambda path: _plot_stress(path, torsional, assessment, name),
            )
        )
    if run.whole is not None:
        modes, radius = run.whole.modes, run.engine_file.throw.crank_radius
        made += [
            ToDraw(folder / "shaft_modes.svg", lambda path: plot_shaft_modes(path, modes, radius)),
        ]
    if run.comparison is not None and run.comparison.coupled is not None:
        coupled = run.comparison.coupled
        made.append(
            ToDraw(folder / "axial_split.svg", lambda path: plot_axial_split(path, coupled))
        )
    return made


def picture_names(*, forced: bool, coupled: bool) -> list[str]:
    """Return the names of the files that an engine's vibration surely needs, before it is computed.

    Parameters
    ----------
    forced : bool
        Whether the gas pressure is known.
    coupled : bool
        Whether the whole crankshaft is calculated.
    """
    of_kind = ("modes", "campbell", "amplitude") if forced else ("modes", "campbell")
    names = [f"{kind}_{name}" for kind in MOTION for name in of_kind]
    names += ["torsional_stress"] if forced else []
    names += ["shaft_modes"] if coupled else []
    return [f"{name}.svg" for name in names]


def _kind_pictures(
    folder: Path, run: EngineVibration, vibration: Vibration, forced: ForcedVibration | None
) -> list[ToDraw]:
    """Mode shapes, Campbell diagram and amplitude of one kind of vibration."""
    engine, kind, assessment = run.engine_file.engine, vibration.kind, run.assessment
    orders = engine_orders(engine.strokes, run.engine_file.vibration.highest_order)
    majors = major_orders(orders, engine.firing_angles)
    made = [
        ToDraw(folder / f"{kind}_modes.svg", lambda path: plot_mode_shapes(path, vibration.chosen)),
        ToDraw(
            folder / f"{kind}_campbell.svg",
            lambda path: plot_response_campbell(
                path,
                vibration.chosen.elastic_frequencies,
                orders,
                (engine.lowest_speed, engine.highest_speed),
                vibration.critical_dots(majors) if forced is None else forced.resonances,
                title=f"{engine.name}, {kind}",
            ),
        ),
    ]
    if forced is not None and assessment is not None:
        made.append(
            ToDraw(
                folder / f"{kind}_amplitude.svg",
                lambda path: _plot_free_end(path, forced, assessment, engine.name),
            )
        )
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
        result.plot(axes)


def _plot_free_end(
    path: Path, forced: ForcedVibration, assessment: Assessment, engine: str
) -> None:
    plot_over_speed(
        path,
        forced.free_end,
        0,
        MOTION[forced.kind].quantity,
        limits=assessment.limit_curve(f"{forced.kind}_amplitude", forced.response.speeds),
        barred=assessment.verdict.ranges_to_bar,
        title=free_end_title(engine, forced.kind),
    )


def _plot_stress(path: Path, forced: ForcedVibration, assessment: Assessment, engine: str) -> None:
    """Plot the stress of the crankshaft's element that is stressed most, with limit and barred ranges."""
    assert forced.stress is not None
    plot_over_speed(
        path,
        forced.stress,
        forced.stress.largest_place,
        "stress",
        limits=assessment.limit_curve("crankshaft_stress", forced.response.speeds),
        barred=assessment.verdict.ranges_to_bar,
        title=stress_title(engine),
    )
