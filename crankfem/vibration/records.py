"""All of an engine's vibration as plain numbers."""

from crankfem.record import Record
from crankfem.results import vibration_record
from crankfem.vibration.assessment_records import assessment_record
from crankfem.vibration.forced_records import forced_record
from crankfem.vibration.run import EngineVibration
from crankfem.vibration.whole_records import whole_record


def run_record(run: EngineVibration) -> Record:
    """Return modes, forced vibration, verdict and whole crankshaft; null for what was not calculated."""
    forced = (run.forced_axial, run.forced_torsional)
    return {
        **{own.kind: vibration_record(own) for own in (run.axial, run.torsional)},
        "forced": {own.kind: forced_record(own) for own in forced if own is not None} or None,
        "assessment": None if run.assessment is None else assessment_record(run.assessment),
        "whole": None if run.whole is None else whole_record(run.whole, run.comparison),
    }
