"""Results of an optimum search: the best throw, and the use of its limits."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from scipy import optimize

from crankbase.array_checks import LARGEST, SMALLEST, Array
from crankbase.choices import did_you_mean, is_number
from crankbase.diagrams import RED, draw_groups, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, table
from crankbase.quantity import format_quantity
from crankbase.summaries import frozen
from geometry.throw import CrankThrow
from regression.models.angle import between_values
from regression.models.compliance_model import ComplianceModel
from regression.models.family import Family
from regression.models.lookup import Lookup
from regression.models.response_query import edges, error_band
from regression.response_kinds import ANGLE_LAWS
from regression.throw_values import field_unit


@dataclass(frozen=True)
class Limit:
    """A bound on a response or dimension of a model, or on a function of some.

    Parameters
    ----------
    quantities : tuple of str
        Responses of the model or dimensions; one, or the arguments of `function`.
    at_most, at_least : float or None
        The bound [SI]; one of the two.
    function : callable, optional
        Takes one float for each quantity, in order, and returns a float, for example a frequency from a
        compliance. It should be monotonic in each of them, since only the ends of their bands
        are tried. By default the quantity itself is limited.
    name : str
        Its name; by default the quantity's.
    unit : str
        SI unit for messages.
    gamma_deg : float, optional
        Angle to the neighbors for the axial compliance or influence coefficient among the quantities.

    Raises
    ------
    InputError
        If not one bound is given, or several quantities without a function.

    Examples
    --------
    ``Limit(("axial_compliance",), at_most=1.2e-9)``
    """

    quantities: tuple[str, ...]
    at_most: float | None = None
    at_least: float | None = None
    function: Callable[..., float] | None = None
    name: str = ""
    unit: str = ""
    gamma_deg: float | None = None

    def __post_init__(self) -> None:
        shown = self.name or ", ".join(self.quantities)
        bounds = [bound for bound in (self.at_most, self.at_least) if bound is not None]
        if len(bounds) != 1 or not is_number(bounds[0]):
            raise InputError(
                f"limit on {shown}: given at most {self.at_most}, at least {self.at_least}; allowed is "
                "one finite bound, because each limit is checked by itself."
            )
        if bounds[0] != 0.0 and not SMALLEST <= abs(bounds[0]) <= LARGEST:
            raise InputError(
                f"limit on {shown}: given {bounds[0]:g}; allowed is zero, or {SMALLEST:g} to {LARGEST:g} of "
                "either sign, because others leave what a computer can calculate."
            )
        if isinstance(self.quantities, str) or not self.quantities:
            raise InputError(
                f"limit: given quantities {self.quantities!r}; allowed is a tuple of names, at least "
                "one."
            )
        if self.function is None and len(self.quantities) != 1:
            raise InputError(
                f"limit on {shown}: given {len(self.quantities)} quantities; allowed is one, or a "
                "function of them."
            )
        if not self.name:
            object.__setattr__(self, "name", shown)

    @property
    def bound(self) -> float:
        """The bound, from above or below."""
        bound = self.at_most if self.at_most is not None else self.at_least
        assert bound is not None
        return bound

    @property
    def sign(self) -> str:
        """The comparison as text."""
        return "<=" if self.at_most is not None else ">="

    def excess(self, values: Any) -> Any:
        """Distance of values beyond the bound, as a share of it; negative where they keep it."""
        size = abs(self.bound) or 1.0
        beyond = (values - self.bound) / size
        return beyond if self.at_most is not None else -beyond


class Banded(Protocol):
    """Throws whose dimensions and responses are known, these with their error bands."""

    def band(self, name: str, gamma_deg: float | None = None) -> tuple[Any, ...]:
        """Value of a quantity, and the ends of its error band if it has one."""


class Searched(Protocol):
    """What is searched: a family of throws, with units and answers of the responses."""

    @property
    def family(self) -> Family:
        """Its dimensions."""

    @property
    def responses(self) -> Mapping[str, Any]:
        """Its responses, each with a unit."""

    @property
    def throw(self) -> Mapping[str, Any] | None:
        """Record of the throw that is varied."""

    @property
    def constraints(self) -> Sequence[str] | None:
        """What the dimensions keep."""


def check_known(model: Searched, name: str, argument: str = "minimize") -> None:
    """Refuse what is no number of the model (`InputError` on `argument`)."""
    if name not in model.responses and name not in model.family.all_units:
        raise _unknown(argument, model, name)


def _unknown(argument: str, model: Searched, name: str) -> InputError:
    family = model.family
    names = (*family.ranges, *family.relations, *family.fixed)
    meant = did_you_mean(name, (*model.responses, *names))
    studied = ""
    if name.startswith("fillet_stress"):
        studied = "; the model of a study with stresses = true has fillet_stress_factor"
    return InputError(
        f"{argument}: given {name!r}; {meant}allowed are the responses {', '.join(model.responses)} and the "
        f"dimensions {', '.join(names)}{studied}."
    )


@dataclass(frozen=True)
class Points:
    """Throws of a model's family: all its factors, as numbers, labels, or arrays of n values."""

    model: ComplianceModel
    factors: Mapping[str, Any]

    def dimension(self, name: str) -> Any:
        """Value of a factor, a fixed dimension or one that follows from others.

        `InputError` if there is none.
        """
        if name in self.factors:
            return self.factors[name]
        family = self.model.family
        if name in family.fixed:
            return family.fixed[name]
        if name in family.relations:
            return family.completed(self.factors)[name]
        raise _unknown("quantity", self.model, name)

    def band(self, name: str, gamma_deg: float | None = None) -> tuple[Any, ...]:
        """Value of a quantity, and the ends of its error band if it has one.

        `InputError` if the model knows no such quantity, or its band is open on one side.
        """
        if gamma_deg is not None and name in ANGLE_LAWS:
            return angle_band(self, self.model.angle_law(name), gamma_deg)
        if name not in self.model.responses:
            return (self.dimension(name),)
        band = error_band(self.model.responses[name])
        if band.upper is None:
            raise InputError(
                f"{name}: given a model whose error reaches 100 %; allowed is a better one, because "
                "with this no limit can be promised."
            )
        answer = self.model.answer(name, self.factors)
        return answer.values, *band.around(answer.values, True, answer.errors)


