"""Motion through time by integration: steady, or while speed, cylinders or loads change."""

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, Unpack

import numpy as np

from crankbase.array_checks import FloatArray, positive_number
from crankbase.choices import check_choice, whole_number
from crankbase.errors import InputError
from crankbase.frames import Dataset
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.cycle import even_angles
from dynamics.response.linear_system import LinearSystem
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.applied_forces import (
    USUAL_REACH,
    AppliedForces,
    LoadStep,
    OrderForces,
    SpeedCurve,
    TimeSegment,
    checked_step,
    cycle_turns,
    midpoint_residual,
    sampling_note,
    time_segments,
)
from dynamics.transient.motions import CycleMotion, Envelope, Moving, ShaftRun, units_of
from dynamics.transient.propagator import (
    PLACES,
    Propagator,
    StateSpace,
    ViscousDamping,
    ViscousSystem,
    viscous_system,
)

# An undamped mode that comes round within this share of a whole number of its periods, while forces
# go on driving it there, answers without bounds; as in `harmonic_response`.
UNBOUNDED_WITHIN = 1e-9
# What drives such a mode is nothing below this share of the largest change over a cycle.
NO_DRIVE = 1e-9


@summarized("speed [rad/s]", "turns", "amplitude", "torque_amplitude", "unbounded", "note")
@dataclass(frozen=True, eq=False)
class SteadyMotion(CycleMotion):
    """Vibration that repeats every cycle at a constant speed.

    Parameters
    ----------
    speed : float
        [rad/s]
    turns : int
        Of the shaft in one cycle.
    shaft_angle_deg : ndarray of shape (m,)
        Evenly over the cycle, without its end [deg].
    motion : ndarray of shape (m, n)
        Of the nodes [rad or m]; zero if it is unbounded. Rigid-body motion of a free system is that
        caused by the forces, with zero mean.
    torque : ndarray of shape (m, e)
        Of the spring of each element of a chain [N m or N]; e is 0 for other systems.
    unbounded : bool
        Whether an undamped mode is excited at its own frequency: there is no steady motion.
    step : float
        [s]
    system : ViscousSystem
        The vibrating system.
    note : str
        How loss factors were replaced; empty if there are none.
    """

    speed: float
    turns: int
    shaft_angle_deg: FloatArray
    motion: FloatArray
    torque: FloatArray
    unbounded: bool
    step: float
    system: ViscousSystem
    note: str

    @property
    def time(self) -> FloatArray:
        """Time from shaft angle zero [s], shape (m,)."""
        return np.radians(self.shaft_angle_deg) / self.speed

    def to_xarray(self, quantity: Moving | None = None) -> Dataset:
        """Return motions and torques over shaft angle, node and element.

        `quantity` is that of the values, see `units_of`: a chain does not determine it.

        Raises
        ------
        InputError
            If the quantity is none of these.
        MissingLibraryError
            If xarray is not installed.
        """
        return self._grid(quantity)

    def _chain_and_speed(self) -> tuple[Chain | None, float]:
        return self.system.chain, self.speed

    def _half_way(self, values: FloatArray) -> FloatArray:
        if self.unbounded:
            return np.full(values.shape[1], np.inf)
        return super()._half_way(values)


def steady_motion(
    chain_or_system: Chain | LinearSystem,
    excitation: OrderExcitation,
    speed: float,
    *,
    steps: int | None = None,
    **damping: Unpack[ViscousDamping],
) -> SteadyMotion:
    """Find the steady motion at a speed by integrating over one cycle.

    Parameters
    ----------
    excitation : OrderExcitation
        Between its speeds forces are interpolated as by `OrderExcitation.at_speeds`.
    speed : float
        Within those of the excitation [rad/s].
    steps : int, optional
        Number of steps per cycle; by default each covers half a radian of the highest order.
    **damping
        loss_as, loss_frequency, magnifier, modal_damping, as for `viscous_system`.

    Raises
    ------
    InputError
        If the speed is not above zero or outside the excitation's, the steps do not resolve the
        highest order, orders have no common cycle, or damping is out of range.

    Notes
    -----
    Over a cycle of time T the state becomes z(T) = Phi z(0) + z_p, so that it repeats for
    (I - Phi) z(0) = z_p. Nothing depends on the position of rigid motions: it is not an unknown, but its
    periodicity is an equation, which also determines a speed that no damping holds. Then the mean position
    over the cycle is subtracted.
    """
    at_speed = positive_number("speed", speed, "rad/s", "the shaft turns forward")
    system = viscous_system(chain_or_system, **damping)
    return steady_from(system, excitation, at_speed, 0.0, steps)[0]


