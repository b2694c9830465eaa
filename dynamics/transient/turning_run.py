"""A rotating chain with variable inertia: steady cycles, run-up, failing load, stopping."""

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, Unpack, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    check_shape,
    finite_array,
    positive_number,
    turning_speeds,
)
from crankbase.choices import check_choice, whole_number
from crankbase.errors import InputError
from crankbase.frames import Dataset
from crankbase.sentences import amount, in_si
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import EngineChain, cylinder_inertia
from dynamics.cycle import even_angles
from dynamics.engine import RodModelName
from dynamics.engine.forces import rod_models
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.cylinders import CylinderForces
from dynamics.indices import node_index
from dynamics.response.order_excitation import checked_speed_index
from dynamics.transient.motions import CycleMotion, ShaftRun, spring_torques
from dynamics.transient.propagator import ViscousDamping, ViscousSystem, cycle_turns, viscous_system
from dynamics.turning.free_turning import TurnCurves, turn_curves
from dynamics.turning.speed_over_angle import (
    MOST_EVALUATIONS,
    MOST_TURNS,
    evaluation_counter,
    run_time,
    too_many_turns,
)

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

    orders: Array
    inertia_mean: Array
    inertia: ComplexArray
    torque_mean: Array
    torque: ComplexArray

    def at(self, angles: Array) -> tuple[Array, Array, Array]:
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

    def sampled(angles: Array) -> Array:
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


def _placed(values: ComplexArray, orders: Array, among: Array) -> ComplexArray:
    placed = np.zeros((len(values), among.size), dtype=np.complex128)
    placed[:, np.searchsorted(among, orders)] = values
    return placed


# Ratios of speeds count as one within this; damping against even turning as none.
EVEN = 1e-9
# Torques count as large from this share of twice the kinetic energy on, even where none act.
LEAST_SIZE = 1e-8

# What is no number is given on without a warning; an integrator shortens its step then.
_GIVEN_ON = np.errstate(invalid="ignore", over="ignore")


