"""Factors of a study: fields of a throw, ratios and choices, each over a range or at levels."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

import numpy as np

from crankbase.choices import check_choice, did_you_mean, is_number, whole_within
from crankbase.errors import InputError, quoted
from crankbase.model import InputModel, field_extra, part_kind
from crankbase.sentences import amount, finished, joined, kept
from crankbase.summaries import frozen
from geometry.throw import CrankThrow

SPACINGS = ("even", "log", "chebyshev", "log chebyshev")
FREE_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
# Digits to which calculated values are rounded: 285 mm found by halving and 285 mm written in a file
# shall be one design, whose result is then found in the store.
DIGITS = 12


@frozen("name", "lowest", "highest", "unit")
class Factor:
    """A factor of a study.

    Parameters
    ----------
    name : str
        A field of the throw ("web_width", "counterweight.thickness"), or a free name used in
        relations.
    unit : str
        SI unit; "" for a pure number or a choice.
    lowest, highest : float
        Ends of the range [SI]; of a choice 0 and the last label's index.
    levels : tuple of float, optional
        The values of a factorial, ascending or not [SI]; None for a range.
    labels : tuple of str
        Labels of a choice, whose values are the labels' indices. Empty for numbers.

    Raises
    ------
    InputError
        If the range is empty or not finite, a level occurs twice or is outside, or there are fewer
        than two levels or labels.
    """

    name: str
    unit: str
    lowest: float
    highest: float
    levels: tuple[float, ...] | None = None
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        name = f"study.factors.{self.name}"
        numbers = (self.lowest, self.highest, *(self.levels or ()))
        if not all(is_number(value) for value in numbers):
            raise InputError(f"{name}: given {quoted(numbers)}; allowed are finite numbers.")
        if self.labels and (
            len(set(self.labels)) != len(self.labels)
            or self.levels != tuple(map(float, range(len(self.labels))))
        ):
            raise InputError(
                f"{name}: given {', '.join(self.labels)}; allowed is each choice once, because "
                "repeated finite element runs give the same result."
            )
        if self.levels is not None:
            self._check_levels(name, self.levels)
        if not self.lowest < self.highest:
            raise InputError(
                f"{name}: given the range {kept(self.range_text)}; the "
                "lowest value must lie below the highest, or the factor does not vary."
            )

    def _check_levels(self, name: str, levels: tuple[float, ...]) -> None:
        number = len(set(levels))
        if number < 2:
            raise InputError(
                f"{name}: given {number} level; allowed are two or more different ones, three for a "
                "quadratic equation."
            )
        if number != len(levels):
            raise InputError(
                f"{name}: given {joined(', ', map(self.format_value, levels))}; each level is allowed once, "
                "because repeated finite element runs give the same result."
            )
        if min(levels) < self.lowest or max(levels) > self.highest:
            raise InputError(
                f"{name}: given levels {joined(', ', map(self.format_value, levels))}; allowed "
                f"are levels within the range {kept(self.range_text)}."
            )

    @classmethod
    def of_levels(cls, name: str, unit: str, levels: Sequence[float]) -> "Factor":
        """Make a factor with the given levels, and the range between the outermost."""
        values = tuple(float(value) for value in levels)
        if not values:
            raise InputError(f"study.factors.{name}: given no level; allowed are two or more.")
        return cls(name, unit, min(values), max(values), values)

    @classmethod
    def of_labels(cls, name: str, labels: Sequence[str]) -> "Factor":
        """Make a choice between labels."""
        if len(labels) < 2:
            raise InputError(
                f"study.factors.{name}: given {', '.join(labels) or 'nothing'}; allowed are two or "
                "more different choices, or the factor does not vary."
            )
        levels = tuple(float(index) for index in range(len(labels)))
        return cls(name, "", 0.0, levels[-1], levels, tuple(labels))

    @classmethod
    def spread(
        cls, name: str, unit: str, lowest: float, highest: float, levels: int, spacing: str
    ) -> "Factor":
        """Make a factor with 2 or more levels spread over a range, both ends among them.

        Spacing "even"; "log" (even in the logarithm); "chebyshev" (the extremes of a Chebyshev
        polynomial, denser at the ends, which keeps the error of a polynomial even over the range); "log
        chebyshev" (those in the logarithm). `InputError` if it is unknown, or is logarithmic over a
        range that reaches zero.
        """
        field = f"study.factors.{name}"
        check_choice(f"{field}.spacing", spacing, SPACINGS, "these are the ways to spread levels")
        whole_within(f"{field}.levels", levels, 2, 1000, "a factor varies over a few")
        plain = cls(name, unit, lowest, highest)  # refuses an empty range
        logarithmic = spacing.startswith("log")
        if logarithmic and lowest <= 0.0:
            raise InputError(
                f"{field}.from: given {kept(plain.format_value(lowest))}; allowed is more than 0 with "
                f"spacing {spacing!r}, because zero has no logarithm."
            )
        ends = np.log([lowest, highest]) if logarithmic else np.array([lowest, highest])
        place = np.linspace(0.0, 1.0, levels)
        if "chebyshev" in spacing:
            place = 0.5 - 0.5 * np.cos(np.pi * place)
        inner = ends[0] + place * (ends[1] - ends[0])
        values = np.exp(inner) if logarithmic else inner
        return cls(
            name, unit, lowest, highest, (lowest, *map(rounded, values[1:-1].tolist()), highest)
        )

    @property
    def range_text(self) -> str:
        """Range in the field's usual unit; of a choice its labels."""
        ends = map(self.format_value, (self.lowest, self.highest))
        return ", ".join(self.labels) or finished(joined(" to ", ends))

    def setting(self, value: float) -> float | str:
        """Return one of the factor's values as people give it: of a choice its label."""
        return self.labels[round(value)] if self.labels else value

    def format_value(self, value: float) -> str:
        """Format one of the factor's values for display."""
        return self.labels[round(value)] if self.labels else finished(amount(value, self.unit))


