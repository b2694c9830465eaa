"""Columns side by side, of which one may be the time or the crank angle of the others."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError, quoted
from crankbase.units import size_in
from crankfem.satellites.measured.records.record import SAMPLES, Channel, Column
from crankfem.satellites.measured.records.units import (
    EVENTS,
    axis_of,
    read_unit,
    split_heading,
)

# Longer columns are left in the file, and their places are taken as they are.
MOST_IN_MEMORY = 20_000_000
# Of so many places the extremes are kept, to tell whether all are even.
BLOCK = 1000
# Places that are off even ones by no more than this share of a step are even.
ROUND_OFF = 1e-6
# A rate [1/s] is taken as a whole number if its error is smaller, so that no other one is possible.
SURE = 0.5
# Fewer angles do not tell their unit.
FEWEST = 8
# So many samples of a level show one that has two values.
LEVELS = 10_000
# Of the usual step this share at most is lost by the digits of uneven places.
LARGEST_ERROR = 0.01


@dataclass(frozen=True)
class RecordReading:
    """What a user says of a record that does not say so itself.

    Attributes
    ----------
    columns : mapping of str to int or str
        Name, with its unit, of columns by their number from 1 or their heading: ``{"time_s": 1}``.
    units : mapping of str to str
        Unit of channels, times and angles by name, in place of that in the file.
    rate : float or None
        Samples in a second, where the file has no time or too few digits of it.
    sheet : str
        Of a spreadsheet.
    """

    columns: Mapping[str, int | str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    rate: float | None = None
    sheet: str = ""


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


def even_places(places: Column, error: float) -> tuple[float, float] | None:
    """Return start and step of places that are even but for their digits; None of others.

    They are read once, in pieces: of each block the extremes around a line through the first piece are kept.

    Examples
    --------
    >>> even_places(Column.of([0.0, 0.0003, 0.0007, 0.001]), error=0.5e-4)
    (0.0, 0.00034)
    """
    start = step = 0.0
    count, blocks = 0, []
    for piece in places.read(SAMPLES):
        index = np.arange(count, count + piece.size, dtype=np.float64)
        if count == 0:
            start, step = float(piece[0]), _slope(index, piece)
        off = piece - (start + step * index)
        begins = np.arange(0, piece.size, BLOCK)
        ends = np.minimum(begins + BLOCK, piece.size) - 1
        extremes = [each.reduceat(off, begins) for each in (np.minimum, np.maximum)]
        blocks.append(np.array([*extremes, 0.5 * (index[begins] + index[ends])]))
        count += piece.size
    if count < 2:
        return None
    low, high, middle = np.concatenate(blocks, axis=1)
    step_error = _slope(middle, 0.5 * (low + high))
    level = float(np.mean(0.5 * (low + high))) if middle.size > 1 else float(np.mean(off))
    off = np.array([low, high]) - level - step_error * (middle - np.mean(middle))
    step += step_error
    if step <= 0.0 or not np.max(np.abs(off)) <= max(2.0 * error, ROUND_OFF * step):
        return None
    return start, step


def _slope(index: Array, values: Array) -> float:
    """Return the slope of the line through values, shape (n,), zero of one alone."""
    centered = index - np.mean(index)
    return float(centered @ values / (centered @ centered)) if index.size > 1 else 0.0


def whole_rate(step: float, count: int, error: float) -> float:
    """Return the step [s] of a whole number of samples a second, if the digits leave no other; or `step`."""
    rate = 1.0 / step
    uncertain = rate * 2.0 * max(error, ROUND_OFF * step) / (max(count - 1, 1) * step)
    nearest = round(rate)
    return 1.0 / nearest if nearest and abs(rate - nearest) <= uncertain < SURE else step


def channels_of_series(
    path: str, group: str, series: Sequence[Series], reading: RecordReading
) -> tuple[tuple[Channel, ...], list[str]]:
    """Return the channels of columns of one group, and what is to be told of them.

    Raises
    ------
    InputError
        If a time or an angle goes back, has too few digits, or contradicts the rate that is given.
    """
    notes: list[str] = []
    headings = [each.heading for each in series]
    series = [
        replace(each, heading=f"{each.heading} #{headings[:place].count(each.heading) + 1}")
        if headings[:place].count(each.heading)
        else each
        for place, each in enumerate(series)
    ]
    read = [_named(each, reading, notes) for each in series]
    axes = [
        place
        for place, (name, unit, _) in enumerate(read)
        if len(read) > 1 and axis_of(name, unit) != "none"
    ]
    # Evenly sampled over one of time and angle, the other one is a channel.
    evens = {place: even_places(series[place].column, series[place].error) for place in axes}
    chosen = next((place for place in axes if evens[place] is not None), axes[0] if axes else None)
    channels = []
    for place, (name, unit, _) in enumerate(read):
        if place == chosen:
            continue
        channel = named_channel(group, series[place], reading, notes)
        if channel.si_unit == "s" and EVENTS.search(name) and len(channel) <= MOST_IN_MEMORY:
            check_digits(path, name, unit, channel.values, series[place].error, notes)
        if chosen is None:
            if reading.rate is not None:
                step = 1.0 / reading.rate
                channel = replace(channel, axis="time", axis_unit="s", start=0.0, step=step)
            channels.append(channel)
        else:
            channels.append(
                over_places(
                    path,
                    channel,
                    read[chosen][:2],
                    series[chosen],
                    reading,
                    notes,
                    series[place].gaps,
                )
            )
    return tuple(channels), list(dict.fromkeys(notes))


def _named(each: Series, reading: RecordReading, notes: list[str]) -> tuple[str, str, str]:
    """Return name, unit and reference of the pressure, and note a unit that is unknown."""
    name, written = split_heading(each.heading, each.unit)
    for word in (axis_of(name, written), name, each.heading):
        written = reading.units.get(word, written)
    unit, reference = read_unit(written)
    if written and not unit and written not in ("-", "--", "1"):
        notes.append(f"{name}: its unit {quoted(written)} is unknown.")
    if reference == "gauge":
        notes.append(f"{name}: is a pressure above the atmosphere, by its unit {written}.")
    return name, unit, reference


def named_channel(group: str, each: Series, reading: RecordReading, notes: list[str]) -> Channel:
    """Return a channel without places, and note a unit that is unknown."""
    name, unit, reference = _named(each, reading, notes)
    return Channel(name, group, unit, each.column, reference=reference)


def over_places(
    path: str,
    channel: Channel,
    axis_named: tuple[str, str],
    axis: Series,
    reading: RecordReading,
    notes: list[str],
    gaps: bool = False,
) -> Channel:
    """Return a channel over a column of times or angles: by start and step if they are even.

    Samples without a number, or without a place, are left out: a channel that has ended is not continued.

    Raises
    ------
    InputError
        As `channels_of_series`.
    """
    name, unit = axis_named
    kind = axis_of(name, unit)
    over = replace(channel, axis=kind, axis_unit=unit, error=axis.error)
    if channel.column.count > MOST_IN_MEMORY:
        if (even := even_places(axis.column, axis.error)) is None:
            return replace(over, places=axis.column)
        return at_steps(path, replace(over, start=even[0], step=even[1]), reading, notes)
    places = axis.column.whole
    if gaps or axis.gaps:
        values = channel.column.whole
        there = np.isfinite(places) & np.isfinite(values)
        over, places = replace(over, column=Column.of(values[there])), places[there]
    if kind == "angle":
        falls = np.flatnonzero(np.diff(places) < 0.0)
        first = places[: falls[0] + 1] if falls.size else places
        unit = settled_unit(name, unit, first, axis.error, reading, notes)
        over, places = replace(over, axis_unit=unit), continued(places, unit)
    back = np.flatnonzero(np.diff(places) < 0.0)
    if back.size:
        raise InputError(
            f"{path}: {name}: given {places[back[0] + 1]:.9g} {unit} after {places[back[0]]:.9g} {unit} in "
            f"sample {back[0] + 2}; allowed are places that increase, because samples follow each other."
        )
    even = even_places(Column.of(places), axis.error)
    if even is None:
        check_digits(path, name, unit, places, axis.error, notes)
        if reading.rate is not None and kind == "time":
            raise InputError(
                f"{path}: given the rate {reading.rate:g} 1/s, but {name} is uneven; allowed is a rate of "
                "even samples alone."
            )
        return replace(over, places=Column.of(places))
    start, step = even
    if reading.rate is None and axis.error > LARGEST_ERROR * step and _is_level(over):
        # Edges of a logic analyzer are even as well, if few digits are left of them.
        check_digits(path, name, unit, places, axis.error, notes)
    return at_steps(path, replace(over, start=start, step=step), reading, notes)


def _is_level(channel: Channel) -> bool:
    return np.unique(next(channel.column.read(LEVELS))).size <= 2


def settled_unit(
    name: str, unit: str, angles: Array, error: float, reading: RecordReading, notes: list[str]
) -> str:
    """Return the unit of crank angles, shape (n,): radians may be labeled degrees, and the other way round.

    A turn is a whole number of steps, and a record one of turns, in the unit that is meant alone.
    """
    if angles.size < FEWEST or not reading.units.keys().isdisjoint((name, "angle")):
        return unit
    step = float(angles[-1] - angles[0]) / (angles.size - 1)
    even = even_places(Column.of(angles), error) is not None
    room = 2.0 * error / (angles.size * abs(step)) + ROUND_OFF if step else 1.0

    def fits(turn: float) -> bool:
        steps, span = turn / step, (angles[-1] - angles[0]) / turn
        divides = even and abs(steps - round(steps)) <= room * abs(steps) < SURE / 5.0
        ends = (span, span + 1.0 / abs(steps))
        whole = any(round(end) and abs(end - round(end)) < 0.02 / abs(steps) for end in ends)
        return divides or whole

    known = {"deg": 360.0, "rad": 2.0 * math.pi}
    if not step or (unit and not known.keys() & {unit.replace("°", "deg")}):
        return unit
    fitting = [each for each, turn in known.items() if fits(turn)]
    if fitting and unit not in fitting:
        notes.append(
            f"{name}: is taken in {fitting[0]}, not in {unit or 'an unknown unit'}: from {angles[0]:.6g} to "
            f"{angles[-1]:.6g} in steps of {step:.6g} it is turns in {fitting[0]} alone."
        )
        return fitting[0]
    return unit


def at_steps(path: str, channel: Channel, reading: RecordReading, notes: list[str]) -> Channel:
    """Return an evenly sampled channel at its rate: the one that is given, or that its digits leave.

    Raises
    ------
    InputError
        If the rate that is given is another one.
    """
    step, count, unit = channel.step, len(channel), channel.axis_unit
    assert step is not None
    if channel.axis != "time" or not unit:
        return channel
    size = size_in(unit, "s")[0]
    taken = whole_rate(step * size, count, channel.error * size) / size
    if reading.rate is not None:
        taken = 1.0 / (reading.rate * size)
        room = 2.0 * channel.error / (max(count - 1, 1) * step) + ROUND_OFF
        if abs(taken / step - 1.0) > room:
            raise InputError(
                f"{path}: {channel.name}: given the rate {reading.rate:g} 1/s, but its samples are "
                f"{1.0 / (step * size):.7g} a second, {step / taken:.4g} times apart; allowed is the rate of "
                "the file, or none."
            )
    if channel.error > ROUND_OFF * step:
        notes.append(
            f"The times of even samples have errors up to {channel.error:.2g} {unit} by their digits; "
            f"{1.0 / (taken * size):.9g} samples a second from {channel.start:.9g} {unit} are taken."
        )
    return replace(channel, step=taken)


def check_digits(
    path: str, name: str, unit: str, places: Array, error: float, notes: list[str]
) -> None:
    """Refuse uneven places, shape (n,), such as times of pulses, of which too few digits are left.

    Steps that are whole multiples of the smallest one may be exact: their error is noted.

    Raises
    ------
    InputError
        If their error is more than a hundredth of the usual step.
    """
    steps = np.diff(places)
    usual, least = (float(np.median(steps)), float(np.min(steps))) if steps.size else (0.0, 0.0)
    if not steps.size or error <= LARGEST_ERROR * usual:
        return
    told = f"errors up to {error:.2g} {unit} by their digits"
    off = steps - least * np.round(steps / least) if least > 0.0 else np.array(error)
    if np.all(np.abs(off) < 0.1 * error):
        notes.append(f"{name}: has {told}, unless they are exact.")
        return
    same = int(np.count_nonzero(steps == 0.0))
    raise InputError(
        f"{path}: {name}: given uneven places with {told}, while their usual step is {usual:.2g} {unit} and "
        f"{same} of {places.size} fall together; allowed is an error of {LARGEST_ERROR * usual:.1g} {unit}: "
        "export them with more digits, or in binary form."
    )


def continued(angles: Array, unit: str) -> Array:
    """Return angles, shape (n,), that begin again with each turn or cycle as angles that are counted on."""
    steps = np.diff(angles)
    if not np.any(steps < 0.0) or not unit:
        return angles
    turn = 2.0 * np.pi / size_in(unit, "rad")[0]
    usual = float(np.median(steps))
    turns = np.where(steps < -0.4 * turn, np.round((usual - steps) / turn), 0.0)
    return angles + turn * np.concatenate([[0.0], np.cumsum(turns)])