def angle_band(points: Banded, parts: Sequence[str], gamma_deg: float) -> tuple[Any, ...]:
    """Value between neighbors and the ends of its error band, from those of the angle law's parts."""
    bands = [points.band(part) for part in parts]
    corners = [between_values(gamma_deg, corner) for corner in itertools.product(*bands)]
    return corners[0], np.min(corners, axis=0), np.max(corners, axis=0)


def worst_values(limit: Limit, points: Banded, margins: bool) -> Any:
    """Worst values of a limit's quantity within the error bands; without `margins` by the equations.

    `InputError` if a quantity is unknown or has no band, or a function of it is not finite.
    """
    bands = [points.band(name, limit.gamma_deg) for name in limit.quantities]
    if not margins:
        return _applied(limit, [band[0] for band in bands])
    # The value itself lies between the ends of its band, where it has one.
    ends = [band[1:] or band for band in bands]
    corners = [_applied(limit, list(corner)) for corner in itertools.product(*ends)]
    farthest = np.max if limit.at_most is not None else np.min
    return farthest(corners, axis=0)


def _applied(limit: Limit, values: list[Any]) -> Any:
    if limit.function is None:
        return values[0]
    arrays = np.broadcast_arrays(*values)
    reached = np.array(
        [limit.function(*map(float, point)) for point in zip(*map(np.ravel, arrays), strict=True)]
    ).reshape(arrays[0].shape)
    if not np.all(np.isfinite(reached)):
        raise InputError(
            f"{limit.name}: given a function that returns {reached[~np.isfinite(reached)].flat[0]}; "
            "allowed are finite numbers."
        )
    return reached


# Share of a range within which a place is its end; limits have more than this to spare.
_AT_END = 1e-10

# How far constraints are broken by factors; 0 or less is kept.
Excess = Callable[[Mapping[str, Any]], Any]


