"""Assessment of an engine's forced vibration: limits, verdict, and uncertainty."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import count, pairwise
from typing import TYPE_CHECKING, Annotated, Any, Self, TypeAlias

import numpy as np

from crankbase.array_checks import Array
from crankbase.frames import Axes, table_of
from crankbase.quantity import percent
from crankbase.results import (
    Flat,
    Hertz,
    Internal,
    Part,
    Quantity,
    Result,
    Speed,
    made_from,
    result,
)
from crankbase.sentences import amount, joined, kept
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.assumptions import is_assumed
from crankfem.analyses.shaft.chains import MOTION, damped_engine_chain, magnifier_of
from crankfem.analyses.shaft.sources import source_spread
from crankfem.analyses.shaft.throw_analyses import Analyses
from crankfem.analyses.vibration.bearing_sweep import HeldChains, answers_by_chain
from crankfem.analyses.vibration.chain_answers import cause_at
from crankfem.analyses.vibration.engine_limits import (
    Findings,
    engine_limits,
    engine_ranges,
    engine_verdict,
    judges_axial,
    limit_findings,
    limited_quantities,
    limited_series,
    strengths,
    unmodeled_plant,
)
from crankfem.analyses.vibration.forced import ForcedVibration, limit_curves
from crankfem.analyses.vibration.modes import Vibration
from crankfem.files.chain.chain_file import PLANT
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.limits_sections import LimitsInput
from dynamics.assessment.barred_ranges import BarredRange
from dynamics.assessment.limit_rules import BASE_STRENGTH, BASE_YIELD, CRANKSHAFT_STRENGTHS
from dynamics.assessment.limits import VibrationLimit
from dynamics.assessment.response_curves import with_resonances
from dynamics.assessment.separation import USUAL_MARGIN, CriticalRange, critical_ranges
from dynamics.assessment.uncertainty import (
    ALL_DAMPING,
    Samples,
    Spread,
    frequency_bounds,
    function_samples,
    scaled_chain,
)
from dynamics.assessment.verdict import (
    Decision,
    LimitCheck,
    Status,
    Trial,
    Verdict,
    changes,
    decide,
    ranges_to_bar,
    status_by,
)
from dynamics.chains.engine_chains import Kind
from dynamics.critical import engine_orders
from dynamics.excitation.cylinders import CylinderHarmonics
from dynamics.indices import within
from dynamics.response.forced import forced_response
from dynamics.response.series import synthesis
from dynamics.wording import conclusion_sentences

if TYPE_CHECKING:
    from regression.models.compliance_model import ComplianceModel


# Magnifiers that are tried beside the one assumed, as shares of it: 25 and 60 of 40. An order of magnitude.
MAGNIFIER_SHARES = (0.625, 1.5)
TENSILE, YIELD = "tensile_strength", "yield_strength"
# Yield strengths are tried up to this share of a given tensile strength.
HIGHEST_YIELD = 0.7
# [Pa] The change of a verdict between two strengths is told to this.
STRENGTH_STEP = 1e6

Judged = Callable[[float], Status]
Motion: TypeAlias = Annotated[float, Quantity(".motion_unit")]
Parts: TypeAlias = Iterator[Table | str]
# What a table shows; files hold everything.
ROWS_SHOWN = 12


def engine_decision(
    engine_file: EngineFile,
    status: Status,
    findings: Findings,
    again: Callable[[EngineFile], Status] | None = None,
) -> Decision:
    """Check whether an engine's verdict holds for other values of its assumptions.

    Parameters
    ----------
    status : {"fine", "barred range needed", "not acceptable"}
        Of its verdict.
    again : callable, optional
        Status of a changed engine; without it no other magnifier is tried.

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
        strength = None if TENSILE in given else limits.tensile_strength
        strong = strength is None and given.get(TENSILE, tensile) > CRANKSHAFT_STRENGTHS[False]
        changed = engine_file.changed(limits={**given, "alloy": limits.alloy or strong})
        own = {limit.name: limit for limit in engine_limits(changed)[0].values()}
        judged_by = [(own[limit.name], curve) for limit, curve in findings]
        return status_by(engine_ranges(changed, judged_by))

    ways: list[list[Trial]] = []
    strongest = {BASE_STRENGTH, *CRANKSHAFT_STRENGTHS.values()}
    if is_assumed(engine_file, f"limits.{TENSILE}") and engine_file.strength is None:
        made = Trial(f"limits.{TENSILE}", "tensile strength", tensile, "Pa", status, taken=True)
        possible = {value for value in strongest if value >= yielding}
        ways.append(_with_changes(made, possible, lambda value: judged(tensile_strength=value)))
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
    decides = next((way for way in ways if changes(way)), ways[-1] if ways else [])
    plain = CRANKSHAFT_STRENGTHS[False]
    if not limits.alloy and any(low.value >= plain for low, _ in changes(decides)):
        # The rule counts carbon steel as no stronger than that.
        return [replace(trial, field=f"{trial.field} and limits.alloy = true") for trial in decides]
    return decides


