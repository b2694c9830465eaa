"""What the command harmonics tells of a torque table or an engine: records, tables, files."""

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np

from crankfem import console
from crankfem.console import number, print_table
from crankfem.mechanism_file import MechanismFile
from crankfem.results import harmonics_record
from dynamics.harmonics import Harmonics
from dynamics.torque.pin_harmonics import PinForceHarmonics
from dynamics.torque.star import Star, leading_stars, same_stars, star_diagram
from dynamics.torque.torque import EngineTorque

Record = dict[str, Any]
COLUMNS = ("orders", "cosine", "sine", "amplitude", "phase_deg")
PARTS = ("gas", "inertia", "gas and inertia")


def cut_record(found: Harmonics, highest: float) -> Record:
    """Return the record of harmonics with the orders up to a highest one."""
    record = harmonics_record(found)
    kept = sum(order <= highest * (1.0 + 1e-9) for order in record["orders"])
    return record | {name: record[name][:kept] for name in COLUMNS}


def engine_record(mechanism: MechanismFile, torque: EngineTorque, highest: float) -> Record:
    """Mean, power, harmonics of engine and throws, and the star of each order."""
    engine = torque.engine
    stars = star_diagram(engine, highest)
    remarks = list(mechanism.remarks)
    if not mechanism.pressure:
        remarks.append("the file has no section [gas]: the torque is that of moving masses alone")
    return {
        "engine": mechanism.name,
        "speed_rpm": torque.speed * 30.0 / math.pi,
        "rod_model": mechanism.rod_model,
        "strokes": engine.strokes,
        "mean": torque.mean,
        "power": torque.power,
        "nonuniformity": torque.nonuniformity,
        "indicated_work": torque.indicated_work.tolist(),
        "energy_error": torque.energy_error,
        "harmonics": cut_record(torque.harmonics(), highest),
        "throws": [
            {"cylinders": list(throw), "harmonics": cut_record(torque.harmonics(place), highest)}
            for place, throw in enumerate(torque.throws, start=1)
        ],
        "firing_angles_deg": np.rad2deg(engine.firing).tolist(),
        "stars": [_star_record(star) for star in stars],
        "leading_orders": [star.order for star in leading_stars(stars)],
        "same_stars": [[star.order for star in group] for group in same_stars(stars)],
        "remarks": remarks,
    }


def pin_force_record(found: PinForceHarmonics, highest: float) -> Record:
    """Harmonics of one cylinder's tangential and radial force, phases from its firing top."""
    fields = ("tangential", "radial")
    return {
        "number": found.number,
        "firing_angle_deg": math.degrees(found.firing_angle),
        **{
            field: {
                "gas": cut_record(getattr(found, f"{field}_gas"), highest),
                "inertia": cut_record(getattr(found, f"{field}_inertia"), highest),
                "gas and inertia": cut_record(getattr(found, field), highest),
            }
            for field in fields
        },
    }


def _star_record(star: Star) -> Record:
    return {
        "order": star.order,
        "kind": star.kind,
        "resultant": star.resultant,
        "share": star.share,
        "directions_deg": np.rad2deg(star.directions).tolist(),
    }


def print_harmonics(title: str, record: Record, unit: str) -> None:
    """Print orders, coefficients, amplitudes and phases."""
    rows = zip(*(record[name] for name in COLUMNS), strict=True)
    print_table(
        title,
        ["order", f"A_k [{unit}]", f"B_k [{unit}]", f"M_k [{unit}]", "a_k [deg]"],
        [[f"{row[0]:g}", *(_hundredths(value) for value in row[1:])] for row in rows],
    )


