"""Axial compliance over the angle between neighboring cranks: finite elements and formulas."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import CURVES
from crankfem.report.interactive.style import (
    QUIET_COLOR,
    Figure,
    axis,
    layout,
    level,
    line,
    literal,
)

Array = NDArray[np.float64]

NANO = 1e9
FE_COLOR = "#000000"
ANGLE_TITLE = "angle between neighboring cranks γ [deg]"


def formulas_over_angle(
    gammas: Array, fe: Array, formulas: Mapping[str, Array], bounds: Mapping[str, float]
) -> Figure:
    """Draw the published formulas and finite elements over the angle between neighboring cranks.

    Parameters
    ----------
    gammas : (g,) array
        [deg]
    fe : (g,) array
        FE compliance in a helix of that angle [m/N].
    formulas : mapping
        Formula name to (g,) values [m/N], nan where it does not apply.
    bounds : mapping
        Support to its FE value [m/N].

    Returns
    -------
    traces : list of dict
    layout : dict
    """
    told = "<br>γ = %{x:.4g} deg<br>%{y:.4g}·10<sup>-9</sup> m/N"
    traces = [
        line(
            gammas,
            NANO * fe,
            "finite elements",
            FE_COLOR,
            f"<b>finite elements</b>{told}",
            width=3.2,
        )
    ]
    for number, (name, values) in enumerate(formulas.items()):
        color, dash = CURVES[number % len(CURVES)]
        traces.append(
            line(gammas, NANO * values, name, color, literal(name) + told, width=2.0, dash=dash)
        )
    notes = [
        {
            "x": 0.0,
            "xref": "paper",
            "xanchor": "left",
            "y": NANO * value,
            "yanchor": "bottom",
            "text": f"FE {name}: {NANO * value:.4g}",
            "showarrow": False,
            "font": {"size": 11, "color": QUIET_COLOR},
        }
        for name, value in bounds.items()
    ]
    lines = [
        level(NANO * value, FE_COLOR) | {"line": {"color": FE_COLOR, "width": 1, "dash": "dot"}}
        for value in bounds.values()
    ]
    return traces, layout(
        axis(ANGLE_TITLE, range=[0, 180], dtick=30, tick0=0),
        axis("axial compliance e<sub>n</sub> [10<sup>-9</sup> m/N]", rangemode="tozero"),
        title="Axial compliance, finite elements and formulas",
        height=470,
        shapes=lines,
        annotations=notes,
    )
