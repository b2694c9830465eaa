"""One response of a compliance model, ready for queries: names to columns, columns to a value.

Numbers and arrays take the same path; for plain numbers it needs no numpy.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from operator import itemgetter
from typing import Any

import numpy as np

from crankbase.errors import InputError
from crankbase.quantity import format_number
from crankbase.sentences import amount, finished
from fem.material import Material
from regression.fits.forms import GROUPS, FittedForm, Term, code, group_named
from regression.fits.selection import COVERAGE
from regression.models.family import Family, Given, smallest_and_largest
from regression.models.response_model import IS, ResponseModel
from regression.plans.relations import (
    Compiled,
    Constraint,
    compile_constraint,
    constraint_violations,
)
from regression.response_kinds import is_positive_response, response_scale
from regression.throw_values import SAME

# Smaller relative errors are rounding, and not told by their value.
LEAST_SAID = 1e-5
# The largest error of so many designs holds 95 % of new ones on the average.
FEWEST = 19
# Imaginary parts by which slopes are taken [SI]: their squares are nothing beside any value, and both give
# one slope where there is one. As powers of two they change no digit.
_STEPS = np.array([2.0**-166, 2.0**-332])
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

    def around(
        self, values: Any, inside: Any, errors: Callable[[], Any] | None = None
    ) -> tuple[Any, Any]:
        """Lower and upper ends round a value, or an array of them; infinite where open, and not inside.

        `errors` calculates the values' own, as of `ResponseValues`.
        """
        far = np.copysign(np.inf, values) if self.upper is None else values * self.upper
        ends = values * self.lower, far
        if errors is not None:
            error = errors()
            with np.errstate(divide="ignore"):
                ends = ends[0] / (1.0 + error), ends[1] / np.maximum(1.0 - error, 0.0)
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
    # Values of a Gaussian process have errors of their own.
    m = 0.0 if response.process else equation_error(response)
    f = response.largest_fe_error or 0.0
    lower = max(0.0, 1.0 - f) / (1.0 + m)
    upper = (1.0 + f) / (1.0 - m) if m < 1.0 else math.inf
    elements = (
        "the error of the finite elements was not estimated"
        if response.largest_fe_error is None
        else f"the finite elements' own estimate is {percent(f)} either way"
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
        within = percent(error)
        if response.process:
            within = f"{response.process.band:.3g} of the value's own standard deviations"
        return f"{of} are predicted within {within}, by {designs}"
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
        return finished(
            f"{self._given}; the range of the fit is {self._range}; "
            f"{format_number(100.0 * self.distance, 3)} % of its width outside it the error is unknown."
        )

    @property
    def error_sentence(self) -> str:
        """One sentence for a value that is refused."""
        return finished(
            f"{self._given}; allowed is the range of the fit, {self._range}, because a result "
            f"{format_number(100.0 * self.distance, 3)} % of its width beyond it has no known error and "
            "strict results are requested."
        )

    def check_distance(self) -> None:
        """Refuse a value so far outside that an equation is meaningless (`InputError`)."""
        large = self.value > FARTHEST * self.highest > 0.0
        small = 0.0 < FARTHEST * self.value < self.lowest
        if large or small or self.distance > FARTHEST:
            hint = " (mm given in place of m?)" if large and self.unit == "m" else ""
            raise InputError(
                finished(
                    f"{self._given}; allowed is the range of the fit, {self._range}, or what is near it, "
                    f"because {FARTHEST:g} times beyond it the equation is meaningless{hint}."
                )
            )

    @property
    def _given(self) -> str:
        several = f" (and {self.number - 1} more)" if self.number > 1 else ""
        return f"{self.name}: given {self._shown(self.value)}{several}"

    @property
    def _range(self) -> str:
        return f"{self._shown(self.lowest)} to {self._shown(self.highest)}"

    def _shown(self, value: float) -> str:
        return amount(value, self.unit) if self.unit else f"{value:g}"


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


# Values of one column that are evaluated at a time: 64 kB, so that a few columns fit into a cache.
PIECE = 8192

# Floats or arrays: the closures do not ask.
ColumnValues = Any


# Value of the columns, k floats or arrays of one shape, not coded and not logged; with `math` it raises
# `OverflowError` or `ValueError` where there is none, with `numpy` that is infinity or NaN.
Equation = Callable[[Sequence[ColumnValues], Any], ColumnValues]


def compile_equation(fitted: FittedForm) -> Equation:
    """Compile a fitted form: equal to `fitted.predict` within rounding."""
    codings = tuple(zip(fitted.log_factors, fitted.center, fitted.half_range, strict=True))
    polynomial = _horner_tree(dict(zip(fitted.terms, fitted.coefficients, strict=True)))
    process = fitted.process
    # exp(constant) once and for all: the rest is of order 1 and loses no digits in the exponential.
    size = math.exp(polynomial.constant) if fitted.logarithmic else 1.0
    total = _closure(_HornerNode(0.0, polynomial.children) if fitted.logarithmic else polynomial)

    def evaluate(columns: Sequence[ColumnValues], library: Any) -> ColumnValues:
        coded = [
            ((library.log(value) if logged else value) - center) / half_range
            for value, (logged, center, half_range) in zip(columns, codings, strict=True)
        ]
        value = total(coded)
        if process is not None:
            further = process.predict(np.stack(np.broadcast_arrays(*coded), axis=-1))
            value = value + (further if further.ndim else further.item())
        return size * library.exp(value) if fitted.logarithmic else value

    return evaluate


# Relative errors of values at the columns.
ErrorsOfValues = Callable[[Sequence[ColumnValues], ColumnValues], Any]


def compile_errors(fitted: FittedForm) -> ErrorsOfValues | None:
    """Compile half the width of a Gaussian process's band; None for other forms."""
    process = fitted.process
    if process is None:
        return None

    def evaluate(columns: Sequence[ColumnValues], values: ColumnValues) -> Any:
        points = np.stack(np.broadcast_arrays(*columns), axis=-1)
        coded = code(points, fitted.center, fitted.half_range, fitted.log_factors)
        errors = process.band * process.deviations(coded)
        errors = np.expm1(errors) if fitted.logarithmic else errors / np.abs(values)
        return errors if errors.ndim else errors.item()

    return evaluate


