"""Results of another store for a study."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from crankbase.errors import InputError
from regression.plans.factors import Factor, field_value
from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.records import ExtraRow, Outcome
from regression.runs.store import ResultStore
from regression.runs.store_rows import damaged_rows_warning
from regression.runs.study_table import throw_dimensions, throw_outlines
from regression.throw_values import same_dimension


def is_in_range(factor: Factor, given: Any) -> bool:
    """Whether a value of a factor lies in the study's range; rounding must not put it outside."""
    if factor.labels:
        return given in factor.labels
    inside = factor.lowest <= given <= factor.highest
    return inside or same_dimension(given, factor.lowest) or same_dimension(given, factor.highest)


def factor_value(factor: Factor, given: Any) -> float:
    """Return the value of a factor as in designs: for a label, its index."""
    return float(factor.labels.index(given)) if factor.labels else float(given)


@dataclass(frozen=True)
class StoreResults:
    """Results of another store for a study.

    Attributes
    ----------
    finished : tuple of Outcome
        Results of exactly the study's own designs.
    rows : tuple of ExtraRow
        Results of other designs of the same throw and material, at other values of the factors within
        the study's ranges.
    left_out : int
        Results that do not belong to the study.
    """

    finished: tuple[Outcome, ...]
    rows: tuple[ExtraRow, ...]
    left_out: int


def read_store(store: ResultStore, plan: StudyPlan, keys: Iterable[str]) -> StoreResults:
    """Find the results of another store for a study.

    Parameters
    ----------
    store : ResultStore
    plan : StudyPlan
    keys : iterable of str
        Of the study's designs.

    Raises
    ------
    InputError
        If there are none.
    """
    own = set(keys)
    finished, rows, left_out = [], list(store.extra_rows(plan.key)), 0
    others = 0  # of another version of the model
    for role, outcome, version in store.results():
        if outcome.key in own:
            finished.append(outcome)
            continue
        row = _row_of(outcome, role, plan, store.path.name) if version == MODEL_VERSION else None
        if row is None:
            left_out += 1
            others += version != MODEL_VERSION
        else:
            rows.append(row)
    if not finished and not rows:
        damaged = f"; {damaged_rows_warning(store.damaged, store.path)}" if store.damaged else ""
        raise InputError(
            f"import: given {str(store.path)!r}, in which {left_out} results are of another throw, material, "
            f"accuracy or model version ({others} of another version than {MODEL_VERSION}, which must not be "
            f"mixed); allowed is a store with results of this study{damaged}."
        )
    return StoreResults(tuple(finished), tuple(rows), left_out)


def _row_of(outcome: Outcome, role: str, plan: StudyPlan, source: str) -> ExtraRow | None:
    """Make a row from another study's result, if the study could have such a design."""
    inputs: Mapping[str, Any] = outcome.inputs
    same = all(inputs.get(name) == value for name, value in plan.settings.items())
    if outcome.responses is None or not same:
        return None
    try:
        given = {name: field_value(inputs["throw"], name) for name in plan.names}
    except IndexError:  # a pin that the other throw does not have
        return None
    for factor in plan.factors:
        value = given[factor.name]  # None also for a ratio that only relations use
        if value is None or not is_in_range(factor, value):
            return None
    values = tuple(factor_value(factor, given[factor.name]) for factor in plan.factors)
    variant = plan.variants().at(np.array([values]))[0]
    if variant.throw is None or variant.throw != inputs["throw"]:
        return None
    return ExtraRow(
        role=role,
        dimensions=throw_dimensions(variant.throw),
        outlines=throw_outlines(variant.throw),
        values=values,
        responses=outcome.responses,
        errors=outcome.errors,
        source=f"{source}, design {outcome.key}",
    )
