"""The diagrams of a report, each from plain numbers to one SVG file."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dynamics.harmonics import Harmonics
from geometry.diagram_style import BLUE, GREEN, ORANGE, figure

Array = NDArray[np.float64]
SHAPES_SHOWN = 3


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
