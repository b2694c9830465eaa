"""A rotating torsional chain with its rods and pistons: the full equations of motion and their state."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, Unpack, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    ComplexArray,
    FloatArray,
    check_shape,
    finite_array,
    turning_speeds,
)
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.engine_chains import EngineChain, cylinder_inertia
from dynamics.engine import RodModelName
from dynamics.engine.forces import rod_models
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.cylinders import CylinderForces
from dynamics.indices import node_index
from dynamics.response.order_excitation import checked_speed_index
from dynamics.transient.applied_forces import cycle_turns
from dynamics.transient.propagator import ViscousDamping, ViscousSystem, viscous_system
from dynamics.turning.shaft_moments import TurnCurves, turn_curves

# Harmonics of the inertia below this share of its mean are left out.
NEGLIGIBLE = 1e-14


@dataclass(frozen=True, eq=False)
class ThrowCurves:
    """Curves of t throws, each over its own angle: y = mean + Re sum of a_k exp(i k theta).

    Parameters
    ----------
    orders : ndarray of shape (K,)
        k, those of inertia and torque together.
    inertia_mean : ndarray of shape (t,)
        Of rods and pistons [kg m^2].
    inertia : complex ndarray of shape (t, K)
        Its harmonics.
    torque_mean : ndarray of shape (t,)
        Of the gas [N m].
    torque : complex ndarray of shape (t, K)
        Its harmonics.
    """

    orders: FloatArray
    inertia_mean: FloatArray
    inertia: ComplexArray
    torque_mean: FloatArray
    torque: ComplexArray

    def at(self, angles: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return inertia, its derivative by the angle, and torque at angles (c, t), each of that shape."""
        table = self._table
        # Waves of all orders by repeated multiplication: it costs a tenth of exponentials.
        waves = np.empty((*angles.shape, table.shape[1]), dtype=np.complex128)
        waves[...] = np.exp(1j * self._step * angles)[..., np.newaxis]
        waves = np.cumprod(waves, axis=-1)
        curves = np.matmul(waves.swapaxes(0, 1), table).real
        inertia = self.inertia_mean + curves[..., 0].T
        return inertia, curves[..., 1].T, self.torque_mean + curves[..., 2].T

    @cached_property
    def _step(self) -> float:
        """Order of which all orders are multiples."""
        return 1.0 / cycle_turns(self.orders) if self.orders.size else 1.0

    @cached_property
    def _table(self) -> ComplexArray:
        """Harmonics of inertia, its derivative and torque at all multiples of the step, (t, N, 3)."""
        places = np.round(self.orders / self._step).astype(int) - 1
        count = int(places.max(initial=0)) + 1
        table = np.zeros((self.inertia_mean.size, count, 3), dtype=np.complex128)
        table[:, places, 0] = self.inertia
        table[:, places, 1] = 1j * self.orders * self.inertia
        table[:, places, 2] = self.torque
        return table

    def with_constant_inertia(self) -> "ThrowCurves":
        """Return the same with the inertia at its mean."""
        return replace(self, inertia=np.zeros_like(self.inertia))


def throw_inertia_curves(
    engine: EngineLayout, throws: Sequence[int], model: RodModelName = "rigid"
) -> TurnCurves:
    """Return the inertia of rods and pistons on each throw over its angle, as series.

    Parameters
    ----------
    throws : sequence of n int
        Throw of each cylinder, from 0.
    model : str, optional
        Of the rods.
    """
    models = rod_models(engine, model)

    def sampled(angles: FloatArray) -> FloatArray:
        inertia = np.zeros((max(throws) + 1, angles.size))
        for place, (throw, rod) in enumerate(zip(throws, models, strict=True)):
            inertia[throw] += cylinder_inertia(engine, place + 1, rod, angles)
        return inertia

    return turn_curves(sampled)


