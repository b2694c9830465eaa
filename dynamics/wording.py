"""Sentences of limits, verdicts and findings, made from their fields."""

from collections.abc import Mapping, Sequence

import numpy as np

from crankbase.quantity import format_quantity, format_usage, quantities_apart, significant

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


def use_in_words(unit: str, speed: float, value: float, permitted: float, digits: int = 4) -> str:
    """State the value of a quantity at a speed [rad/s] and the permitted value there."""
    reached, allowed = quantities_apart(value, permitted, unit, digits)
    if np.isinf(value):
        return f"unbounded at {speed_text(speed)}, where {allowed} is permitted"
    used = value / permitted
    most = "at most " if used <= 1.0 else ""
    return (
        f"{most}{reached} at {speed_text(speed)}, {format_usage(used)} of the permitted {allowed}"
    )


def check_sentence(
    limit: str, place: str, source: str, speed: float, use: str, running: str, reasons: str
) -> str:
    """State what is reached of a limit at a place, the limit's source and the cause.

    `use` is the largest at all speeds judged, `running` at running speeds, where that is another one.
    """
    if running:
        use = f"{running} at running speeds; above them {use}"
        # The cause is that of one of the two.
        reasons = reasons and f"at {speed_text(speed)}, {reasons}"
    text = f"{limit_at(limit, place)}: {use} ({source})."
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


# Why a range cannot be barred or passed, and what is not known of it.
NO_SPEED_LEFT = "it leaves no speed to run at"
CUT_OFF = "the range reaches the end of the speeds calculated"


def above_running(limit: str, used: float, end: float) -> str:
    """Refuse a range above the running one, by the share of a limit used that applies up to a speed."""
    return (
        f"{limit} reaches {_used(used)} of its limit, which applies up to {speed_text(end)}; the engine does "
        "not run there, so that only less vibration or another critical speed helps"
    )


def too_high(top: float, end: float, rated: float, holds_rated: bool) -> str:
    """Refuse a range by its highest speed, above the end of what may be barred."""
    reaches = (
        f"it holds the rated speed of {speed_text(rated)}"
        if holds_rated
        else f"it reaches {top / rated:.2f} of the rated speed"
    )
    return (
        f"{reaches}, and nothing may be barred above {end / rated:.2f} "
        f"{'of it ' if holds_rated else ''}({speed_text(end)})"
    )


def unbounded_inside(limit: str) -> str:
    """Refuse a range in which vibration is unbounded."""
    return f"the {limit} is unbounded in it"


def no_passing(limit: str) -> str:
    """Remark that a limit states nothing for passing."""
    return f"{limit}: no limit for passing is known"


def too_much(place: str, value: float, passing: float, unit: str, speed: float, others: int) -> str:
    """Refuse a range by what is reached at a place; further places exceed what may be passed, too."""
    reached, passed = (
        "no bounds" if np.isinf(size) else format_quantity(size, unit, 4)
        for size in (value, passing)
    )
    more = "location exceeds" if others == 1 else "locations exceed"
    return (
        f"{place} reaches {reached} at {speed_text(speed)}, where {passed} may be passed"
        f"{f'; {others} more {more} what may be passed' if others else ''}"
    )


def range_ends(
    first: tuple[float, str],
    last: tuple[float, str],
    gaps: bool,
    used: float,
    rated: float,
    peaks: tuple[float | None, float | None],
) -> str:
    """State where limits are exceeded first and last, and about which peaks the rule widens the range."""
    parts = [
        f"limits are exceeded from {speed_text(first[0])} ({first[1]}) to {speed_text(last[0])} "
        f"({last[1]}), {'not throughout, ' if gaps else ''}{_used(used)} is used at most"
    ]
    low, high = peaks
    if low is not None:
        parts.append(f"the range begins at 16 n/(18 - r) below the peak at n = {speed_text(low)}")
    if high is not None:
        parts.append(f"it ends at (18 - r) n/16 above the peak at n = {speed_text(high)}")
    if len(parts) > 1:
        parts.append(f"r is n divided by the rated speed of {speed_text(rated)}")
    return "; ".join(parts)


def _used(share: float) -> str:
    return format_usage(None if np.isinf(share) else share)


NO_MAIN_ORDER = "no order makes a part of it worth naming"
# How an order's state stands to a mode.
STATES = {
    "at resonance": "at the resonance of {}",
    "near resonance": "near the resonance of {}",
    "amplified": "amplified by {}",
    "forced": "forced without resonance",
}


def undamped_order(order: float, mode: str) -> str:
    """State which order makes vibration unbounded."""
    return f"order {order:g} excites {mode}, which nothing damps"


def orders_contribute(
    runs: Sequence[tuple[float, float]],
    state: str,
    mode: str,
    total: float,
    share: float,
    unit: str,
    main: tuple[float, float] | None,
) -> str:
    """State what orders of one state contribute to a peak.

    `runs` are their first and last orders, `share` that of the peak, `main` the contribution of one order
    that makes most of it, and this order.
    """
    texts = [f"{low:g} to {high:g}" if low < high else f"{low:g}" for low, high in runs]
    listed = " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)
    many = len(runs) > 1 or runs[0][0] < runs[0][1]
    text = (
        f"order{'s' if many else ''} {listed}, {STATES[state].format(mode or 'several modes')}, "
        f"{_contribute(total, many)} {peak_text(abs(total), unit)} ({100.0 * share:.0f} %)"
    )
    return f"{text}, {peak_text(main[0], unit)} of it by order {main[1]:g}" if main else text


def others_contribute(rest: float, unit: str) -> str:
    """State what all orders that are not named contribute."""
    return f"all others {_contribute(rest, many=True)} {peak_text(abs(rest), unit)}"


