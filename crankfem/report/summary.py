"""The first screen of a report: the verdict, what follows, the limits, and the key figures."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from crankbase.quantity import format_usage, significant
from crankbase.sentences import amount, finished, joined, kept, listed
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.findings import (
    DIGITS,
    headline,
    main_findings,
    misfiring_decides,
    reached_and_permitted,
    speed_shown,
    too_weak,
)
from crankfem.analyses.record import Record
from crankfem.analyses.vibration.assessment import Assessment, factor_range
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.tables import CriticalLine, critical_lines, speed_table
from crankfem.files.engine.mechanism_cylinders import order_named
from dynamics.assessment.limits import LimitUse
from dynamics.assessment.verdict import LimitCheck
from dynamics.engine.layout import repeating_intervals
from dynamics.wording import at_speed, cylinders_named, limit_at, speed_range

if TYPE_CHECKING:
    from crankfem.analyses.run_results import RunResults

KINDS = ("axial", "torsional")


def summary(results: "RunResults") -> Record:
    """Return what the first screen of a report says.

    Returns
    -------
    dict
        "facts" (of the engine), "status" ("fine", "barred", "bad" or "open"), "headline", "tiles", "plot"
        (the names of those that decide, the best first), "findings" (of `main_findings`), "found" (all of
        them in full, by section), "limits", "frequencies", "uncertain" (a sentence by kind).
    """
    vibration = results.vibration
    assessment = vibration.assessment
    known = {"fine": "fine", "not acceptable": "bad"}
    status = "open" if assessment is None else known.get(assessment.verdict.status, "barred")
    if assessment is not None and (assessment.undecided or misfiring_decides(vibration)):
        status = "barred"
    if too_weak(results.strength):
        status = "bad"
    # Limits that only misfiring exceeds.
    by_misfiring = misfiring_decides(vibration) and (
        assessment is None or assessment.verdict.status != "not acceptable"
    )
    by_section: dict[str, list[str]] = {}
    for finding in results.findings:
        if finding.long:
            text = finished(joined(" ", finding.long))
            by_section.setdefault(finding.section, []).append(text)
    return {
        "facts": engine_facts(results),
        "status": status,
        "headline": headline(results.vibration, results.strength),
        "tiles": tiles(results),
        "plot": (
            *(("misfiring_stress",) if by_misfiring else ()),
            *("deciding", "torsional_stress", "torsional_campbell"),
        ),
        "findings": main_findings(results.findings),
        "found": by_section,
        "limits": [] if assessment is None else worst_of_each(assessment.verdict.checks),
        "frequencies": [_frequency(vibration, kind) for kind in KINDS],
        "uncertain": {}
        if assessment is None
        else {kind: uncertain_sentence(vibration, assessment, kind) for kind in KINDS},
    }


def tiles(results: "RunResults") -> list[Record]:
    """Return at most six figures that sum up a run.

    Returns
    -------
    list of dict
        "label", "value", "details" (a line each), "section" (of the report) and "mark" ("over" or "").
    """
    vibration = results.vibration
    assessment = vibration.assessment
    made = (
        None if assessment is None else _deciding_use(assessment),
        _first_frequencies(vibration),
        _worst_critical(vibration),
        None if assessment is None or results.engine.driven_by else _misfiring(vibration),
        None if assessment is None else _whole(vibration, assessment),
        _assumed_inputs(results),
    )
    return [
        {
            "label": label,
            "value": finished(value),
            "details": list(map(finished, details)),
            "section": section,
            "mark": mark,
        }
        for label, value, details, section, mark in filter(None, made)
    ]


Tile = tuple[str, str, list[str], str, str]


def _deciding_use(assessment: Assessment) -> Tile:
    check, most = assessment.verdict.deciding, assessment.verdict.checks[0]
    reached, permitted = reached_and_permitted(check.at_worst, check.limit.unit)
    may = f"{permitted} may be passed" if check.passing else f"permitted {permitted}"
    details = [
        limit_at(check.limit.name, check.place),
        f"{reached} at {speed_shown(check.worst_speed)}, {may}",
    ]
    if most.worst_speed != check.worst_speed and not most.in_running_range:
        details.append(
            f"above the running range {format_usage(most.used)} at {speed_shown(most.worst_speed)}"
        )
    passed = check.passed and all(other.passed for other in assessment.verdict.checks)
    label = "Deciding use of a limit"
    return label, format_usage(check.used), details, "limits", "" if passed else "over"


def _first_frequencies(vibration: EngineVibration) -> Tile:
    values: list[float | None] = []
    details = []
    for kind in KINDS[::-1]:
        modes = vibration.modes(kind)
        first, mode = modes.first_mode, modes.crankshaft_mode
        values.append(None if first is None else first.frequency)
        known = []
        if mode is not None and mode is not first:
            known.append(f"{_hertz(mode.frequency)} is the crankshaft's own first")
        if mode is not None and vibration.assessment is not None:
            bounds = vibration.assessment.uncertainty[kind].frequencies[mode.number - 1]
            known.append(_bounds(bounds.lowest, bounds.highest))
        if swept := _swept(vibration, kind):
            # Of a mode that is divided the part most alike; all stand with the mode shapes.
            known.append(f"whole crankshaft {swept[0]}")
        if known:
            number = f" mode {mode.number}" if mode is not None and mode.number > 1 else ""
            details.append(f"{kind}{number} {'; '.join(known)}")
    label = "First torsional / axial frequency"
    # With one unit behind both.
    texts = [
        "none"
        if value is None
        else amount(value, "Hz", 3, zeros=True, bare=value is not values[-1])
        for value in values
    ]
    return label, " / ".join(texts), details, "modes", ""


def _worst_critical(vibration: EngineVibration) -> Tile:
    label = "Worst critical speed"
    every = [line for kind in KINDS for line in critical_lines(vibration, kind) if line.speed]
    running = vibration.running_range
    lines = [line for line in every if not line.passed(running)]
    worst = _of_the_deciding(vibration, every)
    if worst is None and not lines:
        return label, "none", ["in the running range"], "campbell", ""
    if worst is None:
        # One without a margin to the running speeds, if any.
        worst = max(
            lines,
            key=lambda line: (line.margin is not None and not line.margin.margin, line.strength),
        )
    assert worst.speed is not None
    modes = ", ".join(map(str, worst.modes))
    details = [f"{worst.vibration}, order {worst.order:g}, mode {modes}"]
    peak, margin = worst.peak, worst.margin
    if peak is not None and np.isfinite(peak.limit_used):
        passing = " for passing" if worst.passed(running) else ""
        details.append(f"this order alone: {format_usage(peak.limit_used)} of a limit{passing}")
    if worst.passed(running):
        details.append("below the running range, passed on every start")
    if margin is not None:
        ends = listed((margin.low, margin.high), "rad/s", DIGITS, " to ", zeros=True)
        reach = f"uncertainty range {ends}"
        left = f"margin {significant(100.0 * margin.margin, 2)} %" if margin.margin else "no margin"
        details.append(f"{left}; {reach}")
    return label, speed_shown(worst.speed), details, "campbell", ""


def _of_the_deciding(
    vibration: EngineVibration, lines: Sequence[CriticalLine]
) -> CriticalLine | None:
    """Return the critical speed of the order that makes most of what decides, if a mode amplifies it."""
    check = None if vibration.assessment is None else vibration.assessment.verdict.deciding
    if check is None or check.cause is None or not check.cause.parts:
        return None
    main = max(check.cause.parts, key=lambda part: part.contribution)
    if main.state == "forced":
        return None
    made = [
        line
        for line in lines
        if (line.vibration, line.order) == (main.kind, main.order) and main.mode in line.modes
    ]
    return min(made, key=lambda line: abs((line.speed or 0.0) - check.worst_speed), default=None)


def _misfiring(vibration: EngineVibration) -> Tile | None:
    misfiring, label = vibration.misfiring, "While a cylinder misfires"
    if misfiring is None or not misfiring.checks:
        return label, "not calculated", [], "limits", ""
    most = max(misfiring.checks, key=lambda check: check.misfiring.used)
    reached = most.misfiring
    details = [
        f"{cylinders_named(most.cylinders)}: {limit_at(most.quantity, reached.place)}",
        f"at {speed_shown(reached.speed)}; all cylinders firing {format_usage(most.normal.used)}",
    ]
    if misfiring.exceeded:
        count, span = len(misfiring.exceeded), (misfiring.exceeded[0][0], misfiring.exceeded[-1][1])
        parts = f"in {count} ranges " if count > 1 else ""
        ends = speed_range(*span)
        details[1:] = [f"at {speed_shown(reached.speed)}; limits are exceeded {parts}from {ends}"]
    over = "" if misfiring.passed else "over"
    return label, f"{format_usage(reached.used)} of a limit", details, "limits", over


def _whole(vibration: EngineVibration, assessment: Assessment) -> Tile | None:
    whole, judged = vibration.whole_crankshaft, assessment.by_whole_shaft
    if whole is None or not whole.comparison.chains:
        return None
    label, chains = "By the whole crankshaft", whole.comparison.chains
    inadequate = [kind for kind, chain in chains.items() if not chain.suffices]
    if not inadequate:
        return label, "the same", ["the lumped models (chains) are adequate"], "whole", ""
    details = [f"the lumped model (chain) is inadequate: {' and '.join(inadequate)}"]
    if judged is None:
        value = f"{' and '.join(inadequate)} differ{'s' * (len(inadequate) == 1)}"
        return label, value, [*details, "limits are judged by the chain"], "whole", ""
    worst = judged.checks[0]
    same = judged.status == assessment.verdict.status
    details = [
        f"at {speed_shown(worst.worst_speed)}, {worst.place}; {'the same' if same else 'another'} verdict",
        *details,
    ]
    over = "" if worst.passed else "over"
    return label, f"{format_usage(worst.used)} of a limit", details, "whole", over


def _assumed_inputs(results: "RunResults") -> Tile:
    assessment, inputs = results.vibration.assessment, results.inputs
    count, details = sum(record.assumed for record in inputs), []
    if assessment is not None:
        status = assessment.verdict.status
        fields = [trial.field for trial in assessment.decision.trials if trial.status != status]
        decides = ", ".join(dict.fromkeys(fields))
        details.append(
            f"the verdict changes with {decides}"
            if decides
            else "the verdict is the same with all other values tried"
        )
    if warnings := len(results.input_warnings):
        details.append(f"{warnings} warning{'' if warnings == 1 else 's'} of the input: check it")
    over = "over" if warnings else ""
    return "Assumed inputs", f"{count} of {len(inputs)}", details, "inputs", over


def engine_facts(results: "RunResults") -> list[str]:
    """Say what the engine is, a phrase each: its layout, size, speeds, pressure and firing order."""
    engine, mechanism = results.engine, results.mechanism
    count = engine.cylinders
    arranged = "in V" if engine.v_engine else "in line"
    running = speed_range(engine.lowest_speed, engine.highest_speed)
    piston = amount(engine.mean_piston_speed, "m/s", 3, zeros=True)
    facts = [
        f"{count} cylinder{'' if count == 1 else 's'} {arranged}, {engine.strokes}-stroke",
        f"bore {exactly(engine.bore, 'm')}, stroke {exactly(engine.stroke, 'm')}",
        f"{running}, rated speed {at_speed(engine.rated_speed)} (mean piston speed {piston})",
    ]
    if mechanism is not None:
        sense, taken = (-1.0, " taken") if engine.driven_by else (1.0, "")
        facts.append(
            f"indicated power {amount(sense * mechanism.power, 'W', 3)}{taken}, mean indicated pressure "
            f"{amount(sense * mechanism.mean_indicated_pressure, 'Pa', 3)}"
        )
    if engine.driven_by:
        facts.append(
            f"driven by {'an' if engine.driven_by == 'engine' else 'a'} {engine.driven_by}"
        )
    if count > 1:
        intervals = engine.firing_intervals_deg
        steps = repeating_intervals(intervals)
        each = listed(np.radians(steps).tolist(), "rad", 4)
        in_turn = " in turn" if len(steps) < len(intervals) else ""
        evenness = "evenly every" if len(steps) == 1 else "unevenly, at intervals of"
        facts.append(
            f"{order_named(engine.driven_by)} {'-'.join(map(str, engine.firing_order))}, "
            f"{evenness} {each}{'' if len(steps) == 1 else in_turn}"
        )
    return list(map(finished, facts))


def exactly(value: float, unit: str) -> str:
    """Write a value that was given, with all of its digits."""
    return amount(value, unit, exact=True)


def uncertain_sentence(vibration: EngineVibration, assessment: Assessment, kind: str) -> str:
    """State what is uncertain of one kind of vibration, and what that does to the crankshaft's first mode."""
    uncertain = assessment.uncertainty[kind]
    spreads = [
        f"{spread.name} {factor_range(spread)} the value used" for spread in uncertain.spreads
    ]
    if vibration.bearings is not None:
        spreads.append(kept(vibration.bearings.stiffness_range))
    sentence = f"Uncertainty of {kind} vibration: {'; '.join(spreads) or 'not known'}."
    first = vibration.modes(kind).crankshaft_mode
    if first is None:
        return finished(sentence)
    bounds = uncertain.frequencies[first.number - 1]
    reach = _bounds(bounds.lowest, bounds.highest)
    sentence += f" First natural frequency of the crankshaft itself {reach} by the chain"
    swept = _swept(vibration, kind)
    if swept:
        sentence += f", {' and '.join(swept)} by the whole crankshaft over this stiffness"
    return finished(f"{sentence}.")


