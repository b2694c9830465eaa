"""Tables of samples over the crank angle: their columns, and one working cycle of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from pydantic import Field

from crankbase.array_checks import Array
from crankbase.errors import InputError, quoted, shortened
from crankbase.exported_table import ExportedTable, read_exported_table, unit_size
from crankbase.input_file import GivenFile, InputFile
from crankbase.model import InputModel, quantity_field
from crankbase.quantity import percent
from crankbase.sentences import angle
from crankbase.units import pressure_reference
from dynamics.cycle import (
    PLACE_TOLERANCE,
    checked_strokes,
    cycle_degrees,
    first_not_increasing,
    mean_step,
)

# [deg] A wider gap between samples could hide the whole rise of the pressure.
WIDEST_GAP = 10.0
# [deg] Steps of samples that are made even, between which half the smallest gap is taken.
FINEST_STEP, COARSEST_STEP = 0.1, 1.0
# Fewer samples show no cycle.
FEWEST_SAMPLES = 3
# Closing and first sample that differ by no more than noise, and by no more than this share of the largest.
LARGEST_NOISE = 0.02
# Third differences of independent errors have the square root of 20 times their standard deviation, and
# half of a normal distribution lies within 0.6745 of it.
_THIRD = 0.6745 * math.sqrt(20.0)
# Errors of two samples differ by so many standard deviations of one at most.
NOISE_WITHIN = 4.0 * math.sqrt(2.0)
# Where value or slope jumps at the end so many times more than between samples, the cycle does not close: of
# whole cycles of shipped engines it is up to 1.3, of one revolution of four-stroke ones 2.2 to 2300.
SEAM = 2.0
# Share of the largest value by which repetitions of a cycle scatter at most.
LARGEST_SCATTER = 0.25
# Of gaps so many are told.
MOST_GAPS = 5

Columns = Mapping[str, int | str]


class TableReading(InputModel):
    """How a table is to be read that does not say so itself."""

    section: ClassVar[str] = "reading"

    columns: dict[str, int | str] | None = Field(
        None,
        description="column of angle and value, by its heading or its number from 1, such as "
        '{ crank_angle_deg = 1, absolute_pressure_bar = "P1" }; the names say what it holds and its unit',
    )
    sheet: str = Field(
        "", description="sheet of a spreadsheet", json_schema_extra={"feature": True}
    )
    top: float = quantity_field(
        "angle in the table at which the crank is at the top, for a cylinder that fires then",
        "rad",
        default=0.0,
        feature=True,
    )


@dataclass(frozen=True)
class TableKind:
    """Contents of a table, and words for its messages.

    Parameters
    ----------
    angle_names, value_names : tuple of str
        Allowed names of the two columns; each ends in its unit.
    units : mapping of str to float
        Size in SI of the units at the ends of value names.
    si : str
        SI unit of the values.
    headers : str
        The allowed headers in words.
    header_says : str
        What follows from the header alone.
    """

    name: str
    angle_names: tuple[str, ...]
    value_names: tuple[str, ...]
    units: Mapping[str, float]
    si: str
    headers: str
    header_says: str


@dataclass(frozen=True, eq=False)
class SampleRows:
    """A file as read.

    Parameters
    ----------
    angle_name, value_name : str
        The names of the two columns.
    angles, values : ndarray of shape (m,)
        The two columns, in the units stated in their names.
    lines : tuple of int
        Line number of each row, counted from 1.
    comments : tuple of str
        The comment lines, without their number sign.
    faults : tuple of str
        What is wrong, a sentence each; they are told with those that follow.
    remarks : tuple of str
        Changes made to them, a sentence each.
    """

    path: Path
    angle_name: str
    value_name: str
    angles: Array
    values: Array
    lines: tuple[int, ...]
    comments: tuple[str, ...]
    faults: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """The unit of the values, as their name ends."""
        return self.value_name.rpartition("_")[2]

    @property
    def source(self) -> str:
        """The comments as one text."""
        return "\n".join(self.comments)

    def angle_error(self, index: int, message: str) -> InputError:
        """Return the error for the angle of a row, with file and line."""
        return InputError(f"{self.path}, line {self.lines[index]}: {self.angle_name}: {message}.")

    def value_error(self, index: int, message: str) -> InputError:
        """Return the error for the value of a row, with file and line."""
        return InputError(f"{self.path}, line {self.lines[index]}: {self.value_name}: {message}.")

    def step_error(self, index: int, allowed: str) -> InputError:
        """Return the error for an angle [deg] that does not fit the one before it."""
        before, after = self.angles[index - 1 : index + 1]
        return self.angle_error(
            index, f"given {after:g} deg after {before:g} deg; allowed are {allowed}"
        )

    def only(self, rows: slice) -> "SampleRows":
        """Return some of the rows."""
        return replace(
            self, angles=self.angles[rows], values=self.values[rows], lines=self.lines[rows]
        )

    def counted_on(self, cycle: float) -> "SampleRows":
        """Return the rows with angles counted on where they begin again with each cycle [deg]."""
        steps = np.diff(self.angles)
        if not np.any(steps < -0.5 * cycle):
            return self
        usual = float(np.median(steps))
        turns = np.where(steps < -0.5 * cycle, np.round((usual - steps) / cycle), 0.0)
        angles = self.angles + cycle * np.concatenate([[0.0], np.cumsum(turns)])
        # A cycle's closing sample is at the angle of the next one's first.
        repeated = (turns > 0.0) & (np.abs(np.diff(angles)) <= PLACE_TOLERANCE * usual)
        kept = np.append(~repeated, True)
        lines = tuple(line for line, keep in zip(self.lines, kept, strict=True) if keep)
        return replace(self, angles=angles[kept], values=self.values[kept], lines=lines)


def possible_cycles(strokes: int | None) -> dict[int, float]:
    """Return the length of the cycle [deg] for the strokes given, or for both."""
    possible = (4, 2) if strokes is None else (checked_strokes(strokes),)
    return {number: cycle_degrees(number) for number in possible}


def read_sample_rows(
    path: GivenFile, kind: TableKind, reading: TableReading | None = None
) -> SampleRows:
    """Read a table's columns of angles and values; what is wrong in it is kept as `faults`."""
    file = InputFile.of(path)
    reading = reading or file.reading or TableReading()
    table = read_exported_table(file, kind.name, reading.sheet)
    faults = list(table.faults)
    angle_name, value_name, angle, value, unclear = _columns_of(table, kind, reading.columns)
    faults = [*unclear, *faults]
    if angle is None or value is None:
        raise InputError("\n".join(faults))
    names = (angle_name, value_name)
    wrong = [
        sentence
        for column, name in zip((angle, value), names, strict=True)
        for sentence in table.wrong_cells(column, name)
    ]
    angles, values = table.numbers(angle), table.numbers(value)
    usable = np.isfinite(angles) & np.isfinite(values)
    if not wrong and not faults and np.count_nonzero(usable) < FEWEST_SAMPLES:
        faults.append(
            f"{file.path}: given {np.count_nonzero(usable)} samples; allowed are {FEWEST_SAMPLES} or more, "
            "over a whole cycle, because what the table holds repeats with it."
        )
    if wrong or np.count_nonzero(usable) < FEWEST_SAMPLES:
        raise InputError("\n".join([*faults, *wrong]))
    lines = tuple(line for line, fit in zip(table.lines, usable, strict=True) if fit)
    unused = [
        quoted(table.headings[place]) if table.headings else str(place + 1)
        for place in range(table.columns)
        if place not in (angle, value)
    ]
    remarks = (f"Columns not used: {', '.join(unused)}.",) if unused else ()
    return SampleRows(
        file.path,
        *names,
        angles[usable] - math.degrees(reading.top),
        values[usable],
        lines,
        table.comments,
        tuple(faults),
        remarks,
    )


