"""Forces of all cylinders on their crankpins, by order and speed, for vibration."""

import math
from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict, Unpack, cast

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    finite_vector,
    nonnegative_number,
    positive_number,
    radians_of,
    read_only,
    turning_speeds,
)
from crankbase.choices import check_choice, whole_number, whole_within
from crankbase.diagrams import curve_diagram, draw_diagram, legend_inside, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, Dataset, grid
from crankbase.quantity import RPM
from crankbase.sentences import with_sentences
from crankbase.summaries import frozen
from dynamics.cycle import cycle_radians, even_angles, order_step
from dynamics.engine import RodModelName
from dynamics.engine.forces import MechanismForces, mechanism_forces, over_angles
from dynamics.engine.layout import MOST_CYLINDERS, EngineLayout
from dynamics.excitation.pressure_map import (
    GasSource,
    Load,
    Pressures,
    Weights,
    constant_weight,
    gas_sources,
    order_indices,
    per_minute,
    phasors_of_samples,
    requested_orders,
)
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.harmonics import Harmonics
from dynamics.plots.curves import (
    KILO,
    MAIN_ORDERS,
    SPEED_LABEL,
    number_axis,
    order_series,
    orders_and_speeds,
)
from dynamics.response.order_excitation import at_angles, checked_speed_index, checked_speeds
from dynamics.torque import DEFAULT_SAMPLES, checked_throws, throws_along_shaft

TURN = 2.0 * math.pi
# The forces of moving masses are smooth: so many samples of a turn tell all harmonics that matter.
INERTIA_SAMPLES = 720
PRESSURE_DIAGRAM = "pressure diagram"


@with_sentences
@frozen("orders", "crank_radius [m]", "throws", "takes_load", "remarks", eq=False)
class CylinderHarmonics:
    """Tangential and radial force of every cylinder by orders, for any speed and load.

    Parameters
    ----------
    gas : tuple of c complex ndarrays of shape (D, K + 1, 2)
        Mean and phasors of T and Z for each of the cylinder's diagrams [N], at shaft angle zero.
    weights : tuple of c callables
        Speeds and load to the weight of each of these diagrams (S, D).
    inertia : complex ndarray of shape (K + 1, c, 2)
        Mean and phasors of T and Z of moving masses, per square of the speed [N s^2/rad^2].
    one_diagram : str
        What is used at all speeds though it belongs to one: "pressure diagram", "torque diagram", or ""
        for nothing.
    changes : tuple of str
        Those of the remarks that tell of changes made to the diagrams.
    """

    orders: Array
    crank_radius: float
    throws: tuple[int, ...]
    gas: tuple[ComplexArray, ...]
    weights: tuple[Weights, ...]
    inertia: ComplexArray
    takes_load: bool
    one_diagram: str
    remarks: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()

    def phasors(self, speeds: Array, load: Load | None = None) -> ComplexArray:
        """Return mean and phasors of T and Z of each cylinder, (K + 1, S, c, 2) [N].

        Raises
        ------
        InputError
            If a speed is not a finite number or too high, a speed or load is outside a pressure map,
            or a load is given but not needed.
        """
        speeds = np.atleast_1d(turning_speeds("speeds", speeds))
        if load is not None and not self.takes_load:
            raise InputError(
                "load: given without a pressure map; allowed is none, because a single diagram has no load."
            )
        total = speeds[:, np.newaxis, np.newaxis] ** 2 * self.inertia[:, np.newaxis]
        known: dict[Weights, Array] = {}
        for place, (of_diagrams, weigh) in enumerate(zip(self.gas, self.weights, strict=True)):
            if weigh not in known:
                known[weigh] = weigh(speeds, load)
            total[:, :, place] += np.tensordot(known[weigh], of_diagrams, axes=1).swapaxes(0, 1)
        return total

    def at(
        self, speed: float | ArrayLike, load: Load | None = None, *, shaft_angle_deg: ArrayLike
    ) -> tuple[Array, Array]:
        """Return T and Z over shaft angles, as the sum of mean and all orders.

        Parameters
        ----------
        speed : number or array_like of shape (m,)
            Of the shaft [rad/s]: the inertia forces are proportional to its square, and a pressure map is
            evaluated at it.

        Returns
        -------
        tangential, radial : ndarray of shape (m, c)
            [N].

        Raises
        ------
        InputError
            As `phasors`, and if an angle or speed is not a finite number.
        """
        angles = radians_of("shaft_angle_deg", shaft_angle_deg, vector=True)
        if np.ndim(speed) == 0:
            single = cast(float, speed)
            running = np.array([nonnegative_number("speed", single, "rad/s", "the shaft turns")])
        else:
            running = over_angles("speed", turning_speeds("speed", speed), angles)
        turning = np.exp(1j * np.outer(angles, np.concatenate(([0.0], self.orders))))
        phasors = self.phasors(running, load)
        if running.size == 1:
            total = np.tensordot(turning, phasors[:, 0], axes=1).real
        else:
            total = np.einsum("mk,kmcx->mcx", turning, phasors).real
        return total[..., 0], total[..., 1]


