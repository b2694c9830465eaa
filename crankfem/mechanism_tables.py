"""Records and printed tables of a crank mechanism's forces."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from crankfem.column_file import write_columns
from crankfem.console import print_line, print_table
from crankfem.mechanism_file import MechanismFile
from crankfem.mechanism_run import MechanismRun
from crankfem.output_units import SI, OutputUnits
from crankfem.record import assumed_values
from crankfem.rod_comparison import compare_rod_models
from dynamics.checks import FloatArray
from dynamics.engine.forces import pin_groups
from dynamics.engine.loads import LoadDiagram
from geometry.units import RPM

# Shares below this are round-off.
ROUND_OFF = 1e-12
ASSUMED = "Assumed: "
MECHANISM_SECTIONS = ("engine", "rod", "piston", "hinged_rods", "gas")


def mechanism_record(run: MechanismRun) -> dict[str, Any]:
    """Return the results of a mechanism as plain numbers in SI units, angles in degrees."""
    mechanism, forces, torque = run.mechanism, run.forces, run.torque.total
    pin, journal = bearing_sizes(mechanism)
    return {
        "engine": mechanism.name,
        "speed_rpm": run.speed * RPM,
        "rod_model": forces.model,
        "firing_angles_deg": np.degrees(run.layout.firing).tolist(),
        "angle_step_deg": float(np.degrees(forces.shaft_angles[1] - forces.shaft_angles[0])),
        "power": run.torque.power,
        "torque": {"mean": run.torque.mean, **_extremes(torque, forces.shaft_angles)},
        "energy_error": run.torque.energy_error,
        "cylinders": [
            {
                "cylinder": place + 1,
                "peak_pressure": work.peak_pressure,
                "peak_angle_deg": float(np.degrees(work.peak_angle)),
                "indicated_work": work.work,
                "mean_effective_pressure": work.mean_effective_pressure,
                "largest_side_force": float(np.max(np.abs(forces.side[place]))),
                "largest_piston_pin_force": float(np.max(np.abs(forces.piston_pin[place]))),
                "largest_tangential_force": float(np.max(np.abs(forces.tangential[place]))),
            }
            for place, work in enumerate(run.works)
        ],
        "crankpins": [
            _load_record(load, pin)
            | {
                "cylinders": list(group),
                "largest_angle_from_firing_deg": _from_firing(run, load, group),
            }
            for load, group in zip(run.crankpins, pin_groups(run.layout), strict=True)
        ],
        "main_bearings": [_load_record(load, journal) for load in run.bearings],
        "rod_models": [
            {
                "model": compared.model,
                "crankpin_beside_mean": compared.crankpin,
                "side_force_beside_largest": compared.side,
            }
            for compared in compare_rod_models(run)
        ],
        "assumed": assumed_values(
            record
            for record in mechanism.records
            if record.field.partition(".")[0] in MECHANISM_SECTIONS
        ),
        "remarks": [*mechanism.remarks, *_gas_remarks(run)],
    }


def bearing_sizes(mechanism: MechanismFile) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return diameter and length that one rod has on its pin, and of a main bearing [m]."""
    throw = mechanism.throw
    pins = throw.parts.pins
    main = set(range(1, len(mechanism.throws) + 1)) - {
        number
        for number, cylinder in enumerate(mechanism.layout.cylinders, start=1)
        if cylinder.slave_pin is not None
    }
    on_first = sum(mechanism.throws[number - 1] == 0 for number in main)
    rods_a_pin = max(1, math.ceil(on_first / len(pins)))
    return (
        (throw.pin_diameter, throw.pin_length / rods_a_pin),
        (throw.main_journal_diameter, throw.main_journal_length),
    )


