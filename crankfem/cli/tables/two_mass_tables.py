"""Output of the command two-mass, from its plain record."""

from crankbase.tables.table import SI, Column, OutputUnits, Table, table_unit
from crankbase.units.units import RPM
from crankfem.analyses.record import Record
from crankfem.cli.console import print_line, print_table

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
    said = ""
    if running is not None:
        where = "inside" if running[0] <= speed <= running[1] else "outside"
        said = f", {where} the running range of {running[0]:.4g} to {running[1]:.4g} 1/min"
    print_line(units.text(f"Order {record['order']:g} resonates at {speed:.1f} 1/min{said}."))
    print_line(units.text(record["statement"]))
    if record["resonances"]:
        print_table(
            Table.of_records(
                f"Resonances in the running range, orders up to {record['highest_order']:g}",
                record["resonances"],
                (Column("order", digits=None), "order"),
                (Column("speed", "1/min", decimals=1), lambda one: one["speed_rpm"] / RPM),
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