@dataclass(frozen=True)
class _HornerNode:
    """Node of a Horner scheme: constant + sum of z_i times child i."""

    constant: float
    children: Mapping[int, "_HornerNode"]


def _horner_tree(coefficients: Mapping[Term, float]) -> _HornerNode:
    """Build a Horner scheme: terms grouped by their first column, and so on within each group."""
    inner: dict[int, dict[Term, float]] = {}
    for term, coefficient in coefficients.items():
        if term:
            inner.setdefault(term[0], {})[term[1:]] = coefficient
    return _HornerNode(
        coefficients.get((), 0.0), {number: _horner_tree(inner[number]) for number in sorted(inner)}
    )


def _closure(nest: _HornerNode) -> Callable[[Sequence[ColumnValues]], ColumnValues]:
    constant = nest.constant
    leaves = tuple((i, n.constant) for i, n in nest.children.items() if not n.children)
    branches = tuple((i, _closure(n)) for i, n in nest.children.items() if n.children)

    def evaluate(coded: Sequence[ColumnValues]) -> ColumnValues:
        total = constant
        for number, coefficient in leaves:
            total = total + coefficient * coded[number]
        for number, inner in branches:
            total = total + coded[number] * inner(coded)
        return total

    return evaluate


def pieces(
    columns: Mapping[str, ColumnValues], shape: tuple[int, ...]
) -> Iterator[tuple[int, dict[str, ColumnValues]]]:
    """Cut columns that are broadcast to one shape into pieces of `PIECE` places.

    Yields the place of the piece in C order, and name to a float or a one-dimensional array.
    """
    flat: dict[str, ColumnValues] = {}
    for name, column in columns.items():
        array = np.asarray(column)
        flat[name] = array.item() if array.size == 1 else np.broadcast_to(array, shape).reshape(-1)
    for start in range(0, math.prod(shape), PIECE):
        yield (
            start,
            {
                name: column[start : start + PIECE] if isinstance(column, np.ndarray) else column
                for name, column in flat.items()
            },
        )


# Ratios that did not vary in a study agree with it within this (of 1, or of the ratio if larger): a
# throw scaled by hand is rounded, and so small a part changes no compliance noticeably.
AGREES = 1e-5

Reader = Callable[[Mapping[str, Given]], Any]
# The throw's size among the known dimensions; no name has a space.
_SIZE = "its size"


@dataclass(frozen=True)
class Column:
    """One column of an equation: its name, its function of dimensions, its range and unit."""

    name: str
    read: Reader
    lowest: float
    highest: float
    unit: str


