"""Loads and time steps of a chain: torques over time, impulses, and exact steps under polynomial forces."""

import math
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from itertools import pairwise
from math import factorial
from typing import Literal, TypedDict, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from crankbase.array_checks import (
    Array,
    Integers,
    finite_array,
    finite_vector,
    nonnegative_number,
    positive_number,
    positive_vector,
    radians_of,
    read_only,
)
from crankbase.choices import check_choice, whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.quantity import RPM
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain
from dynamics.indices import node_index
from dynamics.plots.curves import SPEED_LABEL, draw_over_time
from dynamics.response.forced import chain_and_system
from dynamics.response.linear_system import LinearSystem
from dynamics.response.order_excitation import OrderExcitation, OverSpeed, check_ascending

# Forces are taken at so many Gauss points of each step; between them they are a polynomial.
POINTS = 6
PLACES = 0.5 + 0.5 * np.polynomial.legendre.leggauss(POINTS)[0]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """The first-order equation of motion in the undamped modes.

    z = (w_r y_r of the elastic modes, their velocities, velocities of the rigid motions, their
    displacements times the lowest elastic frequency), so that z' z / 2 is the energy except for the last.

    Parameters
    ----------
    matrix : ndarray of shape (2 q, 2 q)
        A of z' = A z + forces on velocities.
    velocities : ndarray of shape (q,)
        Indices in z of the velocity of each mode, rigid motions first as in the system.
    displacements : ndarray of shape (q,)
        Indices of its displacement.
    scales : ndarray of shape (q,)
        Factor of displacements in z [1/s].
    inputs : ndarray of shape (n, q)
        Forces on the nodes to forces on the modes, by multiplication from the right.
    rigid : int
        Number of rigid motions; their displacements are last in z.
    """

    matrix: Array
    velocities: Array
    displacements: Array
    scales: Array
    inputs: Array
    rigid: int

    @classmethod
    def of(cls, system: LinearSystem) -> "StateSpace":
        """Return the state space of a system without hysteretic damping."""
        count, rigid = system.natural.size, system.rigid.shape[1]
        elastic = count - rigid
        displacements = np.concatenate(
            (np.arange(2 * elastic + rigid, 2 * count), np.arange(elastic))
        )
        velocities = np.concatenate(
            (np.arange(2 * elastic, 2 * elastic + rigid), np.arange(elastic, 2 * elastic))
        )
        scales = system.natural.copy()
        scales[:rigid] = system.natural[rigid] if elastic else 1.0
        damping = system.shapes.T @ system.damping @ system.shapes
        matrix = np.zeros((2 * count, 2 * count))
        matrix[displacements, velocities] = scales
        matrix[np.ix_(velocities, velocities)] = -damping
        matrix[velocities[rigid:], displacements[rigid:]] = -scales[rigid:]
        return cls(matrix, velocities, displacements, scales, system.expand @ system.shapes, rigid)

    def motion(self, states: Array) -> tuple[Array, Array]:
        """Return the motion of the nodes (m, n), and of rigid motions (m, rigid), of states (m, 2q)."""
        modal = states[:, self.displacements] / self.scales
        return modal @ self.inputs.T, modal[:, : self.rigid]


