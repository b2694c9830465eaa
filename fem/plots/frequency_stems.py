"""Natural frequencies by their number."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import COLORS
from crankbase.drawing.legends import write_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_frequencies(
    axes: "Axes", frequencies: NDArray[np.float64], kinds: Sequence[str], title: str
) -> None:
    """Draw a stem for each frequency, colored by its kind.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    frequencies : (n,) array
        [Hz]
    kinds : sequence of n str
        For the legend.
    title : str
    """
    numbers = np.arange(1, len(frequencies) + 1)
    for place, kind in enumerate(dict.fromkeys(kinds)):
        here = np.array([one == kind for one in kinds])
        color = COLORS[place % len(COLORS)]
        axes.vlines(numbers[here], 0.0, frequencies[here], color=color, linewidth=1.2)
        axes.plot(numbers[here], frequencies[here], "o", color=color, markersize=5, label=kind)
    if len(numbers) <= 20:
        axes.set_xticks(numbers)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("number")
    axes.set_ylabel("natural frequency [Hz]")
    write_title(axes, title)
    if len(numbers):
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