def throw_curves(
    engine: EngineLayout, forces: CylinderForces, speed_index: int, model: RodModelName = "rigid"
) -> ThrowCurves:
    """Return the curves of an engine's throws from its gas forces at one of their speeds."""
    inertias = throw_inertia_curves(engine, forces.throws, model)
    largest = np.max(
        np.abs(inertias.coefficients) / inertias.mean[:, np.newaxis], axis=0, initial=0.0
    )
    kept = np.flatnonzero(largest > NEGLIGIBLE)
    throws = inertias.mean.size
    mean, phasors = np.zeros(throws), np.zeros((forces.orders.size, throws), dtype=np.complex128)
    for cylinder, throw in enumerate(forces.throws):
        mean[throw] += forces.crank_radius * forces.mean_tangential[speed_index, cylinder]
        phasors[:, throw] += forces.torque[:, speed_index, cylinder]
    of_inertia = np.asarray(kept + 1.0, dtype=np.float64)
    orders = np.union1d(of_inertia, forces.orders)
    return ThrowCurves(
        orders,
        inertias.mean,
        _placed(inertias.coefficients[:, kept], of_inertia, orders),
        mean,
        _placed(phasors.T, forces.orders, orders),
    )


def _placed(values: ComplexArray, orders: FloatArray, among: FloatArray) -> ComplexArray:
    placed = np.zeros((len(values), among.size), dtype=np.complex128)
    placed[:, np.searchsorted(among, orders)] = values
    return placed


# Ratios of speeds count as one within this; damping against even turning as none.
EVEN = 1e-9
# Torques count as large from this share of twice the kinetic energy on, even where none act.
LEAST_SIZE = 1e-8

# What is no number is given on without a warning; an integrator shortens its step then.
_GIVEN_ON = np.errstate(invalid="ignore", over="ignore")


