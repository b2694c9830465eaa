"""All forces on a system over time: excitations that replace each other, and loads."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from crankbase.checks.arrays import FloatArray, finite_array, nonnegative_number
from crankbase.errors import InputError
from dynamics.indices import node_index
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.order_forces import OrderForces
from dynamics.transient.speed_curve import SpeedCurve

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

    def share(self, times: FloatArray) -> FloatArray:
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
    curve : SpeedCurve
    excitations : tuple of (float, OrderForces)
        Each with its start time [s], ascending.
    loads : tuple of LoadStep
    inputs : ndarray of shape (n, q)
        Forces on the nodes to forces on the modes, by multiplication from the right.
    """

    curve: SpeedCurve
    excitations: tuple[tuple[float, OrderForces], ...]
    loads: tuple[LoadStep, ...]
    inputs: FloatArray

    @classmethod
    def of(
        cls,
        curve: SpeedCurve,
        excitation: OrderExcitation,
        changes: Sequence[tuple[float, OrderExcitation]],
        loads: Sequence[LoadStep],
        inputs: FloatArray,
    ) -> "AppliedForces":
        """Return the forces; arguments as for `transient_motion`.

        Raises
        ------
        InputError
            If times do not ascend within the run, a node does not exist, or forces are unknown at
            the speeds at which they act.
        """
        for place, load in enumerate(loads):
            node_index(f"loads[{place}].node", load.node, len(inputs))
        in_turn = _successive_excitations(excitation, changes, curve, inputs)
        return cls(curve, in_turn, tuple(loads), inputs)

    @property
    def orders(self) -> FloatArray:
        """All orders that act at some time, ascending."""
        return np.unique(np.concatenate([own.orders for _, own in self.excitations]))

    def at(self, starts: FloatArray, step: float, places: FloatArray) -> FloatArray:
        """Return the forces (m, places, q) at points of steps without a change inside."""
        times = (starts[:, np.newaxis] + step * places).reshape(-1)
        middle = float(starts[0]) + 0.5 * step
        by_orders = next(own for begins, own in reversed(self.excitations) if begins <= middle)
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


def _successive_excitations(
    excitation: OrderExcitation,
    changes: Sequence[tuple[float, OrderExcitation]],
    speed: SpeedCurve,
    inputs: FloatArray,
) -> tuple[tuple[float, OrderForces], ...]:
    """Return the forces on the modes and the start time of each, and check their speeds."""
    begins = [float(speed.times[0])]
    for place, (time, _) in enumerate(changes):
        value = float(finite_array(f"changes[{place}]", time))
        if not begins[-1] < value < speed.times[-1]:
            raise InputError(
                f"changes[{place}]: given a time of {value:g} s; allowed are ascending times above "
                f"{begins[-1]:g} s and below {speed.times[-1]:g} s, because each excitation takes over "
                "from the one before within the run."
            )
        begins.append(value)
    ends = [*begins[1:], float(speed.times[-1])]
    acting = []
    for begin, end, own in zip(
        begins, ends, (excitation, *(own for _, own in changes)), strict=True
    ):
        forces = OrderForces.of(own, inputs)
        within = (speed.times > begin) & (speed.times < end)
        passed = np.append(speed.speed([begin, end]), speed.speeds[within])
        forces.check_speeds(float(passed.min()), float(passed.max()))
        acting.append((begin, forces))
    return tuple(acting)
