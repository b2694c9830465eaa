"""A rotating chain with variable inertia: steady cycles, run-up, failing load, stopping."""

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import FloatArray, finite_array, positive_number
from crankbase.choices import whole_number
from crankbase.errors import InputError
from crankbase.frames import Dataset
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.cycle import even_angles
from dynamics.transient.applied_forces import cycle_turns
from dynamics.transient.motions import CycleMotion, ShaftRun
from dynamics.transient.propagator import ViscousSystem
from dynamics.transient.run import spring_torques
from dynamics.transient.turning_chain import (
    WORKS,
    IntegrationMethod,
    TurningChain,
    TurningState,
    check_method,
)
from dynamics.turning.speed_over_angle import (
    MOST_EVALUATIONS,
    MOST_TURNS,
    evaluation_counter,
    run_time,
    too_many_turns,
)

# The cycle closes to this share of the sizes of motion, after so many trials at most.
CLOSED = 1e-7
TRIALS = 40
# Step by which derivatives are taken, in sizes of the motion.
DIFFERENCE = 1e-3
# Directions that change nothing, such as the place of a ring that only a dashpot drives.
NO_CHANGE = 1e-9


@summarized(
    "mean_speed [rad/s]", "turns", "load [N m]", "torque", "energy_error", "closing_error", "note"
)
@dataclass(frozen=True, eq=False)
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
    shaft_angle_deg: FloatArray
    motion: FloatArray
    speed: FloatArray
    torque: FloatArray
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
    evaluated = evaluation_counter(lambda _: _too_slow(chain, speed, period), MOST_EVALUATIONS)
    shooting = _Shooting(chain, speed, period, method, evaluated)
    unknowns, missed = shooting.solved()
    return _sampled_cycle(shooting, unknowns, missed, turns, count)


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

    def state(self, loads: FloatArray) -> TurningState:
        """Return the equations under constant loads (c,) [N m]."""
        return TurningState(self.chain, self.speed, True, lambda _speeds, _time: loads, self.speed)

    def starts(self, unknowns: FloatArray) -> tuple[TurningState, FloatArray]:
        """Return equations and states (c, ...) at the start for unknowns (c, 2 q + 1)."""
        loads = unknowns[:, -1] * self.chain.torque_size(self.speed)
        state = self.state(loads)
        states = np.zeros((len(unknowns), state.size))
        states[:, : self.count] = unknowns[:, :-1] * state.sizes[: self.count]
        return state, states

    def residual(self, unknowns: FloatArray) -> FloatArray:
        """Return the residual (c, 2 q + 1) of unknowns (c, 2 q + 1)."""
        state, states = self.starts(unknowns)
        solution = self.integrate(state, states, [self.period])
        ends = solution.y[:, -1].reshape(states.shape)
        missed = (ends - states)[:, [*range(self.count), -1]]
        missed[:, :-1] /= state.sizes[: self.count]
        missed[:, -1] /= state.sizes[0] * self.period
        return np.asarray(missed)

    def integrate(self, state: TurningState, states: FloatArray, times: ArrayLike) -> Any:
        """Integrate over the cycle; refuse one that the integration did not get through."""
        solution = state.integrate(
            states, (0.0, self.period), self.method, self.evaluated, t_eval=times
        )
        if not solution.success:
            raise InputError(self.unsteady())
        return solution

    def solved(self) -> tuple[FloatArray, float]:
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


def _too_slow(chain: TurningChain, speed: float, period: float) -> InputError:
    periods = period * float(chain.system.system.natural[-1]) / (2.0 * np.pi)
    return InputError(
        f"mean_speed: given {speed:g} rad/s; allowed is a speed whose cycle takes fewer steps, because a "
        f"search has a limit of {MOST_EVALUATIONS} evaluations; in this cycle the highest mode has "
        f"{periods:.3g} periods."
    )


