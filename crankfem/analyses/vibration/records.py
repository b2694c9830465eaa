"""An engine's vibration as plain numbers in SI units, and the columns of its files."""

from collections.abc import Sequence
from math import isnan

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.quantity import RPM
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.record import ASSUMED, Record, assumed_values, attributes, plain
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.shaft.whole_shaft import not_comparable
from crankfem.analyses.vibration.assessment import Assessment, Uncertainty
from crankfem.analyses.vibration.axial_cycle import AxialForces, axial_forces
from crankfem.analyses.vibration.forced import ForcedVibration
from crankfem.analyses.vibration.modes import SourceResult, Vibration
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.whole_verdict import WholeVibration, whole_criticals
from crankfem.files.engine.mechanism_cylinders import firing_evenness, firing_sentence
from dynamics.assessment.verdict import Verdict
from dynamics.chains.engine_chains import CRANKSHAFT_MODE
from dynamics.excitation.chain_excitation import AxialForceComparison
from dynamics.response.damped_criticals import DampedCritical
from dynamics.response.series import OrderSeries

# SI units of loads in records.
LOAD_UNIT = {"torsional": "N m", "axial": "N"}
# How the forces begin to tell that full load serves all speeds, which the load tells.
ONE_DIAGRAM = "One pressure diagram was used"

# Shares below this are round-off: the cylinders cancel.
ROUND_OFF = 1e-12


def assessment_record(assessment: Assessment) -> Record:
    """Return verdict, limits and uncertainty in SI units; null where vibration is unbounded."""
    verdict = assessment.verdict
    running = verdict.running_range
    judged_to = {check.limit.name: check.judged[1] for check in verdict.checks}
    return {
        **attributes(verdict, "status", "headline", "sentence"),
        "decision": assessment.decision,
        "running_rpm": [speed * RPM for speed in running],
        "worst": verdict.worst,
        "checks": verdict.checks,
        "barred": verdict.barred,
        "started_through": verdict.started_through,
        "remarks": [*assessment.remarks, *verdict.remarks],
        "beside": [*assessment.by_whole, *assessment.beside],
        "by_whole": list(assessment.by_whole),
        "whole": None if assessment.whole is None else _verdict(assessment.whole),
        "limits": [
            attributes(limit, "name", "unit", "source", "assumed", "remark")
            | {"judged_to_rpm": judged_to[limit.name] * RPM}
            for limit in assessment.limits.values()
        ],
        "uncertainty": {
            one.kind: _uncertainty(one) for one in (assessment.axial, assessment.torsional)
        },
    }


def _verdict(verdict: Verdict) -> Record:
    return {
        **attributes(verdict, "status"),
        "checks": verdict.checks,
        "barred": [*verdict.barred, *verdict.started_through],
    }


def _uncertainty(uncertain: Uncertainty) -> Record:
    amplitudes = uncertain.amplitudes
    frequencies = zip(uncertain.lowest, uncertain.nominal, uncertain.highest, strict=True)
    return plain(
        {
            "frequencies": [
                {"mode": mode, "low": low, "nominal": nominal, "high": high}
                for mode, (low, nominal, high) in enumerate(frequencies, start=1)
            ],
            "barred": [
                {"low_rpm": low * RPM, "high_rpm": high * RPM} for low, high in uncertain.barred
            ],
            "amplitudes": None
            if amplitudes is None
            else {
                "samples": len(amplitudes.values),
                "nominal": amplitudes.nominal,
                "percentile_5": amplitudes.percentile(5.0),
                "percentile_95": amplitudes.percentile(95.0),
                "highest": amplitudes.highest,
            },
        }
    ) | {"spreads": uncertain.spreads, "critical": uncertain.critical}


def run_record(run: EngineVibration) -> Record:
    """Return modes, forced vibration, verdict, whole crankshaft and the effect of the main bearings' range.

    Null for results that were not calculated.
    """
    forced = (run.forced_axial, run.forced_torsional)
    evenness = firing_evenness(run.engine_file.engine)
    return {
        "firing": firing_sentence(run.engine_file.engine),
        "firing_remarks": list(evenness.notes),
        "firing_warnings": list(evenness.warnings),
        **{vibration.kind: vibration_record(vibration) for vibration in (run.axial, run.torsional)},
        "forced": {
            vibration.kind: forced_record(vibration)
            for vibration in forced
            if vibration is not None
        }
        or None,
        "axial_force": _axial_force(run),
        "load": run.load,
        "assumed": assumed_values(input_values(run.engine_file)),
        "assessment": None if run.assessment is None else assessment_record(run.assessment),
        "misfiring": run.misfiring,
        "misfiring_note": run.misfiring_note or None,
        "whole": None
        if run.whole is None or run.comparison is None
        else WholeVibration(
            run.whole,
            run.comparison,
            whole_criticals(run.engine_file, run.comparison, run.torsional.chosen.chain),
        ),
        "not_comparable": not_comparable(run.engine_file) or None,
        "bearings": run.bearings,
    }


