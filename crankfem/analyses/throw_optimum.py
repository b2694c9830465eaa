"""The best throw of an engine under limits, by finite elements and their slopes.

Each place of the search is a throw that is analyzed; the next one is the best that its slopes
(`fem.sensitivities`) predict within some reach: powers of the dimensions, with curvatures that follow from the
slopes of the other throws. No study is needed. The optimum is a local one.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from crankbase.choices import did_you_mean
from crankbase.errors import InputError, MeshError, SolveError
from crankbase.quantity import format_quantity
from crankfem.analyses.engine_optimum import check_one_throw, first_frequency
from crankfem.analyses.shaft.chains import (
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
)
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.crank_throws import PLAIN
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.angle_law import compliance
from fem.responses import RESPONSES, ResponseKind
from fem.sensitivities import dimension_changes
from fem.superelement import Superelement, shaft_compliances
from fem.supports import Neighbors, Support
from geometry.boundary_motion import STEP
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record
from regression.models.family import Family
from regression.models.lookup import Lookup
from regression.optimum import (
    Banded,
    Limit,
    Optimum,
    Problem,
    SearchResult,
    best_of,
    check_minimized,
    infeasible,
    make_optimum,
    nearest,
    polished,
    search_space,
)
from regression.throw_values import check_dimension, field_unit, throw_values

Array = NDArray[np.float64]
# A quantity, and the angle to the neighbors if it is between them.
Asked = tuple[str, float | None]
Factors = Mapping[str, float]

# Answers scatter by some 0.03 % from mesh to mesh. Shares that aims keep of limits, that a limit has left
# which the optimum stands at, and the least gain that an analysis is worth.
SPARE, ACTIVE, PRECISION = 5e-4, 2e-3, 1e-3
# In logarithms of dimensions: how far slopes are followed at once, and the least that is worth it; throws that
# are nearer than the last show scatter, no curvature.
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

_COMPLIANCES = {
    "axial_compliance": "axial",
    "torsional_compliance": "torsional",
    "influence_coefficient": "influence",
}
_FREQUENCIES = {f"first_{kind}_frequency": kind for kind in ("axial", "torsional")}
# By the names that models of studies have: pinned ones without their support.
QUANTITIES = (
    {
        f"{name}{suffix}": RESPONSES[f"{name}_{support}"]
        for support, suffix in (("pinned", ""), ("guided", "_guided"))
        for name in _COMPLIANCES
    }
    | {"mass": RESPONSES["mass"]}
    | {
        name: ResponseKind(f"f_{kind[0]}", "Hz", f"first {kind} frequency of the crankshaft")
        for name, kind in _FREQUENCIES.items()
    }
)


@dataclass(frozen=True, eq=False)
class SlopedThrow:
    """A throw of the search: its varied dimensions [SI], and answers.

    Attributes
    ----------
    bands : mapping
        Value of each dimension and response [SI], of these with the ends of the error band.
    slopes : mapping
        d ln(response) / d ln(dimension), (dimensions,), of those that are searched by.
    """

    factors: Factors
    bands: Mapping[Asked, tuple[float, ...]]
    slopes: Mapping[Asked, Array]

    def band(self, name: str, gamma_deg: float | None = None) -> tuple[float, ...]:
        """Value of a quantity, and the ends of its error band if it has one."""
        return self.bands[name, gamma_deg]

    def moves(self, factors: Mapping[str, Any]) -> Array:
        """Logarithms of other dimensions divided by its own."""
        return np.array([math.log(factors[name] / own) for name, own in self.factors.items()])


@dataclass(frozen=True, kw_only=True)
class _Local(Problem):
    """A search beside one analyzed throw, by its slopes and those of others."""

    here: SlopedThrow
    others: Sequence[SlopedThrow]

    @cached_property
    def curvatures(self) -> dict[Asked, Array]:
        """Second derivatives of responses in logarithms: the least ones by which slopes differ."""
        moves = {other: self.here.moves(other.factors) for other in self.others}
        sizes = {other: float(np.linalg.norm(move)) for other, move in moves.items()}
        far = [other for other, size in sizes.items() if size > NEAR]
        if not far:
            return {asked: np.zeros((len(own),) * 2) for asked, own in self.here.slopes.items()}
        # Directions that hardly two throws differ in are left flat.
        inverse = np.linalg.pinv([moves[other] / sizes[other] for other in far], rcond=0.1)
        found = {}
        for asked, own in self.here.slopes.items():
            half = inverse @ [(other.slopes[asked] - own) / sizes[other] for other in far]
            found[asked] = 0.5 * (half + half.T)
        return found

    def place(self, factors: Factors) -> Array:
        """Place of a throw in the box."""
        ends = zip(factors.values(), self.space.ranges.values(), strict=True)
        return np.array([(own - low) / ((high - low) or 1.0) for own, (low, high) in ends])

    def points(self, places: Array) -> Banded:
        factors = cast(Factors, self.factors(places))
        move, bands = self.here.moves(factors), dict(self.here.bands)
        for asked, slopes in self.here.slopes.items():
            growth = math.exp(move @ slopes + 0.5 * move @ self.curvatures[asked] @ move)
            bands[asked] = tuple(value * growth for value in bands[asked])
        own = {(name, None): (value,) for name, value in factors.items()}
        return SlopedThrow(factors, bands | own, {})

    def lookups(self, factors: Mapping[str, Any]) -> dict[str, Lookup]:
        found = {}
        for name, kind in QUANTITIES.items():
            value, lower, upper = self.points(self.place(factors)).band(name)
            found[name] = Lookup(
                value=value,
                lower=lower,
                upper=upper,
                unit=kind.unit,
                symbol=kind.symbol,
                support="" if kind.unit in ("kg", "Hz") else str(_quantity(name, None)[1]),
                inside=True,
                remarks=(),
                error=None,
                fe_error=abs(upper / value - 1.0),
                band="the finite elements' own error estimate",
                equation="",
            )
        return found


def _quantity(name: str, gamma_deg: float | None) -> tuple[str, Support]:
    quantity = name.removesuffix("_guided")
    if gamma_deg is not None:
        return quantity, Neighbors(gamma_deg, gamma_deg)
    return quantity, "pinned" if quantity == name else "guided"


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
        own = self.own
        lengths = [name for name, value in own.items() if isinstance(value, float) and value]
        for name, ends in self.ranges.items():
            unit = field_unit(name) or ""
            if name not in lengths or not unit:
                raise InputError(
                    f"vary: given {name!r}; {did_you_mean(name, lengths)}allowed are the throw's dimensions, "
                    f"{', '.join(lengths)}, because slopes are over what is there."
                )
            for end in ends:
                check_dimension(f"vary: {name}", name, end)
            (low, high), at = ends, float(own[name])
            if not low < high or low * high <= 0.0 or not low <= at <= high:
                shown = " to ".join(format_quantity(end, unit) for end in ends)
                raise InputError(
                    f"vary: given {name} from {shown}; allowed is a lower end, then a higher one, on one side of "
                    f"zero and around the engine's own {format_quantity(at, unit)}, where the search begins."
                )

    @cached_property
    def own(self) -> dict[str, Any]:
        """The dimensions and labels of the engine's throw."""
        return throw_values(self.engine_file.throw, spelled_out=True)

    @cached_property
    def throw(self) -> dict[str, Any]:
        """Record of the engine's throw."""
        return self.engine_file.throw.model_dump(mode="json")

    @cached_property
    def family(self) -> Family:
        """The dimensions that vary, and the others."""
        rest = {name: value for name, value in self.own.items() if name not in self.ranges}
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

    def analyzed(self, factors: Factors, asked: Sequence[Asked], accuracy: float) -> SlopedThrow:
        """Analyze a throw, with slopes of what is asked.

        Raises
        ------
        InputError, MeshError, SolveError
            If it cannot be built, meshed or solved, or a dimension has no slope.
        """
        of = analyze_throw(self.build(factors), self.engine_file.material, accuracy)
        joined = any(name in _FREQUENCIES or gamma is not None for name, gamma in asked)
        changes, left_out = dimension_changes(
            of.throw, of.mesh, of.material, of.classes, joined=joined, paths=self.ranges
        )
        for path, reason in left_out.items():
            if path in self.ranges:
                raise InputError(f"{path} has no slope here: {reason}")
        mass, inertia = of.mass, of.masses.inertia_about_shaft
        values = {
            each: self.answer(each, of.throw, of.superelement, mass, inertia)
            for each in dict.fromkeys([*((name, None) for name in QUANTITIES), *asked])
        }
        slopes = {}
        for each in asked:
            shares = []
            for change in (changes[path] for path in self.ranges):
                low, high = (
                    self.answer(
                        each,
                        throw,
                        end,
                        mass * (1.0 + side * change.mass),
                        inertia * (1.0 + side * change.inertia),
                    )
                    for side, throw, end in zip(
                        (-STEP, STEP), change.throws, change.ends, strict=True
                    )
                )
                shares.append((high - low) / (0.5 * (high + low)) / (2.0 * STEP))
            slopes[each] = np.array(shares)
        bands: dict[Asked, tuple[float, ...]] = {
            each: (value, *_ends(of, each, value)) for each, value in values.items()
        }
        dimensions = {**self.family.fixed, **factors}
        bands |= {(name, None): (value,) for name, value in dimensions.items()}
        return SlopedThrow(factors, bands, slopes)

    def answer(
        self, asked: Asked, throw: Any, element: Superelement, mass: float, inertia: float
    ) -> float:
        """A quantity of a throw [SI]."""
        name, gamma_deg = asked
        if name == "mass":
            return mass
        if name not in _FREQUENCIES:
            quantity, support = _quantity(name, gamma_deg)
            return compliance(element, cast(Any, quantity), support)
        changed = engine_with(self.engine_file, throw)
        shaft = shaft_compliances(
            [element] * len(changed.throw_angles_deg),
            crank_angles_deg=changed.throw_angles_deg,
            bearing_stiffness=changed.main_bearings.stiffness,
        )
        if _FREQUENCIES[name] == "axial":
            return first_frequency(engine_axial_chain(changed, shaft.axial, mass))
        inertias = engine_throw_inertias(changed, inertia)
        return first_frequency(engine_torsional_chain(changed, shaft.torsional, inertias))


