"""The best throw of an engine under limits, by finite elements and their slopes.

Each place of the search is a throw that is analyzed; the next one is the best that its slopes
(`fem.sensitivities`) predict within some reach: powers of the dimensions, with curvatures that follow from
the slopes of the other throws. No study is needed. The optimum is a local one.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import did_you_mean
from crankbase.errors import InputError, MeshError, SolveError
from crankbase.quantity import format_quantity, percent
from crankbase.sentences import amount
from crankfem.analyses.shaft.chains import (
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
)
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.crank_throws import PLAIN
from crankfem.satellites.optimum.frequencies import check_one_throw, first_frequency
from fem.response_table import RESPONSES, ResponseKind
from fem.responses import evaluate_throw
from fem.superelement import Superelement, shaft_compliances
from fem.wished_accuracy import COMPLIANCE_ACCURACY
from geometry.any_throw import with_dimensions
from geometry.boundary_motion import STEP
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record
from regression.models.angle import SEVERAL_PINS
from regression.models.family import Family
from regression.models.lookup import Lookup
from regression.optimum import (
    Banded,
    Limit,
    Optimum,
    Problem,
    SearchResult,
    angle_band,
    best_of,
    check_known,
    infeasible,
    make_optimum,
    nearest,
    polished,
    search_space,
)
from regression.response_kinds import ANGLE_LAWS, TILT_RATIO
from regression.throw_values import check_dimension, field_unit, same_dimension, throw_values

Factors = Mapping[str, float]

# Answers scatter by some 0.03 % from mesh to mesh. Shares that aims keep of limits, that a limit has left
# which the optimum stands at, and the least gain that an analysis is worth.
SPARE, ACTIVE, PRECISION = 5e-4, 2e-3, 1e-3
# In logarithms of dimensions: how far slopes are followed at once, and the least that is worth it; throws
# that are nearer than the last show scatter, no curvature.
REACH, LEAST_REACH, NEAR = 0.3, 0.004, 0.02
# The least share of limits that a search comes nearer to them by.
NEARER = 1e-4
# A step that gains less than this share of its promise was too long.
POOR = 0.25
# Of a violated limit, in shares of what is minimized.
PRICE = 3.0
MOST_ANALYSES = 30
HALVINGS = 12
# Slopes need throws beside one.
ROOM = 4.0 * STEP

FREQUENCIES = {
    f"first_{kind}_frequency": ResponseKind(f"f_{kind[0]}", "Hz", f"first {kind} frequency")
    for kind in ("axial", "torsional")
}


def _named(answers: Mapping[str, Any]) -> dict[str, Any]:
    """Name answers as models of studies do: pinned ones without their support."""
    return {name.removesuffix("_pinned"): value for name, value in answers.items()}


QUANTITIES: dict[str, ResponseKind] = FREQUENCIES | {
    name: kind
    for name, kind in _named(RESPONSES).items()
    if "compliance" in name or "coefficient" in name or name == "mass"
}


@dataclass(frozen=True, eq=False)
class SlopedThrow:
    """A throw of the search: its varied dimensions [SI], and its responses.

    Attributes
    ----------
    values, errors : mapping
        Of each response [SI], and its relative error.
    slopes : mapping
        d ln(response) / d ln(dimension), (dimensions,).
    """

    factors: Factors
    values: Mapping[str, float]
    errors: Mapping[str, float]
    slopes: Mapping[str, Array]

    def moves(self, factors: Mapping[str, Any]) -> Array:
        """Logarithms of other dimensions divided by its own."""
        return np.array([math.log(factors[name] / length) for name, length in self.factors.items()])


@dataclass(frozen=True, kw_only=True)
class _Local(Problem):
    """A search beside one analyzed throw, by its slopes and those of others."""

    here: SlopedThrow
    others: Sequence[SlopedThrow]

    @cached_property
    def differences(self) -> tuple[list[tuple[float, SlopedThrow]], Any]:
        """Throws that are not near with their distance, and what makes curvatures of their slopes."""
        moves = {other: self.here.moves(other.factors) for other in self.others}
        sizes = {other: float(np.linalg.norm(move)) for other, move in moves.items()}
        far = [(size, other) for other, size in sizes.items() if size > NEAR]
        # Directions that hardly two throws differ in are left flat.
        return far, far and np.linalg.pinv([moves[other] / size for size, other in far], rcond=0.1)

    def growth(self, name: str, move: Array) -> float:
        """Change of a response's logarithm: its slopes, with the least curvatures by which slopes differ."""
        slopes, (far, inverse) = self.here.slopes[name], self.differences
        bent = 0.0
        if far:
            changes = [(other.slopes[name] - slopes) / size for size, other in far]
            bent = 0.5 * float(move @ (inverse @ changes) @ move)
        return float(move @ slopes) + bent

    def place(self, factors: Factors) -> Array:
        """Place of a throw in the box."""
        ends = zip(factors.values(), self.space.ranges.values(), strict=True)
        return np.array([(value - low) / ((high - low) or 1.0) for value, (low, high) in ends])

    def points(self, places: Array) -> Banded:
        return _Beside(self, cast(Factors, self.factors(places)))

    def lookups(self, factors: Mapping[str, Any]) -> dict[str, Lookup]:
        lookups = {}
        for name in (each for each in QUANTITIES if each in self.here.values):
            value, lower, upper = self.points(self.place(factors)).band(name)
            lookups[name] = Lookup(
                value=value,
                lower=lower,
                upper=upper,
                unit=QUANTITIES[name].unit,
                symbol=QUANTITIES[name].symbol,
                support="",
                inside=True,
                remarks=(),
                error=None,
                fe_error=self.here.errors[name],
                band="the finite elements' own error estimate",
                equation="",
            )
        return lookups


