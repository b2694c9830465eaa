"""Coupled forced vibration of a whole crankshaft, by tangential and radial forces, and its criticals."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.arrays import ComplexArray, FloatArray
from crankbase.checks.scalars import is_whole_within
from crankbase.drawing.curves import Curves, Series, draw_curves
from crankbase.drawing.diagram_style import BLUE, ORANGE, new_axes, with_gaps
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes, Dataset
from crankbase.summaries import summarized
from crankbase.tables.frames import grid
from crankbase.units.units import RPM
from dynamics.crankshaft.assembly import PIN_MOTIONS
from dynamics.crankshaft.shaft_modes import CrankshaftSystem
from dynamics.excitation.combined_excitation import combined_excitation
from dynamics.excitation.cylinders import CylinderForces
from dynamics.plots.quantities import (
    SPEED_LABEL,
    in_unit,
    infinite_where_unbounded,
    name_axis,
    orders_and_speeds,
)
from dynamics.response.damped_criticals import BAND
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.linear_system import DEFAULT_MAGNIFIER
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.series import OrderSeries, synthesis
from dynamics.running_limits import within


def shaft_excitation(
    crankshaft: CrankshaftSystem,
    forces: CylinderForces,
    *,
    pins: Sequence[int] | None = None,
    tangential: bool = True,
    radial: bool = True,
) -> OrderExcitation:
    """Return the cylinders' forces as excitation of a whole crankshaft.

    Parameters
    ----------
    crankshaft : CrankshaftSystem
    forces : CylinderForces
        Orders (K,), speeds (S,), tangential and radial phasors (K, S, c) of c cylinders.
    pins : sequence of c int, optional
        Pin of each cylinder from 0, counted along the shaft; by default that of its throw, if each throw
        has one.
    tangential, radial : bool
        Whether these forces act; with one of them alone, the response shows its effect.

    Returns
    -------
    OrderExcitation
        On the points of the system.

    Raises
    ------
    InputError
        If there is not one pin for each cylinder, or a pin does not exist.

    Notes
    -----
    Forces of several cylinders on one pin act at its middle and add up: rods side by side load it off the
    middle, and their opposite moments on the pin are neglected. Each force is uniform over the pin.
    """
    places = pins_of_cylinders(crankshaft.shaft.pin_throws, forces.throws, pins)
    first = 6 * crankshaft.shaft.section_count
    acting = np.zeros((*forces.tangential.shape[:2], len(crankshaft.names)), dtype=np.complex128)
    kinds = {"tangential": tangential, "radial": radial}
    for direction in (name for name, acts in kinds.items() if acts):
        rows = first + 3 * np.array(places) + PIN_MOTIONS.index(direction)
        for cylinder, row in enumerate(rows.tolist()):
            acting[:, :, row] += getattr(forces, direction)[:, :, cylinder]
    return OrderExcitation(forces.orders, forces.speeds, acting)


def pins_of_cylinders(
    pin_throws: Sequence[int], throws: Sequence[int], pins: Sequence[int] | None = None
) -> tuple[int, ...]:
    """Return the pin of each cylinder, checked.

    Parameters
    ----------
    pin_throws : sequence of p int
        Throw of each pin.
    throws : sequence of c int
        Throw of each cylinder.
    pins : sequence of c int, optional
        As for `shaft_excitation`.

    Raises
    ------
    InputError
        As `shaft_excitation`.
    """
    if pins is None:
        if len(set(pin_throws)) != len(pin_throws):
            raise InputError(
                "pins: given none for throws of several pins; allowed is the pin of each cylinder, because "
                "its throw does not define it."
            )
        pins = [
            pin_throws.index(throw) if throw in pin_throws else len(pin_throws) for throw in throws
        ]
    count = len(pin_throws)
    if len(pins) != len(throws) or not all(is_whole_within(pin, 0, count - 1) for pin in pins):
        raise InputError(
            f"pins: given {list(pins)}; allowed is a whole number from 0 to {count - 1} for each of the "
            f"{len(throws)} cylinders, because its rod sits on one of {count} pins."
        )
    return tuple(int(pin) for pin in pins)


@summarized("orders", "speeds [rad/s]")
@dataclass(frozen=True, eq=False)
class CoupledResponse:
    """Steady vibration of a whole crankshaft by orders, separately for both kinds of force.

    Attributes
    ----------
    crankshaft : CrankshaftSystem
    tangential, radial : ForcedResponse
        Under tangential forces alone and under radial forces alone; the motion under both is the sum.
    further : ForcedResponse or None
        Under forces of others than the cylinders, such as a propeller's, which are in the sum too.
    """

    crankshaft: CrankshaftSystem
    tangential: ForcedResponse
    radial: ForcedResponse
    further: ForcedResponse | None = None

    @property
    def parts(self) -> tuple[ForcedResponse, ...]:
        """The responses whose sum is the motion."""
        found = (self.tangential, self.radial)
        return found if self.further is None else (*found, self.further)

    @property
    def orders(self) -> FloatArray:
        """(K,), in cycles per revolution."""
        return self.tangential.orders

    @property
    def speeds(self) -> FloatArray:
        """(S,) [rad/s]."""
        return self.tangential.speeds

    @property
    def unbounded(self) -> NDArray[np.bool_]:
        """Where one of the responses is unbounded, (K, S)."""
        return np.asarray(np.any([one.unbounded for one in self.parts], axis=0))

    def motion(self, point: str) -> ComplexArray:
        """Return the motion (K, S) of a point such as "main bearing 1 uz" under all forces.

        Raises
        ------
        InputError
            If there is no such point.
        """
        row = self.crankshaft.point(point)
        return np.asarray(np.sum([one.motion[:, :, row] for one in self.parts], axis=0))

    def elastic_motion(self, point: str) -> ComplexArray:
        """Return the motion (K, S) of a point under all forces without rigid-body motion.

        Raises
        ------
        InputError
            If there is no such point.
        """
        return np.asarray(np.sum(self._elastic(point), axis=0))

    def _elastic(self, point: str) -> list[ComplexArray]:
        rigid = self.crankshaft.system.rigid.shape[1]
        # Amplitudes of modes are the unknowns of this system, rigid motions first.
        row = self.crankshaft.system.expand[self.crankshaft.point(point), rigid:]
        return [one.unknowns[:, :, rigid:] @ row for one in self.parts]

    def split(self, point: str) -> "SplitMotion":
        """Return the motion of a point by each kind of force and by all, by order and synthesized.

        Rigid-body motion of the shaft, which causes no strain, is left out.

        Raises
        ------
        InputError
            If there is no such point.
        """
        if point not in self._splits:
            self._splits[point] = self._split(point)
        return self._splits[point]

    @cached_property
    def torque(self) -> OrderSeries:
        """Alternating torque in the shaft at each main bearing, under all forces [N m].

        It balances what lies between the free end and the bearing: minus its angular momentum's rate of
        change and the moment of its pins' forces. The small part of modal damping there is left out.
        """
        shaft = self.crankshaft.shaft
        first = 6 * shaft.section_count
        pins = slice(first, first + len(shaft.pins))
        acting = self.tangential.excitation.forces + self.radial.excitation.forces
        moved = np.sum([one.unknowns for one in self.parts], axis=0) @ self.crankshaft.momenta.T
        squared = (self.orders[:, np.newaxis] * self.speeds) ** 2
        values = -squared[:, :, np.newaxis] * moved - acting[:, :, pins] @ shaft.moments.T
        names = tuple(f"main bearing {place}" for place in range(1, shaft.section_count + 1))
        values = np.where(self.unbounded[:, :, np.newaxis], 0.0, values)
        return OrderSeries(self.orders, self.speeds, values, self.unbounded, names)

    @cached_property
    def _splits(self) -> "dict[str, SplitMotion]":
        return {}

    def _split(self, point: str) -> "SplitMotion":
        each = self._elastic(point)
        motions = {"tangential": each[0], "radial": each[1], "both": np.sum(each, axis=0)}
        unbounded, found = self.unbounded, {}
        for name, motion in motions.items():
            found[name] = np.where(unbounded, np.inf, np.abs(motion))
            summed = synthesis(self.orders, self.speeds, motion, unbounded)
            found[f"{name}_sum"] = summed.amplitude
        return SplitMotion(point=point, orders=self.orders, speeds=self.speeds, **found)

    def plot(self, axes: Axes | None = None, point: str = "main bearing 1 uz") -> Axes:
        """Draw the amplitude of a point over the speed by tangential, by radial and by all forces.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        point : str, optional
            Such as "main bearing 1 uz", the free end along the shaft.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If there is no such point.
        """
        return self.split(point).plot(axes)

    def to_xarray(self) -> Dataset:
        """Return complex motions of all points by tangential and by radial forces.

        Returns
        -------
        xarray.Dataset
            Units in the ``attrs["units"]`` of each array and coordinate.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
            Motions are infinite where unbounded; rotations are in rad.
        """
        over = ("order", "speed", "point")
        names = self.crankshaft.names
        units = [point_unit(name) for name in names]
        return grid(
            {
                **{
                    kind: (
                        over,
                        infinite_where_unbounded(own.motion, self.unbounded),
                        "m or rad",
                        f"phasor of the motion by {kind} forces",
                    )
                    for kind, own in (("tangential", self.tangential), ("radial", self.radial))
                },
                "unbounded": (("order", "speed"), self.unbounded, "1", "no steady vibration"),
                "unit": (("point",), np.array(units), "", "unit of the point's motion"),
            },
            {
                **orders_and_speeds(self.orders, self.speeds),
                "point": name_axis(names, "point of the shaft"),
            },
        )


@summarized("point", "both", "orders", "speeds [rad/s]")
@dataclass(frozen=True, eq=False)
class SplitMotion:
    """Motion of a point [m or rad] by tangential forces, by radial forces, and "both": by all.

    Attributes
    ----------
    point : str
    tangential, radial, both : (K, S) array
        Amplitude by order and speed; inf where unbounded.
    tangential_sum, radial_sum, both_sum : (S,) array
        Half of the range of the sum of all orders over the working cycle; inf where one is
        unbounded.
    orders : (K,) array
        In cycles per revolution.
    speeds : (S,) array
        [rad/s]
    """

    point: str
    tangential: FloatArray
    radial: FloatArray
    both: FloatArray
    tangential_sum: FloatArray
    radial_sum: FloatArray
    both_sum: FloatArray
    orders: FloatArray
    speeds: FloatArray

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the synthesized amplitude over the speed, by tangential, radial and all forces.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
            Curves have gaps where the motion is unbounded.
        """
        drawn_as = in_unit(point_unit(self.point))
        axes = new_axes(axes, height=3.8)
        sums = (self.both_sum, self.tangential_sum, self.radial_sum)
        draw_curves(axes, split_curves(self.speeds, sums, drawn_as.factor, drawn_as.label))
        write_title(
            axes, f"{self.point}: half the range over the working cycle, all orders together", 9
        )
        legend_inside(axes)
        return axes

    def to_xarray(self) -> Dataset:
        """Return the amplitudes by order and speed, and of all orders together.

        Returns
        -------
        xarray.Dataset
            Units in the ``attrs["units"]`` of each array and coordinate.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        unit = point_unit(self.point)
        plane = ("order", "speed")
        found: dict[str, tuple[tuple[str, ...], FloatArray, str, str]] = {}
        for kind in ("tangential", "radial", "both"):
            words = "all forces" if kind == "both" else f"{kind} forces"
            found[kind] = (plane, getattr(self, kind), unit, f"amplitude by {words}")
            total = getattr(self, f"{kind}_sum")
            found[f"{kind}_sum"] = (("speed",), total, unit, f"all orders together, by {words}")
        return grid(found, orders_and_speeds(self.orders, self.speeds))


def point_unit(point: str) -> str:
    """Return the unit of a point's motion: displacements are in m, rotations in rad."""
    turns = point.endswith((" rx", " ry", " rz", "damper ring", "driven machine"))
    return "rad" if turns else "m"


