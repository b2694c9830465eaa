"""Coupled forced vibration of a whole crankshaft, by tangential and radial forces, and its criticals."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, reduce

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, ComplexArray, Flags
from crankbase.choices import check_kind, is_whole_within
from crankbase.diagrams import (
    BLUE,
    ORANGE,
    Diagram,
    Series,
    curve_diagram,
    draw_diagram,
    legend_inside,
    new_axes,
    with_gaps,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes, Dataset, grid
from crankbase.quantity import RPM
from crankbase.results import result
from dynamics.chains.shaft_line import DRIVEN, PRIME_MOVERS
from dynamics.crankshaft.assembly import PIN_MOTIONS
from dynamics.crankshaft.shaft_modes import CrankshaftSystem
from dynamics.excitation.chain_excitation import combined_excitation
from dynamics.excitation.cylinders import CylinderForces
from dynamics.plots.curves import (
    SPEED_LABEL,
    in_unit,
    infinite_where_unbounded,
    name_axis,
    orders_and_speeds,
)
from dynamics.response.damped_criticals import LEAST_PEAK, DampedCritical, criticals_of
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.linear_system import DEFAULT_MAGNIFIER
from dynamics.response.loads import LinearQuantities, motion_rows
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.series import OrderSeries, synthesis


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


@result("orders", "speeds [rad/s]")
class CoupledResponse:
    """Steady vibration of a whole crankshaft by orders, separately for both kinds of force.

    Attributes
    ----------
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
        cylinders = (self.tangential, self.radial)
        return cylinders if self.further is None else (*cylinders, self.further)

    @property
    def orders(self) -> Array:
        """(K,), in cycles per revolution."""
        return self.tangential.orders

    @property
    def speeds(self) -> Array:
        """(S,) [rad/s]."""
        return self.tangential.speeds

    @cached_property
    def total(self) -> ForcedResponse:
        """Under all forces."""
        acting = reduce(np.add, [part.excitation.forces for part in self.parts])
        return replace(
            self.tangential,
            motion=reduce(np.add, [part.motion for part in self.parts]),
            unbounded=reduce(np.logical_or, [part.unbounded for part in self.parts]),
            excitation=OrderExcitation(self.orders, self.speeds, acting),
            unknowns=reduce(np.add, [part.unknowns for part in self.parts]),
        )

    @property
    def unbounded(self) -> Flags:
        """Where one of the responses is unbounded, (K, S)."""
        return self.total.unbounded

    def motion(self, point: str) -> ComplexArray:
        """Return the motion (K, S) of a point such as "main bearing 1 uz" under all forces.

        Raises
        ------
        InputError
            If there is no such point.
        """
        return self.total.motion[:, :, self.crankshaft.point(point)]

    def _elastic(self, response: ForcedResponse, point: str) -> ComplexArray:
        rigid = self.crankshaft.system.rigid.shape[1]
        # Amplitudes of modes are the unknowns of this system, rigid motions first.
        row = self.crankshaft.system.expand[self.crankshaft.point(point), rigid:]
        return np.asarray(response.unknowns[:, :, rigid:] @ row)

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
        return self.bearing_torques.series(self.total)

    @property
    def bearing_torques(self) -> LinearQuantities:
        """See `torque`, of motion and forces."""
        crankshaft = self.crankshaft
        count, pins = crankshaft.shaft.section_count, len(crankshaft.shaft.pins)
        direct = np.zeros((count, len(crankshaft.names)))
        direct[:, 6 * count : 6 * count + pins] = -crankshaft.shaft.moments
        return LinearQuantities(
            names=tuple(f"main bearing {place}" for place in range(1, count + 1)),
            rows=np.zeros_like(crankshaft.momenta),
            loads=np.ones(count, dtype=bool),
            inertia=-crankshaft.momenta,
            direct=direct,
        )

    @property
    def axial_motions(self) -> LinearQuantities:
        """Motions of the main bearings along the shaft less the rigid body's [m]."""
        count = self.crankshaft.shaft.section_count
        names = tuple(f"main bearing {number}" for number in range(1, count + 1))
        points = [self.crankshaft.point(f"{name} uz") for name in names]
        return LinearQuantities(
            names, motion_rows(self.total, points)[0], np.zeros(count, dtype=bool)
        )

    @cached_property
    def _splits(self) -> "dict[str, SplitMotion]":
        return {}

    def _split(self, point: str) -> "SplitMotion":
        responses = {"tangential": self.tangential, "radial": self.radial, "both": self.total}
        motions = {name: self._elastic(each, point) for name, each in responses.items()}
        unbounded, amplitudes = self.unbounded, {}
        for name, motion in motions.items():
            amplitudes[name] = np.where(unbounded, np.inf, np.abs(motion))
            summed = synthesis(self.orders, self.speeds, motion, unbounded)
            amplitudes[f"{name}_sum"] = summed.amplitude
        return SplitMotion(point=point, orders=self.orders, speeds=self.speeds, **amplitudes)

    def plot(self, axes: Axes | None = None, point: str = "main bearing 1 uz") -> Axes:
        """Draw the amplitude of a point over the speed by tangential, by radial and by all forces.

        Parameters
        ----------
        point : str, optional
            Such as "main bearing 1 uz", the free end along the shaft.

        Raises
        ------
        InputError
            If there is no such point.
        """
        return self.split(point).plot(axes)

    def to_xarray(self) -> Dataset:
        """Return complex motions of all points by tangential and by radial forces.

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
                        infinite_where_unbounded(part.motion, self.unbounded),
                        "m or rad",
                        f"phasor of the motion by {kind} forces",
                    )
                    for kind, part in (("tangential", self.tangential), ("radial", self.radial))
                },
                "unbounded": (("order", "speed"), self.unbounded, "1", "no steady vibration"),
                "unit": (("point",), np.array(units), "", "unit of the point's motion"),
            },
            {
                **orders_and_speeds(self.orders, self.speeds),
                "point": name_axis(names, "point of the shaft"),
            },
        )


@result("point", "both", "orders", "speeds [rad/s]")
class SplitMotion:
    """Motion of a point [m or rad] by tangential forces, by radial forces, and "both": by all.

    Attributes
    ----------
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
    tangential: Array
    radial: Array
    both: Array
    tangential_sum: Array
    radial_sum: Array
    both_sum: Array
    orders: Array
    speeds: Array

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the synthesized amplitude over the speed, by tangential, radial and all forces.

        Returns
        -------
        matplotlib.axes.Axes
            Curves have gaps where the motion is unbounded.
        """
        drawn_as = in_unit(point_unit(self.point))
        axes = new_axes(axes, height=3.8)
        sums = (self.both_sum, self.tangential_sum, self.radial_sum)
        draw_diagram(axes, split_curves(self.speeds, sums, drawn_as.factor, drawn_as.label))
        write_title(
            axes, f"{self.point}: half the range over the working cycle, all orders together", 9
        )
        legend_inside(axes)
        return axes

    def to_xarray(self) -> Dataset:
        """Return the amplitudes by order and speed, and of all orders together.

        Units and errors are those of `crankbase.frames.grid`.
        """
        unit = point_unit(self.point)
        plane = ("order", "speed")
        variables: dict[str, tuple[tuple[str, ...], Array, str, str]] = {}
        for kind in ("tangential", "radial", "both"):
            words = "all forces" if kind == "both" else f"{kind} forces"
            variables[kind] = (plane, getattr(self, kind), unit, f"amplitude by {words}")
            total = getattr(self, f"{kind}_sum")
            variables[f"{kind}_sum"] = (("speed",), total, unit, f"all orders together, by {words}")
        return grid(variables, orders_and_speeds(self.orders, self.speeds))


def point_unit(point: str) -> str:
    """Return the unit of a point's motion: displacements are in m, rotations in rad."""
    turns = point.endswith((" rx", " ry", " rz", "damper ring", DRIVEN)) or point in PRIME_MOVERS
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
    magnifier, modal_damping
        As for `forced_response`, the first by default `DEFAULT_MAGNIFIER`; None adds nothing.
    further : OrderExcitation, optional
        Other forces on the points of the shaft, at the same speeds; orders may differ.

    Raises
    ------
    InputError
        If pins or damping do not fit.
    """
    check_kind("crankshaft", crankshaft, CrankshaftSystem, "what crankshaft_system makes")
    system = crankshaft.system
    if modal_damping is not None:
        system = system.with_modal_damping(modal_damping)
    elif magnifier is not None:
        system = system.with_magnifier(magnifier)
    tangential = shaft_excitation(crankshaft, forces, pins=pins, radial=False)
    radial = shaft_excitation(crankshaft, forces, pins=pins, tangential=False)
    excitations = [tangential, radial]
    if further is not None:
        excitations.append(further)
        every = combined_excitation(*excitations)
        silent = replace(every, forces=np.zeros_like(every.forces))
        excitations = [combined_excitation(acting, silent) for acting in excitations]
    return CoupledResponse(crankshaft, *(forced_response(system, acting) for acting in excitations))


def split_curves(
    speeds: Array, sums: tuple[Array, Array, Array], factor: float, label: str
) -> Diagram:
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
    return curve_diagram(
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


def shaft_criticals(
    coupled: CoupledResponse, quantities: LinearQuantities, speed_range: tuple[float, float]
) -> tuple[tuple[DampedCritical, ...], int]:
    """Find the critical speeds of a whole crankshaft in a quantity at several places.

    Parameters
    ----------
    quantities : LinearQuantities
        Of its system, all of one unit.
    speed_range : tuple of two floats
        [rad/s]

    Returns
    -------
    criticals : tuple of DampedCritical
        In ascending speed, each at the place with the largest value.
    left_out : int
        Number of those that are below `LEAST_PEAK` of the largest one at every place.
    """
    peaks = [
        critical
        for critical in criticals_of(coupled.total, quantities, speed_range, least=LEAST_PEAK)
        if critical.has_peak
    ]
    kept = [critical for critical in peaks if critical.severity >= LEAST_PEAK]
    return tuple(sorted(kept, key=lambda critical: critical.speed)), len(peaks) - len(kept)