def _columns_of(
    table: ExportedTable, kind: TableKind, columns: Columns | None
) -> tuple[str, str, int | None, int | None, list[str]]:
    """Return names and places of the two columns, likely ones where they are unclear, and faults."""
    headings = [heading.casefold() for heading in table.headings]
    if columns is not None:
        return _named_columns(table, kind, columns)
    known = {
        role: [name for name in names if name.casefold() in headings]
        for role, names in (("angle", kind.angle_names), ("value", kind.value_names))
    }
    if len(known["angle"]) == len(known["value"]) == 1:
        (angle,), (value,) = known["angle"], known["value"]
        places = headings.index(angle.casefold()), headings.index(value.casefold())
        faults = [
            fault
            for name, place in zip((angle, value), places, strict=True)
            for fault in _contradiction(table, kind, name, place)
        ]
        return angle, value, *places, faults
    where = f"{table.path}, line {table.header_line}: " if headings else f"{table.path}: "
    header = (
        f'given the header "{shortened(",".join(table.headings))}"' if headings else "no header"
    )
    # The first column whose numbers rise nearly always, and the first other one.
    likely_angle, likely_value = 0, min(1, max(table.columns - 1, 0))
    for place in range(table.columns):
        steps = np.diff(table.numbers(place))
        if steps.size and np.all(np.isfinite(steps)) and np.mean(steps > 0.0) > 0.9:
            likely_angle, likely_value = place, int(place == 0)
            break
    listed = {
        kind.angle_names[0]: _column_name(table, likely_angle),
        kind.value_names[0]: _column_name(table, likely_value),
    }
    written = ", ".join(f"{name} = {column}" for name, column in listed.items())
    fault = (
        f"{where}{header}; allowed is {kind.headers}, because it says {kind.header_says}; or say so by "
        f"columns, such as reading = {{ columns = {{ {written} }} }}."
    )
    return kind.angle_names[0], kind.value_names[0], likely_angle, likely_value, [fault]