def _ends(of: ThrowAnalysis, asked: Asked, value: float) -> tuple[float, float]:
    """Ends of the error band of a quantity."""
    name, gamma_deg = asked
    if name in _FREQUENCIES:
        # No frequency changes more than with the root of the throws' compliances.
        kind, supports = _FREQUENCIES[name], cast(tuple[Support, ...], ("pinned", "guided"))
        shares = [
            getattr(of.error_bars(s), kind) / abs(getattr(of.supported(s), kind)) for s in supports
        ]
        share = min(max(shares), 0.5)
        return value / math.sqrt(1.0 + share), value / math.sqrt(1.0 - share)
    if name == "mass":
        error = abs(value - of.material.density * cast(CrankThrow, of.throw).volume)
    else:
        quantity, support = _quantity(name, gamma_deg)
        error = abs(getattr(of.error_bars(support), _COMPLIANCES[quantity]))
    return value - error, value + error


def engine_with(engine_file: EngineFile, throw: CrankThrow) -> EngineFile:
    """Return the engine with another throw in place of its own; its stroke follows the crank radius."""
    names = engine_file.named_throws
    sections: dict[str, Any] = (
        {"throw": throw} if PLAIN in names else {"throws": dict.fromkeys(names, throw)}
    )
    if throw.crank_radius != engine_file.throw.crank_radius:
        share = throw.crank_radius / engine_file.throw.crank_radius
        sections["engine"] = {"stroke": engine_file.engine.stroke * share}
    return engine_file.changed(**sections)


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
    told : callable
        Hears a sentence before each analysis.
    """

    whole: Problem
    analyze: Callable[[Factors], SlopedThrow]
    refusal: Callable[[Factors], str]
    told: Callable[[str], None]
    found: list[SlopedThrow] = field(default_factory=list)
    # Sentences of throws that could not be analyzed, and of the last that could not be built.
    refused: list[str] = field(default_factory=list)

    def local(self, here: SlopedThrow, ranges: Mapping[str, tuple[float, float]]) -> _Local:
        """Return the search beside a throw."""
        space = replace(self.whole.space, ranges=dict(ranges))
        return _Local(**{**vars(self.whole), "space": space}, here=here, others=self.found)

    def rated(self, here: SlopedThrow) -> SearchResult:
        """Rate a throw by its own answers."""
        alone = replace(self.local(here, self.whole.space.ranges), others=())
        return best_of(alone, [alone.place(here.factors)], len(self.found))

    @property
    def best(self) -> tuple[SlopedThrow, SearchResult]:
        """The best throw that keeps the limits, else the nearest."""
        rated = [(one, self.rated(one)) for one in self.found]
        kept = [one for one in rated if one[1].broken <= SPARE]
        if kept:
            return min(kept, key=lambda one: one[1].objective)
        return min(rated, key=lambda one: one[1].broken)

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
        if self.found:
            value = format_quantity(self.best[1].objective, self.whole.unit, 5)
            kept = "best so far" if self.best[1].broken <= SPARE else "limits missed so far at"
            best = f", {kept} {self.whole.minimized.replace('_', ' ')} {value}"
        self.told(f"Analysis {len(self.found) + 1}{best}")
        try:
            self.found.append(self.analyze(factors))
        except (InputError, MeshError, SolveError) as error:
            self.refused.append(str(error))
            return None
        return self.found[-1]

    def buildable(self, here: Factors, change: Factors) -> Factors:
        """Return the farthest throw on the way to a change of some dimensions that can be built."""
        if not self.refusal({**here, **change}):
            return {**here, **change}
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            share = 0.5 * (low + high)
            part = {name: here[name] + share * (aim - here[name]) for name, aim in change.items()}
            low, high = (low, share) if self.refusal({**here, **part}) else (share, high)
        return {
            **here,
            **{name: here[name] + low * (aim - here[name]) for name, aim in change.items()},
        }

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
            found = best_of(local, places, 0)
            factors = cast(Factors, local.factors(found.place))
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
                found = best_of(local, [local.place(factors)], 0)
            at = [each for (name, last), each in refusals.items() if factors[name] == last]
            return found, factors, next(iter(at), refusal)

    def follow(self, start: Factors) -> None:
        """Follow slopes from a throw, until they promise no more."""
        here, reach = self.analyzed(start), REACH
        while here is not None and reach > LEAST_REACH and len(self.found) < MOST_ANALYSES:
            found, factors, _ = self.aim(here, reach)
            promise = self.gain(here, found)
            if promise < (NEARER if self.rated(here).broken > SPARE else PRECISION):
                break
            there = self.analyzed(factors)
            gained = -math.inf if there is None else self.gain(here, self.rated(there))
            far = float(np.abs(here.moves(factors)).max())
            reach = min(2.0 * reach, REACH) if gained > POOR * promise else 0.5 * min(reach, far)
            if there is not None and gained > 0.0:
                here = there

    def result(self, *found: str) -> Optimum:
        """Describe the best throw, with what is known of it; `InputError` if none keeps the limits."""
        here, now = self.best
        local = self.local(here, self.whole.space.ranges)
        if now.broken > SPARE:
            raise InputError(infeasible(local, now, "no throw of this search"))
        aim, _, refusal = self.aim(here, REACH)
        promise, remarks = self.gain(now, aim), list(found)
        if local.limits:
            band = (
                "at the worst end of the finite elements' error bars"
                if local.margins
                else "without margin for errors"
            )
            remarks.append(f"the limits are kept {band}, by an analysis of this very throw")
        remarks.append(
            f"{len(self.found)} analyses; slopes at this throw promise "
            + (
                f"no gain above {100.0 * PRECISION:g} %"
                if promise < PRECISION
                else f"{100.0 * promise:.2g} % more"
            )
            + f" within {100.0 * math.expm1(REACH):.0f} % of each dimension"
        )
        if refusal:
            remarks.append(f"better throws cannot be built: {refusal}")
        if self.refused:
            remarks.append(
                f"{len(self.refused)} throws could not be analyzed, the last because: {self.refused[-1]}"
            )
        return make_optimum(local, now, *remarks)


def best_throw(
    engine_file: EngineFile,
    vary: Mapping[str, tuple[float, float]],
    minimize: str,
    limits: Sequence[Limit] = (),
    *,
    margins: bool = True,
    accuracy: float = 0.01,
    told: Callable[[str], None] = lambda _: None,
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
    told : callable, optional
        Hears a sentence before each analysis.

    Raises
    ------
    InputError
        If a name is unknown, a range is impossible, or no throw found keeps the limits; the message then
        states the nearest one.
    SearchInterrupted
        On an interrupt; with the best throw so far.
    """
    family = ThrowFamily(engine_file, vary)
    check_minimized(family, minimize)
    for limit in limits:
        for name in limit.quantities:
            check_minimized(family, name, f"limit on {limit.name}")
    whole = Problem(
        family,
        minimize,
        tuple(limits),
        margins,
        search_space(family, {}),
        spare=SPARE,
        active=ACTIVE,
    )
    asked = [
        (minimize, None),
        *((name, limit.gamma_deg) for limit in limits for name in limit.quantities),
    ]
    asked = [each for each in dict.fromkeys(asked) if each[0] in QUANTITIES]
    search = ThrowSearch(
        whole, lambda factors: family.analyzed(factors, asked, accuracy), family.refusal, told
    )
    own = throw_values(engine_file.throw, spelled_out=True)
    middle = {name: 0.5 * (low + high) for name, (low, high) in vary.items()}
    try:
        search.follow({name: float(own[name]) for name in vary})
        if not search.found or search.best[1].broken > SPARE:
            search.follow(middle)
    except KeyboardInterrupt:
        kept = search.found and search.best[1].broken <= SPARE
        best = (
            search.result("the search was interrupted: this is the best throw so far")
            if kept
            else None
        )
        raise SearchInterrupted(best) from None
    if not search.found:
        raise InputError(f"vary: given ranges where no search can begin: {search.refused[0]}")
    return search.result()
