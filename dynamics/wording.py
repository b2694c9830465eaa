"""Sentences of limits, verdicts and findings, made from their fields."""

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from crankbase.array_checks import Array
from crankbase.quantity import format_usage, percent
from crankbase.sentences import amount, apart, capital, joined, kept, listed, written

SpeedRanges = Sequence[tuple[float, float]]
# What a verdict is called; "undecided" and "not judged" are those of a run, not of a `Verdict`.
VERDICTS = {
    "fine": "Acceptable",
    "barred range needed": "Barred range needed",
    "not acceptable": "Not acceptable",
    "undecided": "Undecided",
    "not judged": "Not judged: no gas pressure is given",
}


def at_speed(speed: float) -> str:
    """Write a speed [rad/s] into a sentence."""
    return amount(speed, "rad/s", 4)


def speed_range(low: float, high: float) -> str:
    """Write a range of speeds [rad/s] into a sentence."""
    return listed((low, high), "rad/s", 4, " to ")


def shown_range(low: float, high: float) -> str:
    """Write a range of speeds [rad/s] in 1/min."""
    return written(speed_range(low, high))


def frequency_text(frequency: float, *, exact: bool = False) -> str:
    """Write a frequency [Hz] into a sentence; an exact one keeps its digits, so that steps add up."""
    return amount(frequency, "Hz", decimals=1, exact=exact)


def limit_at(name: str, place: str) -> str:
    """Name a limit and where it is assessed; a limit for that location alone already has it in its name."""
    return name if name.endswith(f" of {place}") else f"{name}, {place}"


def use_in_words(
    unit: str,
    speed: float,
    value: float,
    permitted: float,
    digits: int = 4,
    *,
    passing: bool = False,
) -> str:
    """State the value of a quantity at a speed [rad/s] and the permitted value there, or that for passing."""
    reached, allowed = apart(value, permitted, unit, digits)
    if np.isinf(value):
        may = "may be passed" if passing else "is permitted"
        return f"unbounded at {at_speed(speed)}, where {allowed} {may}"
    used = value / permitted
    most = "at most " if used <= 1.0 else ""
    of = f"{allowed} that may be passed" if passing else f"permitted {allowed}"
    return f"{most}{reached} at {at_speed(speed)}, {format_usage(used)} of the {of}"


def share_of_limit(used: float, *, passing: bool) -> str:
    """Write the share of a limit that is used: of that for running, or of that for passing."""
    if np.isinf(used):
        return "unbounded"
    return f"{format_usage(used)} of {'what may be passed' if passing else 'its limit'}"


def check_sentences(
    limit: str,
    source: str,
    speed: float,
    use: str,
    running: str,
    reasons: str,
    *,
    above_alone: bool = False,
) -> tuple[str, ...]:
    """State what is reached of a limit, with the limit's source, and the cause, if it is known.

    `use` is the largest at all speeds judged, `running` at running speeds, where that is another one. Where
    the limit is exceeded above the running range alone, that comes first.
    """
    use, running, reasons = kept(use), kept(running), kept(reasons)
    if running:
        use = (
            f"above the running range {use}; at running speeds {running}"
            if above_alone
            else f"{running} at running speeds; above them {use}"
        )
        # The cause is that of one of the two.
        reasons = reasons and f"at {at_speed(speed)}, {reasons}"
    text = f"{limit}: {use} ({source})."
    return (text, f"{capital(reasons)}.") if reasons else (text,)


def verdict_headline(status: str, running_range: tuple[float, float], barred: Sequence[str]) -> str:
    """Return a verdict in a few words, with the running range or the ranges to bar."""
    beside = {
        "fine": f" from {speed_range(*running_range)}",
        "barred range needed": f", {joined(', ', barred)}",
    }
    return VERDICTS[status] + beside.get(status, "")