def _with_changes(made: Trial, others: set[float], judged: Judged) -> list[Trial]:
    """The value used and others, and those between which the verdict changes."""
    tried = [made, *(_tried(made, value, judged) for value in sorted(others - {made.value}))]
    for ends in changes(tried):
        low, high = ends
        while high.value - low.value > STRENGTH_STEP:
            steps = round(0.5 * (high.value - low.value) / STRENGTH_STEP)
            between = _tried(made, low.value + max(1, steps) * STRENGTH_STEP, judged)
            low, high = (between, high) if between.acceptable == low.acceptable else (low, between)
        tried += [trial for trial in (low, high) if trial not in ends]
    return tried


def _magnifiers(
    engine_file: EngineFile, status: Status, again: Callable[[EngineFile], Status]
) -> Iterable[Trial]:
    """Other magnifiers, of the axial chain only if its vibration is assessed."""
    for kind in ("torsional", "axial") if judges_axial(engine_file) else ("torsional",):
        value, _, assumed = magnifier_of(engine_file, kind)
        field = f"{kind}_magnifier"
        if value is None or not assumed:
            continue

        def judged(magnifier: float, field: str = field) -> Status:
            changed = engine_file.changed(damping={field: magnifier})
            # What is tried is still assumed, so parts with damping of their own do without it.
            sources = changed.provenance | {f"damping.{field}": ("tried", True)}
            return again(replace(changed, provenance=sources))

        made = Trial(f"damping.{field}", f"{kind} magnifier", value, "", status, taken=True)
        yield made
        for share in MAGNIFIER_SHARES:
            yield _tried(made, share * value, judged)


def _tried(like: Trial, value: float, judged: Judged) -> Trial:
    return replace(like, value=value, status=judged(value), taken=False)


# Largest step from one factor to the next: a resonance then moves by 7 %, which no running range is
# as narrow as. One step either way for finite elements and good equations.
STEP = 1.15
# How sources are called in a sentence; formulas by their names.
SOURCES = {"fe": "finite elements", "fe pinned": "finite elements", "regression": "the regression"}
# Factors nearer to 1 change nothing that is told.
LEAST = 1e-6

Range = tuple[float, float]


def _factors(spread: Spread) -> list[float]:
    """Factors from 1 to either end of a range, with equal ratios, without the 1."""
    factors: list[float] = []
    for end in (spread.low, spread.high):
        if abs(end - 1.0) > LEAST:
            steps = math.ceil(abs(math.log(end)) / math.log(STEP))
            factors += np.geomspace(1.0, end, steps + 1)[1:].tolist()
    return factors


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


@result("mode", "lowest", "nominal", "highest", eq=True)
class FrequencyRange(Result):
    """Exact bounds of an elastic natural frequency; modes count from 1."""

    mode: int
    lowest: Annotated[float, Quantity("Hz", key="low")]
    nominal: Hertz
    highest: Annotated[float, Quantity("Hz", key="high")]


@result("nominal", "percentile_5", "percentile_95", "highest")
class SampledAmplitude(Result):
    """Largest amplitude of the free end over the running range, for many possible chains."""

    samples: int
    nominal: Motion
    percentile_5: Motion
    percentile_95: Motion
    highest: Motion


@result("low", "high", eq=True)
class SpeedRange(Result):
    """A range of speeds."""

    low: Speed
    high: Speed


