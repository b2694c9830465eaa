"""The family of throws of a compliance model: varying, fixed and dependent dimensions.

Here the numbers and labels of a query are checked and completed, before any equation is evaluated.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial, reduce
from typing import Any, cast

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import did_you_mean
from crankbase.errors import InputError, named
from crankbase.model import field_extra
from geometry.throw import CrankThrow
from regression.plans.relations import (
    Compiled,
    compile_expression,
    evaluate_expression,
    evaluation_order,
    read_expression,
)
from regression.throw_values import (
    DEFAULTS,
    SAME,
    declaration,
    field_unit,
    format_value,
    same_dimension,
    throw_values,
)

# A float or an array; of a category a label or an array of labels.
Given = Any


@dataclass(frozen=True)
class Family:
    """Description of a model's throws.

    Attributes
    ----------
    ranges : mapping
        Numeric factor to its range [SI]: fields of a throw, or free names used in relations.
    fixed : mapping
        Field to its value in all runs [SI].
    categories, labels : mapping
        Categorical factor to its labels, categorical field to its label in all runs.
    units : mapping
        Factor to SI unit, if it is not a field of a throw.
    relations : mapping
        Field to its expression in the runs.
    """

    ranges: Mapping[str, tuple[float, float]]
    fixed: Mapping[str, float] = field(default_factory=dict)
    categories: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    relations: Mapping[str, str] = field(default_factory=dict)

    def unit(self, name: str) -> str:
        """SI unit of a name; "" for a pure number."""
        return self.units.get(name) or field_unit(name) or ""

    def format_value(self, name: str, value: float) -> str:
        """Format a value of a name in its unit."""
        return format_value(name, value, self.unit(name))

    @property
    def factors(self) -> tuple[str, ...]:
        """All factors."""
        return (*self.ranges, *self.categories)

    @property
    def all_units(self) -> dict[str, str]:
        """Unit of every number of the family."""
        names = {*self.ranges, *self.fixed, *self.relations}
        return {name: self.unit(name) for name in names}

    def checked(self, query: Mapping[str, Given]) -> dict[str, Given]:
        """The given values as floats, arrays and labels.

        `InputError` if a name is unknown, a number is not finite or of an impossible sign, or a label
        is none of its category's.
        """
        checked: dict[str, Given] = {}
        for name, value in query.items():
            if value.__class__ is float and 0.0 < value < math.inf and name in self.ranges:
                checked[name] = value
            elif name in self.categories:
                checked[name] = _checked_labels(name, value, self.categories[name])
            elif name in self.labels:
                checked[name] = _checked_labels(name, value, (self.labels[name],))
            elif name in self.ranges or name in self.fixed or name in self.relations:
                checked[name] = self._checked_numbers(name, value)
            else:
                known = (*self.factors, *self.relations, *self.fixed, *self.labels)
                raise InputError(
                    f"{named(name)}: unknown dimension; {did_you_mean(name, known)}allowed are "
                    f"{', '.join(self.factors)}, the factors of this model."
                )
        return checked

    def size(self, query: Mapping[str, Given]) -> Given:
        """Size of the given throw relative to the study's throws.

        From its first fixed length. If no length is fixed, the size nearest to 1 at which the lengths are in
        their ranges, and if there is none, at which some are and the others are beyond one end.
        """
        if self._fixes_a_length:
            for name, value in query.items():
                if self.fixed.get(name) and self.unit(name) == "m" and np.all(value):
                    return value / self.fixed[name]
            return 1.0
        lengths = [(query[n], ends) for n, ends in self._varied_lengths.items() if n in query]
        for value, (low, high) in lengths:
            least, most = smallest_and_largest(value)
            if least < low or most > high:
                break
        else:
            return 1.0
        ends = (
            reduce(np.maximum, [value / high for value, (_, high) in lengths]),
            reduce(np.minimum, [value / low for value, (low, _) in lengths]),
        )
        size = np.minimum(np.maximum(1.0, np.minimum(*ends)), np.maximum(*ends))
        return size if size.ndim else float(size)

    @cached_property
    def _fixes_a_length(self) -> bool:
        return any(value and self.unit(name) == "m" for name, value in self.fixed.items())

    @cached_property
    def _varied_lengths(self) -> dict[str, tuple[float, float]]:
        """Lengths that vary, except those that may be absent and do not indicate the size."""
        ranges = self.ranges.items()
        return {name: ends for name, ends in ranges if self.unit(name) == "m" and ends[0] > 0.0}

    def completed(self, query: Mapping[str, Given], size: Given = 1.0) -> dict[str, Given]:
        """Add fixed values, and those that follow by the relations from known ones.

        `InputError` if one has no value.

        `size` is that of the throw: the relations are between its lengths divided by this.
        """
        known = {**self.fixed, **self.labels, **query}
        if self.relations.keys() - query.keys():
            known |= self._related(query, size)
        return known

    def check_fixed(self, query: Mapping[str, Given]) -> None:
        """Refuse a fixed dimension of another value (`InputError`)."""
        for name, value in self.fixed.items():
            if name in query:
                self._check_equal(name, query[name], value, "it is fixed in this model")

    def check_related(self, query: Mapping[str, Given], size: Given = 1.0) -> None:
        """Refuse a dimension that violates its relation, if that can be calculated (`InputError`)."""
        targets = [name for name in query if name in self.relations]
        if not targets:
            return
        others = {name: value for name, value in query.items() if name not in targets}
        expected = self._related(others, size)
        for name in targets:
            if name not in expected:
                continue
            reason = f"in this model {name} = {self.relations[name]}"
            self._check_equal(name, query[name], expected[name], reason)

    def _related(self, query: Mapping[str, Given], size: Given) -> dict[str, Given]:
        units = self.all_units
        numbers = {name: value for name, value in query.items() if name in units}
        at_study_size = {
            name: value / size if units[name] == "m" else value for name, value in numbers.items()
        }
        following = _related(self.relations, {**self.fixed, **at_study_size}, units)
        return {n: value * size if units[n] == "m" else value for n, value in following.items()}

    def _check_equal(self, name: str, number: Given, expected: Given, reason: str) -> None:
        plain = number.__class__ is float and expected.__class__ is float
        if plain and abs(number - expected) <= SAME * abs(expected):
            return
        values, wanted = np.broadcast_arrays(number, expected)
        wrong = np.abs(values - wanted) > SAME * np.abs(wanted)
        if not np.any(wrong):
            return
        place = int(np.argmax(np.where(wrong, np.abs(values - wanted), 0.0)))
        raise InputError(
            f"{name}: given {self.format_value(name, float(values.flat[place]))}; allowed is "
            f"{self.format_value(name, float(wanted.flat[place]))}, because {reason} (its factors are "
            f"{', '.join(self.factors)})."
        )

    def _lower_limit(self, name: str) -> float:
        """The lower limit of a number: features may be absent (0), offsets of bores negative."""
        if name in self.ranges:
            return self.ranges[name][0]
        info = declaration(name)
        minimum = None if info is None else field_extra(info, "minimum_si")
        return 1.0 if minimum is None else float(minimum)

    def free_factors(self, asked: Mapping[str, float | str], size: float) -> dict[str, float]:
        """Find factors that are not dimensions, such as ratios, from the dimensions related to them.

        Only by relations with a unique solution, between lengths divided by the throw's size.
        """
        free = [name for name in self.ranges if declaration(name) is None]
        if not free:
            return {}
        units = self.all_units
        uses = {
            target: set(read_expression(text, target, units).names)
            for target, text in self.relations.items()
        }
        known = {
            name: value / size if units[name] == "m" else value
            for name, value in asked.items()
            if isinstance(value, float)
        }
        solved: dict[str, float] = {}
        for _ in free:
            for target, names in uses.items():
                unknown = [name for name in free if name in names and name not in solved]
                if len(unknown) != 1 or target not in known:
                    continue
                name = unknown[0]
                others = {n: v for n, v in known.items() if n != target} | solved
                if not uses[target] <= {*others, name}:
                    continue
                relation = {target: self.relations[target]}
                solution = _solution(
                    partial(_related_value, relation, others, units, name),
                    *self.ranges[name],
                    known[target],
                )
                if solution is not None:
                    solved[name] = solution
        return {
            name: value * size if units[name] == "m" else value for name, value in solved.items()
        }

    def _checked_numbers(self, name: str, value: object) -> float | Array:
        """Return finite numbers, positive ones unless the model's least value permits otherwise."""
        if isinstance(value, float) and 0.0 < value < math.inf:
            return float(value)
        least = self._lower_limit(name)
        sign = "positive finite numbers" if least > 0.0 else "positive finite numbers (or 0)"
        sign = "finite numbers" if least < 0.0 else sign
        kind = "in SI units (m for a length)" if self.unit(name) else "without a unit"
        allowed = f"allowed are {sign} {kind}"
        try:
            raw = np.asarray(value)
            if raw.dtype.kind not in "iuf":
                raise TypeError
            array = raw.astype(np.float64, copy=False)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name}: given {value!r}; {allowed}.") from None
        if array.size == 0:
            raise InputError(f"{name}: given an empty array; {allowed}.")
        # NaN passes through both.
        low, high = float(np.min(array)), float(np.max(array))
        if not (np.isfinite(low) and np.isfinite(high)) or (
            least >= 0.0 and (low < 0.0 or (least > 0.0 and low == 0.0))
        ):
            wrong = ~np.isfinite(array) | ((array <= 0.0) if least > 0.0 else (array < 0.0))
            # What is shown has its unit, so that nothing need be said of units.
            shown = self.format_value(name, float(array[wrong].flat[0]))
            raise InputError(f"{name}: given {shown}; allowed are {sign}.")
        return array if array.ndim else float(array)


