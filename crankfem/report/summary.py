"""The first screen of a report: the verdict, the dangerous speeds, the limits, and the key figures."""

from collections.abc import Iterable, Mapping
from typing import Any

from crankbase.units.number_formats import fixed, format_usage, percent, significant
from crankfem.analyses.record import Record
from crankfem.analyses.vibration.tables import TOGETHER
from crankfem.report.text_filters import motion, quantity

KINDS = ("axial", "torsional")
# Speeds of each kind that the first screen names, and how severe beside the worst they are at least.
SPEEDS_SHOWN, LEAST_SEVERITY = 4, 0.05
NOT_JUDGED = "Not judged: no gas pressure is given"


def summary(results: Mapping[str, Any]) -> Record:
    """Return what the first screen of a report says.

    Parameters
    ----------
    results : mapping
        Content of results.json.

    Returns
    -------
    dict
        "status" ("fine", "barred", "bad" or "open"), "headline", "sentences", "ranges", "speeds",
        "limits", "remarks", "figures", "misfiring" (a sentence or None), "misfiring_passed" (None where it
        was not calculated), "beside" (how far the whole crankshaft differs), "judged_to_rpm"
        (None where vibration is not judged above the running range).
    """
    vibration = results["vibration"]
    assessment, forced = vibration["assessment"], vibration["forced"]
    return {
        **(_open(results) if assessment is None else _verdict(vibration, assessment)),
        **_misfiring(vibration),
        "beside": [] if assessment is None else list(assessment.get("beside", [])),
        "judged_to_rpm": None if forced is None else _assessed_above(forced),
        "forced": forced is not None,
        "speeds": _critical_speeds(vibration) if forced is None else _resonances(forced),
        "limits": [] if assessment is None else _worst_of_each(assessment["checks"]),
        "figures": [
            _compliance(results),
            *(_frequency(vibration, kind) for kind in KINDS),
        ],
    }


def _verdict(vibration: Mapping[str, Any], assessment: Mapping[str, Any]) -> Record:
    status = {"fine": "fine", "not acceptable": "bad"}.get(assessment["status"], "barred")
    headline, decided = assessment["sentence"].partition(":")[0], []
    decision = assessment.get("decision") or {"status": "", "sentence": ""}
    if decision["sentence"]:
        decided = [f"{decision['sentence'][0].upper()}{decision['sentence'][1:]}."]
    if decision["status"] == "undecided":
        status, decided = "barred", [*decided, f"With the values assumed: {headline.lower()}."]
        headline = "Undecided"
    worst = assessment["checks"][0]
    cause = worst.get("cause")
    return {
        "status": status,
        "headline": headline,
        "sentences": [
            *decided,
            f"{worst['limit'].capitalize()}, {worst['place']}: {_reached(worst)}.",
            *([] if cause is None else [f"{cause['sentence'][0].upper()}{cause['sentence'][1:]}."]),
        ],
        "ranges": [
            {
                "shown": one["shown"],
                "text": "; ".join(one["refusals"]) or fine,
                "allowed": one["allowed"],
            }
            for name, fine in (
                ("barred", "may be barred"),
                ("started_through", "is passed on every start"),
            )
            for one in assessment[name]
        ],
        "remarks": [*power_and_load(vibration), *_limitations(assessment)],
    }


def _reached(check: Mapping[str, Any]) -> str:
    """Say what is reached at running speeds, and above them where more of the limit is used there."""
    running = check.get("running") or check
    found = _share(running, check["unit"])
    if check.get("in_running_range", True):
        return found
    return f"{found}; above the running range {_share(check, check['unit'])}"


def _share(found: Mapping[str, Any], unit: str) -> str:
    permitted, reached = quantity(found["permitted"], unit), quantity(found["value"], unit)
    at = f"{reached} at {fixed(found['speed_rpm'])} 1/min"
    if found["used"] is None:
        return f"{at}; permitted is {permitted}"
    return f"{at}, {format_usage(found['used'])} of the permitted {permitted}"


