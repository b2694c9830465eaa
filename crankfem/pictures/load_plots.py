"""Load diagrams of crankpins and main bearings: the polar and the developed one."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dynamics.engine.loads import LoadDiagram
from geometry.diagram_style import COLORS, GRAY, figure
from geometry.errors import InputError

KILO = 1e-3
# Labels of angles keep this share of the diagram's width from each other.
LABEL_ROOM = 0.075
# The outline of the journal is a symbol, its radius this share of the diagram's width.
OUTLINE = 0.045
MARGIN = 0.08

Frame = Literal["crank", "engine"]


def plot_polar_loads(
    path: Path,
    diagrams: Sequence[LoadDiagram],
    *,
    labels: Sequence[str] | None = None,
    frame: Frame = "crank",
    mark_step_deg: float = 30.0,
    title: str = "",
) -> None:
    """Plot the locus of a bearing's force vector, one curve for each diagram, as SVG.

    Parameters
    ----------
    path : Path
    diagrams : sequence of LoadDiagram
        Of one bearing with several models or at several operating points, to compare.
    labels : sequence of str, optional
        For the legend; the diagrams' names otherwise.
    frame : str, optional
        "crank": turning with the crank, which stands upright, tangential force to the right, radial
        force (towards the shaft) down. "engine": at rest, y up, seen from the free end, where the
        shaft turns clockwise and x points to the left.
    mark_step_deg : float, optional
        A dot on the first curve at every such step of shaft angle [deg], with its angle where there
        is room.
    title : str, optional

    Raises
    ------
    InputError
        If there is no diagram, or labels, frame or step do not fit.
    """
    names = _names(diagrams, labels)
    if frame not in ("crank", "engine"):
        raise InputError(
            f"frame: given {frame!r}; allowed are crank, engine, because a load is drawn in one of them."
        )
    if not 0.0 < mark_step_deg <= 360.0:
        raise InputError(
            f"mark_step_deg: given {mark_step_deg:g} deg; allowed is above 0 and up to 360 deg, because "
            "marks follow each other along the curve."
        )
    curves = [_drawn(diagram, frame) for diagram in diagrams]
    low, high = _square_round(curves)
    with figure(path, width=6.4, height=6.4) as axes:
        axes.set_aspect("equal")
        _outline(axes, frame, OUTLINE * (high[0] - low[0]))
        for number, (curve, name) in enumerate(zip(curves, names, strict=True)):
            color = COLORS[number % len(COLORS)]
            closed = np.append(curve, curve[:1])
            axes.plot(closed.real, closed.imag, color=color, linewidth=1.3, label=name)
        _marks(axes, diagrams[0], curves[0], mark_step_deg, LABEL_ROOM * (high[0] - low[0]))
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        _name_axes(axes, frame)
        if title:
            axes.set_title(title)
        if len(names) > 1:
            axes.legend(fontsize=8)


def plot_developed_loads(
    path: Path,
    diagrams: Sequence[LoadDiagram],
    *,
    labels: Sequence[str] | None = None,
    title: str = "",
) -> None:
    """Plot the size of a bearing's force over the shaft angle, with mean and maximum, as SVG.

    Parameters
    ----------
    path : Path
    diagrams : sequence of LoadDiagram
    labels : sequence of str, optional
        For the legend; the diagrams' names otherwise.
    title : str, optional

    Raises
    ------
    InputError
        If there is no diagram, or not one label for each.
    """
    names = _names(diagrams, labels)
    with figure(path) as axes:
        for number, (diagram, name) in enumerate(zip(diagrams, names, strict=True)):
            color = COLORS[number % len(COLORS)]
            degrees = np.degrees(diagram.angles)
            mean, most = KILO * diagram.mean, KILO * diagram.maximum
            axes.plot(
                np.append(degrees, 2.0 * degrees[-1] - degrees[-2]),
                KILO * np.append(diagram.magnitude, diagram.magnitude[0]),
                color=color,
                linewidth=1.3,
                label=f"{name}: mean {mean:.4g} kN, maximum {most:.4g} kN",
            )
            axes.axhline(mean, color=color, linewidth=0.9, linestyle="--")
            axes.plot(np.degrees(diagram.maximum_angle), most, "o", color=color, markersize=5)
        axes.set_ylim(bottom=0.0)
        span = np.degrees(diagrams[0].angles)
        axes.set_xticks(np.arange(np.ceil(span[0] / 90.0) * 90.0, span[-1] + 90.0, 90.0))
        axes.set_xlabel("shaft angle, deg")
        axes.set_ylabel("force, kN (dashed: mean)")
        if title:
            axes.set_title(title)
        # Below the axes: the curve fills them.
        axes.figure.legend(fontsize=8, loc="outside lower center")


def _names(diagrams: Sequence[LoadDiagram], labels: Sequence[str] | None) -> list[str]:
    if not diagrams:
        raise InputError(
            "diagrams: given none; allowed are one or more, because a picture shows something."
        )
    names = [diagram.name for diagram in diagrams] if labels is None else list(labels)
    if len(names) != len(diagrams):
        raise InputError(
            f"labels: given {len(names)} for {len(diagrams)} diagrams; allowed is one for each, because "
            "every curve has its name."
        )
    return names


def _drawn(diagram: LoadDiagram, frame: Frame) -> NDArray[np.complex128]:
    """Return places on paper, right + i up [kN]."""
    # Up are -Z, outwards along the crank, and y; to the right T, and -x as seen from the free end.
    force = diagram.in_crank_frame if frame == "crank" else diagram.force
    return np.asarray(KILO * (force.imag + 1j * force.real))


def _square_round(
    curves: Sequence[NDArray[np.complex128]],
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the lower left and upper right corner of a square that holds curves and origin."""
    points = np.concatenate([*curves, [0j]])
    left, right = float(points.real.min()), float(points.real.max())
    bottom, top = float(points.imag.min()), float(points.imag.max())
    half = (0.5 + MARGIN) * max(right - left, top - bottom)
    middle = (0.5 * (left + right), 0.5 * (bottom + top))
    return (middle[0] - half, middle[1] - half), (middle[0] + half, middle[1] + half)


