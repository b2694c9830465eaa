"""Tables of a crank mechanism on the command line: forces, balance, harmonics, rods of two masses."""

from crankbase.quantity import RPM
from crankbase.table import SI, OutputUnits
from crankfem.analyses.mechanism.balance_records import (
    BALANCED_TEXT,
    balance_contents,
    balance_table,
    hinged_rod_table,
    moving_mass_table,
    throw_mass_table,
)
from crankfem.analyses.mechanism.mechanism_records import (
    acceleration_sentences,
    acceleration_table,
)
from crankfem.analyses.mechanism.rod_models import (
    bearing_table,
    crankpin_table,
    cylinder_table,
    model_difference_sentence,
    model_difference_table,
    rod_mass_table,
    rod_model_table,
)
from crankfem.analyses.record import ASSUMED, Record
from crankfem.cli.console import print_line, print_table
from crankfem.cli.tables.throw_tables import intervals_text


def print_mechanism(record: Record, units: OutputUnits = SI) -> None:
    """Print the record of a mechanism as tables."""
    torque, moment = record["torque"], units.of("kN m")
    print_line(
        f"{record['engine']} at {units.of('1/min').with_name(record['speed_rpm'] / RPM, 5)}, rods as "
        f"{record['rod_model']}: indicated power {units.of('kW').with_name(record['power'])}, mean indicated "
        f"pressure {units.of('MPa').with_name(record['mean_indicated_pressure'])}, torque "
        f"{moment.with_name(torque['mean'])} ({moment.number(torque['smallest'])} to "
        f"{moment.with_name(torque['largest'])}); {intervals_text(record['firing_intervals_deg'], units)}."
    )
    rated = record["rated"]
    if rated is not None and rated.rated is not None:
        sentence = rated.sentence
        print_line(units.text(f"{sentence[0].upper()}{sentence[1:]}."))
    for make in (cylinder_table, crankpin_table, bearing_table, rod_model_table):
        table = make(record)
        if table is not None:
            print_table(table, units)
    print_line(
        "Check: the work of the torque differs from the indicated work, the integral of p dV, by "
        f"{abs(record['energy_error']):.1e} of the work exchanged."
    )
    for remark in record["remarks"]:  # assumed values of the cycle are in the list of assumptions
        if not remark.startswith(ASSUMED):
            print_line(units.text(f"Note: {remark.rstrip('.')}."))
    if record["assumed"]:
        print_line(
            f"Assumed, not given ({len(record['assumed'])} values; crankfem check lists them with their "
            "reasons): " + ", ".join(entry["field"] for entry in record["assumed"]) + "."
        )


def print_rod_models(record: Record, units: OutputUnits = SI) -> None:
    """Print the equivalent masses of the rods, and the load by two models, if there are two."""
    print_table(rod_mass_table(record["rod_masses"]), units)
    difference = record["model_difference"]
    if difference is not None:
        table = model_difference_table(difference)
        if table is not None:
            print_table(table, units)
        print_line(model_difference_sentence(difference, units))


def print_balanced_masses(record: Record, units: OutputUnits = SI) -> None:
    """Print which masses are in the balance of a `mechanism_balance_record`."""
    for make in (moving_mass_table, throw_mass_table):
        print_table(make(record), units)
    print_line(balance_contents(record, units))


def print_balance(record: Record, units: OutputUnits = SI) -> None:
    """Print the tables of forces and moments of `balance_record`."""
    for kind in ("force", "moment"):
        print_table(balance_table(record, kind, units), units)
    print_line(
        f'"{BALANCED_TEXT}": less than 1e-12 of all masses times R w^2. Axis of the largest value: from '
        "the vertical, in the sense of rotation."
    )


def print_hinged_rods(
    records: list[Record], accelerations: Record, units: OutputUnits = SI
) -> None:
    """Print the tables of `hinged_rods_record` and `acceleration_record`."""
    print_table(hinged_rod_table(records), units)
    print_table(acceleration_table(accelerations, units), units)
    for sentence in acceleration_sentences(accelerations, units):
        print_line(sentence)
