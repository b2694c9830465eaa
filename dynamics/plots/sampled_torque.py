"""A torque over its cycle: the samples and the sum of their harmonics."""

from typing import Protocol

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.drawing.diagram_style import BLUE, GREEN, ORANGE
from crankbase.drawing.legends import legend_inside
from crankbase.library_types import Axes

POINTS = 721
ANGLE_LABEL, TORQUE_LABEL = "crank angle [deg]", "torque of one throw [N m]"


class Sum(Protocol):
    """A sum of harmonics; `dynamics.harmonics.Harmonics` is one."""

    @property
    def mean(self) -> float:
        """Mean value."""

    @property
    def strokes(self) -> int:
        """Strokes per cycle."""

    def at(self, crank_angle: FloatArray) -> FloatArray:
        """Return the sum at crank angles [rad]."""


def over_cycle(samples: FloatArray, found: Sum) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles and the sum of harmonics at them, and the angles of samples, all in degrees.

    Parameters
    ----------
    samples : ndarray of shape (m,)
        Even over one cycle from crank angle zero.
    found : Sum

    Returns
    -------
    degrees, sums : ndarray of shape (p,)
    sampled : ndarray of shape (m,)
    """
    cycle = np.pi * found.strokes
    angles = np.linspace(0.0, cycle, POINTS)
    sampled = np.arange(len(samples)) * cycle / len(samples)
    return np.rad2deg(angles), found.at(angles), np.rad2deg(sampled)


def draw_samples(axes: Axes, samples: FloatArray, found: Sum) -> None:
    """Draw samples of the torque of one throw, the sum of all harmonics, and the mean.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    samples : ndarray of shape (m,)
        Even over one cycle from crank angle zero [N m].
    found : Sum
    """
    degrees, sums, sampled = over_cycle(samples, found)
    axes.plot(degrees, sums, color=BLUE, label="sum of harmonics")
    axes.plot(sampled, samples, "o", color=ORANGE, markersize=3.5, label="table")
    axes.axhline(found.mean, color=GREEN, linestyle="--", linewidth=1.0, label="mean")
    axes.set_xlabel(ANGLE_LABEL)
    axes.set_ylabel(TORQUE_LABEL)
    legend_inside(axes)
