"""Published formulas as bars, with finite elements as a line."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.bars import PALE, draw_rows
from crankbase.drawing.diagram_style import BLUE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


def draw_formula_bars(
    axes: "Axes",
    names: Sequence[str],
    values: Array,
    valid: Sequence[bool],
    label: str,
    beside: float | None,
) -> None:
    """Draw a bar for each formula, pale where it does not apply, and a line for finite elements.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    names : sequence of n str
    values : (n,) array
        In the unit of the axis.
    valid : sequence of n bool
    label : str
        Of the lying axis, with its unit.
    beside : float or None
        By finite elements, in the unit of the axis.
    """
    from matplotlib.patches import Patch

    draw_rows(axes, names, values, label, colors=[BLUE if one else PALE for one in valid])
    handles: list[Any] = [Patch(color=BLUE, label="applies to the throw")]
    if not all(valid):
        handles.append(Patch(color=PALE, label="does not apply"))
    if beside is not None:
        handles.append(axes.axvline(beside, color="black", linewidth=1.8, label="finite elements"))
    axes.legend(
        frameon=False, handles=handles, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0)
    )
