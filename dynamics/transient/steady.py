"""Steady motion at one speed by integration through time."""

import math
from dataclasses import dataclass
from typing import Unpack

import numpy as np

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.checks.scalars import whole_number
from crankbase.library_types import Dataset
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.cycle import even_angles
from dynamics.response.linear_system import LinearSystem
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.curve_selection import Moving
from dynamics.transient.cycle_motion import CycleMotion
from dynamics.transient.order_forces import USUAL_REACH, OrderForces, checked_step, cycle_turns
from dynamics.transient.propagator import PLACES, Propagator, StateSpace
from dynamics.transient.viscous import ViscousDamping, ViscousSystem, viscous_system

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

        Parameters
        ----------
        quantity : {"torque", "force", "twist", "displacement"}, optional
            Quantity of the values: torque or twist of a torsional chain, force or displacement of an axial
            one. A chain does not determine it: by default units are "rad or m" and "N m or N".

        Returns
        -------
        xarray.Dataset
            Units in the ``attrs["units"]`` of each array and coordinate.

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
    chain_or_system : Chain or LinearSystem
    excitation : OrderExcitation
        Between its speeds forces are interpolated as by `OrderExcitation.at_speeds`.
    speed : float
        Within those of the excitation [rad/s].
    steps : int, optional
        Number of steps per cycle; by default each covers half a radian of the highest order.
    **damping
        loss_as, loss_frequency, magnifier, modal_damping, as for `viscous_system`.

    Returns
    -------
    SteadyMotion

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
    given = forces.at(points, np.full(points.size, speed)).reshape(count, PLACES.size, -1)
    start, unbounded = _periodic_start(space, propagator, given, period)
    states = np.vstack((start, propagator.propagate(start, given)[:-1]))
    if unbounded:
        states[:] = 0.0
    places = slice(len(start) - space.rigid, len(start))
    mean = states[:, places].mean(axis=0)
    states[:, places] -= mean
    motion, _ = space.motion(states)
    found = SteadyMotion(
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
    return found, states[0]


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
    own = np.sqrt(inward**2 @ np.concatenate((elastic, elastic, np.zeros(space.rigid))) ** 2)
    lost = singular <= UNBOUNDED_WITHIN * own * period
    largest = float(np.max(np.abs(right), initial=0.0))
    unbounded = bool(np.any(np.abs(drive[lost]) > NO_DRIVE * largest))
    start = np.zeros(size)
    if unbounded:
        return start, True
    start[:free] = inward.T @ np.divide(drive, singular, out=np.zeros(free), where=~lost)
    return start, False
