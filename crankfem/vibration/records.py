"""All of an engine's vibration as plain numbers, and the tables made from them."""

from crankfem.record import RPM, Record
from crankfem.results import vibration_record
from crankfem.table import Column, Table
from crankfem.vibration.assessment_records import assessment_record
from crankfem.vibration.forced_records import SPEED, forced_record
from crankfem.vibration.run import EngineVibration
from crankfem.vibration.whole_records import whole_record

# Resultant of the cylinders on a mode shape from which they count as acting together.
TOGETHER = 0.5
FREQUENCY = Column("frequency", "Hz", decimals=2)


def run_record(run: EngineVibration) -> Record:
    """Return modes, forced vibration, verdict and whole crankshaft; null for what was not calculated."""
    forced = (run.forced_axial, run.forced_torsional)
    return {
        **{own.kind: vibration_record(own) for own in (run.axial, run.torsional)},
        "forced": {own.kind: forced_record(own) for own in forced if own is not None} or None,
        "assessment": None if run.assessment is None else assessment_record(run.assessment),
        "whole": None if run.whole is None else whole_record(run.whole, run.comparison),
    }


def mode_table(record: Record) -> Table:
    """Return the natural modes of one kind, from its `vibration_record`."""
    return Table(
        f"{record['kind'].capitalize()} modes (compliances: {record['source']})",
        [
            Column("mode", words=True),
            FREQUENCY,
            Column("[1/min]", decimals=0),
            Column("nodes at", decimals=2, words=True),
        ],
        [
            [
                "rigid body" if one["rigid"] else str(one["number"]),
                one["frequency"],
                60.0 * one["frequency"],
                one["node_positions"],
            ]
            for one in record["modes"]
        ],
        note=f"Nodes count the chain's points: 0 is {record['nodes'][0]}, {len(record['nodes']) - 1} is "
        f"{record['nodes'][-1]}.",
    )


def critical_table(record: Record) -> Table:
    """Return the critical speeds of one kind; marked are those at which the cylinders act together."""
    return Table(
        f"{record['kind'].capitalize()} critical speeds in the running range",
        [
            SPEED,
            Column("order", digits=6),
            Column("mode"),
            FREQUENCY,
            Column("phase sum", decimals=3),
        ],
        [
            [
                one["speed_rpm"] / RPM,
                one["order"],
                one["mode"],
                one["frequency"],
                one["phase_sum"],
            ]
            for one in record["criticals"]
        ],
        marks=[
            ("chosen" if one["phase_sum"] >= TOGETHER else "")
            + ("" if one.get("in_running_range", True) else " above")
            for one in record["criticals"]
        ],
    )


def source_table(record: Record) -> Table:
    """Return the first frequencies of one kind with every source of compliances."""
    return Table(
        f"First {record['kind']} frequencies by source of the compliances",
        [
            Column("source", words=True),
            Column("frequencies", "Hz", decimals=1),
            Column("first beside chosen", decimals=3),
        ],
        [
            [one["source"], one["first_frequencies"], one["beside_chosen"]]
            for one in record["sources"]
        ],
    )