@frozen("throws", "even", "load", eq=False)
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
    throws: Array
    constant_mass: Array
    relative_damping: Array
    ground_damping: Array
    even: Array
    load: Array

    @cached_property
    def separate(self) -> bool:
        """Whether each unknown has its own inertia, without coupling inertias."""
        diagonal = np.array_equal(self.constant_mass, np.diag(np.diag(self.constant_mass)))
        return diagonal and bool(np.all((self.throws == 0.0) | (self.throws == 1.0)))

    @cached_property
    def momentum(self) -> Array:
        """Share of each unknown's speed in the mean speed, (q,)."""
        momentum = self.mean_mass @ self.even
        return np.asarray(momentum / (self.even @ momentum))

    @property
    def stiffness(self) -> Array:
        """K (q, q) [N m/rad]."""
        return self.system.system.stiffness

    @property
    def mean_mass(self) -> Array:
        """The inertia with rods and pistons at their means (q, q) [kg m^2]."""
        return self.system.system.mass

    @property
    def expand(self) -> Array:
        """Motion of the nodes per unknown, (n, q)."""
        return self.system.system.expand

    def with_constant_inertia(self) -> "TurningChain":
        """Return the same chain with the inertia of rods and pistons at its mean."""
        return replace(self, curves=self.curves.with_constant_inertia())

    def mean_speed(self, speeds: Array) -> Array:
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
        self, twist: Array, speeds: Array, even_turning: Array, reference: Array
    ) -> tuple[Array, Array, Array, Array]:
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
    def accelerations(self, torques: Array, inertia: Array) -> Array:
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
    def energies(self, twist: Array, speeds: Array, even_turning: Array) -> tuple[Array, Array]:
        """Return kinetic and strain energy (c,) [J]; arguments and errors as for `torques`."""
        self._check_shapes(twist, speeds, even_turning)
        inertia, _, _ = self.curves.at(
            (even_turning[:, np.newaxis] * self.even + twist) @ self.throws.T
        )
        kinetic = np.sum(speeds @ self.constant_mass * speeds, axis=1)
        kinetic += np.sum(inertia * (speeds @ self.throws.T) ** 2, axis=1)
        return 0.5 * kinetic, 0.5 * np.sum(twist @ self.stiffness * twist, axis=1)

    def _check_shapes(self, twist: Array, speeds: Array, even: Array) -> None:
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
    # The motion that neither springs nor relative damping resist.
    even = linear.rigid[:, 0]
    if linear.rigid.shape[1] > 1:
        values, vectors = np.linalg.eigh(linear.rigid.T @ relative @ linear.rigid)
        if values[0] > EVEN * values[-1]:
            raise InputError(
                "engine_chain: given parts that dashpots hold back from turning together; allowed are "
                "parts whose speeds the dashpots join are equal, because the shaft turns steadily."
            )
        even = linear.rigid @ vectors[:, 0]
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
            f"engine_chain: given {amount(chain.inertia[np.asarray(nodes)][throw], 'kg m^2')} at throw "
            f"{throw}; allowed is more than {amount(curves.inertia_mean[throw], 'kg m^2')}, because rods and "
            "pistons alone have that on average."
        )
    return TurningChain(
        system, curves, throws, constant, relative, ground, even, expand[load_node].copy()
    )


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
    load: Callable[[Array, float], Array]
    typical_speed: float

    @property
    def size(self) -> int:
        """Number of columns."""
        return 2 * self.chain.even.size + WORKS + 1

    @cached_property
    def sizes(self) -> Array:
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

    def slope(self, time: float, states: Array) -> Array:
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
        states: Array,
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

        def flat(time: float, values: Array) -> Array:
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

    def turn(
        self,
        time: float,
        last: float,
        now: Array,
        method: IntegrationMethod,
        samples: int,
    ) -> tuple[float, Array, Array, bool]:
        """Integrate about one revolution; return its end, times (m,), states (m, ...), whether it stops."""
        chain, count = self.chain, self.chain.even.size
        speed = float(now[count : 2 * count] @ chain.momentum)
        span = 2.0 * np.pi / speed
        # What is left of the time in even parts, so that no sliver remains at the end.
        until = time + (last - time) / max(1, math.ceil((last - time) / span * (1.0 - 1e-9)))
        if last - until < 1e-9 * span:
            until = last

        def stops(_time: float, values: Array) -> float:
            return float(values[count : 2 * count] @ chain.momentum) - STOPPED * speed

        stops.terminal = True  # type: ignore[attr-defined]  # scipy reads this of the function itself
        times = np.linspace(time, until, samples + 1)[1:]
        evaluated = evaluation_counter(
            lambda now: _not_followed(last, now, MANY_STEPS), MOST_EVALUATIONS
        )
        solution = self.integrate(
            now[np.newaxis], (time, until), method, evaluated, t_eval=times, events=[stops]
        )
        if solution.status < 0:
            raise _not_followed(last, time, str(solution.message).rstrip("."))
        passed, rows = np.asarray(solution.t), np.asarray(solution.y).reshape(now.size, -1).T
        if solution.status == 1:
            ended = float(solution.t_events[0][0])
            if not passed.size or passed[-1] < ended:
                passed, rows = np.append(passed, ended), np.vstack((rows, solution.y_events[0][0]))
            return ended, passed, rows, True
        return until, passed, rows, False


def check_method(method: str) -> None:
    """Refuse an unknown method of integration."""
    why = "the equations are smooth and may be stiff"
    check_choice("method", method, get_args(IntegrationMethod), why)


# The cycle closes to this share of the sizes of motion, after so many trials at most.
CLOSED = 1e-7
TRIALS = 40
# Step by which derivatives are taken, in sizes of the motion.
DIFFERENCE = 1e-3
# Directions that change nothing, such as the place of a ring that only a dashpot drives.
NO_CHANGE = 1e-9


