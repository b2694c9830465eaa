"""The relations of a study applied to a query: dimensions that follow from known ones."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from crankbase.errors import InputError
from regression.plans.compiled import Compiled, compile_expression
from regression.plans.relations import evaluate_expression, evaluation_order, read_expression

Pairs = tuple[tuple[str, str], ...]


def related(
    relations: Mapping[str, str], known: Mapping[str, Any], units: Mapping[str, str]
) -> dict[str, Any]:
    """Calculate the dimensions that follow from others.

    Parameters
    ----------
    relations : mapping
        Field to its expression.
    known : mapping
        Name to a float or array [SI]; a field among them is not calculated.
    units : mapping
        Name to SI unit, of all names that the expressions may use.

    Returns
    -------
    dict
        Field to a float or array [SI]; without those whose expressions use unknown ones.

    Raises
    ------
    InputError
        If an expression has no value for the known dimensions.
    """
    values = dict(known)
    found: dict[str, Any] = {}
    for name, names, value in _compiled(tuple(relations.items()), tuple(units.items())):
        if name in known or not names <= values.keys():
            continue
        with np.errstate(all="ignore"):
            result = value(values)
        if not np.all(np.isfinite(result)):
            raise InputError(
                f"{name}: given dimensions for which {relations[name]} has no value; allowed are "
                "those for which it has one, because this model needs it."
            )
        found[name] = values[name] = result if np.ndim(result) else float(result)
    return found


@lru_cache(maxsize=100)
def _compiled(relations: Pairs, units: Pairs) -> tuple[tuple[str, frozenset[str], Compiled], ...]:
    """Compile relations in the order in which they can be calculated.

    Raises
    ------
    InputError
        If a text is not an expression, or is of another unit than its field.
    """
    by_name = dict(units)
    expressions = {name: read_expression(text, name, by_name) for name, text in relations}
    for name, expression in expressions.items():
        ones = dict.fromkeys(expression.names, np.array(1.0))
        evaluate_expression(expression, ones, by_name, by_name[name])  # refuses another unit
    return tuple(
        (name, frozenset(expressions[name].names), compile_expression(expressions[name]))
        for name in evaluation_order(expressions)
    )
