"""The pressure in a cylinder over speed and load, interpolated by harmonics."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.arrays import (
    FloatArray,
    finite_vector,
    nonnegative_number,
    positive_number,
    read_only,
    turning_speeds,
)
from crankbase.checks.choices import check_choice
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import legend_below, write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes
from crankbase.summaries import summarized
from crankbase.units.units import RPM
from dynamics.cycle import cycle_radians, even_angles
from dynamics.excitation.engine_load import Load, load_at, per_minute
from dynamics.excitation.grid_weights import (
    SAME,
    Method,
    axis_weights,
    nearest_index,
    sorted_unique,
)
from dynamics.excitation.sampled_phasors import order_indices, phasors_of_samples
from dynamics.gas.pressure import GasPressure, gas_pressure
from dynamics.plots.curves import FROM_FIRING, draw_over_angle
from dynamics.plots.quantities import MEGA
from dynamics.response.order_excitation import checked_speeds

# Lightest color that a curve has, of a scale from dark (0) to nearly white (1); columns of the legend.
LIGHTEST, LEGEND_COLUMNS = 0.85, 4


@summarized("speeds [rad/s]", "loads", "method", "samples", "remarks")
@dataclass(frozen=True, eq=False)
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
    method : {"cubic", "linear"}
        Along either axis: cubic spline, or linear.
    load_of_speed : ndarray of shape (a,) or None
        Load of each speed's only diagram, where there is one.

    Raises
    ------
    InputError
        If speeds are not above zero and ascending, a load is not a finite number, or there is not a
        diagram for each point.
    """

    speeds: FloatArray
    loads: FloatArray | None
    diagrams: tuple[GasPressure, ...]
    method: Method
    load_of_speed: FloatArray | None = None

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
        return tuple(dict.fromkeys(text for own in self.diagrams for text in own.remarks))

    def weights(self, speeds: ArrayLike, load: Load | None = None) -> FloatArray:
        """Return the weight of each diagram at speeds, and at a load for each of them.

        Parameters
        ----------
        speeds : array_like of shape (S,)
            [rad/s].
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
        if asked.size == 0:
            raise InputError(
                "speeds: given none; allowed is one or more, because weights are at speeds."
            )
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

        Parameters
        ----------
        orders : array_like of shape (K,)
            In cycles per crankshaft revolution.
        speeds, load
            As for `weights`.

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

    def _positive(self, weights: FloatArray, speeds: FloatArray) -> FloatArray:
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

    def _angles(self) -> FloatArray:
        finest = max(diagram.angles_deg.size for diagram in self.diagrams)
        return even_angles(cycle_radians(self.diagrams[0].strokes), finest)

    @cached_property
    def _sampled(self) -> FloatArray:
        """Return all diagrams at the samples of the finest (a * b, m) [Pa]."""
        angles = self._angles()
        return np.array([diagram.at(angle_deg=np.degrees(angles)) for diagram in self.diagrams])

    def plot(
        self, axes: Axes | None = None, *, speed: float | None = None, load: float | None = None
    ) -> Axes:
        """Draw the map's diagrams over the crank angle at one load, or the one at a speed and load.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        speed : float, optional
            Speed at which one diagram is interpolated [rad/s]; by default those of all speeds of the map.
        load : float, optional
            If the map has loads: any with a speed, one of the map's without; the highest by default.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            As `at`, or if the map has no diagrams at this load.
        """
        if speed is not None:
            axes = self.at(speed, load).plot(axes)
            write_title(axes, f"Gas pressure at {RPM * speed:.4g} 1/min")
            return axes
        place = self._load_index(load)
        apart = 1 if self.loads is None else len(self.loads)
        names = _speed_names(self.speeds)
        if self.load_of_speed is not None:
            pairs = zip(names, self.load_of_speed, strict=True)
            names = [f"{name}, load {own:g}" for name, own in pairs]
        curves = {
            name: MEGA * self._sampled[number * apart + place] for number, name in enumerate(names)
        }
        from matplotlib import colormaps

        # From dark to light by speed, which a few colors in turn would not tell.
        shades = np.linspace(0.0, LIGHTEST, len(curves))
        colors = list(colormaps["viridis"](shades))
        axes, label = new_axes(axes), "absolute pressure [MPa]"
        draw_over_angle(axes, self._angles(), curves, label, angle_label=FROM_FIRING, colors=colors)
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
            said = ", ".join(f"{own:g}" for own in known) or "none"
            raise InputError(
                f"load: given {wanted:g} without a speed; allowed are {said}, because the map's own "
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
    method : {"cubic", "linear"}, optional
        Interpolation between the diagrams, along either axis.

    Returns
    -------
    PressureMap

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
    given = [
        (
            positive_number("pressure map speed", speed, "rad/s", "the engine runs"),
            nonnegative_number("pressure map load", load, "", "it drives"),
            diagram,
        )
        for speed, load, diagram in points
    ]
    if not given:
        raise InputError("points: given none; allowed are one or more, because a map has diagrams.")
    check_choice("method", method, get_args(Method), "these are the ways between the diagrams")
    strokes = {diagram.strokes for _, _, diagram in given}
    if len(strokes) > 1:
        raise InputError(
            "points: given diagrams of 2 and of 4 strokes; allowed is one kind, because they are of "
            "one engine."
        )
    speeds = sorted_unique([speed for speed, _, _ in given])
    loads = sorted_unique([load for _, load, _ in given])
    places = [
        (nearest_index(speeds, speed), nearest_index(loads, load)) for speed, load, _ in given
    ]
    found = dict(zip(places, [diagram for _, _, diagram in given], strict=True))
    if len(found) < len(given):
        raise InputError(
            f"points: given {len(given)} points of which {len(found)} differ in speed or load; allowed "
            "is each point once, because it has one diagram."
        )
    if len(found) == speeds.size * loads.size:
        return PressureMap(
            read_only(speeds),
            read_only(loads),
            tuple(found[row, column] for row, column in np.ndindex(speeds.size, loads.size)),
            method,
        )
    if len(found) == speeds.size == len({row for row, _ in found}):
        along = sorted(found)
        return PressureMap(
            read_only(speeds),
            None,
            tuple(found[place] for place in along),
            method,
            read_only(np.array([loads[column] for _, column in along])),
        )
    missing = next(place for place in np.ndindex(speeds.size, loads.size) if place not in found)
    raise InputError(
        f"points: given {len(found)} points with {speeds.size} speeds and {loads.size} loads, none at "
        f"{per_minute(float(speeds[missing[0]]))} and load {loads[missing[1]]:g}; allowed are all loads "
        "at every speed, or one at each, because what lies between is interpolated along both (loads as "
        "shares of the full load of each speed make a grid)."
    )


def _speed_names(speeds: FloatArray) -> list[str]:
    """Return speeds [rad/s] for a legend, to four digits if these distinguish them."""
    short = [f"{RPM * speed:.4g} 1/min" for speed in speeds.tolist()]
    return short if len(set(short)) == len(short) else [per_minute(one) for one in speeds.tolist()]
