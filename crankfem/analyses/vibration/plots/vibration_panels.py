"""Single panels of an engine's vibration, each drawn on the axes it is given."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from crankbase.checks.arrays import FloatArray
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
