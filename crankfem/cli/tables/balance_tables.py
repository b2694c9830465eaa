"""What the command line prints of an engine's balance."""

from crankbase.tables.output_units import SI, OutputUnits
from crankfem.analyses.mechanism.balance_records import (
    BALANCED_TEXT,
    balance_table,
    hinged_rod_table,
)
from crankfem.analyses.record import Record
from crankfem.cli.console import print_line, print_table


def print_balance(record: Record, units: OutputUnits = SI) -> None:
    """Print the tables of forces and moments of `balance_record`."""
    for kind in ("force", "moment"):
        print_table(balance_table(record, kind, units), units)
    print_line(
        f'"{BALANCED_TEXT}": less than 1e-12 of all masses times R w^2. Axis of the largest value: from '
        "the vertical, in the sense of rotation."
    )


def print_hinged_rods(records: list[Record], units: OutputUnits = SI) -> None:
    """Print the table of `hinged_rods_record`."""
    print_table(hinged_rod_table(records), units)
