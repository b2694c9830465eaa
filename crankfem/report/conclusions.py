"""What a run concludes, in a few sentences: what is reached, why, what may be barred, and what to do."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from crankbase.quantity import UNBOUNDED, format_usage, quantities_apart, significant
from crankfem.analyses.run_results import Check, RunResults
from crankfem.analyses.shaft.chains import MOTION
from crankfem.report.text_filters import (
    check_limit_text,
    check_value_text,
    quantity,
    range_sentence,
    sentence,
    with_three_digits,
)
from dynamics.wording import VERDICTS, limit_at

if TYPE_CHECKING:
    from crankfem.analyses.strength.engine_strength import EngineStrength

Record = Mapping[str, Any]
RESONANT = ("at resonance", "near resonance")
# Of what orders at resonance make together, the share from which a mode is named.
LEAST_SHARE = 0.1
DIGITS = 3


def headline(vibration: Record, strength: "EngineStrength | None" = None) -> str:
    """Return the verdict of a run in a few words."""
    words = _of_vibration(vibration)
    if too_weak(strength) and verdict_status(vibration) != "not acceptable":
        return f"{words}; the crankshaft is not strong enough by UR M53"
    return words


def verdict_status(vibration: Record) -> str:
    """Return which of `VERDICTS` a vibration record comes to with all cylinders firing."""
    assessment = vibration["assessment"]
    if assessment is None:
        return "not judged"
    return "undecided" if undecided(assessment) else str(assessment["status"])


def too_weak(strength: "EngineStrength | None") -> bool:
    """Whether the crankshaft's strength was judged, and is less than required."""
    return strength is not None and strength.passed is False


def _of_vibration(vibration: Record) -> str:
    assessment = vibration["assessment"]
    status = verdict_status(vibration)
    words = VERDICTS[status]
    if assessment is None:
        return words
    if status != "undecided":
        words = assessment["headline"]
    misfiring = misfiring_decides(vibration)
    if assessment["status"] == "not acceptable":
        exceeded = "; with the values used, limits are exceeded, also while a cylinder misfires"
        return f"{words}{exceeded}" if misfiring else words
    if misfiring:
        normal = " with all cylinders firing" if status == "fine" else ""
        words = f"{words}{normal}; limits are exceeded while a cylinder misfires"
    unjudged = status == "fine" and not _axial_judged(assessment)
    return f"{words}; axial vibration is not judged" if unjudged else words


def misfiring_decides(vibration: Record) -> bool:
    """Whether limits are exceeded while a cylinder misfires, and may be kept with all cylinders firing."""
    assessment, failing = vibration["assessment"], vibration["misfiring"]
    fails = failing is not None and failing["passed"] is False
    return fails and (assessment["status"] != "not acceptable" or undecided(assessment))


def undecided(assessment: Record) -> bool:
    """Whether the verdict changes with values that are assumed."""
    return bool(assessment["decision"]["status"] == "undecided")


def verdict_line(vibration: Record, strength: "EngineStrength | None" = None) -> str:
    """Return the verdict of a run in one line: the headline, and the limit that is used most."""
    assessment = vibration["assessment"]
    if assessment is None:
        return f"Verdict: {VERDICTS['not judged']}."
    worst = assessment["worst"]
    used = "unbounded" if worst["used"] is None else f"{format_usage(worst['used'])} of its limit"
    status, of = verdict_status(vibration), ""
    if misfiring_decides(vibration):
        of = ". With all cylinders firing"
    elif too_weak(strength) and status != "not acceptable":
        of = ". Vibration"
    elif status == "undecided":
        of = ". With the values used"
    return f"Verdict: {headline(vibration, strength)}{of}: {worst['limit']} {used}."


