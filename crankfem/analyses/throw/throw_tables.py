"""The tables of a throw, from its plain record."""

from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Column, Table
from crankfem.analyses.record import Record

# Of a throw on its supports, in the order of the columns.
ANSWERS = (
    "axial_compliance",
    "torsional_compliance",
    "influence_coefficient",
    "axial_force_per_radial",
)


def support_table(record: Record) -> Table:
    """Return the compliances of a throw by support of its end sections."""
    return Table(
        f"Throw by finite elements (error of e_n about {100.0 * record['error_estimate']:.2g} %)",
        [
            Column("support", words=True),
            Column("e_n", "1e-9 m/N"),
            Column("torsional", "1e-9 rad/(N m)"),
            Column("c", "1e-9 m/N"),
            Column("P/Z"),
        ],
        [[name, *(answer[key] for key in ANSWERS)] for name, answer in record["supports"].items()],
    )


def reaction_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return what the ends of a throw take of a radial force on its pin."""
    return Table(
        f"Reactions to a radial force of {units.of('kN').with_name(record['radial_force'])} on the "
        "pin, length kept",
        [
            Column("support", words=True),
            Column("end", words=True),
            Column("force x y z", "kN", decimals=3, joint="  "),
            Column("moment x y z", "kN m", decimals=3, joint="  "),
        ],
        [
            [name, side, reaction["force"], reaction["moment"]]
            for name, s in record["supports"].items()
            for side, reaction in s["reactions"].items()
        ],
    )