def barred_sentence(
    low: float, high: float, position: str, refusals: Sequence[str], full_load: bool
) -> str:
    """State whether a range may be barred or passed, and why not; without its full stop."""
    shown, why = speed_range(low, high), f": {joined('; ', refusals)}" if refusals else ""
    if position == "above":
        return f"{shown}, above the running range{why}"
    passed = f"{shown} is passed on every start"
    if full_load:
        return f"{passed}, without the full load of this calculation, so it is not judged"
    if position == "below":
        return f"{passed}{', too severely' if why else ''}{why}"
    return f"{shown} {'cannot' if why else 'can'} be barred{why}"


# Why a range cannot be barred or passed, and what is not known of it.
NO_SPEED_LEFT = "it leaves no speed to run at"
CUT_OFF = "the range reaches the end of the speeds calculated"


def above_running(limit: str, used: float, end: float) -> str:
    """Refuse a range above the running one, by the share of a limit used that applies up to a speed."""
    return (
        f"{limit} reaches {_used(used)} of its limit, which applies up to {at_speed(end)}; the engine does "
        "not run there, so that only less vibration or another critical speed helps"
    )


def too_high(top: float, end: float, rated: float, holds_rated: bool) -> str:
    """Refuse a range by its highest speed, above the end of what may be barred."""
    reaches = (
        f"it holds the rated speed of {at_speed(rated)}"
        if holds_rated
        else f"it reaches {top / rated:.2f} of the rated speed"
    )
    return (
        f"{reaches}, and nothing may be barred above {end / rated:.2f} "
        f"{'of it ' if holds_rated else ''}({at_speed(end)})"
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
        "no bounds" if np.isinf(size) else amount(size, unit, 4) for size in (value, passing)
    )
    more = "location exceeds" if others == 1 else "locations exceed"
    return (
        f"{place} reaches {reached} at {at_speed(speed)}, where {passed} may be passed"
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
        f"limits are exceeded from {at_speed(first[0])} ({first[1]}) to {at_speed(last[0])} "
        f"({last[1]}), {'not throughout, ' if gaps else ''}{_used(used)} is used at most"
    ]
    low, high = peaks
    if low is not None:
        parts.append(f"the range begins at 16 n/(18 - r) below the peak at n = {at_speed(low)}")
    if high is not None:
        parts.append(f"it ends at (18 - r) n/16 above the peak at n = {at_speed(high)}")
    if len(parts) > 1:
        parts.append(f"r is n divided by the rated speed of {at_speed(rated)}")
    return "; ".join(parts)


def narrow_between(low: float, high: float) -> str:
    """Remark that two ranges to be barred leave too little between them [rad/s]."""
    return f"{shown_range(low, high)}, between two ranges to be barred, is too narrow to run in"


def begins_below(low: float, begins: float) -> str:
    """State from where a range is passed that begins below the running range; nothing if it does not."""
    if begins <= low:
        return ""
    return f"; from {at_speed(low)} to the lowest running speed it is passed on every start"


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
    many = len(runs) > 1 or runs[0][0] < runs[0][1]
    text = (
        f"{orders_named(runs, state, mode)}, {_contribute(total, many)} {peak_text(abs(total), unit)} "
        f"({100.0 * share:.0f} %)"
    )
    return f"{text}, {peak_text(main[0], unit)} of it by order {main[1]:g}" if main else text


def orders_named(runs: Sequence[tuple[float, float]], state: str, mode: str) -> str:
    """Name orders by their first and last ones, with their common state."""
    texts = [f"{low:g} to {high:g}" if low < high else f"{low:g}" for low, high in runs]
    named = " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)
    many = len(runs) > 1 or runs[0][0] < runs[0][1]
    return f"order{'s' if many else ''} {named}, {STATES[state].format(mode or 'several modes')}"


def shares_of_peak(speed: float, shares: Sequence[tuple[str, float]]) -> str:
    """State which orders make most of a peak at a speed [rad/s], with their shares."""
    named = "; ".join(f"{orders}: {100.0 * share:.0f} %" for orders, share in shares)
    more = round(100.0 * (sum(share for _, share in shares) - 1.0))
    less = f"; all others subtract {more} %" if more > 0 else ""
    return f"At {amount(speed, 'rad/s', 3, zeros=True)}, {named} of the amplitude{less}."


