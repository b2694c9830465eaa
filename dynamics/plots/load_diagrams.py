"""Load diagrams of a bearing, and hodographs of rotating vectors."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, ComplexArray, positive_number
from crankbase.choices import check_choice, number_within
from crankbase.diagrams import (
    BLUE,
    COLORS,
    GRAY,
    ORANGE,
    Diagram,
    Dots,
    Limits,
    Line,
    Note,
    Series,
    Shape,
    curve_diagram,
    draw_diagram,
    legend_below,
    legend_inside,
    new_axes,
    write_title,
)
from crankbase.frames import Axes
from crankbase.quantity import format_number
from dynamics.plots.curves import KILO

DASHES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1.2)), (0, (6, 2, 1, 2, 1, 2)))
AXIS_LINE: Any = (0, (8, 3, 1, 3))
FORCE_LABELS = ("force to the right, $-F_x$ [kN]", "force upwards, $F_y$ [kN]")
MOMENT_LABELS = ("moment about $-x$ [kN m]", "moment about $y$ [kN m]")
ROOM_AROUND = 1.12
POINTS = 361
# Names up to so many letters stand three in a row under the axes.
SHORT = 14


class _Curve(Protocol):
    """A closed curve; `dynamics.balance.Hodograph` is one."""

    @property
    def major(self) -> float: ...
    def points(self, count: int = 181) -> tuple[Array, Array]: ...


def draw_hodographs(
    axes: Axes | None,
    curves: Mapping[str, _Curve],
    labels: tuple[str, str],
    *,
    title: str = "",
    banks: Iterable[float] = (),
    empty: str = "balanced",
) -> Axes:
    """Draw hodographs, y up and x to the left, as seen from the free end: the shaft turns clockwise.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    curves : mapping of str to Curve
        By name [N or N m]; none leaves the axes empty, with `empty` in the middle.
    labels : tuple of two str
        Of the axes across and up.
    banks : iterable of float, optional
        Angles of the cylinders' axes, drawn as thin lines [rad].

    Notes
    -----
    A dot marks each vector at shaft angle zero, an arrowhead the direction of motion.
    """
    axes = new_axes(axes, width=4.6, height=5.6)
    reach = ROOM_AROUND * KILO * max((curve.major for curve in curves.values()), default=0.0) or 1.0
    if curves:
        for angle in sorted(set(banks)):
            across, up = math.sin(angle), math.cos(angle)
            ends = np.array([-1.0, 1.0]) * reach / max(abs(across), abs(up))
            axes.plot(ends * across, ends * up, color=GRAY, linewidth=0.7, linestyle=AXIS_LINE)
    for number, (name, curve) in enumerate(curves.items()):
        color = COLORS[number % len(COLORS)]
        left, upwards = (KILO * part for part in curve.points(POINTS))
        rightwards = -left
        axes.plot(
            rightwards, upwards, color=color, linestyle=DASHES[number % len(DASHES)], label=name
        )
        axes.plot(rightwards[0], upwards[0], "o", color=color, markersize=4)
        # An arrowhead an eighth of the way along the curve, unless it is a point.
        place = POINTS // 8
        tail, head = ((rightwards[at], upwards[at]) for at in (place, place + 3))
        if math.dist(tail, head) > 0.0:
            arrow = {"arrowstyle": "-|>", "color": color, "mutation_scale": 11}
            axes.annotate("", head, tail, arrowprops=arrow)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    if title:
        write_title(axes, title)
    if curves:
        short = max(len(name) for name in curves) <= SHORT
        legend_below(axes, min(len(curves), 3 if short else 2))
    else:
        axes.text(0.5, 0.5, empty, transform=axes.transAxes, ha="center", va="center")
        axes.set_xticks([])
        axes.set_yticks([])
    return axes


# Half width and half height of an angle's label as shares of the diagram's width, on a small screen.
LABEL_HALF = (0.042, 0.024)
# Where a label may stand: in these directions, so many of its own sizes away.
DIRECTIONS, STEPS = 16, (1.15, 1.6, 2.1)
# The outline of the journal is a symbol, its radius this share of the diagram's width.
OUTLINE = 0.045
MARGIN = 0.08

Frame = Literal["crank", "engine"]
# Labels of the axes, and what is drawn to the right and up.
AXIS_LABELS: dict[Frame, tuple[str, str, str, str]] = {
    "crank": (
        "tangential force T [kN] (with the rotation: right)",
        "outward force -Z [kN] (towards the shaft: down)",
        "T",
        "-Z",
    ),
    "engine": ("force across, -x [kN] (seen from the free end)", "force up, y [kN]", "-x", "y"),
}
# A point of a curve for every so many degrees of shaft angle.
POINT_STEP = 1.0


class _Load(Protocol):
    """The force on a bearing; `dynamics.engine.forces.LoadDiagram` is one."""

    @property
    def angles_deg(self) -> Array: ...
    @property
    def force(self) -> ComplexArray: ...
    @property
    def in_crank_frame(self) -> ComplexArray: ...
    @property
    def magnitude(self) -> Array: ...
    @property
    def mean(self) -> float: ...
    @property
    def maximum(self) -> float: ...
    @property
    def maximum_angle_deg(self) -> float: ...


def check_polar(frame: str, mark_step_deg: float) -> None:
    """Check the choices of a polar diagram."""
    check_choice("frame", frame, ("crank", "engine"), "a load is drawn in one of them")
    step = positive_number("mark_step_deg", mark_step_deg, "deg", "marks follow each other")
    number_within("mark_step_deg", step, 0.0, 360.0, "deg", "marks follow each other")


def draw_polar_loads(
    axes: Axes, loads: Sequence[tuple[str, _Load]], frame: Frame, mark_step_deg: float
) -> None:
    """Draw what `polar_loads` describes; several loads have a legend."""
    draw_diagram(axes, polar_loads(loads, frame, mark_step_deg))
    if len(loads) > 1:
        legend_inside(axes)


def polar_loads(
    loads: Sequence[tuple[str, _Load]], frame: Frame, mark_step_deg: float = 30.0
) -> Diagram:
    """Describe the locus of a bearing's force vector, one curve for each load.

    Parameters
    ----------
    loads : sequence of tuples of str and Load
        Each with its name for the legend, one or more.
    frame : {"crank", "engine"}
        "crank": turning with the crank, which is upright, tangential force to the right, radial
        force (towards the shaft) down. "engine": fixed, y up, seen from the free end, where the
        shaft turns clockwise and x points to the left.
    mark_step_deg : float
        Interval of the dots on the first curve in shaft angle [deg]; labeled with the angle where there
        is room.
    """
    curves = [on_paper(load, frame) for _, load in loads]
    low, high = square_round(curves)
    across, up, right, upwards = AXIS_LABELS[frame]
    hover = (
        "shaft angle %{customdata[0]:.4g} deg<br><b>%{customdata[1]:.4g} kN</b><br>"
        f"{right} %{{x:.4g}} kN, {upwards} %{{y:.4g}} kN"
    )
    lines = []
    for number, (curve, (name, load)) in enumerate(zip(curves, loads, strict=True)):
        degrees = load.angles_deg
        step = max(1, round(POINT_STEP / (degrees[1] - degrees[0])))
        closed = np.append(np.arange(0, len(degrees), step), 0)
        lines.append(
            Line(
                curve[closed].real,
                curve[closed].imag,
                name,
                COLORS[number % len(COLORS)],
                hover,
                1.3,
                # Dashes, where one curve lies on another.
                "dash" if number % 2 else "solid",
                numbers=_angles_and_sizes(degrees[closed], curve[closed]),
            )
        )
    degrees, curve, step = loads[0][1].angles_deg, curves[0], mark_step_deg
    marked = np.arange(np.ceil(degrees[0] / step - 1e-9) * step, degrees[-1] + 1e-6, step)
    # Between samples.
    points = np.interp(marked, degrees, curve.real) + 1j * np.interp(marked, degrees, curve.imag)
    numbers = _angles_and_sizes(marked, points)
    radius = OUTLINE * (high[0] - low[0])
    crank = Shape((-0.7 * radius, -3.2 * radius), (0.7 * radius, 0.0), "#f1f3f6")
    journal = Shape((-radius, -radius), (radius, radius), "#e3e7ec", round=True)
    return Diagram(
        Limits(across, (low[0], high[0])),
        Limits(up, (low[1], high[1])),
        lines,
        [Dots(points.real, points.imag, "", COLORS[0], hover=hover, numbers=numbers)],
        [
            # Adding zero turns -0 into 0.
            Note(f"{angle + 0.0:g}°", spot.real, spot.imag, "middle")
            for angle, spot in zip(
                marked.tolist(), label_spots(curve, points, high[0] - low[0]), strict=True
            )
            if spot is not None
        ],
        shapes=[crank, journal] if frame == "crank" else [journal],
        equal=True,
    )


def _angles_and_sizes(degrees: Array, force: NDArray[np.complex128]) -> list[list[float]]:
    """Return shaft angle [deg] and size of the force for hovering."""
    return [
        [round(angle, 2), float(f"{size:.5g}")]
        for angle, size in zip(degrees.tolist(), np.abs(force).tolist(), strict=True)
    ]


def developed_load(load: _Load) -> Diagram:
    """Describe the size of a bearing's force over the shaft angle, with its mean and maximum."""
    degrees, size = load.angles_deg, KILO * load.magnitude
    mean, most = KILO * load.mean, KILO * load.maximum
    return curve_diagram(
        np.append(degrees, 2.0 * degrees[-1] - degrees[-2]),
        (
            Series("force", np.append(size, size[0]), color=BLUE),
            Series(
                f"mean {format_number(mean, 3)} kN",
                np.full(len(degrees) + 1, mean),
                color=BLUE,
                dash="dash",
            ),
        ),
        "shaft angle [deg]",
        "force [kN]",
        x_step=90.0,
        dots=(
            Dots(
                np.array([load.maximum_angle_deg]),
                np.array([most]),
                f"maximum {format_number(most, 3)} kN",
                ORANGE,
            ),
        ),
    )


