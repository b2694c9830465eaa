"""Common behavior of all runs of a shaft over time."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray
from crankbase.library_types import Axes, Dataset
from dynamics.plots.coordinates import time_axis
from dynamics.plots.over_time import RunCurve, plot_run
from dynamics.transient.curve_selection import Moving, motion_grid, select_curve
from dynamics.transient.envelope import Envelope, envelope_over
from dynamics.transient.viscous import ViscousSystem


class ShaftRun:
    """A run: time, speed, angle, motions (m, n) and torques (m, e), and its plots."""

    time: FloatArray
    shaft_speed: FloatArray
    shaft_angle_deg: FloatArray
    motion: FloatArray
    torque: FloatArray
    system: ViscousSystem

    def envelope(self, turns: int | None = None) -> Envelope:
        """Return the amplitudes in windows of whole revolutions; by default as the run repeats.

        Raises
        ------
        InputError
            If the run is shorter than one window.
        """
        return self._envelope(self.motion, turns)

    def _envelope(self, motion: FloatArray, turns: int | None) -> Envelope:
        return envelope_over(
            self.time,
            self.shaft_speed,
            np.radians(self.shaft_angle_deg),
            motion,
            self.torque,
            self.turns if turns is None else turns,  # type: ignore[attr-defined]  # field or property
        )

    def plot(
        self,
        axes: Axes | None = None,
        place: int | str = 0,
        *,
        quantity: Moving = "torque",
        steady: tuple[ArrayLike, ArrayLike] | None = None,
        turns: int | None = None,
    ) -> Axes:
        """Draw the extremes of one element or node over the time, and its amplitude.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        place : int or str, optional
            Element, or node for "twist" and "displacement", by number from 0 or name.
        quantity : {"torque", "force", "twist", "displacement"}, optional
            Torque or force in the spring of an element, or twist or displacement of a node.
        steady : (speeds [rad/s], amplitudes), optional
            Amplitudes at constant speeds, ascending, drawn where the run passes these speeds.
        turns : int, optional
            Revolutions of the shaft for one amplitude; by default those after which the run repeats.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If it is not the run of a chain, an element, node or quantity is unknown, the run is shorter than
            one window of its envelope, or steady amplitudes do not fit their speeds.
        """
        picked = select_curve(self.system.chain, quantity, place, self.motion, self.torque)
        envelope = self.envelope(turns)
        both = envelope.torque if picked.of_element else envelope.motion
        curve = RunCurve(
            picked.values,
            envelope.time,
            picked.factor * both[:, picked.number],
            envelope.turns,
            picked.factor,
            picked.label,
            picked.name,
        )
        return plot_run(axes, self.time, self.shaft_speed, curve, steady)

    def _grid(self, quantity: Moving | None, **more: Any) -> Dataset:
        """Return the data common to all runs and `more`, over time, node and element."""
        return motion_grid(
            self.system.chain,
            {"time": time_axis(self.time)},
            self.motion,
            self.torque,
            quantity,
            "motion beside even turning",
            shaft_speed=(("time",), self.shaft_speed, "rad/s", "shaft speed"),
            shaft_angle=(("time",), self.shaft_angle_deg, "deg", "shaft angle"),
            **more,
        )