def coupled_response(
    crankshaft: CrankshaftSystem,
    forces: CylinderForces,
    *,
    pins: Sequence[int] | None = None,
    magnifier: float | None = DEFAULT_MAGNIFIER,
    modal_damping: ArrayLike | None = None,
    further: OrderExcitation | None = None,
) -> CoupledResponse:
    """Find the coupled vibration of a crankshaft under the forces of its cylinders.

    Parameters
    ----------
    crankshaft : CrankshaftSystem
        With the damping of its bearings, dampers and material.
    forces : CylinderForces
        By order, speed and cylinder.
    pins : sequence of int, optional
        Pin of each cylinder, as for `shaft_excitation`.
    magnifier : float or None
        Magnifier of every elastic mode, added to the damping of the system; by default the measured
        one of `DEFAULT_MAGNIFIER`. None adds nothing.
    modal_damping : float or array_like, optional
        Alternatively, share of critical damping of every elastic mode.
    further : OrderExcitation, optional
        Other forces on the points of the shaft, at the same speeds; orders may differ.

    Returns
    -------
    CoupledResponse

    Raises
    ------
    InputError
        If pins or damping do not fit.
    """
    if not isinstance(crankshaft, CrankshaftSystem):
        raise InputError(
            f"crankshaft: given {crankshaft!r}; allowed is a CrankshaftSystem, as crankshaft_system makes."
        )
    system = crankshaft.system
    if modal_damping is not None:
        system = system.with_modal_damping(modal_damping)
    elif magnifier is not None:
        system = system.with_magnifier(magnifier)
    tangential = shaft_excitation(crankshaft, forces, pins=pins, radial=False)
    radial = shaft_excitation(crankshaft, forces, pins=pins, tangential=False)
    given = [tangential, radial]
    if further is not None:
        given.append(further)
        every = combined_excitation(*given)
        silent = replace(every, forces=np.zeros_like(every.forces))
        given = [combined_excitation(one, silent) for one in given]
    return CoupledResponse(crankshaft, *(forced_response(system, acting) for acting in given))


