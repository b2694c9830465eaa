"""Balance of an engine with the throws' solids, and its tables."""

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from crankbase.results import Flat, Quantity, Result, result
from crankbase.table import SI, Cell, Column, OutputUnit, OutputUnits, Table
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from dynamics.balance import BALANCED, Balance, Hodograph, balance
from dynamics.engine.layout import EngineCylinder
from geometry.parts import counterweight_moment

BALANCED_TEXT = "balanced"
ROUND_OFF = 1e-12
SENSES = {1: "with shaft", -1: "against", 0: "line"}
COUNTERWEIGHTS = "its counterweights"

# Along the first pin's crank, and across it in the sense of rotation.
StaticMoment = Annotated[tuple[float, float], Quantity("kg m")]


@result("throw", "sum", eq=True)
class ThrowBalance(Result):
    """Static moments of a throw.

    Parameters
    ----------
    rods : tuple of two floats
        Their share at the crankpins.
    solid : tuple of two floats
        All of the throw.
    counterweights : tuple of two floats
        That part of the solid.
    sum : tuple of two floats
        Rods and solid.
    """

    throw: int
    rods: StaticMoment
    solid: StaticMoment
    counterweights: StaticMoment
    sum: StaticMoment


@result("force", "moment", eq=True)
class FirstOrder(Result):
    """Major axes of the first order."""

    force: Annotated[float, Quantity("N")]
    moment: Annotated[float, Quantity("N m")]


