"""The best throw of an engine under limits, by finite elements and their slopes.

Sequential quadratic programming over the dimensions: each place is a throw that is analyzed, and the next one
follows from its values and slopes (`fem.sensitivities`). No study is needed. The optimum is a local one;
the search begins at the engine's own dimensions, and again in the middle of the ranges.
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
from fem.sensitivities import DimensionChange, dimension_changes
from fem.superelement import Superelement, shaft_compliances
from fem.supports import Neighbors, Support
from fem.wished_accuracy import COMPLIANCE_ACCURACY
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
    best_of,
    check_minimized,
    infeasible,
    make_optimum,
    nearest,
    polished,
    search,
    search_space,
)
from regression.plans.factors import rounded
from regression.throw_values import check_dimension, field_unit, throw_values

Array = NDArray[np.float64]

# Meshes scatter by some 0.03 %: what limits keep at places that are aimed at, what a limit has left that the
# optimum stands at, and the least gain that a step is worth.
SPARE, ACTIVE, PRECISION = 5e-4, 2e-3, 1e-3
# How far slopes are followed at once, as a share of a dimension, and the least worth an analysis.
REACH, LEAST_REACH = 0.3, 2e-3
# Of a violated limit, in shares of what is minimized.
PRICE = 5.0
# Slopes need throws beside one: a dimension ("" for none), and the factor that it is changed by.
Side = tuple[str, float]
ROOM = 4.0 * STEP

_COMPLIANCES = {
    "axial_compliance": "axial",
    "torsional_compliance": "torsional",
    "influence_coefficient": "influence",
}
_FREQUENCIES = {f"first_{kind}_frequency": kind for kind in ("axial", "torsional")}
# By the names that models of studies have: pinned ones without their support.
QUANTITIES = {
    f"{name}{suffix}": RESPONSES[f"{name}_{support}"]
    for support, suffix in (("pinned", ""), ("guided", "_guided"))
    for name in _COMPLIANCES
} | {
    "mass": RESPONSES["mass"],
    "first_axial_frequency": ResponseKind("f_a", "Hz", "first axial frequency of the crankshaft"),
    "first_torsional_frequency": ResponseKind("f_t", "Hz", "first torsional frequency of it"),
}


@dataclass(frozen=True, eq=False)
class AnalyzedThrow:
    """A throw of the search, analyzed by finite elements.

    Attributes
    ----------
    factors : dict
        The varied dimensions [SI]; the others are in `fixed`.
    changes : dict
        Its change with each of the varied dimensions.
    """

    engine_file: EngineFile
    factors: Mapping[str, float]
    fixed: Mapping[str, float]
    analysis: ThrowAnalysis
    changes: Mapping[str, DimensionChange]
    _bands: dict[tuple[str, float | None], tuple[float, ...]] = field(default_factory=dict)
    _shares: dict[tuple[str, float | None], dict[str, float]] = field(default_factory=dict)

    def band(self, name: str, gamma_deg: float | None = None) -> tuple[float, ...]:
        """Value of a quantity, and the ends of its error band; of a dimension the value alone."""
        if name in self.factors or name in self.fixed:
            return (self.factors[name] if name in self.factors else self.fixed[name],)
        if (name, gamma_deg) not in self._bands:
            self._bands[name, gamma_deg] = self._band(name, gamma_deg)
        return self._bands[name, gamma_deg]

    def _band(self, name: str, gamma_deg: float | None) -> tuple[float, ...]:
        of = self.analysis
        inertia = of.masses.inertia_about_shaft
        value = self._answer(name, gamma_deg, of.throw, of.superelement, of.mass, inertia)
        if name in _FREQUENCIES:
            # No frequency changes more than with the root of the throws' compliances.
            kind = _FREQUENCIES[name]
            errors = [
                getattr(of.error_bars(support), kind) / abs(getattr(of.supported(support), kind))
                for support in cast(tuple[Support, ...], ("pinned", "guided"))
            ]
            share = min(max(errors), 0.5)
            return value, value / math.sqrt(1.0 + share), value / math.sqrt(1.0 - share)
        if name == "mass":
            error = abs(value - of.material.density * cast(CrankThrow, of.throw).volume)
        else:
            quantity, support = _quantity(name, gamma_deg)
            error = abs(getattr(of.error_bars(support), _COMPLIANCES[quantity]))
        return value, value - error, value + error

    def shares(self, name: str, gamma_deg: float | None = None) -> dict[str, float]:
        """Return d ln(quantity) / d ln(dimension) over each of the varied dimensions."""
        if (name, gamma_deg) not in self._shares:
            self._shares[name, gamma_deg] = {
                path: self._share(name, gamma_deg, path) for path in self.factors
            }
        return self._shares[name, gamma_deg]

    def _share(self, name: str, gamma_deg: float | None, path: str) -> float:
        if name in self.factors or name in self.fixed:
            return float(name == path)
        change = self.changes[path]
        if name == "mass":
            return change.mass
        of, sides = self.analysis, (-STEP, STEP)
        low, high = (
            self._answer(
                name,
                gamma_deg,
                throw,
                end,
                of.mass * (1.0 + side * change.mass),
                of.masses.inertia_about_shaft * (1.0 + side * change.inertia),
            )
            for side, throw, end in zip(sides, change.throws, change.ends, strict=True)
        )
        return (high - low) / (0.5 * (high + low)) / (2.0 * STEP)

    def _answer(
        self,
        name: str,
        gamma_deg: float | None,
        throw: Any,
        element: Superelement,
        mass: float,
        inertia: float,
    ) -> float:
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


@dataclass(frozen=True, eq=False)
class _Beside:
    """Throws beside an analyzed one by its slopes: powers of the dimensions."""

    throw: AnalyzedThrow
    factors: Mapping[str, Any]

    def band(self, name: str, gamma_deg: float | None = None) -> tuple[float, ...]:
        throw = self.throw
        shares = throw.shares(name, gamma_deg)
        change = math.prod(
            (value / throw.factors[path]) ** shares[path] for path, value in self.factors.items()
        )
        return tuple(value * change for value in throw.band(name, gamma_deg))


def _quantity(name: str, gamma_deg: float | None) -> tuple[str, Support]:
    quantity = name.removesuffix("_guided")
    if gamma_deg is not None:
        return quantity, Neighbors(gamma_deg, gamma_deg)
    return quantity, "pinned" if quantity == name else "guided"


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


@dataclass(frozen=True, eq=False)
class ThrowFamily:
    """The throws between which an engine's is sought: some dimensions vary, the others stay.

    Parameters
    ----------
    engine_file : EngineFile
        All its cranks are one throw.
    ranges : mapping
        Dimension ("web_width", "counterweight.thickness") to its least and largest value [SI].

    Raises
    ------
    InputError
        If the engine has several throws, or a dimension is unknown, absent from the throw or has no range.
    """

    engine_file: EngineFile
    ranges: Mapping[str, tuple[float, float]]
    accuracy: float = 0.01
    # Sentences of throws that could not be built or analyzed; throws by their place.
    refused: list[str] = field(default_factory=list)
    found: dict[tuple[float, ...], AnalyzedThrow | None] = field(default_factory=dict)
    constraints: tuple[str, ...] = ()

    responses = QUANTITIES

    def __post_init__(self) -> None:
        check_one_throw(self.engine_file)
        COMPLIANCE_ACCURACY.checked("accuracy", self.accuracy)
        if not self.ranges:
            raise InputError(
                "vary: given no dimension; allowed are one or more, each with a range."
            )
        own = self.own
        for name, (low, high) in self.ranges.items():
            if not field_unit(name) or not isinstance(own.get(name), float):
                names = [each for each, value in own.items() if not isinstance(value, str)]
                raise InputError(
                    f"vary: given {name!r}; {did_you_mean(name, names)}allowed are the throw's dimensions, "
                    f"{', '.join(names)}, because slopes are over what is there."
                )
            if not low < high:
                raise InputError(
                    f"vary: given {name} from {format_quantity(low, field_unit(name) or '')} to "
                    f"{format_quantity(high, field_unit(name) or '')}; allowed is a lower end first."
                )
            for end in (low, high):
                check_dimension(f"vary: {name}", name, end)

    @property
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
        return Family(
            ranges=self.ranges,
            fixed={name: value for name, value in rest.items() if not isinstance(value, str)},
            labels={name: value for name, value in rest.items() if isinstance(value, str)},
        )

    def build(self, factors: Mapping[str, Any]) -> CrankThrow:
        """Return the throw of some dimensions; `InputError` if it cannot be built."""
        return CrankThrow(**changed_record(self.throw, factors))

    def refused_sides(
        self, factors: Mapping[str, Any], sides: Sequence[Side] | None = None
    ) -> list[Side]:
        """Throws that cannot be built: this one, or with a dimension a little smaller or larger."""
        refused = []
        beside = [(name, 1.0 + way * ROOM) for name in self.ranges for way in (-1.0, 1.0)]
        for side in [("", 1.0), *beside] if sides is None else sides:
            try:
                self.build({n: v * side[1] if n == side[0] else v for n, v in factors.items()})
            except InputError:
                refused.append(side)
        return refused

    def analyzed(self, factors: Mapping[str, float]) -> AnalyzedThrow | None:
        """Return the throw of some dimensions, each analyzed once; None if that is impossible."""
        key = tuple(rounded(factors[name]) for name in self.ranges)
        if key not in self.found:
            self.found[key] = None
            try:
                throw = self.build(factors)
                engine_file = engine_with(self.engine_file, throw)
                of = analyze_throw(throw, engine_file.material, self.accuracy)
                changes, left_out = dimension_changes(
                    throw, of.mesh, of.material, of.classes, joined=True, paths=self.ranges
                )
                if left_out := {path: left_out[path] for path in self.ranges if path in left_out}:
                    path, reason = next(iter(left_out.items()))
                    raise InputError(f"{path} has no slope here: {reason}")
                self.found[key] = AnalyzedThrow(
                    engine_file, dict(factors), self.family.fixed, of, changes
                )
            except (InputError, MeshError, SolveError) as error:
                self.refused.append(str(error))
        return self.found[key]

    @property
    def count(self) -> int:
        """How many throws are analyzed."""
        return sum(throw is not None for throw in self.found.values())

    def lookup(self, name: str, /, **factors: Any) -> Lookup:
        """One response at analyzed dimensions, with its error bar."""
        throw = self.analyzed({each: factors[each] for each in self.ranges})
        assert throw is not None
        value, lower, upper = throw.band(name)
        kind = QUANTITIES[name]
        return Lookup(
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


@dataclass(frozen=True)
class _LocalProblem(Problem):
    """A search beside one analyzed throw, by its slopes; among throws that can be built on some sides."""

    throw: AnalyzedThrow | None = None
    sides: tuple[Side, ...] = ()

    def points(self, places: Array) -> Banded:
        assert self.throw is not None
        near = self.factors(places) if places.ndim == 1 else self.space.numbers(places)
        return _Beside(self.throw, near)

    def excess(self, places: Array) -> Array:
        violations = super().excess(places)
        if not self.sides:
            return violations
        throws = cast(ThrowFamily, self.model)
        columns = map(self.factors, places.reshape(len(places), -1).T)
        row = np.array([float(len(throws.refused_sides(one, self.sides))) for one in columns])
        return np.concatenate([violations, row.reshape(1, *places.shape[1:])])


@dataclass(frozen=True)
class _AnalyzedProblem(Problem):
    """A search whose every place is analyzed; `told` hears of each new one."""

    told: Callable[[str], None] | None = None

    @property
    def throws(self) -> ThrowFamily:
        return cast(ThrowFamily, self.model)

    def analyzed(self, factors: Mapping[str, float]) -> AnalyzedThrow | None:
        known = self.throws.count
        throw = self.throws.analyzed(factors)
        if throw is not None and self.told is not None and self.throws.count > known:
            value, most = self.judged(throw)
            shown = f"{self.minimized.replace('_', ' ')} {format_quantity(value, self.unit, 5)}"
            missed = "kept" if most <= 0.0 else f"missed by {100.0 * most:.2g} %"
            limits = f", limits {missed}" if self.limits else ""
            self.told(f"analysis {known + 1}: {shown}{limits}")
        return throw

    def points(self, places: Array) -> AnalyzedThrow:
        throw = self.throws.analyzed(cast(dict[str, float], self.factors(places)))
        assert throw is not None
        return throw

    def judged(self, throw: AnalyzedThrow) -> tuple[float, float]:
        """Value of what is minimized, and the largest violation of a limit."""
        violations = self.excess(self.place(throw)) - self.spare
        return float(throw.band(self.minimized)[0]), float(np.max(violations, initial=-1.0))

    def place(self, throw: AnalyzedThrow) -> Array:
        lows, highs = np.array([*self.space.ranges.values()]).T
        return np.asarray((np.array([*throw.factors.values()]) - lows) / (highs - lows))

    def merit(self, throw: AnalyzedThrow, size: float) -> float:
        """What a step must make smaller: the value, and violations at a price."""
        value, broken = self.judged(throw)
        return value / size + PRICE * max(broken, 0.0)

    def searched(self, start: Mapping[str, float]) -> AnalyzedThrow | None:
        """Follow the slopes from a throw; None if it cannot be analyzed."""
        here, reach = self.analyzed(start), REACH
        if here is None:
            return None
        size = abs(here.band(self.minimized)[0]) or 1.0
        while reach > LEAST_REACH:
            aim = self._aim(here, reach)
            if np.allclose([*aim.values()], [*here.factors.values()], rtol=SPARE):
                break
            there = self.analyzed(aim)
            if there is None or self.merit(there, size) > self.merit(here, size) - PRECISION:
                reach *= 0.5
            else:
                here = there
        return here

    def _aim(self, here: AnalyzedThrow, reach: float) -> dict[str, float]:
        """Return the best dimensions within reach by the slopes of a throw."""
        ranges = {
            name: (max(low, value * (1.0 - reach)), min(high, value * (1.0 + reach)))
            for (name, (low, high)), value in zip(
                self.space.ranges.items(), here.factors.values(), strict=True
            )
        }
        space = replace(self.space, ranges=ranges)
        shared = (self.model, self.minimized, self.limits, self.margins, space)
        local = _LocalProblem(*shared, spare=self.spare, throw=here)
        lows, highs = np.array([*ranges.values()]).T
        start = (np.array([*here.factors.values()]) - lows) / (highs - lows)
        places = [polished(local, start)]
        if self.limits:
            near = nearest(local, start)
            places += [near, polished(local, near)]
        aim = cast(dict[str, float], local.factors(best_of(local, places, 0).place))
        # Where throws end is known by trying alone: first the throw itself, then those beside it.
        sides: list[Side] = []
        while refused := [side for side in self.throws.refused_sides(aim) if side not in sides]:
            sides += refused if sides else refused[:1]
            edge = search(replace(local, sides=tuple(sides)))
            aim = cast(dict[str, float], local.factors(edge.place))
        return aim


def best_throw(
    engine_file: EngineFile,
    vary: Mapping[str, tuple[float, float]],
    minimize: str,
    limits: Sequence[Limit] = (),
    *,
    margins: bool = True,
    accuracy: float = 0.01,
    told: Callable[[str], None] | None = None,
) -> Optimum:
    """Find the throw of an engine with the smallest value of a dimension or response that keeps limits.

    Every throw of the search is analyzed by finite elements, about a second each, ten to thirty in all; an
    interrupt ends the search with the best throw so far. The optimum is a local one.

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
        Hears a sentence about each throw analyzed.

    Raises
    ------
    InputError
        If a name is unknown, a range is impossible, or no throw found keeps the limits; the message then
        states the nearest one.
    """
    family = ThrowFamily(engine_file, vary, accuracy)
    check_minimized(family, minimize)
    for limit in limits:
        for name in limit.quantities:
            check_minimized(family, name, f"limit on {limit.name}")
    problem = _AnalyzedProblem(
        family,
        minimize,
        tuple(limits),
        margins,
        search_space(family, {}),
        spare=SPARE,
        active=ACTIVE,
        told=told,
    )
    own = {name: float(family.own[name]) for name in vary}
    starts = [
        {name: min(max(own[name], low), high) for name, (low, high) in vary.items()},
        {name: 0.5 * (low + high) for name, (low, high) in vary.items()},
    ]
    ends, interrupted = [], False
    try:
        ends = [end for start in starts if (end := problem.searched(start)) is not None]
    except KeyboardInterrupt:
        interrupted = True
    throws = [throw for throw in family.found.values() if throw is not None]
    if not throws:
        if interrupted:
            raise KeyboardInterrupt
        raise InputError(f"vary: given ranges where no search can begin: {family.refused[0]}")
    best = best_of(problem, [problem.place(throw) for throw in throws], family.count)
    if best.broken > SPARE:
        raise InputError(infeasible(problem, best, "no throw of this search"))
    return make_optimum(problem, best, *_remarks(problem, ends, interrupted))


def _remarks(
    problem: _AnalyzedProblem, ends: Sequence[AnalyzedThrow], interrupted: bool
) -> list[str]:
    """State what is known about the optimum."""
    remarks, refused = [], problem.throws.refused
    if problem.limits:
        band = "at the worst end of the finite elements' error bars"
        remarks.append(
            f"the limits are kept {band if problem.margins else 'without margin for errors'}, by an "
            "analysis of this very throw"
        )
    if interrupted:
        remarks.append("the search was interrupted: this is the best throw so far")
    else:
        values = [
            format_quantity(value, problem.unit, 5)
            for value, broken in map(problem.judged, ends)
            if broken <= 0.0
        ]
        remarks.append(
            "a local optimum: the searches from the engine's throw and from the middle of the ranges ended "
            f"at {' and '.join(values)}"
        )
    if refused:
        remarks.append(
            f"{len(refused)} of the throws could not be built or analyzed, the last because: {refused[-1]}"
        )
    return remarks
