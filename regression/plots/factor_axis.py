"""An axis for a study's factor, and the label of a response on the other."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import math_symbol
from crankbase.drawing.legends import display_unit
from regression.factor_labels import factor_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
POINTS = 80


def factor_size(unit: str, labels: Sequence[str]) -> float:
    """Size of the unit that a factor is shown in; of a choice 1."""
    return 1.0 if labels else display_unit(unit)[1]


def sweep(lowest: float, highest: float, labels: Sequence[str]) -> Array:
    """Values over a factor's range [SI]; of a choice its labels' numbers over and over."""
    if labels:
        return np.resize(np.arange(len(labels), dtype=np.float64), POINTS)
    return np.linspace(lowest, highest, POINTS)


def label_factor_axis(axes: "Axes", name: str, unit: str, labels: Sequence[str]) -> None:
    """Label the horizontal axis with a factor and its unit; for a choice with its labels."""
    if labels:
        axes.set_xticks(range(len(labels)), list(labels), fontsize=8)
        axes.set_xlim(-0.5, len(labels) - 0.5)
        axes.set_xlabel(factor_text(name))
        return
    shown = display_unit(unit)[0] if unit else ""
    axes.set_xlabel(f"{factor_text(name)} [{shown}]" if shown else factor_text(name))


def response_text(symbol: str, unit: str) -> str:
    """Write a response with the unit that it is shown in."""
    return f"{math_symbol(symbol)} [{display_unit(unit)[0]}]"
