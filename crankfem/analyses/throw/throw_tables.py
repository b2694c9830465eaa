"""The tables of a throw, from its plain record."""

from dataclasses import replace

from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Column, Table
from crankbase.units.number_formats import percent
from crankfem.analyses.record import Record

# Of a throw on its supports, in the order of the columns.
ANSWERS = (
    "axial_compliance",
    "torsional_compliance",
    "influence_coefficient",
    "axial_force_per_radial",
)


def error_words(record: Record) -> str:
    """State the error of the axial compliance of a `throw_record`."""
    error = f"{percent(record['error_estimate'])} %"
    # Compliances of older versions were not corrected for discretization.
    return f"within {error}" if record.get("axial_correction") else f"too small by about {error}"


def support_table(record: Record) -> Table:
    """Return the compliances of a throw by support of its end sections."""
    return Table(
        f"Throw by finite elements (e_n {error_words(record)})",
        [
            Column("support", words=True),
            Column("e_n", "1e-9 m/N"),
            Column("torsional", "1e-9 rad/(N m)"),
            Column("c", "1e-9 m/N"),
            Column("P/Z"),
        ],
        [[name, *(answer[key] for key in ANSWERS)] for name, answer in record["supports"].items()],
    )


def section_sentence(record: Record) -> str:
    """State the effect of rigid sections on the axial compliance of a `throw_record`; empty if unknown."""
    shares = [
        f"{percent(own['section_errors']['axial_compliance'] / own['axial_compliance'])} % of e_n {name}"
        for name, own in record["supports"].items()
        if own.get("section_errors")
    ]
    if not shares:
        return ""
    return (
        f"Pinned and guided ends are rigid sections here, which omits {' and '.join(shares)}: the throw is "
        f"softer by this much between equal throws, with sections that bend (degree {record['sections']})."
    )


def loaded_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the compliances of a throw with the axial force P due to the force on its pin."""
    table = support_table(record)
    return replace(
        table,
        columns=[*table.columns, Column("P", "kN")],
        rows=[
            [*row, own["axial_force"]]
            for row, own in zip(table.rows, record["supports"].values(), strict=True)
        ],
        note=f"P: axial force at the right end that keeps the length under {pin_force_words(record, units)}.",
    )


def pin_force_words(record: Record, units: OutputUnits = SI) -> str:
    """State which force acts on the pin of a `throw_record`."""
    unit = units.of("kN")
    # Records of older versions know radial forces only.
    x, y, z = record.get("pin_force", (0.0, -record["radial_force"], 0.0))
    own = record.get("dimensions", {})
    several = own.get("further_pins") or len(own.get("pins", ())) > 1
    pin = "the first pin" if several else "the pin"
    if x == z == 0.0 and y <= 0.0:
        return f"a radial force of {unit.with_name(-y)} on {pin}"
    shown = ", ".join(unit.number(value) for value in (x, y, z))
    return f"a force of {shown} {unit.name} (x, y, z) on {pin}"


def reaction_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the reactions of the ends of a throw to a radial force on its pin."""
    return Table(
        f"Reactions to {pin_force_words(record, units)}, length kept",
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
