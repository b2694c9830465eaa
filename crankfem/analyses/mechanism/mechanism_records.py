"""A crank mechanism's forces as plain numbers, the models of a rod compared, and their tables."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.quantity import RPM
from crankbase.results import Internal, Number, Part, Quantity, Result, result
from crankbase.table import SI, Column, OutputUnits, Table, format_names
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.engine_mechanism import MechanismFile
from crankfem.analyses.mechanism.mechanism_run import MechanismRun, hinged_group
from crankfem.analyses.record import ASSUMED, Record, assumed_values, attributes
from dynamics.cycle import cycle_radians
from dynamics.engine import ROD_MODELS, RodModelName
from dynamics.engine.forces import (
    LoadDiagram,
    MechanismForces,
    acceleration_orders,
    crankpin_loads,
    mechanism_forces,
    order_part,
    pin_groups,
    piston_acceleration,
)
from dynamics.engine.layout import EngineLayout, firing_intervals, repeating_intervals
from dynamics.excitation.pressure_map import indicated_power

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
    rows: Sequence[ModelComparison] = record["rod_models"]
    if all(row.crankpin < ROUND_OFF for row in rows):
        return None
    return Table(
        "Rod models compared with the rigid rod, largest differences",
        [
            Column("model", words=True),
            Column("crankpin force / its mean", "%", decimals=2),
            Column("side force / its largest", "%", decimals=2),
        ],
        [[row.model, row.crankpin, row.side] for row in rows],
    )


def _load_cells(row: Record, degrees: float) -> list[float]:
    return [
        row["mean"],
        row["largest"],
        math.radians(degrees),
        row["mean_specific_pressure"],
        row["largest_specific_pressure"],
    ]


@result("model", "crankpin", "side", eq=True)
class ModelComparison(Result):
    """Largest differences of a rod model's forces from those of the rigid rod."""

    model: RodModelName
    crankpin: Annotated[
        float, Quantity("1", "vector to vector, of the mean size", key="crankpin_beside_mean")
    ]
    side: Annotated[float, Quantity("1", "of the largest N", key="side_force_beside_largest")]


def compare_rod_models(run: MechanismRun) -> tuple[ModelComparison, ...]:
    """Compare the rod models with the rigid rod, for the same gas and speed."""
    rigid = run.forces if run.forces.model == "rigid" else _with_model(run, "rigid")
    loads = crankpin_loads(rigid)
    differences = []
    for name in ROD_MODELS[1:]:
        forces = _with_model(run, name)
        crankpin = max(
            float(np.max(np.abs(crankpin_load.force - load.force))) / load.mean
            for crankpin_load, load in zip(crankpin_loads(forces), loads, strict=True)
        )
        side = float(np.max(np.abs(forces.side - rigid.side)) / np.max(np.abs(rigid.side)))
        differences.append(ModelComparison(name, crankpin, side))
    return tuple(differences)


def _with_model(run: MechanismRun, model: RodModelName) -> MechanismForces:
    return mechanism_forces(
        run.layout,
        run.speed,
        run.forces.gas,
        model=model,
        shaft_angles_deg=run.forces.shaft_angles_deg,
    )


Shares = Annotated[FloatArray, Quantity("1")]
Degrees = Annotated[float, Quantity("deg")]


