"""Tables of a crank mechanism on the command line: forces, balance, harmonics, rods of two masses."""

import math
from pathlib import Path

from crankbase.quantity import RPM
from crankbase.table import SI, Column, OutputUnits, Table, table_unit
from crankfem.analyses.mechanism.balance_records import (
    BALANCED_TEXT,
    balance_contents,
    balance_table,
    hinged_rod_table,
    moving_mass_table,
    throw_mass_table,
)
from crankfem.analyses.mechanism.mechanism_records import (
    COLUMNS,
    RESIDUALS,
    acceleration_sentences,
    acceleration_table,
    harmonics_record,
    harmonics_table,
    stars_record,
)
from crankfem.analyses.mechanism.rod_models import (
    bearing_table,
    crankpin_table,
    cylinder_table,
    model_difference_sentence,
    model_difference_table,
    rod_mass_table,
    rod_model_table,
)
from crankfem.analyses.record import ASSUMED, Record
from crankfem.cli.console import number, print_line, print_notes, print_table, write_rows
from crankfem.cli.tables.throw_tables import intervals_text
from crankfem.files.engine.mechanism_file import MechanismFile
from dynamics.torque import EngineTorque, PinForceHarmonics, star_diagram


def print_mechanism(record: Record, units: OutputUnits = SI) -> None:
    """Print the record of a mechanism as tables."""
    torque, moment = record["torque"], units.of("kN m")
    print_line(
        f"{record['engine']} at {units.of('1/min').with_name(record['speed_rpm'] / RPM, 5)}, rods as "
        f"{record['rod_model']}: indicated power {units.of('kW').with_name(record['power'])}, mean indicated "
        f"pressure {units.of('MPa').with_name(record['mean_indicated_pressure'])}, torque "
        f"{moment.with_name(torque['mean'])} ({moment.number(torque['smallest'])} to "
        f"{moment.with_name(torque['largest'])}); {intervals_text(record['firing_intervals_deg'], units)}."
    )
    rated = record["rated"]
    if rated is not None and rated["rated_power"] is not None:
        sentence = rated["sentence"]
        print_line(units.text(f"{sentence[0].upper()}{sentence[1:]}."))
    for make in (cylinder_table, crankpin_table, bearing_table, rod_model_table):
        table = make(record)
        if table is not None:
            print_table(table, units)
    print_line(
        "Check: the work of the torque differs from the indicated work, the integral of p dV, by "
        f"{abs(record['energy_error']):.1e} of the work exchanged."
    )
    for remark in record["remarks"]:  # assumed values of the cycle are in the list of assumptions
        if not remark.startswith(ASSUMED):
            print_line(units.text(f"Note: {remark.rstrip('.')}."))
    if record["assumed"]:
        print_line(
            f"Assumed, not given ({len(record['assumed'])} values; crankfem check lists them with their "
            "reasons): " + ", ".join(entry["field"] for entry in record["assumed"]) + "."
        )


def print_rod_models(record: Record, units: OutputUnits = SI) -> None:
    """Print the equivalent masses of the rods, and the load by two models, if there are two."""
    print_table(rod_mass_table(record["rod_masses"]), units)
    difference = record["model_difference"]
    if difference is not None:
        table = model_difference_table(difference)
        if table is not None:
            print_table(table, units)
        print_line(model_difference_sentence(difference, units))


def print_balanced_masses(record: Record, units: OutputUnits = SI) -> None:
    """Print which masses are in the balance of a `mechanism_balance_record`."""
    for make in (moving_mass_table, throw_mass_table):
        print_table(make(record), units)
    print_line(balance_contents(record, units))


def print_balance(record: Record, units: OutputUnits = SI) -> None:
    """Print the tables of forces and moments of `balance_record`."""
    for kind in ("force", "moment"):
        print_table(balance_table(record, kind, units), units)
    print_line(
        f'"{BALANCED_TEXT}": less than 1e-12 of all masses times R w^2. Axis of the largest value: from '
        "the vertical, in the sense of rotation."
    )


def print_hinged_rods(
    records: list[Record], accelerations: Record, units: OutputUnits = SI
) -> None:
    """Print the tables of `hinged_rods_record` and `acceleration_record`."""
    print_table(hinged_rod_table(records), units)
    print_table(acceleration_table(accelerations, units), units)
    for sentence in acceleration_sentences(accelerations, units):
        print_line(sentence)


SUMMED = "torque of all cylinders"
PARTS = ("gas", "inertia", "gas and inertia")


def engine_record(mechanism: MechanismFile, torque: EngineTorque, highest: float) -> Record:
    """Mean, power, harmonics of engine and throws, and the star of each order."""
    engine = torque.engine
    stars = star_diagram(engine, highest)
    remarks = list(mechanism.remarks)
    if not mechanism.pressure:
        remarks.append("the file has no section [gas]: the torque is that of moving masses alone")
    return {
        "engine": mechanism.name,
        "speed_rpm": torque.speed * RPM,
        "rod_model": "rigid",
        "strokes": engine.strokes,
        "mean": torque.mean,
        "power": torque.power,
        "nonuniformity": torque.nonuniformity,
        "indicated_work": torque.indicated_work.tolist(),
        "energy_error": torque.energy_error,
        "harmonics": harmonics_record(torque.harmonics().up_to(highest)),
        "throws": [
            {
                "cylinders": list(throw),
                "harmonics": harmonics_record(torque.harmonics(place).up_to(highest)),
            }
            for place, throw in enumerate(torque.throws, start=1)
        ],
        "firing_angles_deg": list(engine.firing_deg),
        "hinged_rods": any(cylinder.slave_pin is not None for cylinder in engine.cylinders),
        **stars_record(stars),
        "remarks": remarks,
    }