def _column_name(table: ExportedTable, place: int) -> str:
    """Write a column as a file names it."""
    heading = table.headings[place] if table.headings else ""
    return f'"{heading}"' if heading and table.headings.count(heading) == 1 else str(place + 1)


def _named_columns(
    table: ExportedTable, kind: TableKind, columns: Columns
) -> tuple[str, str, int | None, int | None, list[str]]:
    """Return names and places of the columns that a user names."""
    faults: list[str] = []
    allowed = (*kind.angle_names, *kind.value_names)
    unknown = [name for name in columns if name not in allowed]
    angles = [name for name in columns if name in kind.angle_names]
    values = [name for name in columns if name in kind.value_names]
    if unknown or len(angles) != 1 or len(values) != 1:
        raise InputError(
            f"reading.columns: given {', '.join(columns) or 'none'}; allowed are one of "
            f"{', '.join(kind.angle_names)} and one of {', '.join(kind.value_names)}, because a {kind.name} "
            "has these two."
        )
    places: list[int | None] = []
    for name in (angles[0], values[0]):
        column = columns[name]
        place: int | None = None
        if isinstance(column, int):
            if 1 <= column <= table.columns:
                place = column - 1
            else:
                faults.append(
                    f"{table.path}: reading.columns: given {name} = {column}; allowed are 1 to "
                    f"{table.columns}, because the table has so many columns."
                )
        else:
            matching = [
                number
                for number, heading in enumerate(table.headings)
                if column.strip().casefold()
                in (heading.casefold(), heading.partition("[")[0].strip().casefold())
            ]
            if len(matching) == 1:
                place = matching[0]
            else:
                headings = ", ".join(quoted(each) for each in table.headings) or "no headings"
                faults.append(
                    f"{table.path}: reading.columns: given {name} = {quoted(column)}, which heads "
                    f"{len(matching) or 'none'} of the columns; the table has {headings}; name one of them, "
                    "or the number of the column from 1."
                )
        places.append(place)
        if place is not None:
            faults += _contradiction(table, kind, name, place)
    angle, value = places
    if angle is not None and angle == value:
        faults.append(
            f"{table.path}: reading.columns: given column {_column_name(table, angle)} for both "
            f"{angles[0]} and {values[0]}; allowed are two columns."
        )
    return angles[0], values[0], angle, value, faults


