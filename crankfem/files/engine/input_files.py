"""The input files of a command, which must not be overwritten."""

from collections.abc import Iterator
from pathlib import Path

from crankbase.input_file import InputFile
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import MechanismFile


def mechanism_inputs(mechanism: EngineFile | MechanismFile) -> tuple[Path, ...]:
    """Return the engine file of a mechanism, and the pressure table that it names, if any."""
    return tuple(file.path for file in _mechanism_files(mechanism))


def engine_inputs(engine_file: EngineFile) -> tuple[InputFile, ...]:
    """Return an engine file and those it names: of pressures, at points of a map, of torque, its model."""
    points = () if engine_file.gas_map is None else engine_file.gas_map.points
    on_map = [
        engine_file.files.named("gas_map.points.pressure_table", point.pressure_table, "tables")
        for point in points
    ]
    others = (engine_file.torque_table, engine_file.model_file)
    named = (*_mechanism_files(engine_file), *on_map, *(file for file in others if file))
    return tuple(dict.fromkeys(named))


def _mechanism_files(mechanism: EngineFile | MechanismFile) -> Iterator[InputFile]:
    yield mechanism.files.own
    gas = mechanism.gas
    if gas is not None and gas.pressure_table is not None:
        yield mechanism.files.named("gas.pressure_table", gas.pressure_table, "tables")
