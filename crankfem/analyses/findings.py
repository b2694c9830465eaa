"""What a run concludes, in a few sentences: what is reached, why, what may be barred, and what to do."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np

from crankbase.quantity import format_usage, percent
from crankbase.results import Quantity, Result, result
from crankbase.sentences import amount, apart, finished, joined, kept, sentence
from crankbase.table import SI, Main, OutputUnits
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.shaft.chains import MOTION
from crankfem.analyses.vibration.assessment import Assessment
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.reading.toml_file import InputRecord
from dynamics.assessment.limits import LimitUse
from dynamics.assessment.verdict import LimitCheck
from dynamics.indices import within
from dynamics.wording import (
    VERDICTS,
    barring,
    limit_at,
    restricted_while_misfiring,
    share_of_limit,
    shares_of_peak,
)

if TYPE_CHECKING:  # vibration alone has neither
    from crankfem.analyses.self_checks import Check
    from crankfem.analyses.strength.cycle_fatigue import EngineFatigue
    from crankfem.analyses.strength.engine_strength import EngineStrength

RESONANT = ("at resonance", "near resonance")
# Of what orders at resonance make together, the share from which a mode is named.
LEAST_SHARE = 0.1
DIGITS = 3


def headline(vibration: EngineVibration, strength: "EngineStrength | None" = None) -> str:
    """Return the verdict of a run in a few words."""
    words = _of_vibration(vibration)
    if too_weak(strength) and verdict_status(vibration) != "not acceptable":
        words = f"{words}; the crankshaft is not strong enough by UR M53"
    return finished(words)


def verdict_status(vibration: EngineVibration) -> str:
    """Return which of `VERDICTS` vibration comes to with all cylinders firing."""
    assessment = vibration.assessment
    if assessment is None:
        return "not judged"
    return "undecided" if assessment.undecided else assessment.verdict.status


def too_weak(strength: "EngineStrength | None") -> bool:
    """Whether the crankshaft's strength was judged, and is less than required."""
    return strength is not None and strength.passed is False


def _of_vibration(vibration: EngineVibration) -> str:
    assessment, status = vibration.assessment, verdict_status(vibration)
    if assessment is None:
        return VERDICTS[status]
    words, end = kept(assessment.verdict.headline), ""
    if status == "undecided":
        words = f"{words} with the values used"
        end = f"; {VERDICTS[status].lower()}"
        whole, failed = assessment.by_whole_shaft, assessment.verdict.status == "not acceptable"
        if whole is not None and (whole.status == "not acceptable") != failed:
            other = "acceptable" if failed else "not acceptable"
            end = f"{end}, as that is by the lumped model: by the whole crankshaft it is {other}"
    misfiring = misfiring_decides(vibration)
    if assessment.verdict.status == "not acceptable":
        return f"{words}{', also while a cylinder misfires' if misfiring else ''}{end}"
    if misfiring:
        joined = "and" if status == "undecided" else "with"
        normal = f" {joined} all cylinders firing" if assessment.verdict.status == "fine" else ""
        words = f"{words}{normal}; limits are exceeded while a cylinder misfires"
    unjudged = status == "fine" and not _axial_judged(assessment)
    return f"{words}{'; axial vibration is not judged' if unjudged else ''}{end}"


def misfiring_decides(vibration: EngineVibration) -> bool:
    """Whether limits are exceeded while a cylinder misfires, and may be kept with all cylinders firing."""
    assessment, misfiring = vibration.assessment, vibration.misfiring
    if assessment is None or misfiring is None or misfiring.passed:
        return False
    return assessment.verdict.status != "not acceptable" or assessment.undecided


def verdict_line(vibration: EngineVibration, strength: "EngineStrength | None" = None) -> str:
    """Return the verdict of a run in one line: the headline, and the limit that decides."""
    assessment = vibration.assessment
    if assessment is None:
        return f"Verdict: {VERDICTS['not judged']}."
    check = assessment.verdict.deciding
    used = share_of_limit(check.used, passing=check.passing)
    if check.passing:
        used = f"{used} at {speed_shown(check.worst_speed)}"
    status, of = verdict_status(vibration), ""
    if misfiring_decides(vibration):
        of = ". With all cylinders firing"
    elif too_weak(strength) and status != "not acceptable":
        of = ". Vibration"
    shown = kept(headline(vibration, strength))
    return finished(f"Verdict: {shown}{of}: {check.limit.name} {used}.")