@frozen(
    "mean_speed [rad/s]",
    "turns",
    "load [N m]",
    "torque",
    "energy_error",
    "closing_error",
    "note",
    eq=False,
)
class TurningCycle(CycleMotion):
    """One cycle of steady running.

    Parameters
    ----------
    mean_speed : float
        [rad/s]
    turns : int
        Of the shaft in the cycle.
    load : float
        Constant braking moment [N m].
    shaft_angle_deg : ndarray of shape (m,)
        Mean speed times time, evenly over the cycle, without its end [deg].
    motion : ndarray of shape (m, n)
        Angle of each node relative to its uniform rotation [rad]; the mean includes the twist by the
        transmitted torque.
    speed : ndarray of shape (m, n)
        Of each node [rad/s].
    torque : ndarray of shape (m, e)
        Of the spring of each element, mean included [N m].
    gas_work, load_work, damping_work : float
        Over the cycle, positive when it drives [J]; damping includes the power input of its dampers to
        ground, which turn uniformly.
    energy_error : float
        Sum of the works, ideally zero, relative to the largest of them and to the fluctuation of energy.
    closing_error : float
        Closing error of the cycle, as a share of the largest motion.
    note : str
        How loss factors were replaced; empty if there are none.
    """

    mean_speed: float
    turns: int
    load: float
    shaft_angle_deg: Array
    motion: Array
    speed: Array
    torque: Array
    gas_work: float
    load_work: float
    damping_work: float
    energy_error: float
    closing_error: float
    chain: TurningChain
    note: str

    def _chain_and_speed(self) -> tuple[Chain | None, float]:
        return self.chain.system.chain, self.mean_speed

    def to_xarray(self) -> Dataset:
        """Return motions and torques over shaft angle, node and element.

        Units and errors are those of `crankbase.frames.grid`.
        """
        speed = (("shaft_angle", "node"), self.speed, "rad/s", "speed of the node")
        return self._grid("twist", speed=speed)


def steady_cycle(
    chain: TurningChain,
    mean_speed: float,
    *,
    method: IntegrationMethod = "DOP853",
    samples: int | None = None,
) -> TurningCycle:
    """Find the periodic cycle at a mean speed, and the constant load that keeps it.

    Parameters
    ----------
    chain : TurningChain
        From `turning_chain`.
    mean_speed : float
        [rad/s]
    method : {"DOP853", "Radau"}
        Of `scipy.integrate.solve_ivp`: explicit of the eighth order, or implicit for a chain so
        stiff that its highest frequency, not the motion, would limit the step.
    samples : int, optional
        Over the cycle; by default eight per period of the highest order, 360 at least.

    Raises
    ------
    InputError
        If the speed is not above zero, no steady running is found, the search takes more than 150,000
        evaluations of the equations, or the method is unknown.

    Notes
    -----
    Shooting: the unknowns are the state at the start and the load for which the state is the same
    after the cycle and the mean position of the shaft is that of uniform rotation. Derivatives come from
    perturbed copies of the chain, all integrated at once; from trial to trial they are updated
    (C. G. Broyden, Mathematics of Computation 19 (1965) 577-593).
    """
    speed = positive_number("mean_speed", mean_speed, "rad/s", "the shaft turns forward")
    check_method(method)
    used = chain.curves.orders
    turns = cycle_turns(used) if used.size else 1
    count = (
        max(360, 8 * math.ceil(float(used.max(initial=1.0)) * turns))
        if samples is None
        else whole_number("samples", samples, 4, "they show the cycle")
    )
    period = 2.0 * np.pi * turns / speed

    def too_slow(_: float) -> InputError:
        periods = period * float(chain.system.system.natural[-1]) / (2.0 * np.pi)
        return InputError(
            f"mean_speed: given {speed:g} rad/s; allowed is a speed whose cycle takes fewer steps, because a "
            f"search has a limit of {MOST_EVALUATIONS} evaluations; in this cycle the highest mode has "
            f"{periods:.3g} periods."
        )

    shooting = _Shooting(
        chain, speed, period, method, evaluation_counter(too_slow, MOST_EVALUATIONS)
    )
    unknowns, missed = shooting.solved()
    state, states = shooting.starts(unknowns[np.newaxis])
    angles = even_angles(2.0 * np.pi * turns, count)
    solution = shooting.integrate(state, states, np.append(angles / speed, period))
    size = chain.even.size
    values = solution.y.T
    works = values[-1, 2 * size : 2 * size + WORKS]
    twists, velocities = values[:-1, :size], values[:-1, size : 2 * size] + speed * chain.even
    motion = twists @ chain.expand.T
    kinetic, strain = chain.energies(twists, velocities, angles)
    largest = max(float(np.max(np.abs(works))), float(np.ptp(kinetic + strain)))
    return TurningCycle(
        mean_speed=speed,
        turns=turns,
        load=float(state.load(np.array([speed]), 0.0)[0]),
        shaft_angle_deg=np.degrees(angles),
        motion=motion,
        speed=velocities @ chain.expand.T,
        torque=spring_torques(chain.system.chain, motion),
        gas_work=float(works[0]),
        load_work=float(works[1]),
        damping_work=float(works[2]),
        energy_error=abs(float(works.sum())) / largest if largest > 0.0 else 0.0,
        closing_error=missed,
        chain=chain,
        note=chain.system.note,
    )


