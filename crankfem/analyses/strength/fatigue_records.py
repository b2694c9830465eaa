"""Fatigue over the working cycle as plain numbers in SI units, and the table made from them."""

import math
from dataclasses import asdict

from crankbase.tables.table import Column, Table
from crankbase.units.units import RPM
from crankfem.analyses.record import Record, attributes, plain
from crankfem.analyses.strength.cycle_fatigue import EngineFatigue, FatiguePlace


def fatigue_record(found: EngineFatigue) -> Record:
    """Return the record of a crankshaft's fatigue over the cycle."""
    return {
        **attributes(found, "sentence", "source", "factor", "remarks"),
        "places": [_place(one) for one in found.places],
    }


def _place(one: FatiguePlace) -> Record:
    own = asdict(one)
    return plain(
        {
            "safety": one.safety,
            "speed_rpm": own.pop("speed") * RPM,
            "misfiring": own.pop("cylinders"),
            "criterion": own.pop("value"),
            **own,
        }
    )


def fatigue_table(record: Record) -> Table:
    """Return the least safety of each kind of location of each throw, from the `fatigue_record`."""
    least: dict[tuple[int, str], Record] = {}
    for one in record["places"]:
        least.setdefault((one["throw"], one["place"]), one)
    return Table(
        "Fatigue over the working cycle",
        [
            Column("throw"),
            Column("location", words=True),
            Column("safety", decimals=2),
            Column("at", "1/min"),
            Column("misfiring cylinder"),
            Column("shaft angle", "deg", decimals=0),
            Column("shear amplitude", "MPa"),
            Column("normal stress", "MPa"),
            Column("fatigue strength", "MPa"),
            Column("factor Q", decimals=2),
        ],
        [
            [
                one["throw"],
                one["name"],
                one["safety"],
                one["speed_rpm"] / RPM,
                one["misfiring"] or None,
                math.radians(one["shaft_angle_deg"]),
                *(one[name] for name in ("shear_amplitude", "normal_stress", "strength")),
                one["rule_factor"],
            ]
            for one in least.values()
        ],
    )
