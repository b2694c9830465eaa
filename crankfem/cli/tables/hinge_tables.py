"""The tables of `crankfem hinge`, from its record."""

import math
import re

from crankbase.quantity import RPM
from crankbase.table import SI, Cell, Column, OutputUnit, OutputUnits, Table
from crankfem.analyses.record import Record
from crankfem.cli.console import print_line, print_notes, print_table


def print_hinge(record: Record, units: OutputUnits = SI) -> None:
    """Print the results of a hinge."""
    _print_moment(record, units)
    _print_profile(record, units)
    _print_turning(record, units)
    if record["other_speeds"]:
        _print_others(record, units)
    if record["compared"]:
        _print_compared(record["compared"], units)
    assumed = record["assumed"]
    if assumed:
        print_line(
            f"Assumed, not given ({len(assumed)} values): "
            + ", ".join(dict.fromkeys(_field(entry["field"]) for entry in assumed))
            + "; the file and --json give the reasons."
        )


def _print_moment(record: Record, units: OutputUnits) -> None:
    moment = record["hinge_moment"]
    print_table(
        Table(
            units.text(
                f"{record['engine']} at {record['speed_rpm']:.4g} 1/min: moments on the crank "
                f"({record['kinematics']} kinematics)"
            ),
            [
                Column("", words=True),
                Column("", "kN m"),
                Column("at", "deg", decimals=1, missing=""),
            ],
            [
                ["load M_r", moment["load"], None],
                *(
                    [f"{name} M_h", moment[name], math.radians(moment[f"{name}_at_deg"])]
                    for name in ("largest", "least")
                ),
            ],
        ),
        units,
    )
    low, high = moment["reduced_inertia"]
    print_line(
        units.text(
            f"Reduced inertia {low:.4g} to {high:.4g} kg m^2; the hinge stores and returns "
            f"{moment['energy_swing'] / 1e3:.4g} kJ per revolution; integral of M_h over a revolution "
            f"{abs(moment['closing_error']):.1e} of that of its absolute value."
        )
    )
    print_line(
        "Largest difference of M_h to exact kinematics, by the largest M_h: "
        + ", ".join(
            f"{name} {100.0 * share:.2g} %"
            for name, share in record["kinematics_deviation"].items()
        )
        + "."
    )


def _print_profile(record: Record, units: OutputUnits) -> None:
    spring, profile = record["spring"], record["profile"]
    surface = profile["surface"] or {}
    length, pressure = units.of("mm"), units.of("MPa")
    print_table(
        Table(
            f"Guides for a gas spring of {pressure.with_name(spring['pressure'])}, "
            f"{length.with_name(spring['height'])} high, n = {spring['exponent']:g}",
            [Column("", words=True), Column("value"), Column("unit", words=True)],
            [
                [name, unit.number(value), unit.name]
                for name, value, unit in (
                    ("radius, smallest", profile["smallest_radius"], length),
                    ("radius, largest", profile["largest_radius"], length),
                    *(
                        (
                            f"surface of the rollers' guides, {name}",
                            surface[f"{name}_radius"],
                            length,
                        )
                        for name in ("smallest", "largest")
                        if surface
                    ),
                    ("compression z, largest", profile["largest_compression"], length),
                    ("gas pressure, largest", profile["largest_pressure"], pressure),
                    ("force on a roller, largest", profile["largest_normal_force"], units.of("kN")),
                    (
                        "off the spring's axis",
                        math.radians(profile["largest_force_angle_deg"]),
                        units.of("deg"),
                    ),
                )
            ],
        )
    )

    def unit(check: Record) -> OutputUnit:
        return pressure if check["unit"] == "Pa" else length

    def reached(check: Record) -> str | None:
        return None if check["value"] is None else unit(check).number(check["value"])

    print_table(
        Table.of_records(
            "Feasibility",
            profile["checks"],
            (Column("check", words=True), lambda check: f"{check['name']} [{unit(check).name}]"),
            (Column("found"), reached),
            (Column("limit"), lambda check: f"> {unit(check).number(check['limit'])}"),
            (
                Column("met", words=True),
                lambda check: "yes" if check["met"] else f"no: {check['meaning']}",
            ),
        )
    )
    print_notes(profile["remarks"], units)


