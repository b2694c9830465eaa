"""Comparison of one quantity in normal firing and while cylinders misfire."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from crankbase.tables.frames import Row
from crankbase.units.number_formats import format_usage
from crankbase.units.quantity import format_quantity
from dynamics.assessment.largest_amplitude import largest_amplitude
from dynamics.assessment.limit_sentences import limit_at, use_in_words
from dynamics.assessment.limits import VibrationLimit
from dynamics.response.series import OrderSeries

DIGITS = 3
# Numbers of cylinders that fail together, from 1.
Cylinders = tuple[int, ...]


@summarized("place", "speed [rad/s]", "value", "permitted", "used")
@dataclass(frozen=True)
class Reached:
    """The worst of a quantity at running speeds.

    Attributes
    ----------
    place : str
        Node or element.
    speed : float
        [rad/s].
    value : float
        Amplitude, all orders together, in the quantity's unit; inf where unbounded.
    permitted : float
        At this speed; inf where no limit is stated.
    """

    place: str
    speed: float
    value: float
    permitted: float

    @property
    def used(self) -> float:
        """Share of the permitted amplitude; 0 where no limit is stated."""
        return 0.0 if np.isinf(self.permitted) else self.value / self.permitted

    @property
    def severity(self) -> tuple[float, float]:
        """Measure for the comparison of cases: the used share, and without a limit the value."""
        return self.used, self.value


@summarized("quantity", "unit", "normal", "cylinders", "misfiring")
@dataclass(frozen=True, eq=False)
class FiringCheck:
    """One quantity in normal firing, and in the worst case of misfiring.

    Attributes
    ----------
    quantity : str
        For example "torsional stress of crankshaft".
    unit : str
        SI unit of the values.
    limit : VibrationLimit or None
    normal : Reached
        With all cylinders firing, compared with the limit for continuous running.
    cylinders : tuple of int
        Failing cylinders in the worst case.
    misfiring : Reached
        In the worst case, compared with the limit while misfiring, `VibrationLimit.misfiring`.
    each : dict
        Cylinders whose failing is then worst.
    over_speed : tuple of three (S,) arrays, or None
        Running speeds [rad/s], and at the place of `misfiring` the amplitude with all cylinders firing
        and in the worst case; of the stress that uses its limit most alone.
    """

    quantity: str
    unit: str
    limit: VibrationLimit | None
    normal: Reached
    cylinders: Cylinders
    misfiring: Reached
    each: Mapping[Cylinders, Reached]
    over_speed: tuple[FloatArray, FloatArray, FloatArray] | None = None

    @property
    def passed(self) -> bool:
        """Whether the limit while misfiring is kept at running speeds."""
        return self.misfiring.used <= 1.0

    @property
    def sentence(self) -> str:
        """The finding while misfiring, with normal firing for comparison."""
        own, normal, limit = self.misfiring, self.normal, self.limit
        if limit is None or np.isinf(own.permitted):
            found = f"at most {self._amount(own)}"
        else:
            found = use_in_words(limit, own.speed, own.value, own.permitted, DIGITS)
        elsewhere = "" if normal.place == own.place else f", {normal.place}"
        return (
            f"With {named(self.cylinders)} misfiring, {limit_at(self.quantity, own.place)}: {found}; with "
            f"all cylinders firing {self._amount(normal)}{self._share(normal)}{elsewhere}."
        )

    def _share(self, found: Reached) -> str:
        """Write the share of what is permitted at that speed, where something is and it is bounded."""
        if np.isinf(found.permitted) or np.isinf(found.value):
            return ""
        permitted, failing = (
            format_quantity(one.permitted, self.unit, DIGITS) for one in (found, self.misfiring)
        )
        same = permitted == failing and not np.isinf(self.misfiring.value)
        return f", {format_usage(found.used)}{'' if same else f' of the permitted {permitted}'}"

    def _amount(self, found: Reached) -> str:
        """Write the value, and its speed."""
        at = format_quantity(found.speed, "rad/s", 4)
        if np.isinf(found.value):
            return f"unbounded at {at}"
        return f"{format_quantity(found.value, self.unit, DIGITS)} at {at}"

    def row(self) -> Row:
        """Return the columns of a table, each value with its unit; see `table_of`."""
        found: Row = {"quantity": (self.quantity, ""), "unit": (self.unit, "")}
        for name, one in (("normal", self.normal), ("misfiring", self.misfiring)):
            found |= {
                f"{name}_place": (one.place, ""),
                f"{name}_speed": (one.speed, "rad/s"),
                f"{name}_value": (one.value, "SI, see the column unit"),
                f"{name}_permitted": (one.permitted, "SI, see the column unit"),
                f"{name}_used": (one.used, "1"),
            }
        return found | {"cylinders": (named(self.cylinders), "")}


def named(cylinders: Cylinders) -> str:
    """Name cylinders, such as "cylinder 4" or "cylinders 3, 5"."""
    numbers = ", ".join(str(number) for number in cylinders)
    return f"cylinder{'' if len(cylinders) == 1 else 's'} {numbers}"


def permitted_at(limit: VibrationLimit | None, speeds: FloatArray) -> FloatArray:
    """Return the permitted values at speeds [rad/s]; inf where none is stated, or without a limit."""
    if limit is None:
        return np.full(speeds.shape, np.inf)
    return limit.continuous.at(speeds)


def weights(limit: VibrationLimit | None, speeds: FloatArray) -> FloatArray:
    """Return the reciprocal of the permitted value at each speed; without a limit one everywhere."""
    return np.ones(speeds.shape) if limit is None else 1.0 / permitted_at(limit, speeds)


def worst_of(series: OrderSeries, limit: VibrationLimit | None) -> Reached:
    """Return the worst of a quantity: where most of a limit is used, or the largest without one."""
    value, speed, place = largest_amplitude(series, weights(limit, series.speeds))
    permitted = permitted_at(limit, series.speeds[[speed]])
    return Reached(
        place=series.names[place],
        speed=float(series.speeds[speed]),
        value=value,
        permitted=float(permitted[0]),
    )