@dataclass(frozen=True)
class _Beside:
    """A throw beside an analyzed one, as predicted."""

    local: _Local
    factors: Factors

    def band(self, name: str, gamma_deg: float | None = None) -> tuple[Any, ...]:
        if gamma_deg is not None and name in ANGLE_LAWS:
            if TILT_RATIO not in self.local.here.values:
                raise InputError(SEVERAL_PINS)
            return angle_band(self, ANGLE_LAWS[name], gamma_deg)
        known = {**self.local.model.family.fixed, **self.factors}
        if name in known:
            return (known[name],)
        here = self.local.here
        value = here.values[name] * math.exp(self.local.growth(name, here.moves(self.factors)))
        return value, value * (1.0 - here.errors[name]), value * (1.0 + here.errors[name])


@dataclass(frozen=True, eq=False)
class ThrowFamily:
    """The throws among which an engine's is sought: some dimensions vary, the others stay.

    Parameters
    ----------
    engine_file : EngineFile
        All its cranks are one throw.
    ranges : mapping
        Dimension ("web_width", "counterweight.thickness") to its least and largest value [SI].

    Raises
    ------
    InputError
        If the engine has several throws, or a dimension is unknown, absent from the throw, or outside its
        range.
    """

    engine_file: EngineFile
    ranges: Mapping[str, tuple[float, float]]
    constraints: tuple[str, ...] = ()

    responses = QUANTITIES

    def __post_init__(self) -> None:
        check_one_throw(self.engine_file)
        if not self.ranges:
            raise InputError(
                "vary: given no dimension; allowed are one or more, each with a range."
            )
        nominal = self.nominal
        lengths = [name for name, value in nominal.items() if isinstance(value, float) and value]
        for name, ends in self.ranges.items():
            unit = field_unit(name) or ""
            if name not in lengths or not unit:
                raise InputError(
                    f"vary: given {name!r}; {did_you_mean(name, lengths)}allowed are the throw's dimensions, "
                    f"{', '.join(lengths)}, because slopes are over what is there."
                )
            for end in ends:
                check_dimension(f"vary: {name}", name, end)
            (low, high), at = ends, float(nominal[name])
            around = low <= at <= high or any(same_dimension(at, end) for end in ends)
            if not low < high or low * high <= 0.0 or not around:
                shown = " to ".join(amount(end, unit) for end in ends)
                raise InputError(
                    f"vary: given {name} from {shown}; allowed is a lower end, then a higher one, on "
                    f"one side of zero and around the engine's own {amount(at, unit)}, where the "
                    "search begins."
                )

    @cached_property
    def nominal(self) -> dict[str, Any]:
        """The dimensions and labels of the engine's throw."""
        return throw_values(with_dimensions(self.engine_file.throw), spelled_out=True)

    @cached_property
    def throw(self) -> dict[str, Any]:
        """Record of the engine's throw."""
        return with_dimensions(self.engine_file.throw).model_dump(mode="json")

    @cached_property
    def family(self) -> Family:
        """The dimensions that vary, and the others."""
        rest = {name: value for name, value in self.nominal.items() if name not in self.ranges}
        labels = {name: value for name, value in rest.items() if isinstance(value, str)}
        fixed = {name: value for name, value in rest.items() if name not in labels}
        return Family(ranges=self.ranges, fixed=fixed, labels=labels)

    def build(self, factors: Factors) -> CrankThrow:
        """Return the throw of some dimensions; `InputError` if it cannot be built."""
        return CrankThrow(**changed_record(self.throw, dict(factors)))

    def refusal(self, factors: Factors) -> str:
        """Say why a throw, or one beside it, cannot be built; "" if it can."""
        beside = [
            {name: factors[name] * (1.0 + side)} for name in factors for side in (-ROOM, ROOM)
        ]
        try:
            for change in ({}, *beside):
                self.build({**factors, **change})
        except InputError as error:
            return str(error)
        return ""

    def analyzed(self, factors: Factors, accuracy: float, frequencies: bool) -> SlopedThrow:
        """Analyze a throw, with slopes; `InputError`, `MeshError` or `SolveError` if it has none."""
        material, further = self.engine_file.material, self.frequencies if frequencies else _none
        answers = evaluate_throw(
            self.build(factors), material, accuracy, slopes=self.ranges, further=further
        )
        missing = [path for path in self.ranges if path not in answers.slopes["mass"]]
        if missing:
            raise InputError(
                f"vary: given {missing[0]}, which has no slope where the throw's shape turns into another."
            )
        slopes = {
            name: np.array([of_paths[path] for path in self.ranges])
            for name, of_paths in answers.slopes.items()
        }
        return SlopedThrow(factors, _named(answers.values), _named(answers.errors), _named(slopes))

    def frequencies(
        self, throw: CrankThrow, element: Superelement, mass: float, inertia: float
    ) -> dict[str, float]:
        """First frequencies of the crankshaft with a throw [Hz]; its stroke follows the crank radius."""
        names = self.engine_file.named_throws
        sections: dict[str, Any] = (
            {"throw": throw} if PLAIN in names else {"throws": dict.fromkeys(names, throw)}
        )
        if "crank_radius" in self.ranges:
            share = throw.crank_radius / self.engine_file.throw.crank_radius
            sections["engine"] = {"stroke": self.engine_file.engine.stroke * share}
        changed = self.engine_file.changed(**sections)
        shaft = shaft_compliances(
            [element] * len(changed.throw_angles_deg),
            crank_angles_deg=changed.throw_angles_deg,
            bearing_stiffness=changed.main_bearings.stiffness,
        )
        chains = (
            engine_axial_chain(changed, shaft.axial, mass),
            engine_torsional_chain(
                changed, shaft.torsional, engine_throw_inertias(changed, inertia)
            ),
        )
        return dict(zip(FREQUENCIES, map(first_frequency, chains), strict=True))


