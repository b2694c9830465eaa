"""Axial forces excited by torque in the shaft: throws tilted by their neighbors lengthen."""

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import (
    ComplexArray,
    FloatArray,
    finite_array,
    finite_vector,
    positive_number,
    positive_vector,
)
from crankbase.errors import InputError
from dynamics.chains.engine_chains import EngineChain
from dynamics.excitation.chain_excitation import axial_section_forces
from dynamics.response.forced import ForcedResponse
from dynamics.response.loads import elastic_loads
from dynamics.response.order_excitation import OrderExcitation


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

    Raises
    ------
    InputError
        If shapes do not fit.

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

    Raises
    ------
    InputError
        If shapes do not fit.

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
    found = np.zeros((*torques.shape[:2], last - first + 2), dtype=np.complex128)
    # A crankshaft is a row of nodes; what else sits on a crank passes no torque along it.
    for place, left in enumerate(range(first - 1, last + 1)):
        if (left, left + 1) in pairs:
            found[:, :, place] = torques[:, :, pairs.index((left, left + 1))]
    return found
