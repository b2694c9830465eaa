"""A run-up as plain numbers, and the table made from them."""

import numpy as np

from crankfem.output_units import SI, UNBOUNDED, OutputUnits
from crankfem.record import RPM, Record
from crankfem.table import Column, Table
from crankfem.vibration.forced import ForcedVibration
from crankfem.vibration.run_up import RunUp


def run_up_record(found: RunUp, forced: ForcedVibration) -> Record:
    """Return the largest torques beside those at constant speeds, in SI units."""
    motion = found.motion
    return {
        "duration": found.duration,
        "complete": motion.complete,
        "from_rpm": float(motion.shaft_speed[0] * RPM),
        "to_rpm": float(motion.shaft_speed[-1] * RPM),
        "notes": list(motion.notes),
        "elements": [
            {
                "element": name,
                "largest": largest,
                "at_rpm": float(
                    found.envelope.speed[int(np.argmax(found.envelope.torque[:, place]))] * RPM
                ),
                "steady": steady if np.isfinite(steady) else None,
            }
            for place, (name, largest, steady) in enumerate(
                zip(
                    forced.loads.elastic.names,
                    found.largest.tolist(),
                    found.steady.tolist(),
                    strict=True,
                )
            )
        ],
    }


def run_up_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the largest torques of a `run_up_record`."""
    speed = units.of("1/min")
    cut = "" if record["complete"] else ", interrupted"
    return Table(
        f"Run-up from {speed.fixed(record['from_rpm'] / RPM, 0)} to "
        f"{speed.fixed(record['to_rpm'] / RPM, 0)} {speed.name} in {record['duration']:g} s{cut}: "
        "amplitude of the torque in the springs",
        [
            Column("element", words=True),
            Column("largest", "kN m"),
            Column("at", "1/min", decimals=0),
            Column("at constant speeds", "kN m", missing=UNBOUNDED),
        ],
        [
            [one["element"], one["largest"], one["at_rpm"] / RPM, one["steady"]]
            for one in record["elements"]
        ],
    )
