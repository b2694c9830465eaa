"""The verdict again with other values of what is assumed: whether it holds."""

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
from dynamics.assessment.decided import Decision, Trial, changes, decide
from dynamics.assessment.limit_rules import BASE_STRENGTH, BASE_YIELD, CRANKSHAFT_STRENGTHS
from dynamics.assessment.verdict import Status

# Magnifiers that are tried beside the one assumed, as shares of it: 25 and 60 of 40. An order of magnitude.
MAGNIFIER_SHARES = (0.625, 1.5)
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
    """Conclude from an engine's verdict whether it holds for what is assumed.

    Parameters
    ----------
    engine_file : EngineFile
    status : {"fine", "barred range needed", "not acceptable"}
        Of its verdict.
    findings : sequence of pairs of VibrationLimit and AmplitudeCurve
        What was held against limits.
    again : callable, optional
        Forced vibration of a changed engine; without it no other magnifier is tried.

    Returns
    -------
    Decision
        The steel that a rule for the crankshaft was asked with and the magnifiers are varied where they
        are assumed, each by itself.
    """
    trials = [*_steels(engine_file, status, findings)]
    if again is not None:
        trials += _magnifiers(engine_file, status, again)
    return decide(status, trials)


def _steels(engine_file: EngineFile, status: Status, findings: Findings) -> Iterable[Trial]:
    """Steels from the plain one to the strongest of the rule, where the crankshaft's limit comes from one."""
    limits = engine_file.limits or LimitsInput()
    if limits.crankshaft_stress is not None:
        return []
    tensile, yielding = strengths(engine_file)
    free = {
        name: is_assumed(engine_file, f"limits.{name}")
        for name in ("tensile_strength", "yield_strength")
    }
    if not any(free.values()):
        return []
    name = "tensile_strength" if free["tensile_strength"] else "yield_strength"

    def judged(strength: float) -> Status:
        if name == "yield_strength":
            given = {"yield_strength": strength}
        else:
            # The yield strength goes along, as that of the plain steel does with its own.
            in_proportion = strength * BASE_YIELD / BASE_STRENGTH
            given = {
                "tensile_strength": strength,
                "yield_strength": in_proportion if free["yield_strength"] else yielding,
                "alloy": limits.alloy or strength > CRANKSHAFT_STRENGTHS[False],
            }
        changed = engine_file.changed(limits=given)
        own = {limit.name: limit for limit in engine_limits(changed)[0].values()}
        return engine_verdict(changed, [(own[lim.name], curve) for lim, curve in findings]).status

    taken, others = yielding, {BASE_YIELD, HIGHEST_YIELD * tensile}
    if name == "tensile_strength":
        taken, others = tensile, {BASE_STRENGTH, *CRANKSHAFT_STRENGTHS.values()}
    made = Trial(f"limits.{name}", name.replace("_", " "), taken, "Pa", status, taken=True)
    tried = [made, *(_tried(made, value, judged) for value in sorted(others - {taken}))]
    for pair in changes(tried):
        tried += _at_change(*pair, judged)
    return tried


def _magnifiers(
    engine_file: EngineFile, status: Status, again: Callable[[EngineFile], Answers]
) -> Iterable[Trial]:
    """Other magnifiers, of the axial chain only where its vibration is judged."""
    limits, _ = engine_limits(engine_file)
    for kind in ("torsional", "axial"):
        value, source = magnifier_of(engine_file, kind)
        field = f"{kind}_magnifier"
        judges = kind == "torsional" or any(name.startswith("axial") for name in limits)
        if value is None or not judges:
            continue
        if source != ASSUMED and not is_assumed(engine_file, f"damping.{field}"):
            continue

        def judged(magnifier: float, field: str = field) -> Status:
            changed = engine_file.changed(damping={field: magnifier})
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
