"""Moments on an engine's shaft at an angle and a speed: gas, load, friction and weight."""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import LARGEST, FloatArray, finite_array
from dynamics.engine.forces import rod_models
from dynamics.engine.layout import EngineLayout
from dynamics.mechanism.rod_model_names import RodModelName
from dynamics.turning.curves import TurnCurves, engine_curves
from dynamics.turning.function_checks import checked_inertia, checked_moment
from dynamics.turning.piston_gas import Gas, PistonGas, piston_gas

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
    curves : TurnCurves
        From `engine_curves`.
    gas : PistonGas
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
        angle : float
            [rad]
        speed : float
            [rad/s]
        directions : ndarray of shape (n,), optional
            Of the pistons, positive away from the shaft, if known better than from the
            angle: at the end of a stroke.

        Raises
        ------
        InputError
            If gas, load or friction are not finite moments, or the inertia vanishes.
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
        """Return the reduced inertia [kg m^2].

        Raises
        ------
        InputError
            If it vanishes.
        """
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
            found = brentq(slope, grid[place], grid[place + 1], xtol=1e-15)
            ends.append(float(found) % (2.0 * math.pi))
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
    """Collect the moments on an engine's shaft; arguments as for `turn_freely`.

    Raises
    ------
    InputError
        If a number is not finite, or pressures do not fit the engine.
    """
    return ShaftMoments(
        curves=engine_curves(engine, rod_models(engine, model)),
        gas=piston_gas(engine, gas, crankcase_pressure),
        load=_resistance("load", load),
        friction=_resistance("friction", friction),
        gravity=float(finite_array("gravity", gravity)),
    )


def _resistance(field: str, given: Resistance | float) -> Resistance:
    if callable(given):
        return given
    constant = float(finite_array(field, given))

    def always(_speed: float, _angle: float) -> float:
        return constant

    return always
