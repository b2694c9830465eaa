"""Motions of a chain over time: steady, run-up, load steps; their curves, envelopes and diagrams."""

import contextlib
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, Literal, TypeAlias, Unpack

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, ComplexArray, finite_array, positive_number
from crankbase.choices import check_choice, whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, Dataset, grid
from crankbase.quantity import RPM
from crankbase.sentences import amount
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain
from dynamics.cycle import even_angles
from dynamics.indices import index_of_name, node_index
from dynamics.plots.curves import (
    MOVING,
    SI_UNITS,
    Coordinate,
    SelectedCurve,
    angle_axis,
    draw_named_curves,
    draw_over_angle,
    draw_over_time,
    name_axis,
    plot_run,
    time_axis,
)
from dynamics.response.linear_system import LinearSystem
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.propagator import (
    PLACES,
    USUAL_REACH,
    AppliedForces,
    LoadStep,
    OrderForces,
    Propagator,
    SpeedCurve,
    StateSpace,
    TimeSegment,
    ViscousDamping,
    ViscousSystem,
    checked_step,
    cycle_turns,
    midpoint_residual,
    sampling_note,
    time_segments,
    viscous_system,
)

Moving: TypeAlias = Literal["torque", "force", "twist", "displacement"]
OF_ELEMENTS = ("torque", "force")


def select_curve(
    chain: Chain | None, quantity: Moving, place: int | str, motion: Array, torque: Array
) -> SelectedCurve:
    """Select the motion of a node or the load of an element.

    Parameters
    ----------
    quantity : {"torque", "force", "twist", "displacement"}
        Torque or force of an element, or twist or displacement of a node.
    place : int or str
        Number from 0, or name.
    motion : ndarray of shape (m, n)
    torque : ndarray of shape (m, e)
    """
    if chain is None or not isinstance(quantity, str) or quantity not in MOVING:
        raise InputError(
            f"quantity: given {quantity!r}; allowed are {', '.join(MOVING)} of a run of a chain, because "
            "its elements and nodes have names."
        )
    of_element = quantity in OF_ELEMENTS
    names, values = (chain.elements, torque) if of_element else (chain.names, motion)
    what = "the chain's elements" if of_element else "the chain's nodes"
    index = index_of_name("place", place, names, what, "a diagram shows one of them")
    label, factor = MOVING[quantity]
    return SelectedCurve(factor * values[:, index], index, names[index], label, factor, of_element)


def axis_names(chain: Chain | None, nodes: int, elements: int) -> tuple[list[str], list[str]]:
    """Return the names of nodes and elements for a table, numbers from 0 if there is no chain."""
    if chain is None:
        return [str(number) for number in range(nodes)], [str(number) for number in range(elements)]
    return list(chain.names), list(chain.elements)


def units_of(quantity: Moving | None) -> tuple[str, str]:
    """Return the units in SI of the motion of nodes and of the loads of elements.

    Parameters
    ----------
    quantity : {"torque", "force", "twist", "displacement"} or None
        That of a torsional or of an axial chain; None for a chain of unknown kind.

    Examples
    --------
    >>> units_of("twist"), units_of("displacement"), units_of(None)
    (('rad', 'N m'), ('m', 'N'), ('rad or m', 'N m or N'))
    """
    if quantity is None:
        return "rad or m", "N m or N"
    check_choice("quantity", quantity, MOVING, "a chain is torsional or axial")
    if quantity in ("torque", "twist"):
        return SI_UNITS["twist"], SI_UNITS["torque"]
    return SI_UNITS["displacement"], SI_UNITS["force"]


