"""From a model's response to its query: columns and ratios from dimensions."""

from collections.abc import Mapping
from functools import partial
from operator import itemgetter
from typing import Any

from crankbase.errors import InputError
from fem.material import Material
from regression.fits.groups import GROUPS, group_named
from regression.models.evaluator import compile_equation
from regression.models.family import Family
from regression.models.response_model import IS, ResponseModel
from regression.models.response_query import Column, Ratio, Reader, ResponseQuery
from regression.models.study_constraints import StudyConstraint
from regression.response_kinds import response_scale


def make_response_query(
    name: str,
    response: ResponseModel,
    family: Family,
    material: Mapping[str, Any],
    constant_groups: Mapping[str, float],
    constraints: tuple[StudyConstraint, ...] = (),
) -> ResponseQuery:
    """Prepare a response for queries.

    Parameters
    ----------
    name : str
        Name of the response; determines whether its values are positive.
    response : ResponseModel
    family : Family
    material : mapping
        Of the study; an equation in dimensionless groups needs its constants.
    constant_groups : mapping
        Groups that did not vary in the study, besides those that follow from its fixed dimensions.
    constraints : tuple of StudyConstraint
        Of the study.

    Raises
    ------
    InputError
        If a column is not one of the family's, or the material's constants are missing.
    """
    readers = [_column_source(name, response.basis, family) for name in response.factors]
    columns = tuple(
        Column(name, read, low, high, unit)
        for name, (read, _, unit), low, high in zip(
            response.factors, readers, response.lowest, response.highest, strict=True
        )
    )
    needed = dict.fromkeys(name for _, names, _ in readers for name in names)
    needed |= dict.fromkeys(name for one in constraints for name in one.read.names)
    equation = compile_equation(response.fitted)
    if response.basis == "factors":
        return ResponseQuery(name, family, columns, (), tuple(needed), equation, None, constraints)
    ratios, names = _ratios(family, constant_groups)
    needed |= dict.fromkeys(("pin_diameter", *names))
    try:
        constants = Material(**material)
    except InputError as error:
        raise InputError(
            f"material: given {dict(material)}; an equation in dimensionless groups needs its "
            f"constants ({error})"
        ) from None
    scale = partial(response_scale, response.unit, material=constants)
    scale({"pin_diameter": 1.0})  # refuses a unit that has no scale
    return ResponseQuery(name, family, columns, ratios, tuple(needed), equation, scale, constraints)


def _column_source(name: str, basis: str, family: Family) -> tuple[Reader, tuple[str, ...], str]:
    """Function, requirements and unit of a column."""
    field, is_label, label = name.partition(IS)
    if is_label:
        if label not in family.categories.get(field, ()):
            raise InputError(
                f"factors: given {name}, which is no label of a category of the model; allowed are "
                f"those of {', '.join(family.categories) or 'no category'}."
            )
        return (lambda known: (known[field] == label) * 1.0), (field,), ""
    if basis == "groups":
        group = group_named(name)
        return group.value, group.dimensions, ""
    return itemgetter(name), (name,), family.unit(name)


def _ratios(
    family: Family, constant_groups: Mapping[str, float]
) -> tuple[tuple[Ratio, ...], tuple[str, ...]]:
    """Ratios that must agree with the study so that a throw of another size is of its family."""
    fixed = family.fixed
    groups = [group for group in GROUPS.values() if set(group.dimensions) <= fixed.keys()]
    found = {
        group.name: Ratio(group.name, group.dimensions, group.value, group.value(fixed))
        for group in groups
    }
    for name, value in constant_groups.items():
        group = group_named(name)
        groups.append(group)
        found.setdefault(name, Ratio(name, group.dimensions, group.value, value))
    names = [name for group in groups for name in group.dimensions]
    covered = {name for name in names if fixed.get(name)}
    reference = (
        "pin_diameter"
        if "pin_diameter" in fixed
        else next(
            (name for name, value in fixed.items() if value and family.unit(name) == "m"), None
        )
    )
    for name, value in fixed.items():
        if name in covered or name == reference or name in names:
            continue
        if family.unit(name) != "m" or reference is None:
            found[name] = Ratio(name, (name,), itemgetter(name), value)
        else:
            below = fixed[reference]
            read = _ratio_reader(name, reference)
            shown = "D_shm" if reference == "pin_diameter" else reference
            ratio = Ratio(f"{name}/{shown}", (name, reference), read, value / below)
            found[ratio.name] = ratio
            names += [name, reference]
    return tuple(found.values()), tuple(dict.fromkeys((*names, *fixed)))


def _ratio_reader(above: str, below: str) -> Reader:
    return lambda known: known[above] / known[below]
