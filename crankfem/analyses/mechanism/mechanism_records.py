"""A crank mechanism's forces as plain numbers."""

import math
from collections.abc import Sequence

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.quantity import RPM
from crankbase.table import SI, Column, OutputUnits, Table, format_names
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.mechanism.mechanism_run import MechanismRun, hinged_group
from crankfem.analyses.mechanism.rod_models import ROUND_OFF, ModelDifference, compare_rod_models
from crankfem.analyses.record import Record, assumed_values, attributes
from crankfem.files.engine.mechanism_file import MechanismFile
from dynamics.cycle import cycle_radians
from dynamics.engine.forces import (
    LoadDiagram,
    acceleration_orders,
    order_part,
    pin_groups,
    piston_acceleration,
)
from dynamics.engine.layout import EngineLayout, firing_intervals
from dynamics.excitation.pressure_map import indicated_power

HIGHEST_ORDER = 8
# Orders that tables of balance go by; what they leave is told by its largest value.
ORDERS = (1, 2)
# [deg] Angles at which accelerations are compared.
STEP = 0.25


def piston_names(layout: EngineLayout, cylinders: Sequence[int]) -> dict[int, str]:
    """Return the names of the pistons of one crankpin, by the number of their cylinder."""
    return {number: f"{_rod(layout, number)} rod (cylinder {number})" for number in cylinders}


def _rod(layout: EngineLayout, number: int) -> str:
    return "main" if layout.main_of(number) == number else "hinged"


def acceleration_columns(
    layout: EngineLayout, speed: float, cylinders: Sequence[int], shaft_angles: FloatArray
) -> dict[str, FloatArray]:
    """Return the pistons' accelerations over shaft angles (m,) [rad] by name with unit: whole, by order."""
    columns = {}
    for number in cylinders:
        alpha = shaft_angles - math.radians(layout.cylinders[number - 1].top_shaft_angle_deg)
        parts = acceleration_orders(layout, number, speed, max(ORDERS))
        columns[f"cylinder_{number}_acceleration_m_s2"] = piston_acceleration(
            layout, number, speed, angles_deg=np.degrees(alpha)
        )
        for order in ORDERS:
            columns[f"cylinder_{number}_order_{order}_m_s2"] = order_part(parts, order, alpha)
    return columns


def acceleration_record(layout: EngineLayout, speed: float, cylinders: Sequence[int]) -> Record:
    """Return the accelerations of pistons on one crankpin as plain JSON content.

    Parameters
    ----------
    cylinders : sequence of int
        Numbers of the cylinders, that with the main rod first.

    Returns
    -------
    dict
        "pistons": for each "cylinder", its "rod" ("main" or "hinged"), the "largest" acceleration
        towards the shaft, "amplitude" [m/s^2] and "phase_deg" of "orders" a cos(k alpha - phase), alpha
        from the position of the crank along the cylinder's own axis, and the largest remainder "left" above
        orders 1 and 2 [m/s^2].
        "differences": for each hinged rod, by "cylinder", the acceleration of the main rod's piston minus
        its own at the same alpha: "largest", "least" [m/s^2] and where, "..._deg", and
        "mean_largest", the mean of the largest accelerations of both [m/s^2].
    """
    alpha = np.radians(np.arange(0.0, 360.0, STEP))
    curves = {
        number: piston_acceleration(layout, number, speed, angles_deg=np.degrees(alpha))
        for number in cylinders
    }
    main, *hinged = cylinders
    return {
        "speed": speed,
        "pistons": [
            _piston_record(layout, speed, number, alpha, curve) for number, curve in curves.items()
        ],
        "differences": [
            _difference_record(one, alpha, curves[main], curves[one]) for one in hinged
        ],
    }


def _piston_record(
    layout: EngineLayout, speed: float, number: int, alpha: FloatArray, whole: FloatArray
) -> Record:
    parts = acceleration_orders(layout, number, speed, HIGHEST_ORDER)
    count = HIGHEST_ORDER
    zero = parts.amplitude[:count] <= ROUND_OFF * parts.amplitude[0]
    # Adding zero makes a negative zero positive.
    phase = np.round(np.degrees(np.arctan2(parts.sine[:count], parts.cosine[:count])), 9) + 0.0
    left = whole - sum(order_part(parts, order, alpha) for order in ORDERS)
    return {
        "cylinder": number,
        "rod": _rod(layout, number),
        "largest": float(np.max(whole)),
        "orders": list(range(1, count + 1)),
        "amplitude": np.where(zero, 0.0, parts.amplitude[:count]).tolist(),
        "phase_deg": np.where(zero, 0.0, phase).tolist(),
        "left": float(np.max(np.abs(left))),
    }


def _difference_record(
    number: int, alpha: FloatArray, main: FloatArray, hinged: FloatArray
) -> Record:
    apart = main - hinged
    most, least = int(np.argmax(apart)), int(np.argmin(apart))
    return {
        "cylinder": number,
        "largest": float(apart[most]),
        "largest_deg": math.degrees(alpha[most]),
        "least": float(apart[least]),
        "least_deg": math.degrees(alpha[least]),
        "mean_largest": 0.5 * float(np.max(main) + np.max(hinged)),
    }


def acceleration_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the orders of an `acceleration_record`, and the remainder above orders 1 and 2."""
    main = record["pistons"][0]
    speed = units.of("1/min").with_name(record["speed"], 6)
    rows: list[list[float | str | None]] = []
    for place, order in enumerate(main["orders"][:4]):
        for piston in record["pistons"]:
            amplitude, reference = piston["amplitude"][place], main["amplitude"][place]
            beside = amplitude / reference - 1.0 if reference else None
            rows.append(
                [
                    str(order),
                    str(piston["cylinder"]),
                    piston["rod"],
                    amplitude,
                    amplitude / piston["largest"],
                    None if piston is main else beside,
                    math.radians(piston["phase_deg"][place]) if amplitude else None,
                ]
            )
    rows += [
        [
            "above 2",
            str(piston["cylinder"]),
            piston["rod"],
            piston["left"],
            piston["left"] / piston["largest"],
            None,
            None,
        ]
        for piston in record["pistons"]
    ]
    return Table(
        f"Accelerations of the pistons on one crankpin at {speed}",
        [
            Column("order", words=True),
            Column("cylinder", words=True),
            Column("rod", words=True),
            Column("amplitude", "m/s^2"),
            Column("of largest", "%", decimals=2),
            Column("against main rod", "%", decimals=2, missing=""),
            Column("phase", "deg", missing=""),
        ],
        rows,
        note="Of largest: amplitude divided by the piston's largest acceleration. Against main rod: "
        "difference of the amplitudes. Phase: order k is a cos(k alpha - phase), with alpha 0 when the "
        "crank is along the cylinder axis.",
    )


def acceleration_sentences(record: Record, units: OutputUnits = SI) -> list[str]:
    """State the difference between pistons of main and hinged rods, one sentence for each hinged rod."""
    main = record["pistons"][0]["cylinder"]

    def apart(row: Record, which: str) -> str:
        value = units.of("m/s^2").with_name(row[which])
        angle = units.of("deg").with_name(math.radians(row[f"{which}_deg"]))
        return f"{value} at {angle} ({abs(100.0 * row[which] / row['mean_largest']):.2g} %)"

    return [
        f"Acceleration, cylinder {main} less cylinder {row['cylinder']}, at the same alpha: "
        f"{apart(row, 'least')} to {apart(row, 'largest')}; percent of the mean of both largest "
        "accelerations."
        for row in record["differences"]
    ]


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
        "rated": mechanism.power,
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
