"""An engine in steady running: the load that holds its mean speed, and the speed over a cycle."""

import math

from dynamics.cycle import cycle_radians
from dynamics.engine.layout import EngineLayout
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.mechanism.rod_model_names import RodModelName
from dynamics.turning.piston_gas import Gas
from dynamics.turning.shaft_moments import Resistance, shaft_moments
from dynamics.turning.steady_turning import SteadyTurning, steady_turning


def turn_steadily(
    engine: EngineLayout,
    mean_speed: float,
    *,
    gas: Gas,
    friction: Resistance | float = 0.0,
    gravity: float = 0.0,
    model: RodModelName = "rigid",
    crankcase_pressure: float = ATMOSPHERE,
    samples: int = 720,
) -> SteadyTurning:
    """Find the constant load under which an engine turns steadily, and its speed over a cycle.

    Parameters
    ----------
    mean_speed : float
        Angle of one cycle divided by its time [rad/s].
    engine, gas, friction, gravity, model, crankcase_pressure
        As for `turn_freely`.
    samples : int, optional
        Steps per revolution.

    Returns
    -------
    SteadyTurning
        With the load [N m] and the rotation over one cycle, whose `fluctuation` is the coefficient
        of speed fluctuation, (highest - lowest speed) / mean speed.

    Raises
    ------
    InputError
        As `turn_freely`, and if the engine would stop within the cycle.
    """
    moments = shaft_moments(engine, gas, 0.0, friction, gravity, model, crankcase_pressure)
    return steady_turning(
        moments.inertia,
        lambda speed, angle: math.fsum(moments.at(angle, speed)[0]),
        mean_speed,
        cycle_radians(engine.strokes) / (2.0 * math.pi),
        samples=samples,
    )
