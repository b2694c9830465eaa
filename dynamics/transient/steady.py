"""Steady motion at one speed by integration through time."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import (
    ComplexArray,
    FloatArray,
    finite_array,
    positive_number,
)
from crankbase.checks.scalars import whole_number
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import grid
from crankbase.units.quantity import format_quantity
from dynamics.chains.chain import Chain
from dynamics.cycle import even_angles
from dynamics.plots.angle_curves import draw_over_angle
from dynamics.plots.coordinates import angle_axis, name_axis
from dynamics.response.linear_system import LinearSystem
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.curve_selection import Moving, axis_names, select_curve, units_of
from dynamics.transient.envelope import half_peak_to_peak
from dynamics.transient.order_forces import (
    USUAL_REACH,
    OrderForces,
    checked_step,
    cycle_turns,
)
from dynamics.transient.propagator import PLACES, Propagator, StateSpace
from dynamics.transient.viscous import LossAs, ViscousSystem, viscous_system

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

# An undamped mode that comes round within this share of a whole number of its periods, while forces
# go on driving it there, answers without bounds; as in `harmonic_answer`.
UNBOUNDED_WITHIN = 1e-9
# Samples between samples among which extremes over a cycle are looked for.
FINER = 4
# What drives such a mode is nothing below this share of the largest change over a cycle.
NO_DRIVE = 1e-9


@summarized("speed [rad/s]", "turns", "amplitude", "torque_amplitude", "unbounded", "note")
@dataclass(frozen=True, eq=False)
class SteadyMotion:
    """Vibration that repeats every cycle at a constant speed.

    Parameters
    ----------
    speed : float
        [rad/s]
    turns : int
        Of the shaft in one cycle.
    shaft_angle : ndarray of shape (m,)
        Even over the cycle, without its end [rad].
    motion : ndarray of shape (m, n)
        Of the nodes [rad or m]; zero if it is unbounded. Rigid-body motion of a free system is that
        which the forces bring about, of mean zero.
    torque : ndarray of shape (m, e)
        Of the spring of each element of a chain [N m or N]; e is 0 for other systems.
    unbounded : bool
        Whether an undamped mode is excited at its own frequency: there is no steady motion.
    step : float
        [s]
    system : ViscousSystem
        What vibrates.
    note : str
        How loss factors were replaced; empty if there are none.
    """

    speed: float
    turns: int
    shaft_angle: FloatArray
    motion: FloatArray
    torque: FloatArray
    unbounded: bool
    step: float
    system: ViscousSystem
    note: str

    @property
    def time(self) -> FloatArray:
        """Time from shaft angle zero [s], shape (m,)."""
        return self.shaft_angle / self.speed

    @property
    def amplitude(self) -> FloatArray:
        """Half of the way between the extremes of each node [rad or m], (n,); inf if unbounded."""
        return self._half_way(self.motion)

    @property
    def torque_amplitude(self) -> FloatArray:
        """Half of the way between the extremes of each element [N m or N], (e,)."""
        return self._half_way(self.torque)

    def phasors(self, orders: ArrayLike) -> ComplexArray:
        """Return X_k of the motion Re sum X_k exp(i k phi), shape (K, n).

        Raises
        ------
        InputError
            If an order does not repeat with the cycle, or the samples cannot show it.
        """
        return phasors_over_cycle(orders, self.shaft_angle, self.motion, self.turns)

    def _half_way(self, values: FloatArray) -> FloatArray:
        if self.unbounded:
            return np.full(values.shape[1], np.inf)
        return half_peak_to_peak_over_cycle(values)

    def plot(
        self, axes: "Axes | None" = None, place: int | str = 0, *, quantity: Moving = "torque"
    ) -> "Axes":
        """Draw one element or node over the shaft angle of the cycle.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; those of a new figure if not given.
        place : int or str, optional
            Element, or node for "twist" and "displacement", by number from 0 or name.
        quantity : {"torque", "force", "twist", "displacement"}, optional
            Torque or force in the spring of an element, or twist or displacement of a node.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If it is not the motion of a chain, or there is no such place or quantity, or it is unbounded.
        """
        if self.unbounded:
            raise InputError(
                f"speed: given {format_quantity(self.speed, 'rad/s', 5)}; allowed are speeds with a steady "
                "vibration, because this one grows without bounds."
            )
        picked = select_curve(self.system.chain, quantity, place, self.motion, self.torque)
        axes = new_axes(axes)
        draw_over_angle(axes, self.shaft_angle, {picked.name: picked.values}, picked.label)
        write_title(axes, f"{picked.name}, {format_quantity(self.speed, 'rad/s', 5)}")
        return axes

    def to_xarray(self, quantity: Moving | None = None) -> "Dataset":
        """Return motions and torques over shaft angle, node and element.

        Parameters
        ----------
        quantity : {"torque", "force", "twist", "displacement"}, optional
            What the values are: torque or twist of a torsional chain, force or displacement of an axial
            one. A chain does not say which it is: without it units are "rad or m" and "N m or N".

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
        moved, loaded = units_of(quantity)
        nodes, elements = axis_names(self.system.chain, self.motion.shape[1], self.torque.shape[1])
        return grid(
            {
                "motion": (("shaft_angle", "node"), self.motion, moved, "motion"),
                "torque": (("shaft_angle", "element"), self.torque, loaded, "load of the spring"),
            },
            {
                "shaft_angle": angle_axis(self.shaft_angle),
                "node": name_axis(nodes, "node"),
                "element": name_axis(elements, "element"),
            },
        )


