"""A run-up as plain numbers, and the table made from them."""

import numpy as np

from crankfem.console import print_line, print_table
from crankfem.record import RPM, Record
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


def print_run_up(record: Record) -> None:
    """Print the largest torques of a run-up."""
    cut = "" if record["complete"] else ", interrupted"
    print_table(
        f"Run-up from {record['from_rpm']:.0f} to {record['to_rpm']:.0f} 1/min in "
        f"{record['duration']:g} s{cut}: amplitude of the torque in the springs",
        ["element", "largest [kN m]", "at [1/min]", "at constant speeds [kN m]"],
        [
            [
                one["element"],
                f"{1e-3 * one['largest']:.4g}",
                f"{one['at_rpm']:.0f}",
                "unbounded" if one["steady"] is None else f"{1e-3 * one['steady']:.4g}",
            ]
            for one in record["elements"]
        ],
    )
    for note in record["notes"]:
        print_line(f"Note: {note}")
