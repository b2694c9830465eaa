"""The tables of `crankfem check`, from its record."""

import math
from collections.abc import Sequence

from crankbase.tables.table import SI, Column, OutputUnit, OutputUnits, Table
from crankbase.units.units import RPM
from crankfem.analyses.record import Record
from crankfem.analyses.throw.law_record import law_sentence
from crankfem.cli.console import print_line, print_notes, print_table
from crankfem.cli.tables.throw_tables import print_shape
from dynamics.engine.firing import repeating_intervals

KINDS = {
    "engine": "It describes a whole engine",
    "mechanism": "It describes cranks, rods and pistons, not a whole engine",
    "throw": "It describes a throw, not an engine",
    "hinge": "It describes an elastic hinge",
    "chain": "It describes a chain of inertias and springs",
}


def print_check(record: Record, units: OutputUnits = SI) -> None:
    """Print how a file is understood."""
    inputs = record["inputs"]
    assumed = sum(one["assumed"] for one in inputs)
    verb = "is" if assumed == 1 else "are"
    counted = f"; {assumed} of {len(inputs)} values {verb} assumed" if inputs else ""
    warnings = record["warnings"]
    warned = f"; {len(warnings)} warning{'s' if len(warnings) > 1 else ''}" if warnings else ""
    print_line(f"{record['file']}: valid {record['kind']} file{counted}{warned}.")
    for warning in warnings:
        print_line(units.text(f"Warning: {warning.rstrip('.')}."))
    print_line(f"{KINDS[record['kind']]}; use it with: {', '.join(record['commands'])}.")
    print_line(f"Sections: {', '.join(record['sections'])}.")
    if record["arrangement"] is not None:
        _print_arrangement(record["engine"], record["arrangement"], units)
    for name, own in record.get("throws", {}).items():
        print_shape(own["shape"], units, f"Throw {name}")
        print_line(law_sentence(own["law"], units))
        _print_dimensions(own["dimensions"], units, f"The throw {name} as understood")
    if record["shape"] is not None and "throws" not in record:
        print_shape(record["shape"], units)
        print_line(law_sentence(record["law"], units))
        _print_dimensions(record["dimensions"], units)
    print_notes((f"{remark.rstrip('.')}." for remark in record["remarks"]), units)
    print_table(
        Table.of_records(
            "Inputs",
            inputs,
            (Column("field", words=True), "field"),
            (Column("value", words=True), "given"),
            (Column("assumed", words=True), lambda one: "yes" if one["assumed"] else ""),
            (Column("source", words=True), "source"),
        )
    )


def _print_arrangement(name: str, engine: Record, units: OutputUnits) -> None:
    length, speed = units.of("mm"), units.of("1/min")
    digits = _digits(length)
    kind = "in line" if engine["bank_angles_deg"] is None else "in banks"
    speeds = [
        speed.number(engine[f"{which}_speed_rpm"] / RPM, 6)
        for which in ("lowest", "highest", "rated")
    ]
    print_line(
        f"{name}: {_cylinders(engine['cylinders'])} {kind}, {engine['strokes']}-stroke, bore x stroke "
        f"{length.number(engine['bore'], digits)} x {length.number(engine['stroke'], digits)} "
        f"{length.name}; runs from "
        f"{speeds[0]} to {speeds[1]} {speed.name}, rated speed {speeds[2]} {speed.name} (mean piston "
        f"speed {units.of('m/s').with_name(engine['mean_piston_speed'], 3)}); firing order "
        f"{'-'.join(map(str, engine['firing_order']))}, "
        f"{intervals_text(engine['firing_intervals_deg'], units)}."
    )
    fired = dict(zip(engine["firing_order"], engine["firing_angles_deg"], strict=True))
    angles = {"crank angle": engine["crank_angles_deg"]}
    if engine["bank_angles_deg"] is not None:
        angles["bank angle"] = engine["bank_angles_deg"]
    angles["fires at"] = [fired[number] for number in sorted(fired)]
    print_table(
        Table(
            f"Cylinders [{units.of('deg').name}]",
            [Column("cylinder"), *(Column(name, "deg", 6, bare=True) for name in angles)],
            [
                [number, *map(math.radians, row)]
                for number, row in enumerate(zip(*angles.values(), strict=True), start=1)
            ],
        ),
        units,
    )


def intervals_text(intervals_deg: Sequence[float], units: OutputUnits) -> str:
    """Say at which intervals an engine fires; of intervals that repeat, each once."""
    repeated = repeating_intervals(intervals_deg)
    angle = units.of("deg")
    told = ", ".join(angle.number(math.radians(step)) for step in repeated)
    if len(repeated) == 1:
        return f"fires every {told} {angle.name}"
    again = " in turn" if len(repeated) < len(intervals_deg) else ""
    return f"fires at intervals of {told} {angle.name}{again}"


def _cylinders(count: int) -> str:
    return "1 cylinder" if count == 1 else f"{count} cylinders"


def _digits(unit: OutputUnit) -> int:
    """Digits of a given length: all of them, and five if it was converted."""
    return 5 if unit.wished else 6


def _print_dimensions(
    dimensions: list[Record], units: OutputUnits, title: str = "The throw as read"
) -> None:
    print_table(
        Table.of_records(
            title,
            dimensions,
            (Column("dimension", words=True), "name"),
            (Column("symbol", words=True), "symbol"),
            (Column("", "mm", _digits(units.of("mm"))), "value"),
            (Column("meaning", words=True), "meaning"),
        ),
        units,
    )
