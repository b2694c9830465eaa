"""Misfiring and normal firing as plain numbers in SI units."""

from crankbase.units.units import RPM
from crankfem.analyses.record import Record, attributes, plain
from crankfem.analyses.vibration.firing_check import FiringCheck, Reached
from crankfem.analyses.vibration.misfiring import Misfiring


def misfiring_record(found: Misfiring) -> Record:
    """Return the record of misfiring; null where vibration is unbounded or nothing is limited."""
    return {
        **attributes(found, "sentence", "passed", "cases", "missing_share", "compression"),
        "checks": [_check(one) for one in found.checks],
        "exceeded_rpm": [[speed * RPM for speed in one] for one in found.exceeded],
        "remaining_rpm": [[speed * RPM for speed in one] for one in found.remaining],
        "remarks": list(found.remarks),
    }


def _check(check: FiringCheck) -> Record:
    limit = check.limit
    return {
        **attributes(check, "quantity", "unit", "cylinders"),
        "source": None if limit is None else limit.source,
        "assumed": limit is not None and limit.assumed,
        "passed": None if limit is None else check.passed,
        "basis": None if limit is None else limit.misfiring_basis,
        "new": None
        if check.new is None
        else {
            "cylinders": list(check.new.cylinders),
            **_reached(check.new.reached),
            "cause": check.new.cause.reasons,
        },
        "normal": _reached(check.normal),
        "misfiring": _reached(check.misfiring),
        "each": [{"cylinders": list(case), **_reached(one)} for case, one in check.each.items()],
    }


def _reached(found: Reached) -> Record:
    limited = found.permitted < float("inf")
    return plain(
        {
            "place": found.place,
            "speed_rpm": found.speed * RPM,
            "value": found.value,
            "permitted": found.permitted,
            "used": found.used if limited else None,
        }
    )


def worst_record(found: tuple[float, float, float] | None) -> Record | None:
    """Return the largest use of a limit among some speeds."""
    if found is None:
        return None
    speed, value, permitted = found
    return {
        "speed_rpm": speed * RPM,
        "value": value,
        "permitted": permitted,
        "used": value / permitted,
    }