def _bounds(lowest: float, highest: float) -> str:
    same = significant(lowest, DIGITS) == significant(highest, DIGITS)
    ends = (lowest,) if same else (lowest, highest)
    return listed(ends, "Hz", DIGITS, " to ", zeros=True)


def _swept(vibration: EngineVibration, kind: str) -> list[str]:
    """First frequency of the whole crankshaft over the stiffness of its bearings; none if not calculated.

    Of a mode that is divided, both parts, the part most alike first.
    """
    swept = vibration.bearings
    if swept is None or kind not in swept.shaft:
        return []
    modes = [swept.shaft[kind], *swept.further[kind]]
    known = [mode[np.isfinite(mode)] for mode in modes]
    if len(known[0]) < 2:
        return []
    return [_bounds(float(min(frequency)), float(max(frequency))) for frequency in known]


def _hertz(value: float) -> str:
    return amount(value, "Hz", DIGITS, zeros=True)


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
            (Column("reached"), lambda worst: units.written(_apart(worst)[0])),
            (Column("permitted"), lambda worst: units.written(_apart(worst)[1])),
            (Column("used", "%", 3), lambda worst: worst.use.used),
            main=True,
        )
    speeds = speed_table(vibration, units, SPEEDS_SHOWN)
    shown = ["vibration", "speed", "range", "order", "peak at", "amplitude", "limit used", "margin"]
    if vibration.forced_by_kind is None:
        shown = ["vibration", "speed", "range", "order", "mode", "phase sum"]
    known = [column.name for column in speeds.columns]  # without peaks there are no amplitudes
    if speeds.rows:
        yield replace(speeds.select(*(name for name in shown if name in known)), note="", main=True)


