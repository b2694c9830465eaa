"""Harmonics as bars, as curves over the crank angle, and as stars of all cylinders."""

import math
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from crankbase.array_checks import Array, ComplexArray
from crankbase.diagrams import (
    BLUE,
    COLORS,
    GRAY,
    GREEN,
    ORANGE,
    RED,
    legend_below,
    legend_inside,
    new_axes,
    write_title,
)
from crankbase.frames import Axes
from crankbase.quantity import percent
from dynamics.indices import grouped

ORDER_LABEL = "harmonic order [cycles per revolution]"
# Share of the distance of two orders that their bars take.
FILLED = 0.6
POINTS = 721
ANGLE_LABEL, TORQUE_LABEL = "crank angle [deg]", "torque of one throw [N m]"


def draw_harmonics(
    axes: Axes | None,
    orders: Array,
    amplitudes: Mapping[str, Array],
    label: str,
    *,
    title: str = "",
) -> Axes:
    """Draw amplitudes by order, side by side if there are several of each order.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    orders : ndarray of shape (K,)
        Ascending.
    amplitudes : mapping of str to ndarray of shape (K,)
        By name, in the unit of the axis.
    label : str
        Label of the vertical axis, with its unit.
    """
    axes = new_axes(axes)
    width = FILLED * float(orders[0] if len(orders) < 2 else np.min(np.diff(orders)))
    each = width / len(amplitudes)
    for place, (name, heights) in enumerate(amplitudes.items()):
        shift = (place - 0.5 * (len(amplitudes) - 1)) * each
        axes.bar(orders + shift, heights, width=each, color=COLORS[place % len(COLORS)], label=name)
    axes.set_xlabel(ORDER_LABEL)
    axes.set_ylabel(label)
    if title:
        write_title(axes, title)
    if len(amplitudes) > 1:
        legend_inside(axes)
    return axes


class _Sum(Protocol):
    """A sum of harmonics; `dynamics.harmonics.Harmonics` is one."""

    @property
    def mean(self) -> float: ...
    @property
    def strokes(self) -> int: ...
    def at(self, *, crank_angle_deg: Array) -> Array: ...


def over_cycle(samples: Array, harmonics: _Sum) -> tuple[Array, Array, Array]:
    """Return angles and the sum of harmonics at them, and the angles of samples, all in degrees.

    Parameters
    ----------
    samples : ndarray of shape (m,)
        Even over one cycle from crank angle zero.

    Returns
    -------
    degrees, sums : ndarray of shape (p,)
    sampled : ndarray of shape (m,)
    """
    cycle = 180.0 * harmonics.strokes
    degrees = np.linspace(0.0, cycle, POINTS)
    return (
        degrees,
        harmonics.at(crank_angle_deg=degrees),
        np.arange(len(samples)) * cycle / len(samples),
    )


def draw_samples(
    axes: Axes | None,
    samples: Array,
    harmonics: _Sum,
    *,
    summed: str = "sum of harmonics",
    title: str = "",
) -> Axes:
    """Draw samples of the torque of one throw, the sum of harmonics, and the mean.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    samples : ndarray of shape (m,)
        Even over one cycle from crank angle zero [N m].
    summed : str, optional
        Words for the sum.
    """
    axes = new_axes(axes)
    degrees, sums, sampled = over_cycle(samples, harmonics)
    axes.plot(degrees, sums, color=BLUE, label=summed)
    axes.plot(sampled, samples, "o", color=ORANGE, markersize=3.5, label="table")
    axes.axhline(harmonics.mean, color=GREEN, linestyle="--", linewidth=1.0, label="mean")
    axes.set_xlabel(ANGLE_LABEL)
    axes.set_ylabel(TORQUE_LABEL)
    legend_inside(axes)
    if title:
        write_title(axes, title)
    return axes


# Of major and minor orders, in Campbell diagrams too.
KIND_COLORS = {"major": RED, "minor": ORANGE, "balanced": GRAY}
# The distance of two stars' centers in lengths of one vector.
STAR_STEP = 3.4
# Where numbers of cylinders stand, in lengths of a vector, and from which sine on to its side.
LABEL_START, SIDEWAYS = 1.2, 0.5
# Of the sum of a minor order's vectors.
SUM = "#1c2733"


class _Vectors(Protocol):
    """Vectors of one order; `dynamics.torque.Star` is an example."""

    @property
    def directions_deg(self) -> Array: ...
    @property
    def weights(self) -> Array: ...
    @property
    def vectors(self) -> ComplexArray: ...
    @property
    def largest(self) -> float: ...
    @property
    def share(self) -> float: ...
    @property
    def kind(self) -> str:
        """Return "major", "minor" or "balanced"."""


def draw_star(
    axes: Axes, star: _Vectors, words: str, center: tuple[float, float] = (0.0, 0.0)
) -> None:
    """Draw one star; firing at shaft angle zero points up, angles turn clockwise.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        In lengths of the longest vector.
    words : str
        Above it, such as "order 3".
    center : tuple of two floats, optional
    """
    x, y = center
    longest = float(np.max(np.abs(star.weights)))
    axes.plot(
        x + np.cos(np.linspace(0.0, 2.0 * np.pi, 73)),
        y + np.sin(np.linspace(0.0, 2.0 * np.pi, 73)),
        color="#d5dae0",
        linewidth=0.8,
    )
    color = KIND_COLORS[star.kind]
    # Cylinders by direction as drawn: negative lengths point backwards.
    turned = np.where(star.weights < 0.0, -1.0, 1.0)
    units = turned * np.exp(1j * np.radians(star.directions_deg))
    alike = grouped(range(units.size), lambda group, tip: abs(units[group[0]] - units[tip]) < 1e-6)
    for tips in alike:
        ends = star.vectors[tips] / longest
        for length in np.unique(np.round(np.abs(ends), 9)).tolist():
            _arrow(axes, center, length * _unit(complex(ends[0])), color, 1.6)
        away = _unit(complex(ends[0]))
        label = ", ".join(str(tip + 1) for tip in tips)
        at = LABEL_START * away
        side = "left" if away.imag > SIDEWAYS else "right" if away.imag < -SIDEWAYS else "center"
        # Set to a side, the label begins at the vector's end.
        shift = 0.0 if side == "center" else 0.1 * away.imag
        axes.text(x + at.imag - shift, y + at.real, label, fontsize=8, ha=side, va="center")
    if star.kind == "minor":
        _arrow(axes, center, complex(star.vectors.sum()) / star.largest, SUM, 2.6)
    kind = star.kind if star.kind != "minor" else f"minor, {percent(star.share, 3)} %"
    axes.text(
        x, y + 0.5 * STAR_STEP + 0.02, f"{words}\n{kind}", fontsize=8, ha="center", va="center"
    )