def steady_from(
    system: ViscousSystem,
    excitation: OrderExcitation,
    speed: float,
    start_angle: float,
    steps: int | None = None,
) -> tuple[SteadyMotion, FloatArray]:
    """Return the steady motion over a cycle from a shaft angle, and the state at its start."""
    space = StateSpace.of(system.system)
    forces = OrderForces.of(excitation, space.inputs)
    forces.check_speeds(speed, speed)
    turns = cycle_turns(excitation.orders)
    highest = float(excitation.orders[-1])
    if steps is None:
        count = 8 * math.ceil(2.0 * np.pi * turns * highest / USUAL_REACH / 8)
    else:
        count = whole_number("steps", steps, 1, "the cycle is passed in steps")
    period = 2.0 * np.pi * turns / speed
    step = checked_step(period / count, excitation.orders, speed)
    propagator = Propagator.of(space, step)
    angles = start_angle + even_angles(2.0 * np.pi * turns, count)
    points = (angles[:, np.newaxis] + speed * step * PLACES).reshape(-1)
    acting = forces.at(points, np.full(points.size, speed)).reshape(count, PLACES.size, -1)
    start, unbounded = _periodic_start(space, propagator, acting, period)
    states = np.vstack((start, propagator.propagate(start, acting)[:-1]))
    if unbounded:
        states[:] = 0.0
    places = slice(len(start) - space.rigid, len(start))
    mean = states[:, places].mean(axis=0)
    states[:, places] -= mean
    motion, _ = space.motion(states)
    steady = SteadyMotion(
        speed=speed,
        turns=turns,
        shaft_angle_deg=np.degrees(angles),
        motion=motion,
        torque=spring_torques(system.chain, motion),
        unbounded=unbounded,
        step=step,
        system=system,
        note=system.note,
    )
    return steady, states[0]


def spring_torques(chain: Chain | None, motion: FloatArray) -> FloatArray:
    """Return the torque (force) of the spring of each element, (m, e); e is 0 without a chain."""
    if chain is None:
        return np.zeros((len(motion), 0))
    return np.asarray(motion @ (chain.stiffness[:, np.newaxis] * chain.elongations()).T)


def _periodic_start(
    space: StateSpace, propagator: Propagator, forces: FloatArray, period: float
) -> tuple[FloatArray, bool]:
    """Return the state that repeats after the cycle, and whether there is none."""
    size = len(space.matrix)
    free = size - space.rigid
    gained = propagator.propagate(np.zeros(size), forces)[-1]
    over_cycle = np.linalg.matrix_power(propagator.transition, len(forces))
    # Places of rigid motions change by speed times period: in that unit they compare with the rest.
    unit = np.ones(size)
    unit[free:] = 1.0 / (space.scales[: space.rigid] * period)
    left = (np.eye(size) - over_cycle)[:, :free] * unit[:, np.newaxis]
    right = gained * unit
    outward, singular, inward = np.linalg.svd(left, full_matrices=False)
    drive = outward.T @ right
    # How fast what each singular value stands for vibrates; rigid motions do not.
    elastic = space.scales[space.rigid :]
    scale = np.sqrt(inward**2 @ np.concatenate((elastic, elastic, np.zeros(space.rigid))) ** 2)
    lost = singular <= UNBOUNDED_WITHIN * scale * period
    largest = float(np.max(np.abs(right), initial=0.0))
    unbounded = bool(np.any(np.abs(drive[lost]) > NO_DRIVE * largest))
    start = np.zeros(size)
    if unbounded:
        return start, True
    start[:free] = inward.T @ np.divide(drive, singular, out=np.zeros(free), where=~lost)
    return start, False


# Steps between two reports of progress.
STRETCH = 2000
# Most numbers in the results of one run: 1.6 GB.
MOST_NUMBERS = 2e8
# Steps that differ by round-off only are one.
SAME_STEP = 1e-11


