"""Tables of a throw and of the stresses at its fillets on the command line, from plain records."""

import math

from crankbase.tables.table import SI, Column, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.analyses.throw.stress import mirrored, stress_tables
from crankfem.analyses.throw.throw_record import (
    NOT_CORRECTED,
    loaded_table,
    reaction_table,
    section_sentence,
)
from crankfem.cli.console import print_line, print_notes, print_table
from fem.fillet_peaks import (
    ACROSS_WEB,
    LARGEST_NORMAL,
    LARGEST_SIZE,
    LARGEST_SPREAD,
    LAYERS,
    RULE_LOADS,
)


def print_throw(record: Record, units: OutputUnits = SI) -> None:
    """Print compliances, reactions and masses of a throw, from its record."""
    print_table(loaded_table(record, units), units)
    print_table(reaction_table(record, units), units)
    print_line(
        units.text(
            f"Mass {record['mass']:.4g} kg, center of mass {record['center_of_mass'][1] * 1e3:.4g} mm "
            f"from the shaft axis, inertia about the shaft {record['inertia_about_shaft']:.4g} kg m^2; "
            f"static unbalance {math.hypot(*record['unbalance']['static']):.4g} kg m, dynamic unbalance "
            f"about the middle {math.hypot(*record['unbalance']['dynamic']):.3g} kg m^2."
        )
    )
    met = (
        "" if record["accuracy_met"] else f"; the accuracy of {record['accuracy']:.2g} was not met"
    )
    print_line(
        f"Model: {record['model']}, {record['unknowns']:,} unknowns, solver {record['solver']}{met}."
    )
    if section_sentence(record):
        print_line(section_sentence(record))
    if not record.get("corrected", True):
        print_notes([NOT_CORRECTED], units)


def print_free_modes(modes: list[Record], units: OutputUnits = SI) -> None:
    """Print the natural modes of a free throw."""
    print_table(
        Table.of_records(
            "Natural modes of the free throw",
            [mode | {"number": number} for number, mode in enumerate(modes, start=1)],
            (Column("mode"), "number"),
            (Column("frequency", "Hz", decimals=1), "frequency"),
            (Column("motion of the end sections", words=True), "name"),
        ),
        units,
    )


def print_profile(seconds: dict[str, float]) -> None:
    """Print the time of each step of an analysis."""
    total = sum(seconds.values())
    print_table(
        Table(
            "Time of each step",
            [Column("work", words=True), Column("s", decimals=2), Column("", "%", decimals=0)],
            [[name, s, s / total] for name, s in (seconds | {"all": total}).items()],
        )
    )


def print_shape(record: Record, units: OutputUnits = SI, name: str = "Throw") -> None:
    """Print the quantities that follow from the dimensions."""
    length, volume = units.of("mm"), units.of("dm^3")
    pins = "one pin" if record["pins"] == 1 else f"{record['pins']} pins"
    print_line(
        f"{name} with {pins}: length {length.with_name(record['length'], 5)}, overlap of journal and pin "
        f"{length.with_name(record['overlap'])}, volume {volume.with_name(record['volume'])}; "
        f"{_PARTS[record['solved_part']]}."
    )
    print_notes(record["remarks"], units)


_PARTS = {
    "quarter": "symmetric about two planes, a quarter is solved",
    "half": "symmetric about the crank plane, half of it is solved",
    "full": "without planes of symmetry, all of it is solved",
}


def print_stresses(record: Record, units: OutputUnits = SI) -> None:
    """Print a table for each load, and the remarks."""
    for table in stress_tables(record, units):
        print_table(table, units)
    for sentence in _sentences(record):
        print_line(sentence)


def _up(value: float, decimals: int) -> str:
    """Return a number rounded up, so that a value above its limit never appears to meet it."""
    return f"{math.ceil(round(value * 10**decimals, 6)) / 10**decimals:.{decimals}f}"


def _down(value: float, decimals: int) -> str:
    """Return a number rounded down, so that a value below its limit never appears to meet it."""
    return f"{math.floor(round(value * 10**decimals, 6)) / 10**decimals:.{decimals}f}"


def _rule_sentences(record: Record) -> list[str]:
    """The requirements of UR M53, Appendix III, on mesh and stresses, and the values reached."""
    meshings = record["meshings"]
    layers = [max(one["layers"][k] for one in meshings) for k in range(len(LAYERS))]
    read = [
        fillet["quality"]
        for load in record["loads"]
        if load["kind"] in RULE_LOADS
        for fillet in load["fillets"]
    ]

    def told(found: list[Record]) -> str:
        return "met" if all(one["met"] for one in found) else "not met"

    return [
        f"Mesh of UR M53, Appendix III, {told(meshings)}: largest element of the fillets "
        f"{_up(max(one['size_share'] for one in meshings), 2)} of the radius (allowed {LARGEST_SIZE:g}), "
        f"layers below {', '.join(_up(layer, 1) for layer in layers)} quarters of it (1, 2, 3), "
        f"{_down(min(one['across_web'] for one in meshings), 1)} elements across the web "
        f"({ACROSS_WEB:.0f} or more).",
        "Its criteria where stresses are read under torque, bending in the crank plane and radial force, "
        f"{told(read)}: smallest principal stress up to "
        f"{100.0 * max(one['normal_share'] for one in read):.1f} % of the largest "
        f"(below {100.0 * LARGEST_NORMAL:.0f} %), elements within "
        f"{_up(100.0 * max(one['spread'] for one in read), 1)} % of their mean "
        f"({100.0 * LARGEST_SPREAD:.0f} %).",
    ]


def _sentences(record: Record) -> list[str]:
    """Remarks that the tables do not contain."""
    found = [
        f"Ends pinned, end sections {record['end_sections']}. Principal: the largest in magnitude, at the "
        "location given; Mises: the largest equivalent stress by von Mises; factor: size of the principal "
        "stress divided by the nominal one, which is a shear stress under a torque; M53: the factor as UR "
        "M53 defines it, at fillets by the largest shear stress under a torque, by von Mises in bending."
    ]
    if mirrored(record):
        found.append(
            "The fillets at the right web have the same stresses, under a torque with the opposite sign."
        )
    if record["solved_part"] != "full":
        found.append(
            "Locations at -x have the same stresses, under a torque and bending across the crank plane "
            "with the opposite sign."
        )
    if record["sharp_corners"]:
        found.append(
            f"No stress is given at {'; '.join(record['sharp_corners'])}: without a fillet the elastic "
            "stress has no bound."
        )
    if any(load.get("oil_holes") for load in record["loads"]):
        found.append(
            "The exit of an oil hole is its rim and the hole to a depth of one diameter; nominal: the stress "
            "of the pin or main journal without the hole, on its extreme fiber, wherever the hole points."
        )
    if record.get("mesh") == "m53":
        found += _rule_sentences(record)
    errors = [
        peak["error_estimate"]
        for load in record["loads"]
        for peak in (*load["fillets"], *load.get("oil_holes", ()))
    ]
    met = (
        "" if record["accuracy_met"] else f", not the {100.0 * record['accuracy']:.2g} % requested"
    )
    found.append(
        f"Estimated errors of the stresses: {100.0 * min(errors):.2g} to {100.0 * max(errors):.2g} %{met}."
    )
    found += [f"{file} written." for file in record["pictures"]]
    return found