# Of the report's first screen.
MOST_FINDINGS, MOST_RANGES = 3, 2


@dataclass(frozen=True)
class Grounds:
    """What findings follow from: vibration, and of a whole run its strength and self-checks besides.

    Attributes
    ----------
    inputs : tuple of InputRecord
        All that was read or assumed.
    highest_order : float
        Of those calculated.
    warnings, warned_fields : tuple of str
        About the input, and the fields that they are about.
    """

    vibration: EngineVibration
    inputs: tuple[InputRecord, ...]
    highest_order: float
    warnings: tuple[str, ...] = ()
    warned_fields: tuple[str, ...] = ()
    strength: "EngineStrength | None" = None
    fatigue: "EngineFatigue | None" = None
    checks: "tuple[Check, ...]" = ()


@result("about", "section")
class Finding(Result):
    """What follows from the results of a run.

    Attributes
    ----------
    about : str
        What it is about, in a word or two.
    section : str
        That of the report which has it in full.
    weight : int
        How much it counts where there is room for few.
    long : tuple of str
        Its sentences.
    short : tuple of str
        What a first screen says of it, a statement each, the main one first; nothing if that stands there
        otherwise.
    rests_on : tuple of str
        What it rests on: limits with their places, checks, or fields of the input.
    """

    about: str
    section: str
    weight: Annotated[int, Quantity("1")]
    long: tuple[str, ...]
    short: tuple[str, ...] = ()
    rests_on: tuple[str, ...] = ()


def vibration_findings(vibration: EngineVibration, file: EngineFile) -> tuple[Finding, ...]:
    """Return the findings of an engine's vibration that was calculated alone; see `findings`."""
    return findings(Grounds(vibration, input_values(file), file.vibration.highest_order))


def main_findings(all_findings: Sequence[Finding]) -> list[tuple[Finding, str]]:
    """Return the main statements in short, each with its finding, the one that counts most first."""
    ranked = sorted(all_findings, key=lambda finding: -finding.weight)
    return [(finding, text) for finding in ranked for text in finding.short][:MOST_FINDINGS]


def finding_parts(all_findings: Iterable[Finding], units: OutputUnits = SI) -> Iterator[Main]:
    """Return findings in full for a console, but for those about checks."""
    for finding in all_findings:
        if finding.long and finding.section != "checks":
            first, *further = (units.written(text, DIGITS) for text in finding.long)
            yield Main(f"- {first}", *further)


def findings(grounds: Grounds) -> tuple[Finding, ...]:
    """Return what follows from the results of a run, or of a vibration.

    Every number of a finding is one of the results, or follows from them as the finding says.

    Returns
    -------
    tuple of Finding
        What looks wrong in the input, what is reached of the limit that decides and where, how the whole
        crankshaft differs, which orders make it, what can help and which speeds may be barred, what
        misfiring does, what decides by assumption and should be given (before the limits if the verdict is
        undecided), what the models leave open, whether the crankshaft is strong enough, and which checks
        fail.
    """
    assessment = grounds.vibration.assessment
    found = [] if assessment is None else _of_assessment(grounds, assessment)
    made = [*_warned(grounds), *(_without_forces(grounds) if assessment is None else found)]
    return tuple(
        replace(
            finding,
            long=tuple(filter(None, finding.long)),
            short=tuple(filter(None, finding.short)),
        )
        for finding in made
        if any(finding.long + finding.short)
    )


