"""What a run reads: the engine file, its tables, and their texts for the report."""

from dataclasses import dataclass
from pathlib import Path

from crankfem.analyses.engine_refusals import refuse_what_cannot_run
from crankfem.analyses.provenance import file_records
from crankfem.analyses.record import Record
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.files.engine.input_files import engine_tables
from crankfem.files.engine.mechanism_file import MechanismFile, mechanism_of
from dynamics.torque_table import TorqueTable, read_torque_table


@dataclass(frozen=True)
class RunInputs:
    """What a run is made from.

    Attributes
    ----------
    engine_file : EngineFile
    mechanism : MechanismFile
        Of the same file.
    torque : TorqueTable or None
        The table that the file names.
    paths : tuple of Path
        Of all files that were read.
    files : list of dict
        All files that were read, as `file_records` makes them, before anything was computed: what is
        changed on disk while a run computes is not what it was made from.
    """

    engine_file: EngineFile
    mechanism: MechanismFile
    torque: TorqueTable | None
    paths: tuple[Path, ...]
    files: list[Record]

    @property
    def with_gas(self) -> MechanismFile | None:
        """The mechanism, if its gas pressure is known."""
        return self.mechanism if self.mechanism.pressure else None


def read_inputs(engine: str | Path) -> RunInputs:
    """Read an engine file, or a shipped engine, and the tables that it names.

    Raises
    ------
    InputError
        With one sentence that names the field, what was given and what is allowed.
    """
    engine_file = load_engine(engine)
    refuse_what_cannot_run(engine_file)
    mechanism = mechanism_of(engine_file)
    torque, table = None, engine_file.torque_table
    if table is not None:
        torque = read_torque_table(table, strokes=engine_file.engine.strokes)
    tables = engine_tables(engine_file, mechanism)
    paths = (engine_file.path, *tables)
    return RunInputs(engine_file, mechanism, torque, paths, file_records(paths[0], tables))
