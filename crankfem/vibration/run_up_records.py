"""A run-up as plain numbers, and the table made from them."""

import numpy as np

from crankfem.console import print_line, print_table
from crankfem.output_units import SI, OutputUnits
from crankfem.record import Record
from crankfem.vibration.forced import ForcedVibration
from crankfem.vibration.run_up import RunUp
from geometry.units import RPM


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


def print_run_up(record: Record, units: OutputUnits = SI) -> None:
    """Print the largest torques of a run-up."""
    torque, speed = units.of("kN m"), units.of("1/min")
    cut = "" if record["complete"] else ", interrupted"
    print_table(
        f"Run-up from {speed.fixed(record['from_rpm'] / RPM, 0)} to "
        f"{speed.fixed(record['to_rpm'] / RPM, 0)} {speed.name} in {record['duration']:g} s{cut}: "
        "amplitude of the torque in the springs",
        [
            "element",
            f"largest [{torque.name}]",
            f"at [{speed.name}]",
            f"at constant speeds [{torque.name}]",
        ],
        [
            [
                one["element"],
                torque.number(one["largest"]),
                speed.fixed(one["at_rpm"] / RPM, 0),
                torque.number(one["steady"]),
            ]
            for one in record["elements"]
        ],
    )
    for note in record["notes"]:
        print_line(units.text(f"Note: {note}"))