def _axial_force(run: EngineVibration) -> AxialForces | None:
    if run.axial_force is None or run.forced_axial is None:
        return None
    compared = run.comparison
    # Without a chain to compare with, the whole crankshaft lacks the plant.
    coupled = None if compared is None or compared.axial is None else compared.coupled
    return axial_forces(run.axial_force, run.forced_axial, run.engine_file, coupled)


def vibration_record(vibration: Vibration) -> Record:
    """Modes and critical speeds with the chosen compliances, first frequencies with all."""
    chosen = vibration.chosen
    # Another source changes this mode's frequency and name, but hardly its number.
    crankshaft = chosen.chain.first_mode(chosen.modes)
    first = chosen.modes.rigid if crankshaft is None else crankshaft
    return {
        "kind": vibration.kind,
        "source": chosen.source,
        "nodes": list(chosen.chain.nodes),
        **attributes(chosen.chain.chain, "inertia", "stiffness", "ground"),
        "connections": [list(pair) for pair in chosen.chain.chain.connections],
        "modes": _mode_records(chosen),
        "criticals": [
            {
                **attributes(critical.critical, "speed_rpm", "order", "frequency"),
                "mode": critical.critical.mode + 1,
                **attributes(critical, "phase_sum", "in_running_range"),
            }
            for critical in vibration.criticals
        ],
        "sources": [
            {
                "source": result.source,
                "first_frequencies": result.elastic_frequencies[:3].tolist(),
                "first_mode": first - chosen.modes.rigid + 1,
                "crankshaft_frequencies": result.modes.frequencies[first : first + 3].tolist(),
                "first_frequency": float(result.modes.frequencies[first]),
                "beside_chosen": float(
                    result.modes.frequencies[first] / chosen.modes.frequencies[first]
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
    shares = result.chain.crankshaft_shares(modes)
    return [
        plain(
            {
                "number": mode + 1 - modes.rigid,
                "frequency": modes.frequencies[mode],
                "rigid": mode < modes.rigid,
                "crankshaft_share": shares[mode],
                "of_crankshaft": shares[mode] >= CRANKSHAFT_MODE,
                "node_positions": modes.node_positions[mode],
                "shape": modes.shapes[:, mode],
            }
        )
        for mode in range(len(modes.frequencies))
    ]


def forced_record(forced: ForcedVibration) -> Record:
    """Return curves and peaks of a forced vibration in SI units; null where it is unbounded."""
    free_end, compared = forced.free_end, forced.axial_forces
    return plain(
        {
            "kind": forced.kind,
            "damping": forced.damping,
            "remarks": [*_gas_remarks(forced), *forced.remarks],
            "method": forced.response.method,
            "orders": forced.response.orders,
            "speeds_rpm": forced.response.speeds * RPM,
            "free_end": {
                "node": free_end.names[0],
                "unit": MOTION[forced.kind].si,
                "synthesis": free_end.synthesis.amplitude[:, 0],
                "plain_sum": free_end.synthesis.plain_sum[:, 0],
                "orders": _order_peaks(free_end),
                "peaks": _peaks(free_end, MOTION[forced.kind].si, forced),
            },
            "loads": _peaks(forced.loads.elements, LOAD_UNIT[forced.kind], forced),
            "stress": None if forced.stress is None else _peaks(forced.stress, "Pa", forced),
            "power": _power(forced),
            "running_rpm": _rpm(forced.running_range),
            "judged_rpm": _rpm(forced.judged_range),
            "resonances": [_resonance(resonance, forced.kind) for resonance in forced.resonances],
            "axial_forces": None if compared is None else _axial_forces(compared, forced),
        }
    )


def _rpm(speeds: Sequence[float]) -> list[float]:
    return [speed * RPM for speed in speeds]


def _resonance(damped_critical: DampedCritical, kind: str) -> Record:
    """Return a peak; null if an order meets a mode without one. The amplitude is that of the free end."""
    names = (
        *("mode", "order", "speed_rpm", "frequency", "mode_frequency", "damping_ratio"),
        *("mode_share", "severity", "kind", "unbounded", "in_running_range"),
        *("in_band", "place", "modes", "others"),
    )
    record = attributes(damped_critical, *names) | plain(
        {
            "amplitude": damped_critical.first_amplitude,
            "value": damped_critical.amplitude,
            "unit": LOAD_UNIT[kind] if damped_critical.of_load else MOTION[kind].si,
            "spread_rpm": _rpm(damped_critical.spread) if damped_critical.has_peak else None,
            "undamped_rpm": damped_critical.undamped_speed * RPM,
            "locked_rpm": damped_critical.locked_speed * RPM,
        }
    )
    # Without a peak, or without a ring, there is no such value.
    missing = {
        name: None for name, value in record.items() if isinstance(value, float) and isnan(value)
    }
    return record | missing


def forced_columns(forced: ForcedVibration) -> tuple[dict[str, FloatArray], str]:
    """Return the amplitudes over the speed, of the free end by order and of loads, and a description."""
    free_end, loads = forced.free_end, forced.loads.elements
    unit = MOTION[forced.kind].si
    load = "Nm" if forced.kind == "torsional" else "N"
    columns = {
        "speed_rpm": forced.response.speeds * RPM,
        f"free_end_synthesis_{unit}": free_end.synthesis.amplitude[:, 0],
        f"free_end_plain_sum_{unit}": free_end.synthesis.plain_sum[:, 0],
    }
    for place, order in enumerate(free_end.orders.tolist()):
        columns[f"free_end_order_{order:g}_{unit}"] = free_end.amplitude[place, :, 0]
    for place, name in enumerate(loads.names):
        columns[f"{name} [{load}]"] = loads.synthesis.amplitude[:, place]
    return columns, f"{forced.kind} vibration, amplitudes; inf is unbounded"


def _peaks(series: OrderSeries, unit: str, forced: ForcedVibration) -> list[Record]:
    """Largest value of each location, all orders together: over all speeds, in and outside running ones."""
    summed = series.synthesis
    worst = np.argmax(summed.amplitude, axis=0)
    return [
        {
            "element": name,
            "unit": unit,
            "peak": summed.amplitude[worst[place], place],
            "speed_rpm": series.speeds[worst[place]] * RPM,
            "plain_sum_peak": np.max(summed.plain_sum[:, place]),
            **{
                part: None
                if not np.any(inside)
                else {
                    "peak": np.max(summed.amplitude[inside, place]),
                    "speed_rpm": series.speeds[inside][np.argmax(summed.amplitude[inside, place])]
                    * RPM,
                    "plain_sum_peak": np.max(summed.plain_sum[inside, place]),
                }
                for part, inside in forced.speed_parts.items()
            },
        }
        for place, name in enumerate(series.names)
    ]


def _order_peaks(series: OrderSeries) -> list[Record]:
    """Largest amplitude of each order at the first location, and its speed."""
    amplitude = series.amplitude[:, :, 0]
    return [
        {"order": order, "amplitude": curve.max(), "speed_rpm": series.speeds[curve.argmax()] * RPM}
        for order, curve in zip(series.orders, amplitude, strict=True)
    ]


def _power(forced: ForcedVibration) -> Record:
    """Speed with the most heat, and the error of the power balance."""
    power = forced.power
    bounded = ~np.any(power.unbounded, axis=0)
    total = power.dissipated.sum(axis=0, where=~power.unbounded)
    worst = int(np.argmax(np.where(bounded, total, -1.0)))
    dampers = {
        name: float(power.dashpots[:, worst, place].sum())
        for place, name in enumerate(power.dashpot_names)
        if bounded[worst]
    }
    return {
        "unit": "W",
        # At no speed is there anything to compare, where vibration is unbounded at all of them.
        "error": power.error if np.any(bounded) else None,
        "largest": float(total[worst]),
        "speed_rpm": float(forced.response.speeds[worst] * RPM),
        "dampers": dampers,
    }


def _axial_forces(compared: AxialForceComparison, forced: ForcedVibration) -> list[Record]:
    """Largest axial force of any throw at the highest speed, by two methods, by order."""
    alone, in_shaft = (
        np.abs(forces[:, -1]).max(axis=1) for forces in (compared.alone, compared.in_shaft)
    )
    none = alone <= ROUND_OFF * alone.max()
    alone[none] = in_shaft[none] = 0.0
    difference = np.where(none, 0.0, compared.difference[:, -1])
    return [
        {
            "order": order,
            "unit": "N",
            "alone": alone[place],
            "in_shaft": in_shaft[place],
            "difference": difference[place],
        }
        for place, order in enumerate(forced.response.orders)
    ]


def _gas_remarks(forced: ForcedVibration) -> list[str]:
    """Remarks of the forces that mechanism and load do not already have."""
    left_out = (ASSUMED, "Solved", ONE_DIAGRAM)
    return [text for text in forced.forces.remarks if not text.startswith(left_out)]