def motion_grid(
    chain: Chain | None,
    over: dict[str, Coordinate],
    motion: Array,
    torque: Array,
    quantity: Moving | None,
    words: str = "motion",
    **more: Any,
) -> Dataset:
    """Return motions (m, n) and torques (m, e) as arrays over node or element and one axis more.

    Parameters
    ----------
    over : dict
        Name and coordinate of the axis of the rows.
    quantity : str or None
        As for `units_of`.
    words : str, optional
        Quantity of the motion.
    **more
        Other arrays of the dataset, for `grid`.
    """
    (axis,) = over
    moved, loaded = units_of(quantity)
    nodes, elements = axis_names(chain, motion.shape[1], torque.shape[1])
    return grid(
        {
            **more,
            "motion": ((axis, "node"), motion, moved, words),
            "torque": ((axis, "element"), torque, loaded, "load of the spring"),
        },
        {**over, "node": name_axis(nodes, "node"), "element": name_axis(elements, "element")},
    )


@frozen("turns", "time [s]", "speed [rad/s]", "motion", "torque", eq=False)
class Envelope:
    """Half of the range within each window of whole revolutions.

    Parameters
    ----------
    turns : int
        In one window.
    time : ndarray of shape (w,)
        Middle of each window [s].
    speed : ndarray of shape (w,)
        Speed there [rad/s].
    motion : ndarray of shape (w, n)
        Of each node [rad or m].
    torque : ndarray of shape (w, e)
        Of each element [N m or N].
    """

    turns: int
    time: Array
    speed: Array
    motion: Array
    torque: Array

    def plot(
        self,
        axes: Axes | None = None,
        place: int = 0,
        *,
        quantity: Moving = "torque",
        over: Literal["speed", "time"] = "speed",
    ) -> Axes:
        """Draw the amplitude of one element or node over the speed or the time.

        Parameters
        ----------
        place : int, optional
            Element, or node for "twist" and "displacement", from 0.
        quantity : {"torque", "force", "twist", "displacement"}, optional
        over : {"speed", "time"}, optional

        Raises
        ------
        InputError
            If there is no such element, node, quantity or axis.
        """
        check_choice("quantity", quantity, MOVING, "amplitudes of these are known")
        check_choice("over", over, ("speed", "time"), "amplitudes are known over these")
        of_element = quantity in OF_ELEMENTS
        values = self.torque if of_element else self.motion
        index = node_index("place", place, values.shape[1])
        label, factor = MOVING[quantity]
        name = f"amplitude over {self.turns} turn{'s' if self.turns > 1 else ''}"
        axes = new_axes(axes)
        if over == "speed":
            draw_named_curves(axes, self.speed, {name: factor * values[:, index]}, label)
            low, high = RPM * float(self.speed.min()), RPM * float(self.speed.max())
            if high > low:
                axes.set_xlim(low, high)
        else:
            draw_over_time(axes, self.time, {name: factor * values[:, index]}, label)
            axes.set_ylim(bottom=0.0)
        write_title(axes, f"{'element' if of_element else 'node'} {index}, {name}")
        return axes


def envelope_over(
    time: Array,
    speed: Array,
    shaft_angle: Array,
    motion: Array,
    torque: Array,
    turns: int,
) -> Envelope:
    """Return the envelope of a motion sampled at times [s], speeds [rad/s] and shaft angles [rad], (m,).

    A window has the revolutions after which the orders repeat, or more.

    Notes
    -----
    Windows begin at the start; an incomplete one at the end is not used. Half of the range
    excludes whatever is constant over the window, such as the twist by mean torque.
    """
    count = whole_number("turns", turns, 1, "a window takes whole turns of the shaft")
    window = 2.0 * np.pi * count
    # Room for round-off, so that n whole windows are n.
    whole = int((shaft_angle[-1] - shaft_angle[0]) / window + 1e-9)
    if whole < 1:
        raise InputError(
            f"turns: given {count}; allowed are at most "
            f"{(shaft_angle[-1] - shaft_angle[0]) / (2.0 * np.pi):.3g}, because the motion lasts for so "
            "many turns of the shaft."
        )
    edges = shaft_angle[0] + window * np.arange(whole + 1)
    starts = np.searchsorted(shaft_angle, edges - 1e-9 * window)
    middles = 0.5 * (edges[1:] + edges[:-1])

    def half_ranges(values: Array) -> Array:
        halves = [
            half_peak_to_peak(values[max(first - 1, 0) : last + 1])
            for first, last in pairwise(starts.tolist())
        ]
        return np.array(halves).reshape(whole, values.shape[1])

    times = np.interp(middles, shaft_angle, time)
    return Envelope(
        turns=count,
        time=times,
        speed=np.interp(times, time, speed),
        motion=half_ranges(motion),
        torque=half_ranges(torque),
    )


