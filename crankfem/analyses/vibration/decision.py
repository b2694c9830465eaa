"""Whether the verdict holds for other possible values of the assumptions."""

from collections.abc import Callable, Iterable
from dataclasses import replace

from crankfem.analyses.assumptions import is_assumed
from crankfem.analyses.shaft.chains import ASSUMED, magnifier_of
from crankfem.analyses.vibration.engine_limits import (
    Findings,
    Limited,
    engine_limits,
    engine_verdict,
    limit_findings,
    strengths,
)
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.limits_sections import LimitsInput
from dynamics.assessment.limit_rules import BASE_STRENGTH, BASE_YIELD, CRANKSHAFT_STRENGTHS
from dynamics.assessment.verdict import Decision, Status, Trial, changes, decide

# Magnifiers that are tried beside the one assumed, as shares of it: 25 and 60 of 40. An order of magnitude.
MAGNIFIER_SHARES = (0.625, 1.5)
TENSILE, YIELD = "tensile_strength", "yield_strength"
# Yield strengths are tried up to this share of a given tensile strength.
HIGHEST_YIELD = 0.7
# [Pa] The change of a verdict between two strengths is told to this.
STRENGTH_STEP = 1e6

Answers = tuple[Limited, Limited]
Judged = Callable[[float], Status]


def engine_decision(
    engine_file: EngineFile,
    status: Status,
    findings: Findings,
    again: Callable[[EngineFile], Answers] | None = None,
) -> Decision:
    """Check whether an engine's verdict holds for other values of its assumptions.

    Parameters
    ----------
    engine_file : EngineFile
    status : {"fine", "barred range needed", "not acceptable"}
        Of its verdict.
    findings : sequence of pairs of VibrationLimit and AmplitudeCurve
        Quantities compared with limits.
    again : callable, optional
        Forced vibration of a changed engine; without it no other magnifier is tried.

    Returns
    -------
    Decision
        The steel of the crankshaft's rule and the magnifiers are varied if they
        are assumed, each separately.
    """
    trials = _steels(engine_file, status, findings)
    if again is not None:
        trials += _magnifiers(engine_file, status, again)
    return decide(status, trials)


def _steels(engine_file: EngineFile, status: Status, findings: Findings) -> list[Trial]:
    """Steels from the plain one to the strongest of the rule, if the crankshaft's limit is from a rule.

    The strength that decides alone, else both strengths together.
    """
    limits = engine_file.limits or LimitsInput()
    if limits.crankshaft_stress is not None:
        return []
    tensile, yielding = strengths(engine_file)

    def judged(**given: float) -> Status:
        told = None if TENSILE in given else limits.tensile_strength
        strong = told is None and given.get(TENSILE, tensile) > CRANKSHAFT_STRENGTHS[False]
        changed = engine_file.changed(limits={**given, "alloy": limits.alloy or strong})
        own = {limit.name: limit for limit in engine_limits(changed)[0].values()}
        return engine_verdict(changed, [(own[lim.name], curve) for lim, curve in findings]).status

    ways: list[list[Trial]] = []
    strongest = {BASE_STRENGTH, *CRANKSHAFT_STRENGTHS.values()}
    if is_assumed(engine_file, f"limits.{TENSILE}") and engine_file.strength is None:
        made = Trial(f"limits.{TENSILE}", "tensile strength", tensile, "Pa", status, taken=True)
        ways.append(_with_changes(made, strongest, lambda value: judged(tensile_strength=value)))
    if is_assumed(engine_file, f"limits.{YIELD}"):
        made = Trial(f"limits.{YIELD}", "yield strength", yielding, "Pa", status, taken=True)
        highest = max(BASE_YIELD, HIGHEST_YIELD * tensile)
        ways.append(
            _with_changes(made, {BASE_YIELD, highest}, lambda value: judged(yield_strength=value))
        )
    if len(ways) == 2:
        made = replace(
            ways[0][0],
            field=f"limits.{TENSILE} and limits.{YIELD}",
            name="tensile strength (yield strength in proportion)",
        )
        share = yielding / tensile
        ways.append(
            _with_changes(
                made,
                strongest,
                lambda value: judged(tensile_strength=value, yield_strength=share * value),
            )
        )
    return next((own for own in ways if changes(own)), ways[-1] if ways else [])


def _with_changes(made: Trial, others: set[float], judged: Judged) -> list[Trial]:
    """The value used and others, and those between which the verdict changes."""
    tried = [made, *(_tried(made, value, judged) for value in sorted(others - {made.value}))]
    for pair in changes(tried):
        tried += _at_change(*pair, judged)
    return tried


def _magnifiers(
    engine_file: EngineFile, status: Status, again: Callable[[EngineFile], Answers]
) -> Iterable[Trial]:
    """Other magnifiers, of the axial chain only if its vibration is assessed."""
    limits, _ = engine_limits(engine_file)
    for kind in ("torsional", "axial"):
        value, source = magnifier_of(engine_file, kind)
        field = f"{kind}_magnifier"
        judges = kind == "torsional" or any(name.startswith("axial") for name in limits)
        if value is None or not judges:
            continue
        if not source.startswith(ASSUMED):
            continue

        def judged(magnifier: float, field: str = field) -> Status:
            changed = engine_file.changed(damping={field: magnifier})
            # What is tried is still assumed, so parts with damping of their own do without it.
            sources = changed.provenance | {f"damping.{field}": ("tried", True)}
            changed = replace(changed, provenance=sources)
            return engine_verdict(changed, limit_findings(changed, *again(changed))).status

        made = Trial(f"damping.{field}", f"{kind} magnifier", value, "", status, taken=True)
        yield made
        for share in MAGNIFIER_SHARES:
            yield _tried(made, share * value, judged)


def _tried(like: Trial, value: float, judged: Judged) -> Trial:
    return replace(like, value=value, status=judged(value), taken=False)


def _at_change(low: Trial, high: Trial, judged: Judged) -> list[Trial]:
    """The two strengths, a step apart, between which the verdict changes."""
    first = (low, high)
    while high.value - low.value > STRENGTH_STEP:
        steps = round(0.5 * (high.value - low.value) / STRENGTH_STEP)
        own = _tried(low, low.value + max(1, steps) * STRENGTH_STEP, judged)
        low, high = (own, high) if own.acceptable == low.acceptable else (low, own)
    return [one for one in (low, high) if one not in first]