@dataclass(frozen=True, eq=False)
class _Shooting:
    """The conditions of a periodic cycle; unknowns and residuals are scaled by the state."""

    chain: TurningChain
    speed: float
    period: float
    method: IntegrationMethod
    evaluated: Callable[[float], None]

    @property
    def count(self) -> int:
        """Twists and their speeds."""
        return 2 * self.chain.even.size

    def state(self, loads: Array) -> TurningState:
        """Return the equations under constant loads (c,) [N m]."""
        return TurningState(self.chain, self.speed, True, lambda _speeds, _time: loads, self.speed)

    def starts(self, unknowns: Array) -> tuple[TurningState, Array]:
        """Return equations and states (c, ...) at the start for unknowns (c, 2 q + 1)."""
        loads = unknowns[:, -1] * self.chain.torque_size(self.speed)
        state = self.state(loads)
        states = np.zeros((len(unknowns), state.size))
        states[:, : self.count] = unknowns[:, :-1] * state.sizes[: self.count]
        return state, states

    def residual(self, unknowns: Array) -> Array:
        """Return the residual (c, 2 q + 1) of unknowns (c, 2 q + 1)."""
        state, states = self.starts(unknowns)
        solution = self.integrate(state, states, [self.period])
        ends = solution.y[:, -1].reshape(states.shape)
        missed = (ends - states)[:, [*range(self.count), -1]]
        missed[:, :-1] /= state.sizes[: self.count]
        missed[:, -1] /= state.sizes[0] * self.period
        return np.asarray(missed)

    def integrate(self, state: TurningState, states: Array, times: ArrayLike) -> Any:
        """Integrate over the cycle; refuse one that the integration did not get through."""
        solution = state.integrate(
            states, (0.0, self.period), self.method, self.evaluated, t_eval=times
        )
        if not solution.success:
            raise InputError(self.unsteady())
        return solution

    def solved(self) -> tuple[Array, float]:
        """Return the unknowns (2 q + 1,) of the periodic cycle, and their residual."""
        size = self.count + 1
        unknowns = np.zeros(size)
        mean = float(self.chain.curves.torque_mean.sum())
        unknowns[-1] = mean / self.chain.torque_size(self.speed)
        missed = self.residual(np.vstack((unknowns, unknowns + DIFFERENCE * np.eye(size))))
        step = np.linalg.pinv((missed[1:] - missed[0]).T / DIFFERENCE, rcond=NO_CHANGE)
        left = missed[0]
        for _ in range(TRIALS):
            scale = max(1.0, float(np.max(np.abs(unknowns))))
            if np.max(np.abs(left)) <= CLOSED * scale:
                return unknowns, float(np.max(np.abs(left))) / scale
            moved = -step @ left
            unknowns = unknowns + moved
            after = self.residual(unknowns[np.newaxis])[0]
            towards = step @ (after - left)
            length = moved @ towards
            if length == 0.0:
                break
            step = step + np.outer((moved - towards) / length, moved @ step)
            left = after
        raise InputError(self.unsteady())

    def unsteady(self) -> str:
        """Report that no cycle is periodic."""
        return (
            f"mean_speed: given {self.speed:g} rad/s; allowed is a speed at which the shaft runs steadily, "
            "because no cycle was found that repeats."
        )


# The shaft stops where its speed has fallen to this share within about a turn.
STOPPED = 1e-3
MANY_STEPS = f"a revolution takes more than {MOST_EVALUATIONS:,} evaluations of the equations"
ENERGIES = ("kinetic_energy", "strain_energy", "gas_work", "load_work", "damping_work")
# Moment that brakes [N m], of shaft speed [rad/s] and time [s].
Load = Callable[[float, float], float]


