"""Stress concentration at the fillets of a throw, as bars."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.bars import draw_groups
from crankbase.drawing.legends import write_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Criterion = Literal["principal", "von Mises"]
LABELS: Mapping[Criterion, str] = {
    "principal": "largest principal / nominal stress [1]",
    "von Mises": "von Mises / nominal stress [1]",
}


def draw_factors(
    axes: "Axes",
    fillets: Sequence[str],
    factors: Mapping[str, NDArray[np.float64]],
    criterion: Criterion,
) -> None:
    """Draw stress concentration factors, a group of bars for each fillet.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    fillets : sequence of n str
    factors : mapping of str to (n,) array
        By load.
    criterion : {"principal", "von Mises"}
    """
    draw_groups(axes, fillets, factors, LABELS[criterion])
    write_title(axes, "Stress concentration at the fillets")
