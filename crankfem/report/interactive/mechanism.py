"""The crank mechanism at one speed: loads of crankpin and main bearing, forces of a piston."""

import numpy as np
from numpy.typing import NDArray

from crankbase.diagrams import BLUE, GRAY, GREEN, ORANGE, Curves, Dash, Series
from crankfem.analyses.mechanism.hinged_rods import piston_names
from crankfem.analyses.mechanism.mechanism_run import MechanismRun, hinged_group
from crankfem.analyses.mechanism.plots import (
    plot_accelerations,
    plot_balance,
    plot_hinged_rods,
    plot_polar_loads,
)
from crankfem.analyses.titles import at_speed
from crankfem.report.interactive.plot import Plot, Plots, plot_of_curves
from crankfem.report.interactive.style import (
    QUIET_COLOR,
    Figure,
    Part,
    axis,
    dots,
    layout,
    level,
    line,
    note,
)
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import LoadDiagram
from dynamics.plots.curves import KILO
from dynamics.plots.load_diagrams import (
    OUTLINE,
    Frame,
    developed_load,
    label_spots,
    on_paper,
    square_round,
)

Array = NDArray[np.float64]

# A point of a polar diagram for every so many degrees of shaft angle, and a mark.
POINT_STEP, MARK_STEP = 1.0, 30.0
SQUARE = 560  # pixels
AXES = {
    "crank": (
        "tangential force T [kN] (right: with the rotation)",
        "outward force -Z [kN]",
        "T",
        "-Z",
    ),
    "engine": ("force across -x [kN]", "force up y [kN]", "-x", "y"),
}


def polar_load(load: LoadDiagram, frame: Frame, title: str) -> Figure:
    """Draw the locus of a bearing's force vector.

    Parameters
    ----------
    frame : {"crank", "engine"}
        "crank": turning with the crank, which stands upright, tangential force to the right, radial
        force (towards the shaft) down. "engine": at rest, y up, seen from the free end.

    Returns
    -------
    traces : list of dict
        The curve, then marks at whole steps of shaft angle.
    layout : dict
    """
    force = on_paper(load, frame)
    degrees = load.angles_deg
    step = degrees[1] - degrees[0]
    kept = np.arange(0, len(degrees), max(1, round(POINT_STEP / step)))
    closed = np.append(kept, 0)
    across, up = force.real, force.imag
    right_title, up_title, right_name, up_name = AXES[frame]
    hover = (
        "shaft angle %{customdata[0]:.4g} deg<br><b>%{customdata[1]:.4g} kN</b><br>"
        f"{right_name} %{{x:.4g}} kN, {up_name} %{{y:.4g}} kN"
    )
    low, high = square_round([force])
    half = 0.5 * (high[0] - low[0])
    marks = np.flatnonzero(np.abs((degrees + 1e-6) % MARK_STEP) < 0.5 * step)
    traces = [
        line(
            across[closed],
            up[closed],
            load.name,
            BLUE,
            hover,
            width=1.8,
            customdata=_hover_values(degrees, force, closed),
        ),
        dots(
            across[marks],
            up[marks],
            f"every {MARK_STEP:g} deg",
            BLUE,
            hover,
            size=6,
            customdata=_hover_values(degrees, force, marks),
        ),
    ]
    notes = [
        # Adding zero turns -0 into 0.
        note(f"{round(angle) + 0:g}°", size=11, color=QUIET_COLOR, x=spot.real, y=spot.imag)
        for angle, spot in zip(
            degrees[marks].tolist(), label_spots(force, force[marks], 2.0 * half), strict=True
        )
        if spot is not None
    ]
    return traces, layout(
        axis(right_title, range=[low[0], high[0]], constrain="domain"),
        axis(up_title, range=[low[1], high[1]], scaleanchor="x", constrain="domain"),
        title=title,
        height=SQUARE,
        showlegend=False,
        annotations=notes,
        shapes=[
            level(0.0),
            level(0.0) | {"xref": "x", "yref": "y domain", "x0": 0, "x1": 0, "y0": 0, "y1": 1},
            *_journal(frame, OUTLINE * 2.0 * half),
        ],
    )


def piston_forces(run: MechanismRun, cylinder: int) -> Curves:
    """Describe gas force, side force and tangential force of a cylinder over the cycle."""
    forces, firing = run.forces, np.radians(run.layout.firing_deg[cylinder - 1])
    degrees = np.degrees(
        (np.radians(forces.shaft_angles_deg) - firing) % cycle_radians(run.layout.strokes)
    )
    order = np.argsort(degrees)
    looks: tuple[tuple[Array, str, Dash, str], ...] = (
        (forces.gas, BLUE, "solid", "gas, towards the shaft"),
        (forces.tangential, ORANGE, "dash", "tangential, T"),
        (forces.side, GREEN, "dashdot", "side, N"),
    )
    return Curves(
        degrees[order],
        tuple(
            Series(name, KILO * values[cylinder - 1][order], color=color, dash=dash)
            for values, color, dash, name in looks
        ),
        "crank angle from the firing top [deg]",
        "force [kN]",
        signed=True,
        x_step=90.0,
    )