def _apart(worst: WorstPlace) -> tuple[str, str]:
    return reached_and_permitted(worst.use, worst.check.limit.unit)


def _frequency(vibration: EngineVibration, kind: str) -> Record:
    modes = vibration.modes(kind)
    first, shown = modes.first_mode, modes.crankshaft_mode
    details = []
    if first is not None:
        details.append(f"{speed_shown(2.0 * np.pi * first.frequency)}, chain of the throws")
    assessment, whole = vibration.assessment, vibration.whole_crankshaft
    if first is not None and assessment is not None:
        bounds = assessment.uncertainty[kind].frequencies[first.number - 1]
        details[0] = f"uncertainty range of the chain {_bounds(bounds.lowest, bounds.highest)}"
    if first is not None and first is not shown:
        details.append("a mode of coupling, damper or line")
    if shown is not None and first is not shown:
        own = _hertz(shown.frequency)
        if assessment is not None:
            bounds = assessment.uncertainty[kind].frequencies[shown.number - 1]
            own += f" ({_bounds(bounds.lowest, bounds.highest)})"
        details.append(f"the crankshaft's own first, mode {shown.number}: {own}")
    chain = None if whole is None else whole.comparison.chains.get(kind)
    if chain is not None and chain.modes:
        mode = chain.modes[0]
        alike = (mode.shaft_frequency, mode.further_frequency)
        frequencies = sorted(filter(None, alike))
        shaft = listed(frequencies, "Hz", DIGITS, " and ", zeros=True) or "no mode like it"
        # The range over the bearings is that of one mode, the one most alike.
        swept = [] if mode.further_frequency else _swept(vibration, kind)
        over = f" ({' and '.join(swept)})" if swept else ""
        details.append(f"whole crankshaft in its bearings: {shaft}{over}")
    return {
        "label": f"First {kind} frequency",
        "value": "none" if first is None else finished(_hertz(first.frequency)),
        "details": list(map(finished, details)),
        "section": "",
        "mark": "",
    }
