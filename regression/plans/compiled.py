"""Expressions of a study compiled for speed: plain arithmetic in SI units, on floats or arrays.

pint reads the text and checks its units once (`regression.plans.relations`); between quantities in SI units
no factor is left, so that only arithmetic remains.
"""

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from crankbase.units.quantity import unit_registry
from regression.plans.constraints import EQUAL_WITHIN, Constraint, holds
from regression.plans.relations import Expression

Known = Mapping[str, Any]
# Values [SI] by name to that of an expression [SI].
Compiled = Callable[[Known], Any]


def compile_expression(expression: Expression) -> Compiled:
    """Compile a checked expression.

    Parameters
    ----------
    expression : Expression
        From `read_expression`, its units checked.

    Returns
    -------
    callable
        Floats or arrays [SI] by name to the value [SI]; not finite if undefined. For arrays
        numpy's warnings are the caller's.
    """
    from pint.pint_eval import build_eval_tree, tokenizer

    places = {f"quantity_{place}": name for place, name in enumerate(expression.names)}

    def operand(token: Any) -> Compiled:
        text = token.string
        if text in places:
            return operator.itemgetter(places[text])
        if text[0].isalpha():
            size = float(unit_registry().Quantity(1.0, text).to_base_units().magnitude)
        else:
            size = float(text)
        return lambda _: size

    tree = build_eval_tree(tokenizer(expression.prepared.replace("^", "**")))
    evaluate = tree.evaluate(operand, _BINARY, _UNARY)

    def value(known: Known) -> Any:
        try:
            found = evaluate(known)
        except ArithmeticError:
            return math.nan
        return math.nan if isinstance(found, complex) else found

    return value


def compile_constraint(constraint: Constraint) -> Compiled:
    """Compile a checked constraint to a test of whether it holds, a bool or an array of them."""
    sides = [compile_expression(side) for side in constraint.sides]

    def test(known: Known) -> Any:
        found = [side(known) for side in sides]
        kept: Any = True
        for sign, left, right in zip(constraint.signs, found, found[1:], strict=False):
            kept = kept & _compared(sign, left, right)
        return kept

    return test


def _compared(sign: str, left: Any, right: Any) -> Any:
    if not (isinstance(left, float) and isinstance(right, float)):
        return holds(sign, left, right)
    gap = right - left if sign[0] == "<" else left - right
    margin = EQUAL_WITHIN * max(abs(left), abs(right))
    return math.isfinite(gap) and (gap >= -margin if len(sign) > 1 else gap > margin)


def _binary(operation: Callable[[Any, Any], Any]) -> Callable[[Compiled, Compiled], Compiled]:
    return lambda left, right: lambda known: operation(left(known), right(known))


def _unary(operation: Callable[[Any], Any]) -> Callable[[Compiled], Compiled]:
    return lambda only: lambda known: operation(only(known))


_BINARY: Any = {
    "+": _binary(operator.add),
    "-": _binary(operator.sub),
    "*": _binary(operator.mul),
    "/": _binary(operator.truediv),
    "**": _binary(operator.pow),
}
_UNARY: Any = {"+": _unary(operator.pos), "-": _unary(operator.neg)}
