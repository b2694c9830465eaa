"""The tables of a crank mechanism's forces, from its plain record."""

import math

from crankbase.tables.table import Column, Table
from crankfem.analyses.record import Record

# Shares below this are round-off.
ROUND_OFF = 1e-12
LOAD_COLUMNS = (
    Column("mean", "kN"),
    Column("largest", "kN"),
    Column("at", "deg"),
    Column("mean", "MPa"),
    Column("largest", "MPa"),
)


def cylinder_table(record: Record) -> Table:
    """Return pressures and largest forces by cylinder."""
    return Table(
        "Cylinders",
        [
            Column("cylinder", words=True),
            Column("p", "MPa"),
            Column("at", "deg"),
            Column("p_i", "MPa"),
            *(Column(symbol, "kN") for symbol in ("N", "pin", "T")),
        ],
        [
            [
                str(row["cylinder"]),
                row["peak_pressure"],
                math.radians(row["peak_angle_deg"]),
                row["mean_effective_pressure"],
                *(row[f"largest_{name}_force"] for name in ("side", "piston_pin", "tangential")),
            ]
            for row in record["cylinders"]
        ],
        note="p: peak pressure, absolute, and its angle from the firing top; p_i: mean indicated pressure; "
        "N, pin, T: largest side force, piston-pin force and tangential force.",
        merged=True,
    )


def crankpin_table(record: Record) -> Table:
    """Return loads and specific pressures of the crankpins."""
    return Table(
        "Crankpin bearings, angle from the firing top of the cylinder whose rod is on the pin",
        [Column("cylinder", words=True), *LOAD_COLUMNS],
        [
            [
                "+".join(str(cylinder) for cylinder in row["cylinders"]),
                *_load_cells(row, row["largest_angle_from_firing_deg"]),
            ]
            for row in record["crankpins"]
        ],
        merged=True,
    )


def bearing_table(record: Record) -> Table:
    """Return loads and specific pressures of the main bearings."""
    return Table(
        "Main bearings, each throw supported by its two bearings, shaft angle",
        [Column("bearing", words=True), *LOAD_COLUMNS],
        [
            [str(place), *_load_cells(row, row["largest_angle_deg"])]
            for place, row in enumerate(record["main_bearings"], start=1)
        ],
    )


def rod_model_table(record: Record) -> Table | None:
    """Return the effect of the rod models, unless the rod's data make them equal."""
    rows = record["rod_models"]
    if all(row["crankpin_beside_mean"] < ROUND_OFF for row in rows):
        return None
    return Table(
        "Rod models compared with the rigid rod, largest differences",
        [
            Column("model", words=True),
            Column("crankpin force / its mean", "%", decimals=2),
            Column("side force / its largest", "%", decimals=2),
        ],
        [
            [row["model"], row["crankpin_beside_mean"], row["side_force_beside_largest"]]
            for row in rows
        ],
    )


def _load_cells(row: Record, degrees: float) -> list[float]:
    return [
        row["mean"],
        row["largest"],
        math.radians(degrees),
        row["mean_specific_pressure"],
        row["largest_specific_pressure"],
    ]
