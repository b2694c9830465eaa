"""Results of a crank mechanism: torque, forces, loads of bearings, and their tables."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.quantity import RPM
from crankbase.results import Flat, Internal, Number, Quantity, Result, Speed, result
from crankbase.sentences import capital, kept
from crankbase.table import SI, Column, Main, OutputUnits, Table, format_names
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.mechanism.engine_balance import EngineBalance, engine_balance, per_area_table
from crankfem.analyses.mechanism.hinged_rods import (
    PistonAccelerations,
    hinged_rod_table,
    motion_columns,
    piston_accelerations,
)
from crankfem.analyses.mechanism.mechanism_run import CylinderWork, MechanismRun, hinged_group
from crankfem.analyses.mechanism.rod_models import (
    ROUND_OFF,
    ModelComparison,
    ModelDifference,
    RodOfCylinders,
    compare_rod_models,
    model_difference,
    rod_mass_table,
    rod_masses,
)
from crankfem.analyses.record import AssumedInput, assumed_values
from crankfem.files.engine.engine_file import EngineFile
from dynamics.balance import HingedRodEffects
from dynamics.cycle import cycle_radians
from dynamics.engine import RodModelName
from dynamics.engine.forces import LoadDiagram, pin_groups
from dynamics.engine.layout import EngineCylinder, firing_intervals, repeating_intervals
from dynamics.excitation.pressure_map import EnginePower, indicated_power

Degrees = Annotated[float, Quantity("deg")]
Newton = Annotated[float, Quantity("N")]
NewtonMeter = Annotated[float, Quantity("N m")]
Pascal = Annotated[float, Quantity("Pa")]
LOAD_COLUMNS = (
    Column("mean", "kN"),
    Column("largest", "kN"),
    Column("at", "deg"),
    Column("mean", "MPa"),
    Column("largest", "MPa"),
)


MECHANISM_SECTIONS = ("engine", "rod", "piston", "hinged_rods", "gas")


@result("name", "mean", "largest", eq=True)
class BearingLoad(Result):
    """Load and specific pressure of a crankpin or main bearing.

    Parameters
    ----------
    largest_angle_deg : float
        Shaft angle of the largest load.
    cylinders : tuple of int or None
        With rods on a crankpin.
    largest_angle_from_firing_deg : float or None
        On a crankpin, from the firing top of the cylinder whose rod is on it.
    """

    name: str
    mean: Newton
    largest: Newton
    largest_angle_deg: Degrees
    diameter: Annotated[float, Quantity("m")]
    length: Annotated[float, Quantity("m")]
    mean_specific_pressure: Pascal
    largest_specific_pressure: Pascal
    cylinders: Annotated[tuple[int, ...] | None, Quantity("1", left_out=True)] = None
    largest_angle_from_firing_deg: Annotated[float | None, Quantity("deg", left_out=True)] = None

    def cells(self, degrees: float) -> list[float]:
        """Return what stands in the columns of loads in a table, with an angle."""
        return [
            self.mean,
            self.largest,
            math.radians(degrees),
            self.mean_specific_pressure,
            self.largest_specific_pressure,
        ]


@result("mean", "smallest", "largest", eq=True)
class TorqueRange(Result):
    """Torque over the cycle, and the shaft angles of its ends."""

    mean: NewtonMeter
    smallest: NewtonMeter
    smallest_angle_deg: Degrees
    largest: NewtonMeter
    largest_angle_deg: Degrees


@result("engine", "speed", "torque: torque.mean [N m]", "power", "crankpins", "main_bearings")
class MechanismResults(Result):
    """Forces in an engine's mechanism over one cycle at constant speed.

    Parameters
    ----------
    firing_intervals_deg : tuple of float
        From each firing to the next, in the firing order.
    mean_indicated_pressure : float
        Mean of the cylinders, each by its swept volume.
    rated : EnginePower or None
        What the file gives of the rated power.
    energy_error : float
        Of the work of the torque, as a share of the work exchanged.
    remarks : tuple of str
        On rods and gas.
    notes : tuple of str
        Those of the remarks that no assumed value tells.
    """

    engine: str
    speed: Speed
    rod_model: RodModelName
    firing_angles_deg: Annotated[tuple[float, ...], Quantity("deg")]
    firing_intervals_deg: Annotated[tuple[float, ...], Quantity("deg")]
    angle_step_deg: Degrees
    power: Annotated[float, Quantity("W")]
    mean_indicated_pressure: Pascal
    rated: EnginePower | None
    torque: TorqueRange
    energy_error: Number
    cylinders: tuple[CylinderWork, ...]
    crankpins: tuple[BearingLoad, ...]
    main_bearings: tuple[BearingLoad, ...]
    rod_models: tuple[ModelComparison, ...]
    assumed: tuple[AssumedInput, ...]
    remarks: tuple[str, ...]
    balance: EngineBalance
    notes: Internal[tuple[str, ...]] = ()

    def bearing_table(self) -> Table:
        """Return loads and specific pressures of the main bearings."""
        return Table(
            "Main bearings, each throw supported by its two bearings, shaft angle",
            [Column("bearing", words=True), *LOAD_COLUMNS],
            [
                [str(place), *load.cells(load.largest_angle_deg)]
                for place, load in enumerate(self.main_bearings, start=1)
            ],
            main=True,
            weights=[load.largest for load in self.main_bearings],
        )

    @property
    def _driven(self) -> bool:
        return self.rated is not None and bool(self.rated.driven)

    def answer(self, units: OutputUnits = SI) -> str:
        """State power and torque."""
        torque, moment = self.torque, units.of("kN m")
        firing = intervals_text(self.firing_intervals_deg, units, driven=self._driven)
        taken = ", which the machine takes" if self._driven else ""
        return (
            f"{self.engine} at {units.of('1/min').with_name(self.speed, 5)}, rods as "
            f"{self.rod_model}: indicated power {units.of('kW').with_name(self.power)}, mean indicated "
            f"pressure {units.of('MPa').with_name(self.mean_indicated_pressure)}, torque "
            f"{moment.with_name(torque.mean)} ({moment.number(torque.smallest)} to "
            f"{moment.with_name(torque.largest)}){taken}; {firing}."
        )

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return tables and sentences, but for the balance and the answer."""
        if self.rated is not None and self.rated.rated is not None:
            yield Main(units.written(f"{capital(self.rated.sentence)}."))
        top = "top" if self._driven else "firing top"
        yield Table(
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
                    str(row.cylinder),
                    row.peak_pressure,
                    math.radians(row.peak_angle_deg),
                    row.mean_effective_pressure,
                    row.largest_side_force,
                    row.largest_piston_pin_force,
                    row.largest_tangential_force,
                ]
                for row in self.cylinders
            ],
            note=f"p: peak pressure, absolute, and its angle from the {top}; p_i: mean indicated "
            "pressure; N, pin, T: largest side force, piston-pin force and tangential force.",
            merged=True,
            main=True,
        )
        yield Table(
            f"Crankpin bearings, angle from the {top} of the cylinder whose rod is on the pin",
            [Column("cylinder", words=True), *LOAD_COLUMNS],
            [
                [
                    "+".join(map(str, load.cylinders or ())),
                    *load.cells(load.largest_angle_from_firing_deg or 0.0),
                ]
                for load in self.crankpins
            ],
            merged=True,
            main=True,
            weights=[load.largest for load in self.crankpins],
        )
        yield self.bearing_table()
        # A rod's data may make all models equal.
        if any(row.crankpin >= ROUND_OFF for row in self.rod_models):
            yield Table(
                "Rod models compared with the rigid rod, largest differences",
                [
                    Column("model", words=True),
                    Column("crankpin force / its mean", "%", decimals=2),
                    Column("side force / its largest", "%", decimals=2),
                ],
                [[row.model, row.crankpin, row.side] for row in self.rod_models],
            )
        yield (
            "Check: the work of the torque differs from the indicated work, the integral of p dV, by "
            f"{abs(self.energy_error):.1e} of the work exchanged."
        )
        yield from (units.written(f"Note: {kept(remark).rstrip('.')}.") for remark in self.notes)
        if self.assumed:
            yield (
                f"Assumed, not given ({len(self.assumed)} values; crankfem check lists them with their "
                "reasons): " + ", ".join(entry.field for entry in self.assumed) + "."
            )