def print_engine(record: Record) -> None:
    """Print the torque of an engine, its harmonics and stars."""
    uneven = record["nonuniformity"]
    said = "" if uneven is None else f", (largest - least) / mean {number(uneven)}"
    console.output.print(
        f"{record['engine']} at {record['speed_rpm']:g} 1/min: mean torque {record['mean']:.2f} N m, "
        f"indicated power {record['power'] / 1000.0:.2f} kW{said}.",
        soft_wrap=True,
    )
    for remark in record["remarks"]:
        console.output.print(f"Note: {remark}.", soft_wrap=True)
    print_harmonics("Harmonics of the engine's torque", record["harmonics"], "N m")
    throws = record["throws"]
    orders = record["harmonics"]["orders"]
    print_table(
        "Amplitudes by throw [N m]",
        ["order", *(_throw_name(place, throw) for place, throw in enumerate(throws, start=1))],
        [
            [f"{order:g}", *(f"{throw['harmonics']['amplitude'][row]:.2f}" for throw in throws)]
            for row, order in enumerate(orders)
        ],
    )
    like = {order: group for group in record["same_stars"] for order in group}
    print_table(
        "Stars of the orders, all cylinders alike",
        ["order", "kind:", "resultant / sum", "same star as:"],
        [
            [
                f"{star['order']:g}",
                star["kind"],
                f"{star['share']:.4f}",
                ", ".join(f"{other:g}" for other in like[star["order"]] if other != star["order"]),
            ]
            for star in record["stars"]
        ],
    )
    named = ", ".join(f"{order:g}" for order in record["leading_orders"])
    kinds = {star["kind"] for star in record["stars"]}
    said = "Major orders" if "major" in kinds else "No order is major; the strongest"
    console.output.print(f"{said}: {named or 'none'}.", soft_wrap=True)


def print_pin_forces(record: Record) -> None:
    """Print the harmonics of one cylinder's forces on its crankpin."""
    for field, letter in (("tangential", "T"), ("radial", "Z")):
        parts = record[field]
        orders = parts["gas"]["orders"]
        means = ", ".join(f"{part} {parts[part]['mean']:.2f}" for part in PARTS)
        print_table(
            f"Cylinder {record['number']}: {field} force {letter} on the crankpin, phases from its "
            f"firing top at {record['firing_angle_deg']:g} deg; mean [N]: {means}",
            ["order", *(f"{part} {sign}" for part in PARTS for sign in ("M_k [N]", "a_k [deg]"))],
            [
                [
                    f"{order:g}",
                    *(
                        f"{parts[part][name][row]:.2f}"
                        for part in PARTS
                        for name in ("amplitude", "phase_deg")
                    ),
                ]
                for row, order in enumerate(orders)
            ],
        )


def _hundredths(value: float) -> str:
    # Adding zero turns a negative zero into zero.
    return f"{round(value, 2) + 0.0:.2f}"


def _throw_name(place: int, throw: Record) -> str:
    return f"throw {place} (cyl. {', '.join(map(str, throw['cylinders']))})"


def table_rows(record: Record) -> list[list[object]]:
    """Return the rows of a CSV file of harmonics: of a torque table or of an engine."""
    if "throws" not in record:
        return _rows("torque", "N m", record)
    rows = _rows("engine torque", "N m", record["harmonics"])
    for place, throw in enumerate(record["throws"], start=1):
        rows += _rows(f"torque of throw {place}", "N m", throw["harmonics"])
    cylinder = record.get("cylinder")
    if cylinder is not None:
        for field in ("tangential", "radial"):
            for part in PARTS:
                name = f"{field} force of cylinder {cylinder['number']} from {part}"
                rows += _rows(name, "N", cylinder[field][part])
    return rows


def _rows(name: str, unit: str, record: Record) -> list[list[object]]:
    mean: list[object] = [name, unit, 0.0, record["mean"], 0.0, record["mean"], 0.0]
    orders = zip(*(record[column] for column in COLUMNS), strict=True)
    return [mean, *([name, unit, *values] for values in orders)]


def write_table(path: Path, record: Record) -> None:
    """Write harmonics as CSV; the row of order 0 is the mean."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["of", "unit", "order", "cosine", "sine", "amplitude", "phase_deg"])
        writer.writerows(table_rows(record))