class Mechanism(TypedDict, total=False):
    """What forces of cylinders take into account besides the pressure; see `cylinder_forces`."""

    misfire: Mapping[int, float] | None
    motored: Pressures | None
    model: RodModelName
    inertia: bool
    samples: int
    throws: Sequence[int] | None
    crankcase_pressure: float


def cylinder_harmonics(
    engine: EngineLayout,
    orders: ArrayLike | float,
    pressure: Pressures | None = None,
    *,
    misfire: Mapping[int, float] | None = None,
    motored: Pressures | None = None,
    model: RodModelName = "rigid",
    inertia: bool = True,
    samples: int = DEFAULT_SAMPLES,
    throws: Sequence[int] | None = None,
    crankcase_pressure: float = ATMOSPHERE,
) -> CylinderHarmonics:
    """Find the harmonics of the force of every cylinder on its crankpin, for any speed.

    Parameters
    ----------
    engine, orders, pressure, misfire, motored, model, inertia, samples, throws, crankcase_pressure
        As for `cylinder_forces`.

    Raises
    ------
    InputError
        As `cylinder_forces`, except for speeds and loads.
    """
    count = whole_number("samples", samples, 3, "fewer show no harmonic")
    asked = requested_orders(orders, engine.strokes)
    places = order_indices(asked, engine.strokes, count, "the force diagrams")
    under = nonnegative_number("crankcase_pressure", crankcase_pressure, "Pa", "it is absolute")
    angles = even_angles(cycle_radians(engine.strokes), count)
    kept = np.concatenate(([0], places))
    cylinders = len(engine.cylinders)
    none = np.zeros((kept.size, cylinders, 2), dtype=np.complex128)
    gas = [none[np.newaxis, :, 0]] * cylinders
    sources: tuple[GasSource, ...] = ()
    if pressure is not None:
        sources = gas_sources(engine, pressure, misfire, motored)
        known = [source.samples for source in sources if source.samples is not None]
        if known:
            order_indices(asked, engine.strokes, min(known), "the pressure diagrams")
        per_force = _pin_forces(
            mechanism_forces(engine, 0.0, 1.0, model=model, shaft_angles_deg=np.degrees(angles))
        )
        for place, (source, cylinder) in enumerate(zip(sources, engine.cylinders, strict=True)):
            since_firing = angles - np.radians(engine.firing_deg[place])
            above = np.array(
                [
                    diagram.at(angle_deg=np.degrees(since_firing)) - under
                    for diagram in source.diagrams
                ]
            )
            forces = cylinder.area * above[:, np.newaxis] * per_force[place]
            gas[place] = phasors_of_samples(forces)[..., kept].swapaxes(1, 2)
    elif misfire:
        raise InputError(
            "misfire: given without a pressure; allowed is none, because an engine without gas forces "
            "does not fire."
        )
    # What is used at all speeds: the pressure of all cylinders, that of some, or nothing.
    constant = [
        str(number) for number, source in enumerate(sources, start=1) if source.at_all_speeds
    ]
    one_diagram = f"pressure diagram of cylinder {', '.join(constant)}" if constant else ""
    if len(constant) == cylinders:
        one_diagram = PRESSURE_DIAGRAM
    return CylinderHarmonics(
        orders=read_only(asked),
        crank_radius=engine.crank_radius,
        throws=throw_of_each(engine, throws),
        gas=tuple(gas),
        weights=tuple(source.weights for source in sources) or (constant_weight,) * cylinders,
        inertia=_inertia_phasors(engine, asked, model) if inertia else none,
        takes_load=any(source.takes_load for source in sources),
        one_diagram=one_diagram,
        remarks=tuple(dict.fromkeys(text for source in sources for text in source.remarks)),
        changes=tuple(dict.fromkeys(text for source in sources for text in source.changes)),
    )