def _sampled_cycle(
    shooting: _Shooting, unknowns: FloatArray, missed: float, turns: int, samples: int
) -> TurningCycle:
    """Return the cycle sampled at even angles."""
    chain, speed = shooting.chain, shooting.speed
    state, states = shooting.starts(unknowns[np.newaxis])
    angles = even_angles(2.0 * np.pi * turns, samples)
    times = np.append(angles / speed, shooting.period)
    solution = shooting.integrate(state, states, times)
    count = chain.even.size
    values = solution.y.T
    works = values[-1, 2 * count : 2 * count + WORKS]
    motion = values[:-1, :count] @ chain.expand.T
    speeds = (values[:-1, count : 2 * count] + speed * chain.even) @ chain.expand.T
    kinetic, strain = chain.energies(
        values[:-1, :count], values[:-1, count : 2 * count] + speed * chain.even, angles
    )
    largest = max(float(np.max(np.abs(works))), float(np.ptp(kinetic + strain)))
    return TurningCycle(
        mean_speed=speed,
        turns=turns,
        load=float(state.load(np.array([speed]), 0.0)[0]),
        shaft_angle_deg=np.degrees(angles),
        motion=motion,
        speed=speeds,
        torque=spring_torques(chain.system.chain, motion),
        gas_work=float(works[0]),
        load_work=float(works[1]),
        damping_work=float(works[2]),
        energy_error=abs(float(works.sum())) / largest if largest > 0.0 else 0.0,
        closing_error=missed,
        chain=chain,
        note=chain.system.note,
    )


# The shaft stops where its speed has fallen to this share within about a turn.
STOPPED = 1e-3
MANY_STEPS = f"a revolution takes more than {MOST_EVALUATIONS:,} evaluations of the equations"
ENERGIES = ("kinetic_energy", "strain_energy", "gas_work", "load_work", "damping_work")
# Moment that brakes [N m], of shaft speed [rad/s] and time [s].
Load = Callable[[float, float], float]


@summarized("time [s]", "speed [rad/s]", "turns", "complete", "energy_error", "notes")
@dataclass(frozen=True, eq=False)
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

    time: FloatArray
    shaft_angle_deg: FloatArray
    shaft_speed: FloatArray
    motion: FloatArray
    speed: FloatArray
    torque: FloatArray
    kinetic_energy: FloatArray
    strain_energy: FloatArray
    gas_work: FloatArray
    load_work: FloatArray
    damping_work: FloatArray
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
    end = run_time("duration", duration)
    if speed * end > 2.0 * np.pi * MOST_TURNS:
        raise too_many_turns("duration", end, speed * end / (2.0 * np.pi))
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
                    raise too_many_turns("duration", end, MOST_TURNS)
                until, passed, rows, stopped = _turn(state, time, last, now, method, samples)
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


def _turn(
    state: TurningState,
    time: float,
    last: float,
    now: FloatArray,
    method: IntegrationMethod,
    samples: int,
) -> tuple[float, FloatArray, FloatArray, bool]:
    """Integrate about one revolution; return its end, times (m,), states (m, ...), whether it stops."""
    chain, count = state.chain, state.chain.even.size
    speed = float(now[count : 2 * count] @ chain.momentum)
    span = 2.0 * np.pi / speed
    # What is left of the time in even parts, so that no sliver remains at the end.
    until = time + (last - time) / max(1, math.ceil((last - time) / span * (1.0 - 1e-9)))
    if last - until < 1e-9 * span:
        until = last

    def stops(_time: float, values: FloatArray) -> float:
        return float(values[count : 2 * count] @ chain.momentum) - STOPPED * speed

    stops.terminal = True  # type: ignore[attr-defined]  # scipy reads this of the function itself
    times = np.linspace(time, until, samples + 1)[1:]
    evaluated = evaluation_counter(
        lambda now: _not_followed(last, now, MANY_STEPS), MOST_EVALUATIONS
    )
    solution = state.integrate(
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


def _not_followed(end: float, reached: float, why: str) -> InputError:
    return InputError(
        f"duration: given times up to {end:g} s; allowed is {reached:.6g} s or less, because the motion "
        f"cannot be followed any longer ({why})."
    )


def _assembled(
    in_turn: tuple[tuple[float, TurningChain], ...],
    times: FloatArray,
    states: FloatArray,
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


def _checked_load(load: Load | float) -> Callable[[FloatArray, float], FloatArray]:
    if not callable(load):
        constant = float(finite_array("load", load))
        return lambda speeds, _time: np.full(speeds.shape, constant)
    moment: Load = load

    def braking(speeds: FloatArray, time: float) -> FloatArray:
        moments = np.array([moment(speed, time) for speed in speeds.tolist()], dtype=np.float64)
        if not np.all(np.isfinite(moments)):
            raise InputError(
                f"load: given a moment of {moments[0]} N m at {speeds[0]:.6g} rad/s and {time:.6g} s; "
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