def _contradiction(table: ExportedTable, kind: TableKind, name: str, place: int) -> list[str]:
    """Return the sentence about a unit in the table that is not the one in the column's name."""
    unit = name.rpartition("_")[2]
    if not table.units[place]:
        return []
    si, size = ("rad", math.radians(1.0)) if unit == "deg" else (kind.si, kind.units[unit])
    in_table, reference = (
        unit_size(table.units[place], si),
        pressure_reference(table.units[place])[1],
    )
    agrees = in_table is None or math.isclose(in_table, size, rel_tol=1e-9)
    if agrees and (in_table is None or name.startswith(reference)):
        return []
    return [
        f"{table.path}, line {table.header_line}: {_column_name(table, place)}: given in "
        f"{table.units[place]}, but named {name}; allowed is the name with the unit that it has."
    ]


@dataclass(frozen=True)
class _Cut:
    """Where the cycles of a record are: rows of each whole one, and what is left over."""

    strokes: int
    cycles: tuple[slice, ...]
    left_over: int
    closing: int | None


def one_cycle(
    rows: SampleRows,
    cycles: Mapping[int, float],
    *,
    tolerance: float,
    what: str,
    even: bool = False,
) -> tuple[int, SampleRows]:
    """Return strokes and rows of one cycle: the mean of several, without a closing sample.

    Parameters
    ----------
    cycles : mapping of int to float
        Length of the cycle [deg] for each number of strokes that is possible.
    tolerance : float
        Share of the largest value by which a closing sample may differ from the first; by noise it may by
        more.
    what : str
        The values, for messages.
    even : bool, optional
        Whether even samples may be further apart than `WIDEST_GAP`.

    Raises
    ------
    InputError
        With a sentence for each fault, those of the rows included.
    """
    faults = list(rows.faults)
    if len(cycles) == 1:
        rows = rows.counted_on(*cycles.values())
    angles = rows.angles
    index = first_not_increasing(angles)
    if index is not None:
        error = rows.step_error(
            index, "strictly increasing angles, because the samples follow the crank"
        )
        raise InputError("\n".join([*faults, str(error)]))
    step = float(np.median(np.diff(angles)))
    steady = even and float(np.ptp(np.diff(angles))) <= 2.0 * PLACE_TOLERANCE * step
    room = max(WIDEST_GAP, step) if steady else WIDEST_GAP
    room *= 1.0 + (2.0 * PLACE_TOLERANCE if steady else 1e-9)
    cut = _cut(rows, cycles, room, step)
    if cut is None:
        lengths = " or ".join(f"{cycle:g} deg" for cycle in cycles.values())
        several = "" if len(cycles) > 1 else ", or several"
        no_cycle = rows.angle_error(
            -1,
            f"given angles from {rows.angles[0]:g} to {rows.angles[-1]:g} deg in steps of "
            f"{mean_step(rows.angles):g} deg; allowed is one cycle of {lengths}{several}, with or without "
            f"the closing sample, and open by {WIDEST_GAP:g} deg at most, because what the table holds "
            "repeats with the cycle",
        )
        raise InputError("\n".join([*faults, str(no_cycle)]))
    cycle = cycles[cut.strokes]
    gaps = np.flatnonzero(np.diff(angles[: cut.cycles[-1].stop]) > room) + 1
    faults += [
        str(
            rows.step_error(
                int(gap),
                f"gaps of {WIDEST_GAP:g} deg at most, because a wider one may hide the {what}'s rise",
            )
        )
        for gap in gaps[:MOST_GAPS]
    ]
    if gaps.size > MOST_GAPS:
        faults.append(f"{rows.path}: {gaps.size} gaps in all are wider than {WIDEST_GAP:g} deg.")
    remarks = list(rows.remarks)
    if cut.left_over:
        remarks.append(f"{cut.left_over} samples of an incomplete cycle at the end were left out.")
    single, scatter, of_mean, wrong = _mean_cycle(rows, cut, cycle)
    faults, remarks = faults + wrong, remarks + of_mean
    values = single.values
    if cut.closing is not None:
        values, wrong, of_closing = _without_closing(rows, cut, single, scatter, tolerance)
        faults, remarks = faults + wrong, remarks + of_closing
    elif (seam := _seam(single.angles, values, cycle)) > SEAM:
        half = (
            " Perhaps it is one revolution of a four-stroke engine, whose cycle has two."
            if cut.strokes == 2
            else ""
        )
        sentence = (
            f"{rows.path}: the step from the last sample to the first is {seam:.2g} times the largest "
            f"between the samples, as if the cycle of {angle(cycle)} did not close.{half}"
        )
        if len(cycles) > 1:
            faults.append(f"{sentence} Give its strokes, 2, if it does.")
        else:
            remarks.append(sentence)
    if len(cycles) > 1 and cut.strokes == 2:
        remarks.append(
            f"Taken as a two-stroke cycle, because it covers {angle(cycle)}; a four-stroke cycle has "
            f"{angle(720.0)}."
        )
    if faults:
        raise InputError("\n".join(faults))
    return cut.strokes, replace(single, values=values, remarks=tuple(remarks), faults=())