@frozen("time [s]", "speed [rad/s]", "turns", "complete", "energy_error", "notes", eq=False)
class TurningRun(ShaftRun):
    """Free rotation of a shaft over time.

    Parameters
    ----------
    time : ndarray of shape (m,)
        [s]
    shaft_angle_deg, shaft_speed : ndarray of shape (m,)
        Of uniform rotation with the same angular momentum about the shaft [deg, rad/s].
    motion : ndarray of shape (m, n)
        Angle of each node relative to it [rad], twist by mean torques included.
    speed : ndarray of shape (m, n)
        Of each node [rad/s].
    torque : ndarray of shape (m, e)
        Of the spring of each element [N m].
    kinetic_energy, strain_energy : ndarray of shape (m,)
        [J]
    gas_work, load_work, damping_work : ndarray of shape (m,)
        Since the start, positive for driving work [J].
    turns : int
        Revolutions after which gas and inertia repeat.
    complete : bool
        False if the run was interrupted or the shaft stopped; the arrays then end there.
    system : ViscousSystem
        The chain of constant inertia.
    """

    time: Array
    shaft_angle_deg: Array
    shaft_speed: Array
    motion: Array
    speed: Array
    torque: Array
    kinetic_energy: Array
    strain_energy: Array
    gas_work: Array
    load_work: Array
    damping_work: Array
    turns: int
    complete: bool
    system: ViscousSystem
    notes: tuple[str, ...]

    @property
    def energy_error(self) -> float:
        """Largest difference of energy gained and work done, relative to the largest energy."""
        energy = self.kinetic_energy + self.strain_energy
        done = self.gas_work + self.load_work + self.damping_work
        return float(np.max(np.abs(energy - energy[0] - done)) / np.max(energy))

    def to_xarray(self) -> Dataset:
        """Return speed, angle, motions, torques, energies and works over time, node and element.

        Units and errors are those of `crankbase.frames.grid`.
        """
        energies = {
            name: (("time",), getattr(self, name), "J", name.replace("_", " ")) for name in ENERGIES
        }
        speed = (("time", "node"), self.speed, "rad/s", "speed of the node")
        return self._grid("twist", speed=speed, **energies)


def turn_under_gas(
    chain: TurningChain,
    start_speed: float,
    duration: float,
    *,
    load: Load | float = 0.0,
    changes: tuple[tuple[float, TurningChain], ...] = (),
    method: IntegrationMethod = "DOP853",
    samples_per_turn: int = 180,
    progress: Callable[[float], None] | None = None,
) -> TurningRun:
    """Integrate a shaft driven by gas and load, from uniform rotation without twist at shaft angle zero.

    Parameters
    ----------
    chain : TurningChain
        From `turning_chain`.
    start_speed : float
        [rad/s]
    duration : float
        At most a day [s], and 20,000 revolutions.
    load : float or callable, optional
        Braking moment at the load's node [N m], or a callable (shaft speed [rad/s], time [s]) ->
        moment: a governor is load = mean + gain (speed - set speed).
    changes : tuple of (float, TurningChain), optional
        Chains of the same matrices with other gas that replace it at given times [s], ascending, such as
        after a cylinder has failed.
    method : {"DOP853", "Radau"}
        As for `steady_cycle`.
    samples_per_turn : int, optional
        Of the results.
    progress : callable, optional
        Called with the share done after each revolution, between 0 and 1.

    Returns
    -------
    TurningRun
        On KeyboardInterrupt, from the keyboard or from `progress`, the revolutions finished until then.

    Raises
    ------
    InputError
        If a number is out of range, changes do not ascend within the run or have other matrices, or
        the load is not a finite moment.
    """
    speed = positive_number("start_speed", start_speed, "rad/s", "the shaft turns forward")
    end = run_time(duration)
    if speed * end > 2.0 * np.pi * MOST_TURNS:
        raise too_many_turns(end, speed * end / (2.0 * np.pi))
    samples = whole_number("samples_per_turn", samples_per_turn, 4, "they show the motion")
    check_method(method)
    braking = _checked_load(load)
    in_turn = _checked_changes(chain, changes, end)
    state = TurningState(chain, 0.0, False, braking, speed)
    now = np.zeros(state.size)
    count = chain.even.size
    now[count : 2 * count] = speed * chain.even
    done = [(np.zeros(1), now[np.newaxis])]
    time, stopped, finished = 0.0, False, False
    with contextlib.suppress(KeyboardInterrupt):
        for place, (begins, turning) in enumerate(in_turn):
            state = TurningState(turning, 0.0, False, braking, speed)
            last = in_turn[place + 1][0] if place + 1 < len(in_turn) else end
            time = begins
            while time < last and not stopped:
                if len(done) > MOST_TURNS:
                    raise too_many_turns(end, MOST_TURNS)
                until, passed, rows, stopped = state.turn(time, last, now, method, samples)
                done.append((passed, rows))
                time, now = until, rows[-1]
                if progress is not None:
                    progress(min(time / end, 1.0))
        finished = not stopped
    how = "The shaft all but stops" if stopped else "Interrupted"
    reached = float(done[-1][0][-1])
    orders = np.unique(np.concatenate([turning.curves.orders for _, turning in in_turn]))
    return _assembled(
        in_turn,
        np.concatenate([times for times, _ in done]),
        np.concatenate([states for _, states in done]),
        cycle_turns(orders) if orders.size else 1,
        finished,
        "" if finished else f"{how} at {reached:.6g} s of {end:.6g} s.",
    )


