"""The box of an optimum search: a model's ranges and choices, with the study's constraints."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from geometry.throw import CrankThrow
from regression.models.compliance_model import ComplianceModel
from regression.models.extrapolation import edges
from regression.models.optimum_limits import Points

Array = NDArray[np.float64]

# Share of a range within which a place is its end; limits have more than this to spare.
_AT_END = 1e-10

# How far constraints are broken at points; 0 or less is kept.
Excess = Callable[[Points], Any]


@dataclass(frozen=True)
class SearchSpace:
    """A box of numbers, 0 to 1 each, and choices.

    Attributes
    ----------
    model : ComplianceModel
    ranges : dict
        Number to its range.
    fixed : dict
        Fixed numbers.
    choices : dict
        Category to its labels.
    labels : dict
        Fixed labels.
    constraints : tuple of callable
    """

    model: ComplianceModel
    ranges: dict[str, tuple[float, float]]
    fixed: dict[str, float]
    choices: dict[str, tuple[str, ...]]
    labels: dict[str, str]
    constraints: tuple[Excess, ...]

    @property
    def dimensions(self) -> int:
        """Number of varying numbers."""
        return len(self.ranges)

    def numbers(self, places: Array) -> dict[str, Any]:
        """Factors at points of the box, (dimensions,) or (dimensions, n)."""
        ends = self.ranges.values()
        varied = {
            name: low + place * (high - low)
            for name, place, (low, high) in zip(self.ranges, places, ends, strict=True)
        }
        return {name: varied[name] if name in varied else self.fixed[name] for name in self._order}

    def exact_numbers(self, place: Array) -> dict[str, float]:
        """Factors at one point, the ends of ranges to the last digit."""
        found = {name: float(value) for name, value in self.numbers(place).items()}
        for (name, (low, high)), where in zip(self.ranges.items(), place, strict=True):
            if min(where, 1.0 - where) < _AT_END:
                found[name] = low if where < 0.5 else high
        return found

    @property
    def _order(self) -> tuple[str, ...]:
        return tuple(self.model.family.ranges)

    def at_ends(self, place: Array) -> tuple[str, ...]:
        """Numbers at an end of their range."""
        return tuple(
            name
            for name, where in zip(self.ranges, place, strict=True)
            if min(where, 1.0 - where) < _AT_END
        )

    def excess(self, points: Points) -> list[Any]:
        """Violation of the study's constraints."""
        return [constraint(points) for constraint in self.constraints]

    def throw(self, known: Mapping[str, float | str]) -> tuple[CrankThrow | None, list[str]]:
        """Build the throw of some dimensions, or say why it cannot be built."""
        if self.model.throw is None:
            return None, []
        from regression.plans.factors import changed_record
        from regression.throw_values import declaration

        record = CrankThrow(**self.model.throw).model_dump(mode="json")
        fields = {name: value for name, value in known.items() if declaration(name) is not None}
        try:
            return CrankThrow(**changed_record(record, fields)), []
        except InputError as error:
            return None, [f"this throw cannot be built: {error}"]


def search_space(model: ComplianceModel, fixed: Mapping[str, float | str]) -> SearchSpace:
    """Set up the box of a search.

    Parameters
    ----------
    model : ComplianceModel
    fixed : mapping
        Fixed factors.

    Raises
    ------
    InputError
        If a fixed factor is not one of the model's, or is outside its range.
    """
    family = model.family
    numbers: dict[str, float] = {}
    labels: dict[str, str] = {}
    for name, value in family.checked(fixed).items():
        if name in family.categories:
            labels[name] = value
            continue
        if name not in family.ranges:
            raise InputError(
                f"fixed: given {name}; allowed are the factors {', '.join(family.factors)}, because "
                "other dimensions do not vary anyway."
            )
        low, high = edges(*family.ranges[name])
        if not low <= value <= high:
            raise InputError(
                f"fixed: given {family.format_value(name, value)} for {name}; allowed is "
                f"{family.format_value(name, family.ranges[name][0])} to "
                f"{family.format_value(name, family.ranges[name][1])}, the range of the model."
            )
        numbers[name] = float(value)
    constraints = [_constraint(model, text) for text in model.constraints or ()]
    return SearchSpace(
        model=model,
        ranges={name: ends for name, ends in family.ranges.items() if name not in numbers},
        fixed=numbers,
        choices={name: found for name, found in family.categories.items() if name not in labels},
        labels=labels,
        constraints=tuple(constraints),
    )


def _constraint(model: ComplianceModel, text: str) -> Excess:
    """A constraint of the study as a function that is 0 or less if it is met."""
    from regression.plans.constraints import constraint_excess, read_constraint

    units = model.family.all_units
    read = read_constraint(text, "constraint", units)

    def excess(points: Points) -> Any:
        known = points.model.family.completed(points.factors)
        used = {name: known[name] for name in read.names}
        values = dict(zip(used, np.broadcast_arrays(*used.values()), strict=True))
        return constraint_excess(read, values, units)

    return excess