@result("balance", "throws", "without_throws", eq=True)
class EngineBalance(Result):
    """The balance of an engine with the masses in it.

    Parameters
    ----------
    without_throws : FirstOrder
        Without the throws' solids.
    """

    balance: Flat[Balance]
    throws: tuple[ThrowBalance, ...]
    without_throws: FirstOrder

    @property
    def weighted(self) -> bool:
        """Whether any throw has counterweights."""
        return any(any(throw.counterweights) for throw in self.throws)

    def table(self, kind: str, units: OutputUnits = SI) -> Table:
        """Return the forces, or the moments, by order."""
        unit = {"force": "kN", "moment": "kN m"}[kind]
        about = units.of("mm").with_name(self.balance.about, 6)
        speed = units.of("1/min").with_name(self.balance.speed, 6)
        where = f" about z = {about}" if kind == "moment" else ""
        y, x = ("up and down (y)", "across (x)") if kind == "force" else ("about y", "about x")
        rows: list[list[Cell]] = []
        for row in self.balance.rows:
            if getattr(row, f"{kind}_balanced"):
                rows.append([str(row.order), BALANCED_TEXT, *[""] * 5])
                continue
            hodograph: Hodograph = getattr(row, kind)
            major, minor, along_y, along_x = (
                cleared(hodograph, name) for name in ("major", "minor", "y", "x")
            )
            turned, sense = angle_cell(hodograph.angle_deg), SENSES[hodograph.sense]
            rows.append([str(row.order), major, minor, turned, sense, along_y, along_x])
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
            rows,
            main=True,
        )

    def mass_tables(self) -> tuple[Table, Table]:
        """Return the masses of the cylinders, and the throws' mass times radius along the crank."""
        masses = Table(
            "Masses in the balance: pistons and rods",
            [
                Column("cylinder", words=True),
                Column("reciprocating", "kg"),
                Column("rotating, at the crankpin", "kg"),
                Column("static moment about the rod's axis", "kg m"),
            ],
            [
                [
                    str(row.cylinder),
                    row.reciprocating,
                    row.rotating,
                    row.lateral if self.balance.model == "rigid" else 0.0,
                ]
                for row in self.balance.masses
            ],
            merged=True,
        )
        note = "Sum: rods and solid, at an angle from the crank."
        throws = Table(
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
                    str(row.throw),
                    *(moment[0] for moment in (row.rods, row.solid, row.counterweights)),
                    math.hypot(*row.sum),
                    math.atan2(*row.sum[::-1]) if any(row.sum) else None,
                ]
                for row in self.throws
            ],
            note="Solid: the whole throw, counterweights included. " * self.weighted + note,
            merged=True,
        )
        shown = [column.name for column in throws.columns]
        if not self.weighted:
            shown.remove(COUNTERWEIGHTS)
        return masses, throws.select(*shown)

    def summary(self, units: OutputUnits = SI) -> str:
        """State what the balance includes, and the first order without the throws' solids."""
        first = self.balance.of(1)

        def both(kind: str, unit: OutputUnit) -> str:
            floor = BALANCED * getattr(first, f"{kind}_scale")
            sizes = (getattr(first, kind).major, getattr(self.without_throws, kind))
            if max(sizes) <= floor:
                return f"{kind} {BALANCED_TEXT} with and without the solids"
            now, bare = (unit.with_name(size) if size > floor else BALANCED_TEXT for size in sizes)
            return f"{kind} {now}, without the solids {bare}"

        return (
            f"The balance includes the throws' solids{' with counterweights' * self.weighted}; flywheel and "
            f"free end are assumed to be balanced. First order: {both('force', units.of('kN'))}; "
            f"{both('moment', units.of('kN m'))}."
        )

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return what is in the balance, its forces and moments."""
        yield from self.mass_tables()
        yield self.summary(units)
        yield self.table("force", units)
        yield self.table("moment", units)
        yield (
            f'"{BALANCED_TEXT}": less than 1e-12 of all masses times R w^2. Axis of the largest value: from '
            "the vertical, in the sense of rotation."
        )


def cleared(hodograph: Hodograph, name: str) -> float:
    """Return a size, zero if it is round-off of the largest."""
    size = float(getattr(hodograph, name))
    return 0.0 if size <= ROUND_OFF * hodograph.major else size


def angle_cell(degrees: float | None) -> float | None:
    """Return an angle without digits that are round-off [rad]."""
    # Adding zero makes a negative zero positive.
    return None if degrees is None else math.radians(round(degrees, 2) + 0.0)


def engine_balance(run: MechanismRun) -> EngineBalance:
    """Return the balance of a run with the masses in it."""
    engine_file, layout, whole = run.engine_file, run.layout, run.balance
    bare = replace(layout, rotating=())
    first = balance(bare, whole.speed, (1,), about=whole.about, model=whole.model).of(1)
    throws = []
    for number, throw in enumerate(engine_file.crank_throws):
        towards = cmath.rect(1.0, -math.radians(engine_file.rotation_angles_deg[number]))
        rods = sum(
            mass.rotating
            * layout.crank_radius
            * towards
            * cmath.rect(1.0, math.radians(cylinder.crank_angle_deg))
            for mass, cylinder, place in zip(
                whole.masses, layout.cylinders, engine_file.throws, strict=True
            )
            if place == number
        )
        # Each throw stands in the layout as two masses.
        solid = sum(
            mass.static_moment * towards * cmath.rect(1.0, math.radians(mass.angle_deg))
            for mass in layout.rotating[2 * number : 2 * number + 2]
        )
        x, y = engine_file.material.density * counterweight_moment(throw.parts)
        moments = [*map(complex, (rods, solid)), complex(y, -engine_file.engine.turning_sense * x)]
        moments.append(moments[0] + moments[1])
        scale = sum(map(abs, moments))
        sizes = [
            [0.0 if abs(part) < ROUND_OFF * scale else part for part in (moment.real, moment.imag)]
            for moment in moments
        ]
        throws.append(ThrowBalance(number + 1, *((along, across) for along, across in sizes)))
    return EngineBalance(whole, tuple(throws), FirstOrder(first.force.major, first.moment.major))


def per_area_table(
    cylinders: Sequence[EngineCylinder], balance: Balance, units: OutputUnits = SI
) -> Table:
    """Return the moving masses of each cylinder over the piston's area, with ranges that are usual."""
    rows = zip(cylinders, balance.masses, strict=True)
    return Table(
        "Masses over the area of the piston",
        [
            Column("cylinder", words=True),
            *(Column(name, "kg/m^2") for name in ("piston", "reciprocating", "rotating")),
        ],
        [
            [
                str(row.cylinder),
                *np.divide([part.piston_mass, row.reciprocating, row.rotating], part.area).tolist(),
            ]
            for part, row in rows
        ],
        note="Rotating: at the crankpin, without the throw. Usual of medium-speed engines: pistons 600 to "
        "1100, reciprocating masses 750 to 1400 kg/m^2 (Mikhina, Vyalkov 2024, table 2); the shipped engines "
        f"of up to {units.of('mm').with_name(0.15, 3)} bore have 80 to 270 and 100 to 410 kg/m^2.",
        merged=True,
    )
