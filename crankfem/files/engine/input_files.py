"""The files that a command reads, which nothing may be written over."""

from pathlib import Path

from crankfem.files.engine.mechanism_file import MechanismFile
from crankfem.files.reading.data_files import find_table


def mechanism_inputs(mechanism: MechanismFile) -> tuple[Path, ...]:
    """Return the engine file of a mechanism, and the pressure table that it names, if any."""
    gas = mechanism.gas
    if gas is None or gas.pressure_table is None:
        return (mechanism.path,)
    table = find_table("gas.pressure_table", mechanism.path, gas.pressure_table)
    return (mechanism.path, table)
