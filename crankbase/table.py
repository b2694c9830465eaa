"""Tables: columns with names, units and digits over rows of plain SI values.

An analysis describes its results once, as a table; the console, the report and files write it, each in
its own format and in the chosen units.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Self, TypeAlias

from crankbase.errors import InputError
from crankbase.quantity import (
    DISPLAY_UNITS,
    POWER_OF_TEN,
    UNBOUNDED,
    UNITS,
    WRITTEN_OUT,
    format_quantity,
    percent,
    without_noise,
    without_round_off,
)
from crankbase.sentences import written
from crankbase.units import Kind, NoUnitError, kind_of, kind_of_si, unit_quantity

SYSTEMS = {"si": "", "imperial": "in, lbf, ksi, lb, hp"}
# A user who reads angles in degrees does not mean speeds in degrees per second.
NEVER_APART = ("rad/s",)
# From 1e5 times 1e-9, a compliance in large units is written without a power of ten, as 0.0025 mm/kN.
WITHOUT_POWER = 1e5


@dataclass(frozen=True)
class OutputUnit:
    """A unit in which a column is printed.

    Attributes
    ----------
    name : str
        As in the table head.
    size : float
        Of the unit, in SI.
    wished : bool
        Whether the user requested it.
    replaced : float
        Size of the unit that it replaces; its own if there is none.
    si : str
        Its SI unit, if the unit is one of `UNITS` or replaces it.
    """

    name: str
    size: float
    wished: bool = False
    replaced: float = 1.0
    si: str = ""

    def number(self, value: float | None, digits: int = 4) -> str:
        """Write an SI number in this unit, without it; "unbounded" for None."""
        if value is None:
            return UNBOUNDED
        value = without_round_off(value, self.si)
        if self.name == "%":
            return percent(value, digits)
        text = f"{without_noise(value / self.size):.{digits}g}"
        if "e+" in text and abs(float(text)) < WRITTEN_OUT:
            return f"{float(text):.0f}"
        return text.replace("e+0", "e").replace("e+", "e")

    def fixed(self, value: float, decimals: int) -> str:
        """Write an SI number with a number of decimals of the SI unit; in another at least as finely."""
        if self.wished:
            finest = self.replaced * 10.0**-decimals / self.size
            decimals = max(0, math.ceil(-math.log10(finest)))
        # Adding zero turns a negative zero into zero.
        return f"{round(value / self.size, decimals) + 0.0:.{decimals}f}"

    def with_name(self, value: float | None, digits: int = 4) -> str:
        """Write an SI number with the unit."""
        text = self.number(value, digits)
        if value is None:
            return text
        if self.name.startswith(POWER_OF_TEN):
            name = self.name.removeprefix(POWER_OF_TEN)
            if self.wished and abs(value) >= WITHOUT_POWER * self.size:
                return f"{value / (1e9 * self.size):.{digits}g} {name}"
            return f"{text}e-9 {name}"
        return f"{text} {self.name}"


@dataclass(frozen=True)
class OutputUnits:
    """The units chosen by the user; SI for all others.

    Parameters
    ----------
    wished : tuple of (kind, name, size)
        From `parse_output_units`.

    Examples
    --------
    >>> SI.of("kN m").number(30730.0)
    '30.73'
    >>> units = parse_output_units("in, lbf")
    >>> units.of("1e-9 m/N").name, units.of("1e-9 m/N").number(1.27e-9)
    ('1e-9 in/lbf', '222.4')
    >>> from crankbase.sentences import amount
    >>> units.written(f"{amount(0.27, 'm')} of the 500 mm series")
    '10.6 in of the 500 mm series'
    """

    wished: tuple[tuple[Kind, str, float], ...] = ()

    def of(self, printed: str) -> OutputUnit:
        """Return the unit that replaces one of `UNITS`, or a power of ten of it."""
        power = POWER_OF_TEN if printed.startswith(POWER_OF_TEN) else ""
        unit, size = UNITS[printed.removeprefix(POWER_OF_TEN)]
        unit_in_use = self._converted(unit)
        if unit_in_use is None:
            return OutputUnit(printed, size * (1e-9 if power else 1.0), si=unit)
        scale = 1e-9 if power else 1.0
        return OutputUnit(power + unit_in_use[0], unit_in_use[1] * scale, True, size * scale, unit)

    def quantity(self, value: float, unit: str, digits: int = 6) -> str:
        """Write a number in the SI unit `unit` with its display unit."""
        if not self.wished or not unit or self._converted(unit) is None:
            return format_quantity(value, unit, digits)
        shown = DISPLAY_UNITS.get(unit, (unit, 1.0))[0]
        return self.of(shown).with_name(value, digits)

    def written(self, text: str, most: int | None = None, *, full: bool = False) -> str:
        """Return a text with its values in these units, with so many digits at most; see `Amount.text`."""
        return written(text, lambda value: value.text(self, most, full=full))

    def _converted(self, unit: str) -> tuple[str, float] | None:
        """Return name and size of the unit that replaces an SI one: as a whole, else by its factors."""
        if not self.wished:
            return None
        whole = self._requested(unit)
        if whole is not None or unit in NEVER_APART:
            return whole
        size, names, changed = 1.0, [], False
        for factor, power in _factors(unit):
            requested = self._requested(factor)
            changed = changed or requested is not None
            name, factor_size = (factor, 1.0) if requested is None else requested
            names.append((f"({name})" if re.search(r"[ /]", name) else name, power))
            size *= factor_size**power
        if not changed:
            return None
        above = [_power(name, power) for name, power in names if power > 0]
        below = [_power(name, -power) for name, power in names if power < 0]
        if not below:
            return " ".join(above), size
        under = below[0] if len(below) == 1 else f"({' '.join(below)})"
        return f"{' '.join(above) or '1'}/{under}", size

    def _requested(self, unit: str) -> tuple[str, float] | None:
        kind = kind_of_si(unit)
        for wished_kind, name, size in self.wished:
            # One word for the unit of energy, such as J, is no unit of torque.
            if wished_kind == kind and not (unit == "N m" and re.fullmatch(r"\w+", name)):
                return name, size
        return None


SI = OutputUnits()


def parse_output_units(text: str | None) -> OutputUnits:
    """Read the list of --units: units with commas between them, "imperial", or "SI".

    Raises
    ------
    InputError
        If one is not a unit, is of a kind that is never printed, or two are of one kind.
    """
    if text is None:
        return SI
    listed = SYSTEMS.get(text.strip().casefold(), text)
    wished: list[tuple[Kind, str, float]] = []
    for name in (part.strip() for part in listed.split(",")):
        if not name and listed == SYSTEMS["si"]:
            continue
        try:
            if not name or re.match(r"\d", name.removeprefix("1/")):
                raise NoUnitError("a number or nothing")
            quantity = unit_quantity(name)
        except NoUnitError as error:
            no_unit = f"; {error.cure}" if error.cure else ", which is no unit"
            raise InputError(
                f"--units: given {name!r}{no_unit}; allowed are units with commas between them, like "
                '"in, lbf, ksi", or one of imperial and SI.'
            ) from None
        kind, shifted = kind_of(quantity), not quantity._is_multiplicative
        if shifted or kind not in _printed_kinds():
            raise InputError(
                f"--units: given {name!r}, of a kind that is never printed; allowed are units of length, "
                "force, torque, stress, mass, inertia, compliance, angle, speed, frequency, power, energy "
                "and time."
            )
        size = float(quantity.to_base_units().magnitude)
        for other_kind, other, _ in wished:
            if other_kind == kind:
                raise InputError(
                    f"--units: given {other!r} and {name!r}, which are units of one kind; allowed is one "
                    "of them, because a number is printed once."
                )
        wished.append((kind, name, size))
    return OutputUnits(tuple(wished))


@cache
def _printed_kinds() -> frozenset[Kind]:
    units = {unit for unit, _ in UNITS.values()}
    factors = {factor for unit in units for factor, _ in _factors(unit)}
    return frozenset(kind_of_si(unit) for unit in units | factors)


def _factors(unit: str) -> list[tuple[str, int]]:
    """Split a unit: "rad/(N m)" into rad, N and m with their powers."""
    above, _, below = unit.partition("/")
    factors = []
    for part, sign in ((above, 1), (below.strip("()"), -1)):
        for factor in part.split():
            name, _, power = factor.partition("^")
            factors.append((name, sign * int(power or 1)))
    return factors


def _power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"


# A value in SI, words as they are, values beside each other, or None where there is no value.
Cell: TypeAlias = float | int | str | Sequence[float] | None

PERCENT = OutputUnit("%", 0.01)
NO_UNIT = OutputUnit("", 1.0)


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    name : str
        Without the unit; empty if the unit is sufficient.
    unit : str or OutputUnit
        Unit of the printed values, such as "kN", unless the user chooses another; "%" for shares; an
        `OutputUnit` is used unchanged.
    digits : int or None
        Significant digits of a value; whole numbers have all of theirs. None for given numbers,
        such as orders, which get no zeros at their end.
    decimals : int or None
        Decimals instead of digits.
    words : bool
        Whether the column is left-aligned.
    joint : str
        Separator of values in one cell.
    missing : str
        Text for None and NaN.
    bare : bool
        Whether the head leaves the unit out, because a neighbor has it.

    Examples
    --------
    >>> column = Column("force", "kN")
    >>> column.head(), column.text(12345.6), column.text(None)
    ('force [kN]', '12.35', 'none')
    """

    name: str
    unit: str | OutputUnit = ""
    digits: int | None = 4
    decimals: int | None = None
    words: bool = field(default=False, kw_only=True)
    joint: str = field(default=", ", kw_only=True)
    missing: str = field(default="none", kw_only=True)
    bare: bool = field(default=False, kw_only=True)

    def display_unit(self, units: OutputUnits = SI) -> OutputUnit:
        """Return the unit in which values are printed."""
        if isinstance(self.unit, OutputUnit):
            return self.unit
        return {"": NO_UNIT, "%": PERCENT}.get(self.unit) or units.of(self.unit)

    def head(self, units: OutputUnits = SI) -> str:
        """Return name and unit."""
        unit = "" if self.bare else self.display_unit(units).name
        return f"{self.name} [{unit}]" if self.name and unit else self.name or unit

    def text(
        self, cell: Cell, units: OutputUnits = SI, write: Callable[[float, int], str] | None = None
    ) -> str:
        """Write a cell without the unit, or that it is unbounded; `write` formats a number with its digits.

        If `write` needs fewer decimals than the column has, it writes the number, so that it is
        rounded once.
        """
        if isinstance(cell, str):
            return cell
        if cell is None or (isinstance(cell, float) and math.isnan(cell)):
            return self.missing
        if isinstance(cell, float) and math.isinf(cell):
            return UNBOUNDED
        if isinstance(cell, Sequence):
            return self.joint.join(self.text(value, units, write) for value in cell)
        unit = self.display_unit(units)
        if self.decimals is not None:
            text = unit.fixed(cell, self.decimals)
            if write is None or float(text) == 0.0:
                return text
            shorter = write(cell / unit.size, self.digits or 6)
            return shorter if _decimals(shorter) < _decimals(text) else text
        if isinstance(cell, int) and unit is NO_UNIT:
            return str(cell)
        if self.digits is None:
            return unit.number(cell, 6)
        return (
            unit.number(cell, self.digits)
            if write is None
            else write(cell / unit.size, self.digits)
        )