def _contribute(amount: float, many: bool) -> str:
    return ("contribute" if amount >= 0.0 else "subtract") + ("" if many else "s")


def peak_text(amplitude: float, unit: str) -> str:
    """Write the amplitude of a peak, or of a part of it."""
    if np.isinf(amplitude):
        return "unbounded"
    text = format_quantity(amplitude, unit, 3)
    return format_quantity(amplitude, unit, 4) if "e+" in text else text


def chain_mode(kind: str, frequency: float) -> str:
    """Name a mode of a chain by its frequency [Hz]."""
    return f"{kind} mode of the chain at {frequency:.1f} Hz"


def no_mode_alike(name: str) -> str:
    """State that the whole crankshaft lacks a chain's mode."""
    return f"The whole shaft has no mode like the {name}."


def two_modes_alike(name: str, kind: str, modes: Sequence[tuple[float, float]]) -> str:
    """State between which modes a chain's mode is divided: frequencies [Hz] and shares of its kind."""
    both = " and ".join(
        f"{frequency:.1f} Hz ({100.0 * share:.0f} % {kind})" for frequency, share in modes
    )
    return f"The whole shaft has two modes like the {name}: {both}."


def other_frequency(name: str, shaft: float, difference: float, limit: float) -> str:
    """State how far a chain's frequency is from that of the whole crankshaft [Hz]."""
    return (
        f"The {name} differs from that of the whole shaft, at {shaft:.1f} Hz, by "
        f"{100.0 * difference:+.1f} %, more than {100.0 * limit:.0f} %."
    )


def mixed_mode(kind: str, shaft: float, share: float, limit: float) -> str:
    """State how little of a mode of the whole crankshaft [Hz] is of a chain's kind."""
    return (
        f"The whole shaft's mode at {shaft:.1f} Hz is only {100.0 * share:.3g} % {kind}, less than "
        f"{100.0 * limit:.0f} %."
    )


def other_amplitude(kind: str, difference: float, limit: float) -> str:
    """State how far a chain's amplitude is from that of the whole crankshaft."""
    return (
        f"The largest {kind} amplitude of the free end at running speeds differs by "
        f"{100.0 * difference:+.0f} % from that of the whole shaft, more than {100.0 * limit:.0f} %."
    )


def frequency_steps(
    kind: str, mode: int, shaft: float, chain: float, steps: Mapping[str, float], least: float
) -> str:
    """State both frequencies of a mode [Hz] and the steps between them; small ones are told together."""
    text = (
        f"{kind} mode {mode}: {shaft:.1f} Hz by the whole crankshaft, {chain:.1f} Hz by the chain"
    )
    shown = {name: f"{by:+.1f}" for name, by in steps.items() if abs(by) >= least}
    if not shown:
        return text
    difference = round(round(shaft, 1) - round(chain, 1), 1)
    rest = difference - sum(map(float, shown.values()))
    told = [f"{name} {by} Hz" for name, by in shown.items()]
    if abs(rest) >= least:
        told.append(f"rounding and smaller steps {rest:+.1f} Hz")
    return f"{text} ({difference:+.1f} Hz, step by step: {', '.join(told)})"


def tilted_mode(
    kind: str, mode: int, without: float, frequencies: Sequence[float], passed: bool
) -> str:
    """State to which frequencies [Hz] the flywheel's diametral inertia moves a mode."""
    listed = " and ".join(f"{frequency:.1f}" for frequency in frequencies)
    below = " (which brings another mode below it)" if passed else ""
    return f"{kind} mode {mode} from {without:.1f} Hz without to {listed} Hz with it{below}"


def flywheel_tilts(inertia: float, half: bool, moved: Sequence[str]) -> str:
    """State the flywheel's diametral inertia [kg m^2], half of the polar one or not, and what it moves."""
    about = ", half of that about the shaft" if half else ""
    return (
        f"The last step is the flywheel's inertia about a diameter ({significant(inertia, 3)} kg m^2{about}"
        f"); it moves {', '.join(moved) or 'the first frequencies by less than 0.05 Hz'}. In another order "
        "the steps share the same difference otherwise."
    )


def differing_chains(differences: Sequence[str], kind: str) -> str:
    """State how the whole crankshaft differs from its inadequate chains, `kind` being that of the first."""
    which = "which are" if len(differences) > 1 else f"of which the {kind} one is"
    return (
        f"The verdict uses lumped models (chains), {which} inadequate here; the whole crankshaft differs: "
        f"{'; '.join(differences)}."
    )


def chains_alone(reason: str) -> str:
    """State why no whole crankshaft stands beside a verdict."""
    return f"The verdict uses lumped models (chains) alone: {reason}."


def differing_amplitude(kind: str, shaft: str, chain: str) -> str:
    """State both amplitudes of the free end."""
    return f"largest {kind} amplitude of the free end at running speeds {shaft} instead of {chain}"


def differing_mode(
    kind: str, mode: int, chain: float, shaft: float | None, divided: Sequence[float]
) -> str:
    """State what the whole crankshaft has in place of a chain's mode [Hz]."""
    if shaft is None:
        return f"it has no mode like {kind} mode {mode}"
    if divided:
        both = " and ".join(f"{frequency:.1f}" for frequency in divided)
        return f"two modes at {both} Hz instead of {kind} mode {mode} at {chain:.1f} Hz"
    return f"{kind} mode {mode} at {shaft:.1f} instead of {chain:.1f} Hz"


def impure_mode(kind: str, shaft: float | None, share: float) -> str:
    """State the share of its energy that is of a kind."""
    return f"its {kind} mode at {shaft:.1f} Hz is only {100.0 * share:.3g} % {kind}"


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