def _of_assessment(grounds: Grounds, assessment: Assessment) -> list[Finding]:
    """Return what follows from an assessment; what decides comes first."""
    check, strength = assessment.verdict.deciding, grounds.strength
    place = (limit_at(check.limit.name, check.place),)
    failed, wrong = failed_checks(grounds.checks), _calculation_fails(grounds.checks)
    names = tuple(check.name for check in grounds.checks if check.met is False)
    strong = tuple(own.sentence for own in (strength, grounds.fatigue) if own)
    weak = (strength.sentence,) if strength is not None and too_weak(strength) else ()
    remedy = _remedy(grounds, check)
    helps = (
        *([remedy.sentence] if remedy else []),
        *(f"{kept(span.sentence)}." for span in assessment.verdict.deciding_first),
    )
    assumed = Finding(
        "Assumed",
        "inputs",
        2,
        (*_assumed(grounds, assessment), *_counted(grounds)),
        _assumed(grounds, assessment, reasons=1),
        tuple(dict.fromkeys(trial.field for trial in assessment.decision.trials)),
    )
    misfiring = grounds.vibration.misfiring
    misfires = grounds.vibration.misfiring_note if misfiring is None else misfiring.sentence
    # What is not modeled, and whether the verdict hangs on the bearings; their range stands in both.
    other_models = [*assessment.all_beside[len(assessment.by_whole) :]]
    bearings = grounds.vibration.bearings
    if bearings is not None and bearings.flips:
        other_models += bearings.sentences
    return [
        *([assumed] if assessment.undecided else []),
        Finding("Limits", "limits", 0, (_reached(assessment),), (), place),
        Finding("Whole crankshaft", "whole", 0, _by_whole(grounds.vibration, assessment)),
        Finding("Why", "limits", 5, (_cause(assessment),), (_main_cause(assessment),), place),
        Finding("What helps", "limits", 4, helps, (_measures(grounds, assessment),), place),
        Finding("Misfiring", "limits", 0, (sentence(misfires) if misfires else "",)),
        *([] if assessment.undecided else [assumed]),
        Finding("Models", "whole", 0, tuple(dict.fromkeys(other_models))),
        Finding("Strength", "strength", 6, strong, weak, ("strength",)),
        Finding("Checks", "checks", 7 if wrong else 1, (failed,), (failed,), names),
    ]


def _main_cause(assessment: Assessment) -> str:
    check = assessment.verdict.deciding
    if check.cause is None or not check.cause.parts:
        return ""
    if math.isinf(check.worst_value):
        return _cause(assessment)
    return shares_of_peak(check.worst_speed, check.cause.main_shares[:2])


def _measures(grounds: Grounds, assessment: Assessment) -> str:
    """State in short what can be done where a limit is exceeded."""
    verdict, misfiring = assessment.verdict, grounds.vibration.misfiring
    told = [
        barring(span.low, span.high, span.position, span.allowed)
        for span in verdict.deciding_first
        if span.position == "running" or not span.allowed
    ][:MOST_RANGES]
    remedy = _remedy(grounds, verdict.deciding)
    if remedy is not None:
        told.append(remedy.short)
    elif misfiring is not None and not misfiring.passed:
        told.append(restricted_while_misfiring(misfiring.restriction))
    return " ".join(told)


def speed_shown(speed: float) -> str:
    """Write a speed [rad/s] into a sentence, with the digits of a report."""
    return amount(speed, "rad/s", DIGITS, zeros=True)


def reached_and_permitted(use: LimitUse, unit: str) -> tuple[str, str]:
    """Write what is reached and what is permitted with three digits, or as many as tell them apart.

    Examples
    --------
    >>> tuple(map(finished, reached_and_permitted(LimitUse(100.0, 22.28e6, 22.27e6), "Pa")))
    ('22.28 MPa', '22.27 MPa')
    """
    return apart(use.value, use.permitted, unit, DIGITS)


def _reached(assessment: Assessment) -> str:
    verdict = assessment.verdict
    check, most = verdict.deciding, verdict.checks[0]
    shown = _share(check.at_worst, check.limit.unit, check.passing)
    if not most.in_running_range and most.used > check.used and not check.passing:
        place = "" if most.place == check.place else f"{limit_at(most.limit.name, most.place)}: "
        above = _share(most.at_worst, most.limit.unit)
        shown = f"{shown}; above the running range {place}{above}"
    others = sum(
        not other.passed and (other.limit.name, other.place) != (check.limit.name, check.place)
        for other in verdict.checks
    )
    more = f"; {others} more {'location exceeds' if others == 1 else 'locations exceed'} a limit"
    condition = "With the values used: " if assessment.undecided else ""
    limit = check.limit.name if condition else check.limit.name.capitalize()
    return f"{condition}{limit_at(limit, check.place)}: {shown}{more if others > 0 else ''}."


def _cause(assessment: Assessment) -> str:
    check = assessment.verdict.deciding
    if check.cause is None:
        return ""
    return sentence(f"at {speed_shown(check.worst_speed)}, {kept(check.cause.reasons)}")


def _share(use: LimitUse, unit: str, passing: bool = False) -> str:
    reached, permitted = reached_and_permitted(use, unit)
    at = f"{reached} at {speed_shown(use.speed)}"
    if math.isinf(use.used):
        return f"{at}, permitted is {permitted}"
    of = f"{permitted} that may be passed" if passing else f"permitted {permitted}"
    return f"{at}, {format_usage(use.used)} of the {of}"