def _cut(rows: SampleRows, cycles: Mapping[int, float], room: float, step: float) -> _Cut | None:
    """Return where the cycles are, for the first length that the angles cover; None if there is none."""
    angles = rows.angles
    near = PLACE_TOLERANCE * step
    for strokes, cycle in cycles.items():
        span = float(angles[-1] - angles[0])
        count = math.floor((span + room) / cycle)
        if count < 1 or (count > 1 and len(cycles) > 1):
            continue
        starts = [
            int(np.searchsorted(angles, angles[0] + number * cycle - near))
            for number in range(count + 1)
        ]
        # The last whole cycle ends before its closing sample, if there is one, or at the end.
        stop = min(starts[-1], angles.size)
        left = angles.size - stop
        closes = left == 1 and abs(float(angles[stop]) - angles[0] - count * cycle) <= near
        if left > closes and count == 1:
            continue
        ends = [*starts[1:-1], stop]
        parts = tuple(slice(start, end) for start, end in zip(starts, ends, strict=False))
        if count > 1 and min(part.stop - part.start for part in parts) < FEWEST_SAMPLES:
            continue
        if float(angles[0]) + count * cycle - float(angles[stop - 1]) > room:
            continue
        return _Cut(strokes, parts, left - closes, stop if closes else None)
    return None