def barring(low: float, high: float, position: str, allowed: bool) -> str:
    """State whether speeds [rad/s] may be barred or passed, without the reasons."""
    shown = speed_range(low, high)
    if position == "above":
        return f"{shown}, above the running range, exceeds a limit."
    if position == "below":
        return f"{shown} is passed on every start{'' if allowed else ', too severely'}."
    return f"{shown} {'can' if allowed else 'cannot'} be barred."


def restricted_while_misfiring(restriction: str) -> str:
    """State at which speeds to run while a cylinder misfires, by `restricted_running`."""
    return f"While a cylinder misfires, {kept(restriction)}."


def restricted_running(advised: SpeedRanges, remaining: SpeedRanges, otherwise: SpeedRanges) -> str:
    """State at which speeds to run while misfiring: `advised` of those that remain, [rad/s].

    `otherwise` are speeds at which limits are exceeded, or which are to be barred, with normal firing too.
    """
    if not remaining:
        return "no running speed keeps the limits"
    if not advised:
        low, high = max(remaining, key=lambda span: span[1] / span[0])
        count = len(remaining)
        some = (
            f"{count} ranges too narrow to run in, the widest"
            if count > 1
            else "a range too narrow to run in,"
        )
        return f"limits are kept only in {some} {speed_range(low, high)}"
    narrower = len(remaining) - len(advised)
    left = f" (and {narrower} too narrow to run in)" if narrower else ""
    too = "is" if len(otherwise) == 1 else "are"
    apart = (
        f"; {_ranges(otherwise)} {too} not to be run in with all cylinders firing either"
        if otherwise
        else ""
    )
    return f"restrict running to {_ranges(advised)}{left}{apart}"


def others_contribute(rest: float, unit: str) -> str:
    """State what all orders that are not named contribute."""
    return f"all others {_contribute(rest, many=True)} {peak_text(abs(rest), unit)}"


def _contribute(amount: float, many: bool) -> str:
    return ("contribute" if amount >= 0.0 else "subtract") + ("" if many else "s")


def peak_text(amplitude: float, unit: str) -> str:
    """Write the amplitude of a peak, or of a part of it."""
    return amount(amplitude, unit, 3)


def chain_mode(kind: str, frequency: float) -> str:
    """Name a mode of a chain by its frequency [Hz]."""
    return f"{kind} mode of the chain at {frequency_text(frequency)}"


def no_mode_alike(name: str) -> str:
    """State that the whole crankshaft lacks a chain's mode."""
    return f"The whole shaft has no mode like the {name}."


def two_modes_alike(name: str, kind: str, modes: Sequence[tuple[float, float]]) -> str:
    """State between which modes a chain's mode is divided: frequencies [Hz] and shares of its kind."""
    both = " and ".join(
        f"{frequency_text(frequency)} ({100.0 * share:.0f} % {kind})" for frequency, share in modes
    )
    return f"The whole shaft has two modes like the {name}: {both}."


def other_frequency(name: str, shaft: float, difference: float, limit: float) -> str:
    """State how far a chain's frequency is from that of the whole crankshaft [Hz]."""
    return (
        f"The {name} differs from that of the whole shaft, at {frequency_text(shaft)}, by "
        f"{100.0 * difference:+.1f} %, more than {100.0 * limit:.0f} %."
    )


def mixed_mode(kind: str, shaft: float, share: float, limit: float) -> str:
    """State how little of a mode of the whole crankshaft [Hz] is of a chain's kind."""
    return (
        f"The whole shaft's mode at {frequency_text(shaft)} is only {percent(share, 3)} % {kind}, less than "
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
        f"{kind} mode {mode}: {frequency_text(shaft, exact=True)} by the whole crankshaft, "
        f"{frequency_text(chain, exact=True)} by the chain"
    )
    large = {name: round(by, 1) for name, by in steps.items() if abs(by) >= least}
    if not large:
        return text
    difference = round(round(shaft, 1) - round(chain, 1), 1)
    rest = difference - sum(large.values())
    if abs(rest) >= least:
        large["rounding and smaller steps"] = rest
    each = ", ".join(f"{name} {_change(by)}" for name, by in large.items())
    return f"{text} ({_change(difference)}, step by step: {each})"