@result("kind", "spreads", "frequencies")
class Uncertainty(Result):
    """Uncertainty of natural frequencies and amplitudes of one kind.

    Attributes
    ----------
    spreads : tuple of Spread
        Uncertain values.
    frequencies : tuple of FrequencyRange
        Elastic natural frequencies.
    critical : tuple of CriticalRange
        Critical speeds in or near the running range, with margins.
    samples : Samples or None
        Largest amplitude of the free end over the running range [rad or m] for many possible chains;
        None unless the engine file has the section [ranges].
    barred : tuple of SpeedRange
        Speeds to be barred with some compliance of the range; they include those of the verdict.
    """

    kind: Internal[str]
    spreads: tuple[Spread, ...]
    frequencies: tuple[FrequencyRange, ...]
    critical: tuple[CriticalRange, ...]
    samples: Internal[Samples | None]
    barred: tuple[SpeedRange, ...] = ()

    @cached_property
    def amplitudes(self) -> Part[SampledAmplitude | None]:
        """Figures of the samples."""
        drawn = self.samples
        if drawn is None:
            return None
        ends = (drawn.nominal, drawn.percentile(5.0), drawn.percentile(95.0), drawn.highest)
        return SampledAmplitude(len(drawn.values), *map(float, ends))

    @property
    def motion_unit(self) -> str:
        """Of amplitudes."""
        return MOTION[self.kind].si

    @property
    def barred_within_error(self) -> str:
        """Which speeds have to be barred over the range of the compliances; empty if none."""
        if not self.barred:
            return ""
        ends = [end for span in self.barred for end in (span.low, span.high)]
        texts = [
            amount(end, "rad/s", decimals=0, bare=place + 1 < len(ends))
            for place, end in enumerate(ends)
        ]
        shown = ", ".join(map(" to ".join, zip(texts[::2], texts[1::2], strict=True)))
        return f"over that range of the compliances, speeds to be barred are within {shown}"

    def to_pandas(self) -> Any:
        """Return a table of the elastic natural frequencies with their bounds.

        Units are in ``frame.attrs["units"]``.
        """
        return table_of(self.frequencies)

    def parts(self, units: OutputUnits = SI) -> Parts:
        """Return what is uncertain, margins of critical speeds, and sampled amplitudes."""
        kind, critical = self.kind.capitalize(), self.critical
        for spread in self.spreads:
            yield f"{kind}: {spread.name} {factor_range(spread)} the value used"
        if self.barred:
            yield units.written(f"{kind}: {kept(self.barred_within_error)}.")
        yield Table.of_records(
            f"{kind} critical speeds with uncertainty ranges, and margins to running speeds"
            + (
                f", the first {ROWS_SHOWN} of {len(critical)}" if len(critical) > ROWS_SHOWN else ""
            ),
            critical[:ROWS_SHOWN],
            (Column("mode"), "mode"),
            (Column("order", digits=None), "order"),
            (Column("speed", "1/min", decimals=1), "nominal"),
            (Column("lowest", "1/min", decimals=1, bare=True), "low"),
            (Column("highest", "1/min", decimals=1, bare=True), "high"),
            (Column("margin", "%", decimals=1), lambda margin: margin.margin or None),
        )
        drawn, motion = self.amplitudes, units.of(MOTION[self.kind].printed)
        if drawn is not None:
            yield (
                f"{kind} amplitude of the free end at running speeds: nominal "
                f"{motion.number(drawn.nominal)} {motion.name}; of {drawn.samples} random choices of the "
                f"uncertain values, 90 % give {motion.number(drawn.percentile_5)} to "
                f"{motion.number(drawn.percentile_95)} {motion.name}"
            )


def factor_range(spread: Spread) -> str:
    """Write the range of a factor.

    Examples
    --------
    >>> factor_range(Spread("compliance", 0.6, 1.4))
    '0.6 to 1.4 times'
    >>> factor_range(Spread("compliance", 0.9967, 1.0033))
    '-0.33 to +0.33 % of'
    """
    low, high = spread.low, spread.high
    if max(abs(low - 1.0), abs(high - 1.0)) < 0.1:
        return f"{percent(low - 1.0, 2, signed=True)} to {percent(high - 1.0, 2, signed=True)} % of"
    return f"{low:.3g} to {high:.3g} times"


