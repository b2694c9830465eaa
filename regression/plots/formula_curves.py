"""Published formulas: as bars beside finite elements, and over the angle between neighboring cranks."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.bars import PALE, draw_rows
from crankbase.drawing.diagram_style import BLUE, CURVES
from fem.plots.over_angle import LABELS, SHOWN, angle_axis, draw_supports

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Dashes by their names, as matplotlib draws them.
DASHES: dict[str, Any] = {
    "solid": "-",
    "dash": "--",
    "dashdot": "-.",
    "dot": (0, (1, 1.2)),
    "longdashdot": (0, (6, 2, 1, 2, 1, 2)),
}


def curve_line_style(number: int) -> dict[str, Any]:
    """Color and dashes of a curve."""
    color, dashes = CURVES[number % len(CURVES)]
    return {"color": color, "linestyle": DASHES[dashes]}


def draw_over_angle(
    axes: "Axes",
    gammas: Array,
    formulas: Mapping[str, Array],
    fe: Array | None = None,
    bounds: Mapping[str, float] | None = None,
) -> None:
    """Draw the published formulas, and finite elements if there are any, over the angle.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    gammas : (g,) array
        Angles between neighboring cranks [deg].
    formulas : mapping
        Formula name to (g,) values [m/N], nan where it does not apply.
    fe : (g,) array, optional
        In a helix of that angle [m/N].
    bounds : mapping of str to float, optional
        Finite elements under other supports, by their names [m/N].
    """
    for number, (name, values) in enumerate(formulas.items()):
        axes.plot(gammas, values * SHOWN, **curve_line_style(number), linewidth=1.5, label=name)
    if fe is not None:
        axes.plot(gammas, fe * SHOWN, color="black", linewidth=2.6, label="finite elements")
    draw_supports(axes, bounds or {})
    axes.set_ylim(bottom=0.0)
    angle_axis(axes)
    axes.set_ylabel(LABELS["axial_compliance"])
    axes.legend(
        frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2
    )


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