def _change(by: float) -> str:
    """Write the change of a frequency [Hz]."""
    return amount(by, "Hz", decimals=1, signed=True, exact=True)


def tilted_mode(
    kind: str, mode: int, without: float, frequencies: Sequence[float], passed: bool
) -> str:
    """State to which frequencies [Hz] the flywheel's diametral inertia moves a mode."""
    moved = listed(frequencies, "Hz", between=" and ", decimals=1, exact=True)
    below = " (which brings another mode below it)" if passed else ""
    return f"{kind} mode {mode} from {frequency_text(without, exact=True)} without to {moved} with it{below}"


def flywheel_tilts(inertia: float, half: bool, moved: Sequence[str]) -> str:
    """State the flywheel's diametral inertia [kg m^2], half of the polar one or not, and what it moves."""
    about = ", half of that about the shaft" if half else ""
    least = amount(0.05, "Hz")
    return (
        "The last step is the flywheel's inertia about a diameter "
        f"({amount(inertia, 'kg m^2', 3, zeros=True)}{about}); it moves "
        f"{joined(', ', moved) or f'the first frequencies by less than {least}'}. In another order the steps "
        "share the same difference otherwise."
    )


def differing_chains(differences: Sequence[str], kind: str) -> str:
    """State how the whole crankshaft differs from its inadequate chains, `kind` being that of the first."""
    which = "which are" if len(differences) > 1 else f"of which the {kind} one is"
    return (
        f"The verdict uses lumped models (chains), {which} inadequate here; the whole crankshaft differs: "
        f"{joined('; ', differences)}."
    )


# Of the chain that stands beside them.
ADEQUATE = "The lumped model is adequate."
INADEQUATE = "Lumped model inadequate; the section on the whole crankshaft gives the reasons."


def adequate_chain(kind: str) -> str:
    """State that a chain is an adequate model of the whole crankshaft."""
    return f"The {kind} chain is an adequate lumped model of the whole crankshaft."


def inadequate_chain(kind: str) -> str:
    """State that it is not; the reasons follow."""
    return f"Lumped model inadequate ({kind} chain):"


def chains_alone(reason: str) -> str:
    """State why no whole crankshaft stands beside a verdict."""
    return f"The verdict uses lumped models (chains) alone: {reason}."


WITHOUT_PLANT = (
    "the torsional chain is the maker's for the whole plant (shaft_line.plant), not one of the "
    "file's throws: the whole crankshaft, made of these, is without the plant and judged by no limit"
)


LINE_WITHOUT_BENDING = (
    "the shaft line is one without bending, because no single piece of shaft follows its first node: it does "
    "not hold the flywheel against tilting"
)


def line_bends(
    length: float,
    bearings: Sequence[tuple[float, float]],
    given_places: bool,
    given_stiffness: bool,
    per_diameter: float,
    without: Sequence[str],
) -> tuple[str, ...]:
    """State how a shaft line bends, what of its bearings is assumed, and what its bodies are without."""
    places = joined(", ", [amount(place, "m") for place, _ in bearings])
    stiffness = amount(max((stiffness for _, stiffness in bearings), default=0.0), "N/m", 3)
    beside = "" if given_places else "assumed to be "
    held = (
        f"on bearings {beside}{places} from there, of {stiffness} each"
        if bearings
        else "without bearings"
    )
    remarks = [f"the shaft line bends over {amount(length, 'm')} from the flywheel on, {held}"]
    if not given_places:
        remarks.append(
            "its spans are assumed as equal, and as long as classification societies allow; give "
            "shaft_line.bearings"
        )
    if bearings and not given_stiffness:
        remarks.append(
            f"its bearings are assumed to have {amount(per_diameter, 'N/m')} per m of its least diameter; "
            "give shaft_line.bearing_stiffness"
        )
    if without:
        remarks.append(
            f"bodies on it have no {' and no '.join(without)}, as no chain of that kind is given"
        )
    return tuple(remarks)


