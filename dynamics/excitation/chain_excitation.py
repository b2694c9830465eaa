"""Forces of the cylinders as excitation of an engine's chains: torques, and axial forces of throws."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    finite_array,
    finite_vector,
    positive_number,
    positive_vector,
)
from crankbase.choices import is_whole
from crankbase.errors import InputError
from dynamics.chains.engine_chains import EngineChain
from dynamics.excitation.cylinders import CylinderForces, CylinderHarmonics
from dynamics.excitation.pressure_map import Load
from dynamics.response.forced import ForcedResponse
from dynamics.response.loads import elastic_loads
from dynamics.response.order_excitation import OrderExcitation


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
    torques = _summed_at_nodes(forces.torque, nodes, engine_chain.chain.inertia.size)
    return OrderExcitation(forces.orders, forces.speeds, torques)


def node_torques(
    harmonics: CylinderHarmonics,
    engine_chain: "EngineChain",
    speed: float | ArrayLike,
    load: Load | None = None,
    *,
    shaft_angle_deg: ArrayLike,
) -> FloatArray:
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
    radial_and_tangential = _influence(influence, forces, e.size, pins)
    acting = np.stack((forces.radial, forces.tangential), axis=-1)
    lengthening = np.einsum("ncx,kscx->ksn", radial_and_tangential, acting)
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
    return OrderExcitation(
        forces.orders, forces.speeds, axial_section_forces(pressing, engine_chain)
    )


def axial_section_forces(pressing: ComplexArray, engine_chain: "EngineChain") -> ComplexArray:
    """Return the forces on the nodes of an axial chain from those that push throws' ends apart.

    Parameters
    ----------
    pressing : complex ndarray of shape (K, S, n)
        P of each throw [N].

    Returns
    -------
    complex ndarray of shape (K, S, nodes)
        -P on the section before each throw, +P on that after it [N].
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
    count = engine_chain.chain.inertia.size
    return _summed_at_nodes(pressing, sections[1:], count) - _summed_at_nodes(
        pressing, sections[:-1], count
    )


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


def _summed_at_nodes(
    values: ComplexArray, nodes: "tuple[int, ...] | list[int]", n: int
) -> ComplexArray:
    """Return values (K, S, c) summed at the nodes where they act (K, S, n)."""
    sums = np.zeros((*values.shape[:2], n), dtype=np.complex128)
    for place, node in enumerate(nodes):
        sums[:, :, node] += values[:, :, place]
    return sums


def _influence(
    influence: ArrayLike, forces: CylinderForces, throws: int, pins: ArrayLike | None
) -> FloatArray:
    """Return the lengthening of each throw per Z and T of each cylinder (n, c, 2)."""
    lengthening = finite_array("influence", influence)
    if lengthening.shape == (throws,):
        lengthening = np.diag(lengthening)
    if lengthening.ndim == 2:
        lengthening = np.stack((lengthening, np.zeros_like(lengthening)), axis=-1)
    on_pins = np.array(forces.throws) if pins is None else _pins(pins, len(forces.throws))
    if (
        lengthening.ndim != 3
        or lengthening.shape[::2] != (throws, 2)
        or lengthening.shape[1] != on_pins.max() + 1
    ):
        raise InputError(
            f"influence: given an array of shape {np.shape(influence)}; allowed is ({throws},), "
            f"({throws}, {on_pins.max() + 1}) or ({throws}, {on_pins.max() + 1}, 2), because it has a row "
            "for each throw and a column for each pin."
        )
    return np.asarray(lengthening[:, on_pins])


def _pins(pins: ArrayLike, cylinders: int) -> NDArray[np.int64]:
    places = list(np.asarray(pins).ravel())
    if len(places) != cylinders or not all(is_whole(pin) and pin >= 0 for pin in places):
        raise InputError(
            f"pins: given {places}; allowed is a whole number from 0 for each of the {cylinders} "
            "cylinders, because its rod sits on one pin."
        )
    return np.array(places, dtype=np.int64)


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
    if not excitations:
        raise InputError(
            "excitations: given none; allowed are one or more, because they are added up."
        )
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
    forces = np.zeros((orders.size, *first.forces.shape[1:]), dtype=np.complex128)
    for excitation in excitations:
        places = np.argmin(np.abs(orders[:, np.newaxis] - excitation.orders), axis=0)
        np.add.at(forces, places, excitation.forces)
    return OrderExcitation(orders, first.speeds, forces)


def torsion_influence(tangential: ArrayLike, through: ArrayLike, crank_radius: float) -> FloatArray:
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
) -> FloatArray:
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
    torques = _torque_of_parts(elastic_loads(response), torsional)
    pressing = torques @ lengthening.T / e
    return OrderExcitation(response.orders, response.speeds, axial_section_forces(pressing, axial))


def _torque_of_parts(torques: ComplexArray, torsional: EngineChain) -> ComplexArray:
    """Return the torque of each part of the crankshaft (K, S, n + 1), zero where there is none."""
    first, last = torsional.throw_nodes[0], torsional.throw_nodes[-1]
    pairs = torsional.chain.connections
    parts = np.zeros((*torques.shape[:2], last - first + 2), dtype=np.complex128)
    # A crankshaft is a row of nodes; what else sits on a crank passes no torque along it.
    for place, left in enumerate(range(first - 1, last + 1)):
        if (left, left + 1) in pairs:
            parts[:, :, place] = torques[:, :, pairs.index((left, left + 1))]
    return parts