def half_peak_to_peak(values: Array) -> Array:
    """Return half of the peak-to-peak value of samples (m, k), (k,).

    The extremes are those of the parabolas through the highest and the lowest sample and its
    neighbors: with samples half a radian of a sine apart, the highest sample may miss the peak by
    3 %, the parabola by 0.02 %.
    """
    if not values.shape[1]:
        return np.zeros(0)
    return np.asarray(0.5 * (_peak(values) + _peak(-values)))


def _peak(values: Array) -> Array:
    columns = np.arange(values.shape[1])
    places = np.argmax(values, axis=0)
    highest = values[places, columns]
    # At either end there is one neighbor only, and the sample stands.
    inside = (places > 0) & (places < len(values) - 1)
    before = np.where(inside, values[places - 1, columns], highest)
    after = np.where(inside, values[np.minimum(places + 1, len(values) - 1), columns], highest)
    bend = 2.0 * highest - before - after
    above = np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros_like(bend), where=bend > 0.0)
    return np.asarray(highest + above)


# Samples between samples among which extremes over a cycle are looked for.
FINER = 4


class CycleMotion:
    """A cycle: its revolutions, angles (m,), motions (m, n) and torques (m, e), and its plots."""

    turns: int
    shaft_angle_deg: Array
    motion: Array
    torque: Array

    @property
    def amplitude(self) -> Array:
        """Half of the range of each node [rad or m], (n,); inf if unbounded."""
        return self._half_way(self.motion)

    @property
    def torque_amplitude(self) -> Array:
        """Half of the range of each element [N m or N], (e,)."""
        return self._half_way(self.torque)

    def phasors(self, orders: ArrayLike) -> ComplexArray:
        """Return X_k of the motion, mean + Re sum X_k exp(i k phi), shape (K, n)."""
        wanted = np.atleast_1d(finite_array("orders", orders))
        cycles = wanted * self.turns
        whole = np.round(cycles)
        count = self.shaft_angle_deg.size
        if np.any((np.abs(cycles - whole) > 1e-9 * whole) | (whole < 1) | (2.0 * whole >= count)):
            raise InputError(
                f"orders: given {wanted.tolist()}; allowed are multiples of {1.0 / self.turns:g} above zero "
                f"and below {0.5 * count / self.turns:g}, because the cycle has {self.turns} turns and "
                f"{count} samples."
            )
        waves = np.exp(-1j * np.outer(wanted, np.radians(self.shaft_angle_deg)))
        return np.asarray(waves @ self.motion * (2.0 / count))

    def plot(
        self, axes: Axes | None = None, place: int | str = 0, *, quantity: Moving = "torque"
    ) -> Axes:
        """Draw one element or node over the shaft angle of the cycle.

        Parameters
        ----------
        place : int or str, optional
            Element, or node for "twist" and "displacement", by number from 0 or name.
        quantity : {"torque", "force", "twist", "displacement"}, optional
            Torque or force in the spring of an element, or twist or displacement of a node.
        """
        chain, speed = self._chain_and_speed()
        shown = amount(speed, "rad/s", 5)
        if np.any(np.isinf(self.amplitude)):
            raise InputError(
                f"speed: given {shown}; allowed are speeds with a steady vibration, because this one "
                "grows without bounds."
            )
        picked = select_curve(chain, quantity, place, self.motion, self.torque)
        axes = new_axes(axes)
        draw_over_angle(
            axes, np.radians(self.shaft_angle_deg), {picked.name: picked.values}, picked.label
        )
        write_title(axes, f"{picked.name}, {shown}")
        return axes

    def _chain_and_speed(self) -> tuple[Chain | None, float]:
        """Return the vibrating system, and the mean speed of the shaft [rad/s]."""
        raise NotImplementedError

    def _grid(self, quantity: Moving | None, **more: Any) -> Dataset:
        """Return the data common to all cycles and `more`, over shaft angle, node and element."""
        chain, _ = self._chain_and_speed()
        axis = {"shaft_angle": angle_axis(self.shaft_angle_deg)}
        return motion_grid(chain, axis, self.motion, self.torque, quantity, **more)

    def _half_way(self, values: Array) -> Array:
        count = len(values)
        spectrum = np.fft.rfft(values, axis=0)
        finer = np.fft.irfft(spectrum, FINER * count, axis=0) * FINER
        # One more sample on each side, so that the extremes have neighbors.
        return half_peak_to_peak(np.vstack((finer[-1:], finer, finer[:1])))