@result("results", "rod_masses", "hinged_rods", "accelerations")
class MechanismDetails(Result):
    """Results of a mechanism, with the masses of its rods and its hinged rods.

    Parameters
    ----------
    model_difference : ModelDifference or None
        None of a single model.
    rods_shown : bool
        Whether the masses of the rods are among the parts.
    """

    results: Flat[MechanismResults]
    rod_masses: tuple[RodOfCylinders, ...]
    model_difference: ModelDifference | None
    hinged_rods: tuple[HingedRodEffects, ...]
    accelerations: PistonAccelerations | None
    rods_shown: Internal[bool] = False
    cylinders: Internal[tuple[EngineCylinder, ...]] = ()
    pictures: tuple[str, ...] = ()

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return tables and sentences, but for the answer."""
        yield from self.results.parts(units)
        if self.rods_shown:
            yield rod_mass_table(self.rod_masses)
        if self.model_difference is not None:
            yield from self.model_difference.parts(units)
        yield from self.results.balance.parts(units)
        yield per_area_table(self.cylinders, self.results.balance.balance, units)
        if self.accelerations is not None:
            yield hinged_rod_table(self.hinged_rods)
            yield from self.accelerations.parts(units)


def mechanism_details(
    run: MechanismRun, compared: RodModelName | None = None, *, rods_shown: bool = False
) -> MechanismDetails:
    """Return the results of a mechanism with those of its rods, by another model, too, if asked for."""
    group = hinged_group(run.layout)
    return MechanismDetails(
        results=mechanism_results(run),
        rod_masses=rod_masses(run.layout),
        model_difference=None if compared is None else model_difference(run, compared),
        hinged_rods=run.hinged_rods,
        accelerations=piston_accelerations(run.layout, run.speed, group) if group else None,
        rods_shown=rods_shown,
        cylinders=tuple(run.layout.cylinders),
    )


def mechanism_results(run: MechanismRun) -> MechanismResults:
    """Return the results of a mechanism."""
    engine_file, forces, torque = run.engine_file, run.forces, run.torque.total
    pins, journals = bearing_sizes(engine_file)
    angles = forces.shaft_angles_deg
    least, most = int(np.argmin(torque)), int(np.argmax(torque))
    # Remarks on some cylinders only have their numbers.
    whose: dict[str, list[str]] = {}
    for place, pressure in enumerate(run.pressure, start=1):
        for remark in pressure.remarks:
            whose.setdefault(remark, []).append(str(place))
    gas = [
        remark
        if len(places) == len(run.pressure)
        else f"Cylinder{'s' if len(places) > 1 else ''} {format_names(places)}: "
        f"{remark[0].lower()}{kept(remark[1:])}"
        for remark, places in whose.items()
    ]
    crankpins = []
    for load, group in zip(run.crankpins, pin_groups(run.layout), strict=True):
        # From the firing top of the first rod's own cylinder.
        firing = np.radians(run.layout.firing_deg[group[0] - 1])
        after = (math.radians(load.maximum_angle_deg) - firing) % cycle_radians(run.layout.strokes)
        crankpins.append(
            replace(
                _bearing_load(load, pins[engine_file.throws[group[0] - 1]]),
                cylinders=group,
                largest_angle_from_firing_deg=float(np.degrees(after)),
            )
        )
    assumed = set[str]().union(*(pressure.assumed for pressure in run.pressure))
    return MechanismResults(
        engine=engine_file.engine.name,
        speed=run.speed,
        rod_model=forces.model,
        firing_angles_deg=run.layout.firing_deg,
        firing_intervals_deg=mechanism_intervals(run),
        angle_step_deg=float(angles[1] - angles[0]),
        power=run.torque.power,
        mean_indicated_pressure=indicated_power(run.layout, run.pressure, run.speed)[1],
        rated=engine_file.power,
        torque=TorqueRange(
            run.torque.mean,
            float(torque[least]),
            float(angles[least]),
            float(torque[most]),
            float(angles[most]),
        ),
        energy_error=run.torque.energy_error,
        cylinders=run.works,
        crankpins=tuple(crankpins),
        main_bearings=tuple(map(_bearing_load, run.bearings, journals)),
        rod_models=compare_rod_models(run),
        assumed=assumed_values(
            record
            for record in input_values(engine_file)
            if record.field.partition(".")[0] in MECHANISM_SECTIONS
        ),
        remarks=(*engine_file.remarks, *gas),
        balance=engine_balance(run),
        notes=(*engine_file.remarks, *(remark for remark in gas if remark not in assumed)),
    )


def mechanism_intervals(run: MechanismRun) -> tuple[float, ...]:
    """Return the angles from each firing to the next, in the firing order [deg]."""
    layout = run.layout
    fired = [np.radians(layout.firing_deg[int(number) - 1]) for number in layout.firing_order]
    intervals = firing_intervals(fired, layout.strokes)
    return tuple(round(math.degrees(step), 6) for step in intervals)


Size = tuple[float, float]


def bearing_sizes(engine_file: EngineFile) -> tuple[list[Size], list[Size]]:
    """Return diameter and length [m] for one rod on the pin of each crank, and of each main bearing."""
    throws = engine_file.crank_throws
    pins = throws[0].parts.pins
    main = set(range(1, len(engine_file.throws) + 1)) - {
        number
        for number, cylinder in enumerate(engine_file.layout.cylinders, start=1)
        if cylinder.slave_pin is not None
    }
    on_first = sum(engine_file.throws[number - 1] == 0 for number in main)
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


def _bearing_load(load: LoadDiagram, size: Size) -> BearingLoad:
    pressure = load.specific_pressure(*size)
    return BearingLoad(
        load.name,
        load.mean,
        load.maximum,
        load.maximum_angle_deg,
        *size,
        mean_specific_pressure=float(pressure.mean()),
        largest_specific_pressure=float(pressure.max()),
    )


def force_columns(
    run: MechanismRun, compared: ModelDifference | None = None
) -> tuple[dict[str, Array], str]:
    """Return the forces over the shaft angle by name with unit, and a description.

    With the motion of pistons and rods and, if two rod models are compared, the forces of the first
    cylinder and its crankpin by them.
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
    cylinders = range(1, len(run.layout.cylinders) + 1)
    angles = np.radians(run.forces.shaft_angles_deg)
    columns |= motion_columns(run.layout, run.speed, cylinders, angles)
    if compared is not None:
        for model, load in zip(compared.models, (compared.first, compared.second), strict=True):
            columns[f"{load.name.replace(', ', '_').replace(' ', '_')}_{model}_N"] = load.magnitude
        changes = compared.force_changes.items()
        columns |= {f"difference_{force}_N": values for force, values in changes}
        columns["difference_of_same_angle"] = compared.of_same_angle
        columns["difference_of_mean"] = compared.of_mean
    heading = (
        f"{run.engine_file.engine.name}, {run.speed * RPM:.10g} 1/min, rods as {run.forces.model}"
    )
    return columns, heading


def intervals_text(
    intervals_deg: Sequence[float], units: OutputUnits, *, driven: bool = False
) -> str:
    """Say at which intervals an engine fires, or a driven machine has tops; of repeated ones each once."""
    does = "comes to a top" if driven else "fires"
    repeated = repeating_intervals(intervals_deg)
    angle = units.of("deg")
    steps = ", ".join(angle.number(math.radians(step)) for step in repeated)
    if len(repeated) == 1:
        return f"{does} every {steps} {angle.name}"
    again = " in turn" if len(repeated) < len(intervals_deg) else ""
    return f"{does} at intervals of {steps} {angle.name}{again}"