def without_propeller(node: str) -> str:
    """State why the whole crankshaft is not judged: a propeller's forces act on another node."""
    return (
        f"the propeller's forces act on {node}, not behind the flywheel: the whole crankshaft is without "
        "them and judged by no limit"
    )


def differing_amplitude(kind: str, shaft: str, chain: str) -> str:
    """State both amplitudes of the free end."""
    shaft, chain = kept(shaft), kept(chain)
    return f"largest {kind} amplitude of the free end at running speeds {shaft} instead of {chain}"


def differing_mode(
    kind: str, mode: int, chain: float, shaft: float | None, divided: Sequence[float]
) -> str:
    """State what the whole crankshaft has in place of a chain's mode [Hz]."""
    if shaft is None:
        return f"it has no mode like {kind} mode {mode}"
    if divided:
        both = listed(divided, "Hz", between=" and ", decimals=1)
        return f"two modes at {both} instead of {kind} mode {mode} at {frequency_text(chain)}"
    both = listed((shaft, chain), "Hz", between=" instead of ", decimals=1)
    return f"{kind} mode {mode} at {both}"


def impure_mode(kind: str, shaft: float | None, share: float) -> str:
    """State the share of its energy that is of a kind."""
    at = "none" if shaft is None else frequency_text(shaft)
    return f"its {kind} mode at {at} is only {percent(share, 3)} % {kind}"


def whole_use(
    use: str, apart: Iterable[str], beside: str, agrees: bool, status: str, ranges: Sequence[str]
) -> str:
    """State what the whole crankshaft uses of limits, `beside` what the chains use, and its status.

    `apart` names limits that are judged by the axial chain alone.
    """
    told = "".join(f" ({name} by the axial chain alone)" for name in apart)
    verdict = "the same verdict" if agrees else "another verdict"
    return (
        f"The whole crankshaft held against the same limits{told}: {use}"
        f"{f' (by the chains {beside})' if beside else ''}; with the values used, {verdict}, "
        f'"{status}"{"".join(f" ({kept(shown)})" for shown in ranges)}.'
    )


def by_one_model(by_chains: bool) -> str:
    """State that a verdict is acceptable by the chains alone, or by the whole crankshaft alone."""
    by = ("the lumped model", "the whole crankshaft")
    yes, no = by if by_chains else by[::-1]
    return (
        f"acceptable by {yes}, not by {no}: rely on the whole crankshaft, and give bearings.stiffness and "
        "flywheel.diametral_inertia, which decide its modes"
    )


def _frequencies(values: Array) -> str:
    """Write the range of frequencies [Hz]."""
    low, high = (round(float(end), 1) for end in (np.nanmin(values), np.nanmax(values)))
    return (
        frequency_text(low)
        if low == high
        else listed((low, high), "Hz", between=" to ", decimals=1)
    )


def stiffness_range(lowest: float, highest: float) -> str:
    """Write a range of stiffness [N/m] into a sentence."""
    return listed((lowest, highest), "N/m", 3, " to ")


def first_frequencies(
    kind: str,
    mode: int,
    chain: Array | None,
    shaft: Array | None,
    others: Iterable[Array],
) -> str:
    """State the frequencies of a mode over the bearings' range [Hz]; empty where there are none.

    The mode is the crankshaft's own first, with its number in the chain.
    """
    moved = [
        f"{_frequencies(curve)} by the {by}"
        for by, curve in (("chain", chain), ("whole crankshaft", shaft))
        if curve is not None and np.any(np.isfinite(curve))
    ]
    if not moved:
        return ""
    parts = " and ".join(map(_frequencies, others))
    first = f"first {kind} frequency"
    if mode != 1:
        first = f"{kind} mode {mode}, the crankshaft's own first,"
    return (
        f"{first} {', '.join(moved)}{f'; modes that are {kind} in part: {parts}' if parts else ''}"
    )