class ShaftRun:
    """A run: time, speed, angle, motions (m, n) and torques (m, e), and its plots."""

    time: Array
    shaft_speed: Array
    shaft_angle_deg: Array
    motion: Array
    torque: Array
    system: ViscousSystem

    def envelope(self, turns: int | None = None) -> Envelope:
        """Return the amplitudes in windows of whole revolutions; by default as the run repeats."""
        return self._envelope(self.motion, turns)

    def _envelope(self, motion: Array, turns: int | None) -> Envelope:
        return envelope_over(
            self.time,
            self.shaft_speed,
            np.radians(self.shaft_angle_deg),
            motion,
            self.torque,
            self.turns if turns is None else turns,  # type: ignore[attr-defined]  # field or property
        )

    def plot(
        self,
        axes: Axes | None = None,
        place: int | str = 0,
        *,
        quantity: Moving = "torque",
        steady: tuple[ArrayLike, ArrayLike] | None = None,
        turns: int | None = None,
    ) -> Axes:
        """Draw the extremes of one element or node over the time, and its amplitude.

        Parameters
        ----------
        place : int or str, optional
            Element, or node for "twist" and "displacement", by number from 0 or name.
        quantity : {"torque", "force", "twist", "displacement"}, optional
            Torque or force in the spring of an element, or twist or displacement of a node.
        steady : (speeds [rad/s], amplitudes), optional
            Amplitudes at constant speeds, ascending, drawn where the run passes these speeds.
        turns : int, optional
            Revolutions of the shaft for one amplitude; by default those after which the run repeats.
        """
        picked = select_curve(self.system.chain, quantity, place, self.motion, self.torque)
        envelope = self.envelope(turns)
        both = envelope.torque if picked.of_element else envelope.motion
        windows = (envelope.time, both[:, picked.number], envelope.turns)
        return plot_run(axes, self.time, self.shaft_speed, picked, windows, steady)

    def _grid(self, quantity: Moving | None, **more: Any) -> Dataset:
        """Return the data common to all runs and `more`, over time, node and element."""
        return motion_grid(
            self.system.chain,
            {"time": time_axis(self.time)},
            self.motion,
            self.torque,
            quantity,
            "motion beside even turning",
            shaft_speed=(("time",), self.shaft_speed, "rad/s", "shaft speed"),
            shaft_angle=(("time",), self.shaft_angle_deg, "deg", "shaft angle"),
            **more,
        )


# An undamped mode that comes round within this share of a whole number of its periods, while forces
# go on driving it there, answers without bounds; as in `harmonic_response`.
UNBOUNDED_WITHIN = 1e-9
# What drives such a mode is nothing below this share of the largest change over a cycle.
NO_DRIVE = 1e-9


