"""Forced vibration as plain numbers, and the tables and columns made from them."""

from pathlib import Path
from typing import Any

import numpy as np

from crankfem.column_file import write_columns
from crankfem.console import print_line, print_table
from crankfem.mechanism_tables import ASSUMED
from crankfem.output_units import SI, OutputUnits
from crankfem.record import Record
from crankfem.vibration.forced import ForcedVibration
from crankfem.vibration.motion import MOTION
from dynamics.checks import FloatArray
from dynamics.excitation.axial_comparison import AxialForceComparison
from dynamics.response.series import OrderSeries
from geometry.units import RPM

# What a table shows; files hold everything.
ROWS_SHOWN = 12
# Units in which loads are printed.
LOAD = {"torsional": "kN m", "axial": "kN"}
# SI units of loads in records.
LOAD_UNIT = {"torsional": "N m", "axial": "N"}

# Shares below this are round-off: the cylinders cancel.
ROUND_OFF = 1e-12


def forced_record(forced: ForcedVibration) -> Record:
    """Return curves and peaks of a forced vibration in SI units; null where it is unbounded."""
    free_end = forced.free_end
    return {
        "kind": forced.kind,
        "damping": list(forced.damping),
        "remarks": [*_gas_remarks(forced), *forced.remarks],
        "method": forced.response.method,
        "orders": forced.response.orders.tolist(),
        "speeds_rpm": (forced.response.speeds * RPM).tolist(),
        "free_end": {
            "node": free_end.names[0],
            "unit": MOTION[forced.kind].si,
            "synthesis": _finite(free_end.synthesis.amplitude[:, 0]),
            "plain_sum": _finite(free_end.synthesis.plain_sum[:, 0]),
            "orders": _order_peaks(free_end),
        },
        "loads": _peaks(forced.loads.elements, LOAD_UNIT[forced.kind]),
        "stress": None if forced.stress is None else _peaks(forced.stress, "Pa"),
        "power": _power(forced),
        "running_rpm": [speed * RPM for speed in forced.running_range],
        "judged_rpm": [speed * RPM for speed in forced.judged_range],
        "resonances": [
            {
                "mode": one.mode,
                "frequency": one.frequency,
                "order": one.order,
                "speed_rpm": one.speed_rpm,
                "amplitude": finite_or_none(one.amplitude if one.severity > ROUND_OFF else 0.0),
                "estimate": finite_or_none(one.estimate if one.severity > ROUND_OFF else 0.0),
                "magnifier": finite_or_none(one.magnifier),
                "share": one.share,
                "severity": one.severity,
                "kind": one.kind,
                "unbounded": one.unbounded,
                "in_running_range": one.in_running_range,
            }
            for one in forced.resonances
        ],
        "axial_forces": None
        if forced.axial_forces is None
        else _axial_forces(forced.axial_forces, forced),
    }


def print_forced(record: dict[str, Any], units: OutputUnits = SI) -> None:
    """Print resonances and peaks of a forced vibration."""
    kind = record["kind"]
    motion, load = units.of(MOTION[kind].printed), units.of(LOAD[kind])
    speed, stress = units.of("1/min"), units.of("MPa")
    free_end = record["free_end"]
    for line in (*record["damping"], *record["remarks"]):
        print_line(units.text(f"{kind.capitalize()}: {line}"))
    worst = sorted(record["resonances"], key=lambda one: -one["severity"])[:ROWS_SHOWN]
    count = len(record["resonances"])
    print_table(
        f"{kind.capitalize()} resonances {_judged(record, units)}"
        + (f", the {ROWS_SHOWN} most severe of {count}" if count > ROWS_SHOWN else ""),
        [
            f"speed [{speed.name}]",
            "order",
            "mode",
            f"{free_end['node']} [{motion.name}]",
            "by magnifier",
            "kind:",
        ],
        [
            [
                speed.fixed(one["speed_rpm"] / RPM, 1),
                f"{one['order']:g}",
                str(one["mode"]),
                motion.number(one["amplitude"]),
                motion.number(one["estimate"]),
                one["kind"] + ("" if one["in_running_range"] else ", above"),
            ]
            for one in sorted(worst, key=lambda one: float(one["speed_rpm"]))
        ],
    )
    stresses = {one["element"]: one for one in record["stress"] or ()}
    stressed = [f"stress [{stress.name}]"] if stresses else []
    print_table(
        f"{kind.capitalize()} vibration of the elements, largest over the speeds "
        "(all orders over the cycle; plain sum of amplitudes)",
        [
            "element",
            f"load [{load.name}]",
            f"at [{speed.name}]",
            f"plain sum [{load.name}]",
            *stressed,
        ],
        [
            [
                one["element"],
                load.number(one["peak"]),
                speed.fixed(one["speed_rpm"] / RPM, 0),
                load.number(one["plain_sum_peak"]),
                *(
                    [stress.number(stresses[one["element"]]["peak"])]
                    if one["element"] in stresses
                    else [""] * len(stressed)
                ),
            ]
            for one in record["loads"]
        ],
    )