def _decimals(text: str) -> int:
    return len(text.partition(".")[2])


@dataclass(frozen=True)
class Table:
    """Rows of values below columns.

    Parameters
    ----------
    rows : sequence of sequences of cells
        A cell for each column.
    note : str
        Note below the table.
    marks : sequence of str
        Class of each row, such as "over" a limit; empty if no row is marked.
    merged : bool
        Whether rows that differ only in the first column are combined.
    main : bool
        Whether the table is among the main results, which a console shows first.
    weights : sequence of float
        How important each row is where there is no room for all; empty if the first rows are.
    """

    title: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    note: str = ""
    marks: Sequence[str] = ()
    merged: bool = False
    main: bool = False
    weights: Sequence[float] = ()

    @classmethod
    def of_records(
        cls,
        title: str,
        records: Iterable[Any],
        *columns: tuple[Column, str | Callable[[Any], Cell]],
        note: str = "",
        mark: Callable[[Any], str] | None = None,
        weight: Callable[[Any], float] | None = None,
        main: bool = False,
    ) -> Self:
        """Return a table with a row for each record.

        Parameters
        ----------
        *columns : tuple of (Column, str or callable)
            Each with the key (of results the field) of its cells in the records, or a function that
            makes a cell of a record.
        mark : callable, optional
            Gives the mark of a record's row.
        weight : callable, optional
            Gives its weight.
        """
        records = list(records)
        rows = [[_cell(record, cell) for _, cell in columns] for record in records]
        marks = [mark(record) for record in records] if mark else ()
        weights = [weight(record) for record in records] if weight else ()
        heads = [column for column, _ in columns]
        return cls(title, heads, rows, note, marks, main=main, weights=weights)

    @classmethod
    def of_columns(
        cls,
        title: str,
        *columns: tuple[Column, Iterable[Any]],
        note: str = "",
        marks: Sequence[str] = (),
        main: bool = False,
    ) -> Self:
        """Return a table of columns, each with its cells: words, numbers, or an array."""
        cells = [
            [cell.item() if hasattr(cell, "item") else cell for cell in cells]
            for _, cells in columns
        ]
        rows = list(zip(*cells, strict=True))
        return cls(title, [column for column, _ in columns], rows, note, marks, main=main)

    def texts(
        self, units: OutputUnits = SI, write: Callable[[float, int], str] | None = None
    ) -> list[list[str]]:
        """Return the rows as they are written."""
        rows = [
            [
                column.text(cell, units, write)
                for column, cell in zip(self.columns, row, strict=True)
            ]
            for row in self.rows
        ]
        return merged_rows(rows) if self.merged else rows

    def combined(self, units: OutputUnits = SI) -> "Table":
        """Return the table of the rows as they are written, if some are combined."""
        if not self.merged:
            return self
        texts = [replace(self, rows=[row], merged=False).texts(units)[0][1:] for row in self.rows]
        places = [place for place, text in enumerate(texts) if text not in texts[:place]]
        weights = [self.weights[place] for place in places] if self.weights else ()
        return replace(self, rows=self.texts(units), merged=False, weights=weights)

    def select(self, *names: str) -> "Table":
        """Select columns by their names, in this order, and return their table."""
        places = [[column.name for column in self.columns].index(name) for name in names]
        return replace(
            self,
            columns=[self.columns[place] for place in places],
            rows=[[row[place] for place in places] for row in self.rows],
        )

    def heaviest(self, count: int) -> "Table":
        """Return the table of so many rows, the most important ones, in their order."""
        weights = self.weights or range(len(self.rows), 0, -1)
        places = sorted(sorted(range(len(self.rows)), key=lambda place: -weights[place])[:count])

        def kept(each: Sequence[Any]) -> list[Any]:
            return [each[place] for place in places] if each else []

        return replace(
            self, rows=kept(self.rows), marks=kept(self.marks), weights=kept(self.weights)
        )