@result("models", "mean: first.mean [N]", "of_same_angle", "of_mean", "piston_area")
class ModelDifference(Result):
    """The load of one crankpin by two models of the rods' mass; the second is compared with the first.

    Notes
    -----
    Yamanin, Zhukov, Baryshnikov 2018, doi 10.21821/2309-5180-2018-10-1-191-200, draw forces over the
    piston's area, and give the difference of momentary values.
    """

    models: tuple[RodModelName, RodModelName]
    first: Internal[LoadDiagram]
    second: Internal[LoadDiagram]
    piston_area: Annotated[float, Quantity("m^2", "of the piston above the crankpin")]

    @property
    def crankpin(self) -> Part[str]:
        """Its name."""
        return self.first.name

    @property
    def shaft_angles_deg(self) -> Annotated[FloatArray, Quantity("deg")]:
        """Of the following, shape (m,)."""
        return self.first.angles_deg

    @property
    def sizes(self) -> Annotated[tuple[FloatArray, FloatArray], Quantity("N")]:
        """Sizes of the force by both models."""
        return self.first.magnitude, self.second.magnitude

    @property
    def change(self) -> FloatArray:
        """Size of the force by the second model minus that by the first, shape (m,) [N].

        Zero if it is round-off of the largest force.
        """
        change = self.second.magnitude - self.first.magnitude
        return np.where(np.abs(change) < ROUND_OFF * self.first.maximum, 0.0, change)

    @property
    def of_same_angle(self) -> Shares:
        """The change as a share of the size by the first model at the same angle, shape (m,)."""
        return self.change / self.first.magnitude

    @property
    def of_mean(self) -> Shares:
        """The change as a share of the mean size by the first model, shape (m,)."""
        return self.change / self.first.mean

    @property
    def largest_of_same_angle(self) -> Number:
        """The largest share of the size at the same angle, signed."""
        return float(self.of_same_angle[_largest(self.of_same_angle)])

    @property
    def largest_of_same_angle_deg(self) -> Degrees:
        """Where it is."""
        return float(self.first.angles_deg[_largest(self.of_same_angle)])

    @property
    def largest_of_mean(self) -> Number:
        """The largest share of the mean size, signed."""
        return float(self.of_mean[_largest(self.of_mean)])

    @property
    def largest_of_mean_deg(self) -> Degrees:
        """Where it is."""
        return float(self.first.angles_deg[_largest(self.of_mean)])

    @property
    def mean(self) -> Number:
        """How the mean by the second model differs from that by the first, as a share."""
        return self.second.mean / self.first.mean - 1.0

    @property
    def maximum(self) -> Number:
        """How the maximum by the second model differs from that by the first, as a share."""
        return self.second.maximum / self.first.maximum - 1.0


def _largest(shares: FloatArray) -> int:
    return int(np.argmax(np.abs(shares)))


def model_difference(run: MechanismRun, model: RodModelName) -> ModelDifference:
    """Compare the load of the first crankpin by another rod model with that of a run."""
    return ModelDifference(
        (run.forces.model, model),
        run.crankpins[0],
        crankpin_loads(_with_model(run, model))[0],
        run.layout.cylinders[0].area,
    )


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
    records = []
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
        records.append(
            {
                "cylinders": [number for number, own in enumerate(rods, start=1) if own == rod],
                "models": rows,
            }
        )
    return records


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


def model_difference_table(difference: ModelDifference) -> Table | None:
    """Return the loads of a difference by shaft angle, unless both are the same."""
    first, second = difference.models
    if not difference.largest_of_mean:
        return None
    degrees = difference.first.angles_deg
    wanted = np.arange(math.ceil(degrees[0] / ROW_STEP) * ROW_STEP, degrees[-1] + 1e-6, ROW_STEP)
    rows = [int(np.argmin(np.abs(degrees - angle))) for angle in wanted]
    pressure = 1e-3 / difference.piston_area
    return Table(
        f"Load of {difference.crankpin}, rods as {first} and as {second}",
        [
            Column("shaft angle", "deg"),
            *(Column(name, "kN") for name in difference.models),
            Column("change", "%", decimals=2),
            Column("of mean", "%", decimals=2),
        ],
        [
            [
                math.radians(degrees[row]),
                *(size[row] for size in difference.sizes),
                difference.of_same_angle[row],
                difference.of_mean[row],
            ]
            for row in rows
        ],
        note=f"1 kN over the area of the piston is {pressure:.4g} MPa. Change: from {first} to {second}, in "
        f"percent of {first} at the same angle, and of its mean.",
    )


