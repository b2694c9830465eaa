"""A crank mechanism's forces as plain numbers."""

import math
from collections.abc import Sequence

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.tables.table import format_names
from crankbase.units.units import RPM
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.mechanism.acceleration_records import acceleration_columns
from crankfem.analyses.mechanism.mechanism_run import MechanismRun, hinged_group
from crankfem.analyses.mechanism.rod_comparison import ModelDifference, compare_rod_models
from crankfem.analyses.record import Record, assumed_values, attributes
from crankfem.files.engine.mechanism_file import MechanismFile
from crankfem.files.engine.rated_power import EnginePower, indicated_power
from dynamics.cycle import cycle_radians
from dynamics.engine.firing import firing_intervals
from dynamics.engine.forces import pin_groups
from dynamics.engine.loads import LoadDiagram

MECHANISM_SECTIONS = ("engine", "rod", "piston", "hinged_rods", "gas")


def mechanism_record(run: MechanismRun) -> Record:
    """Return the results of a mechanism as plain numbers in SI units, angles in degrees."""
    mechanism, forces, torque = run.mechanism, run.forces, run.torque.total
    pins, journals = bearing_sizes(mechanism)
    return {
        "engine": mechanism.name,
        "speed_rpm": run.speed * RPM,
        "rod_model": forces.model,
        "firing_angles_deg": list(run.layout.firing_deg),
        "firing_intervals_deg": mechanism_intervals(run),
        "angle_step_deg": float(forces.shaft_angles_deg[1] - forces.shaft_angles_deg[0]),
        "power": run.torque.power,
        "mean_indicated_pressure": _mean_indicated_pressure(run),
        "rated": None if mechanism.power is None else power_record(mechanism.power),
        "torque": {"mean": run.torque.mean, **_extremes(torque, forces.shaft_angles_deg)},
        "energy_error": run.torque.energy_error,
        "cylinders": [
            {
                "cylinder": place + 1,
                **attributes(work, "peak_pressure", "mean_effective_pressure"),
                "peak_angle_deg": work.peak_angle_deg,
                "indicated_work": work.work,
                "largest_side_force": float(np.max(np.abs(forces.side[place]))),
                "largest_piston_pin_force": float(np.max(np.abs(forces.piston_pin[place]))),
                "largest_tangential_force": float(np.max(np.abs(forces.tangential[place]))),
            }
            for place, work in enumerate(run.works)
        ],
        "crankpins": [
            _load_record(load, pins[mechanism.throws[group[0] - 1]])
            | {
                "cylinders": list(group),
                "largest_angle_from_firing_deg": _from_firing(run, load, group),
            }
            for load, group in zip(run.crankpins, pin_groups(run.layout), strict=True)
        ],
        "main_bearings": [
            _load_record(load, size) for load, size in zip(run.bearings, journals, strict=True)
        ],
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
            for record in input_values(mechanism)
            if record.field.partition(".")[0] in MECHANISM_SECTIONS
        ),
        "remarks": [*mechanism.remarks, *_gas_remarks(run)],
    }


def mechanism_intervals(run: MechanismRun) -> list[float]:
    """Return the angles from each firing to the next, in the firing order [deg]."""
    layout = run.layout
    fired = [np.radians(layout.firing_deg[int(number) - 1]) for number in layout.firing_order]
    return [round(math.degrees(step), 6) for step in firing_intervals(fired, layout.strokes)]


def power_record(power: EnginePower) -> Record:
    """Return power at rated speed and full load, and whether the rated power is consistent, in SI units."""
    names = (
        *("mean_indicated_pressure", "mean_effective_pressure", "mechanical_efficiency"),
        *("consistent", "sentence"),
    )
    return {
        "speed_rpm": power.speed * RPM,
        "indicated_power": power.indicated,
        "rated_power": power.rated,
        **attributes(power, *names),
    }


def _mean_indicated_pressure(run: MechanismRun) -> float:
    """Mean of the cylinders, each by its swept volume [Pa]."""
    return indicated_power(run.layout, run.pressure, run.speed)[1]


