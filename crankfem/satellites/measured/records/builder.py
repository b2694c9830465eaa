"""Making a record: columns of a file become channels over their own times or crank angles."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.errors import InputError, quoted, shortened
from crankbase.exported_table import NO_UNIT
from crankbase.units import size_in
from crankfem.satellites.measured.records.places import (
    LARGEST_ERROR,
    ROUND_OFF,
    check_rising,
    continued,
    digits_fault,
    even_places,
    settled_unit,
    step_error,
    whole_rate,
)
from crankfem.satellites.measured.records.record import Axis, Channel, Column, Record
from crankfem.satellites.measured.records.units import (
    AXIS_UNITS,
    EVENTS,
    axis_of,
    read_unit,
    split_heading,
)

# Longer columns are left in the file, and their angles are taken as they are.
MOST_IN_MEMORY = 20_000_000
# Later times [s] count from another zero than that of the file: those since 1970 are rounded to 0.2 us.
LATEST_START = 1e6
# So many samples of a level show one that has two values.
LEVELS = 10_000


@dataclass(frozen=True)
class RecordReading:
    """What a user says of a record that does not say so itself; fields as parameters of `read_record`."""

    columns: Mapping[str, int | str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    rate: float | None = None


@dataclass(frozen=True, eq=False)
class Series:
    """A column with what stands at it.

    Attributes
    ----------
    heading, unit : str
        As in the file; the unit may be in the heading.
    error : float
        Largest error of a number, by its digits.
    gaps : bool
        Whether there are rows without a number, which are NaN.
    """

    heading: str
    unit: str
    column: Column
    error: float = 0.0
    gaps: bool = False


@dataclass(frozen=True, eq=False)
class PlaceSeries:
    """The times or crank angles of other series; `column` is in `unit`."""

    name: str
    unit: str
    kind: Axis
    column: Column
    error: float
    gaps: bool

    @cached_property
    def even(self) -> tuple[float, float] | None:
        """Start and step, if they are even."""
        return even_places(self.column, self.error)


class RecordBuilder:
    """A record while it is read.

    Raises
    ------
    InputError
        By its methods, if times or angles go back, have too few digits, or contradict the rate that is given.
    """

    def __init__(self, path: Path, kind: str, reading: RecordReading) -> None:
        self.path, self.kind, self.reading = path, kind, reading
        self.channels: list[Channel] = []
        self.notes: list[str] = []
        self.origin = 0

    @property
    def record(self) -> Record:
        """What has been added."""
        notes = tuple(dict.fromkeys(self.notes))
        return Record(str(self.path), self.kind, tuple(self.channels), notes)

    def add_columns(self, group: str, series: Sequence[Series]) -> None:
        """Add columns side by side, of which one may be the time or the crank angle of the others."""
        headings = [each.heading for each in series]
        for place, heading in enumerate(headings):
            if repeated := headings[:place].count(heading):
                headings[place] = f"{heading} #{repeated + 1}"
        series = [
            replace(each, heading=heading) for each, heading in zip(series, headings, strict=True)
        ]
        axes = [
            each
            for each in series
            if len(series) > 1 and axis_of(*split_heading(each.heading, each.unit)) != "none"
        ]
        places = {id(each): self.places(each) for each in axes}
        # Evenly sampled over one of time and angle, the other one is a channel.
        chosen = next((each for each in axes if places[id(each)].even), axes[0] if axes else None)
        if chosen is None:
            for each in series:
                self._add_without_places(group, each)
            return
        kind = places[id(chosen)].kind
        alike = [id(each) for each in axes if places[id(each)].kind == kind]
        if len(alike) > 1:
            self.notes.append(
                f"Each channel is over the column of {kind} before it, of {len(alike)}."
            )
        over = alike[0]
        for each in series:
            if id(each) in alike:
                over = id(each)
            else:
                self.add_over(group, each, places[over])

    def _add_without_places(self, group: str, series: Series) -> None:
        if series.gaps:
            numbers = series.column.whole
            there = np.isfinite(numbers)
            series = replace(series, column=Column.of(numbers[there]))
        channel = self._channel(group, series)
        if series.gaps:
            self._note_missing(channel.name, there)
        if channel.si_unit == "s" and EVENTS.search(channel.name):
            self._check_digits(channel.name, channel.unit, channel.column, series.error)
        if self.reading.rate is not None:
            step = 1.0 / self.reading.rate
            channel = replace(channel, axis="time", axis_unit="s", start=0.0, step=step)
        self.channels.append(channel)

    def add_over(self, group: str, series: Series, places: PlaceSeries | None) -> None:
        """Add a channel over times or angles: by start and step if they are even.

        Samples without a number, or without a place, are left out: a channel that has ended is not continued.
        """
        if places is None:
            self._add_without_places(group, series)
            return
        channel = replace(self._channel(group, series), axis=places.kind, axis_unit=places.unit)
        column, even = places.column, places.even
        if series.gaps or places.gaps:
            there = np.isfinite(column.whole) & np.isfinite(series.column.whole)
            self._note_missing(channel.name, there)
            channel = replace(channel, column=Column.of(series.column.whole[there]))
            column = Column.of(column.whole[there])
            even = even_places(column, places.error)
        coarse = even is not None and places.error > LARGEST_ERROR * even[1]
        level = coarse and np.unique(next(channel.column.read(LEVELS))).size <= 2
        if even is None or (level and self.reading.rate is None):
            # Edges of a logic analyzer are even as well, if few digits are left of them.
            self._check_digits(places.name, places.unit, column, places.error)
        if even is not None:
            self._add_even(channel, *even, places.error)
            return
        if self.reading.rate is not None and places.kind == "time":
            raise InputError(
                f"{self.path}: given the rate {self.reading.rate:g} 1/s, but {places.name} is uneven; "
                "allowed is a rate of even samples alone."
            )
        size = _size(channel)
        self.channels.append(replace(channel, places=column, error=places.error * size))

    def add_even(
        self, group: str, series: Series, axis: tuple[str, str], start: float, step: float, error: float = 0.0
    ) -> None:  # fmt: skip
        """Add a channel of which the file has start and step, in the unit of `axis` (its name and unit)."""
        channel, (name, unit) = self._channel(group, series), axis
        kind = axis_of(name, unit)
        if kind == "none":
            self.notes.append(f"{channel.name}: is over {name} [{unit}], neither time nor angle.")
            self.channels.append(channel)
            return
        unit = read_unit(self._unit_of(name, kind, unit))[0]
        self._add_even(replace(channel, axis=kind, axis_unit=unit), start, step, error)

    def _add_even(self, channel: Channel, start: float, step: float, error: float) -> None:
        """Add a channel at its rate: the one that is given, or that its digits leave."""
        size, rate = _size(channel), self.reading.rate
        start, step, error = start * size, step * size, error * size
        if channel.axis == "time" and channel.axis_unit:
            taken = rate or whole_rate(step, len(channel), error)
            if rate and abs(rate * step - 1.0) > step_error(step, len(channel), error) + ROUND_OFF:
                raise InputError(
                    f"{self.path}: {channel.name}: given the rate {rate:g} 1/s, but its samples are "
                    f"{1.0 / step:.7g} a second, {step * rate:.4g} times apart; allowed is the rate of the "
                    "file, or none."
                )
            if error > ROUND_OFF * step:
                self.notes.append(
                    f"The times of even samples have errors up to {error:.2g} s by their digits; {taken:.9g} "
                    f"samples a second from {start:.9g} s are taken."
                )
            step = 1.0 / taken
        self.channels.append(replace(channel, start=start, step=step, error=error))

    def places(self, series: Series, kind: Axis | None = None) -> PlaceSeries:
        """Return a series as the places of others: angles counted on, in the unit that their turns show."""
        name, unit = split_heading(series.heading, series.unit)
        kind = kind or axis_of(name, unit)
        unit, column = read_unit(self._unit_of(name, kind, unit))[0], series.column
        first = np.concatenate([next(column.read(1), np.zeros(1)), np.zeros(1)])[0]
        error = max(series.error, float(np.spacing(abs(first))) / 2.0)
        if kind == "time" and unit and abs(first) * size_in(unit, "s")[0] > LATEST_START:
            self.origin = self.origin or math.floor(first * size_in(unit, "s")[0])
            column = Column(
                column.count, partial(_since, column, self.origin / size_in(unit, "s")[0])
            )
            self.notes.append(f"Times count from {self.origin} s of the file.")
        if kind == "angle" and column.count <= MOST_IN_MEMORY:
            angles = column.whole
            if self.reading.units.keys().isdisjoint((name, kind)):
                unit, why = settled_unit(unit, angles[np.isfinite(angles)], error)
                self.notes += [f"{name}: {why}."] if why else []
            column = Column.of(continued(angles, unit))
        return PlaceSeries(name, unit, kind, column, error, series.gaps)

    def _unit_of(self, name: str, kind: str, written: str) -> str:
        """Return the unit that is given for a name, or a kind of axis, or else the one that is written."""
        units = self.reading.units
        return units.get(name, units.get(kind, written))

    def _channel(self, group: str, series: Series) -> Channel:
        """Return a channel without places, and note a unit that is unknown."""
        name, written = split_heading(series.heading, series.unit)
        written = self._unit_of(name, series.heading, written)
        unit, reference = read_unit(written)
        if not unit and written not in NO_UNIT:
            self.notes.append(f"{name}: its unit {quoted(written)} is unknown.")
        if reference == "gauge":
            self.notes.append(f"{name}: is a pressure above the atmosphere, by its unit {written}.")
        column = Column(series.column.count, partial(_pieces, self.path, series.column))
        return Channel(name, group, unit, column, reference=reference)

    def _note_missing(self, name: str, there: Flags) -> None:
        """Count the rows left out for want of a number; behind the last one a channel has ended."""
        rows = np.flatnonzero(there)
        missing = int(rows[-1]) + 1 - rows.size if rows.size else 0
        if missing:
            self.notes.append(f"{name}: {missing} rows without a number are left out.")

    def _check_digits(self, name: str, unit: str, column: Column, error: float) -> None:
        """Refuse uneven places that go back or have too few digits; of very long ones it is not looked at."""
        if column.count > MOST_IN_MEMORY:
            return
        check_rising(f"{self.path}: {name}", unit, column.whole)
        fault, too_few = digits_fault(unit, column.whole, error)
        if too_few:
            raise InputError(f"{self.path}: {name}: {fault}.")
        self.notes += [f"{name}: {fault}."] if fault else []


def _pieces(path: Path, column: Column, samples: int) -> Iterator[Array]:
    """Read a column, and tell of damage that is found on the way; packages do so by errors of many kinds."""
    try:
        yield from column.read(samples)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: cannot be read ({shortened(str(error))}).") from None


def _since(column: Column, origin: float, samples: int) -> Iterator[Array]:
    """Read times from another zero."""
    return (piece - origin for piece in column.read(samples))


def _size(channel: Channel) -> float:
    """Return the size of the unit of a channel's places [s or rad], NaN if it is unknown."""
    return (
        size_in(channel.axis_unit, AXIS_UNITS[channel.axis])[0] if channel.axis_unit else math.nan
    )
