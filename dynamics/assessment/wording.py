"""Sentences of limits, verdicts and findings, made from their fields."""

from collections.abc import Sequence

import numpy as np

from crankbase.quantity import format_quantity, format_usage, quantities_apart
from dynamics.assessment.limits import LimitUse, VibrationLimit

# What a verdict is called; "undecided" and "not judged" are those of a run, not of a `Verdict`.
VERDICTS = {
    "fine": "Fine",
    "barred range needed": "Barred range needed",
    "not acceptable": "Not acceptable",
    "undecided": "Undecided",
    "not judged": "Not judged: no gas pressure is given",
}


def speed_text(speed: float) -> str:
    """Write a speed [rad/s] in 1/min."""
    return format_quantity(speed, "rad/s", 4)


def shown_range(low: float, high: float) -> str:
    """Write a range of speeds [rad/s] in 1/min."""
    return f"{speed_text(low).removesuffix(' 1/min')} to {speed_text(high)}"


def limit_at(name: str, place: str) -> str:
    """Name a limit and where it is assessed; a limit for that location alone already has it in its name."""
    return name if name.endswith(f" of {place}") else f"{name}, {place}"


def use_in_words(
    limit: VibrationLimit, speed: float, value: float, permitted: float, digits: int = 4
) -> str:
    """State the value of a quantity at a speed [rad/s] and the permitted value there."""
    reached, allowed = quantities_apart(value, permitted, limit.unit, digits)
    used = value / permitted
    if np.isinf(value):
        return f"unbounded at {speed_text(speed)}, where {allowed} is permitted"
    most = "at most " if used <= 1.0 else ""
    return (
        f"{most}{reached} at {speed_text(speed)}, {format_usage(used)} of the permitted {allowed}"
    )


def check_sentence(
    limit: VibrationLimit, place: str, worst: LimitUse, running: LimitUse | None, reasons: str
) -> str:
    """State what is reached of a limit at a place, the limit's source and the cause.

    The largest use at all speeds judged; at running speeds too, where that is another one.
    """
    source = limit.source + (", assumed" if limit.assumed else "")
    use = use_in_words(limit, worst.speed, worst.value, worst.permitted)
    if running:
        kept = use_in_words(limit, running.speed, running.value, running.permitted)
        use = f"{kept} at running speeds; above them {use}"
        # The cause is that of one of the two.
        reasons = reasons and f"at {speed_text(worst.speed)}, {reasons}"
    text = f"{limit_at(limit.name, place)}: {use} ({source})."
    return f"{text} {reasons[0].upper()}{reasons[1:]}." if reasons else text


def verdict_headline(status: str, running_range: tuple[float, float], barred: Sequence[str]) -> str:
    """Return a verdict in a few words, with the running range or the ranges to bar."""
    beside = {
        "fine": f" from {shown_range(*running_range)}",
        "barred range needed": f", {', '.join(barred)}",
    }
    return VERDICTS[status] + beside.get(status, "")


def barred_sentence(
    low: float, high: float, position: str, refusals: Sequence[str], full_load: bool
) -> str:
    """State whether a range may be barred or passed, and why not; without its full stop."""
    shown, why = shown_range(low, high), f": {'; '.join(refusals)}" if refusals else ""
    if position == "above":
        return f"{shown}, above the running range{why}"
    passed = f"{shown} is passed on every start"
    if full_load:
        return f"{passed}, without the full load of this calculation, so it is not judged"
    if position == "below":
        return f"{passed}{', too severely' if why else ''}{why}"
    return f"{shown} {'cannot' if why else 'may'} be barred{why}"


def undecided_sentence(why: str) -> str:
    """State that a verdict is undecided, and why."""
    return f"{VERDICTS['undecided']}: {why}."


def conclusion_sentence(verdict: str, deciding: str, undecided: bool) -> str:
    """Join the sentence of a verdict, with the values used, and what decides by assumption, if anything."""
    if undecided:
        return f"{undecided_sentence(deciding)} With the values used, {verdict[0].lower()}{verdict[1:]}"
    return (
        f"{verdict} It depends on assumed or uncertain values: {deciding}." if deciding else verdict
    )


def values_sentence(
    field: str, name: str, why: str, shown: Sequence[str], holds: Sequence[bool], taken: int | None
) -> str:
    """State with which values, ascending, something holds and with which not: the two on either side.

    `taken` is the place of the value used in the calculation, `why` the reason for which others are possible.
    """
    used = "used" if why else "assumed"
    texts = [f"{text} ({used})" if place == taken else text for place, text in enumerate(shown)]
    turns = [place for place in range(1, len(holds)) if holds[place] != holds[place - 1]]
    named = range(turns[0] - 1, turns[0] + 1) if len(turns) == 1 else range(len(holds))
    kept, lost = (
        " or ".join(texts[place] for place in named if holds[place] == side)
        for side in (True, False)
    )
    beside = "" if taken is None or taken in named else f" ({shown[taken]} {used})"
    remedy = f"within {why}, set by" if why else "give"
    article = "an" if name[0] in "aeiou" else "a"
    return f"{article} {name} of {kept}, not with {lost}{beside}: {remedy} {field}"
