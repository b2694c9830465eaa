"""The load of an engine over its speed: constant, by the propeller law, or given."""

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_array, nonnegative_number, positive_number
from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankbase.units.units import RPM

# A number, one for each speed, or a function of the speeds [rad/s].
Load = float | ArrayLike | Callable[[FloatArray], ArrayLike]
# What a load is a measure of, and how it goes with the speed of a propeller.
PROPELLER_EXPONENTS = {"torque": 2.0, "power": 3.0}


def propeller_load(
    rated_speed: float, rated_load: float = 1.0, *, measure: Literal["torque", "power"] = "torque"
) -> Callable[[FloatArray], FloatArray]:
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

    def load(speeds: FloatArray) -> FloatArray:
        return np.asarray(most * (speeds / rated) ** exponent, dtype=np.float64)

    return load


def load_at(load: Load, speeds: FloatArray) -> FloatArray:
    """Return the load at each speed (S,).

    Raises
    ------
    InputError
        If there is not one finite number for all speeds, or one for each.
    """
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
