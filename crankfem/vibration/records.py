"""All of an engine's vibration as plain numbers, and the tables that the command line prints."""

from typing import Any

from crankfem import tables
from crankfem.console import print_line
from crankfem.output_units import SI, OutputUnits
from crankfem.record import Record
from crankfem.results import vibration_record
from crankfem.vibration.assessment_records import assessment_record, print_assessment
from crankfem.vibration.forced_records import forced_record, print_forced
from crankfem.vibration.run import EngineVibration
from crankfem.vibration.whole_records import print_whole, whole_record

NOT_FORCED = (
    "Amplitudes are not calculated, because the engine file gives no gas pressure: add [gas]."
)


def run_record(run: EngineVibration) -> Record:
    """Return modes, forced vibration, verdict and whole crankshaft; null for what was not calculated."""
    forced = (run.forced_axial, run.forced_torsional)
    return {
        **{own.kind: vibration_record(own) for own in (run.axial, run.torsional)},
        "forced": {own.kind: forced_record(own) for own in forced if own is not None} or None,
        "assessment": None if run.assessment is None else assessment_record(run.assessment),
        "whole": None if run.whole is None else whole_record(run.whole, run.comparison),
    }


def print_run(record: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print everything, the verdict last."""
    for kind in ("axial", "torsional"):
        tables.print_vibration(record[kind], forced=record["forced"] is not None, units=units)
        if record["forced"] is not None:
            print_forced(record["forced"][kind], units)
    if record["whole"] is not None:
        print_whole(record["whole"], units)
    if record["assessment"] is None:
        print_line(NOT_FORCED)
    else:
        print_assessment(record["assessment"], units)