@summarized("throws", "even", "load")
@dataclass(frozen=True, eq=False)
class TurningChain:
    """Matrices and curves of M(theta) theta'' + ... = torques, on the q unknowns of a chain.

    Parameters
    ----------
    system : ViscousSystem
        The chain of constant inertia.
    curves : ThrowCurves
        Of its t throws.
    throws : ndarray of shape (t, q)
        Angle of each throw per unknown.
    constant_mass : ndarray of shape (q, q)
        Inertia without rods and pistons [kg m^2].
    relative_damping, ground_damping : ndarray of shape (q, q)
        [N m s/rad]
    even : ndarray of shape (q,)
        Uniform rotation: motion of the unknowns per shaft angle.
    load : ndarray of shape (q,)
        Braking torques on the unknowns per torque of the load.
    """

    system: ViscousSystem
    curves: ThrowCurves
    throws: FloatArray
    constant_mass: FloatArray
    relative_damping: FloatArray
    ground_damping: FloatArray
    even: FloatArray
    load: FloatArray

    @cached_property
    def separate(self) -> bool:
        """Whether each unknown has its own inertia, without coupling inertias."""
        diagonal = np.array_equal(self.constant_mass, np.diag(np.diag(self.constant_mass)))
        return diagonal and bool(np.all((self.throws == 0.0) | (self.throws == 1.0)))

    @cached_property
    def momentum(self) -> FloatArray:
        """Share of each unknown's speed in the mean speed, (q,)."""
        momentum = self.mean_mass @ self.even
        return np.asarray(momentum / (self.even @ momentum))

    @property
    def stiffness(self) -> FloatArray:
        """K (q, q) [N m/rad]."""
        return self.system.system.stiffness

    @property
    def mean_mass(self) -> FloatArray:
        """The inertia with rods and pistons at their means (q, q) [kg m^2]."""
        return self.system.system.mass

    @property
    def expand(self) -> FloatArray:
        """Motion of the nodes per unknown, (n, q)."""
        return self.system.system.expand

    def with_constant_inertia(self) -> "TurningChain":
        """Return the same chain with the inertia of rods and pistons at its mean."""
        return replace(self, curves=self.curves.with_constant_inertia())

    def mean_speed(self, speeds: FloatArray) -> FloatArray:
        """Return the shaft speed of even turning with the same angular momentum, (...) of (..., q).

        Raises
        ------
        InputError
            If a speed is not finite, or there is not one for each unknown.
        """
        motion = finite_array("speeds", speeds)
        if motion.shape[-1:] != self.even.shape:
            raise InputError(
                f"speeds: given an array of shape {motion.shape}; allowed are {self.even.size} in its last "
                "dimension, because each unknown has its own."
            )
        return np.asarray(motion @ self.momentum)

    @_GIVEN_ON
    def torques(
        self, twist: FloatArray, speeds: FloatArray, even_turning: FloatArray, reference: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the torques of springs, dampers and gas on the unknowns, and the inertia terms.

        Parameters
        ----------
        twist : ndarray of shape (c, q)
            Unknowns minus uniform rotation [rad], of c copies of the chain.
        speeds : ndarray of shape (c, q)
            [rad/s]
        even_turning : ndarray of shape (c,)
            Of the shaft, relative to which the twist is counted [rad].
        reference : ndarray of shape (c,)
            Shaft speed of the dampers to ground [rad/s].

        Returns
        -------
        springs, dampers, gas : ndarray of shape (c, q)
            [N m]
        inertia : ndarray of shape (c, t, 2)
            Inertia of rods and pistons on each throw [kg m^2], and the braking torque by its
            change, I' w^2 / 2 [N m].

        Raises
        ------
        InputError
            If an array has another shape.
        """
        self._check_shapes(twist, speeds, even_turning)
        check_shape("reference", reference, even_turning.shape)
        at_throws = (even_turning[:, np.newaxis] * self.even + twist) @ self.throws.T
        inertia, slope, torque = self.curves.at(at_throws)
        springs = -twist @ self.stiffness
        vibrating = speeds - reference[:, np.newaxis] * self.even
        dampers = -speeds @ self.relative_damping - vibrating @ self.ground_damping
        changing = 0.5 * slope * (speeds @ self.throws.T) ** 2
        return springs, dampers, torque @ self.throws, np.stack((inertia, changing), axis=-1)

    @_GIVEN_ON
    def accelerations(self, torques: FloatArray, inertia: FloatArray) -> FloatArray:
        """Return the accelerations (c, q) under torques (c, q); inertia as from `torques`.

        Raises
        ------
        InputError
            If an array has another shape.
        """
        count, (throws, unknowns) = len(torques), self.throws.shape
        check_shape("torques", torques, (count, unknowns))
        check_shape("inertia", inertia, (count, throws, 2))
        moments = torques - inertia[..., 1] @ self.throws
        if self.separate:
            return np.asarray(
                moments / (np.diag(self.constant_mass) + inertia[..., 0] @ self.throws)
            )
        mass = self.constant_mass + np.einsum(
            "ct,tp,tq->cpq", inertia[..., 0], self.throws, self.throws
        )
        return np.asarray(np.linalg.solve(mass, moments[..., np.newaxis])[..., 0])

    @_GIVEN_ON
    def energies(
        self, twist: FloatArray, speeds: FloatArray, even_turning: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return kinetic and strain energy (c,) [J]; arguments and errors as for `torques`."""
        self._check_shapes(twist, speeds, even_turning)
        inertia, _, _ = self.curves.at(
            (even_turning[:, np.newaxis] * self.even + twist) @ self.throws.T
        )
        kinetic = np.sum(speeds @ self.constant_mass * speeds, axis=1)
        kinetic += np.sum(inertia * (speeds @ self.throws.T) ** 2, axis=1)
        return 0.5 * kinetic, 0.5 * np.sum(twist @ self.stiffness * twist, axis=1)

    def _check_shapes(self, twist: FloatArray, speeds: FloatArray, even: FloatArray) -> None:
        count = np.size(even)
        check_shape("even_turning", even, (count,))
        for name, values in (("twist", twist), ("speeds", speeds)):
            check_shape(name, values, (count, self.even.size))

    def torque_size(self, speed: float) -> float:
        """Return the order of magnitude of the torques on one throw at a shaft speed [rad/s], in N m.

        Raises
        ------
        InputError
            If the speed is not a finite number, or unrealistically high.
        """
        speed = float(turning_speeds("speed", speed))
        curves = self.curves
        gas = np.abs(curves.torque_mean) + np.sum(np.abs(curves.torque), axis=1)
        changing = 0.5 * speed**2 * np.sum(np.abs(curves.inertia) * curves.orders, axis=1)
        least = LEAST_SIZE * speed**2 * float(self.even @ self.mean_mass @ self.even)
        return float(np.max(gas + changing)) + least


def turning_chain(
    engine: EngineLayout,
    engine_chain: EngineChain,
    gas: CylinderForces,
    *,
    speed_index: int = 0,
    load_node: int | None = None,
    model: RodModelName = "rigid",
    **damping: Unpack[ViscousDamping],
) -> TurningChain:
    """Put the variable inertia of rods and pistons, and the gas, on the throws of a torsional chain.

    Parameters
    ----------
    engine_chain : EngineChain
        Torsional, not held by ground stiffness. The inertia of each throw in it includes shaft,
        rods and pistons: the mean inertia of rods and pistons is subtracted and replaced by the exact
        one over the throw's own angle.
    gas : CylinderForces
        From `cylinder_forces(..., inertia=False)`: inertia forces follow from the equations here.
        Torques are functions of the throw's own angle.
    speed_index : int, optional
        Which of its speeds, from 0.
    load_node : int, optional
        Node where the load brakes, from 0; by default the last node.
    model : str, optional
        Of the rods, one of `ROD_MODELS`.
    **damping
        loss_as, loss_frequency, magnifier, modal_damping, as for `viscous_system`. Absolute damping
        of the chain acts on the vibration only: its dampers turn with the mean speed.

    Raises
    ------
    InputError
        If the chain is not torsional or is held to ground, its throws differ in number or turn at
        different speeds, a throw has no inertia left, or something else is out of range.

    Notes
    -----
    With absolute angles theta of the unknowns, I_i the inertia of rods and pistons on throw i, and
    M_0 the rest of the chain's inertia, Lagrange's equations of the energy
    (theta' M_0 theta' + sum of I_i(theta_i) theta_i'^2) / 2 are M_0 theta'' + sum over the throws of
    (I_i theta_i'' + I_i' theta_i'^2 / 2) = torques of springs, dampers, gas and load.
    """
    chain = engine_chain.chain
    if engine_chain.kind != "torsional" or np.any(chain.ground):
        raise InputError(
            f"engine_chain: given {engine_chain.kind}"
            f"{', held to ground' if np.any(chain.ground) else ''}; allowed is a torsional chain that "
            "turns freely, because the angles are those of the turning shaft."
        )
    if len(engine_chain.throw_nodes) != gas.throw_count:
        raise InputError(
            f"engine_chain: given {len(engine_chain.throw_nodes)} throws; allowed are "
            f"{gas.throw_count}, because that many carry cylinders."
        )
    if gas.of_inertia:
        raise InputError(
            "gas: given forces that hold those of moving masses; allowed is cylinder_forces with "
            "inertia=False, because the varying inertia includes them."
        )
    place = checked_speed_index(speed_index, gas.speeds)
    last = chain.inertia.size - 1
    node = last if load_node is None else node_index("load_node", load_node, last + 1)
    curves = throw_curves(engine, gas, place, model)
    return assemble_turning_chain(
        viscous_system(chain, **damping), curves, engine_chain.throw_nodes, node
    )


def assemble_turning_chain(
    system: ViscousSystem, curves: ThrowCurves, nodes: ArrayLike, load_node: int
) -> TurningChain:
    """Assemble the turning chain with curves on given nodes (t,)."""
    chain, linear = system.chain, system.system
    assert chain is not None
    if linear.natural.size == linear.rigid.shape[1]:
        raise InputError(
            "engine_chain: given a chain without springs; allowed are one or more, because the nodes "
            "vibrate against each other."
        )
    expand = linear.expand
    throws = expand[np.asarray(nodes)]
    ground = expand.T @ (chain.ground_damping[:, np.newaxis] * expand)
    relative = linear.damping - ground
    even = _even_turning(linear.rigid, relative)
    even = even / (throws[0] @ even)
    if np.any(np.abs(throws @ even - 1.0) > EVEN):
        raise InputError(
            f"engine_chain: given throws that turn {(throws @ even).round(6).tolist()} times as fast as "
            "the first; allowed are equal speeds, because they are parts of one crankshaft."
        )
    constant = linear.mass - throws.T @ (curves.inertia_mean[:, np.newaxis] * throws)
    left = chain.inertia[np.asarray(nodes)] - curves.inertia_mean
    if np.any(left <= 0.0):
        throw = int(np.argmin(left))
        raise InputError(
            f"engine_chain: given {chain.inertia[np.asarray(nodes)][throw]:g} kg m^2 at throw {throw}; "
            f"allowed is more than {curves.inertia_mean[throw]:g} kg m^2, because rods and pistons alone "
            "have that on average."
        )
    return TurningChain(
        system, curves, throws, constant, relative, ground, even, expand[load_node].copy()
    )


def _even_turning(rigid: FloatArray, relative: FloatArray) -> FloatArray:
    """Return the motion that neither springs nor relative damping resist, (q,)."""
    if rigid.shape[1] == 1:
        return rigid[:, 0]
    values, vectors = np.linalg.eigh(rigid.T @ relative @ rigid)
    if values[0] > EVEN * values[-1]:
        raise InputError(
            "engine_chain: given parts that dashpots hold back from turning together; allowed are "
            "parts whose speeds the dashpots join are equal, because the shaft turns steadily."
        )
    return np.asarray(rigid @ vectors[:, 0])


IntegrationMethod = Literal["DOP853", "Radau"]
# Relative tolerance of the integration; absolute ones are this share of the sizes of the states.
TOLERANCE = 1e-9
WORKS = 3
# The first step, in radians of the highest natural frequency.
FIRST_STEP = 0.1


@dataclass(frozen=True, eq=False)
class TurningState:
    """Columns of a state array (c, 2 q + 4) of c copies of a chain, relative to uniform rotation.

    They are twist, its speed, works of gas, load and dampers, and the integral over time of the
    shaft's part of the twist.

    Parameters
    ----------
    frame : float
        Speed of the uniform rotation that twists are counted from [rad/s].
    holds : bool
        Whether dampers to ground turn at that speed, or at the current mean speed.
    load : callable
        Shaft speeds (c,) [rad/s] and time [s] to the braking moments (c,) [N m].
    typical_speed : float
        Of the shaft, for the scale of torques and motions [rad/s].
    """

    chain: TurningChain
    frame: float
    holds: bool
    load: Callable[[FloatArray, float], FloatArray]
    typical_speed: float

    @property
    def size(self) -> int:
        """Number of columns."""
        return 2 * self.chain.even.size + WORKS + 1

    @cached_property
    def sizes(self) -> FloatArray:
        """Scale of each column, (2 q + 4,)."""
        chain = self.chain
        rigid = chain.system.system.rigid.shape[1]
        lowest = float(chain.system.system.natural[rigid])
        torque = chain.torque_size(self.typical_speed)
        twist = torque / float(np.max(np.diag(chain.stiffness)))
        count = chain.even.size
        return np.concatenate(
            (
                np.full(count, twist),
                np.full(count, twist * lowest),
                np.full(WORKS, torque),
                [twist / lowest],
            )
        )

    def slope(self, time: float, states: FloatArray) -> FloatArray:
        """Return the derivative by time of states (c, 2 q + 4)."""
        chain, count = self.chain, self.chain.even.size
        twist, vibration = states[:, :count], states[:, count : 2 * count]
        speeds = vibration + self.frame * chain.even
        mean = speeds @ chain.momentum
        reference = np.full(mean.shape, self.frame) if self.holds else mean
        angles = np.full(mean.shape, self.frame * time)
        springs, dampers, gas, inertia = chain.torques(twist, speeds, angles, reference)
        load = -self.load(mean, time)[:, np.newaxis] * chain.load
        slopes = np.empty_like(states)
        slopes[:, :count] = vibration
        slopes[:, count : 2 * count] = chain.accelerations(springs + dampers + gas + load, inertia)
        for place, torques in enumerate((gas, load, dampers), start=2 * count):
            slopes[:, place] = np.sum(torques * speeds, axis=1)
        slopes[:, -1] = twist @ chain.momentum
        return slopes

    def integrate(
        self,
        states: FloatArray,
        span: tuple[float, float],
        method: IntegrationMethod,
        evaluated: Callable[[float], None],
        **options: Any,
    ) -> Any:
        """Integrate states (c, 2 q + 4) over a span of time [s] and return what `solve_ivp` does.

        At each evaluation `evaluated` is called with the time.
        """
        from scipy.integrate import solve_ivp

        shape = states.shape
        # Left to itself, the integrator tries a first step that is far too long for even turning.
        first = FIRST_STEP / float(self.chain.system.system.natural[-1])

        def flat(time: float, values: FloatArray) -> FloatArray:
            evaluated(time)
            return self.slope(time, values.reshape(shape)).reshape(-1)

        return solve_ivp(
            flat,
            span,
            states.reshape(-1),
            method=method,
            first_step=min(first, span[1] - span[0]),
            rtol=TOLERANCE,
            atol=TOLERANCE * np.tile(self.sizes, len(states)),
            **options,
        )


def check_method(method: str) -> None:
    """Refuse an unknown method of integration."""
    why = "the equations are smooth and may be stiff"
    check_choice("method", method, get_args(IntegrationMethod), why)