def _judged(record: dict[str, Any], units: OutputUnits) -> str:
    """Say over which speeds resonances are listed."""
    running, judged = record["running_rpm"], record["judged_rpm"]
    if judged[1] <= running[1]:
        return "in the running range"
    return units.text(
        f"at the speeds judged: the running range to {running[1]:.4g} 1/min, and above it to "
        f"{judged[1]:.4g} 1/min, as far as a limit holds"
    )


def write_forced(path: Path, forced: ForcedVibration) -> None:
    """Write the amplitudes over the speed as CSV: free end by order, loads of all elements."""
    free_end, loads = forced.free_end, forced.loads.elements
    unit = MOTION[forced.kind].si
    load = "Nm" if forced.kind == "torsional" else "N"
    columns = {
        "speed_rpm": forced.response.speeds * RPM,
        f"free_end_synthesis_{unit}": free_end.synthesis.amplitude[:, 0],
        f"free_end_plain_sum_{unit}": free_end.synthesis.plain_sum[:, 0],
    }
    for place, order in enumerate(free_end.orders.tolist()):
        columns[f"free_end_order_{order:g}_{unit}"] = free_end.amplitude[place, :, 0]
    for place, name in enumerate(loads.names):
        columns[f"{name} [{load}]"] = loads.synthesis.amplitude[:, place]
    write_columns(path, columns, f"{forced.kind} vibration, amplitudes; inf is unbounded")


def _peaks(series: OrderSeries, unit: str) -> list[Record]:
    """Largest value over the speeds of each place, all orders together."""
    summed = series.synthesis
    found = []
    for place, name in enumerate(series.names):
        worst = int(np.argmax(summed.amplitude[:, place]))
        found.append(
            {
                "element": name,
                "unit": unit,
                "peak": finite_or_none(float(summed.amplitude[worst, place])),
                "speed_rpm": float(series.speeds[worst] * RPM),
                "plain_sum_peak": finite_or_none(float(np.max(summed.plain_sum[:, place]))),
            }
        )
    return found


def _order_peaks(series: OrderSeries) -> list[Record]:
    """Largest amplitude of each order at the first place, and its speed."""
    amplitude = series.amplitude[:, :, 0]
    places = np.argmax(amplitude, axis=1)
    return [
        {
            "order": order,
            "amplitude": finite_or_none(float(amplitude[row, place])),
            "speed_rpm": float(series.speeds[place] * RPM),
        }
        for row, (order, place) in enumerate(
            zip(series.orders.tolist(), places.tolist(), strict=True)
        )
    ]


def _power(forced: ForcedVibration) -> Record:
    """Where most heat arises, and how well the balance of power holds."""
    power = forced.power
    bounded = ~np.any(power.unbounded, axis=0)
    total = power.dissipated.sum(axis=0, where=~power.unbounded)
    worst = int(np.argmax(np.where(bounded, total, -1.0)))
    dampers = {
        name: float(power.dashpots[:, worst, place].sum())
        for place, name in enumerate(power.dashpot_names)
        if bounded[worst]
    }
    return {
        "unit": "W",
        # At no speed is there anything to compare, where vibration is unbounded at all of them.
        "error": power.error if np.any(bounded) else None,
        "largest": float(total[worst]),
        "speed_rpm": float(forced.response.speeds[worst] * RPM),
        "dampers": dampers,
    }


def _axial_forces(compared: AxialForceComparison, forced: ForcedVibration) -> list[Record]:
    """Largest axial force of any throw at the highest speed, two ways, by order."""
    alone, in_shaft = (
        np.abs(forces[:, -1]).max(axis=1) for forces in (compared.alone, compared.in_shaft)
    )
    none = alone <= ROUND_OFF * alone.max()
    alone[none] = in_shaft[none] = 0.0
    return [
        {
            "order": order,
            "unit": "N",
            "alone": own,
            "in_shaft": shaft,
            "difference": difference,
        }
        for order, own, shaft, difference in zip(
            forced.response.orders.tolist(),
            alone.tolist(),
            in_shaft.tolist(),
            np.where(none, 0.0, compared.difference[:, -1]).tolist(),
            strict=True,
        )
    ]


def _gas_remarks(forced: ForcedVibration) -> list[str]:
    """What the forces tell beside the gas model's own assumptions, which the mechanism reports."""
    return [text for text in forced.forces.remarks if not text.startswith((ASSUMED, "Solved"))]


def _finite(values: FloatArray) -> list[float | None]:
    return [finite_or_none(value) for value in values.tolist()]


def finite_or_none(value: float) -> float | None:
    """Return a number that JSON can hold; None stands for an unbounded one."""
    return value if np.isfinite(value) else None
