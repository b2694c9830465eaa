"""A pressure map calculated by the cycle model, from peak or mean pressure at points."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_array, finite_vector
from crankbase.errors import InputError
from dynamics.excitation.engine_load import per_minute
from dynamics.excitation.grid_weights import Method
from dynamics.excitation.pressure_map import PressureMap, pressure_map
from dynamics.gas.cycle_values import GasCycle
from dynamics.gas.cylinder_volume import Position
from dynamics.gas.gas_cycle import Solved, gas_cycle

# What a cycle has of its own, and its solution is not told.
OF_CYCLE = ("intake_pressure", "exhaust_pressure")


def pressure_map_from_cycles(
    cycle: GasCycle,
    position: Position,
    area: float,
    speeds: ArrayLike,
    loads: ArrayLike,
    *,
    heat: ArrayLike | None = None,
    peak_pressure: ArrayLike | None = None,
    mean_effective_pressure: ArrayLike | None = None,
    intake_pressure: ArrayLike | None = None,
    exhaust_pressure: ArrayLike | None = None,
    solve_for: Solved = "combustion_start_deg",
    samples: int | None = None,
    method: Method = "cubic",
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
    loads : array_like of shape (b,)
        In any measure.
    heat : array_like of shape (a, b), optional
        Heat released in one cycle at each point [J], instead of the pressures below; 0 is a motored
        engine.
    peak_pressure, mean_effective_pressure : array_like of shape (a, b), optional
        Highest absolute pressure, and indicated mean effective pressure [Pa] at each point; one of
        them or both. Shapes that broadcast to (a, b) are allowed.
    intake_pressure, exhaust_pressure : array_like of shape (a, b), optional
        Absolute pressure at the end of the intake and during exhaust [Pa]; by default those of the
        cycle. With a turbocharger both rise together.
    method : {"cubic", "linear"}, optional
        Interpolation between the points.

    Returns
    -------
    PressureMap

    Raises
    ------
    InputError
        If a shape does not fit, or a cycle cannot reach its point (the message names it).
    """
    running, loaded = finite_vector("speeds", speeds), finite_vector("loads", loads)
    shape = (running.size, loaded.size)
    given = {
        "heat": heat,
        "peak_pressure": peak_pressure,
        "mean_effective_pressure": mean_effective_pressure,
        "intake_pressure": intake_pressure,
        "exhaust_pressure": exhaust_pressure,
    }
    known = {
        name: _at_points(name, values, shape)
        for name, values in given.items()
        if values is not None
    }
    points = []
    for place in np.ndindex(*shape):
        speed, load = float(running[place[0]]), float(loaded[place[1]])
        wanted = {name: float(values[place]) for name, values in known.items()}
        own: dict[str, Any] = {name: wanted.pop(name) for name in OF_CYCLE if name in wanted}
        try:
            found = gas_cycle(
                replace(cycle, **own),
                position,
                area,
                **wanted,
                solve_for=solve_for,
                samples=samples,
            )
        except InputError as error:
            raise InputError(f"at {per_minute(speed)} and load {load:g}: {error}") from None
        # What was solved at each point would make a remark of its own for every one.
        kept = tuple(text for text in found.pressure.remarks if not text.startswith("Solved"))
        points.append((speed, load, replace(found.pressure, remarks=kept)))
    return pressure_map(points, method=method)


def _at_points(field: str, values: ArrayLike, shape: tuple[int, int]) -> FloatArray:
    given = finite_array(field, values)
    try:
        return np.asarray(np.broadcast_to(given, shape))
    except ValueError:
        raise InputError(
            f"{field}: given an array of shape {given.shape}; allowed is {shape}, because there is one for "
            "each speed and load."
        ) from None
