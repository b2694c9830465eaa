"""The first screen of a report: the verdict, what follows, the limits, and the key figures."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crankbase.quantity import RPM, compact, format_number, nano, significant
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.vibration.assessment import Assessment, factor_range
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.tables import speed_table
from crankfem.report.conclusions import (
    conclusions,
    failed_checks,
    headline,
    misfiring_decides,
    reached_and_permitted,
    too_weak,
)
from crankfem.report.text_filters import quantity
from dynamics.assessment.limits import LimitUse
from dynamics.assessment.verdict import LimitCheck
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
    assessment = vibration.assessment
    known = {"fine": "fine", "not acceptable": "bad"}
    status = "open" if assessment is None else known.get(assessment.verdict.status, "barred")
    if assessment is not None and (assessment.undecided or misfiring_decides(vibration)):
        status = "barred"
    if too_weak(results.strength):
        status = "bad"
    return {
        "facts": engine_facts(results),
        "status": status,
        "headline": headline(results.vibration, results.strength),
        "sentences": conclusions(results),
        "failed_checks": failed_checks(results.checks),
        "limits": [] if assessment is None else worst_of_each(assessment.verdict.checks),
        "figures": [_compliance(results), *(_frequency(vibration, kind) for kind in KINDS)],
        "uncertain": {}
        if assessment is None
        else {kind: uncertain_sentence(vibration, assessment, kind) for kind in KINDS},
    }


def engine_facts(results: RunResults) -> list[str]:
    """Say what the engine is, a phrase each: its layout, size, speeds, pressure and firing order."""
    engine, mechanism = results.engine, results.mechanism
    count = engine.cylinders
    arranged = "in V" if engine.v_engine else "in line"
    lowest, highest, rated = (
        format_number(speed * RPM, 4)
        for speed in (engine.lowest_speed, engine.highest_speed, engine.rated_speed)
    )
    piston = significant(engine.mean_piston_speed, 3)
    facts = [
        f"{count} cylinder{'' if count == 1 else 's'} {arranged}, {engine.strokes}-stroke",
        f"bore {quantity(engine.bore, 'm', 6)}, stroke {quantity(engine.stroke, 'm', 6)}",
        f"{lowest} to {highest} 1/min, rated speed {rated} 1/min (mean piston speed {piston} m/s)",
    ]
    if mechanism is not None:
        facts.append(
            f"indicated power {quantity(mechanism.power, 'W', 3)}, mean indicated pressure "
            f"{quantity(mechanism.mean_indicated_pressure, 'Pa', 3)}"
        )
    if count > 1:
        order = f"firing order {'-'.join(map(str, engine.firing_order))}"
        facts.append(order + _firing(engine.firing_intervals_deg))
    return facts


def _firing(intervals: Sequence[float]) -> str:
    """Say at which intervals an engine fires."""
    steps = repeating_intervals(intervals)
    listed = ", ".join(f"{step:.4g}" for step in steps)
    if len(steps) == 1:
        return f", evenly every {listed} deg"
    return f", unevenly, at intervals of {listed} deg{' in turn' if len(steps) < len(intervals) else ''}"


def uncertain_sentence(vibration: EngineVibration, assessment: Assessment, kind: str) -> str:
    """State what is uncertain of one kind of vibration, and what that does to the crankshaft's first mode."""
    uncertain = assessment.uncertainty[kind]
    spreads = [
        f"{spread.name} {factor_range(spread)} the value used" for spread in uncertain.spreads
    ]
    bearings = vibration.bearings
    if bearings is not None:
        low, high = float(min(bearings.stiffness)), float(max(bearings.stiffness))
        spreads.append(f"stiffness of the main bearings {compact(low)} to {compact(high)} N/m each")
    sentence = f"Uncertainty of {kind} vibration: {'; '.join(spreads) or 'not known'}."
    first = vibration.modes(kind).crankshaft_mode
    if first is None:
        return sentence
    bounds = uncertain.frequencies[first.number - 1]
    reach = _bounds(bounds.lowest, bounds.highest)
    sentence += f" First natural frequency of the crankshaft {reach} by the chain"
    swept = _swept(vibration, kind)
    return (
        f"{sentence}, {swept} by the whole crankshaft over this stiffness."
        if swept
        else f"{sentence}."
    )


def _bounds(lowest: float, highest: float) -> str:
    low, high = _hertz(lowest), _hertz(highest)
    return f"{low} Hz" if low == high else f"{low} to {high} Hz"


def _swept(vibration: EngineVibration, kind: str) -> str:
    """First frequency of the whole crankshaft over the stiffness of its bearings; empty if not calculated."""
    swept = vibration.bearings
    if swept is None or kind not in swept.shaft:
        return ""
    modes = [swept.shaft[kind], *swept.further[kind]]
    known = [mode[np.isfinite(mode)] for mode in modes]
    if len(known[0]) < 2:
        return ""
    return " and ".join(
        _bounds(float(min(frequency)), float(max(frequency))) for frequency in known
    )


