"""Values outside the range of an equation's fit: their distance, and the sentences on them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from crankbase.errors import InputError
from regression.throw_values import SAME, format_value

# So many times as large as the range's end, or as small, or so many widths beyond it, an equation
# says nothing; most likely the unit is another: 70 for 0.070 m.
FARTHEST = 100.0


class OutsideRangeWarning(UserWarning):
    """A compliance outside the range of dimensions of its fit."""


@dataclass(frozen=True)
class OutOfRange:
    """One column whose values are out of its range.

    Attributes
    ----------
    name : str
        Of the dimension or the ratio.
    value : float
        The farthest value [SI].
    number : int
        Number of values outside.
    lowest, highest : float
        The range.
    unit : str
        SI unit.
    alone : bool
        Whether this is a single number, not multiplied by arrays.
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
        """Refuse a value so far outside that an equation is meaningless.

        Raises
        ------
        InputError
        """
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
    """Find the values outside a range.

    Parameters
    ----------
    name, lowest, highest, unit
        As in `OutOfRange`.
    values : float or ndarray
    size : float or ndarray
        Factor on the range: the size of the throw, for a length.

    Returns
    -------
    finding : OutOfRange
        With the farthest value, and the range at its size.
    outside : bool or ndarray
        Where the values are outside. The result is None if none is.
    """
    low, high = edges(lowest, highest)
    at_study = values / size
    if isinstance(at_study, float):
        if low <= at_study <= high:
            return None
        return OutOfRange(name, values, 1, lowest * size, highest * size, unit, alone=True), True
    if low <= np.min(at_study) and np.max(at_study) <= high:
        return None
    outside = (at_study < low) | (at_study > high)
    place = int(np.argmax(np.maximum(lowest - at_study, at_study - highest)))
    value, scale = (float(np.broadcast_to(one, outside.shape)[place]) for one in (values, size))
    number = int(np.count_nonzero(outside))
    return OutOfRange(name, value, number, lowest * scale, highest * scale, unit), outside
