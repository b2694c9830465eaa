"""Forced vibration of a chain, or of any linear system, by orders over a range of speeds."""

import math
from dataclasses import replace
from functools import cached_property
from typing import Unpack, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, ComplexArray, Flags
from crankbase.choices import check_choice, check_kind
from crankbase.errors import InputError, SolveError
from crankbase.frames import Axes, Dataset, grid
from crankbase.memory import check_memory
from crankbase.quantity import format_quantity
from crankbase.results import result
from dynamics.chains.chain import Chain
from dynamics.chains.varying import over_amplitude
from dynamics.plots.curves import (
    Quantity,
    infinite_where_unbounded,
    name_axis,
    orders_and_speeds,
    quantity_display,
)
from dynamics.response.harmonic import HarmonicResponse, Method, harmonic_response
from dynamics.response.linear_system import DampedChain, LinearSystem, chain_system
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.series import DrawnBeside, OrderSeries, Synthesis, synthesis

# Complex amplitudes of every order, speed, node and unknown are held so many times at once.
COPIES = 3.0
# Amplitudes that springs vary with are settled when they change by less than this share of theirs.
SETTLED, AMPLITUDE_STEPS = 1e-11, 300


@result("orders", "speeds [rad/s]", "amplitude", "names", "method")
class ForcedResponse:
    """Steady vibration by orders: the motion at the shaft angle phi is Re sum_k X_k exp(i k phi).

    Parameters
    ----------
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speeds : ndarray of shape (S,)
        [rad/s].
    motion : ndarray of shape (K, S, n), complex
        Amplitudes of the nodes [rad or m]; zero where the response is unbounded, so that sums
        stay finite: check `unbounded`, or use `amplitude`.
    unbounded : ndarray of shape (K, S), bool
        Where an undamped mode is excited within 1e-9 of its frequency: there is no steady motion.
    system : LinearSystem
        The system with all of its damping.
    chain : Chain or None
        The chain it was made from.
    unknowns : ndarray of shape (K, S, q), complex
        Amplitudes of the unknowns of the system; for a chain without gears those of the nodes.
    method : str
        Method used.
    """

    orders: Array
    speeds: Array
    motion: ComplexArray
    unbounded: Flags
    system: LinearSystem
    chain: Chain | None
    excitation: OrderExcitation
    unknowns: ComplexArray
    method: str

    @property
    def angular_frequencies(self) -> Array:
        """Angular frequency of each order at each speed [rad/s], (K, S)."""
        return np.outer(self.orders, self.speeds)

    @cached_property
    def amplitude(self) -> Array:
        """Amplitude of each node by order and speed [rad or m], (K, S, n); inf where unbounded."""
        return self.nodes.amplitude

    @cached_property
    def nodes(self) -> OrderSeries:
        """The motion as a series by orders, to be summed over the cycle."""
        return self._series(self.motion)

    @cached_property
    def elastic(self) -> OrderSeries:
        """The motion without rigid-body motion, which causes no strain."""
        rigid = self.system.shapes[:, : self.system.rigid.shape[1]]
        without = self.unknowns - (self.unknowns @ (self.system.mass @ rigid)) @ rigid.T
        return self._series(without @ self.system.expand.T)

    @property
    def synthesis(self) -> Synthesis:
        """Motion of each node, all orders together, and their plain sum, (S, n) each."""
        return self.nodes.synthesis

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the nodes or points, (n,)."""
        if self.chain is not None:
            return self.chain.names
        return tuple(f"point {number}" for number in range(self.motion.shape[2]))

    def _series(self, values: ComplexArray) -> OrderSeries:
        return OrderSeries(self.orders, self.speeds, values, self.unbounded, self.names)

    def plot(
        self,
        axes: Axes | None = None,
        node: int | str = 0,
        *,
        quantity: Quantity | None = None,
        elastic: bool = True,
        **drawn: Unpack[DrawnBeside],
    ) -> Axes:
        """Draw one node's main orders, their synthesis and their plain sum over the speed.

        Parameters
        ----------
        node : int or str, optional
            By number from 0 or name.
        quantity
            As for `quantity_display`.
        elastic : bool, optional
            Whether rigid-body motion, which causes no strain, is left out.
        **drawn
            As `DrawnBeside` says: limits, barred, main_orders.

        Returns
        -------
        matplotlib.axes.Axes
            Curves have gaps where the vibration is unbounded, with a vertical line there.

        Raises
        ------
        InputError
            If the node or the quantity is unknown, or a limit, range or number is invalid.
        """
        series = self.elastic if elastic else self.nodes
        return series.draw(axes, node, quantity_display(quantity, "rad or m"), "node", **drawn)

    def to_xarray(self, quantity: Quantity | None = None) -> Dataset:
        """Return complex ``motion``, ``elastic`` and ``unbounded`` over order, speed and node.

        `quantity`, for the unit of the axis, is that of `quantity_display`.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
            Motion is infinite where it is unbounded; ``elastic`` is without rigid-body motion.
        """
        unit = quantity_display(quantity, "rad or m").unit
        over = ("order", "speed", "node")
        whole, elastic = (
            infinite_where_unbounded(values, self.unbounded)
            for values in (self.motion, self.elastic.values)
        )
        return grid(
            {
                "motion": (over, whole, unit, "phasor of the motion"),
                "elastic": (over, elastic, unit, "phasor of the motion less the rigid body's"),
                "unbounded": (("order", "speed"), self.unbounded, "1", "no steady vibration"),
            },
            {**orders_and_speeds(self.orders, self.speeds), "node": name_axis(self.names, "node")},
        )


def forced_response(
    chain_or_system: Chain | LinearSystem | DampedChain,
    excitation: OrderExcitation,
    *,
    magnifier: float | None = None,
    modal_damping: ArrayLike | None = None,
    method: Method = "modal",
) -> ForcedResponse:
    """Find the steady vibration under forces given by orders, at all speeds at once.

    Parameters
    ----------
    chain_or_system : Chain, LinearSystem or DampedChain
        With its own damping; without any, resonances are unbounded. `damped` adds
        damping of any kind to a chain.
    excitation : OrderExcitation
        Forces on the nodes of the chain, or the points of the system.
    magnifier : float, optional
        Adds to each elastic mode the damping of this magnifier, 1 / (2 magnifier) of critical.
    modal_damping : float or array_like, optional
        Adds to each elastic mode this share of critical damping; one for all, or one for each.
    method : {"modal", "direct"}
        By damped modes, checked, with the other method as fallback; or by solving with the complex
        dynamic stiffness at each order and speed.

    Raises
    ------
    NotEnoughMemoryError
        If the amplitudes do not fit into the free memory.
    InputError
        If the excitation has another number of nodes, both magnifier and modal damping are given,
        or one of them is out of range.
    """
    check_kind("excitation", excitation, OrderExcitation, "an OrderExcitation")
    chain, system = chain_and_system(chain_or_system)
    system = system.with_added_damping(magnifier, modal_damping)
    nodes = len(system.expand)
    if excitation.forces.shape[2] != nodes:
        raise InputError(
            f"excitation: given forces on {excitation.forces.shape[2]} nodes; allowed is one on each "
            f"of {nodes}, because the system has so many."
        )
    pressing = excitation.pressing
    if chain is not None and pressing is not None and pressing.shape[2] != len(chain.elements):
        raise InputError(
            f"excitation: given the pressing of {pressing.shape[2]} elements; allowed is that of each of "
            f"{len(chain.elements)}, because the chain has so many."
        )
    shape = excitation.forces.shape[:2]
    check_memory(
        COPIES * 16.0 * math.prod(shape) * (nodes + len(system.mass)),
        f"excitation: given {shape[0]} orders at {shape[1]} speeds on {nodes} nodes, whose "
        "amplitudes take",
        "ask for fewer orders or speeds",
    )
    # Mostly the unknowns are the nodes, and multiplying with ones and zeros would take its time.
    plain = np.array_equal(system.expand, np.eye(nodes))
    forces = excitation.forces.reshape(-1, nodes)
    forces = forces if plain else forces @ system.expand
    speeds = np.tile(excitation.speeds, shape[0])
    frequencies = excitation.angular_frequencies.reshape(-1)
    check_choice("method", method, get_args(Method), "these are the ways to solve the equations")
    answer, system = _settled(system, excitation, frequencies, forces, method, speeds)
    if chain is not None and any(over_amplitude(spring.law) for spring in chain.varying):
        pairs = zip(chain.varying, system.varying, strict=True)
        chain = replace(
            chain, varying=tuple(replace(spring, law=known.law) for spring, known in pairs)
        )
    motion = answer.motion if plain else answer.motion @ system.expand.T
    return ForcedResponse(
        orders=excitation.orders,
        speeds=excitation.speeds,
        motion=motion.reshape(*shape, nodes),
        unbounded=answer.unbounded.reshape(shape),
        system=system,
        chain=chain,
        excitation=excitation,
        unknowns=answer.motion.reshape(*shape, -1),
        method=(
            f"{method}; {answer.directly} of {answer.unbounded.size} by the dynamic stiffness itself"
        ),
    )


def _settled(
    system: LinearSystem,
    excitation: OrderExcitation,
    frequencies: Array,
    forces: ComplexArray,
    method: Method,
    speeds: Array,
) -> tuple[HarmonicResponse, LinearSystem]:
    """Return the response, and the system whose springs know the amplitudes that they reach.

    At each speed amplitudes are put in the place of those before, in smaller steps where they do not
    come closer, until they stay.
    """
    asked = {k: spring.law for k, spring in enumerate(system.varying) if over_amplitude(spring.law)}
    if not asked:
        return harmonic_response(system, frequencies, forces, method, speeds), system
    order = np.argsort(excitation.speeds)
    known = np.zeros((len(asked), excitation.speeds.size))
    step, last = np.ones(excitation.speeds.size), np.full(excitation.speeds.size, np.inf)
    rows = np.array([system.varying[k].row for k in asked])
    for _ in range(AMPLITUDE_STEPS):
        springs = list(system.varying)
        for (k, law), amplitude in zip(asked.items(), known, strict=True):
            at_speeds = law.at_amplitude(excitation.speeds[order], amplitude[order])
            springs[k] = replace(springs[k], law=at_speeds)
        settled = replace(system, varying=tuple(springs))
        answer = harmonic_response(settled, frequencies, forces, method, speeds)
        twists = (answer.motion @ rows.T).reshape(*excitation.forces.shape[:2], -1)
        reached = synthesis(excitation.orders, excitation.speeds, twists).amplitude.T
        change = np.max(np.abs(reached - known), axis=0)
        if np.all(change <= SETTLED * np.max(reached, axis=0)):
            return answer, settled
        step = np.where(change >= last, 0.5 * step, step)
        known, last = known + step * (reached - known), change
    left = format_quantity(float(excitation.speeds[int(np.argmax(change))]), "rad/s")
    raise SolveError(
        f"The amplitude that a spring varies with does not settle in {AMPLITUDE_STEPS} steps, at {left} and "
        "elsewhere; give its stiffness at more amplitudes, or more damping."
    )


def chain_and_system(
    vibrating: Chain | LinearSystem | DampedChain,
) -> tuple[Chain | None, LinearSystem]:
    """Return the chain, if there is one, and the system for the calculation."""
    if isinstance(vibrating, LinearSystem):
        return None, vibrating
    if isinstance(vibrating, DampedChain):
        return vibrating.chain, vibrating.system
    check_kind("chain_or_system", vibrating, Chain, "a Chain, or what damped returns")
    return vibrating, chain_system(vibrating)