def conclusions(results: RunResults) -> list[str]:
    """Return what follows from the results of a run, in at most eight statements.

    Every number of a statement is one of the results, or follows from them as the statement says.

    Returns
    -------
    list of str
        What looks wrong in the input, what is reached of the limit used most and where, how the whole
        crankshaft differs, which orders make it and what can help, which speeds may be barred, what
        misfiring does, what decides by assumption and should be given (before the limits if the verdict
        is undecided), what the models leave open, and whether the crankshaft is strong enough.
    """
    assessment = results.vibration["assessment"]
    if assessment is None:
        return [*_warned(results), *_without_forces(results)]
    cause = assessment["worst"]["cause"]
    # What decides comes first.
    assumed, open_ = _assumed(results), undecided(assessment)
    found = [
        *_warned(results),
        assumed if open_ else "",
        _reached(assessment),
        _by_whole(results.vibration),
        " ".join(filter(None, ("" if cause is None else _cause(assessment), _advice(results)))),
        " ".join(_ranges(assessment)),
        _misfiring(results.vibration),
        "" if open_ else assumed,
        _other_models(results.vibration),
        " ".join(own.sentence for own in (results.strength, results.fatigue) if own),
    ]
    return [one for one in found if one]


def reached_and_permitted(check: Record) -> tuple[str, str]:
    """Write what is reached and what is permitted with three digits, or as many as tell them apart.

    Parameters
    ----------
    check : mapping
        One of the checks of an assessment's record.

    Examples
    --------
    >>> reached_and_permitted({"value": 22.28e6, "permitted": 22.27e6, "unit": "Pa"})
    ('22.28 MPa', '22.27 MPa')
    """
    value, permitted, unit = check["value"], check["permitted"], check["unit"]
    if value is None:
        return quantity(value, unit), quantity(permitted, unit, DIGITS)
    return quantities_apart(value, permitted, unit, DIGITS)


def _reached(assessment: Record) -> str:
    worst, most = assessment["worst"], assessment["checks"][0]
    running = worst["running"]
    shown = _share(worst, worst["unit"])
    if worst["speed_rpm"] != most["speed_rpm"] and not most["in_running_range"]:
        place = (
            "" if most["place"] == worst["place"] else f"{limit_at(most['limit'], most['place'])}: "
        )
        shown = f"{shown}; above the running range {place}{_share(most, most['unit'])}"
    elif running is not None and not worst["in_running_range"]:
        shown = f"{_share(running, worst['unit'])}; above the running range {shown}"
    failed = sum(not one["passed"] for one in assessment["checks"])
    others = failed - 1
    more = f"; {others} more {'location exceeds' if others == 1 else 'locations exceed'} a limit"
    condition = "With the values used: " if undecided(assessment) else ""
    limit = worst["limit"] if condition else worst["limit"].capitalize()
    return f"{condition}{limit_at(limit, worst['place'])}: {shown}{more if others > 0 else ''}."


def _cause(assessment: Record) -> str:
    worst = assessment["worst"]
    return sentence(
        f"at {significant(worst['speed_rpm'], DIGITS)} 1/min, {worst['cause']['sentence']}"
    )


def _share(found: Record, unit: str) -> str:
    reached, permitted = reached_and_permitted({"unit": unit, **found})
    at = f"{reached} at {significant(found['speed_rpm'], DIGITS)} 1/min"
    if found["used"] is None:
        return f"{at}, permitted is {permitted}"
    return f"{at}, {format_usage(found['used'])} of the permitted {permitted}"


def _ranges(assessment: Record) -> list[str]:
    return [
        f"{range_sentence(one)}." for one in (*assessment["barred"], *assessment["started_through"])
    ]