@dataclass(frozen=True, eq=False)
class Propagator:
    """One step of given length: z(t + h) = E z(t) + sum over points of W_j p(t + c_j h).

    Parameters
    ----------
    step : float
        h [s].
    transition : ndarray of shape (2 q, 2 q)
        E.
    weights : ndarray of shape (POINTS * q, 2 q)
        W of all points, one below the other, transposed.
    """

    step: float
    transition: Array
    weights: Array

    @classmethod
    def of(cls, space: StateSpace, step: float) -> "Propagator":
        """Return the step of a state space.

        Notes
        -----
        The integral of exp(A (h - s)) B (s/h)^k ds over the step is h k! phi_(k+1)(A h) B. All phi
        come from one exponential: that of A h augmented with B and a chain of unit matrices (C. Van
        Loan, IEEE Trans. Automatic Control 23 (1978) 395-404). The step is not limited by the stiffness of
        the chain, only by the accuracy of the polynomials.
        """
        size, count = len(space.matrix), space.velocities.size
        whole = np.zeros((size + POINTS * count,) * 2)
        whole[:size, :size] = space.matrix * step
        whole[space.velocities, size + np.arange(count)] = step
        chain = np.arange((POINTS - 1) * count)
        whole[size + chain, size + count + chain] = 1.0
        exponential = expm(whole)
        powers = np.vander(PLACES, POINTS, increasing=True)
        # Row j: coefficients by powers of the polynomial that is 1 at point j and 0 at the others.
        basis = np.linalg.inv(powers).T
        weights = np.zeros((POINTS, count, size))
        for power in range(POINTS):
            start = size + power * count
            answer = factorial(power) * exponential[:size, start : start + count].T
            weights += basis[:, power, np.newaxis, np.newaxis] * answer
        return cls(step, exponential[:size, :size], weights.reshape(POINTS * count, size))

    def propagate(self, start: Array, forces: Array) -> Array:
        """Return the states after each of m steps, (m, 2 q).

        Parameters
        ----------
        start : ndarray of shape (2 q,)
        forces : ndarray of shape (m, POINTS, q)
            On the modes, at the points of each step.
        """
        gains = forces.reshape(len(forces), -1) @ self.weights
        state, transition = start, self.transition
        for gain in gains:
            gain += transition @ state
            state = gain
        return np.asarray(gains)


LossAs = Literal["viscous", "modal"]


class ViscousDamping(TypedDict, total=False):
    """Damping arguments of `viscous_system`, which see."""

    loss_as: LossAs
    loss_frequency: float | None
    magnifier: float | None
    modal_damping: ArrayLike | None


@frozen("system.natural", "note", eq=False)
class ViscousSystem:
    """A linear system that can be integrated over time.

    Parameters
    ----------
    system : LinearSystem
        Without hysteretic damping.
    chain : Chain or None
        Its origin.
    note : str
        How loss factors were replaced; empty if there are none.
    """

    system: LinearSystem
    chain: Chain | None
    note: str


def viscous_system(
    chain_or_system: Chain | LinearSystem,
    *,
    loss_as: LossAs = "viscous",
    loss_frequency: float | None = None,
    magnifier: float | None = None,
    modal_damping: ArrayLike | None = None,
) -> ViscousSystem:
    """Return the system with loss factors replaced by viscous damping, and modal damping added.

    Parameters
    ----------
    loss_as : {"viscous", "modal"}
        "viscous": each element of loss factor eta and stiffness k gets a damper of
        eta k / w, exact at one angular frequency w. "modal": each elastic mode gets half of its own
        loss factor as share of critical damping, exact at the frequency of each mode, without the
        coupling of modes by damping.
    loss_frequency : float, optional
        w for "viscous" [rad/s]; the lowest elastic mode's by default.
    magnifier : float, optional
        Adds to each elastic mode the damping of this magnifier, 1 / (2 magnifier) of critical.
    modal_damping : float or array_like, optional
        Adds to each elastic mode this share of critical damping.

    Raises
    ------
    InputError
        If a number is out of range, the way is unknown, both magnifier and modal damping are given,
        or a loss frequency is given that is not used, or springs vary with frequency or speed.

    Notes
    -----
    Under harmonic motion of angular frequency W a loss factor causes the force i eta k x, a damper
    i W c x: with c = eta k / w the energy lost in a cycle is exact at W = w and wrong by W / w
    elsewhere. The mode of natural frequency w_r and shape x_r has the loss factor
    x_r' H x_r / (w_r^2 x_r' M x_r).
    """
    chain, system = chain_and_system(chain_or_system)
    if system.varying:
        raise InputError(
            "chain: given springs that vary with frequency, speed or amplitude; allowed are constant ones "
            "for motion over time, because one motion has many frequencies: replace(chain, varying=()) keeps "
            "the constant stiffness."
        )
    why = "these are the ways to put viscous damping in the place of loss factors"
    check_choice("loss_as", loss_as, get_args(LossAs), why)
    frequency = None
    if loss_frequency is not None:
        frequency = positive_number(
            "loss_frequency", loss_frequency, "rad/s", "damping is right at one frequency"
        )
        if loss_as == "modal":
            raise InputError(
                f"loss_frequency: given {frequency:g} rad/s; allowed is none with loss_as='modal', "
                "because there each mode takes its own frequency."
            )
    replaced, note = system, ""
    if np.any(system.loss):
        count = system.rigid.shape[1]
        replaced = replace(system, loss=np.zeros_like(system.loss))
        natural, shapes = system.natural[count:], system.shapes[:, count:]
        if loss_as == "modal":
            losses = np.sum(shapes * (system.loss @ shapes), axis=0) / natural**2
            note = "Loss factors as modal damping, half the loss factor of each mode."
            replaced = replaced.with_modal_damping(0.5 * losses)
        else:
            right_at = float(natural[0]) if frequency is None else frequency
            which = ", that of the lowest elastic mode" if frequency is None else ""
            note = (
                "Loss factors as viscous damping of the elements, equal at "
                f"{right_at / (2.0 * np.pi):.6g} Hz{which}."
            )
            replaced = replace(replaced, damping=system.damping + system.loss / right_at)
    return ViscousSystem(replaced.with_added_damping(magnifier, modal_damping), chain, note)


