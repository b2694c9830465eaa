"""Moments on an engine's shaft at an angle and a speed: gas, load, friction and weight."""

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crankbase.array_checks import (
    LARGEST,
    ComplexArray,
    FloatArray,
    finite_array,
    nonnegative_number,
)
from dynamics.cycle import cycle_radians, even_angles
from dynamics.engine import RodModelName
from dynamics.engine.forces import (
    Pressure,
    parts_motion,
    piston_ends,
    pressure_of_each,
    reduced_inertia,
    rod_models,
    turn_spectrum,
)
from dynamics.engine.layout import EngineLayout
from dynamics.engine.rods import RodModel
from dynamics.turning.speed_over_angle import checked_inertia, checked_moment

# Samples that show how large a curve is, and the share of that which counts as nothing.
SIZE_SAMPLES = 64
NEGLIGIBLE = 1e-17


@dataclass(frozen=True, eq=False)
class TurnCurves:
    """Several periodic curves as Fourier series, with derivatives.

    Parameters
    ----------
    coefficients : complex ndarray of shape (c, K)
        a_k of Re sum a_k exp(i k phi), k from 1.
    """

    mean: FloatArray
    coefficients: ComplexArray

    def at(self, angle: float) -> tuple[FloatArray, FloatArray]:
        """Return values and derivatives by the angle [rad] of all curves, each of shape (c,)."""
        numbers = np.arange(1, self.coefficients.shape[1] + 1)
        terms = np.exp(1j * angle * numbers)
        values = self.mean + (self.coefficients @ terms).real
        return values, -(self.coefficients @ (numbers * terms)).imag


def turn_curves(function: Callable[[FloatArray], FloatArray]) -> TurnCurves:
    """Return the series of curves over a revolution.

    Parameters
    ----------
    function : callable
        Takes angles (m,) [rad] and returns the curves' values (c, m).
    """
    largest = np.max(
        np.abs(function(even_angles(2.0 * np.pi, SIZE_SAMPLES))), axis=1, keepdims=True
    )
    # Each curve by its own size: inertias and lengths are not to be compared.
    scale = np.where(largest > 0.0, largest, 1.0)
    spectrum = scale * turn_spectrum(lambda angles: function(angles) / scale, 1)
    half = spectrum.shape[1] // 2
    terms = 2.0 * spectrum[:, 1:half]
    above = np.flatnonzero(np.max(np.abs(terms) / scale, axis=0) > NEGLIGIBLE)
    needed = int(above[-1]) + 1 if above.size else 0
    return TurnCurves(spectrum[:, 0].real.copy(), terms[:, :needed].copy())


def engine_curves(engine: EngineLayout, models: tuple[RodModel, ...]) -> TurnCurves:
    """Return the curves of an engine: positions of the n pistons, inertia, static moment upwards.

    Returns
    -------
    TurnCurves
        c = n + 2: s of each piston pin [m]; inertia reduced to the shaft [kg m^2]; sum of masses
        times heights [kg m], which determines the work of gravity.
    """
    return turn_curves(functools.partial(_engine_samples, engine, models))


def _engine_samples(
    engine: EngineLayout, models: tuple[RodModel, ...], angles: FloatArray
) -> FloatArray:
    places = []
    height = np.zeros(angles.shape)
    for number, (cylinder, model) in enumerate(zip(engine.cylinders, models, strict=True), start=1):
        motion = parts_motion(engine, number, angles)
        upwards = np.exp(1j * math.radians(cylinder.bank_angle_deg))
        places.append(motion.piston.place.real)
        height += cylinder.piston_mass * (upwards * motion.piston.place).real
        height += model.mass * (upwards * motion.rod_point(model.center).place).real
    for mass in engine.rotating:
        height += mass.static_moment * np.cos(math.radians(mass.angle_deg) + angles)
    inertia, _ = reduced_inertia(engine, models, shaft_angles_deg=np.degrees(angles))
    return np.array([*places, inertia, height])


# Force on a piston towards the shaft [N]: of the cylinder's number, the piston's place (0 lowest to
# 1 highest), its direction (1 away from the shaft, -1 towards it), and the angle from the
# cylinder's firing top [rad].
PistonForce = Callable[[int, float, Literal[-1, 1], float], float]
Gas = Pressure | Sequence[Pressure] | PistonForce | None


@dataclass(frozen=True, eq=False)
class PistonGas:
    """The gas in all cylinders.

    Parameters
    ----------
    forces : callable
        (shaft angle [rad], pistons' s (n,) [m], directions (n,)) -> forces towards the shaft (n,)
        [N].
    """

    forces: Callable[[float, FloatArray, FloatArray], FloatArray]
    turns_at_ends: bool


def piston_gas(engine: EngineLayout, gas: Gas, crankcase_pressure: float) -> PistonGas:
    """Return the gas forces from pressures, or from a function of the piston's position and direction."""
    if gas is None:
        return PistonGas(lambda _angle, places, _directions: np.zeros(places.shape), False)
    if callable(gas):
        return PistonGas(_from_places(engine, gas), True)
    under = nonnegative_number("crankcase_pressure", crankcase_pressure, "Pa", "it is absolute")
    return PistonGas(_from_pressures(engine, gas, under), False)


def _from_pressures(
    engine: EngineLayout, gas: Pressure | Sequence[Pressure], crankcase_pressure: float
) -> Callable[[float, FloatArray, FloatArray], FloatArray]:
    pressures = pressure_of_each("pressure", gas, engine)
    areas = np.array([cylinder.area for cylinder in engine.cylinders])
    firing = np.radians(engine.firing_deg)
    # Cylinders with the same pressure are asked for together.
    groups: dict[int, tuple[Pressure, list[int]]] = {}
    for place, diagram in enumerate(pressures):
        groups.setdefault(id(diagram), (diagram, []))[1].append(place)

    def forces(angle: float, _places: FloatArray, _directions: FloatArray) -> FloatArray:
        absolute = np.empty(areas.size)
        for pressure, members in groups.values():
            absolute[members] = pressure.at(angle_deg=np.degrees(angle - firing[members]))
        return np.asarray(areas * (absolute - crankcase_pressure))

    return forces


