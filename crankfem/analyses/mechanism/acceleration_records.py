"""Accelerations of the pistons on one crankpin, by order, as plain JSON content, and their table."""

import math
from collections.abc import Sequence

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Column, Table
from crankfem.analyses.mechanism.load_tables import ROUND_OFF
from crankfem.analyses.record import Record
from dynamics.engine.layout import EngineLayout
from dynamics.engine.motions import acceleration_orders, order_part, piston_acceleration

HIGHEST_ORDER = 8
# Orders that tables of balance go by; what they leave is told by its largest value.
ORDERS = (1, 2)
# [deg] Angles at which accelerations are compared.
STEP = 0.25


def piston_names(layout: EngineLayout, cylinders: Sequence[int]) -> dict[int, str]:
    """Return the names of the pistons of one crankpin, by the number of their cylinder."""
    return {number: f"{_rod(layout, number)} rod (cylinder {number})" for number in cylinders}


def _rod(layout: EngineLayout, number: int) -> str:
    return "main" if layout.main_of(number) == number else "hinged"


def acceleration_columns(
    layout: EngineLayout, speed: float, cylinders: Sequence[int], shaft_angles: FloatArray
) -> dict[str, FloatArray]:
    """Return the pistons' accelerations over shaft angles (m,) [rad] by name with unit: whole, by order."""
    columns = {}
    for number in cylinders:
        alpha = shaft_angles - math.radians(layout.cylinders[number - 1].top_shaft_angle_deg)
        found = acceleration_orders(layout, number, speed, max(ORDERS))
        columns[f"cylinder_{number}_acceleration_m_s2"] = piston_acceleration(
            layout, number, speed, angles_deg=np.degrees(alpha)
        )
        for order in ORDERS:
            columns[f"cylinder_{number}_order_{order}_m_s2"] = order_part(found, order, alpha)
    return columns


def acceleration_record(layout: EngineLayout, speed: float, cylinders: Sequence[int]) -> Record:
    """Return the accelerations of pistons on one crankpin as plain JSON content.

    Parameters
    ----------
    layout : EngineLayout
    speed : float
        Of the shaft [rad/s].
    cylinders : sequence of int
        Numbers of the cylinders, that with the main rod first.

    Returns
    -------
    dict
        "pistons": for each "cylinder", its "rod" ("main" or "hinged"), the "largest" acceleration
        towards the shaft, "amplitude" [m/s^2] and "phase_deg" of "orders" a cos(k alpha - phase), alpha
        from the position of the crank along the cylinder's own axis, and the largest remainder "left" above
        orders 1 and 2 [m/s^2].
        "differences": for each hinged rod, by "cylinder", the acceleration of the main rod's piston minus
        its own at the same alpha: "largest", "least" [m/s^2] and where, "..._deg", and
        "mean_largest", the mean of the largest accelerations of both [m/s^2].
    """
    alpha = np.radians(np.arange(0.0, 360.0, STEP))
    curves = {
        number: piston_acceleration(layout, number, speed, angles_deg=np.degrees(alpha))
        for number in cylinders
    }
    main, *hinged = cylinders
    return {
        "speed": speed,
        "pistons": [
            _piston_record(layout, speed, number, alpha, curve) for number, curve in curves.items()
        ],
        "differences": [
            _difference_record(one, alpha, curves[main], curves[one]) for one in hinged
        ],
    }


def _piston_record(
    layout: EngineLayout, speed: float, number: int, alpha: FloatArray, whole: FloatArray
) -> Record:
    found = acceleration_orders(layout, number, speed, HIGHEST_ORDER)
    count = HIGHEST_ORDER
    zero = found.amplitude[:count] <= ROUND_OFF * found.amplitude[0]
    # Adding zero makes a negative zero positive.
    phase = np.round(np.degrees(np.arctan2(found.sine[:count], found.cosine[:count])), 9) + 0.0
    left = whole - sum(order_part(found, order, alpha) for order in ORDERS)
    return {
        "cylinder": number,
        "rod": _rod(layout, number),
        "largest": float(np.max(whole)),
        "orders": list(range(1, count + 1)),
        "amplitude": np.where(zero, 0.0, found.amplitude[:count]).tolist(),
        "phase_deg": np.where(zero, 0.0, phase).tolist(),
        "left": float(np.max(np.abs(left))),
    }


def _difference_record(number: int, alpha: FloatArray, main: FloatArray, own: FloatArray) -> Record:
    apart = main - own
    most, least = int(np.argmax(apart)), int(np.argmin(apart))
    return {
        "cylinder": number,
        "largest": float(apart[most]),
        "largest_deg": math.degrees(alpha[most]),
        "least": float(apart[least]),
        "least_deg": math.degrees(alpha[least]),
        "mean_largest": 0.5 * float(np.max(main) + np.max(own)),
    }


def acceleration_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the orders of an `acceleration_record`, and the remainder above orders 1 and 2."""
    main = record["pistons"][0]
    speed = units.of("1/min").with_name(record["speed"], 6)
    rows: list[list[float | str | None]] = []
    for place, order in enumerate(main["orders"][:4]):
        for piston in record["pistons"]:
            amplitude, reference = piston["amplitude"][place], main["amplitude"][place]
            beside = amplitude / reference - 1.0 if reference else None
            rows.append(
                [
                    str(order),
                    str(piston["cylinder"]),
                    piston["rod"],
                    amplitude,
                    amplitude / piston["largest"],
                    None if piston is main else beside,
                    math.radians(piston["phase_deg"][place]) if amplitude else None,
                ]
            )
    rows += [
        [
            "above 2",
            str(one["cylinder"]),
            one["rod"],
            one["left"],
            one["left"] / one["largest"],
            None,
            None,
        ]
        for one in record["pistons"]
    ]
    return Table(
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


def acceleration_sentences(record: Record, units: OutputUnits = SI) -> list[str]:
    """State the difference between pistons of main and hinged rods, one sentence for each hinged rod."""
    main = record["pistons"][0]["cylinder"]

    def apart(row: Record, which: str) -> str:
        value = units.of("m/s^2").with_name(row[which])
        angle = units.of("deg").with_name(math.radians(row[f"{which}_deg"]))
        return f"{value} at {angle} ({abs(100.0 * row[which] / row['mean_largest']):.2g} %)"

    return [
        f"Acceleration, cylinder {main} less cylinder {row['cylinder']}, at the same alpha: "
        f"{apart(row, 'least')} to {apart(row, 'largest')}; percent of the mean of both largest "
        "accelerations."
        for row in record["differences"]
    ]
