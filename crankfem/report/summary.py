"""The first screen of a report: the verdict, what follows, the limits, and the key figures."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from crankbase.quantity import compact, format_number, nano, significant
from crankfem.analyses.record import Record
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.vibration.tables import factor_range
from crankfem.report.conclusions import (
    conclusions,
    failed_checks,
    headline,
    misfiring_decides,
    too_weak,
    undecided,
)
from crankfem.report.text_filters import quantity
from dynamics.engine.layout import repeating_intervals

KINDS = ("axial", "torsional")


def summary(results: RunResults) -> Record:
    """Return what the first screen of a report says.

    Returns
    -------
    dict
        "facts" (of the engine), "status" ("fine", "barred", "bad" or "open"), "headline", "sentences"
        (the conclusions), "failed_checks" (a sentence), "limits", "figures", "uncertain" (a sentence by
        kind).
    """
    vibration = results.vibration
    assessment = vibration["assessment"]
    known = {"fine": "fine", "not acceptable": "bad"}
    status = "open" if assessment is None else known.get(assessment["status"], "barred")
    if assessment is not None and (undecided(assessment) or misfiring_decides(vibration)):
        status = "barred"
    if too_weak(results.strength):
        status = "bad"
    return {
        "facts": engine_facts(results),
        "status": status,
        "headline": headline(results.vibration, results.strength),
        "sentences": conclusions(results),
        "failed_checks": failed_checks(results.checks),
        "limits": [] if assessment is None else worst_of_each(assessment["checks"]),
        "figures": [_compliance(results), *(_frequency(vibration, kind) for kind in KINDS)],
        "uncertain": {}
        if assessment is None
        else {kind: uncertain_sentence(vibration, kind) for kind in KINDS},
    }


def engine_facts(results: RunResults) -> list[str]:
    """Say what the engine is, a phrase each: its layout, size, speeds, pressure and firing order."""
    engine, mechanism = results.engine, results.mechanism
    count = engine["cylinders"]
    arranged = "in V" if engine["v_engine"] else "in line"
    lowest, highest, rated = (
        format_number(engine[f"{which}_speed_rpm"], 4) for which in ("lowest", "highest", "rated")
    )
    piston = significant(engine["mean_piston_speed"], 3)
    facts = [
        f"{count} cylinder{'' if count == 1 else 's'} {arranged}, {engine['strokes']}-stroke",
        f"bore {quantity(engine['bore'], 'm', 6)}, stroke {quantity(engine['stroke'], 'm', 6)}",
        f"{lowest} to {highest} 1/min, rated speed {rated} 1/min (mean piston speed {piston} m/s)",
    ]
    if mechanism is not None:
        facts.append(
            f"indicated power {quantity(mechanism.power, 'W', 3)}, mean indicated pressure "
            f"{quantity(mechanism.mean_indicated_pressure, 'Pa', 3)}"
        )
    if count > 1:
        order = f"firing order {'-'.join(map(str, engine['firing_order']))}"
        facts.append(order + _firing(engine["firing_intervals_deg"]))
    return facts


def _firing(intervals: Sequence[float]) -> str:
    """Say at which intervals an engine fires."""
    steps = repeating_intervals(intervals)
    listed = ", ".join(f"{step:.4g}" for step in steps)
    if len(steps) == 1:
        return f", evenly every {listed} deg"
    return f", unevenly, at intervals of {listed} deg{' in turn' if len(steps) < len(intervals) else ''}"


def uncertain_sentence(vibration: Record, kind: str) -> str:
    """State what is uncertain of one kind of vibration, and what that does to the crankshaft's first mode."""
    uncertain = vibration["assessment"]["uncertainty"][kind]
    spreads = [
        f"{spread['name']} {factor_range(spread)} the value used" for spread in uncertain["spreads"]
    ]
    bearings = vibration["bearings"]
    if bearings is not None:
        low, high = min(bearings["stiffness"]), max(bearings["stiffness"])
        spreads.append(f"stiffness of the main bearings {compact(low)} to {compact(high)} N/m each")
    sentence = f"Uncertainty of {kind} vibration: {'; '.join(spreads) or 'not known'}."
    first = _first_mode(vibration[kind])
    if first is None:
        return sentence
    bounds = uncertain["frequencies"][first["number"] - 1]
    sentence += f" First natural frequency of the crankshaft {_bounds(bounds)} by the chain"
    swept = _swept(vibration, kind)
    return (
        f"{sentence}, {swept} by the whole crankshaft over this stiffness."
        if swept
        else f"{sentence}."
    )


