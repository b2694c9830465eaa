"""The Campbell diagram of any chain, as a file."""

from collections.abc import Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from crankbase.checks.arrays import finite_array
from crankbase.drawing.diagram_style import figure
from crankfem.analyses.titles import add_title
from dynamics.plots.campbell import Meeting, draw_campbell


def plot_response_campbell(
    path: Path,
    frequencies: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    found: Sequence[Meeting],
    *,
    title: str = "",
) -> None:
    """Plot natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    path : Path
        SVG file.
    frequencies : array_like of shape (n,)
        Natural frequencies of elastic modes [Hz]; those above the range of the orders are left out.
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s].
    found : sequence of Meeting
        For example `Resonance`; dots grow with their severity.
    title : str, optional

    Raises
    ------
    InputError
        If the path is not an SVG file in an existing folder.
    """
    natural, lines = finite_array("frequencies", frequencies), finite_array("orders", orders)
    with figure(path, height=4.8) as axes:
        draw_campbell(axes, natural, lines, speed_range, found)
        add_title(axes, title)
