"""Diagram of the published formulas over the angle between neighboring cranks."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import figure
from regression.plots.formula_curves import draw_over_angle

Array = NDArray[np.float64]


def plot_formulas(
    path: Path,
    gammas: Array,
    fe: Array,
    formulas: Mapping[str, Array],
    bounds: Mapping[str, float],
) -> None:
    """Plot the published formulas and FE over the angle between neighboring cranks.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    gammas : (g,) array
        Angles between neighboring cranks [deg].
    fe : (g,) array
        FE compliance in a helix of that angle [m/N].
    formulas : mapping
        Formula name to (g,) values [m/N], nan where it does not apply.
    bounds : mapping
        Support to its FE value [m/N].
    """
    with figure(path) as axes:
        draw_over_angle(axes, gammas, formulas, fe, bounds)
