"""The diagram of a torque table in a report."""

from pathlib import Path

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import figure
from dynamics.harmonics import Harmonics
from dynamics.plots.harmonic_bars import draw_harmonics, draw_samples


def plot_torque(path: Path, samples: FloatArray, found: Harmonics) -> None:
    """Plot torque samples with the sum of all harmonics, and the amplitudes by order."""
    with figure(path, 2, width=8.6, height=3.4) as (left, right):
        draw_samples(left, samples, found)
        draw_harmonics(
            right, found.orders, {"amplitude": found.amplitude}, r"amplitude $M_k$ [N m]"
        )