def _from_places(
    engine: EngineLayout, force: PistonForce
) -> Callable[[float, FloatArray, FloatArray], FloatArray]:
    count = len(engine.cylinders)
    lowest, highest = np.array([piston_ends(engine, number + 1) for number in range(count)]).T
    firing, cycle = np.radians(engine.firing_deg), cycle_radians(engine.strokes)

    def forces(angle: float, places: FloatArray, directions: FloatArray) -> FloatArray:
        positions = np.clip((places - lowest) / (highest - lowest), 0.0, 1.0).tolist()
        since_firing = ((angle - firing) % cycle).tolist()
        return np.array(
            [
                force(place + 1, positions[place], 1 if way > 0.0 else -1, since_firing[place])
                for place, way in enumerate(directions.tolist())
            ],
            dtype=np.float64,
        )

    return forces


# Moment that brakes [N m], of speed [rad/s] and shaft angle [rad].
Resistance = Callable[[float, float], float]

# Angles at which a piston's change of direction is looked for over a turn.
SEARCH_ANGLES = 720
# Ends of stroke closer than this are one [rad].
SAME_ANGLE = 1e-9
# An inertia below this share of its mean is none: what is left at a dead center of massless parts.
LEAST_INERTIA = 1e-9


@dataclass(frozen=True, eq=False)
class ShaftMoments:
    """The moments on the shaft.

    Parameters
    ----------
    load, friction : callable
        (speed [rad/s], angle [rad]) -> braking moment [N m].
    gravity : float
        Along -y [m/s^2].
    """

    curves: TurnCurves
    gas: PistonGas
    load: Resistance
    friction: Resistance
    gravity: float

    def at(
        self, angle: float, speed: float, directions: FloatArray | None = None
    ) -> tuple[tuple[float, ...], float, float]:
        """Return the moments of gas, load, friction and gravity; inertia and its derivative.

        Parameters
        ----------
        directions : ndarray of shape (n,), optional
            Of the pistons, positive away from the shaft, if known better than from the
            angle: at the end of a stroke.
        """
        values, slopes = self.curves.at(angle)
        ways = slopes[:-2] if directions is None else directions
        forces = self.gas.forces(angle, values[:-2], ways).tolist()
        # Number by number: arrays would warn of what is not finite before it can be told clearly.
        gas = sum(force * slope for force, slope in zip(forces, slopes[:-2].tolist(), strict=True))
        # An integration tries a speed below zero where the shaft stops; resistances may have no
        # value there, and what they were does not matter.
        forward = max(speed, 0.0)
        moments = (
            -checked_moment("gas", gas, speed, angle, LARGEST),
            -checked_moment("load", self.load(forward, angle), speed, angle, LARGEST),
            -checked_moment("friction", self.friction(forward, angle), speed, angle, LARGEST),
            -self.gravity * float(slopes[-1]),
        )
        return moments, self._checked_inertia(values, angle), float(slopes[-2])

    def inertia(self, angle: float) -> float:
        """Return the reduced inertia [kg m^2]."""
        return self._checked_inertia(self.curves.at(angle)[0], angle)

    def _checked_inertia(self, values: FloatArray, angle: float) -> float:
        return checked_inertia(values[-2], angle, LEAST_INERTIA * float(self.curves.mean[-2]))

    def directions(self, angle: float) -> FloatArray:
        """Return the pistons' directions (n,) at an angle, positive away from the shaft."""
        return np.sign(self.curves.at(angle)[1][:-2])

    def stroke_ends(self) -> FloatArray:
        """Return the shaft angles of one revolution at which a piston changes its direction (k,)."""
        from scipy.optimize import brentq

        # Not at round angles, where strokes end.
        grid = np.linspace(0.0, 2.0 * math.pi, SEARCH_ANGLES + 1) - 0.001
        ways = np.array([self.directions(angle) for angle in grid.tolist()])
        ends = []
        for place, cylinder in np.argwhere(ways[1:] != ways[:-1]).tolist():
            slope = functools.partial(self._slope, cylinder)
            reversal = brentq(slope, grid[place], grid[place + 1], xtol=1e-15)
            ends.append(float(reversal) % (2.0 * math.pi))
        ordered = np.sort(ends)
        return ordered[np.diff(ordered, prepend=-1.0) > SAME_ANGLE]

    def _slope(self, cylinder: int, angle: float) -> float:
        return float(self.curves.at(angle)[1][cylinder])


def shaft_moments(
    engine: EngineLayout,
    gas: Gas,
    load: Resistance | float,
    friction: Resistance | float,
    gravity: float,
    model: RodModelName,
    crankcase_pressure: float,
) -> ShaftMoments:
    """Collect the moments on an engine's shaft; arguments as for `turn_freely`."""
    return ShaftMoments(
        curves=engine_curves(engine, rod_models(engine, model)),
        gas=piston_gas(engine, gas, crankcase_pressure),
        load=_resistance("load", load),
        friction=_resistance("friction", friction),
        gravity=float(finite_array("gravity", gravity)),
    )


def _resistance(field: str, resistance: Resistance | float) -> Resistance:
    if callable(resistance):
        return resistance
    constant = float(finite_array(field, resistance))

    def always(_speed: float, _angle: float) -> float:
        return constant

    return always
