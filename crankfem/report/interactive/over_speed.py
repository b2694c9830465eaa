"""Amplitudes over speed: every order for itself, all together, limits and barred ranges."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crankfem.report.interactive.curves import figure_of
from crankfem.report.interactive.style import Figure
from dynamics.assessment.limits import VibrationLimit
from dynamics.plots.quantities import quantity_display
from dynamics.response.series import OrderSeries


@dataclass(frozen=True, eq=False)
class Curve:
    """What is drawn over speed.

    Attributes
    ----------
    series : OrderSeries
    place : int
        Which of its places, from 0.
    quantity : {"twist", "displacement", "stress"}
        What its values are.
    limit : VibrationLimit or None
    """

    series: OrderSeries
    place: int
    quantity: Literal["twist", "displacement", "stress"]
    limit: VibrationLimit | None


def amplitudes_over_speed(
    curve: Curve, barred: Sequence[tuple[float, float]], title: str
) -> Figure:
    """Draw one place's orders, synthesis and plain sum over speed, with the limit.

    Parameters
    ----------
    curve : Curve
    barred : sequence of pairs of floats
        Barred ranges [rad/s].
    title : str

    Returns
    -------
    traces : list of dict
        Synthesis, plain sum, limits, then the orders, all there; those with small peaks wait in the
        legend.
    layout : dict
    """
    series, limits, passing = curve.series, {}, {}
    if curve.limit is not None:
        limits["limit"] = curve.limit.continuous.at(series.speeds)
        if curve.limit.passing is not None:
            values = curve.limit.passing.at(series.speeds)
            if np.isfinite(values).any():
                passing["limit while passing"] = values
    described = series.over_speed(
        curve.place,
        quantity_display(curve.quantity, "SI"),
        limits=limits,
        passing=passing,
        barred=barred,
    )
    return figure_of(described, title)
