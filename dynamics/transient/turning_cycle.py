"""Steady running of a rotating chain with variable inertia at a mean speed."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.checks.scalars import whole_number
from crankbase.errors import InputError
from crankbase.library_types import Dataset
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.cycle import even_angles
from dynamics.running_limits import MOST_EVALUATIONS, evaluation_counter
from dynamics.transient.cycle_motion import CycleMotion
from dynamics.transient.order_forces import cycle_turns
from dynamics.transient.steady import spring_torques
from dynamics.transient.turning_chain import TurningChain
from dynamics.transient.turning_motion import WORKS, IntegrationMethod, TurningState, check_method

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
    chain : TurningChain
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

        Returns
        -------
        xarray.Dataset
            Units in the ``attrs["units"]`` of each array and coordinate.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
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

    Returns
    -------
    TurningCycle

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
        found = self.integrate(state, states, [self.period])
        ends = found.y[:, -1].reshape(states.shape)
        missed = (ends - states)[:, [*range(self.count), -1]]
        missed[:, :-1] /= state.sizes[: self.count]
        missed[:, -1] /= state.sizes[0] * self.period
        return np.asarray(missed)

    def integrate(self, state: TurningState, states: FloatArray, times: ArrayLike) -> Any:
        """Integrate over the cycle; refuse one that the integration did not get through."""
        found = state.integrate(
            states, (0.0, self.period), self.method, self.evaluated, t_eval=times
        )
        if not found.success:
            raise InputError(self.unsteady())
        return found

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
    found = shooting.integrate(state, states, times)
    count = chain.even.size
    values = found.y.T
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
