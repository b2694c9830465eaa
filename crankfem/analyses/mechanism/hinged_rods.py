"""One crankpin with hinged rods: their effect on the inertia forces, accelerations of the pistons."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Literal

import numpy as np

from crankbase.array_checks import Array
from crankbase.results import Quantity, Result, result
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.mechanism.engine_balance import angle_cell, cleared
from dynamics.balance import HingedRodEffects
from dynamics.engine.forces import (
    acceleration_orders,
    order_part,
    parts_motion,
    piston_acceleration,
    piston_ends,
)
from dynamics.engine.layout import EngineLayout

Degrees = Annotated[float, Quantity("deg")]
CASES = {
    "side_by_side": "rods side by side",
    "kinematics": "hinged: movement alone",
    "masses": "hinged: masses alone",
    "hinged": "hinged",
}
# Shares below this are round-off.
ROUND_OFF = 1e-12
HIGHEST_ORDER = 8
# Orders that tables of balance go by; what they leave is told by its largest value.
ORDERS = (1, 2)
# [deg] Angles at which accelerations are compared.
STEP = 0.25


def hinged_rod_table(effects: tuple[HingedRodEffects, ...]) -> Table:
    """Return the effects of hinged rods by order."""
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
                str(effect.order),
                CASES[name],
                case.hodograph.major,
                _percent(case.change.major),
                cleared(case.hodograph, "minor"),
                _percent(case.change.minor),
                angle_cell(case.change.turn_deg),
            ]
            for effect in effects
            for name, case in effect.changes.items()
        ],
    )


def _percent(share: float | None) -> str:
    return "" if share is None else f"{round(100.0 * share, 2) + 0.0:.3g} %"


def piston_names(layout: EngineLayout, cylinders: Sequence[int]) -> dict[int, str]:
    """Return the names of the pistons of one crankpin, by the number of their cylinder."""
    return {number: f"{_rod(layout, number)} rod (cylinder {number})" for number in cylinders}


def _rod(layout: EngineLayout, number: int) -> Literal["main", "hinged"]:
    return "main" if layout.main_of(number) == number else "hinged"


def motion_columns(
    layout: EngineLayout, speed: float, cylinders: Sequence[int], shaft_angles: Array
) -> dict[str, Array]:
    """Return the motion of pistons and rods over shaft angles (m,) [rad] by name with unit.

    The piston's travel from its top and its acceleration towards the shaft, whole and by order, with that of
    the rod's center of mass, where the third of three masses is; across: to the side to which the crankpin
    moves as it passes the top.
    """
    columns: dict[str, Array] = {}
    for number in cylinders:
        alpha = shaft_angles - math.radians(layout.cylinders[number - 1].top_shaft_angle_deg)
        parts = acceleration_orders(layout, number, speed, max(ORDERS))
        motion = parts_motion(layout, number, shaft_angles)
        center = motion.rod_point(layout.cylinders[number - 1].rod.center).acceleration(speed)
        top = piston_ends(layout, number)[1]
        columns |= {
            f"cylinder_{number}_piston_travel_m": top - motion.piston.place.real,
            f"cylinder_{number}_rod_center_acceleration_m_s2": -center.real,
            f"cylinder_{number}_rod_center_acceleration_across_m_s2": center.imag,
        }
        columns[f"cylinder_{number}_acceleration_m_s2"] = piston_acceleration(
            layout, number, speed, angles_deg=np.degrees(alpha)
        )
        for order in ORDERS:
            columns[f"cylinder_{number}_order_{order}_m_s2"] = order_part(parts, order, alpha)
    return columns


Acceleration = Annotated[float, Quantity("m/s^2")]
Accelerations = Annotated[Array, Quantity("m/s^2")]


@result("cylinder", "rod", "largest")
class PistonAcceleration(Result):
    """Acceleration of a piston towards the shaft, by order: the sum of a cos(k alpha - phase).

    Alpha counts from the position of the crank along the cylinder's own axis.

    Parameters
    ----------
    left : float
        Largest remainder above the orders of `ORDERS`.
    """

    cylinder: int
    rod: Literal["main", "hinged"]
    largest: Acceleration
    orders: Annotated[tuple[int, ...], Quantity("1")]
    amplitude: Accelerations
    phase_deg: Annotated[Array, Quantity("deg")]
    left: Acceleration


@result("cylinder", "largest", "least", eq=True)
class AccelerationDifference(Result):
    """Acceleration of the main rod's piston minus that of a hinged rod's, at the same alpha.

    Parameters
    ----------
    mean_largest : float
        Mean of the largest accelerations of both.
    """

    cylinder: int
    largest: Acceleration
    largest_deg: Degrees
    least: Acceleration
    least_deg: Degrees
    mean_largest: Acceleration


@result("speed", "pistons", "differences")
class PistonAccelerations(Result):
    """Accelerations of the pistons on one crankpin, that of the main rod first."""

    speed: Annotated[float, Quantity("rad/s")]
    pistons: tuple[PistonAcceleration, ...]
    differences: tuple[AccelerationDifference, ...]

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return the orders, the remainder, and how hinged pistons differ."""
        main = self.pistons[0]
        speed = units.of("1/min").with_name(self.speed, 6)
        rows: list[list[float | str | None]] = []
        for place, order in enumerate(main.orders[:4]):
            for piston in self.pistons:
                amplitude, reference = piston.amplitude[place], main.amplitude[place]
                beside = amplitude / reference - 1.0 if reference else None
                rows.append(
                    [
                        str(order),
                        str(piston.cylinder),
                        piston.rod,
                        amplitude,
                        amplitude / piston.largest,
                        None if piston is main else beside,
                        math.radians(piston.phase_deg[place]) if amplitude else None,
                    ]
                )
        rows += [
            [
                "above 2",
                str(piston.cylinder),
                piston.rod,
                piston.left,
                piston.left / piston.largest,
                None,
                None,
            ]
            for piston in self.pistons
        ]
        yield Table(
            f"Accelerations of the pistons on one crankpin at {speed}",
            [
                Column("order", words=True),
                Column("cylinder", words=True),
                Column("rod", words=True),
                Column("amplitude", "m/s^2"),
                Column("of largest", "%", decimals=2),
                Column("against main rod", "%", decimals=2, missing=""),
                Column("phase", "deg", missing=""),
            ],
            rows,
            note="Of largest: amplitude divided by the piston's largest acceleration. Against main rod: "
            "difference of the amplitudes. Phase: order k is a cos(k alpha - phase), with alpha 0 when the "
            "crank is along the cylinder axis.",
        )
        for row in self.differences:
            ends = (
                f"{units.of('m/s^2').with_name(size)} at "
                f"{units.of('deg').with_name(math.radians(degrees))} "
                f"({abs(100.0 * size / row.mean_largest):.2g} %)"
                for size, degrees in ((row.least, row.least_deg), (row.largest, row.largest_deg))
            )
            yield (
                f"Acceleration, cylinder {main.cylinder} less cylinder {row.cylinder}, at the same alpha: "
                f"{' to '.join(ends)}; percent of the mean of both largest accelerations."
            )


