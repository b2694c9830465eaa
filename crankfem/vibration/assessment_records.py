"""Verdict and uncertainty as plain numbers, and the tables made from them."""

from crankfem.output_units import SI, UNBOUNDED, OutputUnits
from crankfem.record import RPM, Record
from crankfem.table import Column, Table
from crankfem.vibration.assessment import Assessment, Uncertainty
from crankfem.vibration.forced_records import ROWS_SHOWN, SPEED, finite_or_none
from dynamics.assessment.barred_ranges import BarredRange, judged_to
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
                "judged_to_rpm": judged_to(limit, verdict.running_range) * RPM,
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


def limit_table(record: Record, limit: str | None = None, units: OutputUnits = SI) -> Table:
    """Return how far limits are used, each place at its worst speed: all of them, or one by its name."""
    checks = [one for one in record["checks"] if limit in (None, one["limit"])]

    def quantity(value: float | None, unit: str) -> str:
        return UNBOUNDED if value is None else units.quantity(value, unit, 4)

    table = Table(
        "Limits, worst speeds" if limit is None else f"{limit.capitalize()}, worst speeds",
        [
            Column("limit", words=True),
            Column("where", words=True),
            Column("at", "1/min", decimals=1),
            Column("reached"),
            Column("permitted"),
            Column("used", "%", 3, missing=UNBOUNDED),
        ],
        [
            [
                one["limit"],
                one["place"],
                one["speed_rpm"] / RPM,
                quantity(one["value"], one["unit"]),
                quantity(one["permitted"], one["unit"]),
                one["used"],
            ]
            for one in checks
        ],
        marks=["" if one["passed"] else "over" for one in checks],
    )
    return table if limit is None else table.only("where", "at", "reached", "permitted", "used")


def margin_table(kind: str, record: Record) -> Table:
    """Return the critical speeds of one kind with what is uncertain of them."""
    found = record["critical"]
    return Table(
        f"{kind.capitalize()} critical speeds with what is uncertain, and their margin to running speeds"
        + (f", the first {ROWS_SHOWN} of {len(found)}" if len(found) > ROWS_SHOWN else ""),
        [
            Column("mode"),
            Column("order", digits=6),
            SPEED,
            *(Column(name, "1/min", decimals=1, bare=True) for name in ("lowest", "highest")),
            Column("margin", "%", decimals=1),
        ],
        [
            [
                one["mode"],
                one["order"],
                *(one[name] / RPM for name in ("speed_rpm", "low_rpm", "high_rpm")),
                one["margin"] or None,
            ]
            for one in found[:ROWS_SHOWN]
        ],
    )


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