def throw_of_each(engine: EngineLayout, throws: Sequence[int] | None) -> tuple[int, ...]:
    """Return the throw of each cylinder from 0, given or found from the layout."""
    groups = throws_along_shaft(engine) if throws is None else checked_throws(engine, throws)
    throw_of = {number: throw for throw, group in enumerate(groups) for number in group}
    return tuple(throw_of[number] for number in range(1, len(engine.cylinders) + 1))


def _pin_forces(forces: MechanismForces) -> Array:
    """Return T and Z of each cylinder (c, 2, m)."""
    return np.stack((forces.tangential, forces.radial), axis=1)


def _inertia_phasors(engine: EngineLayout, orders: Array, model: RodModelName) -> ComplexArray:
    """Return mean and phasors of T and Z per square of the speed, which repeat every revolution."""
    whole = np.flatnonzero(orders == np.round(orders))
    angles = even_angles(TURN, max(INERTIA_SAMPLES, 2 * int(orders[-1]) + 3))
    forces = phasors_of_samples(
        _pin_forces(
            mechanism_forces(engine, 1.0, 0.0, model=model, shaft_angles_deg=np.degrees(angles))
        )
    )
    phasors = np.zeros((orders.size + 1, len(engine.cylinders), 2), dtype=np.complex128)
    phasors[0] = forces[..., 0]
    phasors[1 + whole] = np.moveaxis(forces[..., orders[whole].astype(np.int64)], -1, 0)
    return phasors