def piston_accelerations(
    layout: EngineLayout, speed: float, cylinders: Sequence[int]
) -> PistonAccelerations:
    """Return the accelerations of pistons on one crankpin, by the numbers of their cylinders."""
    alpha = np.radians(np.arange(0.0, 360.0, STEP))
    curves = {
        number: piston_acceleration(layout, number, speed, angles_deg=np.degrees(alpha))
        for number in cylinders
    }
    main, *hinged = cylinders
    differences = []
    for number in hinged:
        apart = curves[main] - curves[number]
        most, least = int(np.argmax(apart)), int(np.argmin(apart))
        differences.append(
            AccelerationDifference(
                cylinder=number,
                largest=float(apart[most]),
                largest_deg=math.degrees(alpha[most]),
                least=float(apart[least]),
                least_deg=math.degrees(alpha[least]),
                mean_largest=0.5 * float(np.max(curves[main]) + np.max(curves[number])),
            )
        )
    pistons = []
    for number, whole in curves.items():
        parts = acceleration_orders(layout, number, speed, HIGHEST_ORDER)
        amplitude, cosine, sine = (
            values[:HIGHEST_ORDER] for values in (parts.amplitude, parts.cosine, parts.sine)
        )
        zero = amplitude <= ROUND_OFF * amplitude[0]
        # Adding zero makes a negative zero positive.
        phase = np.round(np.degrees(np.arctan2(sine, cosine)), 9) + 0.0
        left = whole - sum(order_part(parts, order, alpha) for order in ORDERS)
        pistons.append(
            PistonAcceleration(
                cylinder=number,
                rod=_rod(layout, number),
                largest=float(np.max(whole)),
                orders=tuple(range(1, HIGHEST_ORDER + 1)),
                amplitude=np.where(zero, 0.0, amplitude),
                phase_deg=np.where(zero, 0.0, phase),
                left=float(np.max(np.abs(left))),
            )
        )
    return PistonAccelerations(speed, tuple(pistons), tuple(differences))