def smallest_and_largest(values: Any) -> tuple[float, float]:
    """Ends of a number or an array; for numbers without numpy, which takes longer than a lookup may."""
    if values.__class__ is float:
        return values, values
    return float(np.min(values)), float(np.max(values))


def _checked_labels(name: str, value: object, labels: tuple[str, ...]) -> Any:
    """Return a label, or an array of labels."""
    if isinstance(value, str) and value in labels:
        return value
    array = np.asarray(value)
    if array.dtype.kind == "U" and array.size and np.all(np.isin(array, labels)):
        return array if array.ndim else str(array)
    others = array.ravel().tolist() if array.dtype.kind == "U" else [value]
    wrong = next((label for label in others if label not in labels), value)
    raise InputError(f"{name}: given {wrong!r}; allowed is {' or '.join(labels)}.")


Pairs = tuple[tuple[str, str], ...]


def _related(
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


# Beginnings of the names of what makes one end of a throw another than the other.
_ONE_SIDED = ("left_web.", "right_web.", "further_pins.", "oil_holes.")
# A solution of a relation is sought to this share; relations are checked to `SAME`.
_ROUNDING = 1e-13


def angle_law_remarks(family: Family, study_throw: Mapping[str, Any] | None) -> tuple[str, ...]:
    """State that the angle law is not exact for throws that are not symmetric about their middle."""
    varying = (*family.factors, *family.relations)
    names = varying if study_throw is not None else (*varying, *family.fixed, *family.labels)
    alike = study_throw is None or CrankThrow(**study_throw).symmetry == "quarter"
    if alike and not any(name.startswith(_ONE_SIDED) for name in names):
        return ()
    return (
        "The model's throws are not alike from both ends, or what one end has of its own varies: the angle "
        "law is an interpolation between 0, 90 and 180 deg for them, and the band does not hold its error.",
    )


def query_for_throw(
    throw: CrankThrow, family: Family, study_throw: Mapping[str, Any] | None
) -> dict[str, float | str]:
    """Query to a model for a throw: numbers [SI] and labels, with the fixed ones, so that they are checked.

    `study_throw` is the throw that the study varied, as a record; None: the model's throws have only
    the dimensions of the family. `InputError` if the throw has a feature that these lack, or lacks one.
    """
    dimensions = throw_values(throw)
    study = {} if study_throw is None else throw_values(CrankThrow(**study_throw))
    numbers = tuple(dict.fromkeys((*family.ranges, *family.fixed, *family.relations)))
    asked: dict[str, float | str] = {}
    for name in numbers:
        value = dimensions.get(name)
        field = declaration(name)
        if value is None and field is not None:
            if name in DEFAULTS:
                other, share = DEFAULTS[name]
                base = dimensions.get(other)
                value = share * base if isinstance(base, float) else None
            elif field_extra(field, "feature"):
                value = 0.0
        if isinstance(value, float):
            asked[name] = value
    for name in (*family.categories, *family.labels):
        label = dimensions.get(name)
        if label is not None:
            asked[name] = label
    others = {name: value for name, value in dimensions.items() if name not in asked}
    expected = {name: value for name, value in study.items() if name not in asked}
    size = family.size({name: value for name, value in asked.items() if name in numbers})
    for name in dict.fromkeys((*others, *expected)):
        _check_same(name, others.get(name), expected.get(name), size)
    return asked | family.free_factors(asked, size)


def _check_same(
    name: str, own_value: float | str | None, expected: float | str | None, size: float
) -> None:
    """Refuse differences from the study's throw; lengths are compared at the study's size."""
    info = declaration(name)
    if expected is None and info is not None and own_value == info.default:
        return
    wanted = expected
    if isinstance(expected, float) and field_unit(name) == "m":
        wanted = expected * size
    numbers = isinstance(own_value, float) and isinstance(wanted, float)
    if own_value == wanted or (
        numbers and same_dimension(cast(float, own_value), cast(float, wanted))
    ):
        return
    raise InputError(
        f"throw.{name}: given {_format_dimension(name, own_value)}; allowed is "
        f"{_format_dimension(name, wanted)}, because the "
        "throws that the model was fitted to were so."
    )


def _format_dimension(name: str, value: float | str | None) -> str:
    if value is None:
        return "none"
    return value if isinstance(value, str) else format_value(name, value)


def _related_value(
    relation: Mapping[str, str],
    known: Mapping[str, float],
    units: Mapping[str, str],
    name: str,
    number: float,
) -> float:
    """Result of one relation with `name` equal to this number."""
    (value,) = _related(relation, {**known, name: number}, units).values()
    return float(value)


def _solution(
    value: Callable[[float], float], low: float, high: float, target: float
) -> float | None:
    """Find where a function over a range has a value; None if this is not certain."""
    start, stop = value(low), value(high)
    if start == stop:
        return None
    straight = low + (high - low) * (target - start) / (stop - start)
    inside = low < straight < high
    try:
        if same_dimension(value(straight), target):
            return straight
        from scipy import optimize  # a lookup by numbers does without

        def miss(number: float) -> float:
            return value(number) - target

        width = high - low
        if inside:
            root = optimize.brentq(miss, low, high, xtol=_ROUNDING * width)
        else:
            root = optimize.newton(miss, low, x1=high, tol=_ROUNDING * width, rtol=_ROUNDING)
    except (InputError, RuntimeError):  # beyond the range there may be no value, or no end of steps
        return None
    # Where the ends have values on the same side, a solution inside has another one beside it.
    certain = same_dimension(value(root), target) and inside == (low < root < high)
    return float(root) if certain else None
