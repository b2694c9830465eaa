"""A given throw as a question to a model: its dimensions by name, if it is one of the model's family."""

from collections.abc import Mapping
from typing import Any, cast

from geometry.errors import InputError
from geometry.model import field_extra
from geometry.throw import CrankThrow
from regression.models.family import Family
from regression.throw_values import DEFAULTS, declaration, field_unit, same, show, throw_values


def throw_question(
    throw: CrankThrow, family: Family, study_throw: Mapping[str, Any] | None
) -> dict[str, float | str]:
    """Return what a model has to be asked for a throw.

    Parameters
    ----------
    throw : CrankThrow
    family : Family
    study_throw : mapping or None
        The throw that the study varied, as a record; without it the model's throws are taken to have
        nothing but what the family names.

    Returns
    -------
    dict
        Numbers [SI] and labels by name, the fixed ones among them, so that they are checked.

    Raises
    ------
    InputError
        If the throw has something that the model's throws did not have, or lacks what they had.
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
    return asked | _free_factors(family, asked)


def _absent(name: str, found: Mapping[str, float | str]) -> float | None:
    """Value of a dimension that is not given: what it is by default, or 0 for a feature."""
    if name in DEFAULTS:
        other, share = DEFAULTS[name]
        base = found.get(other)
        return share * base if isinstance(base, float) else None
    info = declaration(name)
    return 0.0 if info is not None and field_extra(info, "feature") else None


def _check_same(
    name: str, given: float | str | None, expected: float | str | None, size: float
) -> None:
    """Refuse what differs from the study's throw; lengths are compared at the study's size."""
    info = declaration(name)
    if expected is None and info is not None and given == info.default:
        return
    wanted = expected
    if isinstance(expected, float) and field_unit(name) == "m":
        wanted = expected * size
    numbers = isinstance(given, float) and isinstance(wanted, float)
    if given == wanted or (numbers and same(cast(float, given), cast(float, wanted))):
        return
    raise InputError(
        f"throw.{name}: given {_shown(name, given)}; allowed is {_shown(name, wanted)}, because the "
        "throws that the model was fitted to were so."
    )


def _shown(name: str, value: float | str | None) -> str:
    if value is None:
        return "none"
    return value if isinstance(value, str) else show(name, value)


def _free_factors(family: Family, asked: Mapping[str, float | str]) -> dict[str, float | str]:
    """Find factors that are no dimensions, such as ratios, from the dimensions related to them.

    Each is found from a relation that is of first degree in it; others are left out, and the model
    then says that they are missing.
    """
    free = [name for name in family.ranges if declaration(name) is None]
    if not free:
        return {}
    from regression.models.model_relations import related
    from regression.plans.relations import read_expression

    units = family.all_units
    uses = {
        target: set(read_expression(text, target, units).names)
        for target, text in family.relations.items()
    }
    known = {name: value for name, value in asked.items() if isinstance(value, float)}
    found: dict[str, float | str] = {}
    for _ in free:
        for target, names in uses.items():
            unknown = [name for name in free if name in names and name not in found]
            if len(unknown) != 1 or target not in known:
                continue
            name = unknown[0]
            low, high = family.ranges[name]
            others = {n: v for n, v in known.items() if n != target} | found
            relation = {target: family.relations[target]}
            ends = [related(relation, {**others, name: end}, units) for end in (low, high)]
            if not all(target in end for end in ends):
                continue
            start, stop = (end[target] for end in ends)
            if start != stop:
                found[name] = low + (high - low) * (known[target] - start) / (stop - start)
    return found
