"""The whole crankshaft's modes and coupled vibration as plain numbers."""

import numpy as np

from crankbase.units.units import RPM
from crankfem.analyses.record import Record, finite_or_none
from crankfem.analyses.shaft.whole_shaft import ShaftComparison, WholeShaft
from dynamics.crankshaft.chain_comparison import ChainVerdict
from dynamics.crankshaft.coupled_response import CoupledResponse

MODES_SHOWN = 12


def whole_record(whole: WholeShaft, comparison: ShaftComparison | None) -> Record:
    """Return modes with their shares, and the comparison with the chains, in SI units."""
    modes = whole.modes
    return {
        "remarks": list(whole.remarks),
        "highest_frequency": whole.highest_frequency,
        "modes": [
            {
                "name": modes.names[mode],
                "frequency": float(modes.frequencies[mode]),
                "rigid": mode < modes.rigid,
                "kind": modes.kinds[mode],
                "label": modes.label(mode),
                "axial": float(modes.shares[0, mode]),
                "torsional": float(modes.shares[1, mode]),
                "bending": float(modes.shares[2, mode]),
            }
            for mode in range(min(modes.rigid + MODES_SHOWN, len(modes.names)))
        ],
        "rotation_ratio": float(whole.rotation_ratios[0]),
        "chains": {}
        if comparison is None
        else {one.kind: _chain(one) for one in comparison.verdicts},
        "axial_split": None
        if comparison is None or comparison.coupled is None
        else _split(comparison.coupled),
    }


def _chain(verdict: ChainVerdict) -> Record:
    response = verdict.response
    return {
        "suffices": verdict.suffices,
        "reasons": list(verdict.reasons),
        "modes": [
            {
                "chain_frequency": one.chain_frequency,
                "shaft_frequency": one.shaft_frequency,
                "share": one.share,
                "likeness": one.likeness,
            }
            for one in verdict.modes
        ],
        "chain_amplitude": None
        if response is None
        else finite_or_none(float(np.max(response.chain))),
        "shaft_amplitude": None
        if response is None
        else finite_or_none(float(np.max(response.shaft))),
    }


def _split(coupled: CoupledResponse) -> Record:
    """Largest axial amplitude of the free end by each kind of force, and by both."""
    split = coupled.split("section 0 uz")
    worst = int(np.argmax(split.both_sum))
    return {
        "tangential": finite_or_none(float(np.max(split.tangential_sum))),
        "radial": finite_or_none(float(np.max(split.radial_sum))),
        "both": finite_or_none(float(split.both_sum[worst])),
        "speed_rpm": float(coupled.speeds[worst] * RPM),
    }