def phasors_over_cycle(
    orders: ArrayLike, angles: FloatArray, values: FloatArray, turns: int
) -> ComplexArray:
    """Return Y_k (K, n) of what repeats after turns, mean + Re sum Y_k exp(i k phi), at even angles.

    Raises
    ------
    InputError
        If an order is not above zero, does not repeat with the cycle, or the samples cannot show it.
    """
    given = np.atleast_1d(finite_array("orders", orders))
    cycles = given * turns
    whole = np.round(cycles)
    count = angles.size
    if np.any((np.abs(cycles - whole) > 1e-9 * whole) | (whole < 1) | (2.0 * whole >= count)):
        raise InputError(
            f"orders: given {given.tolist()}; allowed are multiples of {1.0 / turns:g} above zero and "
            f"below {0.5 * count / turns:g}, because the cycle has {turns} turns and {count} samples."
        )
    return np.asarray(np.exp(-1j * np.outer(given, angles)) @ values * (2.0 / count))


def half_peak_to_peak_over_cycle(values: FloatArray) -> FloatArray:
    """Return half of the peak-to-peak value over a cycle, (k,), from its samples (m, k)."""
    count = len(values)
    spectrum = np.fft.rfft(values, axis=0)
    finer = np.fft.irfft(spectrum, FINER * count, axis=0) * FINER
    # One more sample on each side, so that the extremes have neighbors.
    return half_peak_to_peak(np.vstack((finer[-1:], finer, finer[:1])))


def steady_motion(
    chain_or_system: Chain | LinearSystem,
    excitation: OrderExcitation,
    speed: float,
    *,
    loss_as: LossAs = "viscous",
    loss_frequency: float | None = None,
    magnifier: float | None = None,
    modal_damping: ArrayLike | None = None,
    steps: int | None = None,
) -> SteadyMotion:
    """Find the steady motion at a speed by integrating over one cycle.

    Parameters
    ----------
    chain_or_system : Chain or LinearSystem
    excitation : OrderExcitation
        Between its speeds forces are interpolated as by `OrderExcitation.at_speeds`.
    speed : float
        Within those of the excitation [rad/s].
    loss_as, loss_frequency, magnifier, modal_damping
        As for `viscous_system`.
    steps : int, optional
        Per cycle, even; by default so many that each covers half a radian of the highest order.

    Returns
    -------
    SteadyMotion

    Raises
    ------
    InputError
        If the speed is not above zero or outside of the excitation's, the steps do not resolve the
        highest order, orders have no common cycle, or damping is out of range.

    Notes
    -----
    Over a cycle of time T the state becomes z(T) = Phi z(0) + z_p, so that it repeats for
    (I - Phi) z(0) = z_p. Nothing depends on the place of rigid motions: it is no unknown, but that
    it repeats is an equation, which also settles a speed that no damping holds. Then the mean place
    over the cycle is taken off.
    """
    at_speed = positive_number("speed", speed, "rad/s", "the shaft turns forward")
    system = viscous_system(
        chain_or_system,
        loss_as=loss_as,
        loss_frequency=loss_frequency,
        magnifier=magnifier,
        modal_damping=modal_damping,
    )
    return steady_from(system, excitation, at_speed, 0.0, steps)[0]


def steady_from(
    system: ViscousSystem,
    excitation: OrderExcitation,
    speed: float,
    start_angle: float,
    steps: int | None = None,
) -> tuple[SteadyMotion, FloatArray]:
    """Return the steady motion over a cycle from a shaft angle on, and the state at its start."""
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
        shaft_angle=angles,
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
    """Return the state that comes back after the cycle, and whether none does."""
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
