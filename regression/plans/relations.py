"""Relations between the dimensions of a study, as text with units.

pint calculates them, with their units and for all designs at once; no text is ever run as Python. Expressions
that pint would interpret loosely ("a b" as a product, "1,6" as 16, "410 mm / 2 mm" as an area) are refused or
put in brackets before.
"""

import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import Any

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.choices import did_you_mean, is_number
from crankbase.errors import InputError, quoted
from crankbase.input_file import LARGEST_POWER, LONGEST_EXPRESSION
from crankbase.quantity import format_quantity
from crankbase.units import is_unit, pint_name, unit_registry

TOKEN = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[A-Za-z_]\w*(?:\.\w+)*)|(?P<sign>\*\*|[-+*/^()])|(?P<space>\s+)",
    re.ASCII,
)
POWERS = ("^", "**")
Values = Mapping[str, Array]
Units = Mapping[str, str]


@dataclass(frozen=True)
class Expression:
    """A checked expression: its field in messages, its text, the names of the study that it uses.

    `prepared` is the text for pint, the names replaced by placeholders.
    """

    field: str
    text: str
    names: tuple[str, ...]
    prepared: str


def read_expression(text: object, field: str, units: Units) -> Expression:
    """Check the grammar of an expression and its names.

    Numbers, quantities such as ``410 mm``, ``+ - * / ** ^``, brackets.

    `units` has the allowed names, with their SI units. `InputError` for another text or an unknown
    name.
    """
    if is_number(text):
        text = quoted(text)
    if not isinstance(text, str) or not text.strip():
        raise InputError(
            f'{field}: given {quoted(text)}; allowed is an expression in quotes, like "1.6 * pin_diameter".'
        )
    check_length(text, field)
    names: list[str] = []
    pieces: list[str] = []
    depth, operand_next = 0, True
    tokens = _tokens(text, field)
    for place, (kind, token) in enumerate(tokens):
        before = tokens[place - 1] if place else ("", "")
        if kind == "name" and before[0] == "number" and token not in units:
            if not is_unit(token):
                raise _unknown_name(token, text, field, units)
            pieces[-1] += f"*{pint_name(token)}"
            continue
        operand = kind != "sign" or token == "("
        prefix = token in ("+", "-") and before[1] not in ("+", "-")
        if operand != operand_next and not (operand_next and prefix):
            raise _no_grammar(text, field, before[1], token)
        if kind == "name":
            if token not in units:
                raise _unknown_name(token, text, field, units)
            if token not in names:
                names.append(token)
            token = f"quantity_{names.index(token)}"
        depth += {"(": 1, ")": -1}.get(token, 0) if kind == "sign" else 0
        if depth < 0:
            raise _no_grammar(text, field, before[1], token)
        # Python's own whole numbers grow without end; exponents stay whole, as units have them.
        signs = [sign for _, sign in tokens[max(place - 2, 0) : place]]
        after_sign = signs[1:] in (["+"], ["-"])
        exponent = bool(signs) and signs[0 if after_sign else -1] in POWERS
        pieces.append(f"{token}.0" if token.isdigit() and not exponent else token)
        operand_next = kind == "sign" and token != ")"
    if depth or operand_next:
        raise _no_grammar(text, field, tokens[-1][1], "the end")
    _check_powers(tokens, text, field)
    return Expression(field, text, tuple(names), " ".join(_bracketed(pieces)))


def check_length(text: str, field: str) -> None:
    """Refuse a text that is too long for an expression (`InputError`)."""
    if len(text) > LONGEST_EXPRESSION:
        raise InputError(
            f"{field}: given {text!r}, of {len(text)} characters; allowed are {LONGEST_EXPRESSION}, because "
            "relations between dimensions are short."
        )


def _check_powers(tokens: list[tuple[str, str]], text: str, field: str) -> None:
    """Refuse powers of powers, powers of units that are not numbers, and exponents that are too large."""
    powers = 1.0
    for place, (kind, token) in enumerate(tokens):
        if kind != "sign" or token not in POWERS:
            continue
        ahead = tokens[place + 1 :]
        signed = ahead[1:] if ahead and ahead[0][1] in ("+", "-") else ahead
        number = bool(signed) and signed[0][0] == "number"
        of_unit = tokens[place - 2 : place - 1] and tokens[place - 2][0] == "number"
        if of_unit and tokens[place - 1][0] == "name" and not (number and signed is ahead):
            raise _no_grammar(text, field, token, ahead[0][1] if ahead else "the end")
        if not number:
            continue
        if len(signed) > 1 and signed[1][1] in POWERS:
            raise _no_grammar(text, field, signed[0][1], signed[1][1])
        powers *= max(1.0, float(signed[0][1]))
    if powers > LARGEST_POWER:
        raise InputError(
            f"{field}: given {text!r}, with exponents of {powers:g} multiplied; allowed is up to "
            f"{LARGEST_POWER:g}, because no relation between dimensions has more."
        )


