"""Verdict and uncertainty as plain numbers."""

from crankbase.units.units import RPM
from crankfem.analyses.record import Record, finite_or_none
from crankfem.analyses.vibration.assessment import Assessment, Uncertainty
from dynamics.assessment.barred_ranges import BarredRange, limit_end_speed
from dynamics.assessment.verdict import LimitCheck


def assessment_record(assessment: Assessment) -> Record:
    """Return verdict, limits and uncertainty in SI units; null where vibration is unbounded."""
    verdict = assessment.verdict
    return {
        "status": verdict.status,
        "sentence": verdict.sentence,
        "running_rpm": [speed * RPM for speed in verdict.running_range],
        "checks": [_check(check, verdict.running_range) for check in verdict.checks],
        "barred": [_range(one) for one in verdict.barred],
        "started_through": [_range(one) for one in verdict.started_through],
        "remarks": [*assessment.remarks, *verdict.remarks],
        "beside": list(assessment.beside),
        "limits": [
            {
                "name": limit.name,
                "unit": limit.unit,
                "judged_to_rpm": limit_end_speed(limit, verdict.running_range) * RPM,
                "source": limit.source,
                "assumed": limit.assumed,
                "remark": limit.remark,
            }
            for limit in assessment.limits.values()
        ],
        "uncertainty": {
            one.kind: _uncertainty(one) for one in (assessment.axial, assessment.torsional)
        },
    }


def _check(check: LimitCheck, running: tuple[float, float]) -> Record:
    return {
        "limit": check.limit.name,
        "place": check.curve.name,
        "unit": check.limit.unit,
        "speed_rpm": check.worst_speed * RPM,
        "near": check.near or None,
        "in_running_range": check.worst_speed <= running[1],
        "value": finite_or_none(check.worst_value),
        "permitted": check.permitted,
        "used": finite_or_none(check.used),
        "passed": check.passed,
        "source": check.limit.source,
        "assumed": check.limit.assumed,
    }


def _range(found: BarredRange) -> Record:
    return {
        "shown": found.shown,
        "low_rpm": found.low * RPM,
        "high_rpm": found.high * RPM,
        "limits": list(found.limits),
        "allowed": found.allowed,
        "refusals": list(found.refusals),
        "remarks": list(found.remarks),
        "ends": found.ends,
    }


def _uncertainty(uncertain: Uncertainty) -> Record:
    amplitudes = uncertain.amplitudes
    return {
        "spreads": [
            {"name": one.name, "kind": one.kind, "low": one.low, "high": one.high}
            for one in uncertain.spreads
        ],
        "frequencies": [
            {"mode": place + 1, "low": low, "nominal": nominal, "high": high}
            for place, (low, nominal, high) in enumerate(
                zip(
                    uncertain.lowest.tolist(),
                    uncertain.nominal.tolist(),
                    uncertain.highest.tolist(),
                    strict=True,
                )
            )
        ],
        "critical": [
            {
                "mode": one.mode,
                "order": one.order,
                "speed_rpm": one.nominal * RPM,
                "low_rpm": one.low * RPM,
                "high_rpm": one.high * RPM,
                "margin": one.margin,
            }
            for one in uncertain.critical
        ],
        "amplitudes": None
        if amplitudes is None
        else {
            "samples": len(amplitudes.values),
            "nominal": finite_or_none(float(amplitudes.nominal)),
            "percentile_5": finite_or_none(float(amplitudes.percentile(5.0))),
            "percentile_95": finite_or_none(float(amplitudes.percentile(95.0))),
            "highest": finite_or_none(float(amplitudes.highest)),
        },
    }
