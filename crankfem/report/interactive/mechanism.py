"""The crank mechanism at one speed: loads of crankpin and main bearing, forces of a piston."""

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.curves import Curves, Dash, Dots, Series
from crankbase.drawing.diagram_style import BLUE, GRAY, GREEN, ORANGE
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.report.interactive.style import (
    QUIET_COLOR,
    Figure,
    Part,
    axis,
    degrees_of,
    dots,
    layout,
    level,
    line,
    note,
    number,
)
from dynamics.cycle import cycle_radians
from dynamics.engine.loads import LoadDiagram
from dynamics.plots.load_diagrams import OUTLINE, Frame, label_spots, on_paper, square_round
from dynamics.plots.quantities import KILO

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
    load : LoadDiagram
    frame : {"crank", "engine"}
        "crank": turning with the crank, which stands upright, tangential force to the right, radial
        force (towards the shaft) down. "engine": at rest, y up, seen from the free end.
    title : str

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


def developed_load(load: LoadDiagram) -> Curves:
    """Describe the size of a bearing's force over the shaft angle, with its mean and maximum."""
    degrees, size = load.angles_deg, KILO * load.magnitude
    mean, most = KILO * load.mean, KILO * load.maximum
    x = np.append(degrees, 2.0 * degrees[-1] - degrees[-2])
    level = np.full(len(x), mean)
    return Curves(
        x,
        (
            Series("force", np.append(size, size[0]), color=BLUE),
            Series(f"mean {number(mean, 3)} kN", level, color=BLUE, dash="dash"),
        ),
        "shaft angle [deg]",
        "force [kN]",
        x_step=90.0,
        dots=(
            Dots(
                np.array([load.maximum_angle_deg]),
                np.array([most]),
                f"maximum {number(most, 3)} kN",
                ORANGE,
            ),
        ),
    )


def piston_forces(run: MechanismRun, cylinder: int) -> Curves:
    """Describe gas force, side force and tangential force of a cylinder over the cycle."""
    forces, firing = run.forces, np.radians(run.layout.firing_deg[cylinder - 1])
    degrees = degrees_of(
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
