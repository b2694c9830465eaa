"""All of an engine's vibration as plain numbers."""

from crankfem.analyses.record import Record
from crankfem.analyses.shaft.whole_records import whole_record
from crankfem.analyses.vibration.assessment_records import assessment_record
from crankfem.analyses.vibration.forced_records import forced_record
from crankfem.analyses.vibration.modes_record import vibration_record
from crankfem.analyses.vibration.run import EngineVibration


def run_record(run: EngineVibration) -> Record:
    """Return modes, forced vibration, verdict and whole crankshaft; null for what was not calculated."""
    forced = (run.forced_axial, run.forced_torsional)
    return {
        **{own.kind: vibration_record(own) for own in (run.axial, run.torsional)},
        "forced": {own.kind: forced_record(own) for own in forced if own is not None} or None,
        "assessment": None if run.assessment is None else assessment_record(run.assessment),
        "whole": None if run.whole is None else whole_record(run.whole, run.comparison),
    }