def _gas_remarks(run: MechanismRun) -> list[str]:
    """Return what is said of the pressures; what holds for some cylinders only, with their numbers."""
    whose: dict[str, list[str]] = {}
    for place, pressure in enumerate(run.pressure, start=1):
        for remark in pressure.remarks:
            whose.setdefault(remark, []).append(str(place))
    return [
        remark
        if len(places) == len(run.pressure)
        else f"Cylinders {listed(places)}: {remark[0].lower()}{remark[1:]}"
        for remark, places in whose.items()
    ]


def _extremes(values: FloatArray, angles: FloatArray) -> dict[str, float]:
    least, most = int(np.argmin(values)), int(np.argmax(values))
    return {
        "smallest": float(values[least]),
        "smallest_angle_deg": float(np.degrees(angles[least])),
        "largest": float(values[most]),
        "largest_angle_deg": float(np.degrees(angles[most])),
    }


def _from_firing(run: MechanismRun, load: LoadDiagram, group: Sequence[int]) -> float:
    """Return the angle of the largest load from the firing top of the rod's own cylinder [deg]."""
    after = (load.maximum_angle - run.layout.firing[group[0] - 1]) % run.layout.cycle
    return float(np.degrees(after))


def _load_record(load: LoadDiagram, size: tuple[float, float]) -> dict[str, Any]:
    pressure = load.specific_pressure(*size)
    return {
        "name": load.name,
        "mean": load.mean,
        "largest": load.maximum,
        "largest_angle_deg": float(np.degrees(load.maximum_angle)),
        "diameter": size[0],
        "length": size[1],
        "mean_specific_pressure": float(pressure.mean()),
        "largest_specific_pressure": float(pressure.max()),
    }


