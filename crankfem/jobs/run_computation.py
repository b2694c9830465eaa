"""All that a run computes, before anything of it is written."""

from dataclasses import dataclass

from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.study.studies import StudyResult
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.jobs.run_inputs import RunInputs
from dynamics.harmonics import Harmonics
from dynamics.torque_table import TorqueTable
from fem.fillet_peaks import FilletStresses
from fem.throw_analysis import ThrowAnalysis


@dataclass(frozen=True)
class RunComputation:
    """What a run has computed.

    Attributes
    ----------
    inputs : RunInputs
    analysis : ThrowAnalysis
    stresses : FilletStresses or None
        At the throw's fillets.
    fillet_note : str or None
        Why there are none.
    mechanism : MechanismRun or None
        None without gas pressure.
    study : StudyResult or None
        None if the engine file has none.
    vibration : EngineVibration
    harmonics : Harmonics or None
        Of the torque table.
    """

    inputs: RunInputs
    analysis: ThrowAnalysis
    stresses: FilletStresses | None
    fillet_note: str | None
    mechanism: MechanismRun | None
    study: StudyResult | None
    vibration: EngineVibration
    harmonics: Harmonics | None

    @property
    def engine_file(self) -> EngineFile:
        """The engine file that was read."""
        return self.inputs.engine_file

    @property
    def torque(self) -> TorqueTable | None:
        """The torque table that was read."""
        return self.inputs.torque
