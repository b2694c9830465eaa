"""Diagrams of the class document: mode shapes, phase vectors, stresses over the speed."""

from pathlib import Path

import numpy as np

from crankbase.drawing.diagram_style import GREEN, ORANGE, figure, with_gaps
from crankbase.drawing.legends import legend_below
from crankbase.units.units import RPM
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.submission.firing_cases import CUT_OUT, MISFIRING, STRESS, FiringCases
from crankfem.analyses.submission.mode_tables import mode_stars, shown_modes
from crankfem.analyses.submission.stress_tables import permitted_curves
from crankfem.analyses.titles import short_name
from crankfem.analyses.vibration.modes import mode_label
from crankfem.analyses.vibration.run import EngineVibration
from dynamics.plots.harmonics import draw_star, finish_stars
from dynamics.plots.mode_shapes import draw_chain_shapes
from dynamics.plots.quantities import quantity_display
from dynamics.torque.star import same_stars

# Stars in a row of a picture, and mode shapes in one picture.
STARS_IN_ROW, SHAPES = 5, 3
# Stars in a row of a picture of which two stand beside each other.
STARS_IN_HALF = 3
# Orders of single lines in a diagram over the speed.
MAIN_ORDERS = 4
FAILING_COLORS = {MISFIRING: ORANGE, CUT_OUT: GREEN}


def draw_modes(path: Path, run: EngineVibration, first: int) -> None:
    """Draw the shapes of some of the modes shown, from index `first` on."""
    result = run.torsional.chosen
    modes, chain = result.modes, result.chain.chain
    shown = list(shown_modes(run)[first : first + SHAPES])
    still = [modes.node_positions[mode] for mode in shown]
    with figure(path, height=3.6) as axes:
        draw_chain_shapes(
            axes,
            modes.shapes[:, shown],
            [
                f"mode {mode - modes.rigid + 1}: {mode_label(float(modes.frequencies[mode]), own)}"
                for mode, own in zip(shown, still, strict=True)
            ],
            still,
            chain.connections,
            [short_name(name) for name in chain.names],
            MOTION["torsional"].quantity,
        )


def star_rows(run: EngineVibration, mode: int) -> tuple[int, int]:
    """Return the numbers of rows and columns of the phase vectors of a mode."""
    count = len(same_stars(mode_stars(run, mode)))
    columns = min(STARS_IN_ROW, count)
    return -(-count // columns), columns


def draw_vectors(path: Path, run: EngineVibration, mode: int) -> None:
    """Draw the phase vectors of all orders in one mode, orders of equal shape together."""
    groups = same_stars(mode_stars(run, mode))
    rows, columns = star_rows(run, mode)
    with figure(path, width=1.5 * columns + 0.4, height=1.85 * rows) as axes:
        for place, group in enumerate(groups):
            row, column = divmod(place, columns)
            orders = ", ".join(f"{star.order:g}" for star in group[:5])
            more = " ..." if len(group) > 5 else ""
            center = (3.4 * column, -1.15 * 3.4 * row)
            draw_star(axes, group[0], f"{orders}{more}", center)
        finish_stars(axes, rows, columns)


def draw_stress(path: Path, run: EngineVibration, cases: FiringCases, place: int) -> None:
    """Draw the stress of one location over the speed: main orders, all orders, cylinders failing, limits."""
    series = cases.normal[STRESS]
    name, forced = series.names[place], run.forced_torsional
    display = quantity_display("stress", "SI")
    barred = [] if run.assessment is None else run.assessment.verdict.ranges_to_bar
    with figure(path, height=3.7) as axes:
        series.plot(
            axes,
            place,
            quantity="stress",
            limits=permitted_curves(cases, name),
            barred=barred,
            main_orders=MAIN_ORDERS,
            running=None if forced is None else forced.running_range,
        )
        top = axes.get_ylim()[1]
        for way, envelope in cases.envelopes.items():
            values = envelope[:, place] / 1e6
            axes.plot(
                RPM * cases.speeds,
                with_gaps(values),
                color=FAILING_COLORS[way],
                linestyle="--",
                linewidth=1.2,
                label=f"{way}, worst of each",
            )
            top = max(top, 1.05 * float(np.max(values[np.isfinite(values)], initial=0.0)))
        axes.set_ylim(0.0, top)
        axes.set_ylabel(display.label)
        legend_below(axes, 3)
