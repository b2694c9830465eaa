"""Inputs and computations of a run, before anything is written."""

from dataclasses import dataclass
from pathlib import Path

from crankfem.analyses.engine_mechanism import engine_inputs, warned_inputs
from crankfem.analyses.file_check import refuse_what_cannot_run
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.provenance import UsedFile, used_files
from crankfem.analyses.shaft.sources import saved_model, with_model
from crankfem.analyses.strength.cycle_fatigue import EngineFatigue
from crankfem.analyses.strength.engine_strength import EngineStrength
from crankfem.analyses.study.studies import StudyResult
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.files.engine.file_kinds import engine_sections
from crankfem.files.reading.toml_file import InputWarning, TomlFile
from dynamics.harmonics import Harmonics, TorqueTable, read_torque_table
from fem.analysis import ThrowAnalysis
from fem.fillet_peaks import FilletStresses
from regression.models.compliance_model import ComplianceModel
from regression.plans.plan import StudyPlan


@dataclass(frozen=True)
class RunInputs:
    """Inputs of a run.

    Attributes
    ----------
    warnings : tuple of InputWarning
        Of what is far outside of practice.
    torque : TorqueTable or None
        The table that the file names.
    paths : tuple of Path
        Of all files that were read.
    files : tuple of UsedFile
        All files that were read, before anything was computed: what is
        changed on disk while a run computes is not what it was made from.
    model : ComplianceModel or None
        The saved one that the file or an option names.
    option : str or None
        Its name, where an option gives it.
    """

    engine_file: EngineFile
    warnings: tuple[InputWarning, ...]
    torque: TorqueTable | None
    paths: tuple[Path, ...]
    files: tuple[UsedFile, ...]
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


def read_inputs(engine: str | Path | TomlFile, model: Path | None = None) -> RunInputs:
    """Read an engine file, or a shipped engine, and the tables that it names.

    Parameters
    ----------
    engine : path
        Or its sections, if already read.
    model : Path, optional
        Saved compliance model to take in place of the file's sources and study.
    """
    content = engine_sections(engine)
    engine_file = load_engine(content if model is None else with_model(content, model))
    refuse_what_cannot_run(engine_file, content)
    torque, table = None, engine_file.torque_table
    if table is not None:
        torque = read_torque_table(table, strokes=engine_file.engine.strokes)
    read = engine_inputs(engine_file)
    files = used_files(read)
    return RunInputs(
        engine_file,
        warned_inputs(engine_file),
        torque,
        tuple(file.path for file in read),
        files,
        saved_model(engine_file),
        None if model is None else files[-1].name,
    )


@dataclass(frozen=True)
class ThrowComputation:
    """Results of one throw.

    Attributes
    ----------
    stresses : FilletStresses or None
        At its fillets.
    fillet_note : str or None
        Why there are none.
    """

    analysis: ThrowAnalysis
    stresses: FilletStresses | None
    fillet_note: str | None


@dataclass(frozen=True)
class RunComputation:
    """Results of a run.

    Attributes
    ----------
    throws : dict of str to ThrowComputation
        Of each distinct throw by its name, first that at the free end; "throw" is that of a file with one.
    mechanism : MechanismRun or None
        None without gas pressure.
    study : StudyResult or None
        None if the engine file has none.
    harmonics : Harmonics or None
        Of the torque table.
    model : ComplianceModel or None
        Of the study, or the saved one.
    strength : EngineStrength or None
        None without a section [strength].
    fatigue : EngineFatigue or None
        Over the cycle; None without that section.
    fatigue_note : str or None
        Why there is none, with the section.
    """

    inputs: RunInputs
    throws: dict[str, ThrowComputation]
    mechanism: MechanismRun | None
    study: StudyResult | None
    vibration: EngineVibration
    harmonics: Harmonics | None
    model: ComplianceModel | None
    strength: EngineStrength | None = None
    fatigue: EngineFatigue | None = None
    fatigue_note: str | None = None

    @property
    def throw(self) -> ThrowComputation:
        """Results of the throw; of several, of the one at the free end."""
        return next(iter(self.throws.values()))

    @property
    def crank_analyses(self) -> tuple[ThrowAnalysis, ...]:
        """Finite elements of each crank's throw, from the free end."""
        return tuple(self.throws[name].analysis for name in self.engine_file.throw_names)

    @property
    def engine_file(self) -> EngineFile:
        """The engine file that was read."""
        return self.inputs.engine_file

    @property
    def torque(self) -> TorqueTable | None:
        """The torque table that was read."""
        return self.inputs.torque