def _misfiring(vibration: Mapping[str, Any]) -> Record:
    """What is told of misfiring; nothing of older runs, which have not calculated it."""
    found = vibration.get("misfiring")
    if found is None:
        return {"misfiring": vibration.get("misfiring_note"), "misfiring_passed": None}
    return {"misfiring": found["sentence"], "misfiring_passed": found["passed"]}


def power_and_load(vibration: Mapping[str, Any]) -> list[str]:
    """What says that the file's power does not fit its gas, and the load of each speed."""
    load = vibration.get("load")
    if load is None:
        return []
    rated = load["rated"]
    found = [] if rated["consistent"] else [rated["sentence"]]
    return [f"{text[0].upper()}{text[1:]}." for text in (*found, load["sentence"])]


def _limitations(assessment: Mapping[str, Any]) -> list[str]:
    """What the verdict rests on, and what it leaves out."""
    found = [
        f"The limit on {limit['name']} is assumed ({limit['source']}), for none is given."
        for limit in assessment["limits"]
        if limit["assumed"]
    ]
    if not any(limit["name"].startswith("axial") for limit in assessment["limits"]):
        found.append("Axial vibration is not judged: no limit is given.")
    return found


def _open(results: Mapping[str, Any]) -> Record:
    count = sum(len(results["vibration"][kind]["criticals"]) for kind in KINDS)
    engine = results["engine"]
    return {
        "status": "open",
        "headline": NOT_JUDGED,
        "sentences": [
            "Amplitudes and stresses are not calculated, so nothing can be held against limits. "
            f"{count} critical speed{'' if count == 1 else 's'} of orders up to "
            f"{engine['highest_order']:g} {'lies' if count == 1 else 'lie'} in the running range."
        ],
        "ranges": [],
        "remarks": ["With a section [gas] the engine file gives what excites vibration."],
    }


def _assessed_above(forced: Mapping[str, Any]) -> float | None:
    """Speed up to which resonances are listed, if that is above the running range [1/min]."""
    own = forced["torsional"]
    if "judged_rpm" not in own or own["judged_rpm"][1] <= own["running_rpm"][1]:
        return None
    return float(own["judged_rpm"][1])


def _resonances(forced: Mapping[str, Any]) -> list[Record]:
    """The most severe resonances of each kind."""
    return [
        _speed(kind, one, motion(one["amplitude"], kind), major=one["kind"] == "major")
        for kind in KINDS
        for one in _largest(forced[kind]["resonances"], "severity", LEAST_SEVERITY)
    ]


def _critical_speeds(vibration: Mapping[str, Any]) -> list[Record]:
    """Critical speeds at which the cylinders act together, the strongest of each kind."""
    return [
        _speed(kind, one, fixed(one["phase_sum"], 2), major=one["phase_sum"] > 0.9)
        for kind in KINDS
        for one in _largest(vibration[kind]["criticals"], "phase_sum", TOGETHER)
    ]


def _largest(records: Iterable[Record], by: str, least: float) -> list[Record]:
    """The largest by a value that is at least so large."""
    found = (one for one in records if one[by] >= least)
    worst = sorted(found, key=lambda one: (not one.get("in_running_range", True), -float(one[by])))
    return worst[:SPEEDS_SHOWN]


def _speed(kind: str, record: Record, strength: str, *, major: bool) -> Record:
    return {
        "kind": kind,
        "speed_rpm": record["speed_rpm"],
        "order": record["order"],
        "strength": strength,
        "major": major,
        "above": not record.get("in_running_range", True),
    }


def _worst_of_each(checks: Iterable[Mapping[str, Any]]) -> list[Record]:
    """The worst place of each limit at running speeds, and its use above them where it is judged there."""
    found: dict[str, Record] = {}
    for check in checks:
        own = dict(check) | (check.get("running") or {})
        limit = found.setdefault(check["limit"], own | {"above": None})
        if _use(own) > _use(limit):
            found[check["limit"]] = limit = own | {"above": limit["above"]}
        above = check.get("above")
        if above is not None and (limit["above"] is None or _use(above) > _use(limit["above"])):
            limit["above"] = above
    for one in found.values():
        one["passed"] = _use(one) <= 1.0 and (one["above"] is None or _use(one["above"]) <= 1.0)
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
