"""Single harmonics over the crank angle, each with its amplitude and phase."""

import math
from typing import Protocol

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import BLUE, COLORS, GRAY, new_axes
from crankbase.drawing.legends import legend_below, write_title
from crankbase.library_types import Axes
from dynamics.plots.harmonic_bars import ANGLE_LABEL, POINTS

# A line style beside a color, for print without colors.
STYLES = ("-", "--", "-.", (0, (1, 1.2)), (0, (6, 2, 1, 2, 1, 2)), (0, (8, 3)))


class Series(Protocol):
    """Harmonics; `dynamics.harmonics.Harmonics` is one."""

    @property
    def orders(self) -> FloatArray:
        """Ascending (K,)."""

    @property
    def amplitude(self) -> FloatArray:
        """M_k (K,)."""

    @property
    def phase(self) -> FloatArray:
        """a_k [rad] (K,)."""

    @property
    def strokes(self) -> int:
        """Strokes per cycle."""

    def each_at(self, *, crank_angle_deg: FloatArray) -> FloatArray:
        """Return each harmonic at crank angles [deg], (K, m)."""


def harmonic_words(found: Series, place: int, unit: str) -> str:
    """State amplitude and phase of the harmonic at an index, such as "279.7 N m, 230.2 deg".

    Amplitudes have the decimals of the largest one.
    """
    whole = math.floor(math.log10(max(float(np.max(found.amplitude)), 1e-300)))
    amplitude = f"{found.amplitude[place]:.{min(max(3 - whole, 0), 12)}f}"
    return f"{amplitude} {unit}, {np.degrees(found.phase[place]):.1f} deg"


def draw_single_harmonics(
    axes: Axes | None, found: Series, unit: str, samples: FloatArray | None = None
) -> Axes:
    """Draw harmonics over the crank angle in one diagram, the largest if there are too many.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        Those of a new figure if None.
    found : Series
    unit : str
        Of the amplitudes.
    samples : ndarray of shape (m,), optional
        Even over one cycle from crank angle zero, drawn as dots.

    Returns
    -------
    matplotlib.axes.Axes
    """
    axes = new_axes(axes)
    degrees = _cycle(found)
    curves = found.each_at(crank_angle_deg=degrees)
    strongest = np.sort(np.argsort(-found.amplitude, kind="stable")[: len(COLORS)])
    if samples is not None:
        step = degrees[-1] / len(samples)
        axes.plot(step * np.arange(len(samples)), samples, ".", color="#b6bec7", label="table")
    for number, place in enumerate(strongest.tolist()):
        axes.plot(
            degrees,
            curves[place],
            color=COLORS[number],
            linestyle=STYLES[number],
            label=f"order {found.orders[place]:g}: {harmonic_words(found, place, unit)}",
        )
    _name_axes(axes, degrees, f"harmonics [{unit}]")
    legend_below(axes, 3)
    write_title(
        axes,
        "Single harmonics"
        if len(strongest) == len(found.orders)
        else f"The {len(strongest)} strongest of {len(found.orders)} harmonics",
    )
    return axes


def draw_one_harmonic(axes: Axes, found: Series, place: int, unit: str) -> None:
    """Draw the harmonic at an index with its amplitude as dashed lines, order and phase in the title."""
    degrees = _cycle(found)
    angles = found.orders[place] * np.radians(degrees) + found.phase[place]
    axes.plot(degrees, found.amplitude[place] * np.sin(angles), color=BLUE)
    for level in (-1.0, 1.0):
        axes.axhline(level * found.amplitude[place], color=GRAY, linestyle="--", linewidth=0.8)
    _name_axes(axes, degrees, f"harmonic [{unit}]")
    axes.set_title(
        f"Order {found.orders[place]:g}\n{harmonic_words(found, place, unit)}", fontsize=9
    )


def _cycle(found: Series) -> FloatArray:
    """Return crank angles over one cycle [deg]."""
    return np.linspace(0.0, 180.0 * found.strokes, POINTS)


def _name_axes(axes: Axes, degrees: FloatArray, label: str) -> None:
    axes.set_xlabel(ANGLE_LABEL)
    axes.set_ylabel(label)
    axes.set_xlim(0.0, degrees[-1])
    axes.set_xticks(np.linspace(0.0, degrees[-1], 5))