# [share] By which an angle may miss the ends of a curve.
ROUND_OFF = 1e-14


@frozen("times [s]", "speeds [rad/s]", "duration [s]", eq=False)
class SpeedCurve:
    """The speed over time, linear between the values given; the angle is its integral.

    Parameters
    ----------
    times : array_like of shape (m,)
        Ascending, two or more [s].
    speeds : array_like of shape (m,)
        Above zero [rad/s].
    start_angle_deg : float, optional
        Shaft angle at the first time [deg].

    Raises
    ------
    InputError
        If times do not ascend, a speed is not above zero, or lengths differ.

    Examples
    --------
    >>> curve = SpeedCurve.ramp(50.0, 150.0, acceleration=20.0)
    >>> curve.duration, float(curve.angle_deg(curve.duration).round())
    (5.0, 28648.0)
    """

    times: Array
    speeds: Array
    _: KW_ONLY
    start_angle_deg: float = 0.0

    def __post_init__(self) -> None:
        times = finite_vector("times", self.times)
        speeds = positive_vector("speeds", self.speeds, "rad/s", "the shaft turns forward")
        if times.size < 2 or times.size != speeds.size:
            raise InputError(
                f"times: given {times.size} for {speeds.size} speeds; allowed are two or more, one for "
                "each speed, because the curve runs from point to point."
            )
        check_ascending("times", times, " s", "time does not run back")
        object.__setattr__(self, "times", read_only(times))
        object.__setattr__(self, "speeds", read_only(speeds))
        object.__setattr__(
            self, "start_angle_deg", float(finite_array("start_angle_deg", self.start_angle_deg))
        )

    @classmethod
    def constant(
        cls, speed: float, duration: float, *, start_angle_deg: float = 0.0
    ) -> "SpeedCurve":
        """Return a constant speed [rad/s] over a time [s]."""
        end = positive_number("duration", duration, "s", "time runs forward")
        return cls(np.array([0.0, end]), np.array([speed, speed]), start_angle_deg=start_angle_deg)

    @classmethod
    def ramp(
        cls,
        start_speed: float,
        end_speed: float,
        *,
        acceleration: float | None = None,
        duration: float | None = None,
        start_angle_deg: float = 0.0,
    ) -> "SpeedCurve":
        """Return a uniform run-up, or run-down, from time zero.

        Parameters
        ----------
        start_speed, end_speed : float
            [rad/s]
        acceleration : float, optional
            Its magnitude, for either direction [rad/s^2].
        duration : float, optional
            Alternatively, duration [s].
        start_angle_deg : float, optional
            [deg]

        Raises
        ------
        InputError
            If a number is not above zero, the speeds are equal, or not exactly one of acceleration
            and duration is given.
        """
        start = positive_number("start_speed", start_speed, "rad/s", "the shaft turns forward")
        end = positive_number("end_speed", end_speed, "rad/s", "the shaft turns forward")
        if (acceleration is None) == (duration is None):
            raise InputError(
                f"acceleration: given {acceleration} with a duration of {duration}; allowed is one of "
                "both, because each follows from the other."
            )
        if start == end:
            raise InputError(
                f"end_speed: given {end:g} rad/s, that of the start; allowed is another, because a "
                "ramp changes the speed."
            )
        if acceleration is not None:
            rate = positive_number("acceleration", acceleration, "rad/s^2", "it is a size")
            time = abs(end - start) / rate
        else:
            assert duration is not None
            time = positive_number("duration", duration, "s", "time runs forward")
        return cls(np.array([0.0, time]), np.array([start, end]), start_angle_deg=start_angle_deg)

    @classmethod
    def sampled(
        cls,
        speed: Callable[[float], float],
        duration: float,
        *,
        samples: int = 1001,
        start_angle_deg: float = 0.0,
    ) -> "SpeedCurve":
        """Return the linear pieces through a function time [s] -> speed [rad/s] from time zero."""
        end = positive_number("duration", duration, "s", "time runs forward")
        count = whole_number("samples", samples, 2, "start and end are among them")
        times = np.linspace(0.0, end, count)
        return cls(
            times,
            np.array([speed(time) for time in times.tolist()]),
            start_angle_deg=start_angle_deg,
        )

    @property
    def duration(self) -> float:
        """From first to last time [s]."""
        return float(self.times[-1] - self.times[0])

    def speed(self, time: ArrayLike) -> Array:
        """Return the speed at times [s] within the curve [rad/s].

        Raises
        ------
        InputError
            If a time is outside.
        """
        return np.asarray(np.interp(self._checked(time), self.times, self.speeds))

    def angle_deg(self, time: ArrayLike) -> Array:
        """Return the shaft angle at times [s] within the curve [deg].

        Raises
        ------
        InputError
            If a time is outside.
        """
        times = self._checked(time)
        piece = np.clip(np.searchsorted(self.times, times, "right") - 1, 0, self.times.size - 2)
        since = times - self.times[piece]
        rates = np.diff(self.speeds) / np.diff(self.times)
        return np.degrees(
            self._angles[piece] + since * (self.speeds[piece] + 0.5 * rates[piece] * since)
        )

    def time_at(self, *, angle_deg: ArrayLike) -> Array:
        """Return the times at which the shaft passes angles [deg], such as firing angles.

        Raises
        ------
        InputError
            If an angle is not passed.
        """
        angles = radians_of("angle_deg", angle_deg)
        known = self._angles
        # The ends as `angle_deg` gives them differ from these by round-off.
        room = ROUND_OFF * max(abs(known[0]), abs(known[-1]))
        if np.any((angles < known[0] - room) | (angles > known[-1] + room)):
            raise InputError(
                f"angle_deg: given {np.min(angle_deg):g} to {np.max(angle_deg):g}; allowed are "
                f"{math.degrees(known[0]):g} to {math.degrees(known[-1]):g}, because the shaft passes those."
            )
        piece = np.clip(np.searchsorted(known, angles, "right") - 1, 0, known.size - 2)
        rate = (np.diff(self.speeds) / np.diff(self.times))[piece]
        start, past = self.speeds[piece], np.clip(angles, known[0], known[-1]) - known[piece]
        # Smaller root of rate t^2 / 2 + start t = past, in the form that holds for rate 0.
        root = np.sqrt(np.maximum(start**2 + 2.0 * rate * past, 0.0))
        return np.asarray(self.times[piece] + 2.0 * past / (start + root))

    @property
    def _angles(self) -> Array:
        """Shaft angle at the times given [rad], (m,)."""
        means = 0.5 * (self.speeds[1:] + self.speeds[:-1])
        return math.radians(self.start_angle_deg) + np.concatenate(
            ([0.0], np.cumsum(means * np.diff(self.times)))
        )

    def _checked(self, time: ArrayLike) -> Array:
        times = finite_array("time", time)
        room = 1e-12 * self.duration
        if np.any((times < self.times[0] - room) | (times > self.times[-1] + room)):
            raise InputError(
                f"time: given {float(np.min(times)):g} to {float(np.max(times)):g} s; allowed are "
                f"{self.times[0]:g} to {self.times[-1]:g} s, because the speed is known there."
            )
        return times

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the speed over the time."""
        axes = new_axes(axes, height=3.4)
        draw_over_time(axes, self.times, {"speed": RPM * self.speeds}, SPEED_LABEL)
        write_title(axes, "Speed over time")
        return axes


# Shaft angles times the highest order that one step may cover [rad], by default and at most. A
# polynomial through the points of a step misses a sine at its ends by 1.5e-6 of the sixth power.
USUAL_REACH, WIDEST_REACH = 0.5, 2.0
# Most turns that a cycle may take for all orders to repeat.
MOST_TURNS = 12
# Speeds count as those of the excitation within this share.
SAME_SPEED = 1e-9
# Steps of each stretch at which the error of the polynomials is looked at.
CHECKED = 64


@dataclass(frozen=True, eq=False)
class OrderForces:
    """Forces on the modes as piecewise polynomials of the speed.

    Parameters
    ----------
    orders : ndarray of shape (K,)
    over_speed : OverSpeed
        Their amplitudes on the modes.
    coefficients : ndarray of shape (pieces, 2 K, powers, q)
        The same for the cosine, then for the sine of each order.
    """

    orders: Array
    over_speed: OverSpeed
    coefficients: Array

    @classmethod
    def of(cls, excitation: OrderExcitation, inputs: Array) -> "OrderForces":
        """Return the forces on modes, inputs (n, q) taking forces on nodes to those on modes.

        Between the speeds of the excitation they are interpolated as by `at_speeds`.
        """
        if excitation.forces.shape[2] != len(inputs):
            raise InputError(
                f"excitation: given forces on {excitation.forces.shape[2]} nodes; allowed is one on "
                f"each of {len(inputs)}, because the system has so many."
            )
        over_speed = OverSpeed.of(excitation.speeds, excitation.forces @ inputs)
        powers = over_speed.coefficients.swapaxes(1, 2)
        both = np.concatenate((powers.real, -powers.imag), axis=1)
        return cls(excitation.orders, over_speed, np.ascontiguousarray(both))

    def check_speeds(self, lowest: float, highest: float) -> None:
        """Refuse speeds for which the forces are unknown."""
        known = self.over_speed.speeds[[0, -1]]
        if lowest < known[0] * (1.0 - SAME_SPEED) or highest > known[1] * (1.0 + SAME_SPEED):
            asked = f"{lowest:g}" if lowest == highest else f"{lowest:g} to {highest:g}"
            allowed = f"{known[0]:g}" if known.size == 1 else f"{known[0]:g} to {known[1]:g}"
            raise InputError(
                f"speed: given {asked} rad/s; allowed is {allowed} rad/s, because the excitation is "
                "known there."
            )

    def at(self, angles: Array, speeds: Array) -> Array:
        """Return the forces (m, q) at shaft angles [rad] and speeds [rad/s], both (m,)."""
        turning = np.outer(angles, self.orders)
        waves = np.concatenate((np.cos(turning), np.sin(turning)), axis=1)
        places = self.over_speed.pieces(speeds)
        forces = np.empty((angles.size, self.coefficients.shape[-1]))
        for piece in np.unique(places).tolist():
            rows = np.flatnonzero(places == piece)
            coefficients = self.coefficients[piece]
            terms = waves[rows] @ coefficients.reshape(len(coefficients), -1)
            terms = terms.reshape(rows.size, *coefficients.shape[1:])
            above = (speeds[rows] - self.over_speed.speeds[piece])[:, np.newaxis]
            total = terms[:, 0]
            for power in range(1, terms.shape[1]):
                total = total * above + terms[:, power]
            forces[rows] = total
        return forces


def checked_step(step: float, orders: Array, highest_speed: float) -> float:
    """Return a step [s] that resolves the orders."""
    fastest = float(orders[-1]) * highest_speed
    if step * fastest > WIDEST_REACH * (1.0 + 1e-9):
        raise InputError(
            f"step: given {step:g} s; allowed is {WIDEST_REACH / fastest:.4g} s or less, because order "
            f"{orders[-1]:g} repeats every {2.0 * np.pi / fastest:.4g} s at {highest_speed:g} rad/s."
        )
    return step


def cycle_turns(orders: Array) -> int:
    """Return the least number of revolutions after which all orders repeat."""
    for turns in range(1, MOST_TURNS + 1):
        cycles = orders * turns
        if np.all(np.abs(cycles - np.round(cycles)) <= 1e-9 * np.maximum(cycles, 1.0)):
            return turns
    raise InputError(
        f"orders: given {', '.join(f'{order:g}' for order in orders[:8].tolist())}; allowed are orders "
        f"that all repeat within {MOST_TURNS} turns, because the motion is sought over a cycle."
    )


def sampling_note(natural: Array, step: float) -> str:
    """State which modes the samples at each step are too few to show, or nothing."""
    unseen = int(np.count_nonzero(natural * step > np.pi))
    if not unseen:
        return ""
    return (
        f"Of the {natural.size} natural frequencies the highest {unseen}, above "
        f"{0.5 / step:.4g} Hz, are followed exactly, but the results at each step are too few to show "
        "them."
    )


def midpoint_residual(forces: Array) -> tuple[Array, Integers]:
    """Return the errors of the polynomials of some steps at their midpoints, (k, q), and those steps.

    Parameters
    ----------
    forces : ndarray of shape (m, POINTS, q)
        At the points of m steps.
    """
    chosen = np.unique(np.linspace(0, len(forces) - 1, CHECKED).astype(int))
    powers = 0.5 ** np.arange(POINTS)
    middle = powers @ np.linalg.inv(np.vander(PLACES, POINTS, increasing=True))
    return np.tensordot(forces[chosen], middle, axes=(1, 0)), chosen


# Times closer than this share of a step are one.
SAME_TIME = 1e-6
# In a piece of time; far more than fit in memory.
MOST_STEPS = 1e15


@dataclass(frozen=True)
class LoadStep:
    """A constant torque or force that begins at a time and remains.

    Parameters
    ----------
    time : float
        [s]
    node : int
        Its node, from 0.
    load : float
        Torque in the sense of rotation [N m], or force [N]; a brake is negative.
    rise : float, optional
        Time of its linear increase from zero [s].

    Raises
    ------
    InputError
        If a value is not finite, or the rise is negative.
    """

    time: float
    node: int
    load: float
    rise: float = 0.0

    def __post_init__(self) -> None:
        finite_array("load_step.time", self.time)
        finite_array("load_step.load", self.load)
        nonnegative_number("load_step.rise", self.rise, "s", "time runs forward")

    def share(self, times: Array) -> Array:
        """Return which share of the load acts at times [s]."""
        if self.rise == 0.0:
            return np.where(times >= self.time, 1.0, 0.0)
        return np.asarray(np.clip((times - self.time) / self.rise, 0.0, 1.0))


@dataclass(frozen=True)
class TimeSegment:
    """A segment of time from its start [s] in so many even steps [s]."""

    start: float
    step: float
    steps: int


@dataclass(frozen=True, eq=False)
class AppliedForces:
    """All forces on the modes over time.

    Parameters
    ----------
    excitations : tuple of (float, OrderForces)
        Each with its start time [s], ascending.
    loads : tuple of LoadStep
    inputs : ndarray of shape (n, q)
        Forces on the nodes to forces on the modes, by multiplication from the right.
    """

    curve: SpeedCurve
    excitations: tuple[tuple[float, OrderForces], ...]
    loads: tuple[LoadStep, ...]
    inputs: Array

    @classmethod
    def of(
        cls,
        curve: SpeedCurve,
        excitation: OrderExcitation,
        changes: Sequence[tuple[float, OrderExcitation]],
        loads: Sequence[LoadStep],
        inputs: Array,
    ) -> "AppliedForces":
        """Return the forces; arguments as for `transient_motion`."""
        for place, load in enumerate(loads):
            node_index(f"loads[{place}].node", load.node, len(inputs))
        begins = [float(curve.times[0])]
        for place, (time, _) in enumerate(changes):
            value = float(finite_array(f"changes[{place}]", time))
            if not begins[-1] < value < curve.times[-1]:
                raise InputError(
                    f"changes[{place}]: given a time of {value:g} s; allowed are ascending times above "
                    f"{begins[-1]:g} s and below {curve.times[-1]:g} s, because each excitation takes over "
                    "from the one before within the run."
                )
            begins.append(value)
        ends = [*begins[1:], float(curve.times[-1])]
        in_turn = []
        for begin, end, exciting in zip(
            begins, ends, (excitation, *(later for _, later in changes)), strict=True
        ):
            forces = OrderForces.of(exciting, inputs)
            within = (curve.times > begin) & (curve.times < end)
            passed = np.append(curve.speed([begin, end]), curve.speeds[within])
            forces.check_speeds(float(passed.min()), float(passed.max()))
            in_turn.append((begin, forces))
        return cls(curve, tuple(in_turn), tuple(loads), inputs)

    @property
    def orders(self) -> Array:
        """All orders that act at some time, ascending."""
        return np.unique(np.concatenate([excitation.orders for _, excitation in self.excitations]))

    def at(self, starts: Array, step: float, places: Array) -> Array:
        """Return the forces (m, places, q) at points of steps without a change inside."""
        times = (starts[:, np.newaxis] + step * places).reshape(-1)
        middle = float(starts[0]) + 0.5 * step
        by_orders = next(
            forces for begins, forces in reversed(self.excitations) if begins <= middle
        )
        forces = by_orders.at(np.radians(self.curve.angle_deg(times)), self.curve.speed(times))
        for load in self.loads:
            forces += load.load * load.share(times)[:, np.newaxis] * self.inputs[load.node]
        return forces.reshape(starts.size, places.size, -1)


def time_segments(acting: AppliedForces, longest: float) -> list[TimeSegment]:
    """Return segments of time, each of even steps, between discontinuities."""
    curve = acting.curve
    first, last = float(curve.times[0]), float(curve.times[-1])
    inner = [
        *curve.times.tolist(),
        *(begins for begins, _ in acting.excitations),
        *(time for load in acting.loads for time in (load.time, load.time + load.rise)),
    ]
    edges = [first]
    for time in sorted(inner):
        if edges[-1] + SAME_TIME * longest < time < last - SAME_TIME * longest:
            edges.append(time)
    pieces = []
    for start, end in pairwise([*edges, last]):
        count = min((end - start) / longest * (1.0 - 1e-12), MOST_STEPS)
        steps = max(1, math.ceil(count))
        pieces.append(TimeSegment(start, (end - start) / steps, steps))
    return pieces
