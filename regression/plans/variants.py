"""From factor values to throws: relations, constraints, and whether they can be built."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from geometry.throw import CrankThrow
from regression.plans.factors import (
    FREE_NAME,
    Factor,
    ThrowField,
    changed_record,
    field_value,
    rounded,
    throw_fields,
    unknown_field,
)
from regression.plans.relations import (
    EQUAL_WITHIN,
    Constraint,
    Expression,
    constraint_excess,
    constraint_violations,
    evaluate_expression,
    evaluation_order,
    is_unit,
    read_constraint,
    read_expression,
    used_names,
)


@dataclass(frozen=True)
class Variant:
    """A throw from factor values, as its record; or None and the reason why there is none."""

    throw: dict[str, Any] | None
    reason: str = ""


@dataclass(frozen=True)
class Variants:
    """The throws that follow from a study's factors, relations, constraints and base throw.

    Attributes
    ----------
    record : mapping
        Of the base throw.
    factors : tuple of Factor
    fields : mapping
        Path to the fields that can vary.
    units : mapping
        SI units of all quantities allowed in expressions.
    relations : mapping
        Path to expression, in the order of calculation.
    constraints : tuple of Constraint
    """

    record: Mapping[str, Any]
    factors: tuple[Factor, ...]
    fields: Mapping[str, ThrowField]
    units: Mapping[str, str]
    relations: Mapping[str, Expression]
    constraints: tuple[Constraint, ...]

    @classmethod
    def of(
        cls,
        throw: CrankThrow,
        factors: tuple[Factor, ...],
        relations: Mapping[str, str],
        constraints: tuple[str, ...],
    ) -> "Variants":
        """Check that all names are known and all units fit.

        Raises
        ------
        InputError
            If they do not; the message names the factor, the relation or the constraint.
        """
        fields, record = throw_fields(throw), throw.model_dump(mode="json")
        names = [factor.name for factor in factors]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"study.factors.{name}: given twice; allowed is each factor once.")
        for path in relations:
            _check_target(path, fields, throw, names)
        units = {
            path: found.unit
            for path, found in fields.items()
            if not found.choices and (field_value(record, path) is not None or path in relations)
        } | {factor.name: factor.unit for factor in factors if not factor.categorical}
        read = {
            path: read_expression(text, f"study.relations.{path}", units)
            for path, text in relations.items()
        }
        limits = tuple(
            read_constraint(text, f"study.constraints[{place}]", units)
            for place, text in enumerate(constraints)
        )
        for factor in factors:
            _check_factor(factor, fields, throw, used_names(read.values()))
        ones = dict.fromkeys(units, np.array(1.0))
        for path, expression in read.items():
            evaluate_expression(expression, ones, units, fields[path].unit)  # refuses another unit
        ordered = {path: read[path] for path in evaluation_order(read)}
        return cls(record, factors, fields, units, ordered, limits)

    def at(self, values: NDArray[np.float64]) -> tuple[Variant, ...]:
        """Make the throws of factor values.

        Parameters
        ----------
        values : (n, k) array
            [SI]; of a choice the label's index.
        """
        count = len(values)
        reasons: list[str | None] = [None] * count
        known = self._quantities(values)
        for path, expression in self.relations.items():
            found = np.broadcast_to(
                evaluate_expression(expression, known, self.units, self.units[path]), (count,)
            )
            known[path] = np.array([rounded(value) for value in found.tolist()])
            for place in np.flatnonzero(~np.isfinite(known[path])).tolist():
                reasons[place] = reasons[place] or (
                    f"the relation {path} = {expression.text!r} has no finite value"
                )
        for constraint in self.constraints:
            for place, reason in enumerate(
                constraint_violations(constraint, known, self.units, count)
            ):
                reasons[place] = reasons[place] or reason
        return tuple(
            self._variant(row, place, known, reasons[place])
            for place, row in enumerate(values.tolist())
        )

    def keep_constraints(self, values: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which factor values (n, k) meet the constraints, whether throws can be built or not."""
        known = self._quantities(values)
        kept = np.ones(len(values), dtype=bool)
        for path, expression in self.relations.items():
            known[path] = evaluate_expression(expression, known, self.units, self.units[path])
        for constraint in self.constraints:
            kept &= constraint_excess(constraint, known, self.units) <= EQUAL_WITHIN
        return kept

    def _quantities(self, values: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        columns = {
            factor.name: column
            for factor, column in zip(self.factors, values.T, strict=True)
            if not factor.categorical
        }
        used = used_names(
            (*self.relations.values(), *(side for one in self.constraints for side in one.sides))
        )
        base = {
            path: np.array(float(field_value(self.record, path)))
            for path in used
            if path not in columns and path not in self.relations
        }
        return base | columns

    def _variant(
        self,
        row: list[float],
        place: int,
        known: Mapping[str, NDArray[np.float64]],
        reason: str | None,
    ) -> Variant:
        if reason is not None:
            return Variant(None, reason)
        changes: dict[str, Any] = {
            factor.name: factor.format_value(value) if factor.categorical else value
            for factor, value in zip(self.factors, row, strict=True)
            if factor.name in self.fields
        }
        changes |= {path: float(known[path][place]) for path in self.relations}
        try:
            throw = CrankThrow(**changed_record(self.record, changes))
        except InputError as error:
            return Variant(None, f"it cannot be built: {str(error).rstrip('.')}")
        return Variant(throw.model_dump(mode="json"))


def _check_target(
    path: str, fields: Mapping[str, ThrowField], throw: CrankThrow, factors: list[str]
) -> None:
    name = f"study.relations.{path}"
    if path not in fields:
        raise InputError(f"{name}: unknown throw dimension; {unknown_field(path, fields, throw)}.")
    if fields[path].choices:
        raise InputError(
            f"{name}: is a choice; allowed are fields that are quantities, because an expression gives a "
            "number."
        )
    if path in factors:
        raise InputError(
            f"{name}: is a factor as well; allowed is either, because a relation fixes what a factor "
            "varies."
        )


def _check_factor(
    factor: Factor, fields: Mapping[str, ThrowField], throw: CrankThrow, used: set[str]
) -> None:
    name, found = f"study.factors.{factor.name}", fields.get(factor.name)
    if found is not None:
        unfit = next((label for label in factor.labels if label not in found.choices), None)
        if unfit is not None or bool(factor.labels) != bool(found.choices):
            given = unfit or factor.range_text
            allowed = ", ".join(found.choices) or f"a range or levels in {found.unit or 'no unit'}"
            raise InputError(f"{name}: given {given}; allowed is {allowed}.")
        if factor.unit != found.unit:
            raise InputError(
                f"{name}: given in {factor.unit or 'no unit'}; allowed is {found.unit or 'no unit'}."
            )
        return
    if factor.name not in used or factor.labels or factor.unit:
        raise InputError(
            f"{name}: unknown throw dimension, and no relation uses it as a ratio; "
            f"{unknown_field(factor.name, fields, throw)}."
        )
    if not FREE_NAME.fullmatch(factor.name) or is_unit(factor.name):
        raise InputError(
            f"{name}: is the name of a unit; allowed for a ratio is a name of letters, digits and "
            "underscores that is none."
        )
