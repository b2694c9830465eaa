"""Forces of the cylinders as excitation of an engine's chains: torques, axial forces of throws, compared."""

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    check_shape,
    checked_degrees,
    finite_array,
    finite_vector,
    positive_number,
    positive_vector,
    turning_speeds,
)
from crankbase.choices import check_some, is_whole, whole_number, whole_within
from crankbase.diagrams import (
    BLUE,
    COLORS,
    GRAY,
    Diagram,
    Series,
    curve_diagram,
    draw_diagram,
    legend_below,
    legend_inside,
    new_axes,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import RPM
from crankbase.summaries import frozen
from dynamics.chains.engine_chains import EngineChain
from dynamics.excitation.cylinders import CylinderForces, CylinderHarmonics
from dynamics.excitation.pressure_map import Load
from dynamics.plots.curves import KILO, main_orders_of, set_speed_axis
from dynamics.response.forced import ForcedResponse
from dynamics.response.loads import elastic_loads
from dynamics.response.order_excitation import OrderExcitation, checked_speed_index


def torque_excitation(forces: CylinderForces, engine_chain: "EngineChain") -> OrderExcitation:
    """Return the cylinders' torques as excitation of a torsional chain.

    Parameters
    ----------
    engine_chain : EngineChain
        Torsional. Crank radius times T of each cylinder acts on the node of its throw; cylinders on
        one throw add up.

    Returns
    -------
    OrderExcitation
        Torques [N m].

    Raises
    ------
    InputError
        If the chain is not torsional or has another number of throws.
    """
    nodes = _nodes_of_cylinders(engine_chain, forces.throws)
    size = engine_chain.chain.inertia.size
    torques = np.zeros((*forces.torque.shape[:2], size), dtype=np.complex128)
    for place, node in enumerate(nodes):
        torques[:, :, node] += forces.torque[:, :, place]
    return OrderExcitation(forces.orders, forces.speeds, torques)


def node_torques(
    harmonics: CylinderHarmonics,
    engine_chain: "EngineChain",
    speed: float | ArrayLike,
    load: Load | None = None,
    *,
    shaft_angle_deg: ArrayLike,
) -> Array:
    """Return the cylinders' torques on the nodes of a torsional chain over shaft angles.

    This is the mean and the sum of the orders of `torque_excitation`, so time
    integration and solution by orders have the same excitation.

    Parameters
    ----------
    speed : number or array_like of shape (m,)
        Of the shaft at these angles [rad/s].

    Returns
    -------
    ndarray of shape (m, n)
        [N m].

    Raises
    ------
    InputError
        As `torque_excitation` and `CylinderHarmonics.at`.
    """
    nodes = _nodes_of_cylinders(engine_chain, harmonics.throws)
    tangential, _ = harmonics.at(speed, load, shaft_angle_deg=shaft_angle_deg)
    torques = np.zeros((tangential.shape[0], engine_chain.chain.inertia.size))
    for cylinder, node in enumerate(nodes):
        torques[:, node] += harmonics.crank_radius * tangential[:, cylinder]
    return torques


def axial_throw_forces(
    forces: CylinderForces,
    compliances: ArrayLike,
    influence: ArrayLike,
    pins: ArrayLike | None = None,
) -> ComplexArray:
    """Return the axial force with which each throw pushes its ends apart.

    Parameters
    ----------
    compliances : array_like of shape (n,)
        Axial compliance e of each throw, as in the axial chain [m/N].
    influence : array_like of shape (n,), (n, p) or (n, p, 2)
        Lengthening per unit force on pins, ends axially free [m/N]. (n,): c of each single throw, for
        its own radial force alone. (n, p): lengthening of throw i per Z on pin j, neighbors included.
        (n, p, 2): per Z and per T of pin j.
    pins : array_like of c int, optional
        Pin of each cylinder from 0 along the shaft; by default that of its throw.

    Returns
    -------
    complex ndarray of shape (K, S, n)
        P_i = (sum over j of c_ij Z_j) / e_i [N].

    Notes
    -----
    A throw with free ends would lengthen by c Z. The chain's spring 1/e between its ends lengthens
    as much under P = c Z / e; held ends carry P. Stoyanov's formula, as quoted by Yamanin, Zhukov
    2021, doi 10.24143/2073-1574-2021-4-75-83.
    """
    e = positive_vector("compliances", compliances, "m/N", "every throw yields under load")
    unit_lengthening = finite_array("influence", influence)
    if unit_lengthening.shape == (e.size,):
        unit_lengthening = np.diag(unit_lengthening)
    if unit_lengthening.ndim == 2:
        unit_lengthening = np.stack((unit_lengthening, np.zeros_like(unit_lengthening)), axis=-1)
    places = list(forces.throws if pins is None else np.asarray(pins).ravel())
    cylinders = len(forces.throws)
    if len(places) != cylinders or not all(is_whole(pin) and pin >= 0 for pin in places):
        raise InputError(
            f"pins: given {places}; allowed is a whole number from 0 for each of the {cylinders} "
            "cylinders, because its rod sits on one pin."
        )
    on_pins = np.array(places, dtype=np.int64)
    count = on_pins.max() + 1
    if unit_lengthening.shape != (e.size, count, 2):
        raise InputError(
            f"influence: given an array of shape {np.shape(influence)}; allowed is ({e.size},), "
            f"({e.size}, {count}) or ({e.size}, {count}, 2), because it has a row for each throw and a "
            "column for each pin."
        )
    acting = np.stack((forces.radial, forces.tangential), axis=-1)
    lengthening = np.tensordot(acting, unit_lengthening[:, on_pins], axes=([2, 3], [1, 2]))
    return np.asarray(lengthening / e)


def axial_excitation(
    forces: CylinderForces,
    engine_chain: "EngineChain",
    compliances: ArrayLike,
    influence: ArrayLike,
    pins: ArrayLike | None = None,
) -> OrderExcitation:
    """Return the axial forces of the throws as excitation of an axial chain.

    Parameters
    ----------
    engine_chain : EngineChain
        Axial, with a section before and one after each throw.

    Returns
    -------
    OrderExcitation
        -P on the section before each throw, +P on that after it [N], positive towards the flywheel.

    Raises
    ------
    InputError
        As `axial_throw_forces`, and if the chain is not axial or has other throws.
    """
    pressing = axial_throw_forces(forces, compliances, influence, pins)
    return pressing_excitation(forces.orders, forces.speeds, pressing, engine_chain)


def pressing_excitation(
    orders: Array, speeds: Array, pressing: ComplexArray, engine_chain: "EngineChain"
) -> OrderExcitation:
    """Return the excitation of an axial chain by throws that push their ends apart.

    Parameters
    ----------
    pressing : complex ndarray of shape (K, S, n)
        P of each throw [N].

    Returns
    -------
    OrderExcitation
        -P on the section before each throw, +P on that after it [N]. No axial force acts on a pin from
        outside, so the force through the throw is that of its spring less P.
    """
    if engine_chain.kind != "axial":
        raise InputError(
            f"engine_chain: given a {engine_chain.kind} one; allowed is an axial one, because axial "
            "forces act on it."
        )
    sections = engine_chain.sections
    if len(sections) != pressing.shape[2] + 1:
        raise InputError(
            f"compliances: given {pressing.shape[2]} for a chain of {len(sections)} sections; allowed "
            f"are {len(sections) - 1}, because a throw lies between two sections."
        )
    chain = engine_chain.chain
    # The throws are the first elements of the chain.
    elements = np.pad(pressing, ((0, 0), (0, 0), (0, len(chain.elements) - pressing.shape[2])))
    return OrderExcitation(orders, speeds, elements @ chain.elongations(), elements)


def _nodes_of_cylinders(engine_chain: "EngineChain", throws: tuple[int, ...]) -> list[int]:
    if engine_chain.kind != "torsional":
        raise InputError(
            f"engine_chain: given a {engine_chain.kind} one; allowed is a torsional one, because "
            "torques act on it."
        )
    nodes = engine_chain.throw_nodes
    if max(throws) + 1 != len(nodes):
        raise InputError(
            f"engine_chain: given one of {len(nodes)} throws for cylinders on {max(throws) + 1}; allowed "
            "is the same number, because each cylinder turns its throw."
        )
    return [nodes[throw] for throw in throws]


# Two orders are one within this share: that of a propeller comes from a gear ratio.
SAME_ORDER = 1e-9


def combined_excitation(*excitations: OrderExcitation) -> OrderExcitation:
    """Return several excitations of the same nodes as one with all their orders.

    Parameters
    ----------
    excitations : OrderExcitation
        With the same speeds and nodes; orders may differ, as those of engine and propeller.
        Phasors of one order are added, with their phases.

    Raises
    ------
    InputError
        If none is given, or speeds or the number of nodes differ.
    """
    check_some("excitations", excitations, "they are added up")
    first = excitations[0]
    for other in excitations[1:]:
        if (
            not np.array_equal(other.speeds, first.speeds)
            or other.forces.shape[2] != first.forces.shape[2]
        ):
            raise InputError(
                f"excitations: given {other.speeds.size} speeds and {other.forces.shape[2]} nodes beside "
                f"{first.speeds.size} and {first.forces.shape[2]}; allowed are the same speeds and nodes, "
                "because forces are added speed by speed and node by node."
            )
    every = np.sort(np.concatenate([excitation.orders for excitation in excitations]))
    orders = every[np.diff(every, prepend=0.0) > SAME_ORDER * every]
    count = first.forces.shape[2]
    most = max(
        (excitation.acting for excitation in excitations), key=lambda acting: acting.shape[2]
    )
    acting = np.zeros((orders.size, *most.shape[1:]), dtype=np.complex128)
    for excitation in excitations:
        places = np.argmin(np.abs(orders[:, np.newaxis] - excitation.orders), axis=0)
        added = excitation.acting
        np.add.at(acting[:, :, : added.shape[2]], places, added)
    pressing = acting[:, :, count:] if acting.shape[2] > count else None
    return OrderExcitation(orders, first.speeds, acting[:, :, :count], pressing)


def torsion_influence(tangential: ArrayLike, through: ArrayLike, crank_radius: float) -> Array:
    """Return the lengthening of each throw per torque in each part of the shaft.

    Parameters
    ----------
    tangential : array_like of shape (n, n)
        Lengthening of throw i per unit tangential force T on the pin of throw j, the shaft held
        against rotation at its free end only [m/N].
    through : array_like of shape (n,)
        Lengthening of throw i per unit torque in the sense of rotation at the flywheel's end, held
        likewise [1/N].
    crank_radius : float
        R [m].

    Returns
    -------
    ndarray of shape (n, n + 1)
        Per torque in the parts free end to crank 1, crank 1 to crank 2 ... crank n to flywheel, each
        positive where it twists the part forwards [1/N]. It does not depend on where the shaft is
        held.

    Notes
    -----
    A torque in the part between cranks j and j + 1 alone comes from -1 / R on pin j and 1 / R on
    pin j + 1. In a shaft whose cranks are in one plane all values are zero: mirrored in that plane,
    torque and T change their sign and lengthening does not.
    """
    by_pins, through_shaft = (
        finite_array("tangential", tangential),
        finite_vector("through", through),
    )
    count = through_shaft.size
    if by_pins.shape != (count, count):
        raise InputError(
            f"tangential: given an array of shape {by_pins.shape}; allowed is ({count}, {count}), because "
            "through has a value for each throw and each throw has one pin."
        )
    per_torque = by_pins / positive_number("crank_radius", crank_radius, "m", "it is a length")
    ends = np.column_stack((np.zeros(count), per_torque, through_shaft))
    return np.asarray(np.diff(ends, axis=1))


def tangential_towards_flywheel(
    tangential: ArrayLike, through: ArrayLike, crank_radius: float
) -> Array:
    """Return the lengthening per tangential force whose torque goes to the flywheel, (n, p) [m/N].

    Parameters
    ----------
    tangential : array_like of shape (n, p)
        As for `torsion_influence`, of throws with any number of pins [m/N].
    through, crank_radius
        As for `torsion_influence`.

    Returns
    -------
    ndarray of shape (n, p)
        The second layer of the influence in `axial_throw_forces`. It is valid if the
        flywheel keeps its speed and the shaft is far below its torsional resonances.

    Notes
    -----
    A torque -R T at the flywheel's end cancels the reaction to T at the free end.
    """
    by_pins, through_shaft = (
        finite_array("tangential", tangential),
        finite_vector("through", through),
    )
    if by_pins.ndim != 2 or len(by_pins) != through_shaft.size:
        raise InputError(
            f"tangential: given an array of shape {by_pins.shape}; allowed is ({through_shaft.size}, p), "
            "because through has a value for each throw."
        )
    radius = positive_number("crank_radius", crank_radius, "m", "it is a length")
    return np.asarray(by_pins - radius * through_shaft[:, np.newaxis])


def axial_excitation_of_torsion(
    response: ForcedResponse,
    torsional: EngineChain,
    axial: EngineChain,
    compliances: ArrayLike,
    influence: ArrayLike,
) -> OrderExcitation:
    """Return the axial forces that the torques of a torsional vibration excite.

    Parameters
    ----------
    response : ForcedResponse
        Of the torsional chain, bounded everywhere.
    torsional, axial : EngineChain
        Of one engine.
    compliances : array_like of shape (n,)
        Axial compliance of each throw, as in the axial chain [m/N].
    influence : array_like of shape (n, n + 1)
        From `torsion_influence` [1/N].

    Returns
    -------
    OrderExcitation
        On the axial chain [N]; to be added to that of the radial forces.

    Raises
    ------
    InputError
        If chains, compliances and influence have different numbers of throws, or the response is
        unbounded somewhere.

    Notes
    -----
    One way only: the axial vibration does not act back on the torsional one. This reaction, and its
    shift of the frequencies, requires the whole crankshaft.
    """
    if np.any(response.unbounded):
        raise InputError(
            "response: given one that is unbounded at some orders and speeds; allowed is a damped one, "
            "because the torques of an unbounded one are unknown."
        )
    e = positive_vector("compliances", compliances, "m/N", "every throw yields under load")
    lengthening = finite_array("influence", influence)
    if lengthening.shape != (e.size, e.size + 1) or torsional.throws != e.size:
        raise InputError(
            f"influence: given an array of shape {lengthening.shape} for {torsional.throws} throws and "
            f"{e.size} compliances; allowed is (n, n + 1) for n of both, because a shaft of n throws has "
            "n + 1 parts between cranks and ends."
        )
    loads, pairs = elastic_loads(response), torsional.chain.connections
    first, last = torsional.throw_nodes[0], torsional.throw_nodes[-1]
    torques: ComplexArray = np.zeros((*loads.shape[:2], last - first + 2), dtype=np.complex128)
    # A crankshaft is a row of nodes; what else sits on a crank passes no torque along it.
    for place, left in enumerate(range(first - 1, last + 1)):
        if (left, left + 1) in pairs:
            torques[:, :, place] = loads[:, :, pairs.index((left, left + 1))]
    pressing = torques @ lengthening.T / e
    return pressing_excitation(response.orders, response.speeds, pressing, axial)


@frozen("orders", "speeds [rad/s]", "alone [N]", "in_shaft [N]", eq=False)
class AxialForceComparison:
    """Exciting axial force P of each throw by order and speed, by two methods.

    Parameters
    ----------
    alone : complex ndarray of shape (K, S, n)
        P_i = c_i Z_i / e_i: each throw loaded by its own pin alone [N].
    in_shaft : complex ndarray of shape (K, S, n)
        With the lengthening caused by all pin forces of the shaft [N].
    shapes : ndarray of shape (q, n + 1)
        Axial mode shapes at the sections for the modal forces; q may be 0.
    """

    orders: Array
    speeds: Array
    alone: ComplexArray
    in_shaft: ComplexArray
    shapes: Array

    @property
    def modal_alone(self) -> ComplexArray:
        """Work of the forces on each mode shape, single throws (K, S, q)."""
        return self._modal(self.alone)

    @property
    def modal_in_shaft(self) -> ComplexArray:
        """Work of the forces on each mode shape, neighbors included (K, S, q)."""
        return self._modal(self.in_shaft)

    @property
    def difference(self) -> Array:
        """Largest amplitude of the difference over the throws, relative to the largest in the shaft (K, S).

        Zero where no throw has a force of this order.
        """
        apart, most = (
            np.max(np.abs(forces), axis=2) for forces in (self.alone - self.in_shaft, self.in_shaft)
        )
        share: Array = np.divide(apart, most, out=np.zeros_like(most), where=most > 0.0)
        return share

    def columns(self, speed_index: int) -> dict[str, Array]:
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
        """Draw the exciting axial force of a throw by its main orders over the speed, by both methods.

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
        axes.set_ylabel("exciting axial force [kN]")
        write_title(axes, f"Exciting axial force of throw {throw}")
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
    """Find the exciting axial force of each throw by two methods.

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


@frozen(
    "shaft_angles_deg [deg]",
    "speed [rad/s]",
    "throws [N]",
    "held [N]",
    "thrust_bearing [N]",
    eq=False,
)
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

    shaft_angles_deg: Array
    speed: float
    throws: Array
    held: Array
    thrust_bearing: Array | None = None

    def curves(self) -> Diagram:
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
        return curve_diagram(
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
        draw_diagram(axes, self.curves())
        legend_below(axes, 2)
        write_title(axes, "Axial force over the cycle")
        return axes

    def columns(self) -> dict[str, Array]:
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
    thrust_bearing: Array | None = None,
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