@dataclass(frozen=True)
class SearchSpace:
    """A box of numbers, 0 to 1 each, and choices; `fixed` numbers and `labels` stay."""

    model: Searched
    ranges: dict[str, tuple[float, float]]
    fixed: dict[str, float]
    choices: dict[str, tuple[str, ...]]
    labels: dict[str, str]
    constraints: tuple[Excess, ...]

    def numbers(self, places: Array) -> dict[str, Any]:
        """Factors at points of the box, (dimensions,) or (dimensions, n)."""
        ends = self.ranges.values()
        varied = {
            name: low + place * (high - low)
            for name, place, (low, high) in zip(self.ranges, places, ends, strict=True)
        }
        known = varied | self.fixed
        return {name: known[name] for name in self.model.family.ranges}

    def exact_numbers(self, place: Array) -> dict[str, float]:
        """Factors at one point, the ends of ranges to the last digit."""
        exact = {name: float(value) for name, value in self.numbers(place).items()}
        for (name, (low, high)), where in zip(self.ranges.items(), place, strict=True):
            if min(where, 1.0 - where) < _AT_END:
                exact[name] = low if where < 0.5 else high
        return exact

    def at_ends(self, place: Array) -> tuple[str, ...]:
        """Numbers at an end of their range."""
        return tuple(
            name
            for name, where in zip(self.ranges, place, strict=True)
            if min(where, 1.0 - where) < _AT_END
        )

    def excess(self, factors: Mapping[str, Any]) -> list[Any]:
        """Violation of the study's constraints."""
        return [constraint(factors) for constraint in self.constraints]

    def throw(self, known: Mapping[str, float | str]) -> tuple[CrankThrow | None, list[str]]:
        """Build the throw of some dimensions, or say why it cannot be built."""
        if self.model.throw is None:
            return None, []
        from geometry.throw_dimensions import changed_record
        from regression.throw_values import declaration

        record = CrankThrow(**self.model.throw).model_dump(mode="json")
        fields = {name: value for name, value in known.items() if declaration(name) is not None}
        try:
            return CrankThrow(**changed_record(record, fields)), []
        except InputError as error:
            return None, [f"this throw cannot be built: {error}"]


def search_space(model: Searched, fixed: Mapping[str, float | str]) -> SearchSpace:
    """Set up the box of a search; `InputError` if a fixed factor is unknown or outside its range."""
    family = model.family
    numbers: dict[str, float] = {}
    labels: dict[str, str] = {}
    for name, value in family.checked(fixed).items():
        if name in family.categories:
            labels[name] = value
            continue
        if name not in family.ranges:
            raise InputError(
                f"fixed: given {name}; allowed are the factors {', '.join(family.factors)}, because "
                "other dimensions do not vary anyway."
            )
        low, high = edges(*family.ranges[name])
        if not low <= value <= high:
            raise InputError(
                f"fixed: given {family.format_value(name, value)} for {name}; allowed is "
                f"{family.format_value(name, family.ranges[name][0])} to "
                f"{family.format_value(name, family.ranges[name][1])}, the range of the model."
            )
        numbers[name] = float(value)
    constraints = [_constraint(model, text) for text in model.constraints or ()]
    return SearchSpace(
        model=model,
        ranges={name: ends for name, ends in family.ranges.items() if name not in numbers},
        fixed=numbers,
        choices={
            name: labels_of for name, labels_of in family.categories.items() if name not in labels
        },
        labels=labels,
        constraints=tuple(constraints),
    )


def _constraint(model: Searched, text: str) -> Excess:
    """A constraint of the study as a function that is 0 or less if it is met."""
    from regression.plans.relations import constraint_excess, read_constraint

    units = model.family.all_units
    read = read_constraint(text, "constraint", units)

    def excess(factors: Mapping[str, Any]) -> Any:
        known = model.family.completed(factors)
        used = {name: known[name] for name in read.names}
        values = dict(zip(used, np.broadcast_arrays(*used.values()), strict=True))
        return constraint_excess(read, values, units)

    return excess


@dataclass(frozen=True)
class LimitCheck:
    """A limit at the optimum: its value by the equation, and at the worst end of the band.

    That end keeps the bound, without margins the value. `active`: whether the optimum is at this limit.
    """

    limit: Limit
    value: float
    worst: float
    active: bool