def print_mechanism(record: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print the record of a mechanism as tables."""
    torque, moment = record["torque"], units.of("kN m")
    force, pressure, angle = units.of("kN"), units.of("MPa"), units.of("deg")
    print_line(
        f"{record['engine']} at {units.of('1/min').with_name(record['speed_rpm'] / RPM, 5)}, rods as "
        f"{record['rod_model']}: indicated power {units.of('kW').with_name(record['power'])}, torque "
        f"{moment.with_name(torque['mean'])} ({moment.number(torque['smallest'])} to "
        f"{moment.with_name(torque['largest'])})."
    )
    print_table(
        "Cylinders",
        [
            "cylinder",
            f"p [{pressure.name}]",
            f"at [{angle.name}]",
            f"p_i [{pressure.name}]",
            *(f"{symbol} [{force.name}]" for symbol in ("N", "pin", "T")),
        ],
        merged_rows(
            [
                [
                    str(row["cylinder"]),
                    pressure.number(row["peak_pressure"]),
                    angle.number(math.radians(row["peak_angle_deg"])),
                    pressure.number(row["mean_effective_pressure"]),
                    force.number(row["largest_side_force"]),
                    force.number(row["largest_piston_pin_force"]),
                    force.number(row["largest_tangential_force"]),
                ]
                for row in record["cylinders"]
            ]
        ),
    )
    print_line(
        "p: peak pressure, absolute, and its angle from the firing top; p_i: mean effective; N, pin, T: "
        "largest side force, piston-pin force and tangential force."
    )
    columns = [
        f"mean [{force.name}]",
        f"largest [{force.name}]",
        f"at [{angle.name}]",
        f"mean [{pressure.name}]",
        f"largest [{pressure.name}]",
    ]
    print_table(
        "Crankpin bearings, angle from the firing top of the cylinder whose rod is on the pin",
        ["cylinder", *columns],
        merged_rows(
            [
                [
                    "+".join(str(cylinder) for cylinder in row["cylinders"]),
                    *_load_cells(row, row["largest_angle_from_firing_deg"], units),
                ]
                for row in record["crankpins"]
            ]
        ),
    )
    print_table(
        "Main bearings, each throw carried by its two neighbors, shaft angle",
        ["bearing", *columns],
        [
            [str(place), *_load_cells(row, row["largest_angle_deg"], units)]
            for place, row in enumerate(record["main_bearings"], start=1)
        ],
    )
    _print_models(record)
    print_line(
        "Check: the work of the torque misses the indicated work, the integral of p dV, by "
        f"{abs(record['energy_error']):.1e} of the work exchanged."
    )
    _print_remarks(record["remarks"], units)
    if record["assumed"]:
        print_line(
            f"Assumed in the file ({len(record['assumed'])} values): "
            + ", ".join(entry["field"] for entry in record["assumed"])
            + "."
        )


def _load_cells(row: dict[str, Any], degrees: float, units: OutputUnits) -> list[str]:
    force, pressure = units.of("kN"), units.of("MPa")
    return [
        force.number(row["mean"]),
        force.number(row["largest"]),
        units.of("deg").number(math.radians(degrees)),
        pressure.number(row["mean_specific_pressure"]),
        pressure.number(row["largest_specific_pressure"]),
    ]


def merged_rows(rows: list[list[str]]) -> list[list[str]]:
    """Put rows that differ in the first column only into one, such as "1, 3" or "1 to 6"."""
    found: dict[tuple[str, ...], list[str]] = {}
    for first, *rest in rows:
        found.setdefault(tuple(rest), []).append(first)
    return [[listed(names), *rest] for rest, names in found.items()]


def listed(names: list[str]) -> str:
    """Write a list of names, numbers that follow each other as "1 to 6"."""
    numbers = [int(name) for name in names if name.isdigit()]
    if len(numbers) == len(names) > 2 and numbers == [*range(numbers[0], numbers[0] + len(names))]:
        return f"{names[0]} to {names[-1]}"
    return ", ".join(names)


def _print_remarks(remarks: list[str], units: OutputUnits) -> None:
    """Print remarks, the assumed values of the gas cycle as one line without their reasons."""
    assumed = [remark for remark in remarks if remark.startswith(ASSUMED)]
    for remark in remarks:
        if remark not in assumed:
            print_line(units.text(f"Note: {remark.rstrip('.')}."))
    if assumed:
        values = ", ".join(remark.removeprefix(ASSUMED).partition(",")[0] for remark in assumed)
        print_line(units.text(f"Assumed in the cycle: {values}; the reasons stand in --json."))


def _print_models(record: dict[str, Any]) -> None:
    """Print what the rod models make of it, unless the rod's data cannot tell them apart."""
    rows = record["rod_models"]
    if all(row["crankpin_beside_mean"] < ROUND_OFF for row in rows):
        return
    print_table(
        "Rod models beside the rigid rod, largest differences",
        ["model", "crankpin force / its mean [%]", "side force / its largest [%]"],
        [
            [
                row["model"],
                f"{100.0 * row['crankpin_beside_mean']:.2f}",
                f"{100.0 * row['side_force_beside_largest']:.2f}",
            ]
            for row in rows
        ],
    )


def write_forces(path: Path, run: MechanismRun) -> None:
    """Write the forces over the cycle as CSV: a row for each shaft angle, units in the names.

    Parameters
    ----------
    path : Path
    run : MechanismRun
    """
    columns = {
        "shaft_angle_deg": np.degrees(run.forces.shaft_angles),
        "torque_Nm": run.torque.total,
    }
    for place in range(len(run.layout.cylinders)):
        for name, values in (
            ("gas_force_N", run.forces.gas),
            ("side_force_N", run.forces.side),
            ("tangential_N", run.forces.tangential),
            ("radial_N", run.forces.radial),
            ("torque_Nm", run.forces.torque),
        ):
            columns[f"cylinder_{place + 1}_{name}"] = values[place]
    for load in (*run.crankpins, *run.bearings):
        name = load.name.replace(", ", "_").replace(" ", "_")
        columns |= {f"{name}_{key}": load.columns()[key] for key in ("force_x_N", "force_y_N")}
    heading = f"{run.mechanism.name}, {run.speed * RPM:.10g} 1/min, rods as {run.forces.model}"
    write_columns(path, columns, heading)