@frozen(
    "orders", "speeds [rad/s]", "tangential [N]", "radial [N]", "power [W]", "remarks", eq=False
)
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
    own_remarks : tuple of str
        Those of them that neither the cycle in the cylinders nor the load tells.
    of_inertia : bool
        Whether forces of moving masses are included.
    """

    orders: Array
    speeds: Array
    tangential: ComplexArray
    radial: ComplexArray
    mean_tangential: Array
    mean_radial: Array
    crank_radius: float
    throws: tuple[int, ...]
    remarks: tuple[str, ...] = ()
    own_remarks: tuple[str, ...] = ()
    of_inertia: bool = True

    @property
    def torque(self) -> ComplexArray:
        """R T of each cylinder (K, S, c) [N m]."""
        return self.crank_radius * self.tangential

    @property
    def mean_torque(self) -> Array:
        """Mean torque of the engine at each speed (S,) [N m]."""
        return np.asarray(self.crank_radius * self.mean_tangential.sum(axis=1))

    @property
    def power(self) -> Array:
        """Indicated power, mean torque times speed (S,) [W]."""
        return self.mean_torque * self.speeds

    @property
    def throw_count(self) -> int:
        """Number of throws."""
        return max(self.throws) + 1

    def at_angle(self, speed_index: int, *, shaft_angle_deg: ArrayLike) -> tuple[Array, Array]:
        """Return T and Z over shaft angles at one of the speeds, the sum of mean and all orders.

        Returns
        -------
        tangential, radial : ndarray of shape (m, c)
            [N].
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
        """Draw the amplitudes of T or Z of a cylinder's main orders over the speed."""
        whole_within("cylinder", cylinder, 1, len(self.throws), "the engine has that many")
        check_choice("show", show, ("tangential", "radial"), "these are the forces on a crankpin")
        most = whole_number("main_orders", main_orders, 1, "a diagram shows some orders")
        phasors = self.tangential if show == "tangential" else self.radial
        sizes = KILO * np.abs(phasors[:, :, cylinder - 1])
        axes = new_axes(axes)
        series = tuple(order_series(self.orders, sizes, most))
        draw_diagram(axes, curve_diagram(self.speeds * RPM, series, SPEED_LABEL, "amplitude [kN]"))
        write_title(axes, f"Orders of the {show} force, cylinder {cylinder}")
        legend_inside(axes)
        return axes

    def to_xarray(self) -> Dataset:
        """Return complex T and Z over order, speed and cylinder, and their means."""
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
    **mechanism: Unpack[Mechanism],
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
    >>> from dynamics.engine.layout import EngineCylinder
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(length=0.2, mass=1.0, center_distance=0.07, inertia=0.006)
    >>> engine = EngineLayout(0.05, [EngineCylinder(0.1, 1.0, rod)], [1])
    >>> slow_and_fast = cylinder_forces(engine, [50.0, 100.0], 3.0)
    >>> np.abs(slow_and_fast.tangential[3, :, 0]).round(2).tolist()
    [89.24, 356.96]
    """
    harmonics = cylinder_harmonics(engine, orders, pressure, **mechanism)
    return forces_at_speeds(harmonics, speeds, load)


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
    used: tuple[str, ...] = ()
    if harmonics.one_diagram and running.size > 1:
        used = (
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
        remarks=harmonics.remarks + used,
        own_remarks=harmonics.changes + (used if harmonics.one_diagram != PRESSURE_DIAGRAM else ()),
        of_inertia=bool(np.any(harmonics.inertia)),
    )


def torque_harmonics(
    torque: Harmonics | Sequence[Harmonics],
    orders: ArrayLike | float,
    *,
    firing_angles_deg: ArrayLike,
    crank_radius: float,
    throws: Sequence[int] | None = None,
) -> CylinderHarmonics:
    """Return given torques of the cylinders in the form of calculated forces.

    Parameters
    ----------
    torque : Harmonics or sequence of c Harmonics
        Of one cylinder's torque, gas and inertia together [N m], phases counted from its own firing
        top: the same for all, or one for each. They are used at all speeds.
    orders : array_like of shape (K,), or a number
        Ascending; a number for all up to it.
    firing_angles_deg : array_like of shape (c,)
        Shaft angle at which each cylinder fires [deg].
    crank_radius : float
        R [m].
    throws : sequence of c int, optional
        Throw of each cylinder, 0 next to the free end; by default one each.

    Returns
    -------
    CylinderHarmonics
        Without radial forces, which a torque does not determine.

    Raises
    ------
    InputError
        If there is not one for each cylinder, strokes differ, or samples do not resolve an order.
    """
    firing = np.radians(finite_vector("firing_angles_deg", firing_angles_deg))
    each = [torque] * firing.size if isinstance(torque, Harmonics) else list(torque)
    if firing.size > MOST_CYLINDERS:
        raise InputError(
            f"firing_angles_deg: given {firing.size} angles; allowed are at most {MOST_CYLINDERS}, because "
            "no engine has more cylinders."
        )
    if not each or len(each) != firing.size or len({spectrum.strokes for spectrum in each}) > 1:
        raise InputError(
            f"torque: given {len(each)} for {firing.size} firing angles; allowed is one for each cylinder, "
            "all of one kind of cycle, because each cylinder works on the same shaft."
        )
    at_throws = tuple(range(firing.size)) if throws is None else tuple(throws)
    if sorted(set(at_throws)) != list(range(max(at_throws) + 1)) or len(at_throws) != firing.size:
        raise InputError(
            f"throws: given {list(at_throws)}; allowed is one for each of {firing.size} cylinders, from "
            "0 on without a gap, because each cylinder works on one."
        )
    radius = positive_number("crank_radius", crank_radius, "m", "it is a length")
    strokes = each[0].strokes
    asked = requested_orders(orders, strokes)
    gas: list[ComplexArray] = []
    for spectrum, angle in zip(each, firing.tolist(), strict=True):
        order_indices(asked, strokes, spectrum.samples, "the given torques")
        order_indices(
            asked, strokes, 2 * spectrum.orders.size + 1, "the orders kept of the torques"
        )
        places = np.round(asked / order_step(strokes)).astype(np.int64) - 1
        phasors = (spectrum.cosine - 1j * spectrum.sine)[places] * np.exp(-1j * asked * angle)
        tangential = np.zeros(asked.size + 1, dtype=np.complex128)
        tangential[0], tangential[1:] = spectrum.mean / radius, phasors / radius
        gas.append(np.stack((tangential, 0.0 * tangential), axis=-1)[np.newaxis])
    return CylinderHarmonics(
        orders=read_only(asked),
        crank_radius=radius,
        throws=at_throws,
        gas=tuple(gas),
        weights=(constant_weight,) * firing.size,
        inertia=np.zeros((asked.size + 1, firing.size, 2), dtype=np.complex128),
        takes_load=False,
        one_diagram="torque diagram",
    )
