"""A run-up as plain numbers."""

import numpy as np

from crankbase.units.units import RPM
from crankfem.analyses.record import Record
from crankfem.analyses.vibration.forced import ForcedVibration
from crankfem.analyses.vibration.run_up import RunUp


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
