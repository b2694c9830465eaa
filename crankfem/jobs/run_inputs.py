"""Inputs of a run: the engine file, its tables, and their texts for the report."""

from dataclasses import dataclass
from pathlib import Path

from crankfem.analyses.file_check import refuse_what_cannot_run
from crankfem.analyses.provenance import file_records
from crankfem.analyses.record import Record
from crankfem.analyses.shaft.sources import saved_model, with_model
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.files.engine.file_kinds import engine_sections
from crankfem.files.engine.input_files import engine_inputs
from crankfem.files.engine.mechanism_file import MechanismFile, mechanism_of
from crankfem.files.reading.toml_file import TomlFile
from dynamics.harmonics import TorqueTable, read_torque_table
from regression.models.compliance_model import ComplianceModel
from regression.plans.plan import StudyPlan


@dataclass(frozen=True)
class RunInputs:
    """Inputs of a run.

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
    model : ComplianceModel or None
        The saved one that the file or an option names.
    option : str or None
        Its name, where an option gives it.
    """

    engine_file: EngineFile
    mechanism: MechanismFile
    torque: TorqueTable | None
    paths: tuple[Path, ...]
    files: list[Record]
    model: ComplianceModel | None = None
    option: str | None = None

    @property
    def saved_path(self) -> Path | None:
        """The saved model that is the source regression, if there is one."""
        file = self.engine_file.model_file
        return None if file is None else file.path

    @property
    def study(self) -> StudyPlan | None:
        """The study to run; none beside a saved model, which is used in its place."""
        return self.engine_file.study if self.model is None else None

    @property
    def with_gas(self) -> MechanismFile | None:
        """The mechanism, if its gas pressure is known."""
        return self.mechanism if self.mechanism.pressure else None


def read_inputs(engine: str | Path | TomlFile, model: Path | None = None) -> RunInputs:
    """Read an engine file, or a shipped engine, and the tables that it names.

    Parameters
    ----------
    engine : path
        Or its sections, if already read.
    model : Path, optional
        Saved compliance model to take in place of the file's sources and study.

    Raises
    ------
    InputError
        With one sentence that names the field, what was given and what is allowed.
    """
    content = engine_sections(engine)
    engine_file = load_engine(content if model is None else with_model(content, model))
    refuse_what_cannot_run(engine_file, content)
    mechanism = mechanism_of(engine_file)
    torque, table = None, engine_file.torque_table
    if table is not None:
        torque = read_torque_table(table, strokes=engine_file.engine.strokes)
    read = engine_inputs(engine_file)
    files = file_records(read)
    return RunInputs(
        engine_file,
        mechanism,
        torque,
        tuple(file.path for file in read),
        files,
        saved_model(engine_file),
        None if model is None else files[-1]["name"],
    )
