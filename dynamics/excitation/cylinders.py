"""Forces of all cylinders on their crankpins, by order and speed, for vibration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.angles import radians_of
from crankbase.checks.arrays import ComplexArray, FloatArray, read_only
from crankbase.checks.choices import check_choice
from crankbase.checks.scalars import whole_number, whole_within
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.library_types import Axes, Dataset
from crankbase.summaries import summarized
from crankbase.tables.frames import grid
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.cylinder_harmonics import CylinderHarmonics, cylinder_harmonics
from dynamics.excitation.engine_load import Load, per_minute
from dynamics.excitation.gas_sources import Pressures
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.mechanism.rod_model_names import RodModelName
from dynamics.plots.curves import MAIN_ORDERS, draw_orders, set_speed_axis
from dynamics.plots.quantities import KILO, number_axis, orders_and_speeds
from dynamics.response.order_excitation import at_angles, checked_speed_index, checked_speeds
from dynamics.torque.cycle_samples import DEFAULT_SAMPLES


@summarized("orders", "speeds [rad/s]", "tangential [N]", "radial [N]", "power [W]", "remarks")
@dataclass(frozen=True, eq=False)
class CylinderForces:
    """Force of each cylinder on its crankpin, by order and speed.

    Order k of cylinder j is Re(F exp(i k phi)), phi the shaft angle; firing phases are included.

    Parameters
    ----------
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution, ascending.
    speeds : ndarray of shape (S,)
        Of the crankshaft [rad/s], ascending.
    tangential : complex ndarray of shape (K, S, c)
        T, in the sense of rotation [N].
    radial : complex ndarray of shape (K, S, c)
        Z, towards the shaft axis [N].
    mean_tangential, mean_radial : ndarray of shape (S, c)
        Mean of T and Z [N].
    crank_radius : float
        R [m].
    throws : tuple of c int
        Throw of each cylinder, from 0 at the free end.
    remarks : tuple of str
        Assumptions, a sentence each.
    of_inertia : bool
        Whether forces of moving masses are included.
    """

    orders: FloatArray
    speeds: FloatArray
    tangential: ComplexArray
    radial: ComplexArray
    mean_tangential: FloatArray
    mean_radial: FloatArray
    crank_radius: float
    throws: tuple[int, ...]
    remarks: tuple[str, ...] = ()
    of_inertia: bool = True

    @property
    def torque(self) -> ComplexArray:
        """R T of each cylinder (K, S, c) [N m]."""
        return self.crank_radius * self.tangential

    @property
    def mean_torque(self) -> FloatArray:
        """Mean torque of the engine at each speed (S,) [N m]."""
        return np.asarray(self.crank_radius * self.mean_tangential.sum(axis=1))

    @property
    def power(self) -> FloatArray:
        """Indicated power, mean torque times speed (S,) [W]."""
        return self.mean_torque * self.speeds

    @property
    def throw_count(self) -> int:
        """Number of throws."""
        return max(self.throws) + 1

    def at_angle(
        self, speed_index: int, *, shaft_angle_deg: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Return T and Z over shaft angles at one of the speeds, the sum of mean and all orders.

        Parameters
        ----------
        speed_index : int
            Which of the speeds, from 0.
        shaft_angle_deg : array_like of shape (m,)
            [deg].

        Returns
        -------
        tangential, radial : ndarray of shape (m, c)
            [N].

        Raises
        ------
        InputError
            If there is no such speed, or an angle is not a finite number.
        """
        place = checked_speed_index(speed_index, self.speeds)
        angles = radians_of("shaft_angle_deg", shaft_angle_deg, vector=True)
        return (
            self.mean_tangential[place] + at_angles(self.orders, self.tangential[:, place], angles),
            self.mean_radial[place] + at_angles(self.orders, self.radial[:, place], angles),
        )

    def plot(
        self,
        axes: Axes | None = None,
        cylinder: int = 1,
        *,
        show: Literal["tangential", "radial"] = "tangential",
        main_orders: int = MAIN_ORDERS,
    ) -> Axes:
        """Draw the amplitudes of T or Z of a cylinder's main orders over the speed.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        cylinder : int, optional
            Its number, from 1.
        show : {"tangential", "radial"}, optional
            Which of the forces on the crankpin.
        main_orders : int, optional
            Number of orders, those with the largest peaks.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If there is no such cylinder or force, or the number of orders is not 1 or more.
        """
        whole_within("cylinder", cylinder, 1, len(self.throws), "the engine has that many")
        check_choice("show", show, ("tangential", "radial"), "these are the forces on a crankpin")
        most = whole_number("main_orders", main_orders, 1, "a diagram shows some orders")
        phasors = self.tangential if show == "tangential" else self.radial
        sizes = KILO * np.abs(phasors[:, :, cylinder - 1])
        axes = new_axes(axes)
        draw_orders(axes, self.speeds, self.orders, sizes, most)
        set_speed_axis(axes, self.speeds)
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel("amplitude [kN]")
        write_title(axes, f"Orders of the {show} force, cylinder {cylinder}")
        legend_inside(axes)
        return axes

    def to_xarray(self) -> Dataset:
        """Return complex T and Z over order, speed and cylinder, and their means.

        Returns
        -------
        xarray.Dataset
            Units in the ``attrs["units"]`` of each array and coordinate.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        over, mean = ("order", "speed", "cylinder"), ("speed", "cylinder")
        return grid(
            {
                "tangential": (over, self.tangential, "N", "phasor of the tangential force"),
                "radial": (over, self.radial, "N", "phasor of the radial force"),
                "mean_tangential": (mean, self.mean_tangential, "N", "mean tangential force"),
                "mean_radial": (mean, self.mean_radial, "N", "mean radial force"),
            },
            {
                **orders_and_speeds(self.orders, self.speeds),
                "cylinder": number_axis(len(self.throws), "cylinder"),
            },
        )


def cylinder_forces(
    engine: EngineLayout,
    speeds: ArrayLike,
    orders: ArrayLike | float,
    pressure: Pressures | None = None,
    *,
    load: Load | None = None,
    misfire: Mapping[int, float] | None = None,
    motored: Pressures | None = None,
    model: RodModelName = "rigid",
    inertia: bool = True,
    samples: int = DEFAULT_SAMPLES,
    throws: Sequence[int] | None = None,
    crankcase_pressure: float = ATMOSPHERE,
) -> CylinderForces:
    """Find the force of every cylinder on its crankpin, by order and speed.

    Parameters
    ----------
    engine : EngineLayout
        Any layout: cylinders in line or in a V, offset pins, hinged rods (whose share acts through
        the main rod, with the wall's reaction).
    speeds : array_like of shape (S,)
        Of the crankshaft [rad/s], ascending.
    orders : array_like of shape (K,), or a number
        In cycles per crankshaft revolution, ascending; a number for all orders up to it.
    pressure : GasPressure, PressureMap, or a sequence of n of them, optional
        For all cylinders, or for each; None for no gas force. A map is evaluated at each speed and
        load; a single diagram is used at all speeds, which a remark states.
    load : number, array_like of shape (S,) or callable, optional
        For a pressure map of several loads, in its measure: constant, one for each speed, or a
        function of the speeds such as that of `propeller_load`.
    misfire : mapping of int to float, optional
        Number of each failing cylinder to the share of its combustion that is missing: 1 for no
        combustion, when it follows the motored pressure.
    motored : as pressure, optional
        The pressure without combustion; required for misfire.
    model : str, optional
        Of the rods, one of `ROD_MODELS`.
    inertia : bool, optional
        Whether moving masses excite, by the square of the speed. Use False if the equations
        of motion contain the variable inertia itself.
    samples : int, optional
        Of the gas over the working cycle; they resolve orders below half their number per
        revolution.
    throws : sequence of n int, optional
        Throw of each cylinder, 0 next to the free end; by default cylinders of different banks with
        equal crank angles and nearly equal positions share one.
    crankcase_pressure : float, optional
        Absolute pressure under the pistons [Pa].

    Returns
    -------
    CylinderForces

    Raises
    ------
    InputError
        If orders or speeds do not ascend from above zero, an order is not one of the cycle or is beyond
        the resolution of samples or pressure diagrams, a pressure does not fit the engine, a speed or
        load is outside the map, or a misfire has no pressure without combustion.

    Notes
    -----
    Gas forces are linear in the pressure: T and Z per unit of gas force follow from the mechanism
    once, and each diagram's harmonics once. At constant speed inertia forces are the square of the
    speed times a function of the angle, and so are their harmonics, exactly.

    Examples
    --------
    >>> from dynamics.engine.cylinder import EngineCylinder
    >>> from dynamics.mechanism.rods import ConnectingRod
    >>> rod = ConnectingRod(length=0.2, mass=1.0, center_distance=0.07, inertia=0.006)
    >>> engine = EngineLayout(0.05, [EngineCylinder(0.1, 1.0, rod)], [1])
    >>> slow_and_fast = cylinder_forces(engine, [50.0, 100.0], 3.0)
    >>> np.abs(slow_and_fast.tangential[3, :, 0]).round(2).tolist()
    [89.24, 356.96]
    """
    found = cylinder_harmonics(
        engine,
        orders,
        pressure,
        misfire=misfire,
        motored=motored,
        model=model,
        inertia=inertia,
        samples=samples,
        throws=throws,
        crankcase_pressure=crankcase_pressure,
    )
    return forces_at_speeds(found, speeds, load)


def forces_at_speeds(
    harmonics: CylinderHarmonics, speeds: ArrayLike, load: Load | None = None
) -> CylinderForces:
    """Return the forces of the cylinders at speeds [rad/s] and loads.

    Raises
    ------
    InputError
        If speeds do not ascend from above zero, or one is outside a pressure map.
    """
    running = checked_speeds(speeds)
    phasors = harmonics.phasors(running, load)
    remarks = harmonics.remarks
    if harmonics.one_diagram and running.size > 1:
        remarks = (
            *remarks,
            f"One {harmonics.one_diagram} was used at all speeds from {per_minute(float(running[0]))} to "
            f"{per_minute(float(running[-1]))}, although it changes with speed and load.",
        )
    return CylinderForces(
        orders=harmonics.orders,
        speeds=read_only(running),
        tangential=phasors[1:, ..., 0],
        radial=phasors[1:, ..., 1],
        mean_tangential=phasors[0, ..., 0].real,
        mean_radial=phasors[0, ..., 1].real,
        crank_radius=harmonics.crank_radius,
        throws=harmonics.throws,
        remarks=remarks,
        of_inertia=bool(np.any(harmonics.inertia)),
    )