@dataclass(frozen=True)
class Ratio:
    """A ratio that did not vary in the study: its dimensions, and its value there."""

    name: str
    names: tuple[str, ...]
    read: Reader
    value: float

    def check(self, values: Any) -> None:
        """Refuse values other than that of the study (`InputError`)."""
        margin, (least, most) = AGREES * max(1.0, abs(self.value)), smallest_and_largest(values)
        if self.value - margin <= least and most <= self.value + margin:
            return
        differences = np.atleast_1d(np.abs(values - self.value))
        worst_ratio = float(np.atleast_1d(values)[int(np.argmax(differences))])
        share = f", {100.0 * (worst_ratio / self.value - 1.0):+.3g} %" if self.value else ""
        raise InputError(
            f"{self.name}: given {worst_ratio:.6g}{share}; allowed is {self.value:.6g}, because this "
            "ratio did not vary in the study, so the equation does not contain its effect."
        )


@dataclass(frozen=True)
class ResponseValues:
    """Values of a response, the findings outside the study, and where everything is inside it.

    `errors` calculates the relative error of each value by a Gaussian process.
    """

    values: Any
    outside: tuple[Finding, ...]
    inside: Any
    errors: Callable[[], Any] | None = None


@dataclass(frozen=True, eq=False)
class ResponseQuery:
    """Evaluation of one response from dimensions.

    Attributes
    ----------
    ratios : tuple of Ratio
        Ratios that must agree with the study; empty for an equation in the factors themselves.
    needed : tuple of str
        Required names.
    scale : callable or None
        Factor on the equation's value, from the dimensions.
    constraints : tuple of StudyConstraint
        Relations of the study, between the lengths of a throw of its size.
    errors : callable, optional
        From columns and values to the relative errors of these.
    """

    name: str
    family: Family
    columns: tuple[Column, ...]
    ratios: tuple[Ratio, ...]
    needed: tuple[str, ...]
    equation: Equation
    scale: Reader | None
    constraints: tuple[StudyConstraint, ...] = ()
    errors: ErrorsOfValues | None = None

    @cached_property
    def lower_limit(self) -> float:
        """Lower limit of the response: 0 by nature, or none."""
        return 0.0 if is_positive_response(self.name) else -math.inf

    def evaluate(self, query: Mapping[str, Given]) -> ResponseValues:
        """Evaluate any query of dimensions and labels, numbers or arrays that can be broadcast together.

        Raises
        ------
        InputError
            If something is missing, unknown or unusable, a fixed dimension or ratio differs from
            the study, or the equation has no finite or a physically impossible value.
        """
        known, shape = self._used(query)
        findings: list[Finding] = []
        values: Any
        if shape == ():
            least, inside = self._piece(known, math, findings)
            values, finite = least, math.isfinite(least)
        else:
            values, inside = np.empty(shape), np.ones(shape, dtype=bool)
            flat, flat_inside = values.reshape(-1), inside.reshape(-1)
            with np.errstate(all="ignore"):
                for start, piece in pieces(known, shape):
                    place = slice(start, start + PIECE)
                    flat[place], flat_inside[place] = self._piece(piece, np, findings)
            least, finite = float(np.min(values)), bool(np.isfinite(values).all())
        outside = tuple(worst(findings))
        for finding in outside:
            finding.check_distance()
        if not finite:
            beyond = "far outside the range of the fit" if findings else "small or large"
            raise InputError(
                f"dimensions: given ones so {beyond} that its equation has no finite value; allowed are "
                "those near the range, because beyond it the equation is meaningless."
            )
        if not least > self.lower_limit:
            raise InputError(
                f"{self.name}: given {least:g}; allowed is a number above zero, as every throw has it: an "
                "equation that gives another one does not hold for these dimensions."
            )
        errors = None
        if self.errors is not None:
            errors = partial(self.errors, [column.read(known) for column in self.columns], values)
        return ResponseValues(values, outside, inside, errors)

    def slopes(self, query: Mapping[str, Given]) -> dict[str, Any]:
        """Derivatives by each factor given, at a query that `evaluate` accepts [SI].

        The equation is evaluated in complex numbers with an imaginary part far below rounding: its
        imaginary part is the derivative without a difference, as the real part does not change
        (Squire and Trapp, SIAM Review 40, 1998). What follows from a factor by relations follows it.
        """
        checked, shape = self._used(query)
        family = self.family
        names = [name for name in family.ranges if name in query]
        steps = _STEPS.reshape(2, *(1 for _ in shape))
        moved: dict[str, Given] = {
            name: value for name, value in checked.items() if name not in family.relations
        }
        for place, name in enumerate(names):
            step = np.zeros((2, len(names), *(1 for _ in shape)), dtype=np.complex128)
            step[:, place] = 1j * steps
            moved[name] = checked[name] + step
        known = family.completed(moved, checked[_SIZE])
        missing = [name for name in self.needed if name not in known]
        if missing:
            raise InputError(
                f"{missing[0]}: given without the factors that it follows from; allowed are the model's "
                f"factors {', '.join(family.factors)}, because slopes are by these."
            )
        values = self.equation([column.read(known) for column in self.columns], np)
        if self.scale is not None:
            values = values * self.scale(known)
        parts = np.broadcast_to(np.imag(values), (2, len(names), *shape))
        rows, again = parts / steps[:, None]
        for name, row, other in zip(names, rows, again, strict=True):
            if not np.allclose(row, other, rtol=1e-9, atol=0.0):
                raise InputError(
                    f"{name}: given a value at which {self.name} has no slope; allowed are others, because a "
                    "relation of this model takes the root of zero there."
                )
        return {
            name: row.copy() if shape else float(row) for name, row in zip(names, rows, strict=True)
        }

    @cached_property
    def _ranges(self) -> dict[str, tuple[float, float, str]]:
        """Range and unit of each varying number: all forms of a study share those of its factors."""
        if self.scale is None:
            numbers = [column for column in self.columns if IS not in column.name]
            return {part.name: (part.lowest, part.highest, part.unit) for part in numbers}
        family = self.family
        return {name: (*ends, family.unit(name)) for name, ends in family.ranges.items()}

    def _used(self, query: Mapping[str, Given]) -> tuple[dict[str, Given], tuple[int, ...]]:
        """Check and complete the query, with the throw's size; also return its shape."""
        family = self.family
        checked = family.checked(query)
        shape = _common_shape(checked)
        size: Any = 1.0
        if self.scale is None:
            family.check_fixed(checked)
        else:
            size = family.size(checked)
            least, most = smallest_and_largest(size)
            if least * FARTHEST < 1.0 or most > FARTHEST:
                hint = " (mm given in place of m?)" if most > FARTHEST else ""
                raise InputError(
                    f"dimensions: given a throw {most if hint else least:.3g} times as large as those of "
                    f"the study; allowed is up to {FARTHEST:g} times as large or as small, because no crank "
                    f"is of such a size{hint}."
                )
        family.check_related(checked, size)
        if not self._names <= checked.keys():
            known = family.completed(checked, size)
            missing = [name for name in self.needed if name not in known]
            if missing:
                raise InputError(
                    f"{missing[0]}: missing; the model needs its factors {', '.join(family.factors)}."
                )
            checked |= {name: known[name] for name in self.needed}
        checked[_SIZE] = size
        return checked, shape

    @cached_property
    def _names(self) -> frozenset[str]:
        return frozenset(self.needed)

    def _piece(
        self, known: Mapping[str, Given], library: Any, findings: list[Finding]
    ) -> tuple[Any, Any]:
        """Evaluate one piece by numpy, or one point by math; `findings` gets the values outside."""
        for ratio in self.ratios:
            ratio.check(ratio.read(known))
        columns = [column.read(known) for column in self.columns]
        inside: Any = True
        for finding, where in self._outside(known, columns):
            findings.append(finding)
            inside = inside & np.logical_not(where)
        try:
            value = self.equation(columns, library)
            return (value if self.scale is None else value * self.scale(known)), inside
        except (ArithmeticError, ValueError):
            return math.nan, inside  # told of by the caller

    def _outside(
        self, known: Mapping[str, Given], columns: Sequence[Given]
    ) -> Iterator[tuple[Finding, Any]]:
        """Find the values outside the study, and where."""
        size = known[_SIZE]
        if self._ranges and self._ranges.keys() <= known.keys():
            asked = [
                (name, known[name], *ends, size if ends[2] == "m" and self.scale else 1.0)
                for name, ends in self._ranges.items()
            ]
        else:  # factors that are not given: the equation's own columns are what is known
            asked = [
                (column.name, values, column.lowest, column.highest, column.unit, 1.0)
                for column, values in zip(self.columns, columns, strict=True)
            ]
        for values in asked:
            if (beyond := find_out_of_range(*values)) is not None:
                yield beyond
        for constraint in self.constraints:
            at_study_size = {
                name: known[name] / size if constraint.units[name] == "m" else known[name]
                for name in constraint.read.names
            }
            if (broken := constraint.find_broken(at_study_size)) is not None:
                yield broken


