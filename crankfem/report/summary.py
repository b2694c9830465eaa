"""The first screen of a report: the verdict, what follows, the limits, and the key figures."""

from collections.abc import Iterable, Mapping
from typing import Any

from crankbase.units.number_formats import fixed, percent, significant
from crankfem.analyses.record import Record
from crankfem.report.conclusions import conclusions, headline, undecided

KINDS = ("axial", "torsional")


def summary(results: Mapping[str, Any]) -> Record:
    """Return what the first screen of a report says.

    Parameters
    ----------
    results : mapping
        Content of results.json.

    Returns
    -------
    dict
        "status" ("fine", "barred", "bad" or "open"), "headline", "sentences" (the conclusions), "limits",
        "figures".
    """
    vibration = results["vibration"]
    assessment = vibration["assessment"]
    known = {"fine": "fine", "not acceptable": "bad"}
    status = "open" if assessment is None else known.get(assessment["status"], "barred")
    if assessment is not None and undecided(assessment):
        status = "barred"
    return {
        "status": status,
        "headline": headline(results),
        "sentences": conclusions(results),
        "limits": [] if assessment is None else worst_of_each(assessment["checks"]),
        "figures": [
            _compliance(results),
            *(_frequency(vibration, kind) for kind in KINDS),
        ],
    }


def worst_of_each(checks: Iterable[Mapping[str, Any]]) -> list[Record]:
    """Return the worst place of each limit at running speeds, and its use above them where it is told.

    Parameters
    ----------
    checks : iterable of mapping
        Of an assessment's record.

    Returns
    -------
    list of dict
        Checks, each with "above": what is reached above the running range, or None.
    """
    found: dict[str, Record] = {}
    for check in checks:
        own = dict(check) | (check.get("running") or {})
        limit = found.setdefault(check["limit"], own | {"above": None})
        if _use(own) > _use(limit):
            found[check["limit"]] = limit = own | {"above": limit["above"]}
        above = check.get("above")
        if above is not None and (limit["above"] is None or _use(above) > _use(limit["above"])):
            limit["above"] = above
        limit["passed"] = limit["passed"] and check["passed"]
    return list(found.values())


def _use(found: Mapping[str, Any]) -> float:
    return float("inf") if found["used"] is None else float(found["used"])


def _compliance(results: Mapping[str, Any]) -> Record:
    throw, named = results["throw"], results.get("throws")
    which = f"throw {next(iter(named))}" if named else "a throw"
    error = f"error about {percent(throw['error_estimate'])} %"
    return {
        "label": f"Axial compliance of {which},",
        "symbol": ("e", "n"),
        "value": f"{significant(throw['supports']['pinned']['axial_compliance'] * 1e9)}e-9",
        "unit": "m/N",
        "details": ["ends pinned, finite elements", f"{error}; the true value is larger by that"],
    }


def _frequency(vibration: Mapping[str, Any], kind: str) -> Record:
    own = vibration[kind]
    elastic = [mode for mode in own["modes"] if not mode["rigid"]]
    shown = next((mode for mode in elastic if mode.get("of_crankshaft", True)), None)
    first = None if shown is None else shown["frequency"]
    details = [] if first is None else [f"{first * 60.0:.0f} 1/min, chain of the throws"]
    assessment, whole = vibration["assessment"], vibration["whole"]
    if assessment is not None and shown is not None:
        bounds = assessment["uncertainty"][kind]["frequencies"][shown["number"] - 1]
        details[0] = f"{fixed(bounds['low'])} to {fixed(bounds['high'])} Hz with what is uncertain"
    if whole is not None and whole["chains"].get(kind, {}).get("modes"):
        shaft = whole["chains"][kind]["modes"][0]["shaft_frequency"]
        details.append(f"whole crankshaft in its bearings: {fixed(shaft)} Hz")
    beside = elastic.index(shown) if shown is not None else len(elastic)
    if beside:
        lower = ", ".join(fixed(mode["frequency"]) for mode in elastic[:beside])
        details.append(f"lower ones of coupling, damper or line: {lower} Hz")
    return {
        "label": f"First {kind} frequency",
        "symbol": None,
        "value": "none" if first is None else fixed(first),
        "unit": "" if first is None else "Hz",
        "details": details,
    }
