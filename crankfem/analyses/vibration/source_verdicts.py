"""Effect of the compliances' error on the verdict: verdicts over their range."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from crankfem.analyses.vibration.engine_limits import engine_limits, engine_verdict, limit_findings
from crankfem.analyses.vibration.forced import ForcedVibration
from crankfem.analyses.vibration.modes import Vibration
from crankfem.files.engine.engine_file import EngineFile
from dynamics.assessment.uncertainty import Spread, scaled_chain
from dynamics.assessment.verdict import Trial, Verdict

# Largest step from one factor to the next: a resonance then moves by 7 %, which no running range is
# as narrow as. One step either way for finite elements and good equations.
STEP = 1.15
# How sources are called in a sentence; formulas by their names.
SOURCES = {"fe": "finite elements", "fe pinned": "finite elements", "regression": "the regression"}
# Factors nearer to 1 change nothing that is told.
LEAST = 1e-6

Range = tuple[float, float]
# An engine with its axial and torsional vibration to their forced vibration, as far as limits need it.
Again = Callable[[EngineFile, Vibration, Vibration], tuple[ForcedVibration, ForcedVibration]]


@dataclass(frozen=True)
class SourceVerdicts:
    """Verdicts over the range of one kind of compliance.

    Attributes
    ----------
    trials : tuple of Trial
        In the order of the factors, including the value used; empty if that kind is not assessed.
    barred : tuple of pairs of float
        Speeds that have to be barred with some compliance of the range [rad/s]; as far as permitted.
    """

    trials: tuple[Trial, ...] = ()
    barred: tuple[Range, ...] = ()


def source_verdicts(
    engine_file: EngineFile,
    chains: tuple[Vibration, Vibration],
    kind: str,
    spread: Spread,
    verdict: Verdict,
    again: Again,
) -> SourceVerdicts:
    """Assess an engine with compliances of one kind over their range.

    Parameters
    ----------
    engine_file : EngineFile
    chains : pair of Vibration
        The axial and the torsional one.
    kind : {"axial", "torsional"}
        Whose compliances are varied.
    spread : Spread
        Of these, with its places.
    verdict : Verdict
        With the compliances used.
    again : callable
    """
    limits, _ = engine_limits(engine_file)
    if kind == "axial" and not any(name.startswith("axial") for name in limits):
        return SourceVerdicts()
    found = {1.0: verdict}
    for factor in _factors(spread):
        axial, torsional = (
            _scaled(own, spread, factor) if own.kind == kind else own for own in chains
        )
        findings = limit_findings(engine_file, *again(engine_file, axial, torsional))
        found[factor] = engine_verdict(engine_file, findings)
    source = next(own for own in chains if own.kind == kind).chosen.source
    given = getattr(engine_file.ranges, f"{kind}_compliance", None) is not None
    made = Trial(
        field=f"ranges.{kind}_compliance" if given else f"vibration.{kind}_source",
        name=f"{kind} compliance, ratio to that by {SOURCES.get(source, source)}",
        value=1.0,
        unit="",
        status=verdict.status,
        taken=True,
        why="the range given" if given else "the error of its source",
    )
    ordered = sorted(found.items())
    return SourceVerdicts(
        tuple(
            replace(made, value=factor, status=own.status, taken=factor == 1.0)
            for factor, own in ordered
        ),
        _joined([own.ranges_to_bar for _, own in ordered]),
    )


def _factors(spread: Spread) -> list[float]:
    """Factors from 1 to either end of a range, with equal ratios, without the 1."""
    found: list[float] = []
    for end in (spread.low, spread.high):
        if abs(end - 1.0) > LEAST:
            steps = math.ceil(abs(math.log(end)) / math.log(STEP))
            found += np.geomspace(1.0, end, steps + 1)[1:].tolist()
    return found


def _scaled(vibration: Vibration, spread: Spread, factor: float) -> Vibration:
    """Return a kind of vibration with the chosen compliances multiplied by a factor."""
    chosen = vibration.chosen
    chain = scaled_chain(chosen.chain.chain, [spread], [factor])
    changed = replace(
        chosen,
        compliances=factor * chosen.compliances,
        chain=replace(chosen.chain, chain=chain),
        modes=chain.modes(),
    )
    return replace(vibration, chosen=changed)


def _joined(each: Sequence[Sequence[Range]]) -> tuple[Range, ...]:
    """Ranges over all factors: between two factors with equally many, each is joined to its counterpart."""
    swept = [own for ranges in each for own in ranges]
    for before, after in pairwise(each):
        if len(before) == len(after):
            swept += [
                (min(one[0], other[0]), max(one[1], other[1]))
                for one, other in zip(before, after, strict=True)
            ]
    joined: list[Range] = []
    for low, high in sorted(swept):
        if joined and low <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(joined[-1][1], high))
        else:
            joined.append((low, high))
    return tuple(joined)