def _not_followed(end: float, reached: float, why: str) -> InputError:
    return InputError(
        f"duration: given times up to {end:g} s; allowed is {reached:.6g} s or less, because the motion "
        f"cannot be followed any longer ({why})."
    )


def _assembled(
    in_turn: tuple[tuple[float, TurningChain], ...],
    times: Array,
    states: Array,
    turns: int,
    complete: bool,
    note: str,
) -> TurningRun:
    chain = in_turn[0][1]
    count = chain.even.size
    absolute, speeds = states[:, :count], states[:, count : 2 * count]
    angle = absolute @ chain.momentum
    # Strain from what is left beside the even turning: of hundreds of turns it would lose its digits.
    twist = absolute - angle[:, np.newaxis] * chain.even
    kinetic, strain = chain.energies(twist, speeds, angle)
    motion = twist @ chain.expand.T
    works = states[:, 2 * count : 2 * count + WORKS].T
    return TurningRun(
        time=times,
        shaft_angle_deg=np.degrees(angle),
        shaft_speed=speeds @ chain.momentum,
        motion=motion,
        speed=speeds @ chain.expand.T,
        torque=spring_torques(chain.system.chain, motion),
        kinetic_energy=kinetic,
        strain_energy=strain,
        gas_work=works[0],
        load_work=works[1],
        damping_work=works[2],
        turns=turns,
        complete=complete,
        system=chain.system,
        notes=tuple(text for text in (chain.system.note, note) if text),
    )


def _checked_load(load: Load | float) -> Callable[[Array, float], Array]:
    if not callable(load):
        constant = float(finite_array("load", load))
        return lambda speeds, _time: np.full(speeds.shape, constant)
    moment: Load = load

    def braking(speeds: Array, time: float) -> Array:
        moments = np.array([moment(speed, time) for speed in speeds.tolist()], dtype=np.float64)
        if not np.all(np.isfinite(moments)):
            raise InputError(
                f"load: given a moment of {moments[0]} N m at {in_si(speeds[0], 'rad/s')} and {time:.6g} s; "
                "allowed are finite numbers, because the speed follows from the moments."
            )
        return moments

    return braking


def _checked_changes(
    chain: TurningChain, changes: tuple[tuple[float, TurningChain], ...], end: float
) -> tuple[tuple[float, TurningChain], ...]:
    in_turn = [(0.0, chain)]
    for place, (time, other) in enumerate(changes):
        value = float(finite_array(f"changes[{place}]", time))
        if not in_turn[-1][0] < value < end:
            raise InputError(
                f"changes[{place}]: given a time of {value:g} s; allowed are ascending times above "
                f"{in_turn[-1][0]:g} s and below {end:g} s, because each gas takes over from the one "
                "before within the run."
            )
        same = np.array_equal(other.mean_mass, chain.mean_mass)
        if not same or not np.array_equal(other.stiffness, chain.stiffness):
            raise InputError(
                f"changes[{place}]: given a chain of other inertias or stiffnesses; allowed is the same "
                "chain with other gas, because the shaft does not change."
            )
        in_turn.append((value, other))
    return tuple(in_turn)