def _none(*_: object) -> dict[str, float]:
    return {}


class SearchInterrupted(KeyboardInterrupt):
    """An interrupt of a search; `best` is the best throw so far, None if none keeps the limits."""

    def __init__(self, best: Optimum | None) -> None:
        super().__init__()
        self.best = best


@dataclass(frozen=True, eq=False)
class ThrowSearch:
    """A search that follows slopes.

    Parameters
    ----------
    whole : Problem
        Over the whole ranges.
    analyze : callable
        Returns the throw of some dimensions; InputError, MeshError or SolveError if there is none.
    refusal : callable
        Says why one cannot be built, or "".
    step : callable
        Called with a sentence before each analysis.
    """

    whole: Problem
    analyze: Callable[[Factors], SlopedThrow]
    refusal: Callable[[Factors], str]
    step: Callable[[str], object]
    throws: list[SlopedThrow] = field(default_factory=list)
    # Sentences of throws that could not be analyzed, and of the last that could not be built.
    refused: list[str] = field(default_factory=list)

    def local(self, here: SlopedThrow, ranges: Mapping[str, tuple[float, float]]) -> _Local:
        """Return the search beside a throw."""
        space = replace(self.whole.space, ranges=dict(ranges))
        return _Local(**{**vars(self.whole), "space": space}, here=here, others=self.throws)

    def rated(self, here: SlopedThrow) -> SearchResult:
        """Rate a throw by its own answers."""
        alone = replace(self.local(here, self.whole.space.ranges), others=())
        return best_of(alone, [alone.place(here.factors)], len(self.throws))

    @property
    def best(self) -> tuple[SlopedThrow, SearchResult]:
        """The best throw that keeps the limits, else the nearest."""
        rated = [(throw, self.rated(throw)) for throw in self.throws]
        kept = [pair for pair in rated if pair[1].broken <= SPARE]
        if kept:
            return min(kept, key=lambda pair: pair[1].objective)
        return min(rated, key=lambda pair: pair[1].broken)

    def gain(self, here: SlopedThrow | SearchResult, there: SearchResult) -> float:
        """How much better a throw is, as a share; beside one that misses limits, how much nearer to them."""
        now = self.rated(here) if isinstance(here, SlopedThrow) else here
        if now.broken > SPARE:
            return now.broken - max(there.broken, 0.0)
        saved = (now.objective - there.objective) / (abs(now.objective) or 1.0)
        return saved - PRICE * max(there.broken - SPARE, 0.0)

    def analyzed(self, factors: Factors) -> SlopedThrow | None:
        """Analyze a throw of the search; None if that is impossible."""
        best = ""
        if self.throws:
            of, value = self.best[1], self.best[1].objective
            best = f", {'best' if of.broken <= SPARE else 'limits missed'} so far: "
            best += format_quantity(value, self.whole.unit, 5)
        self.step(f"Analysis {len(self.throws) + 1}{best}")
        try:
            self.throws.append(self.analyze(factors))
        except (InputError, MeshError, SolveError) as error:
            self.refused.append(str(error))
            return None
        return self.throws[-1]

    def buildable(self, here: Factors, change: Factors) -> Factors:
        """Return the farthest throw on the way to a change of some dimensions that can be built."""

        def part_way(share: float) -> dict[str, float]:
            part = {name: here[name] + share * (aim - here[name]) for name, aim in change.items()}
            return {**here, **part}

        if not self.refusal({**here, **change}):
            return {**here, **change}
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            share = 0.5 * (low + high)
            low, high = (low, share) if self.refusal(part_way(share)) else (share, high)
        return part_way(low)

    def aim(self, here: SlopedThrow, reach: float) -> tuple[SearchResult, Factors, str]:
        """Return what slopes promise at best within reach, at which dimensions, and what cannot be built."""
        ranges: dict[str, tuple[float, float]] = {}
        refusals: dict[tuple[str, float], str] = {}
        for name, (low, high) in self.whole.space.ranges.items():
            ends = sorted(here.factors[name] * math.exp(way) for way in (-reach, reach))
            ranges[name] = max(low, ends[0]), min(high, ends[1])
        while True:
            local = self.local(here, ranges)
            start = local.place(here.factors)
            places = [start, polished(local, start)]
            if local.limits:
                near = nearest(local, start)
                places += [near, polished(local, near)]
            best = best_of(local, places, 0)
            factors = cast(Factors, local.factors(best.place))
            refusal, before = self.refusal(factors), len(refusals)
            if refusal:
                # Where throws end is known by trying alone: by one dimension, else on the way.
                for name, value in factors.items():
                    last = self.buildable(here.factors, {name: value})[name]
                    if last != value:
                        low, high = ranges[name]
                        ranges[name] = (last, high) if value < last else (low, last)
                        refusals[name, last] = refusal
                if len(refusals) > before:
                    continue
                factors = self.buildable(here.factors, factors)
                best = best_of(local, [local.place(factors)], 0)
            at = [each for (name, last), each in refusals.items() if factors[name] == last]
            return best, factors, next(iter(at), refusal)

    def follow(self, start: Factors) -> None:
        """Follow slopes from a throw, until they promise no more."""
        here, reach = self.analyzed(start), REACH
        while here is not None and reach > LEAST_REACH and len(self.throws) < MOST_ANALYSES:
            aim, factors, refusal = self.aim(here, reach)
            promise = self.gain(here, aim)
            if promise < (NEARER if self.rated(here).broken > SPARE else PRECISION):
                if not refusal:
                    break
                reach *= 0.5  # a nearer aim may miss what cannot be built
                continue
            there = self.analyzed(factors)
            gained = -math.inf if there is None else self.gain(here, self.rated(there))
            far = float(np.abs(here.moves(factors)).max())
            reach = min(2.0 * reach, REACH) if gained > POOR * promise else 0.5 * min(reach, far)
            if there is not None and gained > 0.0:
                here = there

    def result(self, *remarks: str) -> Optimum:
        """Describe the best throw, with what is known of it; `InputError` if none keeps the limits."""
        here, now = self.best
        local = self.local(here, self.whole.space.ranges)
        if now.broken > SPARE:
            raise InputError(infeasible(local, now, f"none of {len(self.throws)} throws analyzed"))
        aims = [self.aim(here, REACH * 0.5**halved) for halved in range(6)]
        promise, refusal = max(self.gain(now, aim) for aim, _, _ in aims), aims[0][2]
        gain = (
            "no gain above 0.1 %" if promise < PRECISION else f"a gain of {percent(promise, 2)} %"
        )
        notes = [
            f"throws analyzed: {len(self.throws)}; the slopes of this one promise {gain} within "
            f"{100.0 * math.expm1(REACH):.0f} % of each dimension"
        ]
        if local.limits:
            band = "the worst end of the error bars" if local.margins else "values without margin"
            notes.insert(0, f"the limits are kept at {band} of this throw's own finite elements")
        if refusal:
            notes.append(
                "slopes also point to throws that cannot be built, along whose edge better ones may lie: "
                + refusal
            )
        if self.refused:
            notes.append(f"{len(self.refused)} could not be analyzed, the last: {self.refused[-1]}")
        return make_optimum(local, now, *remarks, *notes)