def split_curves(
    speeds: FloatArray, sums: tuple[FloatArray, FloatArray, FloatArray], factor: float, label: str
) -> Curves:
    """Describe an amplitude over the speed by all, by tangential and by radial forces.

    Parameters
    ----------
    speeds : (S,) array
        [rad/s]
    sums : three (S,) arrays
        In SI.
    factor : float
        Factor for display.
    label : str
        Of the upright axis, with its unit.
    """
    both, tangential, radial = (with_gaps(factor * values) for values in sums)
    return Curves(
        x=speeds * RPM,
        # Dashes over a line: where all cranks are in one plane, radial forces alone do all of it.
        series=(
            Series("all forces", both, "total"),
            Series("tangential forces alone", tangential, color=BLUE),
            Series("radial forces alone", radial, color=ORANGE, dash="dash"),
        ),
        x_label=SPEED_LABEL,
        y_label=label,
    )


# Maxima of one order at several places within this share of the speed are one critical speed.
TOGETHER = 0.03
# Maxima below this share of the largest one of their place are left out.
LEAST_PEAK = 0.05


@summarized("order", "speed [rad/s]", "place", "value", "frequency [Hz]", "damping_ratio")
@dataclass(frozen=True)
class ShaftCritical:
    """A speed at which an order alone makes a quantity largest.

    Attributes
    ----------
    order : float
        In cycles per revolution.
    speed : float
        [rad/s]
    place : str
        Where it is largest.
    value : float
        There, of this order alone [m or N m]; inf where unbounded.
    mode : int
        Number of the elastic mode of the whole crankshaft at resonance, 1 the lowest; 0 for none.
    frequency : float or None
        Natural frequency of the mode [Hz]; None for none.
    damping_ratio : float or None
        Of the mode, share of critical damping; None for none.
    share : float
        Of a place's largest maximum, at the place where that is most.
    """

    order: float
    speed: float
    place: str
    value: float
    mode: int
    frequency: float | None
    damping_ratio: float | None
    share: float = 1.0


