"""Thrust and torque of a propeller that vary with its blades, from data."""

from dataclasses import KW_ONLY
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    finite_array,
    finite_vector,
    nonnegative_vector,
    positive_number,
    turning_speeds,
)
from crankbase.choices import check_choice, check_one_each, whole_number
from crankbase.errors import InputError
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain, speed_ratios
from dynamics.indices import node_index
from dynamics.response.order_excitation import OrderExcitation, checked_speeds


@frozen(
    "blades",
    "rated_speed [rad/s]",
    "rated_thrust [N]",
    "rated_torque [N m]",
    "thrust_shares",
    "torque_shares",
    eq=False,
)
class PropellerForces:
    """Mean thrust and torque of a propeller, and their variation over a revolution.

    thrust = mean [1 + sum over q of a_q sin(q z theta + phase_q)], theta the propeller's angle,
    counted from its position at shaft angle zero; the torque likewise. Both means are
    proportional to the square of the propeller's speed from the rated point.

    Parameters
    ----------
    blades : int
        z, 2 or more.
    rated_speed : float
        Of the propeller, not of the engine [rad/s].
    rated_thrust : float
        Mean thrust there, ahead [N].
    rated_torque : float
        Mean torque there, taken from the shaft [N m].
    thrust_shares, torque_shares : array_like of shape (Q,)
        a_q for q = 1, 2 ...: amplitude of the blade order and its multiples as a share of the mean.
    thrust_phases_deg, torque_phases_deg : array_like of shape (Q,), optional
        [deg]; zero by default.

    Raises
    ------
    InputError
        If a number is out of its range, or shares and phases differ in length.

    Notes
    -----
    The shares depend on the wake behind the ship and have no usual values: take them from
    the propeller's design, model tests or the rules of the class that checks the shaft line.
    """

    blades: int
    rated_speed: float
    rated_thrust: float
    rated_torque: float
    thrust_shares: ArrayLike
    torque_shares: ArrayLike
    _: KW_ONLY
    thrust_phases_deg: ArrayLike | None = None
    torque_phases_deg: ArrayLike | None = None

    def __post_init__(self) -> None:
        whole_number("propeller_forces.blades", self.blades, 2, "one blade alone is out of balance")
        for name, unit in (
            ("rated_speed", "rad/s"),
            ("rated_thrust", "N"),
            ("rated_torque", "N m"),
        ):
            positive_number(
                f"propeller_forces.{name}", getattr(self, name), unit, "it drives the ship"
            )
        for kind in ("thrust", "torque"):
            shares = nonnegative_vector(
                f"propeller_forces.{kind}_shares",
                getattr(self, f"{kind}_shares"),
                "",
                "they are amplitudes",
            )
            phases = getattr(self, f"{kind}_phases_deg")
            phases = (
                np.zeros(shares.size)
                if phases is None
                else finite_vector(f"propeller_forces.{kind}_phases", phases)
            )
            check_one_each(f"propeller_forces.{kind}_phases", phases.size, shares.size, "shares")
            object.__setattr__(self, f"{kind}_shares", shares)
            object.__setattr__(self, f"{kind}_phases_deg", phases)

    def mean_thrust(self, speeds: ArrayLike) -> Array:
        """Return the mean thrust [N] at speeds of the propeller [rad/s]."""
        return self._law(speeds, self.rated_thrust)

    def mean_torque(self, speeds: ArrayLike) -> Array:
        """Return the mean torque taken from the shaft [N m] at speeds of the propeller [rad/s]."""
        return self._law(speeds, self.rated_torque)

    def _law(self, speeds: ArrayLike, rated: float) -> Array:
        return np.asarray(rated * (turning_speeds("speeds", speeds) / self.rated_speed) ** 2)


def propeller_excitation(
    propeller: PropellerForces,
    chain: Chain,
    node: int,
    speeds: ArrayLike,
    *,
    kind: Literal["torsional", "axial"],
    ratio: float | None = None,
) -> OrderExcitation:
    """Return the excitation by a propeller's varying torque or thrust.

    Parameters
    ----------
    chain : Chain
        Torsional or axial, with node 0 in the crankshaft.
    speeds : array_like of shape (S,)
        Of the crankshaft [rad/s], ascending.
    ratio : float, optional
        Speed of the propeller over that of the crankshaft, negative for the opposite sense.
        By default that of the node by the chain's gears. Required for an axial chain of a geared
        plant, and in a geared chain where only dashpots join the propeller to the crankshaft.

    Returns
    -------
    OrderExcitation
        Orders q z |ratio| per revolution of the crankshaft. The torque on the node acts against its
        rotation; the thrust acts towards the free end, the propeller being behind the flywheel.

    Raises
    ------
    InputError
        If the node does not exist, the ratio is zero or missing, speeds do not ascend, or the
        propeller has no harmonics of this kind.
    """
    place = node_index("propeller node", node, chain.inertia.size)
    running = checked_speeds(speeds)
    check_choice("kind", kind, ("torsional", "axial"), "a propeller has torque and thrust")
    if ratio is None:
        parts, ratios = speed_ratios(chain.connections, chain.gears, chain.inertia.size)
        if chain.gears and parts[place] != parts[0]:
            raise InputError(
                f"ratio: given none for {chain.names[place]}; allowed is its speed over that of the "
                "crankshaft, because gears and springs do not join the two, and the speed behind a dashpot "
                "follows from no ratio of gears."
            )
        ratio = ratios[place]
    turning = float(finite_array("ratio", ratio))
    if turning == 0.0:
        raise InputError(
            f"ratio: given {turning:g}; allowed is a finite number other than zero, because the "
            "propeller turns."
        )
    of_propeller = abs(turning) * running
    if kind == "axial":
        shares, phases = propeller.thrust_shares, propeller.thrust_phases_deg
        mean, sense = propeller.mean_thrust(of_propeller), -1.0
    else:
        shares, phases = propeller.torque_shares, propeller.torque_phases_deg
        mean, sense = propeller.mean_torque(of_propeller), -np.sign(turning)
    sizes = np.asarray(shares, dtype=np.float64)
    if sizes.size == 0:
        raise InputError(
            f"propeller: given no harmonics of its {'thrust' if kind == 'axial' else 'torque'}; allowed "
            "are one or more, because a steady one excites nothing."
        )
    # M sin(k x + a) is Re(-i M exp(i a) exp(i k x)); turning backwards conjugates it.
    turned: Array = np.radians(np.asarray(phases, dtype=np.float64))
    phasors: ComplexArray = -1j * sizes * np.exp(1j * turned)
    if turning < 0.0:
        phasors = phasors.conj()
    orders = propeller.blades * abs(turning) * np.arange(1.0, sizes.size + 1.0)
    forces = np.zeros((sizes.size, running.size, chain.inertia.size), dtype=np.complex128)
    forces[:, :, place] = sense * phasors[:, np.newaxis] * mean
    return OrderExcitation(orders, running, forces)