def _outline(axes: Any, frame: Frame, radius: float) -> None:
    """Draw the journal round the origin, and the crank below it in its own frame."""
    from matplotlib.patches import Circle, Rectangle

    if frame == "crank":
        corner, width = (-0.7 * radius, -3.2 * radius), 1.4 * radius
        axes.add_patch(
            Rectangle(corner, width, 3.2 * radius, facecolor="#f1f3f6", edgecolor=GRAY, zorder=1.5)
        )
    axes.add_patch(Circle((0.0, 0.0), radius, facecolor="#e3e7ec", edgecolor=GRAY, zorder=1.6))
    axes.axhline(0.0, color=GRAY, linewidth=0.8)
    axes.axvline(0.0, color=GRAY, linewidth=0.8)


def _marks(
    axes: Any, diagram: LoadDiagram, curve: NDArray[np.complex128], step: float, room: float
) -> None:
    """Put dots at whole steps of shaft angle, between samples by interpolation."""
    degrees = np.degrees(diagram.angles)
    wanted = np.arange(np.ceil(degrees[0] / step - 1e-9) * step, degrees[-1] + 1e-6, step)
    points = np.interp(wanted, degrees, curve.real) + 1j * np.interp(wanted, degrees, curve.imag)
    axes.plot(points.real, points.imag, "o", color=COLORS[0], markersize=3.5)
    labeled: list[complex] = []
    middle = complex(curve.mean())
    for angle, point in zip(wanted.tolist(), points.tolist(), strict=True):
        if all(abs(point - other) > room for other in labeled):
            labeled.append(point)
            out = (point - middle) / max(abs(point - middle), 1e-12)
            axes.annotate(
                # Adding zero turns -0 into 0.
                f"{angle + 0.0:g}°",
                (point.real, point.imag),
                xytext=(11.0 * out.real, 9.0 * out.imag),
                textcoords="offset points",
                fontsize=8,
                ha="center",
                va="center",
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
            )


def _name_axes(axes: Any, frame: Frame) -> None:
    if frame == "crank":
        axes.set_xlabel("tangential force T, kN (with the rotation: right)")
        axes.set_ylabel("outward force -Z, kN (towards the shaft: down)")
    else:
        axes.set_xlabel("force across, -x, kN (seen from the free end)")
        axes.set_ylabel("force up, y, kN")
