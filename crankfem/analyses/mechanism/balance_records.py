"""Balance of an engine as plain JSON content, and the tables made from it."""

import cmath
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

from crankbase.table import SI, Cell, Column, OutputUnit, OutputUnits, Table
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.record import Record, attributes
from dynamics.balance import (
    BALANCED,
    Balance,
    HingedRodEffects,
    Hodograph,
    OrderBalance,
    Resultant,
    balance,
    hodograph_change,
    moving_masses,
)
from geometry.parts import counterweight_moment

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


# Parts of a throw's unbalance: the rods' share at its pins, its solid, and the counterweights in that.
PARTS = ("rods", "solid", "counterweights")
COUNTERWEIGHTS = "its counterweights"


def mechanism_balance_record(run: MechanismRun) -> Record:
    """Return the balance of a run with the masses included.

    Returns
    -------
    dict
        As `balance_record` gives it, with "throws": of each "throw" the static moments of "rods" (their
        share at the crankpins), "solid" (all of the throw), "counterweights" (that part of the solid)
        and "sum" (rods and solid), each as ["along" the first pin's crank, across it in the sense of
        rotation] [kg m]; and "without_throws": "force" [N] and "moment" [N m] of the first order
        without the throws' solids, the major axes.
    """
    bare = replace(run.layout, rotating=())
    record = run.balance
    first = balance(bare, record.speed, (1,), about=record.about, model=record.model).of(1)
    return {
        **balance_record(record),
        "throws": list(_throw_records(run)),
        "without_throws": {"force": first.force.major, "moment": first.moment.major},
    }


def _throw_records(run: MechanismRun) -> Iterable[Record]:
    mechanism, layout = run.mechanism, run.layout
    masses = moving_masses(layout)
    for number, throw in enumerate(mechanism.crank_throws):
        towards = cmath.rect(1.0, -math.radians(mechanism.throw_angles_deg[number]))
        rods = sum(
            mass.rotating
            * layout.crank_radius
            * towards
            * cmath.rect(1.0, math.radians(cylinder.crank_angle_deg))
            for mass, cylinder, place in zip(
                masses, layout.cylinders, mechanism.throws, strict=True
            )
            if place == number
        )
        # Each throw stands in the layout as two masses.
        solid = sum(
            mass.static_moment * towards * cmath.rect(1.0, math.radians(mass.angle_deg))
            for mass in layout.rotating[2 * number : 2 * number + 2]
        )
        x, y = mechanism.material.density * counterweight_moment(throw.parts)
        weights = complex(y, -mechanism.turning_sense * x)
        parts = dict(zip(PARTS, map(complex, (rods, solid, weights)), strict=True))
        parts["sum"] = parts["rods"] + parts["solid"]
        scale = sum(map(abs, parts.values()))
        yield {
            "throw": number + 1,
            **{name: _without_round_off(moment, scale) for name, moment in parts.items()},
        }


def _without_round_off(moment: complex, scale: float) -> list[float]:
    return [0.0 if abs(part) < 1e-12 * scale else part for part in (moment.real, moment.imag)]


def moving_mass_table(record: Record) -> Table:
    """Return the masses of each cylinder in the balance."""
    return Table(
        "Masses in the balance: pistons and rods",
        [
            Column("cylinder", words=True),
            Column("reciprocating", "kg"),
            Column("rotating, at the crankpin", "kg"),
            Column("static moment about the rod's axis", "kg m"),
        ],
        [
            [
                str(row["cylinder"]),
                row["reciprocating"],
                row["rotating"],
                row["lateral_static_moment"] if record["model"] == "rigid" else 0.0,
            ]
            for row in record["masses"]
        ],
        merged=True,
    )


def throw_mass_table(record: Record) -> Table:
    """Return the static moments of each throw: mass times radius along the crank, and their sum."""
    weighted = _has_counterweights(record)
    table = Table(
        "Masses in the balance: mass times radius at each throw, along its crank",
        [
            Column("throw", words=True),
            Column("rods", "kg m"),
            Column("solid", "kg m"),
            Column(COUNTERWEIGHTS, "kg m"),
            Column("sum", "kg m"),
            Column("at", "deg", missing=""),
        ],
        [
            [
                str(row["throw"]),
                *(row[name][0] for name in PARTS),
                math.hypot(*row["sum"]),
                math.atan2(*row["sum"][::-1]) if any(row["sum"]) else None,
            ]
            for row in record["throws"]
        ],
        note="Solid: the whole throw, counterweights included. Sum: rods and solid, at an angle from the "
        "crank."
        if weighted
        else "Sum: rods and solid, at an angle from the crank.",
        merged=True,
    )
    shown = [column.name for column in table.columns if weighted or column.name != COUNTERWEIGHTS]
    return table.select(*shown)


def balance_contents(record: Record, units: OutputUnits = SI) -> str:
    """State what the balance includes, and the first order without the throws' solids."""
    first = next(row for row in record["orders"] if row["order"] == 1)

    def both(kind: str, unit: OutputUnit) -> str:
        floor = BALANCED * first[f"{kind}_scale"]
        sizes = (first[kind]["major"], record["without_throws"][kind])
        if max(sizes) <= floor:
            return f"{kind} {BALANCED_TEXT} with and without the solids"
        now, bare = (unit.with_name(size) if size > floor else BALANCED_TEXT for size in sizes)
        return f"{kind} {now}, without the solids {bare}"

    weights = " with counterweights" if _has_counterweights(record) else ""
    return (
        f"The balance includes the throws' solids{weights}; flywheel and free end are assumed to be "
        f"balanced. First order: {both('force', units.of('kN'))}; {both('moment', units.of('kN m'))}."
    )


def _has_counterweights(record: Record) -> bool:
    """Whether any throw has counterweights."""
    return any(any(row["counterweights"]) for row in record["throws"])


def balance_parts(record: Record, units: OutputUnits = SI) -> Iterator[Table | str]:
    """Return what is in the balance of a `mechanism_balance_record`, its forces and moments."""
    yield moving_mass_table(record)
    yield throw_mass_table(record)
    yield balance_contents(record, units)
    yield balance_table(record, "force", units)
    yield balance_table(record, "moment", units)
    yield (
        f'"{BALANCED_TEXT}": less than 1e-12 of all masses times R w^2. Axis of the largest value: from '
        "the vertical, in the sense of rotation."
    )