def _hover_values(
    degrees: Array, force: NDArray[np.complex128], those: NDArray[np.int64]
) -> list[list[float]]:
    """Return shaft angle [deg] and size of the force for hovering."""
    return [
        [round(angle, 2), float(f"{size:.5g}")]
        for angle, size in zip(degrees[those].tolist(), np.abs(force[those]).tolist(), strict=True)
    ]


def _journal(frame: str, radius: float) -> list[Part]:
    """Draw the journal round the origin, and the crank below it in its own frame."""
    look = {"xref": "x", "yref": "y", "line": {"color": GRAY, "width": 1}, "layer": "below"}
    circle = look | {
        "type": "circle",
        "x0": -radius,
        "x1": radius,
        "y0": -radius,
        "y1": radius,
        "fillcolor": "#e3e7ec",
    }
    if frame != "crank":
        return [circle]
    crank = look | {
        "type": "rect",
        "x0": -0.7 * radius,
        "x1": 0.7 * radius,
        "y0": -3.2 * radius,
        "y1": 0.0,
        "fillcolor": "#f1f3f6",
    }
    return [crank, circle]


# Loads that differ by a smaller share are alike.
ALIKE = 1e-6


def _engine(run: MechanismRun) -> str:
    return at_speed(run.mechanism.name, run.speed)


def _of_bearing(
    name: str, frame: Frame, polar: tuple[str, str], developed: tuple[str, str]
) -> tuple[Plot[MechanismRun], ...]:
    """Both diagrams of a load, with their words: that of the first crankpin, or the heaviest bearing."""

    def load(run: MechanismRun) -> LoadDiagram:
        if name == "crankpin":
            return run.crankpins[0]
        most = max(bearing.maximum for bearing in run.bearings)
        # The first of those that are alike but for round-off.
        return next(bearing for bearing in run.bearings if bearing.maximum > (1.0 - ALIKE) * most)

    def title(run: MechanismRun, between: str = ", ") -> str:
        return f"{load(run).name}{between}{_engine(run)}"

    return (
        Plot(
            f"{name}_polar",
            *polar,
            lambda path, run: plot_polar_loads(
                path, [load(run)], frame=frame, title=title(run, "\n")
            ),
            lambda run: polar_load(load(run), frame, title(run)),
        ),
        plot_of_curves(
            f"{name}_developed", *developed, lambda run: developed_load(load(run)), title
        ),
    )


def _has(run: MechanismRun) -> list[str]:
    balanced = all(row.force_balanced and row.moment_balanced for row in run.balance.rows)
    return [*([] if balanced else ["unbalanced"]), *(["hinged rods"] if run.hinged_rods else [])]


MECHANISM: Plots[MechanismRun] = Plots(
    (
        *_of_bearing(
            "crankpin",
            "crank",
            (
                "Polar diagram of the crankpin load",
                "Force of the rod on the first crankpin, in the frame rotating with the crank; dots every "
                "30 deg of shaft angle.",
            ),
            (
                "Size of the crankpin load over the shaft angle",
                "The same load over the shaft angle, with its mean and maximum.",
            ),
        ),
        *_of_bearing(
            "main_bearing",
            "engine",
            (
                "Polar diagram of the main bearing load",
                "Load of the most heavily loaded main bearing, in the fixed frame, seen from the free end.",
            ),
            (
                "Size of the main bearing load over the shaft angle",
                "The main bearing load over the shaft angle, with its mean and maximum.",
            ),
        ),
        plot_of_curves(
            "piston_forces",
            "Gas, tangential and side force of one cylinder over the cycle",
            "Forces of the first cylinder over its cycle.",
            lambda run: piston_forces(run, 1),
            lambda run: f"cylinder 1, {_engine(run)}",
        ),
        Plot(
            "balance",
            "Inertia forces and moments on the engine by order",
            "Unbalanced forces and moments, seen from the free end. A dot marks the vector at shaft angle "
            "zero, with the first crank up; an arrowhead marks its sense of rotation; thin dashed lines: "
            "cylinder axes.",
            lambda path, run: plot_balance(path, run.balance, title=_engine(run)),
            needs="unbalanced",
        ),
        Plot(
            "hinged_rods",
            "Effect of the hinged rods compared with rods on the crankpin",
            "Effect of the hinged rods.",
            lambda path, run: plot_hinged_rods(
                path, run.layout, run.speed, cylinders=hinged_group(run.layout), title=_engine(run)
            ),
            needs="hinged rods",
        ),
        Plot(
            "accelerations",
            "Accelerations of the pistons of main and hinged rods, by order",
            "Pistons on the first crankpin with hinged rods, each at the same angle from its own top.",
            lambda path, run: plot_accelerations(
                path,
                run.layout,
                run.speed,
                piston_names(run.layout, hinged_group(run.layout)),
                title=_engine(run),
            ),
            needs="hinged rods",
        ),
    ),
    _has,
)