def _assumed(
    grounds: Grounds, assessment: Assessment, reasons: int | None = None
) -> tuple[str, ...]:
    """State what decides by assumption, which limits are assumed, what is not judged, and the load.

    `reasons` is how many of those that decide are stated.
    """
    vibration = grounds.vibration
    decision = joined("; ", assessment.decision.reasons[:reasons])
    if decision and misfiring_decides(vibration):
        decision = f"with all cylinders firing, {decision}"
    statements = [sentence(decision)] if decision else []
    statements += [
        f"The limit on {limit.name} is assumed ({limit.source}): give the maker's."
        for limit in assessment.judged_limits
        if limit.assumed
    ]
    if not _axial_judged(assessment):
        statements.append(
            f"Axial vibration{_axial_amplitude(grounds)} is not judged: give limits.axial_amplitude or "
            "limits.axial_force."
        )
    if vibration.load is not None and not vibration.load.rated.consistent:
        statements.append(sentence(vibration.load.rated.sentence))
    return tuple(statements)


def _counted(grounds: Grounds) -> tuple[str, ...]:
    """State how many inputs are assumed, if any."""
    count = sum(record.assumed for record in grounds.inputs)
    return (f"{count} of {len(grounds.inputs)} inputs are assumed.",) if count else ()


def _axial_judged(assessment: Assessment) -> bool:
    return any(limit.kind == "axial" for limit in assessment.judged_limits)


def _axial_amplitude(grounds: Grounds) -> str:
    """Tell the largest axial amplitude of the free end at running speeds, where it was calculated."""
    forced = grounds.vibration.forced_of("axial")
    if forced is None:
        return ""
    inside = within(forced.speeds, *grounds.vibration.running_range)
    if not np.any(inside):
        return ""
    reached = forced.free_end_motion.synthesis[inside]
    worst = reached.size - 1 - int(np.argmax(reached[::-1]))
    axial, value = MOTION["axial"], float(reached[worst])
    amplitude = amount(value, axial.si, DIGITS, zeros=True, shown=axial.printed)
    return f" ({amplitude} at the free end at {speed_shown(float(forced.speeds[inside][worst]))})"


def failed_checks(checks: "Sequence[Check]") -> str:
    """Name the self-checks that fail, and whether the calculation itself holds; nothing if all hold."""
    judged = [check for check in checks if check.met is not None]
    failed = [check for check in judged if not check.met]
    if not failed:
        return ""
    # What has no allowed figure compares two models: frequencies, shares and amplitudes decide together.
    one_fails = len(failed) == 1
    told = f"{len(failed)} of {len(judged)} checks {'fails' if one_fails else 'fail'}:"
    if not _calculation_fails(checks):
        what = "it compares a chain" if one_fails else "they compare the chains"
        return f"{told} {what} with the whole crankshaft; the calculation passes all others."
    named = [
        f"{check.name[0].lower()}{check.name[1:]}"
        + (
            ""
            if check.allowed is None
            else f", {check.figure_text} (allowed: {check.allowed_text})"
        )
        for check in failed
    ]
    return f"{told} {'; '.join(named)}."


def _calculation_fails(checks: "Sequence[Check]") -> bool:
    """Whether a check of the calculation itself fails: one with an allowed figure."""
    return any(check.met is False and check.allowed is not None for check in checks)


def _by_whole(vibration: EngineVibration, assessment: Assessment) -> tuple[str, ...]:
    """State how the whole crankshaft differs from the chains, also in the force on the thrust bearing."""
    found, force = [*assessment.by_whole], vibration.thrust
    if found and force is not None and force.running and force.running_whole:
        chain, shaft = (
            f"{amount(largest.amplitude, 'N', DIGITS)} at {speed_shown(largest.speed)}"
            for largest in (force.running, force.running_whole)
        )
        found.append(
            f"Largest force amplitude on the thrust bearing at running speeds: {shaft} by the whole "
            f"crankshaft, {chain} by the chain."
        )
    whole = vibration.whole_crankshaft
    for kind, criticals in ({} if whole is None else whole.criticals).items():
        running = [
            peak
            for peak in criticals.peaks
            if peak.in_running_range and peak.value and not math.isinf(peak.value)
        ]
        if not running:
            continue
        worst = max(running, key=lambda peak: peak.value)
        damping = worst.damping_ratio
        found.append(
            f"Its largest {kind} critical speed in the running range: order {worst.order:g} at "
            f"{speed_shown(worst.speed)}, {amount(worst.value, worst.unit, DIGITS)} at {worst.place}"
            + (f", damping {percent(damping, 2)} %." if damping else ".")
        )
    return tuple(found)


