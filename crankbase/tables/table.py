"""Tables: columns with names, units and digits over rows of plain SI values.

An analysis describes its results once, as a table; the console, the report and files write it, each in
its own format and in the chosen units.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self, TypeAlias

from crankbase.tables.output_units import SI, OutputUnit, OutputUnits

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
        Text for None.
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
        """Write a cell without the unit; `write` formats a number with its digits.

        If `write` needs fewer decimals than the column has, it writes the number, so that it is
        rounded once.
        """
        if isinstance(cell, str):
            return cell
        if cell is None:
            return self.missing
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
    title : str
    columns : sequence of Column
    rows : sequence of sequences of cells
        A cell for each column.
    note : str
        Note below the table.
    marks : sequence of str
        Class of each row, such as "over" a limit; empty if no row is marked.
    merged : bool
        Whether rows that differ only in the first column are combined.
    """

    title: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    note: str = ""
    marks: Sequence[str] = ()
    merged: bool = False

    @classmethod
    def of_records(
        cls,
        title: str,
        records: Iterable[Any],
        *columns: tuple[Column, str | Callable[[Any], Cell]],
        note: str = "",
    ) -> Self:
        """Return a table with a row for each record.

        Parameters
        ----------
        title, note : str
        records : iterable
        *columns : tuple of (Column, str or callable)
            Each with the key of its cells in the records, or a function that makes a cell of a record.
        """
        rows = [
            [record[cell] if isinstance(cell, str) else cell(record) for _, cell in columns]
            for record in records
        ]
        return cls(title, [column for column, _ in columns], rows, note)

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

    def select(self, *names: str) -> "Table":
        """Select columns by their names, in this order, and return their table."""
        places = [[column.name for column in self.columns].index(name) for name in names]
        return replace(
            self,
            columns=[self.columns[place] for place in places],
            rows=[[row[place] for place in places] for row in self.rows],
        )


def merged_rows(rows: list[list[str]]) -> list[list[str]]:
    """Combine rows that differ in the first column only, such as "1, 3" or "1 to 6"."""
    found: dict[tuple[str, ...], list[str]] = {}
    for first, *rest in rows:
        found.setdefault(tuple(rest), []).append(first)
    return [[format_names(names), *rest] for rest, names in found.items()]


def format_names(names: list[str]) -> str:
    """Format a list of names, consecutive numbers as "1 to 6"."""
    numbers = [int(name) for name in names if name.isdigit()]
    if len(numbers) == len(names) > 2 and numbers == [*range(numbers[0], numbers[0] + len(names))]:
        return f"{names[0]} to {names[-1]}"
    return ", ".join(names)
