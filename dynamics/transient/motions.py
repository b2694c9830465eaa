"""What motions over time share: the choice of curves, envelopes by revolution, diagrams."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import ComplexArray, FloatArray, finite_array
from crankbase.choices import check_choice, whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, Dataset, grid
from crankbase.quantity import RPM, format_quantity
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
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
from dynamics.transient.propagator import ViscousSystem

Moving: TypeAlias = Literal["torque", "force", "twist", "displacement"]
OF_ELEMENTS = ("torque", "force")


def select_curve(
    chain: Chain | None, quantity: Moving, place: int | str, motion: FloatArray, torque: FloatArray
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
    motion: FloatArray,
    torque: FloatArray,
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


@summarized("turns", "time [s]", "speed [rad/s]", "motion", "torque")
@dataclass(frozen=True, eq=False)
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
    time: FloatArray
    speed: FloatArray
    motion: FloatArray
    torque: FloatArray

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
    time: FloatArray,
    speed: FloatArray,
    shaft_angle: FloatArray,
    motion: FloatArray,
    torque: FloatArray,
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

    def half_ranges(values: FloatArray) -> FloatArray:
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


def half_peak_to_peak(values: FloatArray) -> FloatArray:
    """Return half of the peak-to-peak value of samples (m, k), (k,).

    The extremes are those of the parabolas through the highest and the lowest sample and its
    neighbors: with samples half a radian of a sine apart, the highest sample may miss the peak by
    3 %, the parabola by 0.02 %.
    """
    if not values.shape[1]:
        return np.zeros(0)
    return np.asarray(0.5 * (_peak(values) + _peak(-values)))


def _peak(values: FloatArray) -> FloatArray:
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
    shaft_angle_deg: FloatArray
    motion: FloatArray
    torque: FloatArray

    @property
    def amplitude(self) -> FloatArray:
        """Half of the range of each node [rad or m], (n,); inf if unbounded."""
        return self._half_way(self.motion)

    @property
    def torque_amplitude(self) -> FloatArray:
        """Half of the range of each element [N m or N], (e,)."""
        return self._half_way(self.torque)

    def phasors(self, orders: ArrayLike) -> ComplexArray:
        """Return X_k of the motion, mean + Re sum X_k exp(i k phi), shape (K, n)."""
        return self._phasors(orders, self.motion)

    def torque_phasors(self, orders: ArrayLike) -> ComplexArray:
        """Return the phasors of the elements' torque by orders, shape (K, e) [N m or N]; as `phasors`."""
        return self._phasors(orders, self.torque)

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
        shown = format_quantity(speed, "rad/s", 5)
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

    def _half_way(self, values: FloatArray) -> FloatArray:
        count = len(values)
        spectrum = np.fft.rfft(values, axis=0)
        finer = np.fft.irfft(spectrum, FINER * count, axis=0) * FINER
        # One more sample on each side, so that the extremes have neighbors.
        return half_peak_to_peak(np.vstack((finer[-1:], finer, finer[:1])))

    def _phasors(self, orders: ArrayLike, values: FloatArray) -> ComplexArray:
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
        return np.asarray(waves @ values * (2.0 / count))


class ShaftRun:
    """A run: time, speed, angle, motions (m, n) and torques (m, e), and its plots."""

    time: FloatArray
    shaft_speed: FloatArray
    shaft_angle_deg: FloatArray
    motion: FloatArray
    torque: FloatArray
    system: ViscousSystem

    def envelope(self, turns: int | None = None) -> Envelope:
        """Return the amplitudes in windows of whole revolutions; by default as the run repeats."""
        return self._envelope(self.motion, turns)

    def _envelope(self, motion: FloatArray, turns: int | None) -> Envelope:
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
