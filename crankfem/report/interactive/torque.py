"""Torque of one throw over its cycle, and the amplitudes of its harmonics."""

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import BLUE, GREEN, ORANGE
from crankfem.report.interactive.curve_decimation import visible_points
from crankfem.report.interactive.curves import UNSEEN
from crankfem.report.interactive.rounding import rounded
from crankfem.report.interactive.style import Figure, axis, dots, layout, line, number
from dynamics.harmonics import Harmonics
from dynamics.plots.harmonic_bars import (
    ANGLE_LABEL,
    ORDER_LABEL,
    TORQUE_LABEL,
    bar_width,
    over_cycle,
)

Array = NDArray[np.float64]

# The longest way without a point [deg].
HOVER_STEP = 6.0


def torque_and_harmonics(samples: Array, found: Harmonics) -> Figure:
    """Draw torque samples with the sum of all harmonics above, and the amplitudes by order below."""
    degrees, sums, own = over_cycle(samples, found)
    kept = visible_points(degrees, sums, UNSEEN * float(np.ptp(sums)), HOVER_STEP)
    told = "<br>crank angle %{x:.4g} deg<br>%{y:.4g} N m"
    bars = {
        "type": "bar",
        "x": rounded(found.orders),
        "y": rounded(found.amplitude),
        "width": bar_width(found.orders),
        "name": "amplitude of an order",
        "marker": {"color": BLUE},
        "customdata": rounded(np.rad2deg(found.phase)),
        "hovertemplate": (
            "<b>order %{x:g}</b><br>amplitude %{y:.4g} N m<br>phase %{customdata:.4g} deg<extra></extra>"
        ),
        "xaxis": "x2",
        "yaxis": "y2",
        "showlegend": False,
    }
    traces = [
        line(degrees[kept], sums[kept], "sum of harmonics", BLUE, f"sum of harmonics{told}"),
        dots(own, samples, "table", ORANGE, f"table{told}", size=6),
        line(
            np.linspace(0.0, degrees[-1], 25),
            np.full(25, found.mean),
            f"mean {number(found.mean)} N m",
            GREEN,
            f"mean {number(found.mean)} N m",
            dash="dash",
        ),
        bars,
    ]
    made = layout(
        axis(ANGLE_LABEL, range=[0.0, float(degrees[-1])], dtick=90, tick0=0, anchor="y"),
        axis(TORQUE_LABEL, domain=[0.58, 1.0]),
        title="Torque of one throw and its harmonics",
        height=620,
    )
    lower = {
        "xaxis2": axis(ORDER_LABEL, anchor="y2"),
        "yaxis2": axis("amplitude M<sub>k</sub> [N m]", domain=[0.0, 0.4], anchor="x2"),
    }
    return traces, made | lower
