"""The designs of a study in a store: those of its plan, and those added to it."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regression.plans.plan import PlannedDesign, PlannedStudy, StudyPlan, planned_design
from regression.records import RUN
from regression.runs.store import ResultStore
from regression.runs.store_results import factor_value


def add_runs(plan: StudyPlan, store: str | Path, values: NDArray[np.float64]) -> None:
    """Add runs to those of a study in the store; the next run computes them.

    Parameters
    ----------
    plan : StudyPlan
    store : path
    values : (n, k) ndarray
        Of the factors [SI]; of a choice the label's index. Throws can be built of them.
    """
    listed = [_as_listed(plan, design) for design in _added(plan, values)]
    with ResultStore(store) as results:
        results.add_designs(plan.key, listed)


def known_designs(store: str | Path, plan: StudyPlan) -> PlannedStudy:
    """Return a plan's designs with those that were added in a store, if there is one."""
    if not Path(store).is_file():
        return plan.planned
    with ResultStore(store, readonly=True) as results:
        return with_added(results, plan)


def _added(plan: StudyPlan, values: NDArray[np.float64]) -> list[PlannedDesign]:
    made = plan.variants().at(values)
    return [
        replace(planned_design(plan, RUN, tuple(row), variant.throw), added=True)
        for row, variant in zip(values.tolist(), made, strict=True)
        if variant.throw is not None
    ]


def with_added(results: ResultStore, plan: StudyPlan) -> PlannedStudy:
    """Return a plan's designs, and behind them those that were added in the store."""
    rows = [
        found
        for shown in results.added_designs(plan.key)
        if (found := _values(plan, shown)) is not None
    ]
    added = _added(plan, np.array(rows).reshape(-1, len(plan.factors)))
    return replace(plan.planned, designs=(*plan.planned.designs, *added))


def _values(plan: StudyPlan, shown: Mapping[str, Any]) -> tuple[float, ...] | None:
    """Read the factor values of a registered design; None if they are damaged."""
    try:
        return tuple(factor_value(factor, shown[factor.name]) for factor in plan.factors)
    except (KeyError, TypeError, ValueError):
        return None


def _as_listed(
    plan: StudyPlan, design: PlannedDesign
) -> tuple[str, str, Mapping[str, float | str]]:
    """Role, key and factor values of a design, choices by their labels."""
    values = zip(plan.factors, design.values, strict=True)
    return (
        design.role,
        design.key,
        {f.name: f.labels[round(v)] if f.labels else v for f, v in values},
    )


def register_designs(results: ResultStore, plan: StudyPlan, planned: PlannedStudy) -> None:
    """Record the designs of a study."""
    own = [_as_listed(plan, design) for design in planned.designs if not design.added]
    results.register_study(plan.key, plan.as_record(), own)


def is_design(plan: StudyPlan, key: str, shown: Mapping[str, Any]) -> bool:
    """Whether a registered design's key is that of its factor values."""
    values = _values(plan, shown)
    return values is not None and [d.key for d in _added(plan, np.array([values]))] == [key]


def is_list_sound(results: ResultStore, plan: StudyPlan) -> bool:
    """Whether a store lists the designs of a study as they were registered."""
    listed = [_as_listed(plan, design) for design in registered_designs(results, plan).designs]
    return listed == list(results.study_designs(plan.key))


def registered_designs(results: ResultStore, plan: StudyPlan) -> PlannedStudy:
    """Return a study with its designs as stored.

    They are those of the plan and those added to it, unless a later release of numpy or scipy draws
    other points.
    """
    planned = with_added(results, plan)
    registered = results.study_designs(plan.key)
    if not registered or [key for _, key, _ in registered] == [d.key for d in planned.designs]:
        return planned
    values = [_values(plan, shown) for _, _, shown in registered]
    sound = [row for row in values if row is not None]
    if len(sound) < len(values):  # the list is damaged
        return planned
    designs = []
    made = plan.variants().at(np.array(sound))
    first_added = len(registered) - sum(design.added for design in planned.designs)
    for place, (row, variant) in enumerate(zip(sound, made, strict=True)):
        if variant.throw is None:  # it was one when the study was registered
            return planned
        design = planned_design(plan, registered[place][0], row, variant.throw)
        designs.append(replace(design, added=place >= first_added))
    # What was excluded of the points drawn then is not known.
    return replace(planned, designs=tuple(designs), excluded=())