def _bounds(ends: Mapping[str, float]) -> str:
    low, high = _hertz(ends["low"]), _hertz(ends["high"])
    return f"{low} Hz" if low == high else f"{low} to {high} Hz"


def _swept(vibration: Mapping[str, Any], kind: str) -> str:
    """First frequency of the whole crankshaft over the stiffness of its bearings; empty if not calculated."""
    swept = vibration["bearings"]
    if swept is None or kind not in swept["shaft"]:
        return ""
    modes = [swept["shaft"][kind], *swept["further"][kind]]
    known = [[frequency for frequency in mode if frequency is not None] for mode in modes]
    if len(known[0]) < 2:
        return ""
    return " and ".join(
        _bounds({"low": min(frequency), "high": max(frequency)}) for frequency in known
    )


def _first_mode(chain: Record) -> Record | None:
    """Return the crankshaft's first mode, which is not one of coupling, damper or line."""
    return next(
        (mode for mode in chain["modes"] if not mode["rigid"] and mode["of_crankshaft"]),
        None,
    )


def _hertz(value: float) -> str:
    return significant(value, 3)


def worst_of_each(checks: Iterable[Mapping[str, Any]]) -> list[Record]:
    """Return the worst place of each limit at running speeds, and what is worse above them.

    Parameters
    ----------
    checks : iterable of mapping
        Of an assessment's record.

    Returns
    -------
    list of dict
        Checks, each with "above": the worst above the running range and its "place", or None where no more
        of the limit is used there.
    """
    worst: dict[str, Record] = {}
    for check in checks:
        running = dict(check) | (check["running"] or {})
        limit = worst.setdefault(check["limit"], running | {"above": None})
        if _use(running) > _use(limit):
            worst[check["limit"]] = limit = running | {"above": limit["above"]}
        above = check["above"]
        if above is not None and (limit["above"] is None or _use(above) > _use(limit["above"])):
            limit["above"] = {**above, "place": check["place"]}
        limit["passed"] = limit["passed"] and check["passed"]
    for limit in worst.values():
        if limit["above"] is not None and _use(limit["above"]) <= _use(limit):
            limit["above"] = None
    return list(worst.values())


def _use(check: Mapping[str, Any]) -> float:
    return float("inf") if check["used"] is None else float(check["used"])


def _compliance(results: RunResults) -> Record:
    throw, named = results.throw, results.throws
    which = f"throw {next(iter(named))}" if named else "a throw"
    exact = " of the exact solution, as 95 of 100 test throws"
    return {
        "label": f"Axial compliance of {which},",
        "symbol": ("e", "n"),
        "value": f"{nano(throw.supports['pinned'].axial, 3)}e-9",
        "unit": "m/N",
        "details": [
            "ends pinned, finite elements",
            f"{throw.error_words}{exact if throw.axial_correction else ''}",
        ],
    }


def _frequency(vibration: Mapping[str, Any], kind: str) -> Record:
    chain = vibration[kind]
    elastic = [mode for mode in chain["modes"] if not mode["rigid"]]
    shown = _first_mode(chain)
    first = None if shown is None else shown["frequency"]
    details = (
        [] if first is None else [f"{significant(60.0 * first, 3)} 1/min, chain of the throws"]
    )
    assessment, whole = vibration["assessment"], vibration["whole"]
    if assessment is not None and shown is not None:
        bounds = assessment["uncertainty"][kind]["frequencies"][shown["number"] - 1]
        details[0] = f"uncertainty range of the chain {_bounds(bounds)}"
    if whole is not None and kind in whole["chains"] and whole["chains"][kind]["modes"]:
        mode = whole["chains"][kind]["modes"][0]
        alike = (mode["shaft_frequency"], mode["further_frequency"])
        shaft = " and ".join(_hertz(frequency) for frequency in sorted(filter(None, alike)))
        shaft = f"{shaft} Hz" if shaft else "no mode like it"
        # The range over the bearings is that of one mode, the one most alike.
        swept = "" if mode["further_frequency"] else _swept(vibration, kind)
        details.append(f"whole crankshaft in its bearings: {shaft}{f' ({swept})' if swept else ''}")
    beside = elastic.index(shown) if shown is not None else len(elastic)
    if beside:
        lower = ", ".join(_hertz(mode["frequency"]) for mode in elastic[:beside])
        details.append(f"lower modes of coupling, damper or line: {lower} Hz")
    return {
        "label": f"First {kind} frequency{' of the crankshaft' if beside else ''}",
        "symbol": None,
        "value": "none" if first is None else _hertz(first),
        "unit": "" if first is None else "Hz",
        "details": details,
    }