def pin_force_record(harmonics: PinForceHarmonics) -> Record:
    """Harmonics of one cylinder's tangential and radial force, phases from its firing top."""
    fields = ("tangential", "radial")
    return {
        "number": harmonics.number,
        "firing_angle_deg": harmonics.firing_angle_deg,
        **{
            field: {
                "gas": harmonics_record(getattr(harmonics, f"{field}_gas")),
                "inertia": harmonics_record(getattr(harmonics, f"{field}_inertia")),
                "gas and inertia": harmonics_record(getattr(harmonics, field)),
            }
            for field in fields
        },
    }


def print_engine(record: Record, units: OutputUnits = SI) -> None:
    """Print the torque of an engine, its harmonics and stars."""
    uneven = record["nonuniformity"]
    spread_text = "" if uneven is None else f", (largest - least) / mean {number(uneven)}"
    speed = units.of("1/min").with_name(record["speed_rpm"] / RPM, 5)
    print_line(
        f"{record['engine']} at {speed}: mean torque {_with_unit(record['mean'], 'N m', units)}, indicated "
        f"power {_with_unit(record['power'], 'W', units)}{spread_text}."
    )
    print_notes((f"{remark}." for remark in record["remarks"]), units)
    title = "Harmonics of the engine's torque"
    print_table(harmonics_table(record["harmonics"], title, units), units)
    throws = record["throws"]
    amplitudes = [throw["harmonics"]["amplitude"] for throw in throws]
    shown = table_unit(
        (value for throw_amplitudes in amplitudes for value in throw_amplitudes), "N m", units
    )
    print_table(
        Table(
            f"Amplitudes by throw [{shown.name}]",
            [
                Column("order", digits=None),
                *(
                    shown.column(
                        f"throw {place} (cyl. {', '.join(map(str, throw['cylinders']))})", bare=True
                    )
                    for place, throw in enumerate(throws, start=1)
                ),
            ],
            list(zip(record["harmonics"]["orders"], *amplitudes, strict=True)),
        ),
        units,
    )
    print_stars(record, units, hinged=record["hinged_rods"])


def print_table_harmonics(record: Record, usual: float, units: OutputUnits = SI) -> None:
    """Print the harmonics of a torque table, and the torque of the cylinders if firing is given.

    Orders above the usual ones are printed only if all requested orders are above.
    """
    kept = sum(order <= usual * (1.0 + 1e-9) for order in record["orders"])
    record = record | {name: record[name][:kept] for name in (*COLUMNS, *RESIDUALS)}
    mean = table_unit([record["mean"]], "N m", units).with_unit(record["mean"])
    print_line(
        f"Mean {mean}; {record['samples']} samples resolve orders up to "
        f"{record['highest_order']:g}."
    )
    print_table(harmonics_table(record, units=units), units)
    most, upto = record["residual_largest"][-1], f"The sum up to order {record['orders'][-1]:g}"
    if most <= 1e-9 * max(record["amplitude"]):
        print_line(f"{upto} matches every sample.")
    else:
        shown = table_unit([most], "N m", units).with_unit(most)
        print_line(f"{upto} differs from the samples by at most {shown}.")
    fired = record.get("cylinders")
    if fired is None:
        return
    mean = table_unit([fired["torque"]["mean"]], "N m", units).with_unit(fired["torque"]["mean"])
    angles = ", ".join(f"{angle:g}" for angle in fired["firing_angles_deg"])
    count = len(fired["firing_angles_deg"])
    those = "1 cylinder" if count == 1 else f"{count} cylinders, each"
    print_line(f"{those} with this torque, fired at {angles} deg: mean torque {mean}.")
    print_table(
        harmonics_table(fired["torque"], "Harmonics of the sum of all cylinders", units), units
    )
    print_stars(fired, units, hinged=False)
    print_notes(fired["remarks"], units)


def print_stars(record: Record, units: OutputUnits, *, hinged: bool) -> None:
    """Print the stars of a `stars_record`; with hinged rods, with the remark that they are incomplete."""
    like = {order: group for group in record["same_stars"] for order in group}
    print_table(
        Table.of_records(
            "Stars of the orders, all cylinders alike",
            record["stars"],
            (Column("order", digits=None), "order"),
            (Column("kind", words=True), "kind"),
            (Column("resultant / sum", decimals=4), "share"),
            (
                Column("vectors by cylinder", "deg", digits=None, words=True),
                lambda star: [math.radians(round(angle, 6)) for angle in star["directions_deg"]],
            ),
            (
                Column("same star as", digits=6, words=True),
                lambda star: [order for order in like[star["order"]] if order != star["order"]],
            ),
        ),
        units,
    )
    if hinged:
        print_line(
            "Cylinders with hinged rods differ from the others: an order with a balanced star can leave "
            "some torque, as the harmonics above show."
        )
    named = ", ".join(f"{order:g}" for order in record["leading_orders"])
    kinds = {star["kind"] for star in record["stars"]}
    heading = "Major orders" if "major" in kinds else "No order is major; the strongest"
    print_line(f"{heading}: {named}." if named else "All orders cancel.")


