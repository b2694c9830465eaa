"""The tables that the command line prints, from the plain records of a run."""

import math
from typing import Any

from crankfem.console import number, print_line, print_table
from crankfem.output_units import SI, OutputUnit, OutputUnits
from geometry.units import RPM


def print_throw(record: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print compliances, reactions and masses of a throw, from its record."""
    supports = record["supports"]
    axial, torsional = units.of("1e-9 m/N"), units.of("1e-9 rad/(N m)")
    force, moment = units.of("kN"), units.of("kN m")
    print_table(
        f"Throw by finite elements (error of e_n about {100.0 * record['error_estimate']:.2g} %)",
        [
            "support",
            f"e_n [{axial.name}]",
            f"torsional [{torsional.name}]",
            f"c [{axial.name}]",
            "P/Z",
        ],
        [
            [
                name,
                axial.number(s["axial_compliance"]),
                torsional.number(s["torsional_compliance"]),
                axial.number(s["influence_coefficient"]),
                number(s["axial_force_per_radial"]),
            ]
            for name, s in supports.items()
        ],
    )
    print_table(
        f"Reactions to a radial force of {force.with_name(record['radial_force'])} on the pin, length "
        "kept",
        ["support", "end:", f"force x y z [{force.name}]", f"moment x y z [{moment.name}]"],
        [
            [name, side, _vector(reaction["force"], force), _vector(reaction["moment"], moment)]
            for name, s in supports.items()
            for side, reaction in s["reactions"].items()
        ],
    )
    print_line(
        units.text(
            f"Mass {record['mass']:.4g} kg, center of mass {record['center_of_mass'][1] * 1e3:.4g} mm "
            f"from the shaft axis, inertia about the shaft {record['inertia_about_shaft']:.4g} kg m^2; "
            f"static unbalance {math.hypot(*record['unbalance']['static']):.4g} kg m, dynamic unbalance "
            f"about the middle {math.hypot(*record['unbalance']['dynamic']):.3g} kg m^2."
        )
    )
    met = (
        "" if record["accuracy_met"] else f"; the accuracy of {record['accuracy']:.2g} was not met"
    )
    print_line(
        f"Model: {record['model']}, {record['unknowns']:,} unknowns, solver {record['solver']}{met}."
    )


def print_free_modes(modes: list[dict[str, Any]], units: OutputUnits = SI) -> None:
    """Print the natural modes of a free throw."""
    frequency = units.of("Hz")
    print_table(
        "Natural modes of the free throw",
        ["mode", f"frequency [{frequency.name}]", "motion of the end sections:"],
        [
            [str(place), frequency.fixed(mode["frequency"], 1), mode["name"]]
            for place, mode in enumerate(modes, start=1)
        ],
    )


def print_profile(seconds: dict[str, float]) -> None:
    """Print where the time of an analysis went."""
    total = sum(seconds.values())
    print_table(
        "Where the time went",
        ["work", "s", "%"],
        [
            *([name, f"{s:.2f}", f"{100.0 * s / total:.0f}"] for name, s in seconds.items()),
            ["all", f"{total:.2f}", "100"],
        ],
    )


def print_shape(record: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print what the dimensions make."""
    length, volume = units.of("mm"), units.of("dm^3")
    pins = "one pin" if record["pins"] == 1 else f"{record['pins']} pins"
    print_line(
        f"Throw with {pins}: length {length.with_name(record['length'], 5)}, overlap of journal and pin "
        f"{length.with_name(record['overlap'])}, volume {volume.with_name(record['volume'])}; "
        f"{_PARTS[record['solved_part']]}."
    )
    for remark in record["remarks"]:
        print_line(units.text(f"Note: {remark}"))


_PARTS = {
    "quarter": "symmetric about two planes, a quarter is solved",
    "half": "symmetric about the crank plane, half of it is solved",
    "full": "without planes of symmetry, all of it is solved",
}


def _vector(values: list[float], unit: OutputUnit) -> str:
    return "  ".join(unit.fixed(value, 3) for value in values)


def print_vibration(
    record: dict[str, Any], *, forced: bool = False, units: OutputUnits = SI
) -> None:
    """Print modes, the first frequencies by source, and critical speeds unless forced vibration has them."""
    frequency, speed = units.of("Hz"), units.of("1/min")
    print_table(
        f"{record['kind'].capitalize()} modes (compliances: {record['source']})",
        ["mode", f"frequency [{frequency.name}]", "[1/min]", "nodes at:"],
        [
            [
                "rigid body" if m["rigid"] else str(m["number"]),
                frequency.fixed(m["frequency"], 2),
                f"{60.0 * m['frequency']:.0f}",
                ", ".join(f"{place:.2f}" for place in m["node_positions"]),
            ]
            for m in record["modes"]
        ],
    )
    nodes = record["nodes"]
    print_line(f"Nodes count the chain's points: 0 is {nodes[0]}, {len(nodes) - 1} is {nodes[-1]}.")
    if not forced:
        print_table(
            f"{record['kind'].capitalize()} critical speeds in the running range",
            [
                f"speed [{speed.name}]",
                "order",
                "mode",
                f"frequency [{frequency.name}]",
                "phase sum",
            ],
            [
                [
                    speed.fixed(c["speed_rpm"] / RPM, 1),
                    f"{c['order']:g}",
                    str(c["mode"]),
                    frequency.fixed(c["frequency"], 2),
                    f"{c['phase_sum']:.3f}",
                ]
                for c in record["criticals"]
            ],
        )
    print_table(
        f"First {record['kind']} frequencies by source of the compliances",
        ["source", f"frequencies [{frequency.name}]", "first beside chosen"],
        [
            [
                s["source"],
                ", ".join(frequency.fixed(f, 1) for f in s["first_frequencies"]),
                f"{s['beside_chosen']:.3f}",
            ]
            for s in record["sources"]
        ],
    )
