"""The tables that the command line prints, from the plain records of a run."""

import math
from typing import Any

from crankfem import console
from crankfem.console import number, print_table


def print_throw(record: dict[str, Any]) -> None:
    """Print compliances, reactions and masses of a throw, from its record."""
    supports = record["supports"]
    print_table(
        f"Throw by finite elements (error of e_n about {100.0 * record['error_estimate']:.2g} %)",
        ["support", "e_n [1e-9 m/N]", "torsional [1e-9 rad/(N m)]", "c [1e-9 m/N]", "P/Z"],
        [
            [
                name,
                number(s["axial_compliance"] * 1e9),
                number(s["torsional_compliance"] * 1e9),
                number(s["influence_coefficient"] * 1e9),
                number(s["axial_force_per_radial"]),
            ]
            for name, s in supports.items()
        ],
    )
    print_table(
        f"Reactions to a radial force of {record['radial_force'] / 1e3:.4g} kN on the pin, length kept",
        ["support", "end:", "force x y z [kN]", "moment x y z [kN m]"],
        [
            [name, side, _vector(reaction["force"]), _vector(reaction["moment"])]
            for name, s in supports.items()
            for side, reaction in s["reactions"].items()
        ],
    )
    console.output.print(
        f"Mass {record['mass']:.4g} kg, center of mass {record['center_of_mass'][1] * 1e3:.4g} mm from the "
        f"shaft axis, inertia about the shaft {record['inertia_about_shaft']:.4g} kg m^2; static unbalance "
        f"{math.hypot(*record['unbalance']['static']):.4g} kg m, dynamic unbalance about the middle "
        f"{math.hypot(*record['unbalance']['dynamic']):.3g} kg m^2.",
        soft_wrap=True,
        highlight=False,
    )
    met = (
        "" if record["accuracy_met"] else f"; the accuracy of {record['accuracy']:.2g} was not met"
    )
    console.output.print(
        f"Model: {record['model']}, {record['unknowns']:,} unknowns, solver {record['solver']}{met}.",
        soft_wrap=True,
        highlight=False,
    )


def print_free_modes(modes: list[dict[str, Any]]) -> None:
    """Print the natural modes of a free throw."""
    print_table(
        "Natural modes of the free throw",
        ["mode", "frequency [Hz]", "motion of the end sections:"],
        [
            [str(number), f"{mode['frequency']:.1f}", mode["name"]]
            for number, mode in enumerate(modes, start=1)
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


def print_shape(record: dict[str, Any]) -> None:
    """Print what the dimensions make."""
    pins = "one pin" if record["pins"] == 1 else f"{record['pins']} pins"
    console.output.print(
        f"Throw with {pins}: length {record['length'] * 1e3:.5g} mm, overlap of journal and pin "
        f"{record['overlap'] * 1e3:.4g} mm, volume {record['volume'] * 1e3:.4g} dm^3; "
        f"{_PARTS[record['solved_part']]}.",
        soft_wrap=True,
        highlight=False,
    )

    for remark in record["remarks"]:
        console.output.print(f"Note: {remark}", soft_wrap=True, highlight=False)


_PARTS = {
    "quarter": "symmetric about two planes, a quarter is solved",
    "half": "symmetric about the crank plane, half of it is solved",
    "full": "without planes of symmetry, all of it is solved",
}


def _vector(values: list[float]) -> str:
    return "  ".join(f"{round(value / 1e3, 3) + 0.0:.3f}" for value in values)


def print_vibration(record: dict[str, Any], *, forced: bool = False) -> None:
    """Print modes, the first frequencies by source, and critical speeds unless forced vibration has them."""
    print_table(
        f"{record['kind'].capitalize()} modes (compliances: {record['source']})",
        ["mode", "frequency [Hz]", "[1/min]", "nodes at:"],
        [
            [
                "rigid body" if m["rigid"] else str(m["number"]),
                f"{m['frequency']:.2f}",
                f"{60.0 * m['frequency']:.0f}",
                ", ".join(f"{place:.2f}" for place in m["node_positions"]),
            ]
            for m in record["modes"]
        ],
    )
    nodes = record["nodes"]
    console.output.print(
        f"Nodes count the chain's points: 0 is {nodes[0]}, {len(nodes) - 1} is {nodes[-1]}.",
        soft_wrap=True,
        highlight=False,
    )
    if not forced:
        print_table(
            f"{record['kind'].capitalize()} critical speeds in the running range",
            ["speed [1/min]", "order", "mode", "frequency [Hz]", "phase sum"],
            [
                [
                    f"{c['speed_rpm']:.1f}",
                    f"{c['order']:g}",
                    str(c["mode"]),
                    f"{c['frequency']:.2f}",
                    f"{c['phase_sum']:.3f}",
                ]
                for c in record["criticals"]
            ],
        )
    print_table(
        f"First {record['kind']} frequencies by source of the compliances",
        ["source", "frequencies [Hz]", "first beside chosen"],
        [
            [
                s["source"],
                ", ".join(f"{f:.1f}" for f in s["first_frequencies"]),
                f"{s['beside_chosen']:.3f}",
            ]
            for s in record["sources"]
        ],
    )