def shaft_criticals(
    coupled: CoupledResponse, series: OrderSeries, speed_range: tuple[float, float]
) -> tuple[tuple[ShaftCritical, ...], int]:
    """Find the critical speeds of a whole crankshaft in a quantity at several places.

    Parameters
    ----------
    coupled : CoupledResponse
    series : OrderSeries
        Motions or torques of it, at its orders and speeds.
    speed_range : tuple of two floats
        [rad/s]

    Returns
    -------
    criticals : tuple of ShaftCritical
        In ascending speed, each at the place with the largest value.
    left_out : int
        Number of maxima that are below `LEAST_PEAK` of the largest one at every place.

    Notes
    -----
    Between the speeds of the series a maximum lies where a parabola through 1 / value^2 has its least,
    which is exact near a resonance. The mode is that with the largest amplitude among those whose magnifier
    is at least half of its largest there.
    """
    sizes = np.where(series.unbounded[:, :, np.newaxis], np.inf, np.abs(series.values))
    top = (sizes[:, 1:-1] > sizes[:, :-2]) & (sizes[:, 1:-1] >= sizes[:, 2:])
    orders, centers, places = np.nonzero(top)
    beside = (centers[:, np.newaxis] + np.arange(3)).T
    with np.errstate(divide="ignore", invalid="ignore"):
        speeds, values = _vertex(series.speeds[beside], sizes[orders, beside, places])
    inside = within(speeds, *speed_range)
    found = np.column_stack((orders, centers + 1, places))[inside]
    speeds, values = speeds[inside], values[inside]
    largest = np.zeros(len(series.names))
    finite = np.isfinite(values)
    np.maximum.at(largest, found[finite, 2], values[finite])
    shares = np.minimum(values / np.where(largest > 0.0, largest, 1.0)[found[:, 2]], 1.0)
    told: dict[int, float] = {}
    # What is worth a row first, the largest value first.
    for row in np.lexsort((-values, shares < LEAST_PEAK)).tolist():
        same = [
            one
            for one in told
            if found[one, 0] == found[row, 0]
            and abs(speeds[one] - speeds[row]) <= TOGETHER * speeds[row]
        ]
        told[(same or [row])[0]] = max(shares[row], told.get((same or [row])[0], 0.0))
    kept = {row: share for row, share in told.items() if share >= LEAST_PEAK}
    criticals = [
        ShaftCritical(
            float(series.orders[found[row, 0]]),
            float(speeds[row]),
            series.names[found[row, 2]],
            float(values[row]),
            *_mode(coupled, found[row, 0], found[row, 1], float(speeds[row])),
            float(share),
        )
        for row, share in kept.items()
    ]
    return tuple(sorted(criticals, key=lambda one: one.speed)), len(told) - len(kept)


