"""The pressure in each cylinder of an engine file: from its table, or from the cycle model."""

import math
from collections.abc import Callable
from typing import TypeVar

from crankbase.errors import InputError
from crankbase.model import InputModel
from crankbase.units.quantity import format_quantity
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.sections.mechanism_sections import Gas
from dynamics.engine import forces
from dynamics.engine.layout import EngineLayout
from dynamics.gas.cycle_values import USUAL_VALUES, GasCycle, name_of_field
from dynamics.gas.gas_cycle import FullLoad, GasCycleResult
from dynamics.gas.pressure import ATMOSPHERE, HIGHEST_PEAK, GasPressure, read_pressure_table

Result = TypeVar("Result")


def cylinder_pressures(
    gas: Gas, layout: EngineLayout, files: InputFiles
) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder over the angle from its firing top.

    Raises
    ------
    InputError
        If the table cannot be used, or the cycle cannot reach the given pressures.
    """
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
    """Calculate from the section's values; errors name its fields and pressures above ambient.

    Raises
    ------
    InputError
        If the cycle's values do not fit, or it cannot reach them.
    """
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
