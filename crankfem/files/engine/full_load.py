"""Gas pressure in an engine's cylinders at full load, from its section [gas]."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from crankbase.errors import InputError
from crankbase.sentences import amount
from crankfem.files.reading.data_files import InputFiles
from crankfem.files.sections.engine_sections import Engine
from crankfem.files.sections.mechanism_sections import Gas, given_of_cycle
from dynamics.engine.forces import full_load_cycles, motored_pressures, piston_position
from dynamics.engine.layout import EngineLayout
from dynamics.gas.gas_cycle import FullLoad, PeakError, name_fields
from dynamics.gas.pressure import (
    ATMOSPHERE,
    HIGHEST_PEAK,
    GasPressure,
    cylinder_volume,
    motored_from_compression,
    read_pressure_table,
)

Calculated = TypeVar("Calculated")


def full_load_pressure(
    engine: Engine, gas: Gas, layout: EngineLayout, files: InputFiles
) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder: of the table that the section names, or of a cycle.

    Raises
    ------
    InputError
        If the table cannot be read, or no cycle reaches the pressures.
    """
    if gas.pressure_table is not None:
        table = replace(
            files.named("gas.pressure_table", gas.pressure_table, "tables"), reading=gas.reading
        )
        diagram = read_pressure_table(table, layout.strokes, fires=not engine.driven_by)
        return (diagram,) * len(layout.cylinders)
    if (cycle := gas.compressor) is not None:
        return tuple(
            cycle.pressure(piston_position(layout, number), cylinder.area)
            for number, cylinder in enumerate(layout.cylinders, start=1)
        )
    return tuple(result.pressure for result in by_gas(gas, layout, full_load_cycles))


def by_gas(
    gas: Gas, layout: EngineLayout, calculate: Callable[[FullLoad, EngineLayout], Calculated]
) -> Calculated:
    """Calculate cycles from the section [gas]; errors name its fields, with pressures above ambient."""
    peak = None if gas.peak_pressure is None else gas.peak_pressure + ATMOSPHERE
    above = "" if gas.peak_pressure is None else amount(gas.peak_pressure, "Pa")
    if peak is not None and peak > HIGHEST_PEAK:
        raise InputError(
            f"gas.peak_pressure: given {above} above ambient; allowed is "
            f"{amount(HIGHEST_PEAK, 'Pa')} absolute at most, because no piston engine withstands "
            "more."
        )
    load = FullLoad(gas.compression_ratio, given_of_cycle(gas), peak, gas.mean_effective_pressure)
    try:
        return calculate(load, layout)
    except PeakError as error:
        raise InputError(
            f"gas.peak_pressure: given {above} above ambient; allowed in all are "
            f"{name_fields(error.allowed)}"
        ) from None
    except InputError as error:
        raise InputError(f"gas.{name_fields(error)}") from None


def motored_for_misfire(
    gas: Gas, layout: EngineLayout, pressure: Sequence[GasPressure]
) -> tuple[GasPressure, ...]:
    """Return the pressure in each cylinder without combustion.

    Parameters
    ----------
    gas : Gas
        The section of the engine file.
    pressure : sequence of n GasPressure
        Of the firing cylinders.

    Returns
    -------
    tuple of n GasPressure
        Of the cycle model without heat, or from the compression of the pressure table with the
        section's compression ratio.
    """
    if gas.pressure_table is None:
        return by_gas(gas, layout, motored_pressures)
    return tuple(
        motored_from_compression(
            firing,
            cylinder_volume(piston_position(layout, number), cylinder.area, gas.compression_ratio),
        )
        for number, (firing, cylinder) in enumerate(
            zip(pressure, layout.cylinders, strict=True), start=1
        )
    )
