"""The whole crankshaft's modes and coupled vibration as plain numbers."""

from collections.abc import Sequence

import numpy as np

from crankbase.quantity import RPM, significant
from crankfem.analyses.record import Record, attributes, plain
from crankfem.analyses.shaft.whole_shaft import ShaftComparison, WholeShaft
from dynamics.crankshaft.chain_comparison import ChainVerdict
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.indices import within
from fem.analysis import ThrowAnalysis
from fem.superelement import ShaftCompliances


def shaft_record(shaft: ShaftCompliances, analyses: Sequence[ThrowAnalysis]) -> Record:
    """Compliances of each throw in the shaft, and those of the single throw."""
    axial = np.array([analysis.axial_compliance("pinned") for analysis in analyses])
    torsional = np.array([analysis.torsional_compliance("pinned") for analysis in analyses])
    return attributes(shaft, "axial", "torsional", "influence") | {
        "axial_beside_pinned": (shaft.axial / axial).tolist(),
        "torsional_beside_pinned": (shaft.torsional / torsional).tolist(),
    }


MODES_SHOWN = 12
SHARES = ("axial", "torsional", "bending")


def whole_record(
    whole: WholeShaft, comparison: ShaftComparison | None, running_range: tuple[float, float]
) -> Record:
    """Return modes with their shares, and the comparison with the chains, in SI units.

    Amplitudes are the largest within the running range [rad/s].
    """
    modes = whole.modes
    verdicts = () if comparison is None else comparison.verdicts
    coupled = None if comparison is None else comparison.coupled
    return plain(
        {
            "remarks": whole.remarks,
            "highest_frequency": whole.highest_frequency,
            "modes": [
                {
                    "name": modes.names[mode],
                    "frequency": modes.frequencies[mode],
                    "rigid": mode < modes.rigid,
                    "kind": modes.kinds[mode],
                    "label": modes.label(mode),
                    **dict(zip(SHARES, modes.shares[:, mode], strict=True)),
                }
                for mode in range(min(modes.rigid + MODES_SHOWN, len(modes.names)))
            ],
            "rotation_ratio": whole.rotation_ratios[0],
            "bending": _bending(whole),
            "axial_split": None if coupled is None else _split(coupled, running_range),
        }
    ) | {
        "chains": {verdict.kind: _chain(verdict) for verdict in verdicts},
        "differences": () if comparison is None else comparison.differences,
        "flywheel_tilt": None if comparison is None else _tilts(whole, comparison),
    }


def _bending(whole: WholeShaft) -> Record | None:
    """Return the lowest bending mode, and the speed of rotation over its frequency."""
    first = whole.first_bending
    if first is None:
        return None
    return {"frequency": whole.modes.frequencies[first], "rotation_ratio": whole.bending_ratio}


def _tilts(whole: WholeShaft, comparison: ShaftComparison) -> Record | None:
    """Return the effect of the flywheel's diametral inertia on the first modes."""
    if not comparison.tilts:
        return None
    stations = whole.crankshaft.shaft.stations
    inertia = float(stations.diametral[-1])
    half = ", half of that about the shaft" if np.isclose(inertia, 0.5 * stations.polar[-1]) else ""
    moved = ", ".join(tilt.sentence for tilt in comparison.tilts if tilt.shown)
    return {
        "inertia": inertia,
        "modes": comparison.tilts,
        "sentence": f"The last step is the flywheel's inertia about a diameter ({significant(inertia, 3)} "
        f"kg m^2{half}); it moves {moved or 'the first frequencies by less than 0.05 Hz'}. In another order "
        "the steps share the same difference otherwise.",
    }


def _chain(verdict: ChainVerdict) -> Record:
    response = verdict.response
    (chain_speed, chain), (shaft_speed, shaft) = response.peaks if response else ((None,) * 2,) * 2
    return {
        **attributes(verdict, "suffices", "reasons"),
        "modes": verdict.modes,
        "chain_amplitude": chain,
        "chain_speed_rpm": None if chain_speed is None else chain_speed * RPM,
        "shaft_amplitude": shaft,
        "shaft_speed_rpm": None if shaft_speed is None else shaft_speed * RPM,
    }


def _split(coupled: CoupledResponse, running_range: tuple[float, float]) -> Record:
    """Largest axial amplitude of the free end by each kind of force and by both, each with its speed."""
    split = coupled.split("main bearing 1 uz")
    inside = np.flatnonzero(within(coupled.speeds, *running_range))
    record: Record = {}
    for name, curve in (
        ("tangential", split.tangential_sum),
        ("radial", split.radial_sum),
        ("both", split.both_sum),
    ):
        worst = int(inside[np.argmax(curve[inside])])
        record[name] = curve[worst]
        record[f"{name}_speed_rpm"] = coupled.speeds[worst] * RPM
    return record | {"speed_rpm": record["both_speed_rpm"]}
