"""A record: channels of samples, each over its own time or crank angle, read in pieces where it is long.

Channels are never put into one table: instants of one that has ended, or that is sampled over the angle, are
none of another one.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, read_only
from crankbase.choices import allowed_names
from crankbase.errors import InputError, quoted
from crankbase.summaries import summarized
from crankbase.units import size_in
from crankfem.satellites.measured.records.units import AXIS_UNITS, kind_of_unit, split_heading

Axis = Literal["time", "angle", "none"]

# Numbers of a piece: 8 MB.
SAMPLES = 1_000_000
# Of a rate [1/s] that is a whole number but for round-off, the inverse is taken: samples that two rates share
# are then at equal instants.
WHOLE = 1e-9


@dataclass(frozen=True, eq=False)
class Column:
    """Numbers of a file.

    Attributes
    ----------
    count : int
        How many.
    read : callable
        Reads them in pieces of so many, the last one of fewer.
    """

    count: int
    read: Callable[[int], Iterator[Array]]

    @classmethod
    def of(cls, numbers: ArrayLike) -> "Column":
        """Return numbers that are in memory as such a column."""
        held = read_only(np.array(numbers, dtype=np.float64))

        def pieces(samples: int) -> Iterator[Array]:
            for first in range(0, held.size, samples):
                yield held[first : first + samples]

        return cls(held.size, pieces)

    @classmethod
    def of_blocks(cls, count: int, blocks: Callable[[], Iterable[Array]]) -> "Column":
        """Return numbers that a file has in blocks of any size as such a column."""

        def pieces(samples: int) -> Iterator[Array]:
            held: list[Array] = []
            held_size = 0
            for block in blocks():
                for part in np.split(block, range(samples - held_size, block.size, samples)):
                    held, held_size = [*held, part], held_size + part.size
                    if held_size >= samples:
                        yield np.concatenate(held)
                        held, held_size = [], 0
            if held_size:
                yield np.concatenate(held)

        return cls(count, pieces)

    @cached_property
    def whole(self) -> Array:
        """All of them, kept in memory, shape (n,)."""
        return read_only(np.concatenate([*self.read(SAMPLES), np.empty(0)]))


@summarized("name", "group", "unit", "axis", "samples: column.count", "rate [1/s]")
@dataclass(frozen=True, eq=False)
class Channel:
    """Samples of one quantity.

    Attributes
    ----------
    name, group : str
        As in the file; the unit is not part of the name.
    unit : str
        As the table of units spells it or reads it; empty if it is unknown, or the numbers have none.
    column : Column
        The samples.
    axis : str
        What they are over: "time", "angle" (of the crank), or "none".
    axis_unit : str
        Unit of the places in the file; empty if it is unknown.
    start, step : float or None
        Place of the first sample and distance of all, if they are even [s or rad].
    places : Column or None
        Place of each sample, if they are not [axis_unit].
    error : float
        Largest error of a place, by the digits with which the file has it [s or rad].
    reference : str
        Of a pressure: "absolute", "gauge" (above the atmosphere), or empty if the file does not say.
    """

    name: str
    group: str
    unit: str
    column: Column
    axis: Axis = "none"
    axis_unit: str = ""
    start: float | None = None
    step: float | None = None
    places: Column | None = None
    error: float = 0.0
    reference: str = ""

    def __len__(self) -> int:
        return self.column.count

    @property
    def values(self) -> Array:
        """The samples in `unit`, shape (n,)."""
        return self.column.whole

    @property
    def instants(self) -> Array | None:
        """The places of uneven samples in `axis_unit`, shape (n,); None of even ones."""
        return None if self.places is None else self.places.whole

    @property
    def si_unit(self) -> str:
        """The unit of `si`, empty if the unit is unknown."""
        return kind_of_unit(self.unit)

    @property
    def rate(self) -> float | None:
        """Samples in a second [1/s]; None if they are not even over time."""
        if self.axis != "time" or self.step is None:
            return None
        rate = 1.0 / self.step
        return float(round(rate)) if math.isclose(rate, round(rate), rel_tol=WHOLE) else rate

    def si(self) -> Array:
        """Return the samples in SI, shape (n,).

        Raises
        ------
        InputError
            If their unit is unknown.
        """
        return self._in_si(self.values)

    def abscissa(self) -> Array:
        """Return the place of each sample [s or rad], shape (n,).

        Raises
        ------
        InputError
            If it is not known, or its unit is not.
        """
        if self.places is not None:
            return self.places.whole * self._axis_size()
        return self._even_places(0, len(self))

    def pieces(self, samples: int = SAMPLES) -> Iterator[tuple[Array, Array]]:
        """Read the channel in pieces: places [s or rad] and samples in SI, of so many, the last of fewer.

        Raises
        ------
        InputError
            As `si` and `abscissa`.
        """
        if self.places is not None:
            size = self._axis_size()
            pairs = zip(self.places.read(samples), self.column.read(samples), strict=True)
            for places, values in pairs:
                yield places * size, self._in_si(values)
            return
        first = 0
        for values in self.column.read(samples):
            yield self._even_places(first, first + values.size), self._in_si(values)
            first += values.size

    def _in_si(self, values: Array) -> Array:
        if not self.si_unit:
            raise InputError(
                f"{self.name}: its unit is {'unknown' if self.unit == '' else self.unit}; say it, like "
                f'units = {{ {self.name} = "N m" }}.'
            )
        size, zero = size_in(self.unit, self.si_unit)
        if not np.all(np.isfinite(values)):
            raise InputError(
                f"{self.name}: sample {int(np.argmin(np.isfinite(values))) + 1} is no finite number; allowed "
                "are finite numbers, because every sample counts."
            )
        return values * size + zero

    def _axis_size(self) -> float:
        """Return the size of the unit of the places [s or rad]."""
        if self.axis == "none":
            raise InputError(
                f"{self.name}: has no time and no angle; say the rate of its samples, like rate = 50000 "
                "(1/s), or which column is the time, like columns = { time_s = 1 }."
            )
        if not self.axis_unit:
            raise InputError(
                f"{self.name}: the unit of its {self.axis} is unknown; say it by the name of that column, "
                f'like units = {{ {self.axis} = "{AXIS_UNITS[self.axis]}" }}.'
            )
        return size_in(self.axis_unit, AXIS_UNITS[self.axis])[0]

    def _even_places(self, first: int, stop: int) -> Array:
        self._axis_size()
        assert self.start is not None
        assert self.step is not None
        counted = np.arange(first, stop, dtype=np.float64)
        return self.start + (counted * self.step if self.rate is None else counted / self.rate)


@summarized("format", "names", "path")
@dataclass(frozen=True, eq=False)
class Record:
    """What an instrument wrote into a file.

    Attributes
    ----------
    path : str
        The file.
    format : str
        Its format, such as "CSV" or "TDMS".
    channels : tuple of Channel
        In the order of the file.
    notes : tuple of str
        What was settled in reading it, and what is not known, a sentence each.
    """

    path: str
    format: str
    channels: tuple[Channel, ...]
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Of the channels."""
        return tuple(each.name for each in self.channels)

    def channel(self, name: str, group: str | None = None) -> Channel:
        """Return a channel by its name, and that of its group where several have the name.

        Raises
        ------
        InputError
            If there is none, or several.
        """
        named = [each for each in self.channels if group is None or each.group == group]
        wanted = (name, split_heading(name)[0])
        matching = [each for each in named if each.name == name] or [
            each for each in named if each.name.casefold() in (word.casefold() for word in wanted)
        ]
        if len(matching) == 1:
            return matching[0]
        if not matching:
            where = "" if group is None else f" in the group {quoted(group)}"
            names = list(dict.fromkeys(each.name for each in named)) or ["none"]
            raise InputError(
                f"{self.path}: given the channel {quoted(name)}, which is not there{where}; "
                f"{allowed_names(name, names)}."
            )
        groups = ", ".join(dict.fromkeys(quoted(each.group) for each in matching))
        raise InputError(
            f"{self.path}: given the channel {quoted(name)}, of which there are {len(matching)}, in the "
            f"groups {groups}; say the group, too, because they may be different quantities."
        )
