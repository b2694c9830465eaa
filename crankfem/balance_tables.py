"""Balance of an engine as plain JSON content and as printed tables."""

import math

from crankfem.console import print_line, print_table
from crankfem.output_units import SI, OutputUnit, OutputUnits
from crankfem.record import Record
from dynamics.balance.balance import Balance, OrderBalance, Resultant
from dynamics.balance.hinged_rods import HingedRodEffects, hodograph_change
from dynamics.balance.hodograph import Hodograph
from dynamics.balance.moving_masses import moving_masses

BALANCED_TEXT = "balanced"
SENSES = {1: "with shaft", -1: "against", 0: "line"}
CASES = {
    "side_by_side": "rods side by side",
    "kinematics": "hinged: movement alone",
    "masses": "hinged: masses alone",
    "hinged": "hinged",
}


def balance_record(found: Balance) -> Record:
    """Return a balance as plain JSON content.

    Parameters
    ----------
    found : Balance

    Returns
    -------
    dict
        "speed" [rad/s], "about" [m], "model", "masses" (a record for each cylinder [kg, kg m]) and
        "orders": for each order force [N] and moment [N m] in total and by part, each as
        `hodograph_record` gives it, whether it is balanced, and the scale of that judgment.
    """
    return {
        "speed": found.speed,
        "about": found.about,
        "model": found.model,
        "masses": [
            {
                "cylinder": place,
                "reciprocating": masses.reciprocating,
                "rotating": masses.rotating,
                "lateral_static_moment": masses.lateral,
            }
            for place, masses in enumerate(moving_masses(found.engine), start=1)
        ],
        "orders": [_order_record(row) for row in found.rows],
    }


def _order_record(row: OrderBalance) -> Record:
    return {
        "order": row.order,
        "force": hodograph_record(row.force),
        "force_balanced": row.force_balanced,
        "force_scale": row.force_scale,
        "moment": hodograph_record(row.moment),
        "moment_balanced": row.moment_balanced,
        "moment_scale": row.moment_scale,
        "parts": {
            name: _resultant_record(getattr(row, name))
            for name in ("reciprocating", "rotating", "lateral")
        },
    }


def _resultant_record(resultant: Resultant) -> Record:
    return {
        "force": hodograph_record(resultant.force),
        "moment": hodograph_record(resultant.moment),
    }


def hodograph_record(hodograph: Hodograph) -> Record:
    """Return a hodograph as plain JSON content, in the unit of its vector.

    Returns
    -------
    dict
        Semi-axes "major" and "minor", "angle_deg" of the major axis and "largest_at_deg" of the
        shaft (None for a circle), "sense" (1, -1, 0), amplitudes "x" and "y", and the coefficients
        "forward" and "backward" as [real, imaginary].
    """
    return {
        "major": hodograph.major,
        "minor": hodograph.minor,
        "angle_deg": _degrees(hodograph.angle),
        "largest_at_deg": _degrees(hodograph.largest_at),
        "sense": hodograph.sense,
        "x": hodograph.x,
        "y": hodograph.y,
        "forward": [hodograph.forward.real, hodograph.forward.imag],
        "backward": [hodograph.backward.real, hodograph.backward.imag],
    }


def hinged_rods_record(effects: tuple[HingedRodEffects, ...]) -> list[Record]:
    """Return the effects of hinged rods as plain JSON content: for each order four cases.

    Returns
    -------
    list of dict
        "order", and for each case `hodograph_record` [N] with "change" against rods side by side:
        "major" and "minor" as shares, "turn_deg".
    """
    return [
        {
            "order": effect.order,
            **{name: _case_record(getattr(effect, name), effect.side_by_side) for name in CASES},
        }
        for effect in effects
    ]


def _case_record(hodograph: Hodograph, reference: Hodograph) -> Record:
    change = hodograph_change(hodograph, reference)
    return {
        **hodograph_record(hodograph),
        "change": {
            "major": change.major,
            "minor": change.minor,
            "turn_deg": _degrees(change.turn),
        },
    }


def print_balance(record: Record, units: OutputUnits = SI) -> None:
    """Print the tables of forces and moments of `balance_record`."""
    speed = units.of("1/min").with_name(record["speed"], 6)
    for kind, shown in (("force", units.of("kN")), ("moment", units.of("kN m"))):
        about = units.of("m").with_name(record["about"], 6)
        where, unit = f" about z = {about}" if kind == "moment" else "", shown.name
        print_table(
            f"Inertia {kind}s on the engine at {speed}{where}",
            [
                "order",
                f"largest [{unit}]",
                f"least [{unit}]",
                f"axis [{units.of('deg').name}]",
                "turns:",
                f"up and down (y) [{unit}]" if kind == "force" else f"about y [{unit}]",
                f"across (x) [{unit}]" if kind == "force" else f"about x [{unit}]",
            ],
            [_row(order, kind, shown, units.of("deg")) for order in record["orders"]],
        )
    print_line(
        f'"{BALANCED_TEXT}": less than 1e-12 of all masses times R w^2. Axis of the largest value: from '
        "the vertical, in the sense of rotation."
    )


def _row(order: Record, kind: str, unit: OutputUnit, angle: OutputUnit) -> list[str]:
    name = str(order["order"])
    if order[f"{kind}_balanced"]:
        return [name, BALANCED_TEXT, "", "", "", "", ""]
    shape = order[kind]
    shown = [unit.number(_cleared(shape, name)) for name in ("major", "minor", "y", "x")]
    return [
        name,
        shown[0],
        shown[1],
        _angle_text(shape["angle_deg"], angle),
        SENSES[shape["sense"]],
        shown[2],
        shown[3],
    ]


def _cleared(shape: Record, name: str) -> float:
    """Return a value, zero where it is round-off of the largest."""
    value = float(shape[name])
    return 0.0 if value <= 1e-12 * shape["major"] else value


def print_hinged_rods(records: list[Record], units: OutputUnits = SI) -> None:
    """Print the table of `hinged_rods_record`."""
    force, angle = units.of("kN"), units.of("deg")
    print_table(
        "One crankpin with hinged rods against rods side by side: reciprocating forces",
        [
            "order",
            "case:",
            f"largest [{force.name}]",
            "change",
            f"least [{force.name}]",
            "change",
            f"axis turned by [{angle.name}]",
        ],
        [
            [
                str(record["order"]),
                text,
                force.number(record[case]["major"]),
                _percent(record[case]["change"]["major"]),
                force.number(_cleared(record[case], "minor")),
                _percent(record[case]["change"]["minor"]),
                _angle_text(record[case]["change"]["turn_deg"], angle),
            ]
            for record in records
            for case, text in CASES.items()
        ],
    )


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)


def _angle_text(degrees: float | None, unit: OutputUnit) -> str:
    if degrees is None:
        return ""
    # Adding zero makes a negative zero positive.
    return unit.number(math.radians(round(degrees, 2) + 0.0))


def _percent(share: float | None) -> str:
    return "" if share is None else f"{round(100.0 * share, 2) + 0.0:.3g} %"
