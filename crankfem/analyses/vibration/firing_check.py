"""Comparison of one quantity in normal firing and while cylinders misfire."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from crankbase.tables.frames import Row
from crankbase.units.number_formats import format_usage
from crankbase.units.quantity import format_quantity
from dynamics.assessment.limits import VibrationLimit
from dynamics.assessment.response_curves import largest_amplitude
from dynamics.assessment.wording import limit_at, use_in_words
from dynamics.response.peak_cause import PeakCause
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


@dataclass(frozen=True)
class NewlyExceeded:
    """The worst of a limit that misfiring exceeds at speeds at which normal firing keeps it.

    Attributes
    ----------
    cylinders : tuple of int
    reached : Reached
    cause : PeakCause
    """

    cylinders: Cylinders
    reached: Reached
    cause: PeakCause


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
    new : NewlyExceeded or None
        What misfiring alone exceeds.
    """

    quantity: str
    unit: str
    limit: VibrationLimit | None
    normal: Reached
    cylinders: Cylinders
    misfiring: Reached
    each: Mapping[Cylinders, Reached]
    over_speed: tuple[FloatArray, FloatArray, FloatArray] | None = None
    new: NewlyExceeded | None = None

    @property
    def passed(self) -> bool:
        """Whether the limit while misfiring is kept at running speeds."""
        return self.misfiring.used <= 1.0

    @property
    def sentence(self) -> str:
        """The finding while misfiring by both limits, with normal firing for comparison."""
        return f"With {self._finding(self.cylinders, self.misfiring)}."

    @property
    def news(self) -> str:
        """What misfiring alone exceeds, with its cause; empty if nothing."""
        if self.new is None:
            return ""
        own, reasons = self.new.reached, self.new.cause.reasons
        kept = "" if self.normal_keeps else f", but within its limit at {self._speed(own)}"
        return (
            f"With {self._finding(self.new.cylinders, own)}{kept}: exceeded by misfiring alone. "
            f"{reasons[0].upper()}{reasons[1:]}."
        )

    @property
    def normal_keeps(self) -> bool:
        """Whether normal firing keeps the limit at all running speeds."""
        return self.normal.used <= 1.0

    def _speed(self, found: Reached) -> str:
        return format_quantity(found.speed, "rad/s", 4)

    def _finding(self, cylinders: Cylinders, own: Reached) -> str:
        normal, limit = self.normal, self.limit
        if limit is None or np.isinf(own.permitted):
            found = f"at most {self._amount(own)}"
        else:
            found = use_in_words(limit, own.speed, own.value, own.permitted, DIGITS)
            found += self._by_the_other(limit, own)
        elsewhere = "" if normal.place == own.place else f", {normal.place}"
        return (
            f"{named(cylinders)} misfiring, {limit_at(self.quantity, own.place)}: {found}; with "
            f"all cylinders firing {self._amount(normal)}{self._share(normal, own)}{elsewhere}"
        )

    def _by_the_other(self, limit: VibrationLimit, own: Reached) -> str:
        """Write the share of the limit that does not decide, and the basis if it is that for passing."""
        if limit.passing is None:
            return ""
        at = np.array([own.speed])
        passing, kept = float(limit.passing.at(at)[0]), float(limit.continuous.at(at)[0])
        if np.isinf(passing) or passing == kept:
            return ""
        other = kept if limit.misfiring_basis else passing
        share = "" if np.isinf(own.value) else f"{format_usage(own.value / other)} of "
        shown = f"{share}the {format_quantity(other, self.unit, DIGITS)}"
        if limit.misfiring_basis:
            return (
                f" for passing, which serves while a cylinder misfires by {limit.misfiring_basis}, "
                f"{shown} permitted continuously"
            )
        return f", {shown} that may be passed"

    def _share(self, found: Reached, beside: Reached) -> str:
        """Write the share of what is permitted at that speed, where something is and it is bounded."""
        if np.isinf(found.permitted) or np.isinf(found.value):
            return ""
        permitted, failing = (
            format_quantity(one.permitted, self.unit, DIGITS) for one in (found, beside)
        )
        same = permitted == failing and not np.isinf(beside.value)
        return f", {format_usage(found.used)}{'' if same else f' of the permitted {permitted}'}"

    def _amount(self, found: Reached) -> str:
        """Write the value, and its speed."""
        if np.isinf(found.value):
            return f"unbounded at {self._speed(found)}"
        return f"{format_quantity(found.value, self.unit, DIGITS)} at {self._speed(found)}"

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


def worst_of(
    series: OrderSeries, limit: VibrationLimit | None, among: NDArray[np.bool_] | None = None
) -> Reached:
    """Return the worst of a quantity: where most of a limit is used, or the largest without one.

    Parameters
    ----------
    series : OrderSeries
    limit : VibrationLimit or None
    among : (S,) array of bool, optional
        The speeds that count.
    """
    counted = weights(limit, series.speeds) * (1.0 if among is None else among)
    value, speed, place = largest_amplitude(series, counted)
    permitted = permitted_at(limit, series.speeds[[speed]])
    return Reached(
        place=series.names[place],
        speed=float(series.speeds[speed]),
        value=value,
        permitted=float(permitted[0]),
    )