def _print_turning(record: Record, units: OutputUnits) -> None:
    turning = record["turning"]
    hinge, without, wheel = turning["with_hinge"], turning["without"], turning["flywheel"]
    print_table(
        Table(
            "Crank turning freely under the constant load",
            [
                Column("", words=True),
                Column("mean", "1/min", decimals=2),
                Column("fluctuation (max - min)/mean", digits=3),
            ],
            [
                [name, case["mean_speed_rpm"] / RPM, case["fluctuation"]]
                for name, case in (
                    ("with the hinge", hinge),
                    ("without, from the same speed at the top", without),
                    (f"without, flywheel of {_inertia(wheel['inertia'], units)}", wheel),
                )
            ],
        ),
        units,
    )
    print_line(f"The hinge leaves {turning['remaining_share']:.2g} of the fluctuation.")
    if not without["comes_round_at_mean_speed"]:
        print_line(units.text(f"Note: without hinge and flywheel, {without['reason']}"))


def _print_others(record: Record, units: OutputUnits) -> None:
    speed = units.of("1/min")
    print_table(
        Table.of_records(
            "The same guides at other running points: start pressure with the smallest fluctuation",
            record["other_speeds"],
            (Column("", "1/min"), lambda other: other["speed_rpm"] / RPM),
            (Column("M_r", "kN m"), lambda other: other["hinge_moment"]["load"]),
            (Column("p_0", "MPa"), "best_pressure"),
            (Column("ratio", decimals=3), "best_ratio"),
            (Column("fluctuation", digits=3), "fluctuation"),
            (Column("M_h lacks", "%", 3, joint=", at most "), _lacking),
        ),
        units,
    )
    print_line(
        "M_h lacks: difference from the moment for constant speed, relative to it; first by root mean "
        "squares, then by largest values."
    )
    wanted = record["turning"]["flywheel"]["fluctuation"]
    for other in record["other_speeds"]:
        unchanged = other["fluctuation_unchanged"]
        fate = (
            "the crank does not complete a revolution"
            if unchanged is None
            else f"the fluctuation is {unchanged:.3g}"
        )
        print_line(
            f"At {speed.with_name(other['speed_rpm'] / RPM)} with the pressure unchanged {fate}; a "
            f"fluctuation of {wanted:.3g} takes a flywheel of "
            f"{_inertia(other['flywheel_with_hinge'], units)} with the best pressure, "
            f"{_inertia(other['flywheel_without_hinge'], units)} without the hinge."
        )


def _print_compared(compared: list[Record], units: OutputUnits) -> None:
    def radii(entry: Record) -> Cell:
        if "refused" in entry:
            return "not feasible"
        return entry["smallest_radius"], entry["largest_radius"]

    def angle(entry: Record) -> Cell:
        return None if "refused" in entry else math.radians(entry["largest_force_angle_deg"])

    print_table(
        Table.of_records(
            "Guides by size and pressure: radii, largest pressure, steepest force on a roller",
            compared,
            (Column("H", "mm"), "height"),
            (Column("rho_0", "mm"), "start_radius"),
            (Column("p_0", "MPa"), "pressure"),
            (Column("rho", "mm", joint=" to "), radii),
            (Column("p", "MPa", missing=""), lambda entry: entry.get("largest_pressure")),
            (Column("off axis", "deg", decimals=1, missing=""), angle),
        ),
        units,
    )
    print_notes((entry["refused"] for entry in compared if "refused" in entry), units)


def _lacking(other: Record) -> Cell:
    return other["moment_residual"], other["largest_residual"]


def _field(name: str) -> str:
    """Return the name of a field without the number of its table."""
    return re.sub(r"\[\d+\]", "", name)


def _inertia(value: float, units: OutputUnits) -> str:
    unit = units.of("kg m^2")
    return f"{value / unit.size:,.0f} {unit.name}"
