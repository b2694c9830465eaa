"""Amplitudes over speed: every order for itself, all together, limits and barred ranges."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crankfem.pictures.interactive.style import Figure, Part, axis, band, layout, line, look
from crankfem.pictures.interactive.thinning import seen_points
from crankfem.vibration.motion import MOTION
from dynamics.assessment.limits import VibrationLimit
from dynamics.response.series import OrderSeries
from geometry.diagram_style import GRAY, RED, with_gaps
from geometry.units import RPM

Array = NDArray[np.float64]

# What the axis says, the unit, and its size in SI.
QUANTITIES = {one.quantity: ("amplitude", one.unit, one.size) for one in MOTION.values()} | {
    "stress": ("alternating stress", "MPa", 1e6)
}
SUM_COLOR, BARRED_COLOR = "#1c2733", "#f6dcd9"
# Orders that are drawn before anybody asks for the others: those with the largest peaks.
MAIN_ORDERS = 5
# Height of a diagram with unbounded speeds in medians of the plain sum.
BESIDE_UNBOUNDED = 4.0
HEADROOM = 1.08
# Shares of the height that a thinned curve may miss, and of the width without a point to hover on.
UNSEEN, HOVER_STEP = 5e-4, 1.0 / 80.0
SPEED_TITLE = "crankshaft speed [1/min]"


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
    series = curve.series
    label, unit, size = QUANTITIES[curve.quantity]
    rpm = series.speeds * RPM
    by_order = with_gaps(series.amplitude[:, :, curve.place] / size)
    both = series.synthesis
    total = with_gaps(both.amplitude[:, curve.place] / size)
    plain = with_gaps(both.plain_sum[:, curve.place] / size)
    limits = _limits(curve.limit, series.speeds, size)
    top = HEADROOM * (_height(plain, [limit for _, limit, _ in limits]) or 1.0 / HEADROOM)
    told = f"%{{x:.5g}} 1/min<br>%{{y:.4g}} {unit}"

    def drawn(values: Array, name: str, color: str, **more: object) -> Part:
        kept = seen_points(rpm, values, UNSEEN * top, HOVER_STEP * float(np.ptp(rpm)))
        return line(rpm[kept], values[kept], name, color, f"{name}<br>{told}", **more)  # type: ignore[arg-type]

    traces = [
        drawn(total, "all orders (synthesis)", SUM_COLOR, width=2.4),
        drawn(plain, "plain sum", GRAY, dash="dot"),
    ]
    for name, limit, visible in limits:
        traces.append(drawn(limit, name, RED, dash="dash", visible=visible))
    main = _main_orders(by_order)
    # Those that are seen first have the colors first.
    ranks = np.empty(len(main), dtype=int)
    ranks[np.argsort(~main, kind="stable")] = np.arange(len(main))
    for number, order in enumerate(series.orders.tolist()):
        visible = True if main[number] else "legendonly"
        style = look(int(ranks[number]))
        traces.append(drawn(by_order[number], f"order {order:g}", visible=visible, **style))
    shapes = [
        band(low * RPM, high * RPM, BARRED_COLOR, **_once(count, "barred"))
        for count, (low, high) in enumerate(barred)
    ]
    shapes += [
        _upright(speed, **_once(count, "unbounded"))
        for count, speed in enumerate(rpm[both.unbounded].tolist())
    ]
    return traces, layout(
        axis(SPEED_TITLE, range=[float(rpm[0]), float(rpm[-1])]),
        axis(f"{label} [{unit}]", range=[0.0, top]),
        title=title,
        shapes=shapes,
    )


def _limits(
    limit: VibrationLimit | None, speeds: Array, size: float
) -> list[tuple[str, Array, bool | str]]:
    """Return name, values and visibility of the curves that a limit has."""
    if limit is None:
        return []
    found: list[tuple[str, Array, bool | str]] = [
        ("limit", with_gaps(limit.continuous.at(speeds) / size), True)
    ]
    if limit.passing is not None:
        passing = with_gaps(limit.passing.at(speeds) / size)
        if np.isfinite(passing).any():
            found.append(("limit while passing", passing, "legendonly"))
    return found


def _height(plain: Array, limits: Sequence[Array]) -> float:
    """Return the largest value that has to be seen."""
    finite = plain[np.isfinite(plain)]
    highest = float(np.max(finite, initial=0.0))
    if finite.size < plain.size:
        # Beside what has no bounds all else would be flat: let the curves leave at the top.
        highest = min(highest, BESIDE_UNBOUNDED * float(np.median(finite)) if finite.size else 0.0)
    return max([highest, *(float(np.nanmax(limit, initial=0.0)) for limit in limits[:1])])


def _main_orders(by_order: Array) -> NDArray[np.bool_]:
    """Tell which orders have the largest peaks."""
    peaks = np.max(np.where(np.isnan(by_order), 0.0, by_order), axis=1)
    found = np.zeros(len(peaks), dtype=bool)
    found[np.argsort(peaks)[::-1][:MAIN_ORDERS]] = True
    return found


def _once(count: int, name: str) -> Part:
    """Return what puts the first of several shapes into the legend, from where it switches all."""
    return {"name": name, "legendgroup": name, "showlegend": count == 0}


def _upright(speed: float, **more: object) -> Part:
    return {
        "type": "line",
        "xref": "x",
        "yref": "paper",
        "x0": speed,
        "x1": speed,
        "y0": 0,
        "y1": 1,
        "line": {"color": RED, "width": 1, "dash": "dot"},
    } | more
