"""Computations of a run, before anything is written."""

from dataclasses import dataclass

from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.strength.cycle_fatigue import EngineFatigue
from crankfem.analyses.strength.engine_strength import EngineStrength
from crankfem.analyses.study.studies import StudyResult
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.jobs.run_inputs import RunInputs
from dynamics.harmonics import Harmonics, TorqueTable
from fem.fillet_peaks import FilletStresses
from fem.throw_analysis import ThrowAnalysis
from regression.models.compliance_model import ComplianceModel


@dataclass(frozen=True)
class ThrowComputation:
    """Results of one throw.

    Attributes
    ----------
    analysis : ThrowAnalysis
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
    inputs : RunInputs
    throws : dict of str to ThrowComputation
        Of each distinct throw by its name, first that at the free end; "throw" is that of a file with one.
    mechanism : MechanismRun or None
        None without gas pressure.
    study : StudyResult or None
        None if the engine file has none.
    vibration : EngineVibration
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
