"""The tables of `crankfem hinge`, from its record."""

import math
import re

from crankfem.console import print_line, print_table
from crankfem.output_units import SI, OutputUnits
from crankfem.record import Record
from geometry.units import RPM


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
            + "; the reasons stand in the file and in --json."
        )


def _print_moment(record: Record, units: OutputUnits) -> None:
    moment, shown, angle = record["hinge_moment"], units.of("kN m"), units.of("deg")
    print_table(
        units.text(
            f"{record['engine']} at {record['speed_rpm']:.4g} 1/min: moments on the crank "
            f"({record['kinematics']} kinematics)"
        ),
        ["", shown.name, f"at [{angle.name}]"],
        [
            ["load M_r", shown.number(moment["load"]), ""],
            *(
                [
                    f"{name} M_h",
                    shown.number(moment[name]),
                    angle.fixed(math.radians(moment[f"{name}_at_deg"]), 1),
                ]
                for name in ("largest", "least")
            ),
        ],
    )
    low, high = moment["reduced_inertia"]
    print_line(
        units.text(
            f"Reduced inertia {low:.4g} to {high:.4g} kg m^2; the hinge stores and gives "
            f"{moment['energy_swing'] / 1e3:.4g} kJ a turn; integral of M_h over the turn "
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
    length, pressure = units.of("mm"), units.of("MPa")
    print_table(
        f"Guides for a gas spring of {pressure.with_name(spring['pressure'])}, "
        f"{length.with_name(spring['height'])} high, n = {spring['exponent']:g}",
        ["", "value", "unit:"],
        [
            [name, unit.number(value), unit.name]
            for name, value, unit in (
                ("radius, smallest", profile["smallest_radius"], length),
                ("radius, largest", profile["largest_radius"], length),
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
    checks = [(check, pressure if check["unit"] == "Pa" else length) for check in profile["checks"]]
    print_table(
        "Can it be made",
        ["check", "found", "limit", "met:"],
        [
            [
                f"{check['name']} [{unit.name}]",
                "none" if check["value"] is None else unit.number(check["value"]),
                f"> {unit.number(check['limit'])}",
                "yes" if check["met"] else f"no: {check['meaning']}",
            ]
            for check, unit in checks
        ],
    )
    for remark in profile["remarks"]:
        print_line(units.text(f"Note: {remark}"))


def _print_turning(record: Record, units: OutputUnits) -> None:
    turning, speed = record["turning"], units.of("1/min")
    hinge, without, wheel = turning["with_hinge"], turning["without"], turning["flywheel"]
    print_table(
        "Crank let turn under the constant load",
        ["", f"mean [{speed.name}]", "fluctuation (max - min)/mean"],
        [
            [
                name,
                speed.fixed(found["mean_speed_rpm"] / RPM, 2),
                f"{found['fluctuation']:.3g}",
            ]
            for name, found in (
                ("with the hinge", hinge),
                ("without, from the same speed at the top", without),
                (f"without, flywheel of {_inertia(wheel['inertia'], units)}", wheel),
            )
        ],
    )
    print_line(f"The hinge leaves {turning['remaining_share']:.2g} of the fluctuation without it.")
    if not without["comes_round_at_mean_speed"]:
        print_line(units.text(f"Note: without hinge and flywheel, {without['reason']}"))


def _print_others(record: Record, units: OutputUnits) -> None:
    speed, moment, pressure = units.of("1/min"), units.of("kN m"), units.of("MPa")
    print_table(
        "The same guides at other running points: the start pressure that evens most",
        [
            speed.name,
            f"M_r [{moment.name}]",
            f"p_0 [{pressure.name}]",
            "ratio",
            "fluctuation",
            "M_h lacks [%]",
        ],
        [
            [
                speed.number(other["speed_rpm"] / RPM),
                moment.number(other["hinge_moment"]["load"]),
                pressure.number(other["best_pressure"]),
                f"{other['best_ratio']:.3f}",
                f"{other['fluctuation']:.3g}",
                f"{100.0 * other['moment_residual']:.3g}",
            ]
            for other in record["other_speeds"]
        ],
    )
    wanted = record["turning"]["flywheel"]["fluctuation"]
    for other in record["other_speeds"]:
        unchanged = other["fluctuation_unchanged"]
        fate = (
            "the crank does not come round"
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
    length, pressure, angle = units.of("mm"), units.of("MPa"), units.of("deg")
    print_table(
        "Guides by size and pressure: radii, largest pressure, steepest force on a roller",
        [
            f"H [{length.name}]",
            f"rho_0 [{length.name}]",
            f"p_0 [{pressure.name}]",
            f"rho [{length.name}]",
            f"p [{pressure.name}]",
            f"off axis [{angle.name}]",
        ],
        [
            [
                length.number(entry["height"]),
                length.number(entry["start_radius"]),
                pressure.number(entry["pressure"]),
                *(
                    ["cannot be made", "", ""]
                    if "refused" in entry
                    else [
                        f"{length.number(entry['smallest_radius'])} to "
                        f"{length.number(entry['largest_radius'])}",
                        pressure.number(entry["largest_pressure"]),
                        angle.fixed(math.radians(entry["largest_force_angle_deg"]), 1),
                    ]
                ),
            ]
            for entry in compared
        ],
    )
    for entry in compared:
        if "refused" in entry:
            print_line(units.text(f"Note: {entry['refused']}"))


def _field(name: str) -> str:
    """Return the name of a field without the number of its table."""
    return re.sub(r"\[\d+\]", "", name)


def _inertia(value: float, units: OutputUnits) -> str:
    unit = units.of("kg m^2")
    return f"{value / unit.size:,.0f} {unit.name}"
