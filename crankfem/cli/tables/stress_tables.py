"""What the command line prints of the stresses at a throw's fillets."""

from crankbase.tables.output_units import SI, OutputUnits
from crankfem.analyses.record import Record
from crankfem.analyses.throw.stress import mirrored, stress_tables
from crankfem.cli.console import print_line, print_table


def print_stresses(record: Record, units: OutputUnits = SI) -> None:
    """Print a table for each load, and what there is to say besides."""
    for table in stress_tables(record, units):
        print_table(table, units)
    for sentence in _sentences(record):
        print_line(sentence)


def _sentences(record: Record) -> list[str]:
    """What the tables leave unsaid."""
    found = [
        f"Ends pinned, end sections {record['end_sections']}. Principal: that of the largest magnitude, "
        "at the place given; factor: its size divided by the nominal stress, under a torque a shear "
        "stress."
    ]
    if mirrored(record):
        found.append(
            "The fillets at the right web have the same stresses, under a torque with the opposite sign."
        )
    if record["solved_part"] != "full":
        found.append(
            "Places at -x have the same stresses, under a torque and bending across the crank plane "
            "with the opposite sign."
        )
    if record["sharp_corners"]:
        found.append(
            f"No stress is given at {'; '.join(record['sharp_corners'])}: without a fillet the elastic "
            "stress has no bound."
        )
    errors = [peak["error_estimate"] for load in record["loads"] for peak in load["fillets"]]
    met = (
        "" if record["accuracy_met"] else f", not the {100.0 * record['accuracy']:.2g} % asked for"
    )
    found.append(
        f"Estimated errors of the stresses: {100.0 * min(errors):.2g} to {100.0 * max(errors):.2g} %{met}."
    )
    found += [f"{file} written." for file in record["pictures"]]
    return found
