"""One response of a compliance model, ready to be asked: names to columns, columns to a value.

A query of plain numbers inside the range has a fast evaluator: the checks and the evaluation are then
a few comparisons and multiplications. Everything else (arrays, what lies outside, what is wrong) goes
the long way, which says what is the matter.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from fem.material import Material
from regression.fits.groups import GROUPS, group_named
from regression.models.evaluator import PIECE, CompiledEquation, compile_equation, pieces
from regression.models.extrapolation import OutOfRange, edges, find_out_of_range, worst
from regression.models.family import Family, Given
from regression.models.response_model import IS, ResponseModel
from regression.response_kinds import is_positive_response, response_scale

# Ratios that did not vary in a study agree with it within this (of 1, or of the ratio if larger): a
# throw scaled by hand is rounded, and so small a part changes no compliance noticeably.
AGREES = 1e-5

Reader = Callable[[Mapping[str, Given]], Any]
# The plain numbers; a subclass of float counts too, but goes the long way.
_PLAIN = (float, int, np.float64)


@dataclass(frozen=True)
class Column:
    """One column of an equation: its name, how it is read from dimensions, its range and unit."""

    name: str
    read: Reader
    lowest: float
    highest: float
    unit: str


@dataclass(frozen=True)
class Ratio:
    """A ratio that did not vary in the study: what it is made of, and its value there."""

    name: str
    names: tuple[str, ...]
    read: Reader
    value: float


@dataclass(frozen=True)
class ResponseValues:
    """Values of a response, and what of the query lies outside the range."""

    values: Any
    outside: tuple[OutOfRange, ...]


@dataclass(frozen=True, eq=False)
class ResponseQuery:
    """How one response is found from dimensions.

    Attributes
    ----------
    name : str
        Of the response.
    family : Family
    columns : tuple of Column
    ratios : tuple of Ratio
        What must agree with the study; empty for an equation in the factors themselves.
    needed : tuple of str
        What must be known to answer.
    equation : CompiledEquation
    scale : callable or None
        What the equation's value is multiplied with, from the dimensions.
    """

    name: str
    family: Family
    columns: tuple[Column, ...]
    ratios: tuple[Ratio, ...]
    needed: tuple[str, ...]
    equation: CompiledEquation
    scale: Reader | None

    @property
    def lower_limit(self) -> float:
        """Lower limit that the response must exceed: 0 by nature, or none."""
        return 0.0 if is_positive_response(self.name) else -math.inf

    def fast_evaluator(self, names: Sequence[str]) -> Callable[[Mapping[str, Given]], float | None]:
        """Make the fast evaluator for queries that give just these names.

        Returns
        -------
        callable
            Dimensions to the value, or None where the long way must be gone.
        """
        family, given = self.family, set(names)
        complete = set(self.needed) <= given | family.fixed.keys() | family.labels.keys()
        known = given <= {*family.factors, *family.fixed}
        if not complete or not known or (self.scale is not None and family.relations):
            return _needs_full_evaluation
        numbers = tuple(name for name in names if name not in family.categories)
        labels = tuple((n, family.categories[n]) for n in names if n in family.categories)
        limits = tuple((c.read, *edges(c.lowest, c.highest)) for c in self.columns)
        ratios: tuple[tuple[Reader, float, float], ...] = ()
        if self.scale is not None:
            ratios = tuple(
                (ratio.read, *_agreeing(ratio.value))
                for ratio in self.ratios
                if given & set(ratio.names)
            )
        elif given & family.fixed.keys():
            fixed = ((name, family.fixed[name]) for name in names if name in family.fixed)
            ratios = tuple((itemgetter(name), *edges(value, value)) for name, value in fixed)
        value, scale, least = self.equation.scalar, self.scale, self.lower_limit
        rest = {**family.fixed, **family.labels} if scale is not None else {}

        def answer(dimensions: Mapping[str, Given]) -> float | None:
            for name in numbers:
                given = dimensions[name]
                if given.__class__ not in _PLAIN or (scale is not None and not given > 0.0):
                    return None
            for name, allowed in labels:
                if dimensions[name].__class__ is not str or dimensions[name] not in allowed:
                    return None
            if rest:
                dimensions = {**rest, **dimensions}
            for read, low, high in ratios:
                if not low <= read(dimensions) <= high:
                    return None
            columns = []
            for read, low, high in limits:
                column = read(dimensions)
                if not low <= column <= high:
                    return None
                columns.append(column)
            try:
                found = value(columns) if scale is None else value(columns) * scale(dimensions)
            except ArithmeticError:
                return None
            return found if least < found < math.inf else None

        return answer

    def evaluate(self, given: Mapping[str, Given]) -> ResponseValues:
        """Evaluate any query, or say what is wrong with it.

        Parameters
        ----------
        given : mapping
            Dimensions and labels, numbers or arrays that can be broadcast together.

        Raises
        ------
        InputError
            If something is missing, unknown or unusable, a fixed dimension or ratio is another than
            in the study, or the equation has no finite value there, or one that no throw has.
        """
        used, shape = self._used(given)
        found: list[OutOfRange] = []
        values: Any
        if shape == ():
            values = self._piece(used, self.equation.scalar, found)
        else:
            values = np.empty(shape)
            flat = values.reshape(-1)
            for start, piece in pieces(used, shape):
                flat[start : start + PIECE] = self._piece(piece, self.equation.array, found)
        hint = next((one.unit_hint for one in found if one.unit_hint), "")
        if not np.all(np.isfinite(values)):
            beyond = "far outside the range of the fit" if found else "small or large"
            raise InputError(
                f"dimensions: given ones so {beyond} that its equation has no finite value; allowed are "
                f"those near the range, for beyond it the equation says nothing{hint}."
            )
        if not np.min(values) > self.lower_limit:
            raise InputError(
                f"{self.name}: given {float(np.min(values)):g}; allowed is a number above zero, as every "
                "throw has it: an equation that gives another one does not hold for these "
                f"dimensions{hint}."
            )
        return ResponseValues(values, tuple(worst(found)))

    def places(self, given: Mapping[str, Given]) -> NDArray[np.float64]:
        """Places of points in the ranges of the columns, -1 to 1 inside; (columns, n)."""
        used, shape = self._used(given)
        rows = [
            (2.0 * column.read(used) - column.lowest - column.highest)
            / (column.highest - column.lowest)
            for column in self.columns
        ]
        return np.array([np.broadcast_to(row, shape) for row in rows])

    def _used(self, given: Mapping[str, Given]) -> tuple[dict[str, Given], tuple[int, ...]]:
        """Check and complete what was given, to what the answer depends on; return its shape too."""
        family = self.family
        checked = family.checked(given)
        shape = _common_shape(checked)
        size: Any = 1.0
        if self.scale is None:
            family.check_fixed(checked)
        else:
            size = family.size(checked)
        family.check_related(checked, size)
        missing = self._missing(checked)
        known = family.completed(checked, size) if missing else checked
        missing = self._missing(known)
        if missing:
            raise InputError(
                f"{missing[0]}: missing; the model needs its factors {', '.join(family.factors)}."
            )
        return {name: known[name] for name in dict.fromkeys((*self.needed, *checked))}, shape

    def _missing(self, known: Mapping[str, Given]) -> list[str]:
        return [name for name in self.needed if name not in known]

    def _piece(
        self,
        known: Mapping[str, Given],
        evaluate: Callable[[Sequence[Any]], Any],
        found: list[OutOfRange],
    ) -> Any:
        """Evaluate one piece (or one point), and collect what lies outside."""
        for ratio in self.ratios:
            _check_ratio(ratio, ratio.read(known))
        columns = [column.read(known) for column in self.columns]
        for column, values in zip(self.columns, columns, strict=True):
            beyond = find_out_of_range(
                column.name, values, column.lowest, column.highest, column.unit
            )
            if beyond is not None:
                found.append(beyond)
        try:
            with np.errstate(all="ignore"):
                value = evaluate(columns)
                return value if self.scale is None else value * self.scale(known)
        except (ArithmeticError, ValueError):
            return np.nan  # told of by the caller


def _needs_full_evaluation(_: Mapping[str, Given]) -> None:
    """Return nothing: the full evaluation is needed."""


def make_response_query(
    name: str,
    response: ResponseModel,
    family: Family,
    material: Mapping[str, Any],
    constant_groups: Mapping[str, float],
) -> ResponseQuery:
    """Prepare a response for queries.

    Parameters
    ----------
    name : str
        Of the response; it says whether its values are above zero.
    response : ResponseModel
    family : Family
    material : mapping
        Of the study; an equation in dimensionless groups needs its constants.
    constant_groups : mapping
        Groups that did not vary in the study, besides those that follow from its fixed dimensions.

    Raises
    ------
    InputError
        If a column is none of the family's, or the material's constants are missing.
    """
    readers = [_column_source(name, response.basis, family) for name in response.factors]
    columns = tuple(
        Column(name, read, low, high, unit)
        for name, (read, _, unit), low, high in zip(
            response.factors, readers, response.lowest, response.highest, strict=True
        )
    )
    needed = dict.fromkeys(name for _, names, _ in readers for name in names)
    equation = compile_equation(response.fitted)
    if response.basis == "factors":
        return ResponseQuery(name, family, columns, (), tuple(needed), equation, None)
    ratios, names = _ratios(family, constant_groups)
    needed |= dict.fromkeys(("pin_diameter", *names))
    try:
        constants = Material(**material)
    except InputError as error:
        raise InputError(
            f"material: given {dict(material)}; an equation in dimensionless groups needs its "
            f"constants ({error})"
        ) from None
    scale = partial(response_scale, response.unit, material=constants)
    scale({"pin_diameter": 1.0})  # refuses a unit that has no scale
    return ResponseQuery(name, family, columns, ratios, tuple(needed), equation, scale)


def _column_source(name: str, basis: str, family: Family) -> tuple[Reader, tuple[str, ...], str]:
    """How a column is read, what it needs, and its unit."""
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
    """What must agree with the study so that a throw of another size is one of its family."""
    fixed = family.fixed
    groups = [group for group in GROUPS.values() if set(group.dimensions) <= fixed.keys()]
    found = {
        group.name: Ratio(group.name, group.dimensions, group.value, group.value(fixed))
        for group in groups
    }
    for name, value in constant_groups.items():
        group = group_named(name)
        groups.append(group)
        found.setdefault(name, Ratio(name, group.dimensions, group.value, value))
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
            found[name] = Ratio(name, (name,), itemgetter(name), value)
        else:
            below = fixed[reference]
            read = _ratio_reader(name, reference)
            shown = "D_shm" if reference == "pin_diameter" else reference
            ratio = Ratio(f"{name}/{shown}", (name, reference), read, value / below)
            found[ratio.name] = ratio
            names += [name, reference]
    return tuple(found.values()), tuple(dict.fromkeys((*names, *fixed)))


def _ratio_reader(above: str, below: str) -> Reader:
    return lambda known: known[above] / known[below]


def _agreeing(value: float) -> tuple[float, float]:
    margin = AGREES * max(1.0, abs(value))
    return value - margin, value + margin


def _check_ratio(ratio: Ratio, values: Any) -> None:
    low, high = _agreeing(ratio.value)
    if np.all((low <= values) & (values <= high)):
        return
    differences = np.atleast_1d(np.abs(values - ratio.value))
    given = float(np.atleast_1d(values)[int(np.argmax(differences))])
    share = f", {100.0 * (given / ratio.value - 1.0):+.3g} %" if ratio.value else ""
    raise InputError(
        f"{ratio.name}: given {given:.6g}{share}; allowed is {ratio.value:.6g}, because this ratio did "
        "not vary in the study, so that the equation does not know what it does."
    )


def _common_shape(values: Mapping[str, Any]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(*(np.shape(value) for value in values.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {np.shape(value)}" for name, value in values.items())
        raise InputError(
            f"dimensions: given arrays of the shapes {shapes}; allowed are shapes that can be "
            "broadcast together, one value or equally many of each."
        ) from None
