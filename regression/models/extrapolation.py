"""Values outside the range that an equation was fitted over: how far, and what to say of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from regression.throw_values import SAME, format_value

# Lengths so many times as large as the range's end are most likely of another unit: 70 for 0.070 m.
WRONG_UNIT = 100.0


class OutsideRangeWarning(UserWarning):
    """A compliance was asked for outside the range of dimensions of its fit."""


@dataclass(frozen=True)
class OutOfRange:
    """One column whose values are out of its range.

    Attributes
    ----------
    name : str
        Of the dimension or the ratio.
    value : float
        The farthest of them [SI].
    number : int
        How many of the values lie outside.
    lowest, highest : float
        The range.
    unit : str
        SI unit.
    alone : bool
        Whether this is one number, which arrays beside it do not multiply.
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
        """How far the farthest value lies beyond the range, as a share of the range's width."""
        beyond = max(self.lowest - self.value, self.value - self.highest)
        return beyond / (self.highest - self.lowest)

    @property
    def remark(self) -> str:
        """One sentence for a value that is given all the same."""
        return (
            f"{self._given}; the range of the fit is {self._range}, and "
            f"{100.0 * self.distance:.3g} % of its width beyond it the error is unknown{self.unit_hint}."
        )

    @property
    def error_sentence(self) -> str:
        """One sentence for a value that is not given."""
        return (
            f"{self._given}; allowed is the range of the fit, {self._range}, because an answer "
            f"{100.0 * self.distance:.3g} % of its width beyond it has no known error and strict "
            f"answers are asked for{self.unit_hint}."
        )

    @property
    def unit_hint(self) -> str:
        """A question where a length is so large that its unit is doubtful."""
        wrong = self.unit == "m" and self.value > WRONG_UNIT * self.highest
        return " (mm given in place of m?)" if wrong else ""

    @property
    def _given(self) -> str:
        several = f" (and {self.number - 1} more)" if self.number > 1 else ""
        return f"{self.name}: given {format_value(self.name, self.value, self.unit)}{several}"

    @property
    def _range(self) -> str:
        low, high = (format_value(self.name, v, self.unit) for v in (self.lowest, self.highest))
        return f"{low} to {high}"


def edges(lowest: float, highest: float) -> tuple[float, float]:
    """Return a range widened by rounding, so that its own ends lie inside."""
    margin = SAME * max(abs(lowest), abs(highest))
    return lowest - margin, highest + margin


def find_out_of_range(
    name: str, values: float | NDArray[np.float64], lowest: float, highest: float, unit: str
) -> OutOfRange | None:
    """Find what is out of a range; None if nothing is."""
    low, high = edges(lowest, highest)
    if isinstance(values, float):
        if low <= values <= high:
            return None
        return OutOfRange(name, values, 1, lowest, highest, unit, alone=True)
    least, most = float(np.min(values)), float(np.max(values))
    if low <= least and most <= high:
        return None
    number = int(np.count_nonzero((values < low) | (values > high)))
    farthest = least if lowest - least >= most - highest else most
    return OutOfRange(name, farthest, number, lowest, highest, unit)


def worst(found: list[OutOfRange]) -> list[OutOfRange]:
    """Join findings of pieces of one array: one for each name, with the farthest value."""
    joined: dict[str, OutOfRange] = {}
    for one in found:
        other = joined.get(one.name)
        if other is None:
            joined[one.name] = one
        if other is None or one.alone:  # each piece finds the same number
            continue
        far = one if one.distance > other.distance else other
        joined[one.name] = OutOfRange(
            one.name, far.value, one.number + other.number, one.lowest, one.highest, one.unit
        )
    return list(joined.values())
