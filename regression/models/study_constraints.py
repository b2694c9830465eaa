"""A study's constraints applied to a query: violated ones, and the sentences on them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from crankbase.errors import InputError
from regression.models.extrapolation import OutOfRange
from regression.plans.relations import (
    Compiled,
    Constraint,
    compile_constraint,
    compile_expression,
    constraint_violations,
    evaluate_expression,
    evaluation_order,
    read_expression,
)

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


@dataclass(frozen=True)
class BrokenConstraint:
    """Designs that the study excluded by one of its constraints.

    Attributes
    ----------
    name : str
        The constraint.
    reason : str
        Violation by the first of them.
    number : int
        Their number.
    alone : bool
        As in `OutOfRange`.
    """

    name: str
    reason: str
    number: int
    alone: bool = False

    @property
    def remark(self) -> str:
        """One sentence for a value that is returned nevertheless."""
        return f"{self._given}; the study excluded such designs, so the error is unknown."

    @property
    def error_sentence(self) -> str:
        """One sentence for a value that is refused."""
        return (
            f"{self._given}; allowed are those that keep it, because the study excluded such designs and "
            "strict results are requested."
        )

    def check_distance(self) -> None:
        """Refuse nothing: a constraint is met or violated."""

    @property
    def _given(self) -> str:
        several = f" (and {self.number - 1} more)" if self.number > 1 else ""
        return f"dimensions: given ones by which {self.reason}{several}"


Finding = OutOfRange | BrokenConstraint


class StudyConstraint:
    """A constraint of a study, ready for throws of its size.

    Parameters
    ----------
    read : Constraint
    units : mapping
        SI unit of every name allowed in it.
    """

    def __init__(self, read: Constraint, units: Mapping[str, str]) -> None:
        self.read, self.units = read, units
        self.holds: Compiled = compile_constraint(read)

    def find_broken(self, known: Mapping[str, Any]) -> tuple[BrokenConstraint, Any] | None:
        """Find violations; as `find_out_of_range`, of values at the study's size."""
        used = {name: known[name] for name in self.read.names}
        with np.errstate(all="ignore"):
            held = np.asarray(self.holds(used))
        if np.all(held):
            return None
        place = int(np.argmin(held))
        one = {
            name: np.broadcast_to(value, held.shape).reshape(-1)[place]
            for name, value in used.items()
        }
        (reason,) = constraint_violations(self.read, one, self.units, 1)
        broken = ~held
        found = BrokenConstraint(
            self.read.text, reason or "", int(np.count_nonzero(broken)), alone=held.ndim == 0
        )
        return found, broken if held.ndim else True


def worst(found: Sequence[Finding]) -> list[Finding]:
    """Join findings of pieces of one array: one for each name, with the farthest value."""
    joined: dict[str, Finding] = {}
    for one in found:
        other = joined.get(one.name)
        if other is None:
            joined[one.name] = one
        if other is None or one.alone:  # each piece finds the same number
            continue
        far = other
        if isinstance(one, OutOfRange) and isinstance(other, OutOfRange):
            far = one if one.distance > other.distance else other
        joined[one.name] = replace(far, number=one.number + other.number)
    return list(joined.values())
