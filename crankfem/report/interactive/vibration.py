"""The plots of an engine's vibration: mode shapes, Campbell diagrams, amplitudes over speed."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from crankbase.array_checks import Array
from crankbase.diagrams import BLUE, ORANGE, Diagram, Series, curve_diagram, with_gaps
from crankbase.quantity import RPM
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.titles import at_speed, short_name
from crankfem.analyses.vibration.engine_limits import limited_series
from crankfem.analyses.vibration.misfiring import FiringCheck
from crankfem.analyses.vibration.modes import Kind, SourceResult, Vibration
from crankfem.analyses.vibration.plots import plot_shaft_modes
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.report.interactive.plot import Plot, Plots, picture, plot_of_curves
from crankfem.report.interactive.style import (
    Figure,
    choice,
    described_traces,
    diagram_figure,
    number,
    visibility_by_choice,
)
from dynamics.assessment.limits import VibrationLimit
from dynamics.assessment.verdict import LimitCheck
from dynamics.crankshaft.coupled_response import CoupledResponse, split_curves
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.critical import engine_orders
from dynamics.plots.campbell import campbell
from dynamics.plots.curves import PLAIN_SUM, SPEED_LABEL, Quantity, in_unit, quantity_display
from dynamics.plots.mode_shapes import chain_shapes, shaft_shape
from dynamics.response.damped_criticals import DampedCritical
from dynamics.response.series import OrderSeries
from dynamics.wording import cylinders_named, limit_at

# Modes that are drawn before anybody asks for the others, and all that are there.
SHAPES_SHOWN, SHAPES = 3, 8


def mode_shapes(result: SourceResult, title: str) -> Figure:
    """Draw the first elastic mode shapes of a chain."""
    modes = result.modes
    shown = range(modes.rigid, modes.rigid + SHAPES)
    return diagram_figure(
        chain_shapes(
            modes.drawn_shapes(shown, result.chain.nodes, numbered=True),
            MOTION[result.chain.kind].quantity,
            SHAPES_SHOWN,
            [short_name(name) for name in result.chain.nodes],
        ),
        title,
    )


MODES_SHOWN = 10


def shaft_modes(modes: ShaftModes, radius: float, title: str) -> Figure:
    """Draw axial, torsional and lateral motion along the shaft, one elastic mode at a time.

    Parameters
    ----------
    radius : float
        Crank radius: rotation about the shaft is shown as the displacement there [m].

    Returns
    -------
    traces : list of dict
        Four for each mode; a menu chooses the mode.
    layout : dict
    """
    shown = range(modes.rigid, min(modes.rigid + MODES_SHOWN, len(modes.names)))
    order = np.argsort(modes.positions, kind="stable")
    shapes = [
        shaft_shape(modes.positions[order], modes.motions[order, :, mode], radius) for mode in shown
    ]
    traces = [
        trace | {"visible": not count}
        for count, shape in enumerate(shapes)
        for trace in described_traces(shape)
    ]
    labels = [f"{modes.frequencies[mode]:.1f} Hz: {modes.label(mode)}" for mode in shown]
    turns = visibility_by_choice(np.repeat(np.arange(len(labels)), 4).tolist(), len(labels))
    _, made = diagram_figure(shapes[0], title)
    menu = choice("mode", labels, [[{"visible": turn}] for turn in turns])
    return traces, made | {"updatemenus": [menu]}


HEIGHT = 480


def campbell_figure(
    kind: str,
    frequencies: Array,
    orders: Array,
    speed_range: tuple[float, float],
    resonances: Sequence[DampedCritical],
    title: str,
) -> Figure:
    """Draw `campbell` of a kind of vibration, with what each resonance is."""
    motion, texts = MOTION[kind], []
    for resonance in resonances:
        size = "unbounded: nothing damps it"
        if not resonance.unbounded:
            amplitude = number(resonance.first_amplitude / motion.size)
            size = (
                f"amplitude {amplitude} {motion.unit} of the free end, by this order alone; peak of "
                f"{resonance.place}"
            )
        texts.append(
            f"<b>order {resonance.order:g}, mode {resonance.mode}</b> ({resonance.kind})<br>"
            f"{resonance.speed_rpm:.5g} 1/min, {resonance.frequency:.5g} Hz<br>{size}"
        )
    return diagram_figure(
        campbell(frequencies, orders, speed_range, resonances, texts), title, HEIGHT
    )


AXIAL = MOTION["axial"]
# What a limit is on, by its unit.
QUANTITIES: dict[str, Quantity] = {
    "Pa": "stress",
    "N m": "torque",
    "N": "force",
    "rad": "twist",
    "m": "displacement",
}
# Of the legend on the first screen of a report, and the height there [pixel].
MOST_NAMED, DECIDING_HEIGHT = 5, 270


def _title(what: str) -> Callable[[EngineVibration], str]:
    return lambda run: f"{run.engine_file.engine.name}, {what}"


def _of_kind(kind: Kind) -> tuple[Plot[EngineVibration], ...]:
    shapes, itself = _title(f"{kind} mode shapes"), _title(kind)
    return (
        Plot(
            f"{kind}_modes",
            f"First {kind} mode shapes",
            f"{kind.capitalize()}: first mode shapes; crosses mark the nodes.",
            picture(lambda axes, run: run.plot(axes, kind=kind, show="modes"), shapes, height=3.6),
            lambda run: mode_shapes(run.modes(kind).chosen, shapes(run)),
        ),
        Plot(
            f"{kind}_campbell",
            f"Campbell diagram, {kind}",
            f"{kind.capitalize()}: running range shaded; dots mark resonances. If gas pressure is given, "
            "larger dots have larger amplitudes and frequencies include damping; an overdamped mode is "
            "shown at its undamped frequency.",
            picture(lambda axes, run: run.plot(axes, kind=kind), itself, height=4.8),
            lambda run: _campbell(run, run.modes(kind), itself(run)),
        ),
        plot_of_curves(
            f"{kind}_amplitude",
            f"Amplitude of the free end over the speed, {kind}",
            "Amplitude of the free end over the speed: main orders, all orders over the cycle, and the "
            "plain sum of amplitudes.",
            lambda run: _free_end(run, kind),
            _title(f"{kind} vibration of the free end"),
            needs="forced",
        ),
    )


def _campbell(run: EngineVibration, vibration: Vibration, title: str) -> Figure:
    engine, forced = run.engine_file.engine, run.forced_of(vibration.kind)
    return campbell_figure(
        vibration.kind,
        vibration.chosen.elastic_frequencies if forced is None else forced.frequencies,
        engine_orders(engine.strokes, run.engine_file.vibration.highest_order),
        (engine.lowest_speed, engine.highest_speed),
        () if forced is None else forced.peaks,
        title,
    )


def _free_end(run: EngineVibration, kind: str) -> Diagram:
    forced, assessment = run.forced_of(kind), run.assessment
    assert forced is not None
    assert assessment is not None
    return amplitudes_over_speed(
        forced.free_end,
        0,
        MOTION[kind].quantity,
        assessment.limits.get(f"{kind}_amplitude"),
        assessment.verdict.ranges_to_bar,
        forced.running_range,
    )


def _stress(run: EngineVibration) -> Diagram:
    """Show the element, of crankshaft or shaft line, that uses its limit most."""
    forced, assessment = run.forced_torsional, run.assessment
    assert forced is not None
    assert assessment is not None
    stress, place, limit = _judged(run, _worst_stress(run))
    return amplitudes_over_speed(
        stress, place, "stress", limit, assessment.verdict.ranges_to_bar, forced.running_range
    )


def _worst(run: EngineVibration) -> LimitCheck:
    assert run.assessment is not None
    return run.assessment.verdict.deciding


def _worst_stress(run: EngineVibration) -> LimitCheck:
    # The worst comes first; the crankshaft's stress always has a limit.
    assert run.assessment is not None
    return next(check for check in run.assessment.verdict.checks if check.limit.unit == "Pa")


def _judged(run: EngineVibration, check: LimitCheck) -> tuple[OrderSeries, int, VibrationLimit]:
    """Return what a limit is on, the place among it that a check judges, and the limit."""
    axial, torsional = run.forced_axial, run.forced_torsional
    assert run.assessment is not None
    assert axial is not None
    assert torsional is not None
    limits = run.assessment.limits.items()
    key = next(name for name, limit in limits if limit.name == check.limit.name)
    series = limited_series(run.engine_file, axial, torsional, [key])[key]
    return series, series.names.index(check.curve.name), check.limit


def _deciding(run: EngineVibration) -> Diagram:
    """Show what uses most of a limit: all orders, the limit, and the orders that contribute most."""
    worst = _worst(run)
    series, place, limit = _judged(run, worst)
    assert worst.cause is not None
    assert run.assessment is not None
    assert run.forced_torsional is not None
    drawn = amplitudes_over_speed(
        series,
        place,
        QUANTITIES[limit.unit],
        limit,
        run.assessment.verdict.ranges_to_bar,
        run.forced_torsional.running_range,
    )
    lines = {line.name: line for line in drawn.lines}
    orders = sorted(worst.cause.parts, key=lambda part: -part.contribution)
    names = [f"order {part.order:g}" for part in orders]
    main = [line for line in drawn.lines if line.main and line.name not in (PLAIN_SUM, *names)]
    named = {band.name for band in drawn.bands} | {mark.name for mark in drawn.marks}
    room = max(0, MOST_NAMED - len(main) - len(named))
    return replace(
        drawn, lines=[*main, *(lines[name]._replace(main=True) for name in names[:room])]
    )


def _misfiring_stress(run: EngineVibration) -> Diagram:
    """Describe a shaft's stress over the running speeds, all cylinders firing and one misfiring."""
    check = _stress_check(run)
    assert check.over_speed is not None
    assert check.limit is not None
    speeds, normal, failing = check.over_speed
    shown = quantity_display("stress", "SI")
    limits = {
        "limit": check.limit.continuous.at(speeds),
        "limit while misfiring": check.limit.misfiring.at(speeds),
    }
    return curve_diagram(
        x=speeds * RPM,
        series=(
            Series("all cylinders firing", with_gaps(shown.factor * normal), color=BLUE),
            Series(
                f"{cylinders_named(check.cylinders)} not firing",
                with_gaps(shown.factor * failing),
                color=ORANGE,
            ),
            *(
                Series(name, with_gaps(shown.factor * values), "limit", number)
                for number, (name, values) in enumerate(limits.items())
            ),
        ),
        x_label=SPEED_LABEL,
        y_label=shown.label,
    )


