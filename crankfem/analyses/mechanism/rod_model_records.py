"""Comparison of two models of the rods' mass as plain JSON content, and the tables made from it."""

import math

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Column, Table, format_names
from crankfem.analyses.mechanism.load_tables import ROUND_OFF
from crankfem.analyses.mechanism.rod_comparison import ModelDifference
from crankfem.analyses.record import Record, attributes
from dynamics.engine import ROD_MODELS
from dynamics.engine.layout import EngineLayout

# A row of the table for every so many degrees of shaft angle, as the dots of the polar diagram.
ROW_STEP = 30.0


def rod_mass_records(layout: EngineLayout) -> list[Record]:
    """Return the equivalent masses of each rod, by model.

    Returns
    -------
    list of dict
        For each different rod "cylinders", and "models": "model", "at_foot", "at_piston_pin" and
        "at_center" [kg], None where the model has no mass there, and the additional "inertia" [kg m^2].
        The foot is at the crankpin, or at the slave pin.
    """
    rods = [cylinder.rod for cylinder in layout.cylinders]
    found = []
    for rod in dict.fromkeys(rods):
        places = {"at_foot": 0j, "at_piston_pin": complex(rod.length), "at_center": rod.center}
        rows = []
        for model in map(rod.model, ROD_MODELS):
            masses = dict(zip(model.places, model.masses, strict=True))
            rows.append(
                {
                    "model": model.name,
                    **{
                        name: _without_round_off(masses.get(place), rod.mass)
                        for name, place in places.items()
                    },
                    "inertia": _without_round_off(model.added_inertia, rod.inertia),
                }
            )
        found.append(
            {
                "cylinders": [number for number, own in enumerate(rods, start=1) if own == rod],
                "models": rows,
            }
        )
    return found


def _without_round_off(value: float | None, scale: float) -> float | None:
    return 0.0 if value is not None and abs(value) < ROUND_OFF * scale else value


def rod_mass_table(records: list[Record]) -> Table:
    """Return the table of `rod_mass_records`."""
    several = len(records) > 1
    return Table(
        "Equivalent masses of the rod" + ("s" if several else ""),
        [
            *([Column("cylinders", words=True)] if several else []),
            Column("model", words=True),
            Column("at big end", "kg", missing=""),
            Column("at piston pin", "kg", missing=""),
            Column("at center of mass", "kg", missing=""),
            Column("added inertia", "kg m^2"),
        ],
        [
            [
                *(
                    [format_names([str(number) for number in record["cylinders"]])]
                    if several
                    else []
                ),
                row["model"],
                *(row[f"at_{place}"] for place in ("foot", "piston_pin", "center")),
                row["inertia"],
            ]
            for record in records
            for row in record["models"]
        ],
    )


def model_difference_record(found: ModelDifference) -> Record:
    """Return the crankpin loads of two rod models, and their difference, as plain JSON content.

    Returns
    -------
    dict
        "models", "crankpin", "piston_area" [m^2]; over "shaft_angles_deg" the "sizes" of the force by
        both models [N], their difference "of_same_angle" and "of_mean" as shares, with the largest of
        each, "largest_of_same_angle" and "largest_of_mean", signed, at "..._deg"; and how "mean" and
        "maximum" of the second model differ from those of the first, as shares.
    """
    first, second = found.first, found.second
    degrees = first.angles_deg
    return {
        **attributes(found, "models", "piston_area", "of_same_angle", "of_mean"),
        "crankpin": first.name,
        "shaft_angles_deg": degrees.tolist(),
        "sizes": [first.magnitude.tolist(), second.magnitude.tolist()],
        **_largest("of_same_angle", found.of_same_angle, degrees),
        **_largest("of_mean", found.of_mean, degrees),
        "mean": second.mean / first.mean - 1.0,
        "maximum": second.maximum / first.maximum - 1.0,
    }


def _largest(name: str, shares: FloatArray, degrees: FloatArray) -> Record:
    place = int(np.argmax(np.abs(shares)))
    return {f"largest_{name}": float(shares[place]), f"largest_{name}_deg": float(degrees[place])}


def model_difference_table(record: Record) -> Table | None:
    """Return the loads of a `model_difference_record` by shaft angle, unless both are the same."""
    first, second = record["models"]
    if not _differ(record):
        return None
    degrees = np.array(record["shaft_angles_deg"])
    wanted = np.arange(math.ceil(degrees[0] / ROW_STEP) * ROW_STEP, degrees[-1] + 1e-6, ROW_STEP)
    rows = [int(np.argmin(np.abs(degrees - angle))) for angle in wanted]
    sizes, pressure = record["sizes"], 1e-3 / record["piston_area"]
    return Table(
        f"Load of {record['crankpin']}, rods as {first} and as {second}",
        [
            Column("shaft angle", "deg"),
            *(Column(name, "kN") for name in record["models"]),
            Column("change", "%", decimals=2),
            Column("of mean", "%", decimals=2),
        ],
        [
            [
                math.radians(degrees[row]),
                *(own[row] for own in sizes),
                record["of_same_angle"][row],
                record["of_mean"][row],
            ]
            for row in rows
        ],
        note=f"1 kN over the area of the piston is {pressure:.4g} MPa. Change: from {first} to {second}, in "
        f"percent of {first} at the same angle, and of its mean.",
    )


def _differ(record: Record) -> bool:
    return bool(record["largest_of_mean"])


def model_difference_sentence(record: Record, units: OutputUnits = SI) -> str:
    """State the difference between two models."""
    first, second = record["models"]
    if not _differ(record):
        return f"Load of {record['crankpin']}: the same, to round-off, as {second} and as {first}."

    def share(name: str) -> str:
        return f"{100.0 * record[name]:+.2f} %"

    def at(name: str) -> str:
        return units.of("deg").with_name(math.radians(record[f"{name}_deg"]))

    same, mean = "largest_of_same_angle", "largest_of_mean"
    return (
        f"Load of {record['crankpin']}, from {first} to {second}: it changes by up to {share(same)} of its "
        f"size at the same angle (at {at(same)}), or {share(mean)} of its mean (at {at(mean)}); its mean "
        f"changes by {share('mean')}, its maximum by {share('maximum')}."
    )
