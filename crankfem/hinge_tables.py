"""The tables of `crankfem hinge`, from its record."""

import re

from crankfem import console
from crankfem.console import number, print_table
from crankfem.record import Record


def print_hinge(record: Record) -> None:
    """Print the results of a hinge."""
    _print_moment(record)
    _print_profile(record)
    _print_turning(record)
    if record["other_speeds"]:
        _print_others(record)
    if record["compared"]:
        _print_compared(record["compared"])
    assumed = record["assumed"]
    if assumed:
        _say(
            f"Assumed, not given ({len(assumed)} values): "
            + ", ".join(dict.fromkeys(_field(entry["field"]) for entry in assumed))
            + "; the reasons stand in the file and in --json."
        )


def _print_moment(record: Record) -> None:
    moment = record["hinge_moment"]
    print_table(
        f"{record['engine']} at {record['speed_rpm']:.4g} 1/min: moments on the crank "
        f"({record['kinematics']} kinematics)",
        ["", "kN m", "at [deg]"],
        [
            ["load M_r", _kilo(moment["load"]), ""],
            ["largest M_h", _kilo(moment["largest"]), f"{moment['largest_at_deg']:.1f}"],
            ["least M_h", _kilo(moment["least"]), f"{moment['least_at_deg']:.1f}"],
        ],
    )
    low, high = moment["reduced_inertia"]
    _say(
        f"Reduced inertia {low:.4g} to {high:.4g} kg m^2; the hinge stores and gives "
        f"{moment['energy_swing'] / 1e3:.4g} kJ a turn; integral of M_h over the turn "
        f"{abs(moment['closing_error']):.1e} of that of its absolute value."
    )
    _say(
        "Largest difference of M_h to exact kinematics, by the largest M_h: "
        + ", ".join(
            f"{name} {100.0 * share:.2g} %"
            for name, share in record["kinematics_deviation"].items()
        )
        + "."
    )


def _print_profile(record: Record) -> None:
    spring, profile = record["spring"], record["profile"]
    print_table(
        f"Guides for a gas spring of {spring['pressure'] / 1e6:.4g} MPa, "
        f"{spring['height'] * 1e3:.4g} mm high, n = {spring['exponent']:g}",
        ["", "value", "unit:"],
        [
            ["radius, smallest", number(profile["smallest_radius"] * 1e3), "mm"],
            ["radius, largest", number(profile["largest_radius"] * 1e3), "mm"],
            ["compression z, largest", number(profile["largest_compression"] * 1e3), "mm"],
            ["gas pressure, largest", number(profile["largest_pressure"] / 1e6), "MPa"],
            ["force on a roller, largest", _kilo(profile["largest_normal_force"]), "kN"],
            ["off the spring's axis", number(profile["largest_force_angle_deg"]), "deg"],
        ],
    )
    print_table(
        "Can it be made",
        ["check", "found", "limit", "met:"],
        [
            [
                f"{check['name']} [{'MPa' if check['unit'] == 'Pa' else 'mm'}]",
                "none" if check["value"] is None else _shown(check["value"], check["unit"]),
                f"> {_shown(check['limit'], check['unit'])}",
                "yes" if check["met"] else f"no: {check['meaning']}",
            ]
            for check in profile["checks"]
        ],
    )
    for remark in profile["remarks"]:
        _say(f"Note: {remark}")


def _print_turning(record: Record) -> None:
    turning = record["turning"]
    hinge, without, wheel = turning["with_hinge"], turning["without"], turning["flywheel"]
    print_table(
        "Crank let turn under the constant load",
        ["", "mean [1/min]", "fluctuation (max - min)/mean"],
        [
            ["with the hinge", f"{hinge['mean_speed_rpm']:.2f}", f"{hinge['fluctuation']:.3g}"],
            [
                "without, from the same speed at the top",
                f"{without['mean_speed_rpm']:.2f}",
                f"{without['fluctuation']:.3g}",
            ],
            [
                f"without, flywheel of {wheel['inertia']:,.0f} kg m^2",
                f"{wheel['mean_speed_rpm']:.2f}",
                f"{wheel['fluctuation']:.3g}",
            ],
        ],
    )
    _say(f"The hinge leaves {turning['remaining_share']:.2g} of the fluctuation without it.")
    if not without["comes_round_at_mean_speed"]:
        _say(f"Note: without hinge and flywheel, {without['reason']}")


def _print_others(record: Record) -> None:
    print_table(
        "The same guides at other running points: the start pressure that evens most",
        [
            "1/min",
            "M_r [kN m]",
            "p_0 [MPa]",
            "ratio",
            "fluctuation",
            "M_h lacks [%]",
        ],
        [
            [
                f"{other['speed_rpm']:.4g}",
                _kilo(other["hinge_moment"]["load"]),
                number(other["best_pressure"] / 1e6),
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
        _say(
            f"At {other['speed_rpm']:.4g} 1/min with the pressure unchanged {fate}; a fluctuation of "
            f"{wanted:.3g} takes a flywheel of {other['flywheel_with_hinge']:,.0f} kg m^2 with the best "
            f"pressure, {other['flywheel_without_hinge']:,.0f} kg m^2 without the hinge."
        )


def _print_compared(compared: list[Record]) -> None:
    print_table(
        "Guides by size and pressure: radii, largest pressure, steepest force on a roller",
        ["H [mm]", "rho_0 [mm]", "p_0 [MPa]", "rho [mm]", "p [MPa]", "off axis [deg]"],
        [
            [
                number(entry["height"] * 1e3),
                number(entry["start_radius"] * 1e3),
                number(entry["pressure"] / 1e6),
                *(
                    ["cannot be made", "", ""]
                    if "refused" in entry
                    else [
                        f"{entry['smallest_radius'] * 1e3:.4g} to {entry['largest_radius'] * 1e3:.4g}",
                        number(entry["largest_pressure"] / 1e6),
                        f"{entry['largest_force_angle_deg']:.1f}",
                    ]
                ),
            ]
            for entry in compared
        ],
    )
    for entry in compared:
        if "refused" in entry:
            _say(f"Note: {entry['refused']}")


def _field(name: str) -> str:
    """Return the name of a field without the number of its table."""
    return re.sub(r"\[\d+\]", "", name)


def _kilo(value: float) -> str:
    return number(value / 1e3)


def _shown(value: float, unit: str) -> str:
    return number(value / 1e6 if unit == "Pa" else value * 1e3)


def _say(text: str) -> None:
    console.output.print(text, soft_wrap=True, highlight=False)
