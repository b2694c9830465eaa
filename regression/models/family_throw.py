"""A given throw as a query to a model: its dimensions by name, if it is of the model's family."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, cast

from crankbase.errors import InputError
from crankbase.model import field_extra
from geometry.throw import CrankThrow
from regression.models.family import Family
from regression.throw_values import (
    DEFAULTS,
    declaration,
    field_unit,
    format_value,
    same_dimension,
    throw_values,
)

# Beginnings of the names of what makes one end of a throw another than the other.
_ONE_SIDED = ("left_web.", "right_web.", "further_pins.", "oil_holes.")
# A solution of a relation is sought to this share; relations are checked to `SAME`.
_ROUNDING = 1e-13


def angle_law_remarks(family: Family, study_throw: Mapping[str, Any] | None) -> tuple[str, ...]:
    """State that the angle law is not exact for throws that are not symmetric about their middle.

    Parameters
    ----------
    family : Family
    study_throw : mapping or None
        As in `query_for_throw`.

    Raises
    ------
    InputError
        If the record is not that of a throw.
    """
    varying = (*family.factors, *family.relations)
    names = varying if study_throw is not None else (*varying, *family.fixed, *family.labels)
    alike = study_throw is None or CrankThrow(**study_throw).symmetry == "quarter"
    if alike and not any(name.startswith(_ONE_SIDED) for name in names):
        return ()
    return (
        "The model's throws are not alike from both ends, or what one end has of its own varies: the angle "
        "law is an interpolation between 0, 90 and 180 deg for them, and the band does not hold its error.",
    )


def query_for_throw(
    throw: CrankThrow, family: Family, study_throw: Mapping[str, Any] | None
) -> dict[str, float | str]:
    """Return the query to a model for a throw.

    Parameters
    ----------
    throw : CrankThrow
    family : Family
    study_throw : mapping or None
        The throw that the study varied, as a record; by default the model's throws have
        only the dimensions of the family.

    Returns
    -------
    dict
        Numbers [SI] and labels by name, including the fixed ones, so that they are checked.

    Raises
    ------
    InputError
        If the throw has a feature that the model's throws lack, or lacks one that they have.
    """
    found = throw_values(throw)
    study = {} if study_throw is None else throw_values(CrankThrow(**study_throw))
    numbers = {*family.ranges, *family.fixed, *family.relations}
    asked: dict[str, float | str] = {}
    for name in numbers:
        value = found.get(name)
        if value is None and declaration(name) is not None:
            value = _absent(name, found)
        if isinstance(value, float):
            asked[name] = value
    for name in (*family.categories, *family.labels):
        label = found.get(name)
        if label is not None:
            asked[name] = label
    others = {name: value for name, value in found.items() if name not in asked}
    expected = {name: value for name, value in study.items() if name not in asked}
    size = family.size({name: value for name, value in asked.items() if name in numbers})
    for name in dict.fromkeys((*others, *expected)):
        _check_same(name, others.get(name), expected.get(name), size)
    return asked | _free_factors(family, asked, size)


def _absent(name: str, found: Mapping[str, float | str]) -> float | None:
    """Default value of a dimension that is not given, or 0 for a feature."""
    if name in DEFAULTS:
        other, share = DEFAULTS[name]
        base = found.get(other)
        return share * base if isinstance(base, float) else None
    info = declaration(name)
    return 0.0 if info is not None and field_extra(info, "feature") else None


def _check_same(
    name: str, given: float | str | None, expected: float | str | None, size: float
) -> None:
    """Refuse differences from the study's throw; lengths are compared at the study's size."""
    info = declaration(name)
    if expected is None and info is not None and given == info.default:
        return
    wanted = expected
    if isinstance(expected, float) and field_unit(name) == "m":
        wanted = expected * size
    numbers = isinstance(given, float) and isinstance(wanted, float)
    if given == wanted or (numbers and same_dimension(cast(float, given), cast(float, wanted))):
        return
    raise InputError(
        f"throw.{name}: given {_format_dimension(name, given)}; allowed is "
        f"{_format_dimension(name, wanted)}, because the "
        "throws that the model was fitted to were so."
    )


def _format_dimension(name: str, value: float | str | None) -> str:
    if value is None:
        return "none"
    return value if isinstance(value, str) else format_value(name, value)


def _free_factors(
    family: Family, asked: Mapping[str, float | str], size: float
) -> dict[str, float]:
    """Find factors that are not dimensions, such as ratios, from the dimensions related to them.

    Each is found from a relation with a unique solution; others are left out, and the model then
    reports them as missing. Relations are between lengths divided by the throw's size.
    """
    free = [name for name in family.ranges if declaration(name) is None]
    if not free:
        return {}
    from regression.plans.relations import read_expression

    units = family.all_units
    uses = {
        target: set(read_expression(text, target, units).names)
        for target, text in family.relations.items()
    }
    known = {
        name: value / size if units[name] == "m" else value
        for name, value in asked.items()
        if isinstance(value, float)
    }
    found: dict[str, float] = {}
    for _ in free:
        for target, names in uses.items():
            unknown = [name for name in free if name in names and name not in found]
            if len(unknown) != 1 or target not in known:
                continue
            name = unknown[0]
            others = {n: v for n, v in known.items() if n != target} | found
            if not uses[target] <= {*others, name}:
                continue
            relation = {target: family.relations[target]}
            solution = _solution(
                partial(_related_value, relation, others, units, name),
                *family.ranges[name],
                known[target],
            )
            if solution is not None:
                found[name] = solution
    return {name: value * size if units[name] == "m" else value for name, value in found.items()}


def _related_value(
    relation: Mapping[str, str],
    known: Mapping[str, float],
    units: Mapping[str, str],
    name: str,
    number: float,
) -> float:
    """Result of one relation with `name` equal to this number."""
    from regression.models.model_relations import related

    (value,) = related(relation, {**known, name: number}, units).values()
    return float(value)


def _solution(
    value: Callable[[float], float], low: float, high: float, target: float
) -> float | None:
    """Find where a function over a range has a value; None if this is not certain."""
    start, stop = value(low), value(high)
    if start == stop:
        return None
    straight = low + (high - low) * (target - start) / (stop - start)
    inside = low < straight < high
    try:
        if same_dimension(value(straight), target):
            return straight
        from scipy import optimize  # a lookup by numbers does without

        def miss(number: float) -> float:
            return value(number) - target

        width = high - low
        if inside:
            found = optimize.brentq(miss, low, high, xtol=_ROUNDING * width)
        else:
            found = optimize.newton(miss, low, x1=high, tol=_ROUNDING * width, rtol=_ROUNDING)
    except (InputError, RuntimeError):  # beyond the range there may be no value, or no end of steps
        return None
    # Where the ends have values on the same side, a solution inside has another one beside it.
    certain = same_dimension(value(found), target) and inside == (low < found < high)
    return float(found) if certain else None
