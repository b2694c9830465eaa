"""The gas pressure of each cylinder over speed and load: diagrams, interpolated by harmonics."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Annotated, Any, Literal, TypedDict, Unpack, cast, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import (
    Array,
    Integers,
    finite_array,
    finite_vector,
    nonnegative_number,
    positive_number,
    read_only,
    turning_speeds,
)
from crankbase.choices import check_choice, check_some, number_within
from crankbase.diagrams import legend_below, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.monotone_curve import MonotoneCurve
from crankbase.quantity import RPM
from crankbase.results import Number, Part, Quantity, Result, Speed, result
from crankbase.sentences import amount, kept
from crankbase.summaries import frozen
from dynamics.critical import engine_orders
from dynamics.cycle import cycle_radians, even_angles, order_numbers, order_step
from dynamics.engine.forces import (
    Pressure,
    checked_cylinder,
    piston_ends,
    piston_position,
    pressure_of_each,
)
from dynamics.engine.layout import EngineLayout
from dynamics.gas.gas_cycle import (
    LEAST_EXHAUST,
    GasCycle,
    GasCycleResult,
    Solved,
    gas_cycle,
    name_fields,
)
from dynamics.gas.pressure import (
    ATMOSPHERE,
    GasPressure,
    Position,
    gas_pressure,
    indicated_work,
    periodic_slope,
)
from dynamics.plots.curves import MEGA, draw_over_angle, from_top
from dynamics.response.order_excitation import checked_orders, checked_speeds


def phasors_of_samples(samples: Array) -> NDArray[np.complex128]:
    """Return mean and phasors of even samples over a cycle, angles counted from the first.

    Returns
    -------
    complex ndarray of shape (..., (m - 1) // 2 + 1)
        The mean, then Y_j of y = mean + Re sum of Y_j exp(i j 2 pi x / cycle). The order at half the
        sampling rate is left out: the samples do not determine its phase.
    """
    count = samples.shape[-1]
    phasors = np.fft.rfft(samples)[..., : (count - 1) // 2 + 1] / count
    phasors[..., 1:] *= 2.0
    return np.asarray(phasors)


def order_indices(orders: ArrayLike, strokes: int, samples: int, what: str) -> Integers:
    """Return the indices of orders among the phasors of samples over a cycle.

    Parameters
    ----------
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution, above zero and ascending.
    """
    values, step = checked_orders(orders), order_step(strokes)
    places = order_numbers(values, strokes)
    highest = (samples - 1) // 2
    beyond = np.flatnonzero(places > highest)
    if beyond.size:
        first = int(beyond[0])
        raise InputError(
            f"orders[{first}]: given {values[first]:g}; allowed are orders up to {step * highest:g}, because "
            f"{what} have {samples} samples over the cycle and in them a higher order looks like a lower "
            "one."
        )
    return np.asarray(places, dtype=np.int64)


def requested_orders(orders: ArrayLike | float, strokes: int) -> Array:
    """Return the requested orders (K,): those given, or all up to a highest one."""
    if np.ndim(orders) == 0:
        return engine_orders(strokes, cast(float, orders))
    return checked_orders(orders)


# A number, one for each speed, or a function of the speeds [rad/s].
Load = float | ArrayLike | Callable[[Array], ArrayLike]
# What a load is a measure of, and how it goes with the speed of a propeller.
PROPELLER_EXPONENTS = {"torque": 2.0, "power": 3.0}


def propeller_load(
    rated_speed: float, rated_load: float = 1.0, *, measure: Literal["torque", "power"] = "torque"
) -> Callable[[Array], Array]:
    """Return the load of an engine that drives a propeller, as a function of its speed.

    Parameters
    ----------
    rated_speed : float
        [rad/s].
    rated_load : float, optional
        Load at that speed, in the unit of the map.
    measure : {"torque", "power"}, optional
        What the load measures: torque (or mean effective pressure), which is proportional to the square
        of the speed, or power, proportional to its cube.

    Raises
    ------
    InputError
        If the speed is not above zero, the load is negative, or the measure is unknown.

    Examples
    --------
    >>> propeller_load(100.0)(np.array([50.0, 100.0])).tolist()
    [0.25, 1.0]
    """
    rated = positive_number("rated_speed", rated_speed, "rad/s", "the rated engine turns")
    most = nonnegative_number("rated_load", rated_load, "", "the engine drives")
    why = "a propeller takes the square or the cube of its speed of them"
    check_choice("measure", measure, PROPELLER_EXPONENTS, why)
    exponent = PROPELLER_EXPONENTS[measure]

    def load(speeds: Array) -> Array:
        return np.asarray(most * (speeds / rated) ** exponent, dtype=np.float64)

    return load


def load_at(load: Load, speeds: Array) -> Array:
    """Return the load at each speed (S,)."""
    values = finite_array("load", load(speeds) if callable(load) else load)
    if values.shape not in ((), speeds.shape):
        raise InputError(
            f"load: given an array of shape {values.shape}; allowed is a number or an array of shape "
            f"{speeds.shape}, because there is one load at each speed."
        )
    return np.array(np.broadcast_to(values, speeds.shape))


def per_minute(speed: float) -> str:
    """Return a speed [rad/s] for a message."""
    return f"{speed * RPM:.6g} 1/min"


Method = Literal["cubic", "linear"]
# Speeds or loads of two points are one within this share.
SAME = 1e-9


def sorted_unique(values: list[float]) -> Array:
    """Return values sorted in ascending order, each once."""
    ordered = np.unique(np.array(values))
    apart = np.diff(ordered, prepend=-np.inf) > SAME * np.abs(ordered)
    return np.asarray(ordered[apart])


def nearest_index(values: Array, value: float) -> int:
    """Return the index of the nearest value."""
    return int(np.argmin(np.abs(values - value)))


def axis_weights(field: str, grid: Array, asked: Array, method: Method) -> Array:
    """Return the weight of each grid value at the requested points (S, a)."""
    room = SAME * np.abs(grid[[0, -1]])
    outside = np.flatnonzero((asked < grid[0] - room[0]) | (asked > grid[-1] + room[1]))
    if outside.size:
        shown = per_minute if field == "speed" else "{:g}".format
        low, high = shown(float(grid[0])), shown(float(grid[-1]))
        allowed = low if grid.size == 1 else f"{low} to {high}"
        raise InputError(
            f"{field}: given {shown(float(asked[outside[0]]))}; allowed is {allowed}, because the pressure "
            "map has no diagrams beyond and is not extended."
        )
    within = np.clip(asked, grid[0], grid[-1])  # by round-off only
    unit = np.eye(grid.size)
    if grid.size == 1:
        return np.ones((asked.size, 1))
    if method == "linear":
        return np.array([np.interp(within, grid, node_values) for node_values in unit]).T
    from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

    # Through three points a parabola, through two a straight line.
    return np.asarray(CubicSpline(grid, unit)(within), dtype=np.float64)


# Lightest color that a curve has, of a scale from dark (0) to nearly white (1); columns of the legend.
LIGHTEST, LEGEND_COLUMNS = 0.85, 4


@frozen("speeds [rad/s]", "loads", "method", "samples", "remarks", eq=False)
class PressureMap:
    """Pressure diagrams at points of speed and load, and the interpolation between them.

    Made by `pressure_map`. Every complex harmonic of the pressure is interpolated over speed and
    load by a rule that is linear in the diagrams, so that the diagrams themselves, and the forces
    that follow from them, are interpolated with the same weights.

    Parameters
    ----------
    speeds : ndarray of shape (a,)
        Ascending [rad/s].
    loads : ndarray of shape (b,) or None
        Ascending, in the user's measure; None if each speed has its own load, as along a
        propeller's curve.
    diagrams : tuple of a * b GasPressure
        Speed by speed, load by load within each.
    load_of_speed : ndarray of shape (a,) or None
        Load of each speed's only diagram, where there is one.

    Raises
    ------
    InputError
        If speeds are not above zero and ascending, a load is not a finite number, or there is not a
        diagram for each point.
    """

    speeds: Array
    loads: Array | None
    diagrams: tuple[GasPressure, ...]
    method: Method
    load_of_speed: Array | None = None

    def __post_init__(self) -> None:
        speeds = checked_speeds(self.speeds)
        loads = None if self.loads is None else finite_vector("loads", self.loads)
        points = speeds.size * (1 if loads is None else loads.size)
        if len(self.diagrams) != points:
            raise InputError(
                f"diagrams: given {len(self.diagrams)}; allowed are {points}, because each point of speed "
                "and load has one."
            )

    @property
    def strokes(self) -> int:
        """Strokes per cycle, 2 or 4."""
        return self.diagrams[0].strokes

    @property
    def samples(self) -> int:
        """Samples over the cycle of the coarsest diagram, which limits the resolution."""
        return min(diagram.angles_deg.size for diagram in self.diagrams)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Changes made to the diagrams, each sentence once."""
        return tuple(dict.fromkeys(text for diagram in self.diagrams for text in diagram.remarks))

    def weights(self, speeds: ArrayLike, load: Load | None = None) -> Array:
        """Return the weight of each diagram at speeds, and at a load for each of them.

        Parameters
        ----------
        load : number, array_like of shape (S,) or callable, optional
            In the measure of the map; none where it has a single load, or one at each speed.

        Returns
        -------
        ndarray of shape (S, a * b)
            The sum of each row is one.

        Raises
        ------
        InputError
            If a speed or load is outside the map, which is never extrapolated, or a load is missing
            or superfluous.
        """
        asked = np.atleast_1d(turning_speeds("speeds", speeds))
        check_some("speeds", asked, "weights are at speeds")
        along = axis_weights("speed", self.speeds, asked, self.method)
        if self.loads is None and load is not None:
            raise InputError(
                "load: given for a pressure map with one diagram at each speed; allowed is none, "
                "because the speed determines the load."
            )
        if self.loads is None or (self.loads.size == 1 and load is None):
            return self._positive(along, asked)
        if load is None:
            raise InputError(
                f"load: given none; allowed are {self.loads[0]:g} to {self.loads[-1]:g}, because the "
                "pressure map has diagrams of several loads."
            )
        across = axis_weights("load", self.loads, load_at(load, asked), self.method)
        both = (along[:, :, np.newaxis] * across[:, np.newaxis]).reshape(asked.size, -1)
        return self._positive(both, asked)

    def phasors(
        self, orders: ArrayLike, speeds: ArrayLike, load: Load | None = None
    ) -> NDArray[np.complex128]:
        """Return the complex harmonics of the pressure, counted from the cylinder's firing top.

        Returns
        -------
        complex ndarray of shape (K, S)
            P_k [Pa] of p = Re sum of P_k exp(i k x).

        Raises
        ------
        InputError
            As `weights`, and if the diagrams do not resolve an order.
        """
        places = order_indices(orders, self.strokes, self.samples, "the pressure map's diagrams")
        of_diagrams = phasors_of_samples(self._sampled)[:, places]
        return np.asarray((self.weights(speeds, load) @ of_diagrams).T)

    def at(self, speed: float, load: float | None = None) -> GasPressure:
        """Return the diagram at a speed [rad/s] and a load.

        Raises
        ------
        InputError
            As `weights`, and if the spline falls below zero.
        """
        running = positive_number("speed", speed, "rad/s", "the engine runs")
        mixed = (self.weights([running], load) @ self._sampled)[0]
        at_load = "" if load is None else f" and load {load:g}"
        return gas_pressure(
            mixed,
            self.strokes,
            source=f"pressure map at {per_minute(running)}{at_load}, {self.method} between diagrams",
            remarks=self.remarks,
            angles_deg=np.degrees(self._angles()),
        )

    def _positive(self, weights: Array, speeds: Array) -> Array:
        """Return weights (S, D), refusing those that give a pressure below zero."""
        uneven = np.flatnonzero(np.any(weights < 0.0, axis=1))  # others lie between diagrams
        lowest = np.min(weights[uneven] @ self._sampled, axis=1)
        if np.any(lowest <= 0.0):
            worst = int(np.argmin(lowest))
            place = int(uneven[worst])
            raise InputError(
                f"speed: given {per_minute(float(speeds[place]))}, where the {self.method} between "
                f"diagrams falls to {lowest[worst]:g} Pa; allowed are speeds and loads at which the pressure "
                'stays above zero (method="linear" keeps it so), because it is absolute pressure.'
            )
        return weights

    def _angles(self) -> Array:
        finest = max(diagram.angles_deg.size for diagram in self.diagrams)
        return even_angles(cycle_radians(self.diagrams[0].strokes), finest)

    @cached_property
    def _sampled(self) -> Array:
        """Return all diagrams at the samples of the finest (a * b, m) [Pa]."""
        angles = self._angles()
        return np.array([diagram.at(angle_deg=np.degrees(angles)) for diagram in self.diagrams])

    def plot(
        self, axes: Axes | None = None, *, speed: float | None = None, load: float | None = None
    ) -> Axes:
        """Draw the map's diagrams over the crank angle at one load, or the one at a speed and load.

        Parameters
        ----------
        speed : float, optional
            Speed at which one diagram is interpolated [rad/s]; by default those of all speeds of the map.
        load : float, optional
            If the map has loads: any with a speed, one of the map's without; the highest by default.
        """
        if speed is not None:
            axes = self.at(speed, load).plot(axes)
            write_title(axes, f"Gas pressure at {RPM * speed:.4g} 1/min")
            return axes
        place = self._load_index(load)
        apart = 1 if self.loads is None else len(self.loads)
        speeds = self.speeds.tolist()
        names = [f"{RPM * each:.4g} 1/min" for each in speeds]
        if len(set(names)) < len(names):
            names = [per_minute(each) for each in speeds]
        if self.load_of_speed is not None:
            pairs = zip(names, self.load_of_speed, strict=True)
            names = [f"{name}, load {speed_load:g}" for name, speed_load in pairs]
        curves = {
            name: MEGA * self._sampled[number * apart + place] for number, name in enumerate(names)
        }
        from matplotlib import colormaps

        # From dark to light by speed, which a few colors in turn would not tell.
        shades = np.linspace(0.0, LIGHTEST, len(curves))
        colors = list(colormaps["viridis"](shades))
        axes, label = new_axes(axes), "absolute pressure [MPa]"
        from_firing = from_top(self.strokes)
        draw_over_angle(axes, self._angles(), curves, label, angle_label=from_firing, colors=colors)
        axes.set_ylim(bottom=0.0)
        at_load = "" if self.loads is None else f" at load {self.loads[place]:g}"
        write_title(axes, f"Gas pressure{at_load}")
        legend_below(axes, LEGEND_COLUMNS)
        return axes

    def _load_index(self, load: float | None) -> int:
        """Return the index of the load to draw among those at every speed, the highest by default."""
        if load is None:
            return 0 if self.loads is None else len(self.loads) - 1
        wanted = nonnegative_number("load", load, "", "the map has diagrams at its loads")
        known = np.array([]) if self.loads is None else self.loads
        near = np.flatnonzero(np.abs(known - wanted) <= SAME * np.abs(known))
        if not near.size:
            allowed = ", ".join(f"{map_load:g}" for map_load in known) or "none"
            raise InputError(
                f"load: given {wanted:g} without a speed; allowed are {allowed}, because the map's own "
                "diagrams at all speeds are drawn."
            )
        return int(near[0])


def pressure_map(
    points: Iterable[tuple[float, float, GasPressure]], *, method: Method = "cubic"
) -> PressureMap:
    """Build a pressure map from diagrams at points of speed and load.

    Parameters
    ----------
    points : iterable of (speed, load, GasPressure)
        Speed [rad/s], load in any measure, the same for all (share of the rated torque, mean
        effective pressure, power), and the diagram. Either every load at every speed, or one load
        at each speed, as along a propeller's curve.

    Raises
    ------
    InputError
        If there are no points, strokes differ, a point is given twice, or points do not fill a grid.
    """
    points = list(points)
    if any(not isinstance(point, Sequence) or len(point) != 3 for point in points):
        raise InputError(
            "points: given one that is not of three; allowed are (speed, load, diagram), because each "
            "diagram has both."
        )
    checked = [
        (
            positive_number("pressure map speed", speed, "rad/s", "the engine runs"),
            nonnegative_number("pressure map load", load, "", "it drives"),
            diagram,
        )
        for speed, load, diagram in points
    ]
    check_some("points", checked, "a map has diagrams")
    check_choice("method", method, get_args(Method), "these are the ways between the diagrams")
    strokes = {diagram.strokes for _, _, diagram in checked}
    if len(strokes) > 1:
        raise InputError(
            "points: given diagrams of 2 and of 4 strokes; allowed is one kind, because they are of "
            "one engine."
        )
    speeds = sorted_unique([speed for speed, _, _ in checked])
    loads = sorted_unique([load for _, load, _ in checked])
    places = [
        (nearest_index(speeds, speed), nearest_index(loads, load)) for speed, load, _ in checked
    ]
    diagrams = dict(zip(places, [diagram for _, _, diagram in checked], strict=True))
    if len(diagrams) < len(checked):
        raise InputError(
            f"points: given {len(checked)} points of which {len(diagrams)} differ in speed or load; allowed "
            "is each point once, because it has one diagram."
        )
    if len(diagrams) == speeds.size * loads.size:
        return PressureMap(
            read_only(speeds),
            read_only(loads),
            tuple(diagrams[row, column] for row, column in np.ndindex(speeds.size, loads.size)),
            method,
        )
    if len(diagrams) == speeds.size == len({row for row, _ in diagrams}):
        along = sorted(diagrams)
        return PressureMap(
            read_only(speeds),
            None,
            tuple(diagrams[place] for place in along),
            method,
            read_only(np.array([loads[column] for _, column in along])),
        )
    missing = next(place for place in np.ndindex(speeds.size, loads.size) if place not in diagrams)
    raise InputError(
        f"points: given {len(diagrams)} points with {speeds.size} speeds and {loads.size} loads, none at "
        f"{per_minute(float(speeds[missing[0]]))} and load {loads[missing[1]]:g}; allowed are all loads "
        "at every speed, or one at each, because what lies between is interpolated along both (loads as "
        "shares of the full load of each speed make a grid)."
    )


# What a cycle has of its own, and its solution is not told.
OF_CYCLE = ("intake_pressure", "exhaust_pressure")


class CycleTargets(TypedDict, total=False):
    """What is known of the cycles of a map; see `pressure_map_from_cycles`."""

    heat: ArrayLike | None
    peak_pressure: ArrayLike | None
    mean_effective_pressure: ArrayLike | None
    intake_pressure: ArrayLike | None
    exhaust_pressure: ArrayLike | None


def pressure_map_from_cycles(
    cycle: GasCycle,
    position: Position,
    area: float,
    speeds: ArrayLike,
    loads: ArrayLike,
    *,
    solve_for: Solved = "combustion_start_deg",
    samples: int | None = None,
    method: Method = "cubic",
    **targets: Unpack[CycleTargets],
) -> PressureMap:
    """Calculate a cycle at each point of speed and load that reaches the values known there.

    Parameters
    ----------
    cycle : GasCycle
        Parameters that the points do not specify.
    position, area, samples, solve_for
        As for `gas_cycle`.
    speeds : array_like of shape (a,)
        [rad/s].
    heat : array_like of shape (a, b), optional
        Heat released in one cycle at each point [J], instead of the pressures below; 0 is a motored
        engine.
    peak_pressure, mean_effective_pressure : array_like of shape (a, b), optional
        Highest absolute pressure, and indicated mean effective pressure [Pa] at each point; one of
        them or both. Shapes that broadcast to (a, b) are allowed.
    intake_pressure, exhaust_pressure : array_like of shape (a, b), optional
        Absolute pressure at the end of the intake and during exhaust [Pa]; by default those of the
        cycle. With a turbocharger both rise together.

    Raises
    ------
    InputError
        If a shape does not fit, or a cycle cannot reach its point (the message names it).
    """
    running, loaded = finite_vector("speeds", speeds), finite_vector("loads", loads)
    shape = (running.size, loaded.size)
    known = {}
    for name, values in targets.items():
        if values is not None:
            array = finite_array(name, cast("ArrayLike", values))
            try:
                known[name] = np.broadcast_to(array, shape)
            except ValueError:
                raise InputError(
                    f"{name}: given an array of shape {array.shape}; allowed is {shape}, because there is "
                    "one for each speed and load."
                ) from None
    points = []
    for place in np.ndindex(*shape):
        speed, load = float(running[place[0]]), float(loaded[place[1]])
        wanted = {name: float(values[place]) for name, values in known.items()}
        receivers: dict[str, Any] = {name: wanted.pop(name) for name in OF_CYCLE if name in wanted}
        try:
            solved = gas_cycle(
                replace(cycle, **receivers),
                position,
                area,
                **wanted,
                solve_for=solve_for,
                samples=samples,
            )
        except InputError as error:
            raise InputError(
                f"at {per_minute(speed)} and load {load:g}: {kept(str(error))}"
            ) from None
        # What was solved at each point would make a remark of its own for every one.
        pressure = solved.pressure
        remarks = tuple(text for text in pressure.remarks if text not in pressure.solved)
        points.append((speed, load, replace(pressure, remarks=remarks, solved=())))
    return pressure_map(points, method=method)


# Pressure of one kind for all cylinders, or one for each.
AnyPressure = Pressure | PressureMap
Pressures = AnyPressure | Sequence[AnyPressure]
Weights = Callable[[Array, Load | None], Array]


@dataclass(frozen=True, eq=False)
class GasSource:
    """Diagrams whose weighted sum is the pressure in a cylinder.

    Parameters
    ----------
    weights : callable
        Speeds (S,) [rad/s] and load to the weight of each diagram (S, D).
    """

    diagrams: tuple[Pressure, ...]
    weights: Weights
    takes_load: bool
    at_all_speeds: bool

    @property
    def samples(self) -> int | None:
        """Samples over the cycle of the coarsest diagram, None if none is sampled."""
        known = [
            diagram.angles_deg.size for diagram in self.diagrams if isinstance(diagram, GasPressure)
        ]
        return min(known, default=None)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Those on the diagrams."""
        return tuple(text for diagram in self.diagrams for text in getattr(diagram, "remarks", ()))

    @property
    def changes(self) -> tuple[str, ...]:
        """Those that tell of changes made to the diagrams."""
        return tuple(text for diagram in self.diagrams for text in getattr(diagram, "changes", ()))


def gas_sources(
    engine: EngineLayout,
    pressure: Pressures,
    misfire: Mapping[int, float] | None = None,
    motored: Pressures | None = None,
) -> tuple[GasSource, ...]:
    """Return the source of the pressure in each cylinder; equal sources are one object."""
    fired = _one_for_each("pressure", pressure, engine)
    failing = {}
    for number, share in (misfire or {}).items():
        cylinder, field = checked_cylinder(engine, number), f"misfire[{number}]"
        reason = "it is the share of the combustion that is missing"
        failing[cylinder] = number_within(field, share, 0.0, 1.0, "", reason)
    if not failing:
        return tuple(fired)
    if motored is None:
        raise InputError(
            f"motored: given none for misfire in cylinder {min(failing)}; allowed is the pressure without "
            "combustion (of the cycle model with heat=0, measured, or by `motored_from_compression`), "
            "because a fired diagram alone does not define it."
        )
    cold = _one_for_each("motored", motored, engine)
    made: dict[tuple[GasSource, GasSource, float], GasSource] = {}
    for number, share in failing.items():
        with_fuel, without = fired[number - 1], cold[number - 1]
        mixed = GasSource(
            with_fuel.diagrams + without.diagrams,
            partial(_mixed_weights, with_fuel, without, share),
            with_fuel.takes_load or without.takes_load,
            with_fuel.at_all_speeds or without.at_all_speeds,
        )
        fired[number - 1] = made.setdefault((with_fuel, without, share), mixed)
    return tuple(fired)


def _one_for_each(field: str, pressure: Pressures, engine: EngineLayout) -> list[GasSource]:
    pressures = pressure_of_each(field, pressure, engine)
    made: dict[AnyPressure, GasSource] = {}
    for each in pressures:
        made[each] = (
            GasSource(each.diagrams, each.weights, True, False)
            if isinstance(each, PressureMap)
            else GasSource((each,), constant_weight, False, True)
        )
    return [made[each] for each in pressures]


def constant_weight(speeds: Array, _load: Load | None) -> Array:
    """Return the constant weight of a diagram that is used at every speed."""
    return np.ones((speeds.size, 1))


def _mixed_weights(
    fired: GasSource, cold: GasSource, share: float, speeds: Array, load: Load | None
) -> Array:
    left = (1.0 - share) * fired.weights(speeds, load)
    return np.hstack([left, share * cold.weights(speeds, load)])


# Speeds of calculated diagrams lie this share apart at most; splines pass between them without a bend, for a
# bend of the excitation would look like a resonance.
SPACING = 0.1


@dataclass(frozen=True, eq=False)
class LoadCurve:
    """Results of the cycle at each speed, relative to full load at rated speed.

    Parameters
    ----------
    speeds : ndarray of shape (S,)
        Ascending [rad/s].
    mean_pressure : ndarray of shape (S,)
        Indicated mean effective pressure divided by that of full load.
    intake_pressure, exhaust_pressure : ndarray of shape (S,)
        Absolute, of the receivers [Pa].
    peak_pressure : ndarray of shape (S,) or None
        Absolute [Pa]; None if it follows from the combustion at full load.
    """

    speeds: Array
    mean_pressure: Array
    intake_pressure: Array
    exhaust_pressure: Array
    peak_pressure: Array | None


@dataclass(frozen=True, eq=False)
class LoadPoints:
    """Load at several speeds; a series that is not known is None.

    Parameters
    ----------
    speeds : ndarray of shape (n,)
        Ascending [rad/s].
    mean_pressure, peak_pressure, intake_pressure : ndarray of shape (n,)
        Indicated mean effective pressure; absolute pressures [Pa].
    """

    speeds: Array
    mean_pressure: Array
    peak_pressure: Array | None
    intake_pressure: Array | None


def load_curve(
    points: LoadPoints | None,
    full: GasCycleResult,
    rated_speed: float,
    speeds: Array,
    friction_pressure: float = 0.0,
) -> LoadCurve:
    """Return the results of the cycle at speeds.

    Parameters
    ----------
    points : LoadPoints or None
        None for the law of a propeller.
    full : GasCycleResult
        Cycle of the first cylinder at full load and rated speed.
    rated_speed : float
        [rad/s]
    speeds : (S,) array
        Ascending, within the points if there are any [rad/s].
    friction_pressure : float, optional
        Mean pressure that friction takes at any speed [Pa]: the propeller takes the rest.

    Notes
    -----
    The mean effective pressure of a propeller is proportional to the square of the speed, its power to
    the cube; both continue above rated speed. The boost is proportional to the power, because the exhaust
    drives the turbocharger. Curves between points are smooth and pass no point above or below its
    neighbors.
    """
    if points is None:
        friction = friction_pressure / full.mean_effective_pressure
        share = friction + (1.0 - friction) * (speeds / rated_speed) ** 2
    else:
        known = points.speeds
        outside = (speeds < known[0] * (1.0 - SAME)) | (speeds > known[-1] * (1.0 + SAME))
        if np.any(outside):
            outer, low, high = (
                amount(float(speed), "rad/s", 5)
                for speed in (speeds[outside][0], known[0], known[-1])
            )
            raise InputError(
                f"load.points: given none for {outer}; allowed are speeds from {low} to {high}, because "
                "nothing is extrapolated beyond the points."
            )
        share = _between(speeds, points, points.mean_pressure) / full.mean_effective_pressure
    boost, peak = share * speeds / rated_speed, None
    taken_in = _boosted(full.cycle.intake_pressure, ATMOSPHERE, boost)
    if points is not None and points.peak_pressure is not None:
        peak = _between(speeds, points, points.peak_pressure)
    if points is not None and points.intake_pressure is not None:
        taken_in = _between(speeds, points, points.intake_pressure)
        at_full = max(full.cycle.intake_pressure - ATMOSPHERE, 0.0)
        boost = np.maximum(taken_in - ATMOSPHERE, 0.0) / at_full if at_full else boost
    exhaust = _boosted(full.cycle.exhaust_pressure, LEAST_EXHAUST, boost)
    return LoadCurve(speeds, share, taken_in, exhaust, peak)


def pressures_along(
    curve: LoadCurve,
    full_load: Sequence[GasCycleResult],
    layout: EngineLayout,
    *,
    motored: bool = False,
) -> tuple[PressureMap, ...]:
    """Return the pressure in each cylinder over the speeds of a curve, equal cylinders with one map.

    Parameters
    ----------
    full_load : sequence of n GasCycleResult
        Cycle in each cylinder at full load.
    motored : bool, optional
        Without combustion, at the same boost.
    """
    column = np.s_[:, np.newaxis]
    peak = None if motored or curve.peak_pressure is None else curve.peak_pressure[column]
    made: dict[GasCycleResult, PressureMap] = {}
    for number, full in enumerate(full_load, start=1):
        if full in made:
            continue
        mean = None if motored else (curve.mean_pressure * full.mean_effective_pressure)[column]
        try:
            made[full] = pressure_map_from_cycles(
                replace(full.cycle, assumed=()),  # what was assumed is told of full load
                piston_position(layout, number),
                layout.cylinders[number - 1].area,
                curve.speeds,
                [1.0],
                heat=0.0 if motored else None,
                mean_effective_pressure=mean,
                peak_pressure=peak,
                intake_pressure=curve.intake_pressure[column],
                exhaust_pressure=curve.exhaust_pressure[column],
                method="cubic",
            )
        except InputError as error:
            raise InputError(f"load: {name_fields(error)}") from None
    return tuple(made[full] for full in full_load)


def _boosted(at_full: float, ambient: float, boost: Array) -> Array:
    """Return a pressure whose part above ambient is multiplied by the boost [Pa]."""
    if at_full <= ambient:
        return np.full(boost.shape, at_full)
    return np.asarray(ambient + (at_full - ambient) * boost)


def _between(speeds: Array, points: LoadPoints, values: Array) -> Array:
    """Interpolate smoothly, without overshoot."""
    known = points.speeds
    inside = np.clip(speeds, known[0], known[-1])  # by round-off only
    return MonotoneCurve(known, values)(inside)


def load_speeds(points: LoadPoints | None, speed_range: tuple[float, float], rated: float) -> Array:
    """Return speeds close enough for splines between their diagrams [rad/s].

    Parameters
    ----------
    points : LoadPoints or None
        They determine the range; without them the rated speed is among the speeds.
    """
    further = [rated] if points is None else points.speeds.tolist()
    low, high = speed_range if points is None else (further[0], further[-1])
    count = 1 + math.ceil(math.log(high / low) / math.log1p(SPACING))
    return sorted_unique([*np.geomspace(low, high, max(count, 2)).tolist(), *further])


# Rated power beside the indicated one: 0.75 in small old engines, 0.97 in slow-running crosshead ones.
LOWEST_EFFICIENCY, HIGHEST_EFFICIENCY = 0.75, 0.97


@result(
    "indicated",
    "mean_indicated_pressure",
    "rated",
    "mean_effective_pressure",
    "mechanical_efficiency",
    eq=True,
)
class EnginePower(Result):
    """Power at rated speed of an engine, or of a machine that is driven.

    The power of the gas is below zero where it takes work from the pistons.
    """

    speed: Speed
    indicated: Annotated[float, Quantity("W", "of the gas on all pistons", key="indicated_power")]
    mean_indicated_pressure: Annotated[float, Quantity("Pa", "mean of all cylinders")]
    rated: Annotated[float | None, Quantity("W", "at the flywheel, if given", key="rated_power")]
    driven: Annotated[bool | None, Quantity("", "whether it takes power", left_out=True)] = None

    @cached_property
    def mechanical_efficiency(self) -> Number | None:
        """Rated over indicated power, the other way round of a driven machine.

        None without a rated power, or if the gas does no work: takes none, of a driven machine.
        """
        gas = -self.indicated if self.driven else self.indicated
        if self.rated is None or gas <= 0.0:
            return None
        return gas / self.rated if self.driven else self.rated / gas

    @cached_property
    def mean_effective_pressure(self) -> Annotated[float, Quantity("Pa")] | None:
        """Mean effective pressure of the rated power; None if the file does not give it."""
        if self.rated is None or self.mechanical_efficiency is None:
            return None
        return self.rated / abs(self.indicated) * self.mean_indicated_pressure

    @property
    def friction_pressure(self) -> float:
        """Friction mean pressure [Pa]; zero if the rated power is unknown or inconsistent."""
        if self.mean_effective_pressure is None or not self.consistent:
            return 0.0
        return self.mean_indicated_pressure - self.mean_effective_pressure

    @cached_property
    def consistent(self) -> Part[bool]:
        """Whether the mechanical efficiency is plausible; True if it is unknown."""
        if self.rated is None:
            return True
        efficiency = self.mechanical_efficiency
        return efficiency is not None and LOWEST_EFFICIENCY <= efficiency <= HIGHEST_EFFICIENCY

    @cached_property
    def sentence(self) -> Part[str]:
        """Indicated power and its ratio to the rated power."""
        speed = amount(self.speed, "rad/s", 5)
        sense = -1.0 if self.driven else 1.0
        indicated = (
            f"indicated power {_kilowatts(sense * self.indicated)}{' taken' if self.driven else ''} at "
            f"{speed}, mean indicated pressure "
            f"{amount(sense * self.mean_indicated_pressure, 'Pa', 4)}"
        )
        if self.rated is None:
            return (
                f"{indicated}; engine.rated_power is not given, so the gas pressure is not checked"
            )
        if self.mechanical_efficiency is None or self.mean_effective_pressure is None:
            return (
                f"The file is inconsistent: rated power {_kilowatts(self.rated)}, but {indicated}; correct "
                f"the section [gas]{self._other_sense}"
            )
        effective = (
            f"rated power {_kilowatts(self.rated)} (mean effective pressure "
            f"{amount(sense * self.mean_effective_pressure, 'Pa', 4)})"
        )
        share = f"{self.mechanical_efficiency:.3g}"
        if self.consistent:
            parts = (
                f"it is {share} of the {effective}"
                if self.driven
                else f"{effective} is {share} of it"
            )
            return f"{indicated}; {parts}, the mechanical efficiency"
        compared = (
            f"{indicated} is {share} of the {effective}"
            if self.driven
            else f"{effective} is {share} of the {indicated}"
        )
        return (
            f"The file is inconsistent: {compared}; usual mechanical "
            f"efficiencies are {LOWEST_EFFICIENCY:g} to {HIGHEST_EFFICIENCY:g}, so correct "
            "engine.rated_power or the section [gas]"
        )

    @property
    def _other_sense(self) -> str:
        if self.driven:
            return ", because the gas of a driven machine takes work from the pistons"
        return (
            " or, of a compressor, give engine.driven_by, because no engine drives with gas that does no "
            "work"
        )


def indicated_power(
    layout: EngineLayout, pressures: Sequence[GasPressure], speed: float
) -> tuple[float, float]:
    """Return indicated power [W] and mean indicated pressure [Pa] of all cylinders at a speed [rad/s]."""
    work = swept = 0.0
    for number, (cylinder, pressure) in enumerate(
        zip(layout.cylinders, pressures, strict=True), start=1
    ):
        low, high = piston_ends(layout, number)
        swept += cylinder.area * (high - low)
        slope = periodic_slope(
            piston_position(layout, number)(np.radians(pressure.angles_deg)),
            cycle_radians(pressure.strokes),
        )
        work += indicated_work(pressure.pressure, -cylinder.area * slope, layout.strokes)
    cycles = speed / (math.pi * layout.strokes)
    return work * cycles, work / swept


def _kilowatts(power: float) -> str:
    return amount(power, "W", 4, shown="kW")
