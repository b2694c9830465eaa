"""The input files of a command, which must not be overwritten."""

from pathlib import Path

from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import MechanismFile
from crankfem.files.reading.data_files import find_table


def mechanism_inputs(mechanism: MechanismFile) -> tuple[Path, ...]:
    """Return the engine file of a mechanism, and the pressure table that it names, if any."""
    gas = mechanism.gas
    if gas is None or gas.pressure_table is None:
        return (mechanism.path,)
    table = find_table("gas.pressure_table", mechanism.path, gas.pressure_table)
    return (mechanism.path, table)


def engine_tables(engine_file: EngineFile, mechanism: MechanismFile) -> tuple[Path, ...]:
    """Return the files that an engine file names: of pressures, at points of a map, of torque, its model."""
    points = () if engine_file.gas_map is None else engine_file.gas_map.points
    on_map = [
        find_table("gas_map.points.pressure_table", engine_file.path, point.pressure_table)
        for point in points
    ]
    torque = () if engine_file.torque_table is None else (engine_file.torque_table,)
    model = () if engine_file.model_path is None else (engine_file.model_path,)
    return (*mechanism_inputs(mechanism)[1:], *on_map, *torque, *model)