class Main(str):
    """A paragraph that belongs to the main results, as a table that is `Table.main`.

    Parameters
    ----------
    *sentences : str
        Of which the first leads, and stands alone where there is little room.

    Examples
    --------
    >>> Main("Fine to 515 1/min.", "No critical speed is near.").lead
    'Fine to 515 1/min.'
    """

    __slots__ = ("first",)
    first: str

    def __new__(cls, *sentences: str) -> Self:
        """Join sentences to a paragraph."""
        made = super().__new__(cls, " ".join(sentences))
        made.first = sentences[0]
        return made

    @property
    def lead(self) -> "Main":
        """The first sentence."""
        return Main(self.first)


class MainWarning(Main):
    """A warning among the main results, which is never shortened."""

    __slots__ = ()

    def __new__(cls, warning: str) -> Self:
        """Write a warning."""
        return super().__new__(cls, f"Warning: {warning}")

    @property
    def lead(self) -> Main:
        """All of it."""
        return self


def _cell(record: Any, cell: str | Callable[[Any], Cell]) -> Cell:
    if not isinstance(cell, str):
        return cell(record)
    content: Cell = record[cell] if isinstance(record, Mapping) else getattr(record, cell)
    return content


def merged_rows(rows: list[list[str]]) -> list[list[str]]:
    """Combine rows that differ in the first column only, such as "1, 3" or "1 to 6"."""
    merged: dict[tuple[str, ...], list[str]] = {}
    for first, *rest in rows:
        merged.setdefault(tuple(rest), []).append(first)
    return [[format_names(names), *rest] for rest, names in merged.items()]