def _hertz(value: float) -> str:
    return significant(value, 3)


@dataclass(frozen=True)
class WorstPlace:
    """The worst place of a limit at running speeds, and what is worse above them.

    Attributes
    ----------
    above : LimitUse or None
        The worst above the running range, at `place_above`; None where no more of the limit is used there.
    """

    check: LimitCheck
    passed: bool
    above: LimitUse | None
    place_above: str

    @property
    def use(self) -> LimitUse:
        """At running speeds."""
        return self.check.at_running


def worst_of_each(checks: Iterable[LimitCheck]) -> list[WorstPlace]:
    """Return the worst place of each limit."""
    by_limit: dict[str, list[LimitCheck]] = {}
    for check in checks:
        by_limit.setdefault(check.limit.name, []).append(check)
    places = []
    for same in by_limit.values():
        first = max(range(len(same)), key=lambda place: same[place].at_running.used)
        worst, passed = same[first], all(check.passed for check in same[first:])
        uses = [(check.above, check.place) for check in same if check.above is not None]
        above, place = max(uses, key=lambda use: use[0].used, default=(None, ""))
        if above is not None and above.used <= worst.at_running.used:
            above = None
        places.append(WorstPlace(worst, passed, above, place))
    return places


def summary_parts(results: RunResults, units: OutputUnits = SI) -> Iterator[str]:
    """Return what follows from the results of a run, and what the engine is, in one line."""
    for line in conclusions(results):
        yield units.text(f"- {line}")
    yield units.text(f"{results.engine.name}: {'; '.join(engine_facts(results))}.")


# Critical speeds of each kind; --full and the report show more.
SPEEDS_SHOWN = 2


def worst_tables(vibration: EngineVibration, units: OutputUnits = SI) -> Iterator[Table]:
    """Return limits, each at its worst location, and the worst critical speeds."""
    if vibration.assessment is not None:
        yield Table.of_records(
            "Limits, each at its worst location and running speed",
            worst_of_each(vibration.assessment.verdict.checks),
            (
                Column("limit", words=True),
                lambda worst: worst.check.limit.name.removesuffix(f" of {worst.check.place}"),
            ),
            (Column("where", words=True), lambda worst: worst.check.place),
            (Column("at", "1/min", decimals=1), lambda worst: worst.use.speed),
            (Column("reached"), lambda worst: units.text(_apart(worst)[0])),
            (Column("permitted"), lambda worst: units.text(_apart(worst)[1])),
            (Column("used", "%", 3), lambda worst: worst.use.used),
            main=True,
        )
    speeds = speed_table(vibration, units, SPEEDS_SHOWN)
    shown = ["vibration", "speed", "order", "peak at", "amplitude", "kind"]
    if vibration.forced_by_kind is None:
        shown = ["vibration", "speed", "order", "mode", "phase sum"]
    known = [column.name for column in speeds.columns]  # without peaks there are no amplitudes
    if speeds.rows:
        yield replace(speeds.select(*(name for name in shown if name in known)), note="", main=True)


def _apart(worst: WorstPlace) -> tuple[str, str]:
    return reached_and_permitted(worst.use, worst.check.limit.unit)


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


def _frequency(vibration: EngineVibration, kind: str) -> Record:
    elastic = vibration.modes(kind).elastic_modes
    shown = vibration.modes(kind).crankshaft_mode
    first = None if shown is None else shown.frequency
    details = (
        [] if first is None else [f"{significant(60.0 * first, 3)} 1/min, chain of the throws"]
    )
    assessment, whole = vibration.assessment, vibration.whole_crankshaft
    if assessment is not None and shown is not None:
        bounds = assessment.uncertainty[kind].frequencies[shown.number - 1]
        details[0] = f"uncertainty range of the chain {_bounds(bounds.lowest, bounds.highest)}"
    chain = None if whole is None else whole.comparison.chains.get(kind)
    if chain is not None and chain.modes:
        mode = chain.modes[0]
        alike = (mode.shaft_frequency, mode.further_frequency)
        shaft = " and ".join(_hertz(frequency) for frequency in sorted(filter(None, alike)))
        shaft = f"{shaft} Hz" if shaft else "no mode like it"
        # The range over the bearings is that of one mode, the one most alike.
        swept = "" if mode.further_frequency else _swept(vibration, kind)
        details.append(f"whole crankshaft in its bearings: {shaft}{f' ({swept})' if swept else ''}")
    beside = elastic.index(shown) if shown is not None else len(elastic)
    if beside:
        lower = ", ".join(_hertz(mode.frequency) for mode in elastic[:beside])
        details.append(f"lower modes of coupling, damper or line: {lower} Hz")
    return {
        "label": f"First {kind} frequency{' of the crankshaft' if beside else ''}",
        "symbol": None,
        "value": "none" if first is None else _hertz(first),
        "unit": "" if first is None else "Hz",
        "details": details,
    }