def _tokens(text: str, field: str) -> list[tuple[str, str]]:
    tokens, place = [], 0
    while place < len(text):
        token = TOKEN.match(text, place)
        if token is None:
            raise InputError(
                f"{field}: given {text!r}, with {text[place]!r} in it; allowed are numbers with a "
                "decimal point, units, names, + - * / ** and brackets."
            )
        if token.lastgroup != "space":
            tokens.append((str(token.lastgroup), token[0]))
        place = token.end()
    return tokens


def _bracketed(pieces: list[str]) -> list[str]:
    """Put a number with its unit, and the power of the unit, in brackets: divide by all of it."""
    done, place = [], 0
    while place < len(pieces):
        piece = pieces[place]
        if "*" in piece and piece not in ("*", "**"):
            if pieces[place + 1 : place + 2] in (["^"], ["**"]) and place + 2 < len(pieces):
                piece += f"**{pieces[place + 2]}"
                place += 2
            piece = f"({piece})"
        done.append(piece)
        place += 1
    return done


def _no_grammar(text: str, field: str, before: str, token: str) -> InputError:
    where = f"{token!r} after {before!r}" if before else f"{token!r} at its start"
    where = where.replace("'the end'", "the end")
    return InputError(
        f"{field}: given {text!r}, which is no expression ({where}); allowed is one like "
        '"410 mm - 2 * web_thickness".'
    )


def _unknown_name(token: str, text: str, field: str, units: Units) -> InputError:
    unit = is_unit(token)
    hint = "a unit follows a number, like 1 mm; " if unit else did_you_mean(token, units)
    return InputError(
        f"{field}: given {text!r}, in which {token} is no known quantity; {hint}allowed are the "
        "factors, the fields of [throw] that have a value, and numbers with units."
    )


def evaluate_expression(expression: Expression, values: Values, units: Units, unit: str) -> Array:
    """Evaluate an expression at values () or (n,) [SI]; not finite where it has no value.

    `unit` is the SI unit of the result, "" for a pure number; `InputError` if it is of another one.
    """
    quantity = calculated(expression, values, units)
    wanted = unit_registry().Quantity(1.0, unit)
    if not same_kind(quantity, wanted):
        raise InputError(
            f"{expression.field}: given {expression.text!r}, which is {kind_of(quantity)}; allowed is "
            f"{kind_of(wanted)}."
        )
    return np.asarray(quantity.to(unit).magnitude, dtype=np.float64)


def calculated(expression: Expression, values: Values, units: Units) -> Any:
    """Calculate with pint; the result is its quantity."""
    registry = unit_registry()
    from pint.errors import PintError

    quantities = {
        f"quantity_{place}": registry.Quantity(np.asarray(values[name], dtype=float), units[name])
        for place, name in enumerate(expression.names)
    }
    try:
        with np.errstate(all="ignore"):
            quantity = registry.Quantity(
                registry.parse_expression(expression.prepared, **quantities)
            )
        if not np.iscomplexobj(quantity.magnitude):
            return quantity
        reason = "it takes a root of a negative number"
    except ZeroDivisionError:
        reason = "it divides by zero"
    except OverflowError:
        reason = "its numbers are too large"
    except PintError as error:  # quantities that do not fit together
        reason = " ".join(str(error).split()).rstrip(".")
    raise InputError(
        f"{expression.field}: given {expression.text!r}, which cannot be calculated ({reason}); "
        "allowed are quantities that fit together."
    )


def _angle(quantity: Any) -> bool:
    """Whether a quantity is an angle: a pure number does not count as one."""
    return quantity.dimensionless and "radian" in str(quantity.to_root_units().units)


def same_kind(first: Any, second: Any) -> bool:
    """Whether quantities can be compared."""
    return bool(first.check(second.dimensionality)) and _angle(first) == _angle(second)


def kind_of(quantity: Any) -> str:
    """Name the kind of a quantity, such as "a length"."""
    if quantity.dimensionless:
        return "an angle" if _angle(quantity) else "a pure number"
    kinds = {"[length]": "a length", "[length] ** 2": "an area", "[length] ** 3": "a volume"}
    return kinds.get(str(quantity.dimensionality), f"in {quantity.to_base_units().units:~P}")


def shown_unit(quantity: Any) -> str:
    """Return the SI unit in which to compare and show a quantity."""
    if quantity.dimensionless:
        return "rad" if _angle(quantity) else ""
    return "m" if quantity.check("[length]") else f"{quantity.to_base_units().units:~C}"


def evaluation_order(relations: Mapping[str, Expression]) -> tuple[str, ...]:
    """Order the relations so that each uses only preceding ones; `InputError` if they are circular."""
    graph = {
        name: sorted(set(expression.names) & set(relations))
        for name, expression in sorted(relations.items())
    }
    try:
        return tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        circle = " -> ".join(reversed(error.args[1]))
        raise InputError(
            f"study.relations: given a circle ({circle}); allowed are relations that end at the "
            "factors and the fields of [throw]."
        ) from None