@result("name", "unit", "assumed", eq=True)
class JudgedLimit(Result):
    """A limit, its source, and the highest speed at which it is judged."""

    name: str
    unit: str
    source: str
    assumed: bool
    remark: str
    judged_to: Speed

    @property
    def kind(self) -> Kind:
        """Of the vibration: in units of length and force the axial one alone is judged."""
        return "axial" if self.unit in (MOTION["axial"].si, MOTION["axial"].load) else "torsional"


@result("status", "checks", "barred")
class OtherVerdict(Result):
    """The verdict of another model by the same limits."""

    status: str
    checks: tuple[LimitCheck, ...]
    barred: tuple[BarredRange, ...]


@result("verdict.status", "decision.status", "judged_limits", "all_remarks")
class Assessment(Result):
    """Verdict and uncertainty of an engine's vibration.

    Attributes
    ----------
    verdict : Verdict
        With the given and the assumed values.
    decision : Decision
        Whether it holds for other possible values of the assumptions.
    limits : dict
        Name to limit; those given, or the selected rule.
    remarks : tuple of str
        What was not assessed, or assumed.
    uncertainty : mapping of str to Uncertainty
        By kind.
    beside : tuple of str
        What the engine drives where it is not modeled, and where the verdict changes within the range of
        the bearings' stiffness, a sentence each.
    whole : Verdict or None
        That of the whole crankshaft by the same limits, where a chain that they judge is inadequate.
    by_whole : tuple of str
        How far the whole crankshaft differs from the chains that were judged, and its own verdict, a
        sentence each.
    """

    verdict: Flat[Verdict]
    decision: Decision
    limits: Internal[dict[str, VibrationLimit]]
    remarks: Internal[tuple[str, ...]]
    uncertainty: Mapping[str, Uncertainty]
    beside: Internal[tuple[str, ...]] = ()
    whole: Internal[Verdict | None] = None
    by_whole: tuple[str, ...] = ()

    @classmethod
    def from_record(cls, content: "Mapping[str, Any] | Self") -> Self:
        """Read content of JSON, in which what is uncertain is of the kind that names it."""
        assessment = super().from_record(content)
        for kind, uncertain in assessment.uncertainty.items():
            vars(uncertain)["kind"] = kind
        return assessment

    @property
    def axial(self) -> Uncertainty:
        """That of the axial vibration."""
        return self.uncertainty["axial"]

    @property
    def torsional(self) -> Uncertainty:
        """That of the torsional vibration."""
        return self.uncertainty["torsional"]

    @cached_property
    def all_remarks(self) -> Annotated[tuple[str, ...], Quantity(key="remarks")]:
        """What was not assessed, or assumed, and open questions of the verdict."""
        return (*self.remarks, *self.verdict.remarks)

    @cached_property
    def all_beside(self) -> Annotated[tuple[str, ...], Quantity(key="beside")]:
        """What stands beside the verdict: the whole crankshaft, and what is not modeled."""
        return (*self.by_whole, *self.beside)

    @cached_property
    def judged_limits(self) -> Annotated[tuple[JudgedLimit, ...], Quantity(key="limits")]:
        """The limits, as far as they are judged."""
        judged_to = {check.limit.name: check.judged[1] for check in self.verdict.checks}
        return tuple(
            made_from(limit, JudgedLimit, judged_to=judged_to[limit.name])
            for limit in self.limits.values()
        )

    @cached_property
    def by_whole_shaft(self) -> Annotated[OtherVerdict | None, Quantity(key="whole")]:
        """The verdict of the whole crankshaft."""
        whole = self.whole
        if whole is None:
            return None
        return OtherVerdict(whole.status, whole.checks, (*whole.barred, *whole.started_through))

    @property
    def undecided(self) -> bool:
        """Whether the verdict changes with values that are assumed."""
        return self.decision.status == "undecided"

    @property
    def conclusion(self) -> str:
        """What can be concluded despite the assumptions, then the verdict with the values used."""
        return joined(" ", self.conclusions)

    @property
    def conclusions(self) -> tuple[str, ...]:
        """The conclusion, sentence by sentence: the first states it, the others why."""
        return conclusion_sentences(self.verdict.sentences, self.decision.reasons, self.undecided)

    def limit_curve(self, name: str, speeds: Array) -> dict[str, Array]:
        """Return a limit over speeds [rad/s] with its name in a legend; empty if there is none."""
        limit = self.limits.get(name)
        return {} if limit is None else {"limit": limit.continuous.at(speeds)}

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the use of each limit over the speed; see `Verdict.plot`."""
        return self.verdict.plot(axes)

    def to_pandas(self) -> Any:
        """Return a table with a row for each limit that was checked; see `Verdict.to_pandas`."""
        return self.verdict.to_pandas()


def assess(
    engine_file: EngineFile,
    harmonics: CylinderHarmonics,
    nominal: HeldChains,
    analysis: Analyses,
    model: "ComplianceModel | None",
    held: Sequence[HeldChains],
) -> Assessment:
    """Compare an engine's forced vibration with limits, and with other values of what is uncertain.

    Parameters
    ----------
    engine_file : EngineFile
        Its sections [limits] and [ranges] are used if given.
    nominal : HeldChains
        The engine's chains with their responses.
    analysis, model
        Source of the compliances; see `source_spread`.
    held : sequence of HeldChains
        The chains over the range of the bearings' stiffness with their responses; the bounds
        of frequencies and critical speeds cover all of them.

    Raises
    ------
    InputError
        If a limit is on an element that the chain does not have.
    """
    assert nominal.answers is not None
    chains, (axial, torsional) = (nominal.axial, nominal.torsional), nominal.answers
    limits, remarks = engine_limits(engine_file)
    findings = limit_findings(engine_file, axial, torsional)
    verdict = engine_verdict(engine_file, findings)
    quantities = limited_quantities(engine_file)
    limited = {
        (limits[name].name, place): (
            axial if quantities[name].kind == "axial" else torsional,
            series,
        )
        for name, series in limited_series(engine_file, axial, torsional).items()
        for place in series.names
    }
    *checks, deciding = (
        replace(
            check,
            cause=cause_at(
                vibration, torsional, series, check.curve.name, check.worst_speed, check.limit.unit
            ),
        )
        for check in (*verdict.checks, verdict.deciding)
        for vibration, series in (limited[check.limit.name, check.curve.name],)
    )

    def again(changed: EngineFile, vibrations: Sequence[Vibration]) -> tuple[BarredRange, ...]:
        return engine_ranges(changed, limit_curves(changed, harmonics, vibrations, nominal.shaft))

    decision = engine_decision(
        engine_file, verdict.status, findings, lambda changed: status_by(again(changed, chains))
    )
    trials, uncertain = decision.trials, dict[str, Uncertainty]()
    for vibration, answer in zip(chains, nominal.answers, strict=True):
        error = source_spread(
            engine_file, vibration.kind, vibration.chosen.source, analysis, nominal.shaft, model
        )
        spreads = _spreads(engine_file, answer, error)
        barred: tuple[Range, ...] = ()
        if vibration.kind == "torsional" or judges_axial(engine_file):
            (spread,) = (spread for spread in spreads if spread.kind == "compliance")
            tried = {1.0: verdict.started_through + verdict.barred}
            chosen = vibration.chosen
            for factor in _factors(spread):
                chain = scaled_chain(chosen.chain.chain, [spread], [factor])
                scaled = replace(
                    chosen,
                    compliances=factor * chosen.compliances,
                    chain=replace(chosen.chain, chain=chain),
                    modes=chain.modes(),
                )
                tried[factor] = again(
                    engine_file,
                    [
                        replace(kind, chosen=scaled) if kind is vibration else kind
                        for kind in chains
                    ],
                )
            tried = dict(sorted(tried.items()))
            ranged = getattr(engine_file.ranges, f"{vibration.kind}_compliance", None) is not None
            source = SOURCES.get(chosen.source, chosen.source)
            # By the factor on the compliances of this kind, 1 for those used.
            trials += tuple(
                Trial(
                    field=f"ranges.{vibration.kind}_compliance"
                    if ranged
                    else f"vibration.{vibration.kind}_source",
                    name=f"{vibration.kind} compliance, ratio to that by {source}",
                    value=factor,
                    unit="",
                    status=status_by(ranges),
                    taken=factor == 1.0,
                    why="the range given" if ranged else "the error of its source",
                )
                for factor, ranges in tried.items()
            )
            barred = _joined([ranges_to_bar(ranges) for ranges in tried.values()])
        uncertain[vibration.kind] = _uncertainty(engine_file, answer, spreads, held, barred)
    return Assessment(
        verdict=replace(verdict, checks=tuple(checks), deciding=deciding),
        limits=limits,
        decision=decide(verdict.status, trials),
        remarks=remarks,
        uncertainty=uncertain,
        beside=unmodeled_plant(engine_file),
    )


def _uncertainty(
    engine_file: EngineFile,
    forced: ForcedVibration,
    spreads: tuple[Spread, ...],
    held: Sequence[HeldChains],
    barred: tuple[tuple[float, float], ...],
) -> Uncertainty:
    """Bounds of frequencies and critical speeds; amplitudes by samples where ranges are given."""
    engine, ranges = engine_file.engine, engine_file.ranges
    chain, running = forced.engine_chain.chain, (engine.lowest_speed, engine.highest_speed)
    rigid = chain.modes().rigid
    each = answers_by_chain(held, forced)
    others = tuple(each)[1:]
    low, high = frequency_bounds(chain, spreads, others)
    orders = engine_orders(engine.strokes, engine_file.vibration.highest_order)
    margin = USUAL_MARGIN if ranges is None else ranges.separation_margin
    amplitudes = None
    if ranges is not None and spreads:
        amplitudes = function_samples(
            lambda factors: _peak(engine_file, forced, spreads, factors),
            spreads,
            ranges.samples,
            ranges.seed,
        )
    return Uncertainty(
        kind=forced.kind,
        spreads=spreads,
        frequencies=tuple(
            map(
                FrequencyRange,
                count(1),
                *(each[rigid:].tolist() for each in (low, chain.modes().frequencies, high)),
            )
        ),
        critical=critical_ranges(
            chain,
            spreads,
            orders,
            running,
            within=margin,
            damped=lambda own, mode, order: each[own].damped_shifts(mode, order),
            others=others,
        ),
        samples=amplitudes,
        barred=tuple(SpeedRange(*span) for span in barred),
    )


def _spreads(engine_file: EngineFile, forced: ForcedVibration, error: Spread) -> tuple[Spread, ...]:
    """The uncertainties given in the file, and at least the error of the compliances' source."""
    ranges = engine_file.ranges
    elements = tuple(range(len(forced.crank_elements.names)))
    spreads: tuple[Spread, ...] = ()
    if ranges is not None:
        spreads = (
            ranges.axial_spreads() if forced.kind == "axial" else ranges.torsional_spreads(elements)
        )
    if any(spread.kind == "compliance" for spread in spreads):
        return spreads
    # A plant's chain is its maker's throughout, the line behind the flywheel too.
    whole_plant = forced.kind == "torsional" and PLANT in engine_file.shaft_lines
    return (replace(error, places=None if whole_plant else elements), *spreads)


def _peak(
    engine_file: EngineFile,
    forced: ForcedVibration,
    spreads: Sequence[Spread],
    factors: Array,
) -> float:
    """Largest amplitude of the free end at running speeds with factors (p,) of p spreads."""
    chain = scaled_chain(forced.engine_chain.chain, spreads, factors)
    pairs = zip(spreads, factors.tolist(), strict=True)
    damping = math.prod(factor for spread, factor in pairs if spread.kind == ALL_DAMPING)
    changed = damped_engine_chain(
        engine_file, replace(forced.engine_chain, chain=chain), factor=damping
    )
    response = forced_response(changed, with_resonances(forced.response.excitation, chain))
    low, high = engine_file.engine.lowest_speed, engine_file.engine.highest_speed
    judged = within(response.speeds, low, high)
    free_end = response.elastic
    summed = synthesis(
        free_end.orders,
        free_end.speeds[judged],
        free_end.values[:, judged, 0],
        free_end.unbounded[:, judged],
    )
    return float(np.max(summed.amplitude))
