"""Axial forces of throws: over a cycle, and compared with those of all pin forces of the shaft."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    check_shape,
    checked_degrees,
    finite_array,
    positive_vector,
    turning_speeds,
)
from crankbase.choices import whole_number, whole_within
from crankbase.diagrams import (
    BLUE,
    COLORS,
    GRAY,
    Curves,
    Series,
    draw_curves,
    legend_below,
    legend_inside,
    new_axes,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import RPM
from crankbase.summaries import summarized
from dynamics.excitation.chain_excitation import axial_throw_forces
from dynamics.excitation.cylinders import CylinderForces
from dynamics.plots.curves import KILO, main_orders_of, set_speed_axis
from dynamics.response.order_excitation import checked_speed_index


@summarized("orders", "speeds [rad/s]", "alone [N]", "in_shaft [N]")
@dataclass(frozen=True, eq=False)
class AxialForceComparison:
    """Axial force of each throw by order and speed, by two methods.

    Parameters
    ----------
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
            np.max(np.abs(forces), axis=2) for forces in (self.alone - self.in_shaft, self.in_shaft)
        )
        share: FloatArray = np.divide(apart, most, out=np.zeros_like(most), where=most > 0.0)
        return share

    def columns(self, speed_index: int) -> dict[str, FloatArray]:
        """Return a table over the orders at one of the speeds, units in the names, each (K,)."""
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

        Returns
        -------
        matplotlib.axes.Axes
            Full lines are those in the shaft, dashed ones those of the single throw.
        """
        whole_within("throw", throw, 1, self.alone.shape[2], "the shaft has that many")
        alone, in_shaft = (
            KILO * np.abs(forces[:, :, throw - 1]) for forces in (self.alone, self.in_shaft)
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
    compliances : array_like of shape (n,)
        e of each throw, as in the axial chain [m/N].
    own : array_like of shape (n,)
        c of each single throw [m/N].
    influence : array_like of shape (n, p) or (n, p, 2)
        Lengthening of throw i per Z (and T) on pin j, as for `axial_throw_forces` [m/N].
    own_compliances : array_like of shape (n,), optional
        e of each single throw [m/N] under the same support as its c; c and e of different supports are
        incompatible. By default `compliances`.
    shapes : array_like of shape (q, n + 1), optional
        Axial mode shapes at the sections, to show the effect of the difference on each mode.

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


@summarized(
    "shaft_angles_deg [deg]", "speed [rad/s]", "throws [N]", "held [N]", "thrust_bearing [N]"
)
@dataclass(frozen=True, eq=False)
class AxialForceOverCycle:
    """Axial forces over one cycle at constant speed, under the forces of all cylinders.

    Parameters
    ----------
    shaft_angles_deg : ndarray of shape (m,)
        Evenly spaced over the cycle, without the closing one [deg].
    throws : ndarray of shape (m, n)
        P_i, the force with which each throw pushes its ends apart [N].
    held : ndarray of shape (m,)
        Force that the shaft would exert on its two ends if both were held axially, without
        vibration [N].
    thrust_bearing : ndarray of shape (m,) or None
        Force on the thrust bearing with vibration, positive towards the flywheel [N]; None
        if unknown.

    Notes
    -----
    Forces on pins have no part along the shaft. So a single thrust bearing carries none
    of them, only the force that accelerates the masses: that of the vibration.
    """

    shaft_angles_deg: FloatArray
    speed: float
    throws: FloatArray
    held: FloatArray
    thrust_bearing: FloatArray | None = None

    def curves(self) -> Curves:
        """Describe both forces over the shaft angle, with the cycle closed."""
        degrees, held = self.shaft_angles_deg, KILO * self.held
        series = [
            Series(
                "both ends held, no vibration", np.append(held, held[0]), color=GRAY, dash="dash"
            )
        ]
        if self.thrust_bearing is not None:
            force = KILO * self.thrust_bearing
            name = "on the thrust bearing, vibrating"
            series.append(Series(name, np.append(force, force[0]), color=BLUE))
        return Curves(
            np.append(degrees, 2.0 * degrees[-1] - degrees[-2]),
            tuple(series),
            "shaft angle [deg]",
            "axial force [kN]",
            signed=True,
            x_step=90.0,
        )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the force on the thrust bearing, and on held ends, over the shaft angle."""
        axes = new_axes(axes)
        draw_curves(axes, self.curves())
        legend_below(axes, 2)
        write_title(axes, "Axial force over the cycle")
        return axes

    def columns(self) -> dict[str, FloatArray]:
        """Return all forces over the shaft angle, units in the names, each (m,)."""
        columns = {"shaft_angle_deg": self.shaft_angles_deg}
        if self.thrust_bearing is not None:
            columns["thrust_bearing_N"] = self.thrust_bearing
        columns["held_N"] = self.held
        for place, force in enumerate(self.throws.T, start=1):
            columns[f"throw_{place}_N"] = force
        return columns

    def to_pandas(self) -> DataFrame:
        """Return a row for each shaft angle."""
        angles, *forces = self.columns().items()
        named = {name.removesuffix("_N"): (force, "N") for name, force in forces}
        return table({"shaft_angle": (angles[1], "deg")} | named)


def axial_force_over_cycle(
    speed: float,
    pin_forces: ArrayLike,
    compliances: ArrayLike,
    influence: ArrayLike,
    thrust_bearing: FloatArray | None = None,
    *,
    shaft_angles_deg: ArrayLike,
) -> AxialForceOverCycle:
    """Find the axial forces of a shaft from the forces on its pins at every angle.

    Parameters
    ----------
    pin_forces : array_like of shape (m, p, 2)
        Radial force Z, towards the shaft, and tangential force T on each pin [N].
    compliances : array_like of shape (n,)
        Axial compliance of each throw in the shaft [m/N].
    influence : array_like of shape (n, p, 2)
        Lengthening of throw i per Z and T on pin j, the shaft axially free [m/N].
    thrust_bearing : ndarray of shape (m,), optional
        Force on the thrust bearing, if known [N].

    Raises
    ------
    InputError
        If shapes of arrays do not fit, a value is not finite, or a compliance is not above zero.

    Notes
    -----
    Throw i would lengthen by d_i = sum over j of c_ij F_j. Held at both ends, the shaft pushes against
    them with (sum of d_i) / (sum of e_i): a pull of 1 N lengthens it by the sum of e_i.
    """
    angles = checked_degrees("shaft_angles_deg", shaft_angles_deg, vector=True)
    forces, c = finite_array("pin_forces", pin_forces), finite_array("influence", influence)
    e = positive_vector("compliances", compliances, "m/N", "every throw yields under load")
    if c.ndim != 3 or c.shape[::2] != (e.size, 2) or forces.shape != (angles.size, c.shape[1], 2):
        raise InputError(
            f"pin_forces: given an array of shape {forces.shape} with an influence of shape {c.shape}; "
            f"allowed are ({angles.size}, p, 2) and ({e.size}, p, 2), because each pin has Z and T at each "
            "angle."
        )
    check_shape("speed", turning_speeds("speed", speed), ())
    if thrust_bearing is not None:
        thrust_bearing = finite_array("thrust_bearing", thrust_bearing)
        check_shape("thrust_bearing", thrust_bearing, angles.shape)
    lengthening = np.einsum("npx,mpx->mn", c, forces)
    return AxialForceOverCycle(
        shaft_angles_deg=angles,
        speed=speed,
        throws=lengthening / e,
        held=lengthening.sum(axis=1) / e.sum(),
        thrust_bearing=thrust_bearing,
    )
