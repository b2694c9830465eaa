"""Verdict and uncertainty as plain numbers, and the tables made from them."""

from typing import Any

from crankfem.console import print_line, print_table
from crankfem.output_units import SI, UNBOUNDED, OutputUnits
from crankfem.record import RPM, Record
from crankfem.vibration.assessment import Assessment, Uncertainty
from crankfem.vibration.forced_records import MOTION, finite_or_none
from dynamics.assessment.barred_ranges import BarredRange
from dynamics.assessment.verdict import LimitCheck

# Critical speeds that a table shows; files hold all.
ROWS_SHOWN = 12


def assessment_record(assessment: Assessment) -> Record:
    """Return verdict, limits and uncertainty in SI units; null where vibration is unbounded."""
    verdict = assessment.verdict
    return {
        "status": verdict.status,
        "sentence": verdict.sentence,
        "checks": [_check(check) for check in verdict.checks],
        "barred": [_range(one) for one in verdict.barred],
        "started_through": [_range(one) for one in verdict.started_through],
        "remarks": [*assessment.remarks, *verdict.remarks],
        "limits": [
            {
                "name": limit.name,
                "unit": limit.unit,
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


def print_assessment(record: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print what is uncertain, limits, barred ranges and, last, the verdict."""
    speed = units.of("1/min")
    for kind, uncertain in record["uncertainty"].items():
        _print_uncertainty(kind, uncertain, units)
    print_table(
        "Limits, each at its worst running speed",
        ["limit", "where:", f"at [{speed.name}]", "reached:", "permitted:", "used [%]"],
        [
            [
                check["limit"],
                check["place"],
                speed.fixed(check["speed_rpm"] / RPM, 1),
                _quantity(check["value"], check["unit"], units),
                _quantity(check["permitted"], check["unit"], units),
                UNBOUNDED if check["used"] is None else f"{100.0 * check['used']:.3g}",
            ]
            for check in record["checks"]
        ],
    )
    for limit in record["limits"]:
        assumed = ", assumed" if limit["assumed"] else ""
        print_line(units.text(f"Limit on {limit['name']}: {limit['source']}{assumed}."))
    for line in record["remarks"]:
        print_line(units.text(f"Note: {line}"))
    for name, fine in (
        ("barred", "may be barred"),
        ("started_through", "is passed on every start"),
    ):
        for one in record[name]:
            said = "; ".join(one["refusals"]) or fine
            print_line(units.text(f"Range {one['shown']}: {said}."))
    print_line(units.text(f"Verdict: {record['sentence']}"))


def _print_uncertainty(kind: str, record: dict[str, Any], units: OutputUnits) -> None:
    motion, speed = units.of(MOTION[kind]), units.of("1/min")
    for spread in record["spreads"]:
        print_line(
            f"{kind.capitalize()}: {spread['name']} {spread['low']:.3g} to {spread['high']:.3g} times the "
            "value used"
        )
    count = len(record["critical"])
    print_table(
        f"{kind.capitalize()} critical speeds with what is uncertain, and their margin to running speeds"
        + (f", the first {ROWS_SHOWN} of {count}" if count > ROWS_SHOWN else ""),
        ["mode", "order", f"speed [{speed.name}]", "lowest", "highest", "margin [%]"],
        [
            [
                str(one["mode"]),
                f"{one['order']:g}",
                *(speed.fixed(one[name] / RPM, 1) for name in ("speed_rpm", "low_rpm", "high_rpm")),
                "none" if one["margin"] == 0.0 else f"{100.0 * one['margin']:.1f}",
            ]
            for one in record["critical"][:ROWS_SHOWN]
        ],
    )
    if record["amplitudes"] is not None:
        found = record["amplitudes"]
        print_line(
            f"{kind.capitalize()} amplitude of the free end at running speeds: nominal "
            f"{motion.number(found['nominal'])}, 5 to 95 % of {found['samples']} samples "
            f"{motion.number(found['percentile_5'])} to {motion.number(found['percentile_95'])} "
            f"{motion.name}"
        )


def _check(check: LimitCheck) -> Record:
    return {
        "limit": check.limit.name,
        "place": check.curve.name,
        "unit": check.limit.unit,
        "speed_rpm": check.worst_speed * RPM,
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


def _quantity(value: float | None, unit: str, units: OutputUnits) -> str:
    return UNBOUNDED if value is None else units.quantity(value, unit, 4)