def _mean_cycle(
    rows: SampleRows, cut: _Cut, cycle: float
) -> tuple[SampleRows, float, list[str], list[str]]:
    """Return the mean of the cycles, the scatter of its first sample, remarks, and faults."""
    first = rows.only(cut.cycles[0])
    count = len(cut.cycles)
    if count == 1:
        return first, 0.0, [], []
    parts = [
        (rows.angles[part] - number * cycle, rows.values[part])
        for number, part in enumerate(cut.cycles)
    ]
    near = PLACE_TOLERANCE * mean_step(first.angles)
    for number, (angles, _) in enumerate(parts[1:], start=2):
        if angles.size != first.angles.size or np.max(np.abs(angles - first.angles)) > near:
            return (
                first,
                0.0,
                [],
                [
                    f"{rows.path}: given {count} cycles, of which cycle {number} has other angles than the "
                    f"first ({angles.size} samples, and {first.angles.size}); allowed are the same angles in "
                    "each, because their mean is taken."
                ],
            )
    values = np.array([values for _, values in parts])
    scatter = np.std(values, axis=0, ddof=1)
    place, size = int(np.argmax(scatter)), float(np.max(np.abs(values.mean(axis=0))))
    if scatter[place] > LARGEST_SCATTER * size:
        return (
            first,
            0.0,
            [],
            [
                f"{rows.path}: given {count} cycles of {cycle:g} deg, which differ by {scatter[place]:.3g} "
                f"{rows.unit} (standard deviation) at {first.angles[place]:g} deg, "
                f"{percent(scatter[place] / size)} % of the largest value; allowed are repetitions of "
                "one cycle, unlike the two revolutions of a four-stroke one."
            ],
        )
    highest = float(np.std(values.max(axis=1), ddof=1))
    remark = (
        f"The mean of {count} cycles is used. They scatter by {scatter[place]:.3g} {rows.unit} at most "
        f"(standard deviation, at {first.angles[place]:g} deg, {percent(scatter[place] / size)} % of the "
        f"largest value); their highest values by {highest:.3g} {rows.unit}."
    )
    return replace(first, values=values.mean(axis=0)), float(scatter[0]), [remark], []


def _without_closing(
    rows: SampleRows, cut: _Cut, single: SampleRows, scatter: float, tolerance: float
) -> tuple[Array, list[str], list[str]]:
    """Return the values of the cycle, what is wrong with its closing sample, and what became of it."""
    values, place = single.values, cut.closing or -1
    first, closing = values[0], rows.values[place]
    size, differs = float(np.max(np.abs(values))), abs(closing - first)
    # The errors' standard deviation, by third differences of the samples.
    thirds = np.diff(np.concatenate([values, values[:3]]), n=3)
    deviation = float(np.median(np.abs(thirds))) / _THIRD
    noise = min(NOISE_WITHIN * deviation, LARGEST_NOISE * size)
    if differs > max(tolerance * size, noise, NOISE_WITHIN * scatter):
        half = "; perhaps it is one revolution of a four-stroke engine" if cut.strokes == 2 else ""
        fault = rows.value_error(
            place,
            f"given {closing:g} for the closing sample; allowed is the {first:g} of line {rows.lines[0]}, "
            f"because the closing sample repeats the first one cycle later{half}",
        )
        return values, [str(fault)], []
    if differs > tolerance * size and len(cut.cycles) == 1:
        remark = (
            f"The closing sample differs from the first by {differs:.3g} {rows.unit}, as noise does; "
            "their mean is used."
        )
        mean = values.copy()
        mean[0] = 0.5 * (first + closing)
        return mean, [], [remark]
    return values, [], [f"The closing sample at {angle(rows.angles[place])} was dropped."]


def _seam(angles: Array, values: Array, cycle: float) -> float:
    """Return the jump of value or slope at the end of a cycle over the largest between samples."""
    closed = np.concatenate([angles, angles[:2] + cycle])
    slopes = np.diff(np.concatenate([values, values[:2]])) / np.diff(closed)
    turns = np.diff(slopes) / np.diff(closed[:-1])
    ratios = []
    # The last slope and the last two turns have the seam in them, besides the first slope again.
    for inside, across in ((slopes[:-2], slopes[-2:-1]), (turns[:-2], turns[-2:])):
        largest = float(np.max(np.abs(inside), initial=0.0))
        ratios.append(float(np.max(np.abs(across))) / largest if largest > 0.0 else 0.0)
    return max(ratios)


def even_count(angles: Array, cycle: float) -> int:
    """Return how many even samples over a cycle [deg] take the place of uneven ones, (m,) angles [deg]."""
    smallest = float(np.min(np.diff(angles, append=angles[0] + cycle)))
    return math.ceil(cycle / min(max(smallest / 2.0, FINEST_STEP), COARSEST_STEP) - 1e-9)
