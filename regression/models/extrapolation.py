"""Values outside the range of an equation's fit: their distance, and the sentences on them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from crankbase.errors import InputError
from regression.fits.selection import COVERAGE
from regression.models.response_model import ResponseModel
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
from regression.throw_values import SAME, format_value

# Smaller relative errors are rounding, and not told by their value.
LEAST_SAID = 1e-5
# The largest error of so many designs holds 95 % of new ones on the average.
FEWEST = 19
# A larger factor is the same as none: errors of nearly 100 %, or estimates beyond all measure.
_OPEN = 1e30


@dataclass(frozen=True)
class ErrorBand:
    """The band of a response as factors of its value, and its origin in one sentence.

    `lower` leads to the end nearer to zero, `upper` to the other; None if an error of 100 % leaves it
    open.
    """

    lower: float
    upper: float | None
    text: str

    def around(self, values: Any, inside: Any) -> tuple[Any, Any]:
        """Lower and upper ends round a value, or an array of them; infinite where open, and not inside."""
        far = np.copysign(np.inf, values) if self.upper is None else values * self.upper
        ends = values * self.lower, far
        if values.__class__ is float:
            return (min(ends), max(ends)) if inside else (-math.inf, math.inf)
        if np.min(values) < 0.0:
            ends = np.minimum(*ends), np.maximum(*ends)
        if np.all(inside):
            return ends
        return np.where(inside, ends[0], -np.inf), np.where(inside, ends[1], np.inf)


def percent(share: float) -> str:
    """Write an error; below 0.001 % it is rounding.

    Examples
    --------
    >>> percent(0.018), percent(4.4e-16)
    ('1.8 %', 'below 0.001 %')
    """
    return f"{100.0 * share:.2g} %" if share >= LEAST_SAID else f"below {100.0 * LEAST_SAID:g} %"


def equation_error(response: ResponseModel) -> float:
    """Relative error of an equation for its band."""
    if response.band_error is not None:
        return response.band_error
    return max(response.largest_error, response.largest_heldout_error or 0.0)


def error_band(response: ResponseModel) -> ErrorBand:
    """Find the band of a response."""
    m = equation_error(response)
    f = response.largest_fe_error or 0.0
    lower = (1.0 if response.too_small else max(0.0, 1.0 - f)) / (1.0 + m)
    upper = (1.0 + f) / (1.0 - m) if m < 1.0 else math.inf
    elements = (
        "the error of the finite elements was not estimated"
        if response.largest_fe_error is None
        else f"the finite elements' own estimate is {percent(f)}"
        + (", by which they are too small" if response.too_small else " either way")
    )
    text = f"{_told(response)}; {elements}"
    return ErrorBand(lower, upper if upper < _OPEN else None, text)


def _told(response: ResponseModel) -> str:
    """State on which designs the equation's error is based."""
    error, held_out = equation_error(response), response.largest_heldout_error
    if response.band_error is not None:
        held = f"{response.heldout_runs} held-out designs" if response.heldout_runs else ""
        left_out = response.band_designs > response.heldout_runs
        runs = f"{response.runs} runs, each left out of the fit in turn" if left_out else ""
        designs = ", and ".join(filter(None, (runs, held)))
        of = (
            f"{100.0 * COVERAGE:g} % of new throws"
            if response.band_designs >= FEWEST
            else f"designs not seen, too few for {100.0 * COVERAGE:g} % of new throws,"
        )
        return f"{of} are predicted within {percent(error)}, by {designs}"
    designs = f"{response.heldout_runs} held-out designs"
    if held_out is None:
        designs = f"the {response.runs} fitted runs themselves, without held-out designs too small an error"
    elif held_out < error:
        designs = f"the {response.runs} fitted runs, {100.0 * held_out:.2g} % at {designs}"
    return f"largest error {100.0 * error:.2g} % at {designs}"


# So many times as large as the range's end, or as small, or so many widths beyond it, an equation
# says nothing; most likely the unit is another: 70 for 0.070 m.
FARTHEST = 100.0


class OutsideRangeWarning(UserWarning):
    """A compliance outside the range of dimensions of its fit."""


