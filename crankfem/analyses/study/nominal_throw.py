"""The throw of an engine file in a study's equations: sensitivities, and sweeps along a factor."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from crankbase.array_checks import Array, Flags
from crankfem.analyses.study.response_fits import ResponseFits, predicted, surface
from geometry.throw import CrankThrow
from regression.fits.fit import Fit
from regression.fits.sensitivity import (
    RegionSample,
    Sensitivities,
    constrained_indices,
    elasticities,
    nominal_values,
    region_sample,
    sobol_indices,
)
from regression.models.response_query import find_out_of_range
from regression.plans.factors import Factor, field_value
from regression.plans.plan import StudyPlan
from regression.runs.study_table import StudyTable
from regression.throw_values import format_value, same_dimension, throw_values

# Of a factor's range: designs nearer to each other are the same.
SAME = 1e-6


def sensitivities(table: StudyTable, response: ResponseFits) -> Sensitivities:
    """Elasticities at the nominal throw and Sobol indices over the ranges, by the chosen equation."""
    plan = table.plan
    model = surface(plan, response, response.chosen)
    nominal = nominal_points(plan)
    numbers = [factor.name for factor in plan.factors if not factor.labels]
    slopes = elasticities(model, plan.factors, nominal)
    if not plan.constraints:
        sobol = sobol_indices(model, plan.factors)
    else:
        sample = _kept_sample(plan)
        sobol = None if sample is None else constrained_indices(model, sample)
    return Sensitivities(
        nominal={
            factor.name: factor.setting(value)
            for factor, value in zip(plan.factors, nominal, strict=True)
        },
        elasticity=dict(zip(numbers, slopes, strict=True)),
        sobol=sobol,
        units={factor.name: factor.unit for factor in plan.factors},
    )


@lru_cache(maxsize=2)
def _kept_sample(plan: StudyPlan) -> RegionSample | None:
    """Sample the ranges within a plan's constraints, once for all responses."""
    return region_sample(plan.factors, plan.variants().keep_constraints)


def nominal_points(plan: StudyPlan) -> list[float]:
    """Return the base throw's values of the factors, the middle of the range where it has none."""
    record = plan.throw.model_dump(mode="json")
    return nominal_values(plan.factors, [_base_value(record, factor) for factor in plan.factors])


def _base_value(record: Mapping[str, object], factor: Factor) -> float | None:
    try:
        value = field_value(record, factor.name)
    except (AttributeError, IndexError, KeyError, ValueError):
        return None  # a free name, or a field of a part that the base throw does not have
    if factor.labels:
        return float(factor.labels.index(value)) if value in factor.labels else None
    return float(value) if isinstance(value, int | float) else None


def outside_study(plan: StudyPlan) -> str:
    """State why the base throw of a study is not one of its variants; empty if it is.

    Ranges, choices and constraints are checked, and relations if all factors are the throw's.
    """
    record = plan.throw.model_dump(mode="json")
    for factor in plan.factors:
        value = _base_value(record, factor)
        if factor.labels and value is None:
            return f"{factor.name}: given none of {', '.join(factor.labels)}"
        if value is None:
            continue
        outside = find_out_of_range(factor.name, value, factor.lowest, factor.highest, factor.unit)
        if outside is not None:
            return outside[0].remark
    variant = plan.variants().at(np.array([nominal_points(plan)]))[0]
    if variant.throw is None:
        return variant.reason
    varied = throw_values(CrankThrow(**variant.throw))
    known = throw_values(plan.throw)
    free = any(_base_value(record, factor) is None for factor in plan.factors)
    for name in () if free else plan.relations:
        stated, follows = known.get(name), varied.get(name)
        if (
            isinstance(stated, float)
            and isinstance(follows, float)
            and not same_dimension(stated, follows)
        ):
            return (
                f"{name}: given {format_value(name, stated)}, not {format_value(name, follows)} as the "
                f"study's relation {plan.relations[name]!r} has it"
            )
    return ""


def nominal_section(table: StudyTable) -> Array:
    """Return the (k,) values of the factors at the nominal throw, or the nearest levels."""
    return np.array(
        [
            min(factor.levels, key=lambda level: abs(level - nominal))
            if factor.levels is not None
            else nominal
            for factor, nominal in zip(table.plan.factors, nominal_points(table.plan), strict=True)
        ]
    )


def moved(section: Array, place: int, values: Array) -> Array:
    """Return (n, k) points of a section in which the factor at an index has (n,) other values."""
    points = np.tile(section, (len(values), 1))
    points[:, place] = values
    return points


def same_designs(table: StudyTable, points: Array) -> Flags:
    """Return which designs of a table (n, k) are the points (n, k)."""
    spans = np.array([factor.highest - factor.lowest for factor in table.plan.factors])
    return np.asarray(np.all(np.abs(table.values - points) <= SAME * spans, axis=1))


@dataclass(frozen=True, eq=False)
class FactorSweep:
    """Equations and designs along one factor, in SI units.

    Attributes
    ----------
    values : (p,) array
        Of the factor.
    curves : list of (p,) array
        Of the forms at these values, the other factors at the nominal throw.
    results : (n,) array
        Of the designs; those elsewhere are shifted to this line along the chosen equation, with
        their distance to it unchanged.
    on_line : (n,) array of bool
        Which designs are on this line.
    """

    values: Array
    curves: list[Array]
    results: Array
    on_line: Flags


def factor_sweep(
    table: StudyTable, response: ResponseFits, place: int, forms: Sequence[Fit], values: Array
) -> FactorSweep:
    """Return forms at (p,) values of the factor at an index, and the designs near them."""
    section = nominal_section(table)
    points = moved(section, place, values)
    here = moved(section, place, table.values[:, place])
    off_curve = table.responses[response.column] / predicted(table, response, response.chosen)
    return FactorSweep(
        values=values,
        curves=[surface(table.plan, response, fit)(points) for fit in forms],
        results=surface(table.plan, response, response.chosen)(here) * off_curve,
        on_line=same_designs(table, here),
    )