def format_names(names: list[str]) -> str:
    """Format a list of names, consecutive numbers as "1 to 6"."""
    numbers = [int(name) for name in names if name.isdigit()]
    if len(numbers) == len(names) > 2 and numbers == [*range(numbers[0], numbers[0] + len(names))]:
        return f"{names[0]} to {names[-1]}"
    return ", ".join(names)


# From here on a table is written in the thousandfold unit.
KILO_FROM = 1e4
DIGITS, MOST_DECIMALS = 5, 4


@dataclass(frozen=True)
class TableUnit:
    """Format of the numbers of a table.

    Parameters
    ----------
    name : str
        Of the unit.
    size : float
        Of the unit, in the unit of the numbers.
    """

    name: str
    size: float
    decimals: int

    def column(self, name: str, *, bare: bool = False) -> Column:
        """Return a column of numbers in this unit."""
        return Column(name, OutputUnit(self.name, self.size), decimals=self.decimals, bare=bare)

    def text(self, value: float) -> str:
        """Write a number without its unit."""
        return OutputUnit(self.name, self.size).fixed(value, self.decimals)

    def with_unit(self, value: float) -> str:
        """Write a number with its unit."""
        return f"{self.text(value)} {self.name}"


def table_unit(values: Iterable[float], unit: str, units: OutputUnits = SI) -> TableUnit:
    """Find a unit in which the largest number has five digits, with aligned decimals.

    Parameters
    ----------
    values : iterable of float
        In `unit`.
    unit : str
        For example "N m"; large numbers get "kN m".
    units : OutputUnits
        The user's choice; such a unit is used unchanged, without a thousandfold.

    Examples
    --------
    >>> table_unit([378987.89, -44306.35], "N m").with_unit(-44306.35)
    '-44.31 kN m'
    >>> table_unit([279.68], "N m").with_unit(279.68)
    '279.68 N m'
    """
    largest = max((abs(value) for value in values), default=0.0)
    name, size = (f"k{unit}", 1e3) if largest >= KILO_FROM else (unit, 1.0)
    shown = units.of(unit)
    if shown.wished:
        name, size = shown.name, shown.size
    before = math.floor(math.log10(largest / size)) + 1 if largest > 0.0 else 1
    return TableUnit(name, size, min(max(DIGITS - before, 0), MOST_DECIMALS))


def text_rows(text: str) -> list[list[str]]:
    r"""Return the cells of a table in a text: a row a line, with bars between its cells.

    Examples
    --------
    >>> text_rows("mass | kg | 2\nlength | m | 0.3")
    [['mass', 'kg', '2'], ['length', 'm', '0.3']]
    """
    return [[cell.strip() for cell in row.split("|")] for row in text.strip().splitlines()]
