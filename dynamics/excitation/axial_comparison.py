"""Axial forces of throws by their own c, compared with those by all pin forces of the shaft."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import ComplexArray, FloatArray, finite_array
from crankbase.checks.scalars import whole_number, whole_within
from crankbase.drawing.diagram_style import COLORS, new_axes
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes
from crankbase.summaries import summarized
from crankbase.units.units import RPM
from dynamics.excitation.chain_excitation import axial_throw_forces
from dynamics.excitation.cylinders import CylinderForces
from dynamics.plots.curves import main_orders_of, set_speed_axis
from dynamics.plots.quantities import KILO
from dynamics.response.order_excitation import checked_speed_index


@summarized("orders", "speeds [rad/s]", "alone [N]", "in_shaft [N]")
@dataclass(frozen=True, eq=False)
class AxialForceComparison:
    """Axial force of each throw by order and speed, by two methods.

    Parameters
    ----------
    orders : ndarray of shape (K,)
    speeds : ndarray of shape (S,)
        [rad/s].
    alone : complex ndarray of shape (K, S, n)
        P_i = c_i Z_i / e_i: each throw loaded by its own pin alone [N].
    in_shaft : complex ndarray of shape (K, S, n)
        With the lengthening caused by all pin forces of the shaft [N].
    shapes : ndarray of shape (q, n + 1)
        Axial mode shapes at the sections for the modal forces; q may be 0.
    """

    orders: FloatArray
    speeds: FloatArray
    alone: ComplexArray
    in_shaft: ComplexArray
    shapes: FloatArray

    @property
    def modal_alone(self) -> ComplexArray:
        """Work of the forces on each mode shape, single throws (K, S, q)."""
        return self._modal(self.alone)

    @property
    def modal_in_shaft(self) -> ComplexArray:
        """Work of the forces on each mode shape, neighbors included (K, S, q)."""
        return self._modal(self.in_shaft)

    @property
    def difference(self) -> FloatArray:
        """Largest amplitude of the difference over the throws, relative to the largest in the shaft (K, S).

        Zero where no throw has a force of this order.
        """
        apart, most = (
            np.max(np.abs(found), axis=2) for found in (self.alone - self.in_shaft, self.in_shaft)
        )
        share: FloatArray = np.divide(apart, most, out=np.zeros_like(most), where=most > 0.0)
        return share

    def columns(self, speed_index: int) -> dict[str, FloatArray]:
        """Return a table over the orders at one of the speeds, units in the names, each (K,).

        Raises
        ------
        InputError
            If there is no such speed.
        """
        place = checked_speed_index(speed_index, self.speeds)
        table = {"order": self.orders}
        for throw in range(self.alone.shape[2]):
            table[f"throw_{throw + 1}_alone_N"] = np.abs(self.alone[:, place, throw])
            table[f"throw_{throw + 1}_in_shaft_N"] = np.abs(self.in_shaft[:, place, throw])
        for mode in range(self.shapes.shape[0]):
            table[f"mode_{mode + 1}_alone_N"] = np.abs(self.modal_alone[:, place, mode])
            table[f"mode_{mode + 1}_in_shaft_N"] = np.abs(self.modal_in_shaft[:, place, mode])
        return table

    def _modal(self, pressing: ComplexArray) -> ComplexArray:
        return np.asarray(pressing @ np.diff(self.shapes, axis=1).T)

    def plot(self, axes: Axes | None = None, throw: int = 1, *, main_orders: int = 3) -> Axes:
        """Draw the axial force of a throw by its main orders over the speed, by both methods.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        throw : int, optional
            Its number, from 1 at the free end.
        main_orders : int, optional
            Number of orders, those with the largest peaks.

        Returns
        -------
        matplotlib.axes.Axes
            Full lines are those in the shaft, dashed ones those of the single throw.

        Raises
        ------
        InputError
            If there is no such throw, or the number of orders is not 1 or more.
        """
        whole_within("throw", throw, 1, self.alone.shape[2], "the shaft has that many")
        alone, in_shaft = (
            KILO * np.abs(found[:, :, throw - 1]) for found in (self.alone, self.in_shaft)
        )
        most = whole_number("main_orders", main_orders, 1, "a diagram shows some orders")
        axes = new_axes(axes)
        for place, order in enumerate(main_orders_of(in_shaft, most)):
            color, name = COLORS[place % len(COLORS)], f"order {self.orders[order]:g}"
            rpm = RPM * self.speeds
            axes.plot(rpm, in_shaft[order], color=color, label=f"{name}, in the shaft")
            axes.plot(rpm, alone[order], "--", color=color, label=f"{name}, throw alone")
        set_speed_axis(axes, self.speeds)
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel("axial force [kN]")
        write_title(axes, f"Axial force of throw {throw}")
        legend_inside(axes)
        return axes


def compare_axial_forces(
    forces: CylinderForces,
    compliances: ArrayLike,
    own: ArrayLike,
    influence: ArrayLike,
    *,
    own_compliances: ArrayLike | None = None,
    pins: ArrayLike | None = None,
    shapes: ArrayLike | None = None,
) -> AxialForceComparison:
    """Find the axial force of each throw by two methods.

    Parameters
    ----------
    forces : CylinderForces
    compliances : array_like of shape (n,)
        e of each throw, as in the axial chain [m/N].
    own : array_like of shape (n,)
        c of each single throw [m/N].
    influence : array_like of shape (n, p) or (n, p, 2)
        Lengthening of throw i per Z (and T) on pin j, as for `axial_throw_forces` [m/N].
    own_compliances : array_like of shape (n,), optional
        e of each single throw [m/N] under the same support as its c; c and e of different supports are
        incompatible. By default `compliances`.
    pins : array_like of c int, optional
        Pin of each cylinder, from 0.
    shapes : array_like of shape (q, n + 1), optional
        Axial mode shapes at the sections, to show the effect of the difference on each mode.

    Returns
    -------
    AxialForceComparison

    Raises
    ------
    InputError
        If shapes of arrays do not fit, or a compliance is not above zero.
    """
    alone = axial_throw_forces(
        forces, compliances if own_compliances is None else own_compliances, own
    )
    in_shaft = axial_throw_forces(forces, compliances, influence, pins)
    sections = alone.shape[2] + 1
    modes = np.zeros((0, sections)) if shapes is None else finite_array("shapes", shapes)
    if modes.ndim != 2 or modes.shape[1] != sections:
        raise InputError(
            f"shapes: given an array of shape {modes.shape}; allowed is (q, {sections}), because a mode "
            "has a displacement at each section."
        )
    return AxialForceComparison(forces.orders, forces.speeds, alone, in_shaft, modes)
