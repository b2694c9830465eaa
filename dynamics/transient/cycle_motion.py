"""Common behavior of all motions that repeat with the cycle of a shaft."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import ComplexArray, FloatArray, finite_array
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes, Dataset
from crankbase.units.quantity import format_quantity
from dynamics.chains.chain import Chain
from dynamics.plots.angle_curves import draw_over_angle
from dynamics.plots.coordinates import angle_axis
from dynamics.transient.curve_selection import Moving, motion_grid, select_curve
from dynamics.transient.envelope import half_peak_to_peak

# Samples between samples among which extremes over a cycle are looked for.
FINER = 4


class CycleMotion:
    """A cycle: its revolutions, angles (m,), motions (m, n) and torques (m, e), and its plots."""

    turns: int
    shaft_angle_deg: FloatArray
    motion: FloatArray
    torque: FloatArray

    @property
    def amplitude(self) -> FloatArray:
        """Half of the range of each node [rad or m], (n,); inf if unbounded."""
        return self._half_way(self.motion)

    @property
    def torque_amplitude(self) -> FloatArray:
        """Half of the range of each element [N m or N], (e,)."""
        return self._half_way(self.torque)

    def phasors(self, orders: ArrayLike) -> ComplexArray:
        """Return X_k of the motion, mean + Re sum X_k exp(i k phi), shape (K, n).

        Raises
        ------
        InputError
            If an order does not repeat with the cycle, or the samples cannot show it.
        """
        return self._phasors(orders, self.motion)

    def torque_phasors(self, orders: ArrayLike) -> ComplexArray:
        """Return the phasors of the elements' torque by orders, shape (K, e) [N m or N]; as `phasors`."""
        return self._phasors(orders, self.torque)

    def plot(
        self, axes: Axes | None = None, place: int | str = 0, *, quantity: Moving = "torque"
    ) -> Axes:
        """Draw one element or node over the shaft angle of the cycle.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        place : int or str, optional
            Element, or node for "twist" and "displacement", by number from 0 or name.
        quantity : {"torque", "force", "twist", "displacement"}, optional
            Torque or force in the spring of an element, or twist or displacement of a node.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If it is not the motion of a chain, an element, node or quantity is unknown, or it is unbounded.
        """
        chain, speed = self._chain_and_speed()
        shown = format_quantity(speed, "rad/s", 5)
        if np.any(np.isinf(self.amplitude)):
            raise InputError(
                f"speed: given {shown}; allowed are speeds with a steady vibration, because this one "
                "grows without bounds."
            )
        picked = select_curve(chain, quantity, place, self.motion, self.torque)
        axes = new_axes(axes)
        draw_over_angle(
            axes, np.radians(self.shaft_angle_deg), {picked.name: picked.values}, picked.label
        )
        write_title(axes, f"{picked.name}, {shown}")
        return axes

    def _chain_and_speed(self) -> tuple[Chain | None, float]:
        """Return the vibrating system, and the mean speed of the shaft [rad/s]."""
        raise NotImplementedError

    def _grid(self, quantity: Moving | None, **more: Any) -> Dataset:
        """Return the data common to all cycles and `more`, over shaft angle, node and element."""
        chain, _ = self._chain_and_speed()
        axis = {"shaft_angle": angle_axis(self.shaft_angle_deg)}
        return motion_grid(chain, axis, self.motion, self.torque, quantity, **more)

    def _half_way(self, values: FloatArray) -> FloatArray:
        count = len(values)
        spectrum = np.fft.rfft(values, axis=0)
        finer = np.fft.irfft(spectrum, FINER * count, axis=0) * FINER
        # One more sample on each side, so that the extremes have neighbors.
        return half_peak_to_peak(np.vstack((finer[-1:], finer, finer[:1])))

    def _phasors(self, orders: ArrayLike, values: FloatArray) -> ComplexArray:
        given = np.atleast_1d(finite_array("orders", orders))
        cycles = given * self.turns
        whole = np.round(cycles)
        count = self.shaft_angle_deg.size
        if np.any((np.abs(cycles - whole) > 1e-9 * whole) | (whole < 1) | (2.0 * whole >= count)):
            raise InputError(
                f"orders: given {given.tolist()}; allowed are multiples of {1.0 / self.turns:g} above zero "
                f"and below {0.5 * count / self.turns:g}, because the cycle has {self.turns} turns and "
                f"{count} samples."
            )
        waves = np.exp(-1j * np.outer(given, np.radians(self.shaft_angle_deg)))
        return np.asarray(waves @ values * (2.0 / count))
