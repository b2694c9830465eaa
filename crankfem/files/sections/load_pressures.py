"""The pressure in each cylinder over the speed, along the load that an engine file gives."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from crankbase.units.quantity import format_quantity
from crankfem.files.sections.cylinder_pressures import full_load_cycles, name_fields
from crankfem.files.sections.load_section import LoadSection
from crankfem.files.sections.mechanism_sections import Gas
from dynamics.engine.forces import piston_position
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.pressure_map import (
    SAME,
    PressureMap,
    pressure_map_from_cycles,
    sorted_unique,
)
from dynamics.gas.cycle_values import LEAST_EXHAUST
from dynamics.gas.gas_cycle import GasCycleResult
from dynamics.gas.pressure import ATMOSPHERE

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

    speeds: FloatArray
    mean_pressure: FloatArray
    intake_pressure: FloatArray
    exhaust_pressure: FloatArray
    peak_pressure: FloatArray | None


def load_curve(
    section: LoadSection,
    full: GasCycleResult,
    rated_speed: float,
    speeds: FloatArray,
    friction_pressure: float = 0.0,
) -> LoadCurve:
    """Return the results of the cycle at speeds.

    Parameters
    ----------
    section : LoadSection
        With points, or the law of a propeller.
    full : GasCycleResult
        Cycle of the first cylinder at full load and rated speed.
    rated_speed : float
        [rad/s]
    speeds : (S,) array
        Ascending, within the points if there are any [rad/s].
    friction_pressure : float, optional
        Mean pressure that friction takes at any speed [Pa]: the propeller takes the rest.

    Raises
    ------
    InputError
        If a speed lies beyond the points.

    Notes
    -----
    The mean effective pressure of a propeller is proportional to the square of the speed, its power to
    the cube; both continue above rated speed. The boost is proportional to the power, because the exhaust
    drives the turbocharger. Curves between points are smooth and pass no point above or below its
    neighbors.
    """
    known = np.array([point.speed for point in section.points])
    points = [section.points[place] for place in np.argsort(known)]
    known = np.sort(known)
    if points:
        _check_within(speeds, known)
        mean = _between(speeds, known, [point.mean_effective_pressure for point in points])
        share = mean / full.mean_effective_pressure
    else:
        friction = friction_pressure / full.mean_effective_pressure
        share = friction + (1.0 - friction) * (speeds / rated_speed) ** 2
    boost, peak = share * speeds / rated_speed, None
    taken_in = _boosted(full.cycle.intake_pressure, ATMOSPHERE, boost)
    above = [point.peak_pressure for point in points if point.peak_pressure is not None]
    if above:
        peak = _between(speeds, known, above) + ATMOSPHERE
    intake = [point.intake_pressure for point in points if point.intake_pressure is not None]
    if intake:
        taken_in = _between(speeds, known, intake)
        at_full = max(full.cycle.intake_pressure - ATMOSPHERE, 0.0)
        boost = np.maximum(taken_in - ATMOSPHERE, 0.0) / at_full if at_full else boost
    exhaust = _boosted(full.cycle.exhaust_pressure, LEAST_EXHAUST, boost)
    return LoadCurve(speeds, share, taken_in, exhaust, peak)


def pressures_along(
    curve: LoadCurve, gas: Gas, layout: EngineLayout, *, motored: bool = False
) -> tuple[PressureMap, ...]:
    """Return the pressure in each cylinder over the speeds of a curve, equal cylinders with one map.

    Parameters
    ----------
    curve : LoadCurve
    gas : Gas
        Full load.
    layout : EngineLayout
    motored : bool, optional
        Without combustion, at the same boost.

    Raises
    ------
    InputError
        If the cycle cannot reach a point.
    """
    made: dict[int, PressureMap] = {}
    maps = []
    for number, full in enumerate(full_load_cycles(gas, layout), start=1):
        if id(full) not in made:
            made[id(full)] = _map_along(curve, full, layout, number, motored)
        maps.append(made[id(full)])
    return tuple(maps)


def _map_along(
    curve: LoadCurve, full: GasCycleResult, layout: EngineLayout, number: int, motored: bool
) -> PressureMap:
    # What was assumed is told of full load.
    cycle = replace(full.cycle, assumed=())
    area, column = layout.cylinders[number - 1].area, np.s_[:, np.newaxis]
    try:
        return pressure_map_from_cycles(
            cycle,
            piston_position(layout, number),
            area,
            curve.speeds,
            [1.0],
            heat=0.0 if motored else None,
            mean_effective_pressure=(
                None if motored else (curve.mean_pressure * full.mean_effective_pressure)[column]
            ),
            peak_pressure=(
                None if motored or curve.peak_pressure is None else curve.peak_pressure[column]
            ),
            intake_pressure=curve.intake_pressure[column],
            exhaust_pressure=curve.exhaust_pressure[column],
            method="cubic",
        )
    except InputError as error:
        raise InputError(f"load: {name_fields(error)}") from None


def _boosted(at_full: float, ambient: float, boost: FloatArray) -> FloatArray:
    """Return a pressure whose part above ambient is multiplied by the boost [Pa]."""
    if at_full <= ambient:
        return np.full(boost.shape, at_full)
    return np.asarray(ambient + (at_full - ambient) * boost)


def _between(speeds: FloatArray, known: FloatArray, values: Sequence[float]) -> FloatArray:
    """Interpolate smoothly, without overshoot."""
    from scipy.interpolate import PchipInterpolator  # here: loading it takes a quarter second

    within = np.clip(speeds, known[0], known[-1])  # by round-off only
    return np.asarray(PchipInterpolator(known, values)(within), dtype=np.float64)


def _check_within(speeds: FloatArray, known: FloatArray) -> None:
    outside = (speeds < known[0] * (1.0 - SAME)) | (speeds > known[-1] * (1.0 + SAME))
    if np.any(outside):
        given, low, high = (
            format_quantity(float(speed), "rad/s", 5)
            for speed in (speeds[outside][0], known[0], known[-1])
        )
        raise InputError(
            f"load.points: given none for {given}; allowed are speeds from {low} to {high}, because nothing "
            "is extrapolated beyond the points."
        )


def load_speeds(
    section: LoadSection, rated_speed: float, speed_range: tuple[float, float]
) -> FloatArray:
    """Return speeds close enough for splines between their diagrams [rad/s].

    Parameters
    ----------
    section : LoadSection
    rated_speed : float
        [rad/s]
    speed_range : tuple of two floats
        Of the law of a propeller; points reach as far as they are given [rad/s].
    """
    further = [point.speed for point in section.points] or [rated_speed]
    low, high = (min(further), max(further)) if section.points else speed_range
    count = 1 + math.ceil(math.log(high / low) / math.log1p(SPACING))
    return sorted_unique([*np.geomspace(low, high, max(count, 2)).tolist(), *further])