def print_pin_forces(record: Record, units: OutputUnits = SI) -> None:
    """Print the harmonics of one cylinder's forces on its crankpin."""
    for field, letter in (("tangential", "T"), ("radial", "Z")):
        parts = record[field]
        amplitudes = (value for part in PARTS for value in parts[part]["amplitude"])
        shown = table_unit(amplitudes, "N", units)
        mean = table_unit((parts[part]["mean"] for part in PARTS), "N", units)
        means = ", ".join(f"{part} {mean.text(parts[part]['mean'])}" for part in PARTS)
        title = units.text(
            f"Cylinder {record['number']}: {field} force {letter} on the crankpin, phases from its "
            f"firing top at {record['firing_angle_deg']:g} deg; mean [{mean.name}]: {means}"
        )
        columns, values = [Column("order", digits=None)], [parts["gas"]["orders"]]
        for part in PARTS:
            columns += [shown.column(f"{part} M_k"), Column(f"{part} a_k", "deg", decimals=2)]
            values += [parts[part]["amplitude"], map(math.radians, parts[part]["phase_deg"])]
        print_table(Table(title, columns, list(zip(*values, strict=True))), units)


def _with_unit(value: float, unit: str, units: OutputUnits) -> str:
    return table_unit([value], unit, units).with_unit(value)


def table_rows(record: Record) -> list[list[object]]:
    """Return the rows of a CSV file of harmonics: of a torque table or of an engine."""
    if "throws" not in record:
        fired = record.get("cylinders")
        rows = _rows("torque", "N m", record)
        return rows if fired is None else [*rows, *_rows(SUMMED, "N m", fired["torque"])]
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
    """Write harmonics as CSV; the first line names their quantity, the row of order 0 is the mean."""
    names = ["of", "unit", "order", *COLUMNS[1:]]
    if "throws" not in record:
        what = f"{record['table']}, {record['strokes']} strokes per cycle"
    else:
        speed = number(record["speed_rpm"], 10)
        what = f"{record['engine']}, {speed} 1/min, rods as {record['rod_model']}"
    write_rows(path, names, table_rows(record), what)


# Of the largest exciting torque; below are cylinders that cancel each other.
LEAST_SHARE = 1e-9


def print_two_masses(record: Record, units: OutputUnits = SI) -> None:
    """Print the natural frequency, resonances, their excitation and the torque in the shaft."""
    print_line(
        units.text(
            f"Two masses on one shaft of {record['stiffness'] / 1e3:.4g} kN m/rad: natural frequency "
            f"{record['frequency']:.2f} Hz, {record['angular_frequency']:.5g} rad/s, "
            f"{record['vibrations_per_minute']:.5g} vibrations per minute."
        )
    )
    speed, running = record["resonant_speed_rpm"], record["running_rpm"]
    within = ""
    if running is not None:
        where = "inside" if running[0] <= speed <= running[1] else "outside"
        within = f", {where} the running range of {running[0]:.4g} to {running[1]:.4g} 1/min"
    print_line(units.text(f"Order {record['order']:g} resonates at {speed:.1f} 1/min{within}."))
    print_line(units.text(record["statement"]))
    if record["resonances"]:
        print_table(
            Table.of_records(
                f"Resonances in the running range, orders up to {record['highest_order']:g}",
                record["resonances"],
                (Column("order", digits=None), "order"),
                (Column("speed", "1/min", decimals=1), lambda row: row["speed_rpm"] / RPM),
                (Column("M_k of one throw", "N m", missing="not resolved"), "amplitude"),
            ),
            units,
        )
    if record["shaft_torque"] is not None:
        _print_shaft_torque(record["shaft_torque"], units)


def _print_shaft_torque(record: Record, units: OutputUnits) -> None:
    names = ("orders", "exciting", "magnification", "torque")
    least = LEAST_SHARE * max(record["exciting"])
    rows = [row for row in zip(*(record[name] for name in names), strict=True) if row[1] > least]
    shown = table_unit(record["exciting"], "N m", units)
    print_table(
        Table(
            units.text(
                f"Torque in the shaft at {record['speed_rpm']:.4g} 1/min, without damping, by the table's "
                "orders that do not cancel"
            ),
            [
                Column("order", digits=None),
                shown.column("M_k of all cylinders"),
                Column("magnification", missing="unbounded"),
                Column(
                    "in the shaft",
                    shown.column("").unit,
                    missing="unbounded",
                    decimals=shown.decimals,
                ),
            ],
            rows,
        ),
        units,
    )
