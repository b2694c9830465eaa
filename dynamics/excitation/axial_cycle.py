"""Axial forces of a crankshaft over one cycle: on its thrust bearing and between held ends."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import checked_degrees
from crankbase.checks.arrays import (
    FloatArray,
    check_shape,
    finite_array,
    positive_vector,
    turning_speeds,
)
from crankbase.drawing.curves import Curves, Series, draw_curves
from crankbase.drawing.diagram_style import BLUE, GRAY, new_axes
from crankbase.drawing.legends import legend_below, write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from dynamics.plots.quantities import KILO


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
    speed : float
        [rad/s].
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
        """Draw the force on the thrust bearing, and on held ends, over the shaft angle.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        draw_curves(axes, self.curves())
        legend_below(axes, 2)
        write_title(axes, "Axial force over the cycle")
        return axes

    def columns(self) -> dict[str, FloatArray]:
        """Return all forces over the shaft angle, units in the names, each (m,)."""
        found = {"shaft_angle_deg": self.shaft_angles_deg}
        if self.thrust_bearing is not None:
            found["thrust_bearing_N"] = self.thrust_bearing
        found["held_N"] = self.held
        for place, own in enumerate(self.throws.T, start=1):
            found[f"throw_{place}_N"] = own
        return found

    def to_pandas(self) -> DataFrame:
        """Return a row for each shaft angle.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        angles, *forces = self.columns().items()
        named = {name.removesuffix("_N"): (own, "N") for name, own in forces}
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
    shaft_angles_deg : array_like of shape (m,)
        [deg].
    speed : float
        [rad/s].
    pin_forces : array_like of shape (m, p, 2)
        Radial force Z, towards the shaft, and tangential force T on each pin [N].
    compliances : array_like of shape (n,)
        Axial compliance of each throw in the shaft [m/N].
    influence : array_like of shape (n, p, 2)
        Lengthening of throw i per Z and T on pin j, the shaft axially free [m/N].
    thrust_bearing : ndarray of shape (m,), optional
        Force on the thrust bearing, if known [N].

    Returns
    -------
    AxialForceOverCycle

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
