"""Masses included in the balance of an engine, as plain JSON content, and the tables made from it."""

import cmath
import math
from collections.abc import Iterable
from dataclasses import replace

from crankbase.tables.output_units import SI, OutputUnit, OutputUnits
from crankbase.tables.table import Column, Table
from crankfem.analyses.mechanism.balance_records import BALANCED_TEXT, balance_record
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.record import Record
from dynamics.balance.balance import BALANCED, balance
from dynamics.balance.moving_masses import moving_masses
from geometry.volume import counterweight_moment

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
    found = run.balance
    first = balance(bare, found.speed, (1,), about=found.about, model=found.model).of(1)
    return {
        **balance_record(found),
        "throws": list(_throw_records(run)),
        "without_throws": {"force": first.force.major, "moment": first.moment.major},
    }


def _throw_records(run: MechanismRun) -> Iterable[Record]:
    mechanism, layout = run.mechanism, run.layout
    masses = moving_masses(layout)
    for number, throw in enumerate(mechanism.crank_throws):
        own = cmath.rect(1.0, -math.radians(mechanism.throw_angles_deg[number]))
        rods = sum(
            mass.rotating
            * layout.crank_radius
            * own
            * cmath.rect(1.0, math.radians(cylinder.crank_angle_deg))
            for mass, cylinder, place in zip(
                masses, layout.cylinders, mechanism.throws, strict=True
            )
            if place == number
        )
        # Each throw stands in the layout as two masses.
        solid = sum(
            mass.static_moment * own * cmath.rect(1.0, math.radians(mass.angle_deg))
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
    return [0.0 if abs(one) < 1e-12 * scale else one for one in (moment.real, moment.imag)]


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
    shown = [one.name for one in table.columns if weighted or one.name != COUNTERWEIGHTS]
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