def over_bearings(lowest: float, highest: float, assumed: bool, frequencies: Iterable[str]) -> str:
    """State the range of the main bearings' stiffness [N/m] and what first frequencies do over it."""
    return (
        f"Main bearings of {stiffness_range(lowest, highest)}{' (assumed)' if assumed else ''}: "
        f"{joined('; ', filter(None, frequencies))}."
    )


def limits_over_bearings(
    used: Mapping[str, Array],
    beyond: Collection[str],
    statuses: Sequence[str],
    stiffness: Array,
) -> str:
    """State the shares of limits used over the bearings' range, and where the verdict changes."""
    uses = []
    for name, shares in used.items():
        low, high = (f"{100.0 * float(end):.0f}" for end in (np.nanmin(shares), np.nanmax(shares)))
        span = low if low == high else f"{low} to {high}"
        above = ", above the running range included" if name in beyond else ""
        uses.append(f"{span} % ({name}{above})")
    places = range(len(statuses))
    starts = [place for place in places if place == 0 or statuses[place] != statuses[place - 1]]
    ends = [*(start - 1 for start in starts[1:]), len(statuses) - 1]
    told = ", ".join(
        f'"{statuses[start]}" at '
        + (
            stiffness_range(stiffness[start], stiffness[end])
            if end > start
            else amount(stiffness[start], "N/m", 3)
        )
        for start, end in zip(starts, ends, strict=True)
    )
    change = (
        f"the verdict changes within this range: {told}"
        if len(starts) > 1
        else f'with all other values as used, the verdict is "{statuses[0]}" over all of it'
    )
    return f"Over that range, the share of the limit used is {', '.join(uses)}; {change}."


def force_on_thrust_bearing(
    speed: float, lowest: float, highest: float, mean_left_out: bool
) -> str:
    """State the axial force [N] on the thrust bearing over the cycle."""
    left_out = ", without the propeller's mean thrust" if mean_left_out else ""
    return (
        f"Axial force on the thrust bearing at {at_speed(speed)}, with vibration: "
        f"{_forces(lowest, highest)} over the cycle by the axial chain, positive towards the "
        f"flywheel{left_out}."
    )


def largest_thrust(by_model: Mapping[str, tuple[float, float]]) -> str:
    """State amplitude [N] and speed of the largest force on the thrust bearing, by each model's name."""
    largest = "; ".join(
        f"{amount(force, 'N', 3, shown='kN')} by the {model}, at {at_speed(speed)}"
        for model, (force, speed) in by_model.items()
    )
    return f"Its largest amplitude at running speeds, for which the bearing is to be checked: {largest}."


def force_on_held_ends(speed: float, lowest: float, highest: float) -> str:
    """State the axial force [N] on held ends over the cycle."""
    return (
        "For comparison with static formulas only: with both ends of the crankshaft held and no vibration, "
        f"the ends would carry {_forces(lowest, highest)} over the cycle at {at_speed(speed)}, "
        "positive where the shaft pushes them apart. A single thrust bearing carries none of this force."
    )


def _forces(lowest: float, highest: float) -> str:
    return " to ".join(amount(force, "N", 3, shown="kN") for force in (lowest, highest))


def cylinders_named(cylinders: Sequence[int]) -> str:
    """Name cylinders, such as "cylinder 4" or "cylinders 3, 5"."""
    return f"cylinder{'' if len(cylinders) == 1 else 's'} {', '.join(map(str, cylinders))}"


def amount_at(value: float, unit: str, speed: float) -> str:
    """Write the value of a quantity, and its speed [rad/s]."""
    return f"{amount(value, unit, 3)} at {at_speed(speed)}"