def rounded(value: float) -> float:
    """Round a calculated value to `DIGITS` significant digits."""
    return float(f"{value:.{DIGITS - 1}e}")


@dataclass(frozen=True)
class ThrowField:
    """A field of a throw that a study can vary: a quantity with its unit, or a choice."""

    path: str
    unit: str
    choices: tuple[str, ...] = ()


def throw_fields(throw: CrankThrow) -> dict[str, ThrowField]:
    """List the fields that can vary, by path ("web_width", "further_pins.0.length").

    Fields of a part that the throw lacks are left out, unless the part has no required field
    (a web of its own).
    """
    return {field.path: field for field in _fields_of(throw, CrankThrow, "")}


def _fields_of(
    record: InputModel | None, kind: type[InputModel], prefix: str
) -> Iterator[ThrowField]:
    for name, info in kind.model_fields.items():
        path, part = prefix + name, part_kind(info)
        value = None if record is None else getattr(record, name)
        if part is not None and field_extra(info, "many"):
            for place, item in enumerate(value or ()):
                yield from _fields_of(item, part, f"{path}.{place}.")
        elif part is not None:
            required = any(entry.is_required() for entry in part.model_fields.values())
            if value is not None or not required:
                yield from _fields_of(value, part, f"{path}.")
        elif field_extra(info, "unit") is not None:
            yield ThrowField(path, field_extra(info, "unit"))
        elif choices := _choices(info.annotation):
            yield ThrowField(path, "", choices)


def _choices(annotation: Any) -> tuple[str, ...]:
    """Labels of a Literal, also within an optional one."""
    if get_origin(annotation) is Literal:
        return get_args(annotation)
    return next((labels for item in get_args(annotation) if (labels := _choices(item))), ())


def field_value(record: Mapping[str, Any], path: str) -> Any:
    """Return the value at a path of a throw's record, None where the part is missing."""
    part: Any = record
    for step in path.split("."):
        if part is None:
            return None
        part = part[int(step)] if isinstance(part, list) else part.get(step)
    return part


def unknown_field(path: str, fields: Mapping[str, ThrowField], throw: CrankThrow) -> str:
    """State why a name is not a field of this throw, and suggest similar ones."""
    steps = path.split(".")
    for count in range(1, len(steps)):
        part = ".".join(steps[:count])
        if part.split(".")[0] not in CrankThrow.model_fields:
            break
        if not any(name.startswith(f"{part}.") for name in fields):
            return f"the throw has no {part} to vary; give it in [throw]"
    offered = [name for name in fields if "." not in name or getattr(throw, name.split(".")[0])]
    return f"{did_you_mean(path, fields)}allowed are {', '.join(offered)}"
