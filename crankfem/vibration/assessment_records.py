"""Verdict and uncertainty as plain numbers, and the tables made from them."""

from typing import Any

from crankfem.console import print_line, print_table
from crankfem.number_formats import UNBOUNDED, used
from crankfem.output_units import SI, OutputUnits
from crankfem.record import Record
from crankfem.vibration.assessment import Assessment, Uncertainty
from crankfem.vibration.forced_records import finite_or_none
from crankfem.vibration.motion import MOTION
from dynamics.assessment.barred_ranges import BarredRange, judged_to
from dynamics.assessment.verdict import LimitCheck
from geometry.units import RPM

# Critical speeds that a table shows; files hold all.
ROWS_SHOWN = 12


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


def print_assessment(record: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print what is uncertain, limits, barred ranges and, last, the verdict."""
    speed = units.of("1/min")
    for kind, uncertain in record["uncertainty"].items():
        _print_uncertainty(kind, uncertain, units)
    for limit in dict.fromkeys(check["limit"] for check in record["checks"]):
        print_table(
            f"{limit.capitalize()}, worst speeds",
            ["where", f"at [{speed.name}]", "reached", "permitted", "used [%]"],
            [
                [
                    check["place"],
                    speed.fixed(check["speed_rpm"] / RPM, 1),
                    _quantity(check["value"], check["unit"], units),
                    _quantity(check["permitted"], check["unit"], units),
                    used(check["used"]).removesuffix(" %"),
                ]
                for check in record["checks"]
                if check["limit"] == limit
            ],
        )
    lowest, highest = record["running_rpm"]
    for limit in record["limits"]:
        assumed = ", assumed" if limit["assumed"] else ""
        end = limit["judged_to_rpm"]
        beyond = (
            f", for it holds above the highest running speed of {highest:.4g} 1/min too"
            if end > highest
            else ""
        )
        print_line(
            units.text(
                f"Limit on {limit['name']}: {limit['source']}{assumed}; judged from {lowest:.4g} to "
                f"{end:.4g} 1/min{beyond}."
            )
        )
    for line in record["remarks"]:
        print_line(units.text(f"Note: {line}"))
    for name, fine in (
        ("barred", "may be barred"),
        ("started_through", "is passed on every start"),
    ):
        for one in record[name]:
            said = "; ".join(one["refusals"]) or fine
            print_line(units.text(f"Range {one['shown']}: {said}. Its ends: {one['ends']}."))
    print_line(units.text(f"Verdict: {record['sentence']}"))
    for line in record["beside"]:
        print_line(units.text(line))


def _print_uncertainty(kind: str, record: dict[str, Any], units: OutputUnits) -> None:
    motion, speed = units.of(MOTION[kind].printed), units.of("1/min")
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


def _quantity(value: float | None, unit: str, units: OutputUnits) -> str:
    return UNBOUNDED if value is None else units.quantity(value, unit, 4)
