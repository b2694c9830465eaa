"""The diagrams of an engine's vibration: mode shapes, Campbell diagrams, amplitudes over speed."""

from pathlib import Path

import numpy as np

from crankfem.pictures.response_plots import plot_over_speed, plot_response_campbell
from crankfem.pictures.shaft_mode_plots import plot_axial_split, plot_mode_shares, plot_shaft_modes
from crankfem.pictures.transient_plots import plot_transient
from crankfem.vibration.assessment import Assessment
from crankfem.vibration.forced import ForcedVibration
from crankfem.vibration.modes import SourceResult
from crankfem.vibration.run import EngineVibration
from crankfem.vibration.run_up import RunUp
from dynamics.checks import FloatArray
from dynamics.critical import engine_orders
from geometry.diagram_style import COLORS, GRAY, figure, make_folder

SHAPES_SHOWN = 3
# Letters that stand side by side under the axis.
ROOM = 90


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
    worst = int(np.argmax(found.largest))
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
    modes, chain = result.modes, result.chain.chain
    places = np.arange(len(result.chain.nodes))
    with figure(path, height=3.4) as axes:
        axes.axhline(0.0, color=GRAY, linewidth=1.0)
        for shown, mode in enumerate(range(modes.rigid, len(modes.frequencies))):
            if shown == SHAPES_SHOWN:
                break
            shape, color = modes.shapes[:, mode], COLORS[shown]
            for pair in chain.connections:
                axes.plot(places[list(pair)], shape[list(pair)], "-", color=color)
            nodes = len(modes.node_positions[mode])
            axes.plot(
                places,
                shape,
                "o",
                color=color,
                markersize=4,
                label=f"{modes.frequencies[mode]:.1f} Hz, {nodes} node{'s' if nodes != 1 else ''}",
            )
            still = _between(modes.node_positions[mode], chain.connections)
            axes.plot(still, np.zeros(nodes), "x", color=color, markersize=7)
        labels = [_short(name) for name in result.chain.nodes]
        crowded = sum(len(label) for label in labels) > ROOM
        axes.set_xticks(
            places,
            [label.replace("\n", " ") for label in labels] if crowded else labels,
            fontsize=8,
            rotation=40 if crowded else 0,
            ha="right" if crowded else "center",
        )
        axes.set_ylabel("relative " + ("displacement" if result.chain.kind == "axial" else "twist"))
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _between(positions: tuple[float, ...], pairs: tuple[tuple[int, int], ...]) -> list[float]:
    """Return where positions on elements lie on the axis of node numbers."""
    found = []
    for position in positions:
        number = min(int(position), len(pairs) - 1)
        left, right = pairs[number]
        found.append(left + (position - number) * (right - left))
    return found


def _short(name: str) -> str:
    return (
        name.replace("cylinder ", "cyl. ")
        .replace("section ", "")
        .replace(", flywheel", "\nflywheel")
        .replace(", thrust bearing", "\nthrust")
        .replace("driven machine", "driven\nmachine")
        .replace("damper ring", "damper\nring")
    )


def _plot_free_end(
    path: Path, forced: ForcedVibration, assessment: Assessment, engine: str
) -> None:
    torsional = forced.kind == "torsional"
    plot_over_speed(
        path,
        forced.free_end,
        0,
        "twist" if torsional else "displacement",
        limits=_limits(assessment, forced, f"{forced.kind}_amplitude"),
        barred=_barred(assessment),
        title=f"{engine}, {forced.kind} vibration of the free end",
    )


def _plot_stress(path: Path, forced: ForcedVibration, assessment: Assessment, engine: str) -> None:
    """Plot the stress of the crankshaft's element that is stressed most, with limit and barred ranges."""
    assert forced.stress is not None
    worst = int(np.argmax(np.max(forced.stress.synthesis.amplitude, axis=0)))
    plot_over_speed(
        path,
        forced.stress,
        worst,
        "stress",
        limits=_limits(assessment, forced, "crankshaft_stress"),
        barred=_barred(assessment),
        title=f"{engine}, nominal torsional stress",
    )


def _barred(assessment: Assessment) -> list[tuple[float, float]]:
    """Return the speed ranges that may be barred, whatever limit asks for them [rad/s]."""
    return [(one.low, one.high) for one in assessment.verdict.barred if one.allowed]


def _limits(assessment: Assessment, forced: ForcedVibration, name: str) -> dict[str, FloatArray]:
    """Return a limit over the speeds by the name it has in a legend, if there is one."""
    limit = assessment.limits.get(name)
    if limit is None:
        return {}
    return {"limit": limit.continuous.at(forced.response.speeds)}
