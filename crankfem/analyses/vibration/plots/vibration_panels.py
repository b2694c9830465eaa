"""Single panels of an engine's vibration, each drawn on the axes it is given."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from crankbase.checks.arrays import FloatArray

from crankbase.drawing.diagram_style import BLUE
from crankbase.drawing.legends import legend_inside
from dynamics.plots.mode_shapes import draw_chain_shapes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_modes(
    axes: "Axes",
    frequencies: FloatArray,
    shapes: FloatArray,
    positions: Sequence[tuple[float, ...]],
    connections: Sequence[tuple[int, int]],
    names: Sequence[str],
    quantity: str,
) -> None:
    """Draw mode shapes of a chain over its nodes.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    frequencies : ndarray of shape (m,)
        Of the modes that are drawn [Hz].
    shapes : ndarray of shape (n, m)
    positions : sequence of m tuples of float
        Where each mode stands still.
    connections : sequence of pairs of int
        Nodes that an element joins.
    names : sequence of n str
        Of the nodes.
    quantity : str
        What the nodes do, such as "twist".
    """
    labels = [
        f"{frequency:.1f} Hz, {len(still)} node{'s' if len(still) != 1 else ''}"
        for frequency, still in zip(frequencies, positions, strict=True)
    ]
    draw_chain_shapes(
        axes,
        shapes,
        labels,
        positions,
        connections,
        [short_name(name) for name in names],
        quantity,
    )


def draw_bounds(axes: "Axes", lowest: FloatArray, nominal: FloatArray, highest: FloatArray) -> None:
    """Draw each elastic frequency with its bounds [Hz], as a share of the nominal one."""
    numbers = np.arange(1, len(nominal) + 1)
    low, high = (100.0 * (ends / nominal - 1.0) for ends in (lowest, highest))
    axes.vlines(numbers, low, high, color=BLUE, linewidth=2.0, label="bounds")
    for ends in (low, high):
        axes.plot(numbers, ends, "_", color=BLUE, markersize=12)
    axes.plot(numbers, np.zeros(len(numbers)), "o", color=BLUE, label="nominal")
    legend_inside(axes)
    for number, frequency in zip(numbers.tolist(), nominal.tolist(), strict=True):
        text = f"{frequency:.1f} Hz"
        axes.annotate(text, (number, 0.0), xytext=(5, 3), textcoords="offset points", fontsize=8)
    axes.set_xticks(numbers)
    axes.margins(x=0.12)
    axes.set_xlabel("elastic mode")
    axes.set_ylabel("natural frequency beside the nominal one [%]")


def short_name(name: str) -> str:
    """Shorten a node's name to what fits under an axis."""
    return (
        name.replace("cylinder ", "cyl. ")
        .replace("section ", "")
        .replace(", flywheel", "\nflywheel")
        .replace(", thrust bearing", "\nthrust")
        .replace("driven machine", "driven\nmachine")
        .replace("damper ring", "damper\nring")
    )


def free_end_title(engine: str, kind: str) -> str:
    """Say of what the free end's amplitudes are."""
    return f"{engine}, {kind} vibration of the free end"


def stress_title(engine: str) -> str:
    """Say of what stresses over the speed are."""
    return f"{engine}, nominal torsional stress"
