"""One unit and one number of decimals for a table's numbers, by the largest of them."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from crankbase.tables.output_units import SI, OutputUnit, OutputUnits
from crankbase.tables.table import Column

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
    decimals : int
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