def _common_shape(values: Mapping[str, Any]) -> tuple[int, ...]:
    if all(value.__class__ in (float, str) for value in values.values()):
        return ()
    try:
        return np.broadcast_shapes(*(np.shape(value) for value in values.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {np.shape(value)}" for name, value in values.items())
        raise InputError(
            f"dimensions: given arrays of the shapes {shapes}; allowed are shapes that can be "
            "broadcast together, one value or equally many of each."
        ) from None


def make_response_query(
    name: str,
    response: ResponseModel,
    family: Family,
    material: Mapping[str, Any],
    constant_groups: Mapping[str, float],
    constraints: tuple[StudyConstraint, ...] = (),
) -> ResponseQuery:
    """Prepare a response for queries.

    An equation in dimensionless groups needs the constants of the study's material; `constant_groups`
    did not vary in the study, besides those that follow from its fixed dimensions. `InputError` if a
    column is not one of the family's, or the constants are missing.
    """
    readers = [_column_source(name, response.basis, family) for name in response.factors]
    columns = tuple(
        Column(name, read, low, high, unit)
        for name, (read, _, unit), low, high in zip(
            response.factors, readers, response.lowest, response.highest, strict=True
        )
    )
    needed = dict.fromkeys(name for _, names, _ in readers for name in names)
    needed |= dict.fromkeys(name for constraint in constraints for name in constraint.read.names)
    equation = compile_equation(response)
    if response.basis == "factors":
        errors = compile_errors(response)
        return ResponseQuery(
            name, family, columns, (), tuple(needed), equation, None, constraints, errors
        )
    ratios, names = _ratios(family, constant_groups)
    needed |= dict.fromkeys(("pin_diameter", *names))
    scale = partial(response_scale, response.unit, material=study_material(material))
    scale({"pin_diameter": 1.0})  # refuses a unit that has no scale
    return ResponseQuery(name, family, columns, ratios, tuple(needed), equation, scale, constraints)


def study_material(constants: Mapping[str, Any]) -> Material:
    """Return the material of a model's runs; `InputError` if the model does not state its constants."""
    try:
        return Material(**constants)
    except InputError as error:
        raise InputError(
            f"material: given {dict(constants)}; allowed are the constants of the model's runs, because an "
            f"equation in dimensionless groups, or for another material, needs them ({error})"
        ) from None


def _column_source(name: str, basis: str, family: Family) -> tuple[Reader, tuple[str, ...], str]:
    """Function, requirements and unit of a column."""
    field, is_label, label = name.partition(IS)
    if is_label:
        if label not in family.categories.get(field, ()):
            raise InputError(
                f"factors: given {name}, which is no label of a category of the model; allowed are "
                f"those of {', '.join(family.categories) or 'no category'}."
            )
        return (lambda known: (known[field] == label) * 1.0), (field,), ""
    if basis == "groups":
        group = group_named(name)
        return group.value, group.dimensions, ""
    return itemgetter(name), (name,), family.unit(name)


def _ratios(
    family: Family, constant_groups: Mapping[str, float]
) -> tuple[tuple[Ratio, ...], tuple[str, ...]]:
    """Ratios that must agree with the study so that a throw of another size is of its family."""
    fixed = family.fixed
    groups = [group for group in GROUPS.values() if set(group.dimensions) <= fixed.keys()]
    fixed_ratios = {
        group.name: Ratio(group.name, group.dimensions, group.value, group.value(fixed))
        for group in groups
    }
    for name, value in constant_groups.items():
        group = group_named(name)
        groups.append(group)
        fixed_ratios.setdefault(name, Ratio(name, group.dimensions, group.value, value))
    names = [name for group in groups for name in group.dimensions]
    covered = {name for name in names if fixed.get(name)}
    reference = (
        "pin_diameter"
        if "pin_diameter" in fixed
        else next(
            (name for name, value in fixed.items() if value and family.unit(name) == "m"), None
        )
    )
    for name, value in fixed.items():
        if name in covered or name == reference or name in names:
            continue
        if family.unit(name) != "m" or reference is None:
            fixed_ratios[name] = Ratio(name, (name,), itemgetter(name), value)
        else:
            below = fixed[reference]
            read = _ratio_reader(name, reference)
            shown = "D_shm" if reference == "pin_diameter" else reference
            ratio = Ratio(f"{name}/{shown}", (name, reference), read, value / below)
            fixed_ratios[ratio.name] = ratio
            names += [name, reference]
    return tuple(fixed_ratios.values()), tuple(dict.fromkeys((*names, *fixed)))


def _ratio_reader(above: str, below: str) -> Reader:
    return lambda known: known[above] / known[below]
