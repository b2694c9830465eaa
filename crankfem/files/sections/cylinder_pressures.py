"""The pressure in each cylinder of an engine file: from its table, or from the cycle model."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from crankbase.errors import InputError
from crankbase.model import InputModel
from crankbase.units.quantity import format_quantity
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.sections.mechanism_sections import Gas
from dynamics.engine.forces import piston_position
from dynamics.engine.layout import EngineLayout
from dynamics.gas.cycle_values import USUAL_VALUES, GasCycle, name_of_field, usual_gas_cycle
from dynamics.gas.cylinder_volume import Position
from dynamics.gas.gas_cycle import GasCycleResult, gas_cycle
from dynamics.gas.pressure import ATMOSPHERE, HIGHEST_PEAK, GasPressure, read_pressure_table

# Peak pressure over that without combustion, usual for diesel engines at rated load: 1.4 to 1.8.
USUAL_PRESSURE_RISE = 1.6

Result = TypeVar("Result")


def cylinder_pressures(
    gas: Gas, layout: EngineLayout, files: InputFiles
) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder over the angle from its firing top.

    Parameters
    ----------
    gas : Gas
        The section of the engine file.
    layout : EngineLayout
    files : InputFiles
        The engine file and those that it may name.

    Raises
    ------
    InputError
        If the table cannot be used, or the cycle cannot reach the given pressures.
    """
    if gas.pressure_table is not None:
        table = files.named("gas.pressure_table", gas.pressure_table, "tables")
        return (read_pressure_table(table, layout.strokes),) * len(layout.cylinders)
    return tuple(one.pressure for one in full_load_cycles(gas, layout))


def full_load_cycles(gas: Gas, layout: EngineLayout) -> tuple[GasCycleResult, ...]:
    """Return the cycle in each cylinder that reaches what a section without a pressure table gives.

    Raises
    ------
    InputError
        If the cycle cannot reach it.
    """
    cycle, remarks = _parameters(gas, layout)

    def fired(position: Position, area: float) -> GasCycleResult:
        found = _cycle_reaching_target(gas, cycle, position, area)
        return replace(found, pressure=_with_remarks(found.pressure, remarks))

    return for_each_cylinder(layout, fired)


def motored_pressures(gas: Gas, layout: EngineLayout) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder of the engine turned without combustion.

    Raises
    ------
    InputError
        If the cycle's values do not fit.
    """
    cycle, remarks = _parameters(gas, layout)

    def motored(position: Position, area: float) -> GasPressure:
        return _with_remarks(gas_cycle(cycle, position, area, heat=0.0).pressure, remarks)

    return for_each_cylinder(layout, motored)


def _with_remarks(pressure: GasPressure, remarks: tuple[str, ...]) -> GasPressure:
    return replace(pressure, remarks=remarks + pressure.remarks)


def assumed_cycle(gas: Gas, layout: EngineLayout) -> GasCycle:
    """Return the parameters of the cycle model that a file's pressure comes from.

    Raises
    ------
    InputError
        If the cycle's values do not fit.
    """
    return _parameters(gas, layout)[0]


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


def for_each_cylinder(
    layout: EngineLayout, calculate: Callable[[Position, float], Result]
) -> tuple[Result, ...]:
    """Calculate something of each cylinder's piston and area, once for all whose pistons move alike."""
    found: dict[object, Result] = {}
    results = []
    for number, cylinder in enumerate(layout.cylinders, start=1):
        main = layout.cylinders[layout.main_of(number) - 1]
        turned = round(math.radians(cylinder.bank_angle_deg - main.bank_angle_deg), 12)
        pin = None if cylinder.slave_pin is None else cylinder.slave_pin.place
        alike = (cylinder.bore, cylinder.rod, cylinder.pin_offset, main.rod, turned, pin)
        if alike not in found:
            found[alike] = calculate(piston_position(layout, number), cylinder.area)
        results.append(found[alike])
    return tuple(results)


def _cycle_reaching_target(
    gas: Gas, cycle: GasCycle, position: Position, area: float
) -> GasCycleResult:
    """Return the cycle that reaches what the file asks for."""
    peak = None if gas.peak_pressure is None else gas.peak_pressure + ATMOSPHERE
    try:
        return gas_cycle(
            cycle,
            position,
            area,
            peak_pressure=peak,
            mean_effective_pressure=gas.mean_effective_pressure,
        )
    except InputError as error:
        text = name_fields(error)
        if gas.peak_pressure is not None and peak is not None and text.startswith("peak"):
            above, absolute = (format_quantity(value, "Pa") for value in (gas.peak_pressure, peak))
            text = text.replace(
                f"given {absolute}; allowed are", f"given {above} above ambient; allowed in all are"
            )
        raise InputError(f"gas.{text}") from None


def _parameters(gas: Gas, layout: EngineLayout) -> tuple[GasCycle, tuple[str, ...]]:
    """Return the cycle's parameters, with an intake pressure that suits the peak if none is given.

    All cylinders breathe from one receiver: the intake is found for the first main cylinder.
    """
    if gas.peak_pressure is not None and gas.peak_pressure + ATMOSPHERE > HIGHEST_PEAK:
        raise InputError(
            f"gas.peak_pressure: given {format_quantity(gas.peak_pressure, 'Pa')} above ambient; allowed is "
            f"{format_quantity(HIGHEST_PEAK, 'Pa')} absolute at most, because no piston engine withstands "
            "more."
        )
    given = given_of_cycle(gas)
    number = layout.main_of(1)
    area = layout.cylinders[number - 1].area
    try:
        cycle = usual_gas_cycle(gas.compression_ratio, layout.strokes, **given)
        if gas.intake_pressure is not None or gas.peak_pressure is None:
            return cycle, ()
        plain = gas_cycle(cycle, piston_position(layout, number), area, heat=0.0)
        rise = (gas.peak_pressure + ATMOSPHERE) / plain.compression_pressure
        intake = cycle.intake_pressure * rise / USUAL_PRESSURE_RISE
        suited = usual_gas_cycle(
            gas.compression_ratio, layout.strokes, **(given | {"intake_pressure": intake})
        )
    except InputError as error:
        raise InputError(f"gas.{name_fields(error)}") from None
    remark = (
        f"Assumed: intake_pressure {format_quantity(intake, 'Pa', 4)}, so that combustion raises the "
        f"pressure {USUAL_PRESSURE_RISE:g} times, as is usual for diesel engines at rated load."
    )
    return suited, (remark,)
