"""A study that grows: further runs where its equations are worst."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.scalars import is_whole_within
from crankbase.errors import InputError
from crankfem.analyses.study.fitting import fit_study
from crankfem.analyses.study.response_fits import (
    ResponseFits,
    fit_scale,
    needed_dimensions,
)
from regression.fits.worst_places import JudgedEquation, worst_places
from regression.plans.designs import values_at
from regression.plans.designs_space import (
    draw_feasible_points,
    sobol_points,
    with_points_at_ends,
)
from regression.plans.plan import StudyPlan
from regression.runs.registered_designs import add_runs
from regression.runs.study import Progress, run_plan
from regression.runs.study_table import StudyTable

Array = NDArray[np.float64]

MOST_ADDED = 1000
# Places among which further runs are chosen; the stream of random numbers that they are drawn from.
PLACES, GROWTH_STREAM = 1000, 2


def run_grown(
    plan: StudyPlan,
    store: str | Path,
    workers: int = 2,
    progress: Progress | None = None,
    *,
    more: int = 0,
    **options: Any,
) -> StudyTable:
    """Compute what a study still lacks, then further runs where its equations are worst.

    Parameters
    ----------
    plan, store, workers, progress, **options
        As of `run_plan`.
    more : int
        Number of further runs beyond the plan, at most 1000. The store records the added runs:
        the same number again adds none, a larger one the difference, chosen where the equations,
        fitted to all runs so far, are worst. By default no run is added.

    Returns
    -------
    StudyTable

    Raises
    ------
    InputError
        As of `run_plan` and `fit_study`; if the number is another.
    """
    if not is_whole_within(more, 0, MOST_ADDED):
        raise InputError(
            f"more: given {more!r}; allowed is 0 to {MOST_ADDED} further designs, as a whole number."
        )
    table = run_plan(plan, store, workers, progress, **options)
    if more <= table.added:
        return table
    add_runs(plan, store, worst_designs(table, fit_study(table), more - table.added))
    grown = run_plan(plan, store, workers, progress, **options)
    return replace(grown, computed=table.computed + grown.computed)


def worst_designs(table: StudyTable, fits: Mapping[str, ResponseFits], count: int) -> Array:
    """Choose runs where the chosen equations of all responses are expected to have the largest errors.

    Held-out designs are not used, so that they remain independent of the equations.

    Parameters
    ----------
    table : StudyTable
    fits : mapping
        As of `fit_study`.
    count : int

    Returns
    -------
    (count, k) ndarray
        Values of the factors [SI] of throws that can be built and keep the study's constraints.

    Raises
    ------
    InputError
        If too few throws in the ranges can be built.
    """
    places = _places(table, count)
    equations = [_judged(table, found, places) for found in fits.values()]
    return places[worst_places(equations, count)]


def _places(table: StudyTable, count: int) -> Array:
    """Draw designs of the study that it does not have yet."""
    plan, factors = table.plan, table.plan.factors
    choices = [len(factor.labels) for factor in factors]

    def draw(number: int) -> Array:
        stream = (plan.seed, GROWTH_STREAM, table.added)
        return with_points_at_ends(sobol_points(number, choices, stream), choices)

    variants = plan.variants()
    present = {row.values for row in table.rows}

    def possible(points: Array) -> NDArray[np.bool_]:
        values = values_at(factors, points)
        made = [variant.throw is not None for variant in variants.at(values)]
        new = [tuple(row) not in present for row in values.tolist()]
        usable: NDArray[np.bool_] = np.array(made) & np.array(new)
        return usable

    found = None
    for wanted in (max(PLACES, count), count):
        found = found or draw_feasible_points(draw, possible, wanted, in_order=True)
    if found is None:
        raise InputError(
            f"more: given {count} further designs; allowed are as many as there are throws in the study's "
            "ranges that can be built and keep its constraints, of which too few are found."
        )
    points, _, impossible = found
    return np.unique(values_at(factors, points[~impossible]), axis=0)


def _judged(table: StudyTable, found: ResponseFits, places: Array) -> JudgedEquation:
    plan, fit = table.plan, found.chosen
    runs = ~table.held_out
    values = table.responses[found.column][runs]
    at_runs = {name: column[runs] for name, column in table.dimensions.items()}
    at_places = needed_dimensions(plan, found, fit, places)
    scale = fit_scale(plan, found.column, fit.basis, at_runs)
    x = found.encodings[fit.basis].columns(plan.factors, places, at_places)
    sizes = np.ones(len(places))
    if not fit.fitted.logarithmic:
        # Where an equation passes through zero, its relative error says nothing.
        sizes = np.maximum(np.abs(fit.predict(x)), np.min(np.abs(values / scale)))
    return JudgedEquation(
        fit=fit,
        runs=found.encodings[fit.basis].columns(plan.factors, table.values[runs], at_runs),
        target=np.log(values / scale) if fit.fitted.logarithmic else values / scale,
        places=x,
        sizes=sizes,
    )