def use_while_misfiring(limit: str, cylinders: Sequence[int], use: str, normal: str) -> str:
    """State the use of a limit at its place while cylinders misfire, beside that of normal firing."""
    return f"With {cylinders_named(cylinders)} misfiring, {limit}: {use}; with all cylinders firing {normal}"


def normal_share(used: float, permitted: float, beside: float, unit: str) -> str:
    """Write the share of a limit used, with the limit where another one stands beside it; inf for none."""
    shown, other = (amount(value, unit, 3) for value in (permitted, beside))
    same = written(shown) == written(other)
    return f", {format_usage(used)}{'' if same else f' of the permitted {shown}'}"


def other_limit(value: float, other: float, unit: str, basis: str) -> str:
    """Write the share of the limit that does not decide, and on what basis that for passing does."""
    share = "" if np.isinf(value) else f"{format_usage(value / other)} of "
    shown = f"{share}the {amount(other, unit, 3)}"
    if basis:
        return (
            f" for passing, which serves while a cylinder misfires by {basis}, {shown} permitted "
            "continuously"
        )
    return f", {shown} that may be passed"


def exceeded_alone(use: str, kept_at: float | None, reasons: str) -> str:
    """State what misfiring alone exceeds, and why; normal firing keeps the limit at that speed [rad/s]."""
    within = "" if kept_at is None else f", but within its limit at {at_speed(kept_at)}"
    return f"{use}{within}: exceeded by misfiring alone. {capital(reasons)}."


def speeds_while_misfiring(
    cylinders: Sequence[int], exceeded: SpeedRanges, restriction: str
) -> str:
    """State where limits are exceeded while cylinders misfire, those named or any, and where to run then."""
    who = cylinders_named(cylinders) if cylinders else "a cylinder"
    return (
        f"While {who} misfires, limits are exceeded from {_ranges(exceeded)}: {kept(restriction)}."
    )


def _ranges(ranges: SpeedRanges) -> str:
    shown = [speed_range(low, high) for low, high in ranges]
    return " and ".join(filter(None, (", ".join(shown[:-1]), shown[-1])))


def misfiring_assumed(
    cases: Sequence[Sequence[int]], missing_share: float, compression: bool, basis: str
) -> tuple[str, str]:
    """State what misfires, and by which limits it is judged."""
    turns = f"each of {len(cases)} cylinders in turn"
    which = cylinders_named(cases[0]) if len(cases) == 1 else turns
    still = "compression stays" if compression else "compression is missing as well"
    deciding = (
        f"the limit for passing serves where stated, by {basis}, elsewhere the continuous one"
        if basis
        else "the limits of continuous running decide; those for passing serve only where the class or the "
        "maker says so, with limits.passing_while_misfiring"
    )
    return (
        f"misfiring of {which}: {percent(missing_share, 3)} % of the combustion is missing, {still}; the "
        "others fire as before, so the mean torque is lower",
        f"while misfiring, {deciding}; only running speeds are judged",
    )


def conclusion_sentences(
    verdict: Sequence[str], deciding: Sequence[str], undecided: bool
) -> tuple[str, ...]:
    """Join the sentences of a verdict, with the values used, and what decides by assumption, if anything."""
    why = joined("; ", deciding)
    if undecided:
        first, *further = map(kept, verdict)
        used = f"With the values used, {first[0].lower()}{first[1:]}"
        return (f"{VERDICTS['undecided']}: {why}.", used, *further)
    return (*verdict, *([f"It depends on assumed or uncertain values: {why}."] if why else ()))


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
    holding, failing = (
        " or ".join(texts[place] for place in named if holds[place] == side)
        for side in (True, False)
    )
    beside = "" if taken is None or taken in named else f" ({shown[taken]} {used})"
    remedy = f"within {why}, set by" if why else "give"
    article = "an" if name[0] in "aeiou" else "a"
    return f"{article} {name} of {holding}, not with {failing}{beside}: {remedy} {field}"
