"""Star diagrams: the harmonics of one order of all cylinders as arrows from one center."""

from typing import Protocol

import numpy as np

from crankbase.checks.arrays import ComplexArray, FloatArray
from crankbase.drawing.diagram_style import GRAY, ORANGE, RED
from crankbase.library_types import Axes
from dynamics.indices import grouped

# Of major and minor orders, in Campbell diagrams too.
KIND_COLORS = {"major": RED, "minor": ORANGE, "balanced": GRAY}
# The distance of two stars' centers in lengths of one vector.
STAR_STEP = 3.4
# Where numbers of cylinders stand, in lengths of a vector, and from which sine on to its side.
LABEL_START, SIDEWAYS = 1.2, 0.5
# Of the sum of a minor order's vectors.
SUM = "#1c2733"


class Vectors(Protocol):
    """Vectors of one order; `dynamics.torque.star.Star` is an example."""

    @property
    def directions_deg(self) -> FloatArray:
        """Of the cylinders' vectors [deg]."""

    @property
    def weights(self) -> FloatArray:
        """Their lengths."""

    @property
    def vectors(self) -> ComplexArray:
        """The vectors themselves."""

    @property
    def largest(self) -> float:
        """Their sum if all had one direction."""

    @property
    def share(self) -> float:
        """Their sum as a share of that."""

    @property
    def kind(self) -> str:
        """Return "major", "minor" or "balanced"."""


def draw_star(
    axes: Axes, star: Vectors, words: str, center: tuple[float, float] = (0.0, 0.0)
) -> None:
    """Draw one star; firing at shaft angle zero points up, angles turn clockwise.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        In lengths of the longest vector.
    star : Vectors
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
    for tips in _by_direction(star):
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
    said = star.kind if star.kind != "minor" else f"minor, {100.0 * star.share:.3g} %"
    axes.text(
        x, y + 0.5 * STAR_STEP + 0.02, f"{words}\n{said}", fontsize=8, ha="center", va="center"
    )


def finish_stars(axes: Axes, rows: int = 1, columns: int = 1) -> None:
    """Arrange the stars in rows and columns, and hide the axes."""
    axes.set_aspect("equal")
    axes.set_axis_off()
    half = 0.5 * STAR_STEP
    axes.set_xlim(-half, STAR_STEP * columns - half)
    axes.set_ylim(-1.15 * STAR_STEP * (rows - 1) - half, half + 0.4)


def _by_direction(star: Vectors) -> list[list[int]]:
    """Return the cylinders, from 0, grouped by direction as drawn: negative lengths point backwards."""
    turned = np.where(star.weights < 0.0, -1.0, 1.0)
    units = turned * np.exp(1j * np.radians(star.directions_deg))
    return grouped(range(units.size), lambda group, tip: abs(units[group[0]] - units[tip]) < 1e-6)


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