@summarized("time [s]", "shaft_speed [rad/s]", "torque", "complete", "force_error", "notes")
@dataclass(frozen=True, eq=False)
class TransientMotion(ShaftRun):
    """Motion of a chain or system over time.

    Parameters
    ----------
    time, shaft_speed, shaft_angle_deg : ndarray of shape (m,)
        [s, rad/s, deg]
    motion : ndarray of shape (m, n)
        Of the nodes, relative to the uniform rotation [rad or m]; in a free system without its rigid-body
        motion.
    rigid_motion : ndarray of shape (m, n)
        Of a free system, due to the forces alone [rad or m]; zero where the system is held.
    torque, system
        As in `SteadyMotion`.
    complete : bool
        False if the run was interrupted; the arrays then end there.
    step : float
        Longest step [s].
    force_error : float
        Largest difference between the forces and the polynomials that replace them within steps,
        relative to the largest force on each mode. All else is exact.
    orders : ndarray of shape (K,)
        Orders of all excitations.
    """

    time: FloatArray
    shaft_speed: FloatArray
    shaft_angle_deg: FloatArray
    motion: FloatArray
    rigid_motion: FloatArray
    torque: FloatArray
    complete: bool
    step: float
    force_error: float
    orders: FloatArray
    system: ViscousSystem
    notes: tuple[str, ...]

    @property
    def turns(self) -> int:
        """Revolutions after which the orders repeat.

        Raises
        ------
        InputError
            If they do not within 12 revolutions; then give `envelope` the number.
        """
        return cycle_turns(self.orders)

    def envelope(self, turns: int | None = None, *, rigid: bool = False) -> Envelope:
        """Return the amplitudes in windows of whole revolutions; by default as the orders repeat.

        Parameters
        ----------
        turns : int, optional
            Revolutions of the shaft in one window.
        rigid : bool, optional
            Whether rigid-body motion counts, as it does in `SteadyMotion` and `forced_response`.

        Raises
        ------
        InputError
            If the run is shorter than one window.
        """
        return self._envelope(self.motion + self.rigid_motion if rigid else self.motion, turns)

    def to_xarray(self, quantity: Moving | None = None) -> Dataset:
        """Return speed, angle, motions and torques over time, node and element.

        `quantity` is that of the values, see `units_of`: a chain does not determine it.

        Raises
        ------
        InputError
            If the quantity is none of these.
        MissingLibraryError
            If xarray is not installed.
        """
        moved, _ = units_of(quantity)
        rigid = (("time", "node"), self.rigid_motion, moved, "rigid-body motion")
        return self._grid(quantity, rigid_motion=rigid)


