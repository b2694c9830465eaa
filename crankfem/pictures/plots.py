"""The diagrams of a report, each from plain numbers to one SVG file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crankfem.pictures.style import BLUE, COLORS, GRAY, GREEN, ORANGE, RED, figure
from crankfem.record import RPM
from crankfem.vibration.modes import SourceResult, Vibration
from dynamics.harmonics import Harmonics

Array = NDArray[np.float64]
SHAPES_SHOWN = 3


def plot_mode_shapes(path: Path, result: SourceResult) -> None:
    """Plot the first elastic mode shapes of a chain over its nodes."""
    modes = result.modes
    places = np.arange(len(result.chain.nodes))
    with figure(path, height=3.4) as axes:
        axes.axhline(0.0, color=GRAY, linewidth=1.0)
        for shown, mode in enumerate(range(modes.rigid, len(modes.frequencies))):
            if shown == SHAPES_SHOWN:
                break
            nodes = len(modes.node_positions[mode])
            axes.plot(
                places,
                modes.shapes[:, mode],
                "o-",
                color=COLORS[shown],
                markersize=4,
                label=f"{modes.frequencies[mode]:.1f} Hz, {nodes} node{'s' if nodes != 1 else ''}",
            )
            axes.plot(
                modes.node_positions[mode], np.zeros(nodes), "x", color=COLORS[shown], markersize=7
            )
        axes.set_xticks(places, [_short(name) for name in result.chain.nodes], fontsize=8)
        axes.set_ylabel("relative " + ("displacement" if result.chain.kind == "axial" else "twist"))
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _short(name: str) -> str:
    return (
        name.replace("cylinder ", "cyl. ")
        .replace("section ", "")
        .replace(", flywheel", "\nflywheel")
        .replace(", thrust bearing", "\nthrust")
    )


def plot_campbell(
    path: Path, vibration: Vibration, orders: Sequence[float], speeds: tuple[float, float]
) -> None:
    """Plot natural frequencies and order lines over the running range, critical speeds marked.

    Parameters
    ----------
    path : Path
    vibration : Vibration
    orders : sequence of float
        Harmonic orders [cycles per revolution].
    speeds : (float, float)
        Running range [rad/s].
    """
    low, high = (speed * RPM for speed in speeds)
    span = high - low
    left, right = max(0.0, low - 0.1 * span), high + 0.1 * span
    top = 1.05 * max(orders) * right / 60.0
    with figure(path, height=4.6) as axes:
        axes.axvspan(low, high, color="#eef3f8", zorder=0)
        for order in orders:
            end = order * right / 60.0
            axes.plot(
                [left, right],
                [order * left / 60.0, end],
                color=GRAY,
                linewidth=0.9 if float(order).is_integer() else 0.4,
            )
            if float(order).is_integer():
                axes.annotate(
                    f"{order:g}",
                    (right, end),
                    xytext=(3, -3),
                    textcoords="offset points",
                    fontsize=7,
                )
        for shown, frequency in enumerate(vibration.chosen.elastic_frequencies):
            if frequency > top:
                continue
            axes.axhline(frequency, color=COLORS[shown % len(COLORS)], linewidth=1.8)
            axes.annotate(
                f"{frequency:.1f} Hz",
                (left, frequency),
                xytext=(3, 3),
                textcoords="offset points",
                fontsize=8,
                color=COLORS[shown % len(COLORS)],
            )
        for critical in vibration.criticals:
            axes.plot(
                critical.critical.speed_rpm,
                critical.critical.frequency,
                "o",
                color=RED,
                markersize=3.0 + 7.0 * critical.phase_sum,
                alpha=0.85,
            )
        axes.set_xlim(left, right)
        axes.set_ylim(0.0, top)
        axes.set_xlabel("crankshaft speed [1/min]")
        axes.set_ylabel("frequency [Hz]")
        axes.set_title(
            f"{vibration.kind}: running range shaded, order at the right end of its line; "
            "dots grow with the phase sum",
            fontsize=9,
        )


def plot_torque(path: Path, samples: Array, found: Harmonics) -> None:
    """Plot torque samples with the sum of all harmonics, and the amplitudes by order."""
    cycle = np.pi * found.strokes
    angles = np.linspace(0.0, cycle, 721)
    sample_angles = np.arange(len(samples)) * cycle / len(samples)
    with figure(path, 2, width=8.6, height=3.4) as (left, right):
        left.plot(np.rad2deg(angles), found.at(angles), color=BLUE, label="sum of harmonics")
        left.plot(
            np.rad2deg(sample_angles), samples, "o", color=ORANGE, markersize=3.5, label="table"
        )
        left.axhline(found.mean, color=GREEN, linestyle="--", linewidth=1.0, label="mean")
        left.set_xlabel("crank angle [deg]")
        left.set_ylabel("torque of one throw [N m]")
        left.legend(fontsize=8)
        right.bar(found.orders, found.amplitude, width=0.3 * found.orders[0] / 0.5, color=BLUE)
        right.set_xlabel("harmonic order [cycles per revolution]")
        right.set_ylabel(r"amplitude $M_k$ [N m]")
