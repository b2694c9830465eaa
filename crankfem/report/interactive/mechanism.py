"""The crank mechanism at one speed: loads of crankpin and main bearing, forces of a piston."""

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import BLUE, GRAY, GREEN, ORANGE
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.report.interactive.curve_decimation import visible_points
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
    number,
)
from dynamics.engine.loads import LoadDiagram

Array = NDArray[np.float64]

KILO = 1e-3
# A point of a polar diagram for every so many degrees of shaft angle, and a mark.
POINT_STEP, MARK_STEP = 1.0, 30.0
# The outline of the journal is a symbol, its radius this share of the diagram's width.
OUTLINE, MARGIN = 0.045, 0.08
# Share of the height that a thinned curve may miss, and the longest way without a point [deg].
UNSEEN, HOVER_STEP = 5e-4, 4.0
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


def polar_load(load: LoadDiagram, frame: str, title: str) -> Figure:
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
    # Up are -Z, outwards along the crank, and y; to the right T, and -x as seen from the free end.
    force = KILO * (load.in_crank_frame if frame == "crank" else load.force)
    degrees = degrees_of(load.angles)
    step = degrees[1] - degrees[0]
    kept = np.arange(0, len(degrees), max(1, round(POINT_STEP / step)))
    closed = np.append(kept, 0)
    across, up = force.imag, force.real
    right_title, up_title, right_name, up_name = AXES[frame]
    hover = (
        "shaft angle %{customdata[0]:.4g} deg<br><b>%{customdata[1]:.4g} kN</b><br>"
        f"{right_name} %{{x:.4g}} kN, {up_name} %{{y:.4g}} kN"
    )
    span = 1.0 + 2.0 * MARGIN
    points = np.concatenate([force, [0.0]])
    low = np.array([points.imag.min(), points.real.min()])
    high = np.array([points.imag.max(), points.real.max()])
    middle, half = 0.5 * (low + high), 0.5 * span * float((high - low).max())
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
            mode="markers+text",
            text=_spaced_labels(degrees[marks], force[marks], 0.16 * half),
            textposition=[
                _side(complex(one), complex(force.mean())) for one in force[marks].tolist()
            ],
            textfont={"size": 11, "color": QUIET_COLOR},
        ),
    ]
    ranges = [[float(one - half), float(one + half)] for one in middle]
    return traces, layout(
        axis(right_title, range=ranges[0], constrain="domain"),
        axis(up_title, range=ranges[1], scaleanchor="x", constrain="domain"),
        title=title,
        height=SQUARE,
        showlegend=False,
        shapes=[
            level(0.0),
            level(0.0) | {"xref": "x", "yref": "y domain", "x0": 0, "x1": 0, "y0": 0, "y1": 1},
            *_journal(frame, OUTLINE * 2.0 * half),
        ],
    )


def developed_load(load: LoadDiagram, title: str) -> Figure:
    """Draw the size of a bearing's force over the shaft angle, with its mean and maximum."""
    degrees = degrees_of(load.angles)
    size = KILO * load.magnitude
    x, y = np.append(degrees, 2.0 * degrees[-1] - degrees[-2]), np.append(size, size[0])
    kept = visible_points(x, y, UNSEEN * float(y.max()), HOVER_STEP)
    mean, most = KILO * load.mean, KILO * load.maximum
    told = "shaft angle %{x:.4g} deg<br>%{y:.4g} kN"
    traces = [
        line(x[kept], y[kept], "force", BLUE, told, width=1.8),
        line(
            np.linspace(x[0], x[-1], 25),
            np.full(25, mean),
            f"mean {number(mean)} kN",
            BLUE,
            f"mean {number(mean)} kN",
            width=1.2,
            dash="dash",
        ),
        dots(
            [float(np.degrees(load.maximum_angle))],
            [most],
            f"maximum {number(most)} kN",
            ORANGE,
            f"maximum<br>{told}",
            size=9,
        ),
    ]
    return traces, layout(
        _angle_axis("shaft angle [deg]", x),
        axis("force [kN]", rangemode="tozero"),
        title=title,
    )


def piston_forces(run: MechanismRun, cylinder: int, title: str) -> Figure:
    """Draw gas force, side force and tangential force of a cylinder over the cycle."""
    forces, firing = run.forces, run.layout.firing[cylinder - 1]
    degrees = degrees_of((forces.shaft_angles - firing) % run.layout.cycle)
    order = np.argsort(degrees)
    x = degrees[order]
    traces = []
    for values, color, dash, label in (
        (forces.gas, BLUE, "solid", "gas, towards the shaft"),
        (forces.tangential, ORANGE, "dash", "tangential, T"),
        (forces.side, GREEN, "dashdot", "side, N"),
    ):
        y = KILO * values[cylinder - 1][order]
        kept = visible_points(x, y, UNSEEN * float(np.ptp(y)), HOVER_STEP)
        told = f"{label}<br>%{{x:.4g}} deg after the firing top<br>%{{y:.4g}} kN"
        traces.append(line(x[kept], y[kept], label, color, told, width=1.8, dash=dash))
    cycle = float(np.degrees(run.layout.cycle))
    return traces, layout(
        _angle_axis("crank angle from the firing top [deg]", np.array([0.0, cycle])),
        axis("force [kN]"),
        title=title,
        shapes=[level(0.0)],
    )


def _angle_axis(title: str, x: Array) -> Part:
    return axis(title, range=[float(x[0]), float(x[-1])], dtick=90, tick0=0)


def _hover_values(
    degrees: Array, force: NDArray[np.complex128], those: NDArray[np.int64]
) -> list[list[float]]:
    """Return shaft angle [deg] and size of the force for hovering."""
    return [
        [round(angle, 2), float(f"{size:.5g}")]
        for angle, size in zip(degrees[those].tolist(), np.abs(force[those]).tolist(), strict=True)
    ]


def _spaced_labels(degrees: Array, force: NDArray[np.complex128], room: float) -> list[str]:
    """Return labels of angles where there is room for them."""
    labeled: list[complex] = []
    texts = []
    for angle, point in zip(degrees.tolist(), force.tolist(), strict=True):
        free = all(abs(point - other) > room for other in labeled)
        if free:
            labeled.append(point)
        # Adding zero turns -0 into 0.
        texts.append(f"{round(angle) + 0:g}°" if free else "")
    return texts


def _side(point: complex, middle: complex) -> str:
    """Say on which side of a point its label stands: away from the middle."""
    away = point - middle
    if abs(away.imag) > abs(away.real):
        return "middle right" if away.imag > 0.0 else "middle left"
    return "top center" if away.real > 0.0 else "bottom center"


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
