"""The best throw of a model's family under limits, such as the thinnest web for a compliance.

The search covers the model's box: its ranges and choices, and the study's constraints. Relations of the
study are kept. A limit counts as met only if it is met at the worst end of the model's error band
(`regression.models.error_band`), so that the result includes the error of the equation and of the finite
elements, as far as known.

Differential evolution (seeded, hence reproducible) searches the whole box; sequential quadratic
programming then moves the best design to its limits.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from crankbase.errors import InputError
from crankbase.units.quantity import format_quantity
from regression.models.compliance_model import ComplianceModel
from regression.models.optimum import LimitCheck, Optimum
from regression.models.optimum_limits import Limit, Points, check_minimized, worst_values
from regression.models.optimum_space import SearchSpace, search_space

Array = NDArray[np.float64]
_optimize: Any = optimize  # its declarations know no vectorized functions

# Limits are kept with this to spare, as a share of the bound, so that rounding breaks none.
SPARE = 1e-9
# A limit with less than this left is one that the optimum stands at.
ACTIVE = 1e-6
_GENERATIONS, _POPULATION = 80, 12


@dataclass(frozen=True)
class _Problem:
    """One search: over the numbers of a box, with the labels set."""

    model: ComplianceModel
    minimized: str
    limits: tuple[Limit, ...]
    margins: bool
    space: SearchSpace
    labels: Mapping[str, str]

    def points(self, places: Array) -> Points:
        return Points(self.model, {**self.space.numbers(places), **self.labels})

    def factors(self, place: Array) -> dict[str, float | str]:
        return {**self.space.exact_numbers(place), **self.labels}

    def objective(self, places: Array) -> Array:
        if places.size == 0:  # differential evolution asks so where no design keeps the limits
            return np.zeros(places.shape[1:])
        value = self.points(places).band(self.minimized)[0]
        return np.broadcast_to(value, places.shape[1:])

    def excess(self, places: Array) -> Array:
        """Violation of each limit, as a share of its bound, (limits, n); 0 or less is kept."""
        points = self.points(places)
        rows = [
            limit.excess(worst_values(limit, points, self.margins)) + SPARE for limit in self.limits
        ]
        rows += self.space.excess(points)
        shape = places.shape[1:]
        return np.array([np.broadcast_to(row, shape) for row in rows]).reshape(len(rows), *shape)


@dataclass(frozen=True)
class _SearchResult:
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
    model : ComplianceModel
    minimize : str
        A dimension, such as "web_thickness", or a response, such as "mass".
    limits : sequence of Limit
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
    check_minimized(model, minimize)
    space = search_space(model, fixed or {})
    choices = [
        dict(zip(space.choices, labels, strict=True))
        for labels in itertools.product(*space.choices.values())
    ]
    problems = [
        _Problem(model, minimize, tuple(limits), margins, space, space.labels | labels)
        for labels in choices
    ]
    try:
        found = [_search(problem) for problem in problems]
    except RuntimeError as error:
        # The optimizer takes every ValueError for one of its own.
        if isinstance(error.__cause__, InputError):
            raise error.__cause__ from None
        raise
    feasible = [n for n, one in enumerate(found) if one.broken <= SPARE]
    if not feasible:
        nearest = min(range(len(found)), key=lambda n: found[n].broken)
        raise InputError(_infeasible(problems[nearest], found[nearest]))
    best = min(feasible, key=lambda n: found[n].objective)
    return _make_optimum(problems[best], found[best], sum(one.evaluations for one in found))


def _search(problem: _Problem) -> _SearchResult:
    """Search for the best design that keeps the limits; else for the one with the least violation."""
    count = 0

    def objective(places: Array) -> Array:
        nonlocal count
        count += places.shape[1] if places.ndim == 2 else 1
        return problem.objective(places)

    dimensions = problem.space.dimensions
    if dimensions == 0:
        alone = np.zeros(0)
        return _SearchResult(alone, *_evaluate(problem, alone), 1)
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
    candidates = [start, _polished(problem, start)]
    if min(_evaluate(problem, place)[1] for place in candidates) > SPARE:
        nearest = _optimize.differential_evolution(
            lambda places: np.max(problem.excess(places), axis=0), box, **settings
        ).x
        candidates = [nearest, _nearest(problem, nearest)]
        candidates += [_polished(problem, place) for place in tuple(candidates)]
    rated = [(_evaluate(problem, place), place) for place in candidates]
    kept = [one for one in rated if one[0][1] <= SPARE]
    if kept:
        (value, broken), place = min(kept, key=lambda one: one[0][0])
    else:
        (value, broken), place = min(rated, key=lambda one: one[0][1])
    return _SearchResult(place, value, broken, count)


def _evaluate(problem: _Problem, place: Array) -> tuple[float, float]:
    """Objective, and the violation of the limits."""
    broken = problem.excess(place)
    return float(problem.objective(place)), float(np.max(broken)) if broken.size else 0.0


def _polished(problem: _Problem, start: Array) -> Array:
    """Move a design to its limits by sequential quadratic programming."""
    size = abs(float(problem.objective(start))) or 1.0
    found = _optimize.minimize(
        lambda place: float(problem.objective(place)) / size,
        start,
        method="SLSQP",
        jac="3-point",
        bounds=[(0.0, 1.0)] * len(start),
        constraints={"type": "ineq", "fun": lambda place: -problem.excess(place)},
        options={"ftol": 1e-13, "maxiter": 200},
    )
    return np.asarray(np.clip(found.x, 0.0, 1.0))


def _nearest(problem: _Problem, start: Array) -> Array:
    """Find the design whose largest violation is least."""
    worst = float(np.max(problem.excess(start)))
    found = _optimize.minimize(
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
    return np.asarray(np.clip(found.x[:-1], 0.0, 1.0))


def _checks(problem: _Problem, points: Points) -> tuple[LimitCheck, ...]:
    checks = []
    for limit in problem.limits:
        nominal, worst = (
            float(worst_values(limit, points, margins)) for margins in (False, problem.margins)
        )
        checks.append(LimitCheck(limit, nominal, worst, bool(limit.excess(worst) > -ACTIVE)))
    return tuple(checks)


def _make_optimum(problem: _Problem, found: _SearchResult, evaluations: int) -> Optimum:
    model, space = problem.model, problem.space
    factors = problem.factors(found.place)
    points = Points(model, factors)
    known = model.family.completed(factors)
    throw, remarks = space.throw(known)
    asked: dict[str, Any] = dict(factors)
    if problem.limits:
        remarks.append(
            "the limits are kept at the worst end of the model's error band"
            if problem.margins
            else "the limits are kept by the equations' values, without margin for their errors"
        )
    return Optimum(
        minimized=problem.minimized,
        value=float(points.band(problem.minimized)[0]),
        unit=(
            model.responses[problem.minimized].unit
            if problem.minimized in model.responses
            else model.family.unit(problem.minimized)
        ),
        dimensions=known,
        factors=factors,
        limits=_checks(problem, points),
        at_ends=space.at_ends(found.place),
        lookups={name: model.lookup(name, **asked) for name in model.responses},
        throw=throw,
        remarks=tuple(remarks),
        evaluations=evaluations,
    )


def _infeasible(problem: _Problem, found: _SearchResult) -> str:
    """State that no throw keeps the limits, and the nearest one."""
    factors = problem.factors(found.place)
    show = problem.model.family.format_value
    at = ", ".join(
        f"{name} {value if isinstance(value, str) else show(name, value)}"
        for name, value in factors.items()
    )
    missed = [
        check
        for check in _checks(problem, Points(problem.model, factors))
        if check.limit.excess(check.worst) > -SPARE / 2.0
    ]
    if not missed:
        return (
            "limits: given a box in which no throw keeps the study's constraints; the nearest is at "
            f"{at}, because there they are broken least."
        )
    shown = "; ".join(
        f"{check.limit.name} {check.limit.sign} "
        f"{format_quantity(check.limit.bound, check.limit.unit)} comes to "
        f"{format_quantity(check.worst, check.limit.unit)}"
        for check in missed
    )
    band = " at the worst end of the error band" if problem.margins else ""
    return (
        f"limits: given ones that no throw of the model's family keeps; allowed are weaker ones, because "
        f"the nearest design ({at}) misses: {shown}{band}."
    )