def transient_motion(
    chain_or_system: Chain | LinearSystem,
    excitation: OrderExcitation,
    speed: SpeedCurve,
    *,
    changes: Sequence[tuple[float, OrderExcitation]] = (),
    loads: Sequence[LoadStep] = (),
    start: Literal["steady", "rest"] = "steady",
    step: float | None = None,
    progress: Callable[[float], None] | None = None,
    **damping: Unpack[ViscousDamping],
) -> TransientMotion:
    """Integrate the vibration over time while the shaft turns at a given, changing speed.

    Parameters
    ----------
    excitation : OrderExcitation
        Its forces follow the shaft angle, the integral of the speed; between its speeds they are
        interpolated as by `OrderExcitation.at_speeds`.
    speed : SpeedCurve
        Within the speeds of the excitation.
    changes : sequence of (float, OrderExcitation), optional
        Excitations that replace it at given times [s], ascending, such as after a cylinder has failed.
    loads : sequence of LoadStep, optional
        Additional torques or forces. The speed is given: it does not react to them.
    start : {"steady", "rest"}
        Whether the motion starts as the steady one at the first speed, or from rest.
    step : float, optional
        Longest step, which is also that of the results [s]; by default each covers half a radian of
        the highest order at the highest speed.
    progress : callable, optional
        Called with the share done, between 0 and 1, every 2000 steps.
    **damping
        loss_as, loss_frequency, magnifier, modal_damping, as for `viscous_system`.

    Returns
    -------
    TransientMotion
        On KeyboardInterrupt, from the keyboard or from `progress`, the part finished until then.

    Raises
    ------
    InputError
        If speeds, times, nodes or steps do not fit, results would be too large, damping is out of
        range, or there is no steady motion to start from.

    Notes
    -----
    Each step is exact for forces that are polynomials of the fifth degree within it, fitted at six
    Gauss points; changes, points of the speed curve and starts and ends of loads are between
    steps. The stiffness of the chain does not limit the step.
    """
    system = viscous_system(chain_or_system, **damping)
    space = StateSpace.of(system.system)
    check_choice("start", start, ("steady", "rest"), "these starts are known")
    acting = AppliedForces.of(speed, excitation, changes, loads, space.inputs)
    orders = acting.orders
    fastest = float(speed.speeds.max())
    if step is None:
        longest = USUAL_REACH / (float(orders[-1]) * fastest)
    else:
        asked = positive_number("step", step, "s", "time runs forward")
        longest = checked_step(asked, orders, fastest)
    pieces = time_segments(acting, longest)
    count, each = sum(piece.steps for piece in pieces), len(space.matrix) + 3 * len(space.inputs)
    if count * each > MOST_NUMBERS:
        raise InputError(
            f"speed: given a curve that takes {count} steps; allowed is {int(MOST_NUMBERS / each)} at most, "
            "because the results of all steps are kept in memory."
        )
    state = np.zeros(len(space.matrix))
    if start == "steady":
        state = _steady_start(system, excitation, speed)
    times, states, error, complete = _integrate_segments(space, acting, pieces, state, progress)
    motion, rigid = space.motion(states)
    rigid_motion = rigid @ space.inputs[:, : space.rigid].T
    elastic = motion - rigid_motion
    notes = (
        system.note,
        sampling_note(system.system.natural[space.rigid :], longest),
        "" if complete else f"Interrupted at {times[-1]:.6g} s of {speed.times[-1]:.6g} s.",
    )
    return TransientMotion(
        time=times,
        shaft_speed=speed.speed(times),
        shaft_angle_deg=speed.angle_deg(times),
        motion=elastic,
        rigid_motion=rigid_motion,
        torque=spring_torques(system.chain, elastic),
        complete=complete,
        step=longest,
        force_error=error,
        orders=orders,
        system=system,
        notes=tuple(note for note in notes if note),
    )


def _integrate_segments(
    space: StateSpace,
    acting: AppliedForces,
    pieces: Sequence[TimeSegment],
    start: FloatArray,
    progress: Callable[[float], None] | None,
) -> tuple[FloatArray, FloatArray, float, bool]:
    """Return times (m,), states (m, 2 q), the error of the forces, and whether the run is complete."""
    count = 1 + sum(piece.steps for piece in pieces)
    times, states = np.empty(count), np.empty((count, start.size))
    times[0], states[0] = pieces[0].start, start
    done, error, largest = 1, 0.0, np.full(space.velocities.size, np.finfo(np.float64).tiny)
    complete = False
    propagator = Propagator.of(space, pieces[0].step)
    with contextlib.suppress(KeyboardInterrupt):
        for step, starts in _step_blocks(pieces):
            if abs(step - propagator.step) > SAME_STEP * step:
                propagator = Propagator.of(space, step)
            forces = acting.at(starts, step, PLACES)
            places = slice(done, done + starts.size)
            states[places] = propagator.propagate(states[done - 1], forces)
            times[places] = starts + step
            missed, chosen = midpoint_residual(forces)
            true = acting.at(starts[chosen], step, np.array([0.5]))[:, 0]
            largest = np.maximum(largest, np.max(np.abs(forces), axis=(0, 1)))
            error = max(error, float(np.max(np.abs(missed - true) / largest)))
            done += starts.size
            if progress is not None:
                progress((done - 1) / (count - 1))
        complete = True
    return times[:done], states[:done], error, complete


def _step_blocks(pieces: Sequence[TimeSegment]) -> Iterator[tuple[float, FloatArray]]:
    """Yield the length of steps and their starts, so many at a time."""
    for piece in pieces:
        for first in range(0, piece.steps, STRETCH):
            numbers = np.arange(first, min(first + STRETCH, piece.steps))
            yield piece.step, np.asarray(piece.start + piece.step * numbers)


def _steady_start(
    system: ViscousSystem, excitation: OrderExcitation, speed: SpeedCurve
) -> FloatArray:
    steady, state = steady_from(
        system, excitation, float(speed.speeds[0]), math.radians(speed.start_angle_deg)
    )
    if steady.unbounded:
        raise InputError(
            f"start: given 'steady' at {speed.speeds[0]:g} rad/s; allowed is 'rest' there, because an "
            "undamped mode is excited at its own frequency."
        )
    return state
