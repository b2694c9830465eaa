"""Balance of an engine as plain JSON content, and the tables made from it."""

import math

from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Cell, Column, Table
from crankfem.analyses.record import Record, attributes
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
        "speed" [rad/s], "about" [m], "model", "masses" (a record for each cylinder [kg, kg m]),
        "rotating" (further masses on the shaft: "static_moment" [kg m], "angle_deg", "position") and
        "orders": for each order force [N] and moment [N m] in total and by part, each as
        `hodograph_record` gives it, whether it is balanced, and the scale for this decision.
    """
    return {
        **attributes(found, "speed", "about", "model"),
        "masses": [
            {
                "cylinder": place,
                **attributes(masses, "reciprocating", "rotating"),
                "lateral_static_moment": masses.lateral,
            }
            for place, masses in enumerate(moving_masses(found.engine), start=1)
        ],
        "rotating": [
            attributes(mass, "static_moment", "angle_deg", "position")
            for mass in found.engine.rotating
        ],
        "orders": [_order_record(row) for row in found.rows],
    }


def _order_record(row: OrderBalance) -> Record:
    return {
        **attributes(row, "order", "force_balanced", "force_scale"),
        **attributes(row, "moment_balanced", "moment_scale"),
        **_resultant_record(row),
        "parts": {
            name: _resultant_record(getattr(row, name))
            for name in ("reciprocating", "rotating", "lateral")
        },
    }


def _resultant_record(resultant: Resultant | OrderBalance) -> Record:
    return {name: hodograph_record(getattr(resultant, name)) for name in ("force", "moment")}


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
        **attributes(hodograph, "major", "minor", "sense", "x", "y"),
        "angle_deg": hodograph.angle_deg,
        "largest_at_deg": hodograph.largest_at_deg,
        "forward": [hodograph.forward.real, hodograph.forward.imag],
        "backward": [hodograph.backward.real, hodograph.backward.imag],
    }


def hinged_rods_record(effects: tuple[HingedRodEffects, ...]) -> list[Record]:
    """Return the effects of hinged rods as plain JSON content: for each order four cases.

    Returns
    -------
    list of dict
        "order", and for each case `hodograph_record` [N] with "change" from rods side by side:
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
        "change": {**attributes(change, "major", "minor"), "turn_deg": change.turn_deg},
    }


def balance_table(record: Record, kind: str, units: OutputUnits = SI) -> Table:
    """Return the forces, or the moments, of `balance_record` by order."""
    unit = {"force": "kN", "moment": "kN m"}[kind]
    about = units.of("m").with_name(record["about"], 6)
    speed = units.of("1/min").with_name(record["speed"], 6)
    where = f" about z = {about}" if kind == "moment" else ""
    y, x = ("up and down (y)", "across (x)") if kind == "force" else ("about y", "about x")
    return Table(
        f"Inertia {kind}s on the engine at {speed}{where}",
        [
            Column("order", digits=None),
            Column("largest", unit),
            Column("least", unit),
            Column("axis", "deg", missing=""),
            Column("turns", words=True),
            Column(y, unit),
            Column(x, unit),
        ],
        [
            [
                str(row["order"]),
                *([BALANCED_TEXT, *[""] * 5] if row[f"{kind}_balanced"] else _cells(row[kind])),
            ]
            for row in record["orders"]
        ],
    )


def _cells(shape: Record) -> list[Cell]:
    return [
        *(_cleared(shape, name) for name in ("major", "minor")),
        _radians(shape["angle_deg"]),
        SENSES[shape["sense"]],
        *(_cleared(shape, name) for name in ("y", "x")),
    ]


def _cleared(shape: Record, name: str) -> float:
    """Return a value, zero if it is round-off of the largest."""
    value = float(shape[name])
    return 0.0 if value <= 1e-12 * shape["major"] else value


def hinged_rod_table(records: list[Record]) -> Table:
    """Return the table of `hinged_rods_record`."""
    change = Column("change", missing="")
    return Table(
        "One crankpin with hinged rods against rods side by side: reciprocating forces",
        [
            Column("order"),
            Column("case", words=True),
            Column("largest", "kN"),
            change,
            Column("least", "kN"),
            change,
            Column("axis turned by", "deg", missing=""),
        ],
        [
            [
                str(record["order"]),
                text,
                record[case]["major"],
                _percent(record[case]["change"]["major"]),
                _cleared(record[case], "minor"),
                _percent(record[case]["change"]["minor"]),
                _radians(record[case]["change"]["turn_deg"]),
            ]
            for record in records
            for case, text in CASES.items()
        ],
    )


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)


def _radians(degrees: float | None) -> float | None:
    # Adding zero makes a negative zero positive.
    return None if degrees is None else math.radians(round(degrees, 2) + 0.0)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{round(100.0 * share, 2) + 0.0:.3g} %"