@frozen("minimized", "value", "unit", "factors", "limits", "remarks")
class Optimum:
    """The best throw under limits.

    Attributes
    ----------
    minimized : str
        Minimized quantity: a dimension or a response.
    value : float
        Its value [SI]; of a response, by the equation.
    dimensions : dict
        All known dimensions and labels of the throw.
    factors : dict
        The model's factors.
    at_ends : tuple of str
        Factors at an end of their range.
    lookups : dict of str to Lookup
        All responses of the model at the optimum.
    throw : CrankThrow or None
        The throw, if the model contains the one that was varied and this can be built.
    evaluations : int
        Designs evaluated.
    """

    minimized: str
    value: float
    unit: str
    dimensions: dict[str, float | str]
    factors: dict[str, float | str]
    limits: tuple[LimitCheck, ...]
    at_ends: tuple[str, ...]
    lookups: dict[str, Lookup]
    throw: CrankThrow | None
    remarks: tuple[str, ...]
    evaluations: int

    def __repr__(self) -> str:
        """Summarize the optimum in a line; throw and lookups would fill screens."""
        at = ", ".join(
            f"{name} {value if isinstance(value, str) else f'{value:.6g}'}"
            for name, value in self.factors.items()
        )
        active = ", ".join(check.limit.name for check in self.limits if check.active)
        limits = f", at the limit of {active}" if active else ""
        return (
            f"Optimum({self.minimized} {self.value:.6g} {self.unit}".rstrip() + f" at {at}{limits})"
        )

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the use of each limit, by the equation and at the worst end of its error band.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.

        Raises
        ------
        InputError
            If the optimum was found without limits, or a bound is 0.
        """
        if not self.limits or any(check.limit.bound == 0.0 for check in self.limits):
            raise InputError(
                f"limits: given {', '.join(c.limit.name for c in self.limits) or 'none'}; allowed for a "
                "plot are one or more whose bound is not 0, because values are drawn as a share of it."
            )
        names = [
            f"{check.limit.name} {check.limit.sign} {format_quantity(check.limit.bound, check.limit.unit)}"
            for check in self.limits
        ]
        shares = {
            "value": [100.0 * check.value / check.limit.bound for check in self.limits],
            "worst in its error band": [
                100.0 * check.worst / check.limit.bound for check in self.limits
            ],
        }
        axes = new_axes(axes)
        draw_groups(axes, names, shares, "share of the bound [%]")
        axes.axhline(100.0, color=RED, linestyle="--", linewidth=1.2)
        write_title(axes, f"Limits at the least {self.minimized.replace('_', ' ')}")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the optimum: its factors, its other dimensions, and its responses.

        Returns
        -------
        pandas.DataFrame
            ``name``, ``kind`` ("factor", "dimension", "response"), ``value`` [SI] and ``unit``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        rows: list[tuple[str, str, float | str, str]] = [
            (name, "factor" if name in self.factors else "dimension", value, field_unit(name) or "")
            for name, value in {**self.factors, **self.dimensions}.items()
        ]
        rows += [
            (name, "response", answer.value, answer.unit) for name, answer in self.lookups.items()
        ]
        names, kinds, values, units = zip(*rows, strict=True)
        return table(
            {
                "name": (names, ""),
                "kind": (kinds, ""),
                "value": (values, "SI, see the column unit"),
                "unit": (units, ""),
            }
        )


_optimize: Any = optimize  # its declarations know no vectorized functions

# Limits are kept with this to spare, as a share of the bound, so that rounding breaks none.
SPARE = 1e-9
# A limit with less than this left is one that the optimum stands at.
ACTIVE = 1e-6
_GENERATIONS, _POPULATION = 80, 12


@dataclass(frozen=True)
class Problem:
    """One search: over the numbers of a box, with the labels set.

    `spare` is what limits are to keep, as a share of the bound, and `active` what one has left that the
    optimum stands at.
    """

    model: Searched
    minimized: str
    limits: tuple[Limit, ...]
    margins: bool
    space: SearchSpace
    labels: Mapping[str, str] = field(default_factory=dict)
    spare: float = SPARE
    active: float = ACTIVE

    @property
    def unit(self) -> str:
        """SI unit of what is minimized."""
        response = self.model.responses.get(self.minimized)
        unit = self.model.family.unit(self.minimized) if response is None else response.unit
        return str(unit)

    def points(self, places: Array) -> Banded:
        """Throws at places of the box, (dimensions,) or (dimensions, n)."""
        assert isinstance(self.model, ComplianceModel)
        if places.ndim == 1:
            return Points(self.model, self.factors(places))
        return Points(self.model, {**self.space.numbers(places), **self.labels})

    def factors(self, place: Array) -> dict[str, float | str]:
        """Factors at a place of the box."""
        return {**self.space.exact_numbers(place), **self.labels}

    def lookups(self, factors: Mapping[str, Any]) -> dict[str, Lookup]:
        """All responses of some factors."""
        assert isinstance(self.model, ComplianceModel)
        return {name: self.model.lookup(name, **factors) for name in self.model.responses}

    def objective(self, places: Array) -> Array:
        """Values of what is minimized, (n,)."""
        if places.size == 0:  # differential evolution asks so where no design keeps the limits
            return np.zeros(places.shape[1:])
        value = self.points(places).band(self.minimized)[0]
        return np.broadcast_to(value, places.shape[1:])

    def excess(self, places: Array) -> Array:
        """Violation of each limit, as a share of its bound, (limits, n); 0 or less is kept."""
        points = self.points(places)
        rows = [
            limit.excess(worst_values(limit, points, self.margins)) + self.spare
            for limit in self.limits
        ]
        rows += self.space.excess({**self.space.numbers(places), **self.labels})
        shape = places.shape[1:]
        return np.array([np.broadcast_to(row, shape) for row in rows]).reshape(len(rows), *shape)


@dataclass(frozen=True)
class SearchResult:
    """The best place found; `broken` is 0 or less than the spare where limits are kept."""

    place: Array
    objective: float
    broken: float
    evaluations: int


def find_optimum(
    model: ComplianceModel,
    minimize: str,
    limits: Sequence[Limit] = (),
    *,
    fixed: Mapping[str, float | str] | None = None,
    margins: bool = True,
) -> Optimum:
    """Find the throw with the smallest value of a dimension or response that keeps limits.

    Parameters
    ----------
    minimize : str
        A dimension, such as "web_thickness", or a response, such as "mass".
    fixed : mapping, optional
        Fixed factors, and their values [SI] or labels.
    margins : bool
        Whether limits must be kept at the worst end of the error band; otherwise by the
        equation's own value.

    Returns
    -------
    Optimum
        Identical for identical arguments.

    Raises
    ------
    InputError
        If a name is unknown, nothing is left to vary, or no throw of the family keeps the limits; the
        message then states the nearest one.
    """
    check_known(model, minimize)
    space = search_space(model, fixed or {})
    choices = [
        dict(zip(space.choices, labels, strict=True))
        for labels in itertools.product(*space.choices.values())
    ]
    problems = [
        Problem(model, minimize, tuple(limits), margins, space, space.labels | labels)
        for labels in choices
    ]
    try:
        searched = [search(problem) for problem in problems]
    except RuntimeError as error:
        # The optimizer takes every ValueError for one of its own.
        if isinstance(error.__cause__, InputError):
            raise error.__cause__ from None
        raise
    feasible = [n for n, attempt in enumerate(searched) if attempt.broken <= SPARE]
    if not feasible:
        nearest = min(range(len(searched)), key=lambda n: searched[n].broken)
        raise InputError(infeasible(problems[nearest], searched[nearest]))
    best = min(feasible, key=lambda n: searched[n].objective)
    kept = (
        "the limits are kept at the worst end of the model's error band"
        if margins
        else "the limits are kept by the equations' values, without margin for their errors"
    )
    whole = replace(searched[best], evaluations=sum(attempt.evaluations for attempt in searched))
    return make_optimum(problems[best], whole, *([kept] if limits else []))


def search(problem: Problem) -> SearchResult:
    """Search for the best design that keeps the limits; else for the one with the least violation."""
    count = 0

    def objective(places: Array) -> Array:
        nonlocal count
        count += places.shape[1] if places.ndim == 2 else 1
        return problem.objective(places)

    dimensions = len(problem.space.ranges)
    if dimensions == 0:
        alone = np.zeros(0)
        return SearchResult(alone, *_evaluate(problem, alone), 1)
    box = [(0.0, 1.0)] * dimensions
    settings: dict[str, Any] = {
        "maxiter": _GENERATIONS,
        "popsize": _POPULATION,
        "init": "sobol",
        "tol": 1e-8,
        "seed": 1,
        "polish": False,
        "vectorized": True,
        "updating": "deferred",
    }
    limited = problem.excess(np.full((dimensions, 1), 0.5)).size > 0
    constraints = (_optimize.NonlinearConstraint(problem.excess, -np.inf, 0.0),) if limited else ()
    start = _optimize.differential_evolution(objective, box, constraints=constraints, **settings).x
    candidates = [start, polished(problem, start)]
    if min(_evaluate(problem, place)[1] for place in candidates) > SPARE:
        start = _optimize.differential_evolution(
            lambda places: np.max(problem.excess(places), axis=0), box, **settings
        ).x
        candidates = [start, nearest(problem, start)]
        candidates += [polished(problem, place) for place in tuple(candidates)]
    return best_of(problem, candidates, count)


def best_of(problem: Problem, candidates: Sequence[Array], evaluations: int) -> SearchResult:
    """Return the best place that keeps the limits, else that with the least violation."""
    rated = [(_evaluate(problem, place), place) for place in candidates]
    kept = [trial for trial in rated if trial[0][1] <= problem.spare]
    if kept:
        (value, broken), place = min(kept, key=lambda trial: trial[0][0])
    else:
        (value, broken), place = min(rated, key=lambda trial: trial[0][1])
    return SearchResult(place, value, broken, evaluations)


def _evaluate(problem: Problem, place: Array) -> tuple[float, float]:
    """Objective, and the violation of the limits."""
    broken = problem.excess(place)
    return float(problem.objective(place)), float(np.max(broken)) if broken.size else 0.0


def polished(problem: Problem, start: Array) -> Array:
    """Move a design to its limits by sequential quadratic programming."""
    size = abs(float(problem.objective(start))) or 1.0
    solution = _optimize.minimize(
        lambda place: float(problem.objective(place)) / size,
        start,
        method="SLSQP",
        jac="3-point",
        bounds=[(0.0, 1.0)] * len(start),
        constraints={"type": "ineq", "fun": lambda place: -problem.excess(place)},
        options={"ftol": 1e-13, "maxiter": 200},
    )
    return np.asarray(np.clip(solution.x, 0.0, 1.0))


def nearest(problem: Problem, start: Array) -> Array:
    """Find the design whose largest violation is least."""
    worst = float(np.max(problem.excess(start)))
    solution = _optimize.minimize(
        lambda extended: extended[-1],
        np.append(start, worst),
        method="SLSQP",
        bounds=[*[(0.0, 1.0)] * len(start), (None, None)],
        constraints={
            "type": "ineq",
            "fun": lambda extended: extended[-1] - problem.excess(extended[:-1]),
        },
        options={"ftol": 1e-12, "maxiter": 200},
    )
    return np.asarray(np.clip(solution.x[:-1], 0.0, 1.0))


def _checks(problem: Problem, points: Banded) -> tuple[LimitCheck, ...]:
    checks = []
    for limit in problem.limits:
        nominal, worst = (float(worst_values(limit, points, margins)) for margins in (False, True))
        kept = worst if problem.margins else nominal
        checks.append(LimitCheck(limit, nominal, worst, bool(limit.excess(kept) > -problem.active)))
    return tuple(checks)


def make_optimum(problem: Problem, best: SearchResult, *findings: str) -> Optimum:
    """Describe the result of a search, with what was found out about it."""
    model, space = problem.model, problem.space
    factors = problem.factors(best.place)
    points = problem.points(best.place)
    known = model.family.completed(factors)
    throw, remarks = space.throw(known)
    return Optimum(
        minimized=problem.minimized,
        value=float(points.band(problem.minimized)[0]),
        unit=problem.unit,
        dimensions=known,
        factors=factors,
        limits=_checks(problem, points),
        at_ends=space.at_ends(best.place),
        lookups=problem.lookups(factors),
        throw=throw,
        remarks=(*remarks, *findings),
        evaluations=best.evaluations,
    )


def infeasible(
    problem: Problem, best: SearchResult, none: str = "no throw of the model's family"
) -> str:
    """State that no throw keeps the limits, and the nearest one."""
    factors = problem.factors(best.place)
    show = problem.model.family.format_value
    at = ", ".join(
        f"{name} {value if isinstance(value, str) else show(name, value)}"
        for name, value in factors.items()
    )
    reached = [
        (check.limit, check.worst if problem.margins else check.value)
        for check in _checks(problem, problem.points(best.place))
    ]
    missed = [(limit, value) for limit, value in reached if limit.excess(value) > -SPARE / 2.0]
    if not missed:
        return (
            "limits: given a box in which no throw keeps the study's constraints; the nearest is at "
            f"{at}, because there they are broken least."
        )
    shown = "; ".join(
        f"{limit.name} {limit.sign} {format_quantity(limit.bound, limit.unit)} comes to "
        f"{format_quantity(value, limit.unit)}"
        for limit, value in missed
    )
    band = " at the worst end of the error band" if problem.margins else ""
    return (
        f"limits: given ones that {none} keeps; allowed are weaker ones, because the "
        f"nearest design ({at}) misses: {shown}{band}."
    )