def _assumed(results: RunResults) -> str:
    """State what decides by assumption, which limits are assumed, what is not judged, and the load."""
    vibration, inputs = results.vibration, results.inputs
    assessment = vibration["assessment"]
    limits = assessment["limits"]
    decision = assessment["decision"]["sentence"]
    if decision and misfiring_decides(vibration):
        decision = f"with all cylinders firing, {decision}"
    found = [sentence(decision)] if decision else []
    found += [
        f"The limit on {one['name']} is assumed ({one['source']}): give the maker's."
        for one in limits
        if one["assumed"]
    ]
    if not _axial_judged(assessment):
        found.append(
            f"Axial vibration{_axial_amplitude(results)} is not judged: give limits.axial_amplitude or "
            "limits.axial_force."
        )
    load = vibration["load"]
    if load is not None and load["rated"] is not None and not load["rated"]["consistent"]:
        found.append(sentence(load["rated"]["sentence"]))
    count = sum(record.assumed for record in inputs)
    if count:
        found.append(f"{count} of {len(inputs)} inputs are assumed.")
    return " ".join(found)


def _axial_judged(assessment: Record) -> bool:
    return any(one["name"].startswith("axial") for one in assessment["limits"])


def _axial_amplitude(results: RunResults) -> str:
    """Tell the largest axial amplitude of the free end at running speeds, where it was calculated."""
    found = (results.vibration["forced"] or {}).get("axial")
    if found is None:
        return ""
    low, high = (results.engine[f"{end}_speed_rpm"] for end in ("lowest", "highest"))
    reached = [
        (math.inf if value is None else value, rpm)
        for value, rpm in zip(found["free_end"]["synthesis"], found["speeds_rpm"], strict=True)
        if low * (1.0 - 1e-9) <= rpm <= high * (1.0 + 1e-9)
    ]
    if not reached:
        return ""
    value, rpm = max(reached)
    own = MOTION["axial"]
    amplitude = UNBOUNDED if math.isinf(value) else f"{own.number(value, DIGITS)} {own.printed}"
    return f" ({amplitude} at the free end at {significant(rpm, DIGITS)} 1/min)"


def _misfiring(vibration: Record) -> str:
    """State what misfiring does, or why it was not calculated."""
    found = vibration["misfiring"]
    said = vibration["misfiring_note"] if found is None else found["sentence"]
    return with_three_digits(sentence(said)) if said else ""


def failed_checks(checks: Sequence[Check]) -> str:
    """Name the self-checks that fail, and whether the calculation itself holds; nothing if all hold."""
    judged = [check for check in checks if check.met is not None]
    failed = [check for check in judged if not check.met]
    if not failed:
        return ""
    # What has no allowed figure compares two models: frequencies, shares and amplitudes decide together.
    one_fails = len(failed) == 1
    told = f"{len(failed)} of {len(judged)} checks {'fails' if one_fails else 'fail'}:"
    if all(check.allowed is None for check in failed):
        what = "it compares a chain" if one_fails else "they compare the chains"
        return f"{told} {what} with the whole crankshaft; the calculation passes all others."
    named = [
        f"{check.name[0].lower()}{check.name[1:]}"
        + (
            ""
            if check.allowed is None
            else f", {check_value_text(check)} (allowed: {check_limit_text(check)})"
        )
        for check in failed
    ]
    return f"{told} {'; '.join(named)}."


def _by_whole(vibration: Record) -> str:
    """State how the whole crankshaft differs from the chains, also in the force on the thrust bearing."""
    found = [*vibration["assessment"]["by_whole"]]
    force = vibration["axial_force"] or {}
    models = list(filter(None, (force.get(name) for name in ("running", "running_whole"))))
    if found and len(models) == 2:
        chain, whole = (
            f"{quantity(one['amplitude'], 'N', DIGITS)} at {significant(one['speed_rpm'], DIGITS)} 1/min"
            for one in models
        )
        found.append(
            f"Largest force amplitude on the thrust bearing at running speeds: {whole} by the whole "
            f"crankshaft, {chain} by the chain."
        )
    criticals = (vibration["whole"] or {"criticals": {}})["criticals"]
    for kind, told in criticals.items():
        running = [one for one in told["peaks"] if one["in_running_range"] and one["value"]]
        if not running:
            continue
        worst = max(running, key=lambda one: float(one["value"]))
        damping = worst["damping_ratio"]
        found.append(
            f"Its largest {kind} critical speed in the running range: order {worst['order']:g} at "
            f"{significant(worst['speed_rpm'], DIGITS)} 1/min, "
            f"{quantity(worst['value'], worst['unit'], DIGITS)} at {worst['place']}"
            + (f", damping {100.0 * damping:.2g} %." if damping else ".")
        )
    return with_three_digits(" ".join(found))


