"""The verdict on an engine's vibration, and its uncertainty, as plain numbers."""

from crankbase.units.units import RPM
from crankfem.analyses.record import Record, attributes, plain
from crankfem.analyses.vibration.assessment import Assessment, Uncertainty
from crankfem.analyses.vibration.misfiring_records import worst_record
from dynamics.assessment.barred_ranges import BarredRange
from dynamics.assessment.limits import worst_use
from dynamics.assessment.verdict import SAME, LimitCheck, Verdict
from dynamics.response.peak_cause import PeakCause

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
        "decision": attributes(assessment.decision, "status", "sentence")
        | {
            "trials": [
                attributes(one, "field", "name", "value", "unit", "status", "taken", "why")
                for one in assessment.decision.trials
            ]
        },
        "running_rpm": [speed * RPM for speed in running],
        "worst": _check(verdict.worst, running[1]),
        "checks": [_check(check, running[1]) for check in verdict.checks],
        "barred": [_range(one) for one in verdict.barred],
        "started_through": [_range(one) for one in verdict.started_through],
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


def _verdict(found: Verdict) -> Record:
    checks = [_check(check, found.running_range[1]) for check in found.checks]
    ranges = (*found.barred, *found.started_through)
    return {
        **attributes(found, "status"),
        "checks": checks,
        "barred": [_range(one) for one in ranges],
    }


def _check(check: LimitCheck, highest_speed: float) -> Record:
    return plain(
        {
            "limit": check.limit.name,
            "place": check.curve.name,
            "speed_rpm": check.worst_speed * RPM,
            "cause": None if check.cause is None else _cause(check.cause),
            "in_running_range": check.worst_speed <= highest_speed,
            "value": check.worst_value,
            **attributes(check, "permitted", "used", "passed"),
            "running": worst_record(check.running),
            "above": worst_record(check.above),
            "below": worst_record(
                worst_use(check.limit, check.curve, 0.0, (1.0 - SAME) * check.judged[0])
            ),
            **attributes(check.limit, "unit", "source", "assumed"),
        }
    )


def _cause(found: PeakCause) -> Record:
    """Return the contributions of the orders to a peak, and the sentences on them."""
    names = (
        *("order", "contribution", "amplitude", "state", "kind", "mode", "mode_share"),
        *("magnifier", "detuning"),
    )
    return {"sentence": found.reasons, "orders": [attributes(one, *names) for one in found.parts]}


def _range(found: BarredRange) -> Record:
    return {
        **attributes(found, "shown", "sentence", "position", "limits", "allowed", "refusals"),
        **attributes(found, "remarks", "ends"),
        "low_rpm": found.low * RPM,
        "high_rpm": found.high * RPM,
    }


def _uncertainty(uncertain: Uncertainty) -> Record:
    amplitudes = uncertain.amplitudes
    frequencies = zip(uncertain.lowest, uncertain.nominal, uncertain.highest, strict=True)
    return plain(
        {
            "spreads": [
                attributes(one, "name", "kind", "low", "high") for one in uncertain.spreads
            ],
            "frequencies": [
                {"mode": mode, "low": low, "nominal": nominal, "high": high}
                for mode, (low, nominal, high) in enumerate(frequencies, start=1)
            ],
            "critical": [
                {
                    **attributes(one, "mode", "order", "margin"),
                    "speed_rpm": one.nominal * RPM,
                    "low_rpm": one.low * RPM,
                    "high_rpm": one.high * RPM,
                }
                for one in uncertain.critical
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
    )