def used_names(expressions: Iterable[Expression]) -> set[str]:
    """Return all quantities used in some expressions."""
    return {name for expression in expressions for name in expression.names}


COMPARISON = re.compile(r"(<=|>=|==|!=|=|<|>)")
# Sides of a constraint that differ by less than this part count as equal: rounding must not exclude a
# design that lies on it.
EQUAL_WITHIN = 1e-9


@dataclass(frozen=True)
class Constraint:
    """Comparisons that must all be met, such as ``0.2 <= web_thickness / pin_diameter <= 0.6``."""

    field: str
    text: str
    sides: tuple[Expression, ...]
    signs: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Quantities of the study that it uses."""
        return tuple(dict.fromkeys(name for side in self.sides for name in side.names))


def read_constraint(text: object, field: str, units: Units) -> Constraint:
    """Check the grammar of a constraint (<, <=, >, >=), and that its sides are of one kind (`InputError`)."""
    if isinstance(text, str):
        check_length(text, field)
    pieces = COMPARISON.split(text) if isinstance(text, str) else []
    sides, signs = pieces[0::2], pieces[1::2]
    if not signs or not set(signs) <= {"<", "<=", ">", ">="}:
        raise InputError(
            f"{field}: given {text!r}; allowed is a comparison by <, <=, > or >=, like "
            '"web_thickness >= 0.25 * pin_diameter".'
        )
    assert isinstance(text, str)
    read = tuple(read_expression(side, field, units) for side in sides)
    ones = {name: np.array(1.0) for side in read for name in side.names}
    first, *others = (calculated(side, ones, units) for side in read)
    for other in others:
        if not same_kind(first, other):
            raise InputError(
                f"{field}: given {text!r}, which compares {kind_of(first)} with {kind_of(other)}; "
                "allowed are sides of one kind."
            )
    return Constraint(field, text, read, tuple(signs))


def constraint_violations(
    constraint: Constraint, values: Values, units: Units, count: int
) -> list[str | None]:
    """Return for each of `count` designs how it violates a constraint; None if it does not.

    Sides that differ by less than one part in 1e9 count as equal.
    """
    unit, both = _sides(constraint, values, units)
    sides = np.array([np.broadcast_to(side, (count,)) for side in both], dtype=float)
    reasons: list[str | None] = [None] * count
    for sign, left, right in zip(constraint.signs, sides[:-1], sides[1:], strict=True):
        kept = holds(sign, left, right)
        for place in np.flatnonzero(~kept):
            if reasons[place] is None:
                reasons[place] = (
                    f"the constraint {constraint.text!r} is broken: "
                    f"{format_quantity(left[place], unit)} is not {sign} "
                    f"{format_quantity(right[place], unit)}"
                )
    return reasons


def constraint_excess(constraint: Constraint, values: Values, units: Units) -> Array:
    """Return the violation of a constraint, as a share of its smaller sides; 0 or less is met."""
    _, sides = _sides(constraint, values, units)
    rows = []
    for sign, left, right in zip(constraint.signs, sides[:-1], sides[1:], strict=True):
        small, large = (left, right) if sign.startswith("<") else (right, left)
        size = np.abs(small)
        rows.append((small - large) / np.where(size > 0.0, size, 1.0))
    worst: Array = np.max(np.broadcast_arrays(*rows), axis=0)
    return worst


def _sides(constraint: Constraint, values: Values, units: Units) -> tuple[str, list[Any]]:
    """Return the unit in which to compare, and the sides in it."""
    sides = [calculated(side, values, units) for side in constraint.sides]
    unit = shown_unit(sides[0])
    return unit, [side.to(unit).magnitude for side in sides]


def holds(sign: str, left: Any, right: Any) -> Flags:
    """Compare values or arrays by a sign; what is not finite holds nothing."""
    with np.errstate(invalid="ignore"):
        margin = EQUAL_WITHIN * np.maximum(np.abs(left), np.abs(right))
        gap = right - left if sign.startswith("<") else left - right
        kept: Flags = np.isfinite(gap) & (gap >= -margin if "=" in sign else gap > margin)
        return kept


Known = Mapping[str, Any]
# Values [SI] by name to that of an expression [SI].
Compiled = Callable[[Known], Any]


def compile_expression(expression: Expression) -> Compiled:
    """Compile a checked expression: floats or arrays [SI] by name to the value [SI]; not finite if undefined.

    For arrays numpy's warnings are the caller's.
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
            result = evaluate(known)
        except ArithmeticError:
            return math.nan
        return math.nan if isinstance(result, complex) else result

    return value


def compile_constraint(constraint: Constraint) -> Compiled:
    """Compile a checked constraint to a test of whether it holds, a bool or an array of them."""
    sides = [compile_expression(side) for side in constraint.sides]

    def test(known: Known) -> Any:
        both = [side(known) for side in sides]
        kept: Any = True
        for sign, left, right in zip(constraint.signs, both, both[1:], strict=False):
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
