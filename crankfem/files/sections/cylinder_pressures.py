"""The pressure in each cylinder of an engine file: from its table, or from the cycle model."""

import math
from collections.abc import Callable
from typing import ClassVar, Literal, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator

from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.quantity import PER_MINUTE, format_quantity
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.sections.mechanism_sections import Gas
from dynamics.engine import forces
from dynamics.engine.layout import EngineLayout
from dynamics.excitation.pressure_map import LoadPoints
from dynamics.gas.gas_cycle import (
    USUAL_VALUES,
    FullLoad,
    GasCycle,
    GasCycleResult,
    name_fields,
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


def load_points(section: LoadSection) -> LoadPoints | None:
    """Return the points of a section in ascending order of speed; None if it names a law."""
    if not section.points:
        return None
    points = sorted(section.points, key=lambda point: point.speed)
    speeds, mean, above, intake = (
        np.array([getattr(point, name) for point in points], dtype=np.float64)
        for name in ("speed", "mean_effective_pressure", "peak_pressure", "intake_pressure")
    )
    return LoadPoints(
        speeds,
        mean,
        None if points[0].peak_pressure is None else above + ATMOSPHERE,
        None if points[0].intake_pressure is None else intake,
    )