Size = tuple[float, float]


def bearing_sizes(mechanism: MechanismFile) -> tuple[list[Size], list[Size]]:
    """Return diameter and length [m] for one rod on the pin of each crank, and of each main bearing."""
    throws = mechanism.crank_throws
    pins = throws[0].parts.pins
    main = set(range(1, len(mechanism.throws) + 1)) - {
        number
        for number, cylinder in enumerate(mechanism.layout.cylinders, start=1)
        if cylinder.slave_pin is not None
    }
    on_first = sum(mechanism.throws[number - 1] == 0 for number in main)
    rods_a_pin = max(1, math.ceil(on_first / len(pins)))
    # Throws side by side make a main journal of half of either's; at the ends there is another half.
    sides = zip((throws[0], *throws), (*throws, throws[-1]), strict=True)
    return (
        [(throw.pin_diameter, throw.pin_length / rods_a_pin) for throw in throws],
        [
            (
                left.main_journal_diameter,
                0.5 * (left.main_journal_length + right.main_journal_length),
            )
            for left, right in sides
        ],
    )


def _gas_remarks(run: MechanismRun) -> list[str]:
    """Return the remarks on the pressures; those on some cylinders only, with their numbers."""
    whose: dict[str, list[str]] = {}
    for place, pressure in enumerate(run.pressure, start=1):
        for remark in pressure.remarks:
            whose.setdefault(remark, []).append(str(place))
    return [
        remark
        if len(places) == len(run.pressure)
        else f"Cylinders {format_names(places)}: {remark[0].lower()}{remark[1:]}"
        for remark, places in whose.items()
    ]


def _extremes(values: FloatArray, angles_deg: FloatArray) -> dict[str, float]:
    least, most = int(np.argmin(values)), int(np.argmax(values))
    return {
        "smallest": float(values[least]),
        "smallest_angle_deg": float(angles_deg[least]),
        "largest": float(values[most]),
        "largest_angle_deg": float(angles_deg[most]),
    }


def _from_firing(run: MechanismRun, load: LoadDiagram, group: Sequence[int]) -> float:
    """Return the angle of the largest load from the firing top of the rod's own cylinder [deg]."""
    after = (
        math.radians(load.maximum_angle_deg) - np.radians(run.layout.firing_deg[group[0] - 1])
    ) % cycle_radians(run.layout.strokes)
    return float(np.degrees(after))


def _load_record(load: LoadDiagram, size: Size) -> Record:
    pressure = load.specific_pressure(*size)
    return {
        "name": load.name,
        "mean": load.mean,
        "largest": load.maximum,
        "largest_angle_deg": float(load.maximum_angle_deg),
        "diameter": size[0],
        "length": size[1],
        "mean_specific_pressure": float(pressure.mean()),
        "largest_specific_pressure": float(pressure.max()),
    }


def force_columns(
    run: MechanismRun, compared: ModelDifference | None = None
) -> tuple[dict[str, FloatArray], str]:
    """Return the forces over the shaft angle by name with unit, and a description.

    With accelerations of the pistons on the first crankpin that has hinged rods, and the load of the first
    crankpin by two rod models, if they are compared.
    """
    columns = {"shaft_angle_deg": run.forces.shaft_angles_deg, "torque_Nm": run.torque.total}
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
    angles, group = np.radians(run.forces.shaft_angles_deg), hinged_group(run.layout)
    columns |= acceleration_columns(run.layout, run.speed, group, angles)
    if compared is not None:
        for model, load in zip(compared.models, (compared.first, compared.second), strict=True):
            columns[f"{load.name.replace(', ', '_').replace(' ', '_')}_{model}_N"] = load.magnitude
        columns["difference_of_same_angle"] = compared.of_same_angle
        columns["difference_of_mean"] = compared.of_mean
    heading = f"{run.mechanism.name}, {run.speed * RPM:.10g} 1/min, rods as {run.forces.model}"
    return columns, heading
