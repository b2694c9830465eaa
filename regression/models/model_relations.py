"""The relations of a study applied to a question: what follows from what is known."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from crankbase.errors import InputError
from regression.plans.relations import evaluate_expression, evaluation_order, read_expression


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
        Field to a float or array [SI]; without those whose expressions use what is not known.

    Raises
    ------
    InputError
        If an expression has no value for what is known.
    """
    expressions = {name: read_expression(text, name, units) for name, text in relations.items()}
    values = dict(known)
    found: dict[str, Any] = {}
    for name in evaluation_order(expressions):
        expression = expressions[name]
        if name in known or not set(expression.names) <= values.keys():
            continue
        arrays = np.broadcast_arrays(*(values[used] for used in expression.names))
        used = dict(zip(expression.names, arrays, strict=True))
        result = evaluate_expression(expression, used, units, units[name])
        if not np.all(np.isfinite(result)):
            raise InputError(
                f"{name}: given dimensions for which {relations[name]} has no value; allowed are "
                "those for which it has one, because this model needs it."
            )
        found[name] = float(result) if result.ndim == 0 else result
        values[name] = found[name]
    return found