@dataclass(frozen=True)
class Remedy:
    """What can help at a place where a limit is exceeded.

    Attributes
    ----------
    resonant, rest, permitted : str
        What the orders at or near resonance contribute, what the others leave at least, and the limit.
    enough : bool
        Whether more damping may be sufficient.
    modes : str
        That make the resonances.
    undamped : str
        Remark that there is no damper.
    speed : str
        At which it is.
    """

    resonant: str
    rest: str
    permitted: str
    enough: bool
    modes: str
    undamped: str
    speed: str

    @property
    def sentence(self) -> str:
        """What remains without resonance, and what follows."""
        without = (
            f"Orders at or near resonance contribute {self.resonant} in all; the others leave at least "
            f"{self.rest}, {'less' if self.enough else 'more'} than the permitted {self.permitted}"
        )
        return f"{without}: {self.short[0].lower()}{self.short[1:]}"

    @property
    def short(self) -> str:
        """What follows alone."""
        if not self.enough:
            return (
                "More damping alone is not sufficient. Reduce the other orders' excitation, or strengthen "
                "the shaft."
            )
        return (
            f"More damping{self.undamped}, or another frequency of {self.modes}, may be sufficient at "
            f"{self.speed}."
        )


def _remedy(grounds: Grounds, worst: LimitCheck) -> Remedy | None:
    """Return whether more damping can help where the limit that decides is exceeded.

    What the orders away from resonance make at the instant of the peak, their sum reaches at least; so where
    that alone exceeds the limit, no damping keeps it.
    """
    cause = worst.cause
    if worst.passed or cause is None or math.isinf(worst.worst_value) or not cause.parts:
        return None
    resonant = [part for part in cause.parts if part.state in RESONANT]
    made = sum(part.contribution for part in resonant)
    # Together they may counteract the peak; its half range without the others is at least their size.
    left = replace(worst.at_worst, value=abs(worst.worst_value - made))
    rest, permitted = reached_and_permitted(left, worst.limit.unit)
    together, _ = reached_and_permitted(replace(left, value=made), worst.limit.unit)
    least = LEAST_SHARE * made
    modes = sorted({(part.kind, part.mode) for part in resonant if part.contribution > least})
    named = " and ".join(f"{kind} mode {mode}" for kind, mode in modes)
    enough = left.value <= worst.permitted
    sections = {record.field.partition(".")[0] for record in grounds.inputs}
    undamped = ""
    torsional = any(kind == "torsional" for kind, _ in modes)
    if torsional and not sections & {"torsional_damper", "shaft_line"}:
        undamped = " (the file has no torsional damper)"
    speed = speed_shown(worst.worst_speed)
    return Remedy(together, rest, permitted, enough, named, undamped, speed)


def _warned(grounds: Grounds) -> list[Finding]:
    """Name the input that looks wrong, and state how formulas were used as sources."""
    made, count, fields = [], len(grounds.warnings), grounds.warned_fields
    if count:
        noun = "1 warning" if count == 1 else f"{count} warnings"
        about = f" about {', '.join(fields)}" if fields else ""
        made.append((f"Check the input: {noun}{about} (report: Inputs and assumptions).", fields))
    chains = (grounds.vibration.axial, grounds.vibration.torsional)
    made += [(sentence(chain.formula_note), ()) for chain in chains if chain.formula_note]
    return [Finding("Input", "inputs", 3, (text,), (text,), on) for text, on in made]


def _without_forces(grounds: Grounds) -> list[Finding]:
    vibration = grounds.vibration
    count = len(vibration.axial.criticals) + len(vibration.torsional.criticals)
    one = count == 1
    calculated = (
        "Amplitudes and stresses are not calculated, so nothing can be compared with limits.",
    )
    counted = (
        f"{count} critical speed{'' if one else 's'} of orders up to {grounds.highest_order:g} "
        f"{'is' if one else 'are'} in the running range.",
    )
    wanted = ("Add a section [gas] to the engine file to define the excitation.",)
    return [
        Finding("Why", "inputs", 0, calculated, calculated, ("gas",)),
        Finding("Critical speeds", "campbell", 2, counted, counted),
        Finding("Assumed", "inputs", 0, _counted(grounds)),
        Finding("What helps", "inputs", 1, wanted, wanted, ("gas",)),
    ]