def _vertex(speeds: FloatArray, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return speed and size (m,) of maxima from three neighboring values (3, m), the middle one largest."""
    inverse = 1.0 / sizes**2
    before, after = speeds[0] - speeds[1], speeds[2] - speeds[1]
    left, right = (inverse[0] - inverse[1]) / before, (inverse[2] - inverse[1]) / after
    bend = (right - left) / (after - before)
    slope = left - bend * before
    shift = np.clip(np.where(bend > 0.0, -slope / (2.0 * bend), 0.0), before, after)
    lowest = inverse[1] + shift * (slope + bend * shift)
    known = np.isfinite(sizes[1]) & np.isfinite(shift) & (lowest > 0.0)
    return (
        speeds[1] + np.where(known, shift, 0.0),
        np.where(known, 1.0 / np.sqrt(np.where(known, lowest, 1.0)), sizes[1]),
    )


def _mode(
    coupled: CoupledResponse, order: int, index: int, speed: float
) -> tuple[int, float | None, float | None]:
    """Return number, frequency [Hz] and damping ratio of the mode at resonance."""
    system = coupled.tangential.system
    rigid, ratios = system.rigid.shape[1], system.damping_ratios()
    natural = system.natural[rigid:]
    moved = np.abs(np.sum([one.unknowns[order, index, rigid:] for one in coupled.parts], axis=0))
    share = float(coupled.orders[order]) * speed / natural
    with np.errstate(divide="ignore"):
        magnifiers = 1.0 / np.abs(1.0 - share**2 + 2j * ratios * share)
        highest = 0.5 / (ratios * np.sqrt(np.maximum(1.0 - ratios**2, 0.0)))
    own = (magnifiers >= BAND * highest) & (ratios < np.sqrt(0.5))
    if not np.any(own[: coupled.crankshaft.kept]):
        return 0, None, None
    best = int(np.argmax(np.where(own, moved, -1.0)[: coupled.crankshaft.kept]))
    return best + 1, float(natural[best] / (2.0 * np.pi)), float(ratios[best])