def best_throw(
    engine_file: EngineFile,
    vary: Mapping[str, tuple[float, float]],
    minimize: str,
    limits: Sequence[Limit] = (),
    *,
    margins: bool = True,
    accuracy: float = 0.01,
    step: Callable[[str], object] | None = None,
) -> Optimum:
    """Find the throw of an engine with the smallest value of a dimension or response that keeps limits.

    Every throw of the search is analyzed by finite elements, about a second each. The optimum is a local one:
    the search follows slopes from the engine's own throw, and from the middle of the ranges if it finds
    none that keeps the limits.

    Parameters
    ----------
    engine_file : EngineFile
        All its cranks are one throw.
    vary : mapping
        Dimension of the throw to its least and largest value [SI].
    minimize : str
        A dimension, or one of the responses: axial_compliance, torsional_compliance, influence_coefficient
        (ends pinned; with _guided ends guided), mass, first_axial_frequency, first_torsional_frequency.
    limits : sequence of Limit
        On the same. Fillet stresses have no slopes, and are not among them.
    margins : bool
        Whether limits must be kept at the worst end of the finite elements' error bars.
    accuracy : float
        Of each analysis, as for `analyze_throw`.
    step : callable, optional
        Called with a sentence before each analysis.

    Raises
    ------
    InputError
        If a name is unknown, a range is impossible, or no throw found keeps the limits; the message then
        states the nearest one.
    SearchInterrupted
        On an interrupt; with the best throw so far.
    """
    family = ThrowFamily(engine_file, vary)
    COMPLIANCE_ACCURACY.checked("accuracy", accuracy)
    check_known(family, minimize)
    asked = {minimize, *(name for limit in limits for name in limit.quantities)}
    for limit in limits:
        for name in limit.quantities:
            check_known(family, name, f"limit on {limit.name}")
    space, frequencies = search_space(family, {}), bool(asked & FREQUENCIES.keys())
    search = ThrowSearch(
        Problem(family, minimize, tuple(limits), margins, space, spare=SPARE, active=ACTIVE),
        lambda factors: family.analyzed(factors, accuracy, frequencies),
        family.refusal,
        step or _none,
    )
    try:
        search.follow({name: float(family.nominal[name]) for name in vary})
        if not search.throws or search.best[1].broken > SPARE:
            search.follow({name: 0.5 * (low + high) for name, (low, high) in vary.items()})
    except KeyboardInterrupt:
        kept = search.throws and search.best[1].broken <= SPARE
        stopped = "the search was interrupted: this is the best throw so far"
        raise SearchInterrupted(search.result(stopped) if kept else None) from None
    if not search.throws:
        raise InputError(f"vary: given ranges where no search can begin: {search.refused[0]}")
    return search.result()
