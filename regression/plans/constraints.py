"""Constraints of a study: comparisons between expressions that every design must fulfill."""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.units.quantity import format_quantity
from regression.plans.relations import (
    Expression,
    Units,
    Values,
    calculated,
    check_length,
    kind_of,
    read_expression,
    same_kind,
    shown_unit,
)

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
    """Check the grammar of a constraint and that its sides are of one kind.

    Raises
    ------
    InputError
        If it is not a comparison by <, <=, > or >=, or compares quantities of different kinds.
    """
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
    unit, found = _sides(constraint, values, units)
    sides = np.array([np.broadcast_to(side, (count,)) for side in found], dtype=float)
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


def constraint_excess(constraint: Constraint, values: Values, units: Units) -> NDArray[np.float64]:
    """Return the violation of a constraint, as a share of its smaller sides; 0 or less is met."""
    _, sides = _sides(constraint, values, units)
    rows = []
    for sign, left, right in zip(constraint.signs, sides[:-1], sides[1:], strict=True):
        small, large = (left, right) if sign.startswith("<") else (right, left)
        size = np.abs(small)
        rows.append((small - large) / np.where(size > 0.0, size, 1.0))
    worst: NDArray[np.float64] = np.max(np.broadcast_arrays(*rows), axis=0)
    return worst


def _sides(constraint: Constraint, values: Values, units: Units) -> tuple[str, list[Any]]:
    """Return the unit in which to compare, and the sides in it."""
    found = [calculated(side, values, units) for side in constraint.sides]
    unit = shown_unit(found[0])
    return unit, [side.to(unit).magnitude for side in found]


def holds(sign: str, left: Any, right: Any) -> NDArray[np.bool_]:
    """Compare values or arrays by a sign; what is not finite holds nothing."""
    with np.errstate(invalid="ignore"):
        margin = EQUAL_WITHIN * np.maximum(np.abs(left), np.abs(right))
        gap = right - left if sign.startswith("<") else left - right
        kept: NDArray[np.bool_] = np.isfinite(gap) & (
            gap >= -margin if "=" in sign else gap > margin
        )
        return kept