def _stress_check(run: EngineVibration) -> FiringCheck:
    assert run.misfiring is not None
    assert run.misfiring.of_stress is not None
    return run.misfiring.of_stress


def amplitudes_over_speed(
    series: OrderSeries,
    place: int,
    quantity: Quantity,
    limit: VibrationLimit | None,
    barred: Sequence[tuple[float, float]],
    running: tuple[float, float] | None = None,
) -> Diagram:
    """Describe a place's amplitudes over the speed, with their limit as far as it is stated.

    Parameters
    ----------
    place : int
        In the series, from 0.
    quantity : {"twist", "displacement", "torque", "force", "stress"}
    barred : sequence of pairs of floats
        Ranges of speed [rad/s].
    running : tuple of two floats, optional
        Lowest and highest running speed [rad/s], outside of which is shaded.
    """
    limits, passing = {}, {}
    if limit is not None:
        limits["limit"] = limit.continuous.at(series.speeds)
        if limit.passing is not None:
            values = limit.passing.at(series.speeds)
            if np.isfinite(values).any():
                passing["limit while passing"] = values
    shown = quantity_display(quantity, "SI")
    return series.over_speed(
        place, shown, limits=limits, passing=passing, barred=barred, running=running
    )


def _axial_force(run: EngineVibration) -> Diagram:
    assert run.axial_force is not None
    return run.axial_force.curves()


