"""Modes and critical speeds of a chain as plain JSON content."""

from crankfem.analyses.record import Record
from crankfem.analyses.vibration.modes import SourceResult, Vibration


def vibration_record(vibration: Vibration) -> Record:
    """Modes and critical speeds with the chosen compliances, first frequencies with all."""
    chosen = vibration.chosen
    return {
        "kind": vibration.kind,
        "source": chosen.source,
        "nodes": list(chosen.chain.nodes),
        "inertia": chosen.chain.chain.inertia.tolist(),
        "stiffness": chosen.chain.chain.stiffness.tolist(),
        "ground": chosen.chain.chain.ground.tolist(),
        "modes": _mode_records(chosen),
        "criticals": [
            {
                "speed_rpm": found.critical.speed_rpm,
                "order": found.critical.order,
                "frequency": found.critical.frequency,
                "mode": found.critical.mode + 1,
                "phase_sum": found.phase_sum,
                "in_running_range": found.in_running_range,
            }
            for found in vibration.criticals
        ],
        "sources": [
            {
                "source": result.source,
                "first_frequencies": result.elastic_frequencies[:3].tolist(),
                "beside_chosen": float(
                    result.elastic_frequencies[0] / chosen.elastic_frequencies[0]
                ),
                "mean_compliance": float(result.compliances.mean()),
                "remark": result.remark,
            }
            for result in vibration.others
        ],
        "unusable": list(vibration.unusable),
    }


def _mode_records(result: SourceResult) -> list[Record]:
    modes = result.modes
    return [
        {
            "number": mode + 1 - modes.rigid,
            "frequency": float(modes.frequencies[mode]),
            "rigid": mode < modes.rigid,
            "node_positions": list(modes.node_positions[mode]),
            "shape": modes.shapes[:, mode].tolist(),
        }
        for mode in range(len(modes.frequencies))
    ]