def on_paper(load: _Load, frame: Frame) -> NDArray[np.complex128]:
    """Return points in the picture, right + i up [kN]."""
    # Up are -Z, outwards along the crank, and y; to the right T, and -x as seen from the free end.
    force = load.in_crank_frame if frame == "crank" else load.force
    return np.asarray(KILO * (force.imag + 1j * force.real))


def square_round(
    curves: Sequence[NDArray[np.complex128]],
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the lower left and upper right corner of a square that holds curves and origin."""
    points = np.concatenate([*curves, [0j]])
    left, right = float(points.real.min()), float(points.real.max())
    bottom, top = float(points.imag.min()), float(points.imag.max())
    half = (0.5 + MARGIN) * max(right - left, top - bottom)
    middle = (0.5 * (left + right), 0.5 * (bottom + top))
    return (middle[0] - half, middle[1] - half), (middle[0] + half, middle[1] + half)


def label_spots(
    curve: NDArray[np.complex128], points: NDArray[np.complex128], width: float
) -> list[complex | None]:
    """Return positions of labels of points on a closed curve: next to it, without overlap.

    Parameters
    ----------
    curve : ndarray of shape (m,), complex
        Right + i up, within a square.
    points : ndarray of shape (n,), complex
        Each label is placed as far as possible from the curve's middle.
    width : float
        Of the square.

    Returns
    -------
    list of n complex or None
        Middles of the labels; None where there is no room.
    """
    half = np.array(LABEL_HALF) * width
    along = np.append(curve, curve[:1])
    parts = np.ceil(np.abs(np.diff(along)) / half[1]).astype(int) + 1
    dense = np.concatenate(
        [
            start + (end - start) * np.arange(count) / count
            for start, end, count in zip(along[:-1], along[1:], parts.tolist(), strict=True)
        ]
    )
    low, high = square_round([curve])
    turns = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    labels: list[complex | None] = []
    placed: list[complex] = []

    def apart(spot: complex, others: NDArray[np.complex128], size: float) -> bool:
        gap = others - spot
        inside = (np.abs(gap.real) < size * half[0]) & (np.abs(gap.imag) < size * half[1])
        return not np.any(inside)

    for point in points.tolist():
        outward = np.angle(point - curve.mean())
        spots = [
            complex(
                point.real + size * half[0] * np.cos(outward + turn),
                point.imag + size * half[1] * np.sin(outward + turn),
            )
            for size in STEPS
            for turn in sorted(turns, key=lambda angle: min(angle, 2.0 * np.pi - angle))
        ]
        chosen = next(
            (
                spot
                for spot in spots
                if low[0] + half[0] < spot.real < high[0] - half[0]
                and low[1] + half[1] < spot.imag < high[1] - half[1]
                and apart(spot, dense, 1.0)
                and apart(spot, np.array(placed, dtype=complex), 2.0)
            ),
            None,
        )
        labels.append(chosen)
        if chosen is not None:
            placed.append(chosen)
    return labels