def finish_stars(axes: Axes, rows: int = 1, columns: int = 1) -> None:
    """Arrange the stars in rows and columns, and hide the axes."""
    axes.set_aspect("equal")
    axes.set_axis_off()
    half = 0.5 * STAR_STEP
    axes.set_xlim(-half, STAR_STEP * columns - half)
    axes.set_ylim(-1.15 * STAR_STEP * (rows - 1) - half, half + 0.4)


def _unit(vector: complex) -> complex:
    return vector / abs(vector) if abs(vector) > 0.0 else 1.0 + 0.0j


def _arrow(
    axes: Axes, center: tuple[float, float], vector: complex, color: str, width: float
) -> None:
    x, y = center
    axes.annotate(
        "",
        xy=(x + vector.imag, y + vector.real),
        xytext=center,
        arrowprops={
            "arrowstyle": "-|>",
            "color": color,
            "linewidth": width,
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )


# A line style beside a color, for print without colors.
STYLES = ("-", "--", "-.", (0, (1, 1.2)), (0, (6, 2, 1, 2, 1, 2)), (0, (8, 3)))


class _Series(Protocol):
    """Harmonics; `dynamics.harmonics.Harmonics` is one."""

    @property
    def orders(self) -> Array: ...
    @property
    def amplitude(self) -> Array: ...
    @property
    def phase(self) -> Array: ...
    @property
    def strokes(self) -> int: ...
    def each_at(self, *, crank_angle_deg: Array) -> Array: ...


def harmonic_words(harmonics: _Series, place: int, unit: str) -> str:
    """State amplitude and phase of the harmonic at an index, such as "279.7 N m, 230.2 deg".

    Amplitudes have the decimals of the largest one.
    """
    whole = math.floor(math.log10(max(float(np.max(harmonics.amplitude)), 1e-300)))
    amplitude = f"{harmonics.amplitude[place]:.{min(max(3 - whole, 0), 12)}f}"
    return f"{amplitude} {unit}, {np.degrees(harmonics.phase[place]):.1f} deg"


def draw_single_harmonics(
    axes: Axes | None, harmonics: _Series, unit: str, samples: Array | None = None
) -> Axes:
    """Draw harmonics over the crank angle in one diagram, the largest if there are too many.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    unit : str
        Of the amplitudes.
    samples : ndarray of shape (m,), optional
        Even over one cycle from crank angle zero, drawn as dots.
    """
    axes = new_axes(axes)
    degrees = _cycle(harmonics)
    curves = harmonics.each_at(crank_angle_deg=degrees)
    strongest = np.sort(np.argsort(-harmonics.amplitude, kind="stable")[: len(COLORS)])
    if samples is not None:
        step = degrees[-1] / len(samples)
        axes.plot(step * np.arange(len(samples)), samples, ".", color="#b6bec7", label="table")
    for number, place in enumerate(strongest.tolist()):
        axes.plot(
            degrees,
            curves[place],
            color=COLORS[number],
            linestyle=STYLES[number],
            label=f"order {harmonics.orders[place]:g}: {harmonic_words(harmonics, place, unit)}",
        )
    _name_axes(axes, degrees, f"harmonics [{unit}]")
    legend_below(axes, 3)
    write_title(
        axes,
        "Single harmonics"
        if len(strongest) == len(harmonics.orders)
        else f"The {len(strongest)} strongest of {len(harmonics.orders)} harmonics",
    )
    return axes


def draw_one_harmonic(axes: Axes, harmonics: _Series, place: int, unit: str) -> None:
    """Draw the harmonic at an index with its amplitude as dashed lines, order and phase in the title."""
    degrees = _cycle(harmonics)
    angles = harmonics.orders[place] * np.radians(degrees) + harmonics.phase[place]
    axes.plot(degrees, harmonics.amplitude[place] * np.sin(angles), color=BLUE)
    for level in (-1.0, 1.0):
        axes.axhline(level * harmonics.amplitude[place], color=GRAY, linestyle="--", linewidth=0.8)
    _name_axes(axes, degrees, f"harmonic [{unit}]")
    axes.set_title(
        f"Order {harmonics.orders[place]:g}\n{harmonic_words(harmonics, place, unit)}", fontsize=9
    )


def _cycle(harmonics: _Series) -> Array:
    """Return crank angles over one cycle [deg]."""
    return np.linspace(0.0, 180.0 * harmonics.strokes, POINTS)


def _name_axes(axes: Axes, degrees: Array, label: str) -> None:
    axes.set_xlabel(ANGLE_LABEL)
    axes.set_ylabel(label)
    axes.set_xlim(0.0, degrees[-1])
    axes.set_xticks(np.linspace(0.0, degrees[-1], 5))