@frozen("speed [rad/s]", "turns", "amplitude", "torque_amplitude", "unbounded", "note", eq=False)
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
        Of each element of a chain, that of its spring less the force with which it pushes its ends apart
        (`OrderExcitation.pressing`) [N m or N]; e is 0 for other systems.
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
    shaft_angle_deg: Array
    motion: Array
    torque: Array
    unbounded: bool
    step: float
    system: ViscousSystem
    note: str

    @property
    def time(self) -> Array:
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

    def _half_way(self, values: Array) -> Array:
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
) -> tuple[SteadyMotion, Array]:
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
        torque=spring_torques(system.chain, motion)
        - _pushed(
            system.chain, [(0.0, excitation)], np.zeros(count), angles, np.full(count, speed)
        ),
        unbounded=unbounded,
        step=step,
        system=system,
        note=system.note,
    )
    return steady, states[0]


def spring_torques(chain: Chain | None, motion: Array) -> Array:
    """Return the torque (force) of the spring of each element, (m, e); e is 0 without a chain."""
    if chain is None:
        return np.zeros((len(motion), 0))
    return np.asarray(motion @ (chain.stiffness[:, np.newaxis] * chain.elongations()).T)


def _pushed(
    chain: Chain | None,
    excitations: Sequence[tuple[float, OrderExcitation]],
    times: Array,
    angles: Array,
    speeds: Array,
) -> Array:
    """Return the force with which each element pushes its ends apart, (m, e); it is no load of the element.

    Parameters
    ----------
    excitations : sequence of (float, OrderExcitation)
        Each in place of those before from its time on [s].
    times, angles, speeds : (m,) arrays
        [s, rad, rad/s].
    """
    pushed = np.zeros((times.size, 0 if chain is None else len(chain.elements)))
    for begins, excitation in excitations if chain is not None else ():
        rows = times >= begins
        pushed[rows] = 0.0
        if excitation.pressing is not None:
            alone = OrderExcitation(excitation.orders, excitation.speeds, excitation.pressing)
            forces = OrderForces.of(alone, np.eye(pushed.shape[1]))
            pushed[rows] = forces.at(angles[rows], speeds[rows])
    return pushed


def _periodic_start(
    space: StateSpace, propagator: Propagator, forces: Array, period: float
) -> tuple[Array, bool]:
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


@frozen("time [s]", "shaft_speed [rad/s]", "torque", "complete", "force_error", "notes", eq=False)
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

    time: Array
    shaft_speed: Array
    shaft_angle_deg: Array
    motion: Array
    rigid_motion: Array
    torque: Array
    complete: bool
    step: float
    force_error: float
    orders: Array
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
        steady, state = steady_from(
            system, excitation, float(speed.speeds[0]), math.radians(speed.start_angle_deg)
        )
        if steady.unbounded:
            raise InputError(
                f"start: given 'steady' at {speed.speeds[0]:g} rad/s; allowed is 'rest' there, because an "
                "undamped mode is excited at its own frequency."
            )
    times, states, error, complete = _integrate_segments(space, acting, pieces, state, progress)
    turned, excitations = speed.angle_deg(times), [(float(times[0]), excitation), *changes]
    pushed = _pushed(system.chain, excitations, times, np.radians(turned), speed.speed(times))
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
        shaft_angle_deg=turned,
        motion=elastic,
        rigid_motion=rigid_motion,
        torque=spring_torques(system.chain, elastic) - pushed,
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
    start: Array,
    progress: Callable[[float], None] | None,
) -> tuple[Array, Array, float, bool]:
    """Return times (m,), states (m, 2 q), the error of the forces, and whether the run is complete."""
    count = 1 + sum(piece.steps for piece in pieces)
    times, states = np.empty(count), np.empty((count, start.size))
    times[0], states[0] = pieces[0].start, start
    done, error, largest = 1, 0.0, np.full(space.velocities.size, np.finfo(np.float64).tiny)
    complete = False
    propagator = Propagator.of(space, pieces[0].step)
    with contextlib.suppress(KeyboardInterrupt):
        for piece in pieces:
            step = piece.step
            if abs(step - propagator.step) > SAME_STEP * step:
                propagator = Propagator.of(space, step)
            for first in range(0, piece.steps, STRETCH):
                numbers = np.arange(first, min(first + STRETCH, piece.steps))
                starts: Array = np.asarray(piece.start + step * numbers)
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