def _axial_split(run: EngineVibration) -> Diagram:
    assert run.comparison is not None
    assert run.comparison.coupled is not None
    return axial_split(run.comparison.coupled)


def axial_split(response: CoupledResponse) -> Diagram:
    """Describe the axial amplitude of the free end, all orders together, by what excites it."""
    split = response.split("main bearing 1 uz")
    return split_curves(
        response.speeds,
        (split.both_sum, split.tangential_sum, split.radial_sum),
        in_unit(AXIAL.si).factor,
        f"axial amplitude of the free end [{AXIAL.unit}]",
    )


def _modes(run: EngineVibration) -> tuple[ShaftModes, float]:
    """Modes of the whole crankshaft, and the crank radius."""
    assert run.whole is not None
    return run.whole.modes, run.engine_file.throw.crank_radius


def _has(run: EngineVibration) -> list[str]:
    comparison = run.comparison
    return [
        name
        for name, there in (
            ("forced", run.assessment is not None),
            ("misfiring", run.misfiring is not None and run.misfiring.of_stress is not None),
            ("whole", run.whole is not None),
            ("coupled", comparison is not None and comparison.coupled is not None),
        )
        if there
    ]


VIBRATION: Plots[EngineVibration] = Plots(
    (
        *_of_kind("axial"),
        *_of_kind("torsional"),
        plot_of_curves(
            "axial_force",
            "Axial force over the cycle, on the thrust bearing and on held ends",
            "Axial force at rated speed: on the thrust bearing with vibration, and on the ends if both were "
            "held without vibration.",
            _axial_force,
            lambda run: at_speed(run.engine_file.engine.name, run.engine_file.engine.rated_speed),
            needs="forced",
        ),
        plot_of_curves(
            "torsional_stress",
            "Nominal torsional stress by order over the speed",
            "Nominal torsional stress by order in the element that uses most of its limit, with the limit.",
            _stress,
            lambda run: _title(f"nominal torsional stress, {_worst_stress(run).place}")(run),
            needs="forced",
        ),
        plot_of_curves(
            "deciding",
            "What uses most of its limit, over the speed",
            "What uses most of its limit, over the speed: all orders over the cycle, the limit, and the "
            "largest contribution by order where most is used.",
            _deciding,
            lambda run: limit_at(_worst(run).limit.name, _worst(run).place),
            needs="forced",
            height=DECIDING_HEIGHT,
        ),
        plot_of_curves(
            "misfiring_stress",
            "Nominal torsional stress over the speed, all cylinders firing and one misfiring",
            "Nominal torsional stress at running speeds, all orders over the cycle: all cylinders firing and "
            "the worst case of misfiring, in the element that is then closest to its limit.",
            _misfiring_stress,
            lambda run: _title(f"misfiring, {_stress_check(run).misfiring.place}")(run),
            needs="misfiring",
            height=DECIDING_HEIGHT,
        ),
        Plot(
            "shaft_modes",
            "Modes of the whole crankshaft along its length",
            "Axial, torsional and lateral motion along the shaft in the first modes; tilting is not drawn.",
            lambda path, run: plot_shaft_modes(path, *_modes(run)),
            lambda run: shaft_modes(*_modes(run), _title("modes of the whole crankshaft")(run)),
            needs="whole",
        ),
        plot_of_curves(
            "axial_split",
            "Axial amplitude of the free end by tangential and radial forces",
            "Axial vibration of the free end under tangential forces alone, which act through torsion, "
            "under radial forces alone, and under both.",
            _axial_split,
            _title("whole crankshaft"),
            needs="coupled",
        ),
    ),
    _has,
)