def model_difference_sentence(difference: ModelDifference, units: OutputUnits = SI) -> str:
    """State the difference between two models."""
    first, second = difference.models
    if not difference.largest_of_mean:
        return f"Load of {difference.crankpin}: the same, to round-off, as {second} and as {first}."

    def share(name: str) -> str:
        return f"{100.0 * getattr(difference, name):+.2f} %"

    def at(name: str) -> str:
        return units.of("deg").with_name(math.radians(getattr(difference, f"{name}_deg")))

    same, mean = "largest_of_same_angle", "largest_of_mean"
    return (
        f"Load of {difference.crankpin}, from {first} to {second}: it changes by up to {share(same)} of its "
        f"size at the same angle (at {at(same)}), or {share(mean)} of its mean (at {at(mean)}); its mean "
        f"changes by {share('mean')}, its maximum by {share('maximum')}."
    )


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


def acceleration_parts(record: Record, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return the orders of an `acceleration_record`, the remainder, and how hinged pistons differ."""
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
    yield Table(
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

    def apart(row: Record, which: str) -> str:
        value = units.of("m/s^2").with_name(row[which])
        angle = units.of("deg").with_name(math.radians(row[f"{which}_deg"]))
        return f"{value} at {angle} ({abs(100.0 * row[which] / row['mean_largest']):.2g} %)"

    for row in record["differences"]:
        yield (
            f"Acceleration, cylinder {main['cylinder']} less cylinder {row['cylinder']}, at the same alpha: "
            f"{apart(row, 'least')} to {apart(row, 'largest')}; percent of the mean of both largest "
            "accelerations."
        )


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
        "rated": None if mechanism.power is None else mechanism.power.to_record(),
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
        "rod_models": compare_rod_models(run),
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


def intervals_text(intervals_deg: Sequence[float], units: OutputUnits) -> str:
    """Say at which intervals an engine fires; of intervals that repeat, each once."""
    repeated = repeating_intervals(intervals_deg)
    angle = units.of("deg")
    steps = ", ".join(angle.number(math.radians(step)) for step in repeated)
    if len(repeated) == 1:
        return f"fires every {steps} {angle.name}"
    again = " in turn" if len(repeated) < len(intervals_deg) else ""
    return f"fires at intervals of {steps} {angle.name}{again}"


def mechanism_parts(record: Record, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return tables and sentences of a `mechanism_record`."""
    torque, moment = record["torque"], units.of("kN m")
    yield (
        f"{record['engine']} at {units.of('1/min').with_name(record['speed_rpm'] / RPM, 5)}, rods as "
        f"{record['rod_model']}: indicated power {units.of('kW').with_name(record['power'])}, mean indicated "
        f"pressure {units.of('MPa').with_name(record['mean_indicated_pressure'])}, torque "
        f"{moment.with_name(torque['mean'])} ({moment.number(torque['smallest'])} to "
        f"{moment.with_name(torque['largest'])}); {intervals_text(record['firing_intervals_deg'], units)}."
    )
    rated = record["rated"]
    if rated is not None and rated["rated_power"] is not None:
        yield units.text(f"{rated['sentence'][0].upper()}{rated['sentence'][1:]}.")
    tables = (
        make(record) for make in (cylinder_table, crankpin_table, bearing_table, rod_model_table)
    )
    yield from filter(None, tables)
    yield (
        "Check: the work of the torque differs from the indicated work, the integral of p dV, by "
        f"{abs(record['energy_error']):.1e} of the work exchanged."
    )
    for remark in record["remarks"]:  # assumed values of the cycle are in the list of assumptions
        if not remark.startswith(ASSUMED):
            yield units.text(f"Note: {remark.rstrip('.')}.")
    if record["assumed"]:
        yield (
            f"Assumed, not given ({len(record['assumed'])} values; crankfem check lists them with their "
            "reasons): " + ", ".join(entry["field"] for entry in record["assumed"]) + "."
        )


def rod_parts(record: Record, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return the equivalent masses of the rods, and the load by two models, if there are two."""
    yield rod_mass_table(record["rod_masses"])
    difference = record["model_difference"]
    if difference is not None:
        if table := model_difference_table(difference):
            yield table
        yield model_difference_sentence(difference, units)
