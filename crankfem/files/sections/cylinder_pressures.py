"""The pressure in each cylinder of an engine file: from its table, or from the cycle model."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator

from crankbase.array_checks import FloatArray
from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.quantity import PER_MINUTE, format_quantity
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.sections.mechanism_sections import Gas
from dynamics.engine import forces
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.pressure_map import (
    SAME,
    PressureMap,
    pressure_map_from_cycles,
    sorted_unique,
)
from dynamics.gas.gas_cycle import (
    LEAST_EXHAUST,
    USUAL_VALUES,
    FullLoad,
    GasCycle,
    GasCycleResult,
    name_of_field,
)
from dynamics.gas.pressure import ATMOSPHERE, HIGHEST_PEAK, GasPressure, read_pressure_table

Result = TypeVar("Result")


def cylinder_pressures(
    gas: Gas, layout: EngineLayout, files: InputFiles
) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder over the angle from its firing top."""
    if gas.pressure_table is not None:
        table = files.named("gas.pressure_table", gas.pressure_table, "tables")
        return (read_pressure_table(table, layout.strokes),) * len(layout.cylinders)
    return tuple(cycle.pressure for cycle in full_load_cycles(gas, layout))


def full_load_cycles(gas: Gas, layout: EngineLayout) -> tuple[GasCycleResult, ...]:
    """Return the cycle in each cylinder that reaches what a section without a pressure table gives."""
    return _of_section(gas, layout, forces.full_load_cycles)


def motored_pressures(gas: Gas, layout: EngineLayout) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder of the engine turned without combustion."""
    return _of_section(gas, layout, forces.motored_pressures)


def assumed_cycle(gas: Gas, layout: EngineLayout) -> GasCycle:
    """Return the parameters of the cycle model that a file's pressure comes from."""
    return _of_section(gas, layout, forces.full_load_parameters)[0]


def given_of_cycle(section: InputModel) -> dict[str, float]:
    """Return what a section gives of the cycle's parameters, angles in degrees."""
    fields = {name: getattr(section, name_of_field(name), None) for name in USUAL_VALUES}
    return {
        name: math.degrees(value) if name.endswith("_deg") else value
        for name, value in fields.items()
        if value is not None
    }


def name_fields(error: InputError) -> str:
    """Return the text of an error of the cycle model with the names that the fields of files have."""
    return str(error).replace("_deg", "")


def _of_section(
    gas: Gas, layout: EngineLayout, calculate: Callable[[FullLoad, EngineLayout], Result]
) -> Result:
    """Calculate from the section's values; errors name its fields and pressures above ambient."""
    peak = None if gas.peak_pressure is None else gas.peak_pressure + ATMOSPHERE
    above = "" if gas.peak_pressure is None else format_quantity(gas.peak_pressure, "Pa")
    if peak is not None and peak > HIGHEST_PEAK:
        raise InputError(
            f"gas.peak_pressure: given {above} above ambient; allowed is "
            f"{format_quantity(HIGHEST_PEAK, 'Pa')} absolute at most, because no piston engine withstands "
            "more."
        )
    load = FullLoad(gas.compression_ratio, given_of_cycle(gas), peak, gas.mean_effective_pressure)
    try:
        return calculate(load, layout)
    except InputError as error:
        text = name_fields(error)
        if peak is not None and text.startswith("peak"):
            absolute = format_quantity(peak, "Pa")
            text = text.replace(
                f"given {absolute}; allowed are", f"given {above} above ambient; allowed in all are"
            )
        raise InputError(f"gas.{text}") from None


class LoadPoint(InputModel):
    """Load of the cylinders at one speed."""

    section: ClassVar[str] = "load.points"

    speed: float = quantity_field(
        "speed of the crankshaft", "rad/s", 1.0 * PER_MINUTE, 30_000.0 * PER_MINUTE
    )
    mean_effective_pressure: float = quantity_field(
        "indicated mean effective pressure at that speed", "Pa", 1e3, 1e7
    )
    peak_pressure: float | None = quantity_field(
        "largest gas pressure above ambient at that speed; by default from the combustion of [gas]",
        "Pa",
        1e4,
        1e8,
        default=None,
    )
    intake_pressure: float | None = quantity_field(
        "absolute pressure in the cylinder at the end of the intake at that speed; by default boost is "
        "proportional to the power",
        "Pa",
        1e4,
        2e6,
        default=None,
    )


class LoadSection(InputModel):
    """Load over the speed, besides full load as in [gas]; full load at all speeds without it."""

    section: ClassVar[str] = "load"

    law: Literal["propeller", "constant"] | None = Field(
        None,
        description="full load at all speeds, or that of a propeller, whose power is proportional to the "
        "cube of the speed; none if points are given",
    )
    points: tuple[LoadPoint, ...] = part_field(
        "load of the cylinders at several speeds, in place of a law", LoadPoint, many=True
    )

    @model_validator(mode="after")
    def _says_one_thing(self) -> Self:
        if (self.law is None) == (not self.points):
            what = "neither it nor points" if self.law is None else "both it and points"
            raise InputError(
                f"load.law: given {what}; allowed is one of the two, because each defines the load at all "
                "speeds."
            )
        speeds = [point.speed for point in self.points]
        if len(speeds) == 1 or len(set(speeds)) < len(speeds):
            raise InputError(
                f"load.points: given {len(speeds)} of {len(set(speeds))} different speeds; allowed are two "
                "or more, each speed once, because the load between them is interpolated."
            )
        for name in ("peak_pressure", "intake_pressure"):
            known = sum(getattr(point, name) is not None for point in self.points)
            if known not in (0, len(speeds)):
                raise InputError(
                    f"load.points: given {name} at {known} of {len(speeds)} speeds; allowed is all of them "
                    "or none, because it is interpolated between them."
                )
        return self


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
    gas : Gas
        Full load.
    motored : bool, optional
        Without combustion, at the same boost.
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
            forces.piston_position(layout, number),
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
        outer, low, high = (
            format_quantity(float(speed), "rad/s", 5)
            for speed in (speeds[outside][0], known[0], known[-1])
        )
        raise InputError(
            f"load.points: given none for {outer}; allowed are speeds from {low} to {high}, because nothing "
            "is extrapolated beyond the points."
        )


def load_speeds(
    section: LoadSection, rated_speed: float, speed_range: tuple[float, float]
) -> FloatArray:
    """Return speeds close enough for splines between their diagrams [rad/s].

    Parameters
    ----------
    rated_speed : float
        [rad/s]
    speed_range : tuple of two floats
        Of the law of a propeller; points reach as far as they are given [rad/s].
    """
    further = [point.speed for point in section.points] or [rated_speed]
    low, high = (min(further), max(further)) if section.points else speed_range
    count = 1 + math.ceil(math.log(high / low) / math.log1p(SPACING))
    return sorted_unique([*np.geomspace(low, high, max(count, 2)).tolist(), *further])