def _other_models(vibration: Record) -> str:
    """State what is not modeled, and whether the verdict hangs on the bearings."""
    bearings, assessment = vibration["bearings"], vibration["assessment"]
    found = [text for text in assessment["beside"] if text not in assessment["by_whole"]]
    found += bearings["sentences"] if bearings is not None and bearings["flips"] else ()
    return with_three_digits(
        " ".join(dict.fromkeys(found))
    )  # the range of the bearings stands in both


def _advice(results: RunResults) -> str:
    """Return whether more damping can help at the worst place, where a limit is exceeded.

    What the orders away from resonance make at the instant of the peak, their sum reaches at least; so where
    that alone exceeds the limit, no damping keeps it.
    """
    worst = results.vibration["assessment"]["worst"]
    cause = worst["cause"]
    if worst["passed"] or cause is None or worst["value"] is None or not cause["orders"]:
        return ""
    resonant = [one for one in cause["orders"] if one["state"] in RESONANT]
    made = sum(one["contribution"] for one in resonant)
    # Together they may counteract the peak; its half range without the others is at least their size.
    left = {**worst, "value": abs(worst["value"] - made)}
    rest, permitted = reached_and_permitted(left)
    together, _ = reached_and_permitted({**worst, "value": made})
    without = f"Orders at or near resonance contribute {together} in all; the others leave at least {rest}, "
    if left["value"] > worst["permitted"]:
        return (
            f"{without}more than the permitted {permitted}: more damping alone is not sufficient. Reduce "
            "the excitation by these orders, or strengthen the shaft."
        )
    least = LEAST_SHARE * made
    modes = sorted({(one["kind"], one["mode"]) for one in resonant if one["contribution"] > least})
    named = " and ".join(f"{kind} mode {mode}" for kind, mode in modes)
    return (
        f"{without}less than the permitted {permitted}: more damping{_undamped(modes, results)}, or "
        f"another frequency of {named}, may be sufficient at this speed."
    )


def _undamped(modes: Sequence[tuple[str, int]], results: RunResults) -> str:
    """Remark that there is no torsional damper, where a torsional mode is at resonance."""
    fields = [record.field.partition(".")[0] for record in results.inputs]
    if "torsional_damper" in fields or "shaft_line" in fields:
        return ""
    return (
        " (the file has no torsional damper)" if any(one[0] == "torsional" for one in modes) else ""
    )


def _warned(results: RunResults) -> list[str]:
    """Name the input that looks wrong."""
    warnings = results.input_warnings
    fields = dict.fromkeys(warning.partition(":")[0] for warning in warnings)
    if not fields:
        return []
    noun = "1 warning" if len(warnings) == 1 else f"{len(warnings)} warnings"
    return [f"Check the input: {noun} about {', '.join(fields)} (report: Inputs and assumptions)."]


def _without_forces(results: RunResults) -> list[str]:
    engine, vibration = results.engine, results.vibration
    count = sum(len(vibration[kind]["criticals"]) for kind in ("axial", "torsional"))
    inputs = results.inputs
    assumed = sum(record.assumed for record in inputs)
    one = count == 1
    return [
        "Amplitudes and stresses are not calculated, so nothing can be compared with limits.",
        f"{count} critical speed{'' if one else 's'} of orders up to {engine['highest_order']:g} "
        f"{'is' if one else 'are'} in the running range.",
        *([f"{assumed} of {len(inputs)} inputs are assumed."] if assumed else []),
        "Add a section [gas] to the engine file to define the excitation.",
    ]