@dataclass(frozen=True)
class OutOfRange:
    """One column or dimension whose values are out of its range [SI]: the farthest value, and how many are.

    `alone`: whether this is a single number, not multiplied by arrays.
    """

    name: str
    value: float
    number: int
    lowest: float
    highest: float
    unit: str
    alone: bool = False

    @property
    def distance(self) -> float:
        """Distance of the farthest value from the range, as a share of the range's width."""
        beyond = max(self.lowest - self.value, self.value - self.highest)
        return beyond / (self.highest - self.lowest)

    @property
    def remark(self) -> str:
        """One sentence for a value that is returned nevertheless."""
        return (
            f"{self._given}; the range of the fit is {self._range}, and "
            f"{100.0 * self.distance:.3g} % of its width beyond it the error is unknown."
        )

    @property
    def error_sentence(self) -> str:
        """One sentence for a value that is refused."""
        return (
            f"{self._given}; allowed is the range of the fit, {self._range}, because a result "
            f"{100.0 * self.distance:.3g} % of its width beyond it has no known error and strict results are "
            "requested."
        )

    def check_distance(self) -> None:
        """Refuse a value so far outside that an equation is meaningless (`InputError`)."""
        large = self.value > FARTHEST * self.highest > 0.0
        small = 0.0 < FARTHEST * self.value < self.lowest
        if large or small or self.distance > FARTHEST:
            hint = " (mm given in place of m?)" if large and self.unit == "m" else ""
            raise InputError(
                f"{self._given}; allowed is the range of the fit, {self._range}, or what is near it, because "
                f"{FARTHEST:g} times beyond it the equation is meaningless{hint}."
            )

    @property
    def _given(self) -> str:
        several = f" (and {self.number - 1} more)" if self.number > 1 else ""
        return f"{self.name}: given {format_value(self.name, self.value, self.unit)}{several}"

    @property
    def _range(self) -> str:
        low, high = (format_value(self.name, v, self.unit) for v in (self.lowest, self.highest))
        return f"{low} to {high}"


def edges(lowest: float, highest: float) -> tuple[float, float]:
    """Return a range widened by rounding, so that its own ends are inside."""
    margin = SAME * max(abs(lowest), abs(highest))
    return lowest - margin, highest + margin


def find_out_of_range(
    name: str, values: Any, lowest: float, highest: float, unit: str, size: Any = 1.0
) -> tuple[OutOfRange, Any] | None:
    """Find the values outside a range: the finding, and where they are; None if none is.

    `size` is a factor on the range: the size of the throw, for a length.
    """
    at_study = values / size
    if at_study.__class__ is float and lowest <= at_study <= highest:
        return None
    low, high = edges(lowest, highest)
    if isinstance(at_study, float):
        if low <= at_study <= high:
            return None
        return OutOfRange(name, values, 1, lowest * size, highest * size, unit, alone=True), True
    if low <= np.min(at_study) and np.max(at_study) <= high:
        return None
    outside = (at_study < low) | (at_study > high)
    place = int(np.argmax(np.maximum(lowest - at_study, at_study - highest)))
    value, scale = (float(np.broadcast_to(part, outside.shape)[place]) for part in (values, size))
    number = int(np.count_nonzero(outside))
    return OutOfRange(name, value, number, lowest * scale, highest * scale, unit), outside


Pairs = tuple[tuple[str, str], ...]


def related(
    relations: Mapping[str, str], known: Mapping[str, Any], units: Mapping[str, str]
) -> dict[str, Any]:
    """Calculate the dimensions [SI] that follow from others by relations, field to expression.

    A field among the known ones is not calculated, nor one whose expression uses unknown ones. `units`
    has the SI unit of every name. `InputError` if an expression has no value for the known dimensions.
    """
    values = dict(known)
    following: dict[str, Any] = {}
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
        following[name] = values[name] = result if np.ndim(result) else float(result)
    return following


@lru_cache(maxsize=100)
def _compiled(relations: Pairs, units: Pairs) -> tuple[tuple[str, frozenset[str], Compiled], ...]:
    """Compile relations in the order in which they can be calculated."""
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
    """Designs that the study excluded by a constraint: the violation by the first, and their number.

    `alone` as in `OutOfRange`.
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
    """A constraint of a study, ready for throws of its size; `units` are SI units of all names."""

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
        first = {
            name: np.broadcast_to(value, held.shape).reshape(-1)[place]
            for name, value in used.items()
        }
        (reason,) = constraint_violations(self.read, first, self.units, 1)
        broken = ~held
        finding = BrokenConstraint(
            self.read.text, reason or "", int(np.count_nonzero(broken)), alone=held.ndim == 0
        )
        return finding, broken if held.ndim else True


def worst(findings: Sequence[Finding]) -> list[Finding]:
    """Join findings of pieces of one array: one for each name, with the farthest value."""
    joined: dict[str, Finding] = {}
    for finding in findings:
        other = joined.get(finding.name)
        if other is None:
            joined[finding.name] = finding
        if other is None or finding.alone:  # each piece finds the same number
            continue
        far = other
        if isinstance(finding, OutOfRange) and isinstance(other, OutOfRange):
            far = finding if finding.distance > other.distance else other
        joined[finding.name] = replace(far, number=finding.number + other.number)
    return list(joined.values())
